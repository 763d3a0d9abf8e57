"""The last angles at which a sew7 arm keeps its limits, in closed form: against dense scans, and search between samples."""

import numpy as np
import pytest
import structured_arms as arms

from horosphere.kinematics import classify, forward, inverse, limit_arcs
from horosphere.kinematics._existence import _chain_pose
from horosphere.kinematics._q7_limits import DEGREE, _Arm, q7_limit_candidates, shoulder_equations
from horosphere.kinematics._structured import solver
from horosphere.kinematics._targets import pose_motor
from horosphere.robots import load

SKEW = [(0.1, 0, 1), (0.1, 1, 0), (0.2, 0, 1), (0, -1, 0.2), (0.1, 0.1, 1), (0.2, -1, 0.1), (0, 0.3, -1)], [
    *[(0, 0, 0.3)] * 3, (0.08, 0.01, 0.65), (0.02, 0, 1.0), (0.02, 0, 1.0), (0.1, 0.02, 1.03),
]  # fmt: skip
CASES = {
    "panda": lambda: load("panda"),
    "xarm7": lambda: arms.robot("xarm7", arms.XARM7, 2.3),
    "xarm7 from its tip": lambda: arms.robot("reversed", arms.XARM7_REVERSED, 2.3),
    "skew": lambda: arms.robot("skew", SKEW, 2.3),
}


def margins(robot, target, values):
    """(m, 8) the least distance of a joint to its limits, -9 where a branch does not exist."""
    s = inverse(robot, target, **{classify(robot).parameter: values})
    room = np.minimum(s.q - robot.limits.lower, robot.limits.upper - s.q).min(axis=-1)
    return np.where(s.valid, room, -9.0)


def peaks(robot, target, grid, room):
    """Values of a branch between samples outside the limits at which it comes inside: golden section around local maxima."""
    inner = room[1:-1]
    top = (inner >= room[:-2]) & (inner >= room[2:]) & (inner < 0.0) & (inner > -0.1)
    k, branch = np.nonzero(top)
    low, high, pick = grid[k], grid[k + 2], np.arange(len(k))
    for _ in range(40 if len(k) else 0):
        third = (high - low) / 3.0
        a, b = low + third, high - third
        left = margins(robot, target, a)[pick, branch] > margins(robot, target, b)[pick, branch]
        low, high = np.where(left, low, a), np.where(left, b, high)
    at = 0.5 * (low + high)
    if not len(k):
        return
    value = margins(robot, target, at)[pick, branch]
    for j in np.flatnonzero(value > 0.0):
        yield at[j], branch[j]


@pytest.mark.parametrize("count", [12, pytest.param(2000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", CASES)
def test_no_interval_is_lost_and_the_ends_are_exact(name, count):
    robot, rng = CASES[name](), np.random.default_rng(20)
    grid = np.linspace(-np.pi, np.pi, 2401)[1:-1]
    found = 0
    for _ in range(count):
        target = forward(robot, rng.uniform(robot.limits.lower, robot.limits.upper))
        arcs, room = limit_arcs(robot, target), margins(robot, target, grid)
        for k, arc in enumerate(arcs):
            off = (np.abs(grid[:, None] - arc.free.ravel()) > 1e-9).all(axis=-1)
            assert (arc.contains(grid) == (room[:, k] >= 0.0))[off].all(), "an interval is lost, or one too many"
            ends = arc.free[arc.free[:, 1] - arc.free[:, 0] > 1e-8].ravel()
            ends = ends[np.abs(ends) < np.pi]
            if len(ends):
                inward = np.where(np.isin(ends, arc.free[:, 0]), 1e-9, -1e-9)
                assert (margins(robot, target, ends + inward)[:, k] >= -1e-12).all()
                assert (margins(robot, target, ends - inward)[:, k] < 1e-12).all()
            found += len(arc.free)
        for at, branch in peaks(robot, target, grid, room):
            width = 1e-6
            if (margins(robot, target, at + np.array([-width, width]) / 2)[:, branch] > 0.0).all():
                assert arcs[branch].contains(at), f"an interval about {at} is lost"
                found += 1
    assert found > 5 * count


@pytest.mark.parametrize("name", CASES)
def test_a_fine_scan(name):
    robot, rng = CASES[name](), np.random.default_rng(21)
    grid = np.linspace(-np.pi, np.pi, 100_001)[1:-1]
    for _ in range(2):
        target = forward(robot, rng.uniform(robot.limits.lower, robot.limits.upper))
        room = margins(robot, target, grid)
        for k, arc in enumerate(limit_arcs(robot, target)):
            off = (np.abs(grid[:, None] - arc.free.ravel()) > 1e-9).all(axis=-1)
            assert (arc.contains(grid) == (room[:, k] >= 0.0))[off].all()


@pytest.mark.parametrize("name", CASES)
def test_the_equation_of_the_first_three_joints_is_of_degree_eight(name):
    robot, rng = CASES[name](), np.random.default_rng(22)
    made = solver(robot)
    chain, limits = made.structure.screws, np.stack([np.full(7, -1.7), np.full(7, 1.1)])
    reached = []
    for _ in range(20):
        motor = pose_motor(forward(robot, rng.uniform(-2.3, 2.3, 7)))
        one = _Arm(chain.axes, chain.points, made.structure.special, _chain_pose(made, motor))
        _, values = one.products(shoulder_equations(chain.axes, limits))
        size = np.abs(np.fft.rfft(values, axis=-1))
        assert (size[:, DEGREE + 1 :].max(axis=-1) < 1e-10 * size.max(axis=-1)).all()
        reached.append((size[:, DEGREE] > 100.0 * size[:, DEGREE + 1 :].max(axis=-1)).all())
    assert np.mean(reached) > 0.5


def test_a_joint_at_its_limit_is_among_the_ends():
    """Every joint in turn stands at a limit: that angle ends an interval, or touches one."""
    robot, rng = CASES["panda"](), np.random.default_rng(23)
    for joint in range(7):
        for end in (robot.limits.lower, robot.limits.upper):
            q = rng.uniform(robot.limits.lower, robot.limits.upper, (10, 7))
            q[:, joint] = end[joint]
            for row in q:
                ends = q7_limit_candidates(solver(robot), pose_motor(forward(robot, row)))
                assert np.abs(ends - row[6]).min() < 1e-7, (joint, row)
