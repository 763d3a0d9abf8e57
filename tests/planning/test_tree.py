"""`connect`: certified paths for many robots, judged by dense sampling in plain numpy; failures that say why."""

import os
import subprocess
import sys

import numpy as np
import pytest
import trimesh

from horosphere import distance, robots
from horosphere.errors import InputError
from horosphere.planning._reactive import react
from horosphere.planning._tree import connect
from horosphere.robots import Capsules, Limits, Link, Robot
from horosphere.shapes import Ball, Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Mesh, PointCloud

from ._dense import along, clearances

IDENTITY = np.array([1.0, 0, 0, 0, 0, 0, 0, 0])


def moved(x, y, z):
    """Motor of a translation."""
    return np.array([1.0, 0, 0, 0, -x / 2, -y / 2, -z / 2, 0])


def gantry_with_two_arms():
    """A slide that carries two two-joint arms (a tree), one joint of the second mimicking the first."""
    z, y, x = np.eye(3)[2], np.eye(3)[1], np.eye(3)[0]
    links = (
        Link("base", -1, IDENTITY),
        Link("cart", 0, moved(0, 0, 0.2), "prismatic", x, 0),
        Link("left1", 1, moved(0, 0.25, 0.1), "revolute", z, 1),
        Link("left2", 2, moved(0.3, 0, 0), "revolute", y, 2),
        Link("right1", 1, moved(0, -0.25, 0.1), "revolute", z, 1, multiplier=-0.5, offset=0.2),
        Link("right2", 4, moved(0.3, 0, 0), "revolute", y, 3),
    )
    inf = np.full(4, np.inf)
    limits = Limits(np.array([-0.8, -np.inf, -2, -2]), np.array([0.8, np.inf, 2, 2]), inf, inf, inf)
    bodies = Capsules(
        np.array([1, 2, 3, 4, 5]),
        np.zeros((5, 3)),
        np.array([[0, 0, 0.1], [0.3, 0, 0], [0.3, 0, 0], [0.3, 0, 0], [0.3, 0, 0]]),
        np.array([0.06, 0.04, 0.03, 0.04, 0.03]),
    )
    pairs = np.array([[2, 4], [2, 5], [3, 4], [3, 5]])
    return Robot("gantry", links, 3, ("slide", "left", "lift", "right"), limits, capsules=bodies, self_pairs=pairs)


def made(name):
    if name == "gantry":
        return gantry_with_two_arms()
    robot = robots.load(name)
    return robot if len(robot.capsules) else robots.load(name, link_radius=0.04)


_KINDS = (
    lambda rng, c, d, turn: Ball(c, 0.08),
    lambda rng, c, d, turn: Box(c, rng.uniform(0.03, 0.12, 3), turn),
    lambda rng, c, d, turn: Box(c, [0.1, 0.04, 0.1]),
    lambda rng, c, d, turn: Capsule(c - d, c + d, 0.05),
    lambda rng, c, d, turn: Cylinder(c - d, c + d, 0.06),
    lambda rng, c, d, turn: Ellipsoid(c, rng.uniform(0.03, 0.15, 3), turn),
    lambda rng, c, d, turn: PointCloud(c + 0.05 * rng.normal(size=(6, 3)), 0.01),
)


def furniture(rng, count):
    """Random solids of every kind, off the axis of the base."""
    solids = []
    for k in range(count):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn[:, 0] *= np.sign(np.linalg.det(turn))
        centre = rng.uniform([-0.8, -0.8, 0.1], [0.8, 0.8, 1.0])
        centre[:2] *= max(1.0, 0.5 / np.linalg.norm(centre[:2]))
        d = 0.1 * rng.normal(size=3)
        solids.append(_KINDS[k % 7](rng, centre, d, turn))
    return solids


def free(robot, rng, obstacles, clearance, low, high):
    for _ in range(40):
        q = rng.uniform(low, high, (24, robot.n_joints))
        outer, inner = clearances(robot, q, obstacles)
        good = q[(outer > clearance + 0.01) & (inner > 5e-4)]
        if len(good):
            return good[0]
    raise AssertionError("no free configuration")


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("name", ["panda", "ur5", "iiwa14", "nao-left-arm", "srs-arm", "gantry"])
def test_paths_keep_the_clearance(name, seed):
    robot, rng = made(name), np.random.default_rng(seed)
    low = np.clip(robot.limits.lower, -np.pi, np.pi)
    high = np.clip(robot.limits.upper, -np.pi, np.pi)
    obstacles = [*furniture(rng, 7)[seed::2], HalfSpace([0, 0, 1], -0.7)]
    clearance = 0.01 * seed
    solved = 0
    for _ in range(3):
        start, goal = (free(robot, rng, obstacles, clearance, low, high) for _ in range(2))
        result = connect(robot, start, goal, obstacles, clearance=clearance, time_limit=1.0)
        if not result.solved:
            continue
        solved += 1
        np.testing.assert_array_equal(result.waypoints[[0, -1]], [start, goal])
        assert (result.waypoints >= robot.limits.lower - 1e-6).all() and (
            result.waypoints <= robot.limits.upper + 1e-6
        ).all()
        outer, inner = clearances(robot, along(result.waypoints, 40), obstacles)
        assert outer.min() >= result.margin >= clearance and inner.min() >= result.margin - clearance, (
            outer.min(),
            inner.min(),
        )
    assert solved >= 1  # random ends may lie in pockets that nothing leads out of


