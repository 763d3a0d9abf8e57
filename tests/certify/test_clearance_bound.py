"""Bounds of the clearance of whole paths: never above dense sampling, close to it, and honest when it grazes."""

import numpy as np
import pytest
from random_robots import random_robot, random_solid

from horosphere import certify, distance
from horosphere.errors import InputError
from horosphere.robots import Capsules, Limits, Link, Robot, humanoid_arm
from horosphere.shapes import Ball, Box, Capsule, HalfSpace

KINDS = ("ball", "capsule", "cylinder", "box", "half-space", "ellipsoid", "cloud")
IDENTITY = [1.0, 0, 0, 0, 0, 0, 0, 0]


def dense(robot, waypoints, obstacles, own=False, samples=400):
    s = np.linspace(0.0, 1.0, samples)[:, None, None]
    q = waypoints[:-1] + s * (waypoints[1:] - waypoints[:-1])
    return distance.signed(robot, q, obstacles, self_collision=own).T  # (segments, samples)


@pytest.mark.parametrize("own", [False, True], ids=["obstacles", "with-self"])
@pytest.mark.parametrize("seed", range(25))
def test_bounds_enclose_the_sampled_clearance_of_random_robots(seed, own):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng)
    obstacles = [random_solid(rng, kind, 1.5) for kind in KINDS]
    waypoints = np.cumsum(0.4 * rng.normal(size=(4, robot.n_joints)), axis=0)
    d = dense(robot, waypoints, obstacles, own)
    bound = certify.clearance_bound(robot, waypoints, obstacles, margin=0.01, self_collision=own)
    assert bound.lower <= d.min()
    assert bound.upper - bound.lower <= max(5e-4, 0.05 * abs(bound.upper)) + 1e-12
    if bound.holds:
        assert (d >= 0.01).all() and bound.violation is None
    if (d < 0.01 - 1e-9).any():
        first = np.flatnonzero(d.ravel() < 0.01)[0] / 400
        assert bound.violation is not None
        at = bound.violation.segment + bound.violation.fraction
        assert at <= first + 1.0 / 400 + 1e-9  # not after the first sample that violates
        q = waypoints[bound.violation.segment]
        q = q + bound.violation.fraction * (waypoints[bound.violation.segment + 1] - q)
        assert (
            float(distance.signed(robot, q, obstacles, self_collision=own)) == pytest.approx(0.01, abs=1e-6)
            or at == 0.0
        )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(25, 400))
def test_bounds_enclose_many_more(seed):
    test_bounds_enclose_the_sampled_clearance_of_random_robots(seed, bool(seed % 2))


def turning_arm(length=1.0, radius=0.0):
    """One joint about z with a rod along x."""
    links = (Link("base", -1, IDENTITY), Link("rod", 0, IDENTITY, "revolute", [0, 0, 1.0], 0))
    capsules = Capsules([1], np.zeros((1, 3)), np.array([[length, 0, 0]]), [radius])
    return Robot("rod", links, 1, ("turn",), Limits.unlimited(1), capsules=capsules)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-8, -1e-8, -1e-6, -1e-3])
def test_a_rod_that_sweeps_past_a_wall(gap):
    """The end of a rod passes a plane at exactly `gap`: the truth is known in closed form."""
    robot, wall = turning_arm(), HalfSpace([0, -1.0, 0], -(1.0 + gap))
    path = np.array([[0.3], [2.9]])  # the top of the swing, pi/2, lies between two waypoints
    bound = certify.clearance_bound(robot, path, [wall])
    assert bound.lower <= gap + 1e-15 and bound.upper >= gap - 1e-12
    assert bound.holds == (gap > 0.0)
    if gap < 0.0:
        assert bound.violation is not None or bound.unresolved
        if bound.violation is not None:
            angle = 0.3 + 2.6 * bound.violation.fraction
            assert np.sin(angle) >= 1.0 + gap - 1e-12
            assert angle <= np.pi - np.arcsin(1.0 + gap) + 1e-9
    else:
        assert bound.violation is None and not bound.unresolved


def test_an_exact_touch_is_never_certified():
    bound = certify.clearance_bound(turning_arm(), [[0.3], [2.9]], [HalfSpace([0, -1.0, 0], -1.0)])
    assert not bound.holds and (bound.unresolved or bound.violation)


