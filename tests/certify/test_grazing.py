"""The adversary: grazing motions, thin obstacles, fast wrists. No margin that the motion breaks by a nanometre is certified."""

import numpy as np
import pytest
from random_robots import random_robot, rotation, unit

from horosphere import certify, distance
from horosphere.shapes import Ball, Box, Capsule, Cylinder, Ellipsoid, HalfSpace


def thin_obstacle(rng):
    """Something that samples miss: a wire, a needle, a sheet, a speck."""
    c, thickness = rng.normal(size=3), 10.0 ** rng.uniform(-6, -2)
    kind = rng.integers(6)
    if kind == 0:
        return Capsule(c, c + rng.normal(size=3), thickness)
    if kind == 1:
        return Cylinder(c, c + rng.normal(size=3), thickness)
    if kind == 2:
        return Box(c, np.array([rng.uniform(0.1, 1), rng.uniform(0.1, 1), thickness]), rotation(rng))
    if kind == 3:
        return Ball(c, thickness)
    if kind == 4:
        return Ellipsoid(c, np.array([rng.uniform(0.1, 1), rng.uniform(0.1, 1), thickness]), rotation(rng))
    return HalfSpace(unit(rng), -1.0 - rng.uniform(0, 2))


def fast_motion(rng, n):
    """Three waypoints; some joints stand, some creep, the later ones may turn many times within one segment."""
    steps = rng.normal(size=(2, n)) * 10.0 ** rng.uniform(-9, 0, (2, n))
    wrist = rng.random((2, n)) < np.linspace(0.0, 0.6, n)
    steps = np.where(wrist, rng.uniform(-25, 25, (2, n)), steps) * (rng.random((2, n)) < 0.9)
    return np.cumsum(np.vstack([rng.uniform(-3, 3, n), steps]), axis=0)


def least_clearance(clearance, samples=2000, best=5):
    """An upper bound of the least value on [0, 1], close to it: samples, then golden sections about the lowest."""
    s = np.linspace(0.0, 1.0, samples + 1)
    d = clearance(s)
    low = np.maximum(s[np.argsort(d)[:best]] - 1.0 / samples, 0.0)
    high, golden = np.minimum(low + 2.0 / samples, 1.0), 0.5 * (np.sqrt(5.0) - 1.0)
    least = d.min()
    for _ in range(70):
        x = np.stack([high - golden * (high - low), low + golden * (high - low)])
        y = clearance(x.ravel()).reshape(2, -1)
        left = y[0] < y[1]
        low, high = np.where(left, low, x[0]), np.where(left, x[1], high)
        least = min(least, y.min())
    return float(least)


def attack(seed):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, links=int(rng.integers(3, 9)))
    if robot.n_joints == 0:
        return
    own = bool(rng.random() < 0.3)
    obstacles = [thin_obstacle(rng) for _ in range(rng.integers(0 if own else 1, 4))]
    waypoints = fast_motion(rng, robot.n_joints)

    def clearance(k):
        def at(s):
            q = waypoints[k] + s[:, None] * (waypoints[k + 1] - waypoints[k])
            return distance.signed(robot, q, obstacles, self_collision=own)

        return at

    seen = min(least_clearance(clearance(k)) for k in range(2))
    if not np.isfinite(seen):
        return
    for margin in (seen + 1e-9, seen + 1e-12 + 1e-14 * abs(seen), seen - 1e-6, 0.0):
        bound = certify.clearance_bound(robot, waypoints, obstacles, margin, self_collision=own)
        assert bound.lower <= seen + bound.slack, f"seed {seed}"
        if margin > seen + bound.slack:
            assert not bound.holds and (bound.violation is not None or bound.unresolved), f"seed {seed}"
        if bound.violation is not None:  # it is one
            v = bound.violation
            q = waypoints[v.segment] + v.fraction * (waypoints[v.segment + 1] - waypoints[v.segment])
            assert distance.signed(robot, q, obstacles, self_collision=own) < margin, f"seed {seed}"
        elif margin == seen - 1e-6 and not bound.holds:  # refused only where it cannot know
            assert bound.unresolved, f"seed {seed}"


@pytest.mark.parametrize("seed", range(40))
def test_no_margin_that_is_broken_is_certified(seed):
    attack(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40, 1500))
def test_many_more_attacks(seed):
    attack(seed)