def test_a_thin_wall_is_not_jumped():
    """A sheet thinner than the distance between samples: only the certificate can see it."""
    robot = robots.load("planar-3r")
    inf = np.full(1, np.inf)
    arm = Robot(
        "rod", (Link("base", -1, IDENTITY), Link("rod", 0, IDENTITY, "revolute", np.eye(3)[2], 0)), 1, ("turn",),
        Limits(np.array([-2.0]), np.array([2.0]), inf, inf, inf),
        capsules=Capsules(np.array([1]), np.array([[0.98, 0, 0]]), np.array([[0.98, 0, 0]]), np.array([1e-4])),
    )  # fmt: skip
    assert robot.n_joints == 3
    for width, hit in ((1e-4, True), (0.0, True)):
        sheet = Box([0.98, 0.0123, 0], [0.1, width, 0.1])
        result = connect(arm, [-0.5], [0.5], [sheet], time_limit=0.3)
        assert result.solved is not hit, result
        assert "no path" in result.reason or "excluded" in result.reason
    assert connect(arm, [-0.5], [0.5], [Box([0.98, 0.0123, 0.2], [0.1, 1e-4, 0.1])]).solved


def test_nearest_of_several_goals_and_seeds():
    robot, rng = made("panda"), np.random.default_rng(0)
    obstacles = furniture(rng, 5)
    low, high = robot.limits.lower, robot.limits.upper
    start, *goals = (free(robot, rng, obstacles, 0.0, low, high) for _ in range(5))
    result = connect(robot, start, goals, obstacles)
    assert result.solved
    np.testing.assert_array_equal(result.waypoints[-1], goals[result.goal_index])
    blocked = np.array([goals[0], goals[1]])
    blocked[0, 1] = robot.limits.upper[1] + 0.1
    second = connect(robot, start, blocked, obstacles)
    assert second.solved and second.goal_index == 1
    again = connect(robot, start, goals, obstacles)
    np.testing.assert_array_equal(result.waypoints, again.waypoints)  # same seed, same path
    assert connect(robot, start, start, obstacles).solved


def test_without_simplification_the_path_is_longer():
    robot = made("panda")
    wall = [Box([0.45, 0.0, 0.4], [0.3, 0.02, 0.4])]
    start = np.array([0.8, 0.3, 0.0, -1.8, 0.0, 2.0, 0.0])
    goal = np.array([-0.8, 0.3, 0.0, -1.8, 0.0, 2.0, 0.0])
    short, raw = (connect(robot, start, goal, wall, simplify=s) for s in (True, False))
    assert short.solved and raw.solved
    length = [np.linalg.norm(np.diff(r.waypoints, axis=0), axis=1).sum() for r in (short, raw)]
    assert length[0] < length[1]


def test_reasons():
    robot = made("panda")
    q = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    away = q + 0.3
    inside = connect(robot, q, away, [Ball([0.3, 0.0, 0.6], 0.2, name="ball")])
    assert not inside.solved and inside.reason.startswith("start: 'panda_") and "mm inside 'ball'" in inside.reason
    hand = Box([0.3, 0.0, 0.38], [0.02, 0.02, 0.02], name="low box")
    near = connect(robot, q + [1.5, 0, 0, 0, 0, 0, 0], q, [hand], clearance=0.12)
    assert not near.solved and near.reason.startswith("goal: ") and "low box" in near.reason
    assert "less than 120 mm" in near.reason
    beyond = connect(robot, q, q + 10.0)
    assert not beyond.solved and "beyond its limits" in beyond.reason and "panda_joint" in beyond.reason
    folded = np.array([0.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0])
    assert "of the robot itself" in connect(robot, folded, q).reason
    # a base stands on something: what no joint moves does not count
    assert connect(robot, q, away, [Box([0, 0, 0], [0.3, 0.3, 0.05], name="table")]).solved


def test_enclosed_goal_stops_at_the_time_limit():
    robot = made("panda")
    q = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    walls = [Box([0, y, 0.5], [2.0, 0.01, 2.0]) for y in (-0.5, 0.5)]
    result = connect(robot, q, q * [0] + [1.2, 0.9, 0, -0.3, 0, 1.2, 0], walls, time_limit=0.2)
    assert not result.solved and result.reason


