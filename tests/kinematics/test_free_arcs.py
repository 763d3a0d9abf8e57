"""Arcs of the redundancy that are proved between samples, against dense sampling with the distance layer."""

import numpy as np
import pytest
import structured_arms as arms

from horosphere.distance import signed
from horosphere.errors import InputError
from horosphere.kinematics import GripperOnPlane, elbow_arcs, forward, free_arcs, inverse, limit_arcs, roomiest
from horosphere.kinematics._redundant import redundancy
from horosphere.robots import Capsules, humanoid_arm, load
from horosphere.shapes import Ball

DENSE = np.linspace(-np.pi, np.pi, 1201)[1:-1]


def with_bodies(name, arm):
    """The arm with one capsule a link, from each joint to the next where that is within 0.6 m."""
    from dataclasses import replace

    robot = arms.robot(name, arm, 2.6)
    points = np.array(arm[1], float)
    link, b = zip(
        *[(k + 1, points[k + 1] - points[k]) for k in range(6) if np.linalg.norm(points[k + 1] - points[k]) > 0.02]
    )
    zeros = np.zeros((len(link), 3))
    return replace(robot, capsules=Capsules(np.array(link), zeros, np.array(b), np.full(len(link), 0.04)))


CASES = {
    "panda": lambda: (load("panda"), "q7"),
    "humanoid": lambda: (humanoid_arm(), "phi"),
    "elbow offset": lambda: (with_bodies("offset", arms.OFFSET_SRS), "psi"),
    "xarm7": lambda: (with_bodies("xarm7", arms.XARM7), "q7"),
    "reversed": lambda: (with_bodies("reversed", arms.XARM7_REVERSED), "q1"),
}


def target_of(robot, q, rng):
    pose = forward(robot, q)
    if robot.n_joints != 5:
        return pose
    T = pose.as_matrix()
    return GripperOnPlane(T[:3, 3], np.cross(T[:3, 1], rng.normal(size=3)))


@pytest.mark.parametrize("count", [1, pytest.param(12, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", CASES)
def test_nothing_touches_in_a_free_arc_and_little_is_left_out(name, count):
    robot, parameter = CASES[name]()
    rng = np.random.default_rng(list(CASES).index(name))
    free = found = 0
    for _ in range(count):
        q = rng.uniform(robot.limits.lower, robot.limits.upper)
        target = target_of(robot, q, rng)
        balls = [Ball(rng.uniform([-0.5, -0.5, 0], [0.5, 0.5, 0.8]), rng.uniform(0.04, 0.1)) for _ in range(2)]
        arcs = free_arcs(robot, target, balls, 0.01)
        rows = inverse(robot, target, **{parameter: DENSE})
        inside = rows.within_limits(robot)
        for k, arc in enumerate(arcs):
            good = inside[:, k].copy()
            good[good] = signed(robot, rows.q[good, k], balls, static=False) > 0.01
            said = arc.contains(DENSE)
            assert not (said & ~good).any(), f"{name}: branch {k} is said to be free where it is not"
            free, found = free + good.sum(), found + (good & said).sum()
    assert found >= 0.97 * free - 3, f"{found} of {free} free samples proved"


def test_without_obstacles_the_psi_of_an_s_r_s_arm_agree_with_the_closed_form():
    robot = arms.robot("iiwa", arms.IIWA, np.radians([170, 110, 170, 110, 170, 110, 175]))
    target = forward(robot, np.random.default_rng(4).uniform(robot.limits.lower, robot.limits.upper))
    for exact, proved in zip(limit_arcs(robot, target), free_arcs(robot, target)):
        assert abs(exact.width - proved.width) < 0.01
        assert exact.contains(proved.free.mean(axis=1)).all()


def test_every_q7_at_which_a_branch_exists_is_found():
    robot = load("panda")
    rng = np.random.default_rng(6)
    for _ in range(20):
        target = forward(robot, rng.uniform(robot.limits.lower, robot.limits.upper))
        one = redundancy(robot, target)
        cell = np.searchsorted(one.ends, DENSE)
        _, exists = one.rows(DENSE)
        _, middle = one.rows(0.5 * (one.ends[1:] + one.ends[:-1]))
        assert (exists == middle[cell - 1]).all()


def test_the_roomiest_value_beats_dense_sampling():
    robot, rng = load("panda"), np.random.default_rng(9)
    q = rng.uniform(robot.limits.lower, robot.limits.upper)
    target, balls = forward(robot, q), [Ball([0.3, 0.2, 0.5], 0.1)]
    best = roomiest(robot, target, balls, 0.02)
    assert best.q.shape == (8, 7) and best.residual[best.valid].max() < 1e-10
    rows = inverse(robot, target, q7=DENSE)
    for k in np.flatnonzero(best.valid):
        both = np.concatenate([best.q[k : k + 1], rows.q[rows.valid[:, k], k]])
        gaps = signed(robot, both, balls, static=False) - 0.02
        margin = np.minimum(both - robot.limits.lower, robot.limits.upper - both).min(axis=-1)
        room = np.minimum(margin, gaps / 0.1)
        assert room[0] > room[1:].max() - 0.02
        assert best.flags["free"][k] == (room[0] > 0.0)


def test_arcs_say_what_they_are_not_for():
    pose = forward(load("ur5"), np.zeros(6))
    with pytest.raises(InputError, match="no redundancy"):
        elbow_arcs(load("ur5"), pose, [])
    with pytest.raises(InputError, match="GripperOnPlane"):
        free_arcs(humanoid_arm(), pose)
    with pytest.raises(InputError, match="one pose"):
        free_arcs(load("panda"), forward(load("panda"), np.zeros((2, 7))))