def test_touching_all_along_is_never_certified_and_ends():
    """A ball slides along a wall at clearance zero: nothing can be proved, the budget ends it."""
    links = (Link("base", -1, IDENTITY), Link("slide", 0, IDENTITY, "prismatic", [1.0, 0, 0], 0))
    robot = Robot(
        "slider", links, 1, ("x",), Limits.unlimited(1), capsules=Capsules([1], [[0, 0, 0.1]], [[0, 0, 0.1]], [0.1])
    )
    bound = certify.clearance_bound(robot, [[0.0], [1.0]], [HalfSpace([0, 0, 1.0], 0.0)], max_evaluations=5000)
    assert not bound.holds and bound.unresolved and bound.lower < 0.0 <= bound.upper + 1e-15
    assert bound.evaluations <= 5001
    clear = certify.clearance_bound(robot, [[0.0], [1.0]], [HalfSpace([0, 0, 1.0], -1e-3)])
    assert clear.holds and clear.lower > 4e-4


@pytest.mark.parametrize("seed", range(6))
def test_thin_obstacles_between_samples_are_seen(seed):
    """A needle that a long step jumps over."""
    rng = np.random.default_rng(seed)
    robot = turning_arm(radius=0.001)
    at = rng.uniform(0.5, 2.5)
    tip = 0.8 * np.array([np.cos(at), np.sin(at), 0.0])
    needle = Capsule(tip - [0, 0, 1.0], tip + [0, 0, 1.0], 1e-5)
    bound = certify.clearance_bound(robot, [[0.0], [3.0]], [needle])
    assert bound.violation is not None
    assert 3.0 * bound.violation.fraction == pytest.approx(at, abs=2e-3)


def test_relative_motion_counts_for_self_pairs():
    """Two fingers on a spinning wrist keep their distance exactly, however fast the wrist turns."""
    links = (
        Link("base", -1, IDENTITY),
        Link("wrist", 0, IDENTITY, "revolute", [0, 0, 1.0], 0),
        Link("left", 1, IDENTITY),
        Link("right", 1, IDENTITY, "prismatic", [0, 1.0, 0], 1),
    )
    capsules = Capsules([2, 3], [[1, 0, 0], [1, 0.5, 0]], [[2, 0, 0], [2, 0.5, 0]], [0.1, 0.1])
    robot = Robot("gripper", links, 3, ("turn", "close"), Limits.unlimited(2), capsules=capsules, self_pairs=[[2, 3]])
    spin = certify.clearance_bound(robot, [[0.0, 0.0], [6.0, 0.0]], [], self_collision=True)
    assert spin.lower == pytest.approx(0.3, abs=1e-9) and spin.evaluations < 20
    close = certify.clearance_bound(robot, [[0.0, 0.0], [6.0, -0.25]], [], self_collision=True)
    assert 0.05 - 5e-3 < close.lower <= 0.05 <= close.upper + 1e-12
    assert close.nearest is not None and {close.nearest.link, close.nearest.other} == {"left", "right"}


def test_humanoid_bound_is_tight():
    robot = humanoid_arm()
    path = np.linspace([0.0] * 5, [0.6, 0.9, 0.8, 0.3, 0.4], 40)
    obstacles = [Ball([0.33, 0.03, -0.03], 0.075), Box([0.5, 0.0, 0.4], [0.1, 0.2, 0.05]), HalfSpace([0, 1.0, 0], -0.4)]
    truth = dense(robot, path, obstacles, samples=50).min()
    bound = certify.clearance_bound(robot, path, obstacles)
    assert truth - max(1e-3, 0.1 * truth) <= bound.lower <= truth <= bound.upper + 1e-4


def test_one_waypoint_and_a_standing_robot():
    robot, ball = turning_arm(radius=0.1), [Ball([1.0, 1.0, 0.0], 0.2)]
    for path in ([[0.0]], [[0.0], [0.0]]):
        bound = certify.clearance_bound(robot, path, ball)
        assert bound.lower == pytest.approx(0.7, abs=1e-9) and bound.upper == pytest.approx(0.7) and bound.holds


def test_the_budget_keeps_the_bound_valid():
    rng = np.random.default_rng(0)
    robot = humanoid_arm()
    path = np.cumsum(0.2 * rng.normal(size=(10, 5)), axis=0)
    obstacles = [Ball([0.4, 0.5, 0.3], 0.05)]
    truth = dense(robot, path, obstacles).min()
    for budget in (1, 12, 30, 100):
        assert certify.clearance_bound(robot, path, obstacles, max_evaluations=budget).lower <= truth


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"waypoints": np.zeros((3, 2))}, r"\(\.\.\., 1\)"),
        ({"waypoints": np.zeros((0, 1))}, "at least one waypoint"),
        ({"waypoints": [[np.nan]]}, "nan"),
        ({"margin": np.inf}, "finite margin"),
        ({"robot": "panda"}, "expected a Robot"),
    ],
)
def test_bad_input(change, says):
    arguments = {"robot": turning_arm(), "waypoints": [[0.0], [1.0]], "obstacles": []} | change
    with pytest.raises(InputError, match=says):
        certify.clearance_bound(**arguments)