def test_bad_input():
    robot = made("panda")
    q = np.zeros(7)
    with pytest.raises(InputError, match="start"):
        connect(robot, q[:5], q)
    with pytest.raises(InputError, match="goals"):
        connect(robot, q, np.zeros((2, 6)))
    with pytest.raises(InputError, match="finite"):
        connect(robot, q, q * np.nan)
    with pytest.raises(InputError, match=r"disc.*Ball of dimension 2"):
        connect(robot, q, q, [Ball([0.0, 0.0], 0.1, name="disc")])
    for plan in connect, react:
        for goals in np.zeros((0, 7)), [], "home", np.zeros((2, 2, 7)):
            with pytest.raises(InputError, match="goals"):
                plan(robot, q, goals)
        for name in "clearance", "self_clearance", "time_limit":
            with pytest.raises(InputError, match=f"{name}: expected .* got nan"):
                plan(robot, q, q, **{name: np.nan})
    with pytest.raises(InputError, match="seed"):
        connect(robot, q, q, seed=-1)


@pytest.mark.parametrize("time_limit", [np.inf, 1e12])
def test_more_time_than_a_clock_can_count(time_limit):
    robot = made("panda")
    q = np.array([0, -0.5, 0, -2.0, 0, 1.8, 0.5])
    assert connect(robot, q, q + 0.1, [Ball([0.4, 0.4, 0.4], 0.1)], time_limit=time_limit).solved


def test_around_a_mesh():
    """The tree sees boxes round the ring; the path keeps clear of its triangles."""
    robot = made("panda")
    ring = trimesh.creation.torus(0.15, 0.03, major_sections=24, minor_sections=12)
    obstacle = Mesh(np.asarray(ring.vertices) + [0.45, 0.0, 0.5], np.asarray(ring.faces), name="ring")
    start = np.array([-0.9, 0.3, 0.0, -2.0, 0.0, 2.2, 0.8])
    goal = start * [-1, 1, 1, 1, 1, 1, 1]
    straight = distance.signed(robot, np.linspace(start, goal, 200), [obstacle]).min()
    found = connect(robot, start, goal, [obstacle], clearance=0.01, seed=3)
    dense = np.concatenate([np.linspace(a, b, 50) for a, b in zip(found.waypoints[:-1], found.waypoints[1:])])
    assert straight < 0.0 and found.solved
    assert distance.signed(robot, dense, [obstacle], static=False).min() > 0.01


def test_robot_without_bodies_moves_straight():
    inf = np.full(1, np.inf)
    arm = Robot("bare", (Link("base", -1, IDENTITY), Link("a", 0, IDENTITY, "revolute", np.eye(3)[2], 0)), 1, ("j",),
                Limits(-inf, inf, inf, inf, inf))  # fmt: skip
    result = connect(arm, [0.0], [3.0], [Ball([0, 0, 0], 1.0)])
    assert result.solved and len(result.waypoints) == 2


def run(code, **environment):
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env={**os.environ, **environment}
    ).stdout


def test_the_import_compiles_nothing():
    assert run("import horosphere.planning._tree, sys; print('numba' in sys.modules)").strip() == "False"


def test_same_path_without_a_compiler():
    code = """
import numpy as np
from horosphere import robots
from horosphere.planning._tree import connect
from horosphere.shapes import Box
robot = robots.load("srs-arm")
if not len(robot.capsules): robot = robots.load("srs-arm", link_radius=0.04)
q = np.array([0.2, 0.6, 0.0, 0.9, 0.0, 0.4, 0.0])
result = connect(robot, q, q + [1.2, 0, 0, 0, 0, 0, 0], [Box([0.25, 0.35, 0.25], [0.03, 0.03, 0.25])], time_limit=60.0)
print(result.solved, len(result.waypoints), np.round(result.waypoints.sum(), 3))
"""
    plain, compiled = run(code, NUMBA_DISABLE_JIT="1"), run(code)
    assert plain.startswith("True") and compiled.startswith("True")


def test_the_certificate_of_other_code_agrees():
    """`horosphere.certify`: double precision, exact capsules, other bounds."""
    from horosphere.certify import certify
    from horosphere.scenes import JointTarget, Options, Scene, Trajectory

    robot, rng = made("panda"), np.random.default_rng(7)
    obstacles = [*furniture(rng, 5)[:5], HalfSpace([0, 0, 1], -0.7)]
    checked = 0
    for _ in range(4):
        start, goal = (free(robot, rng, obstacles, 0.01, robot.limits.lower, robot.limits.upper) for _ in range(2))
        result = connect(robot, start, goal, obstacles, clearance=0.01, time_limit=1.0)
        if result.solved:
            options = Options(clearance=result.margin, self_clearance=result.margin - 0.01)
            scene = Scene(robot, JointTarget(start), JointTarget(goal), tuple(obstacles), options=options)
            slow = np.arange(len(result.waypoints)) * 100.0
            certificate = certify(scene, Trajectory(slow, result.waypoints, names=robot.joint_names))
            assert certificate.certified, certificate
            checked += 1
    assert checked >= 2
