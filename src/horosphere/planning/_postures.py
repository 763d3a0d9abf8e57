"""Postures with the tool at given places, drawn over what the goal leaves free: by a closed form where the arm has one."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import kinematics
from ..entities import Point
from ..kinematics._numeric import search_box
from ..robots import Robot
from ..versors import Motor, Rotor
from ._free_angles import free_range, inverse_over, inverse_over_point, point_range

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_DRAWS = 8  # orientations for one posture that is asked for, before the numerical inverse, which keeps limits, goes on
_ATTEMPTS = 2  # of a numerical inverse, for one posture


def within_limits(robot: Robot, q: Floats, tolerance: float = 1e-9) -> NDArray[np.bool_]:
    """(...) whether configurations (..., n) keep the joint limits."""
    return np.all((q >= robot.limits.lower - tolerance) & (q <= robot.limits.upper + tolerance), axis=-1)


def has_formula(robot: Robot) -> bool:
    """Whether a closed form gives postures for a place of the tool, with the rest drawn."""
    structure = kinematics.classify(robot)
    whole = structure.is_closed_form and robot.n_joints >= 6  # with fewer, next to no orientation is in reach
    return whole or structure.position is not None or structure.name == "humanoid_arm"


def drawn(robot: Robot, places: Any, count: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """About `count` postures (k, n) within the limits with the tool at k `places` (k, 3).

    places: a function of a number, which gives so many places (m, 3), others each time. k is less than `count` where little
    of the goal is in reach.
    """
    found, at, total, size = [], [], 0, max(count // 2, 16)
    left = count
    while left > 0 and total < _DRAWS * count and has_formula(robot):
        points = places(size)
        q, of = _by_formula(robot, points, rng)
        some = rng.permutation(len(q))[:left]  # not all branches of a few places
        found.append(q[some])
        at.append(points[of[some]])
        left, total, size = left - len(found[-1]), total + size, min(2 * size, _DRAWS * count)
    if left > 0:
        points = places(left)
        q, of = searched(robot, Point.from_euclidean(points), random_postures(robot, left, rng))
        found.append(q)
        at.append(points[of])
    return np.concatenate(found), np.concatenate(at)


def searched(robot: Robot, target: Any, seeds: Floats) -> tuple[Floats, Integers]:
    """Postures (k, n) that the numerical inverse reaches from `seeds` (m, n), and the numbers (k,) of their seeds."""
    found = kinematics.numerical_inverse(robot, target, seed=seeds, attempts=_ATTEMPTS)
    valid = np.flatnonzero(found.valid[:, 0])
    return found.q[valid, 0], valid


def random_postures(robot: Robot, count: int, rng: np.random.Generator) -> Floats:
    """(count, n) within the limits, a turn or a metre where there are none."""
    return rng.uniform(*search_box(robot), (count, robot.n_joints))


def _by_formula(robot: Robot, points: Floats, rng: np.random.Generator) -> tuple[Floats, Integers]:
    """All branches within the limits at points (m, 3), at a random orientation and redundancy each; the numbers of their points."""
    m, structure = len(points), kinematics.classify(robot)
    if structure.position is not None:
        found = inverse_over_point(robot, points, _between(rng, point_range(robot), m))
    else:
        if structure.name == "humanoid_arm":
            target: Any = kinematics.GripperOnPlane(points, rng.normal(size=(m, 3)))
        else:
            turn = rng.normal(size=(m, 4))  # normal quaternions: every orientation is as likely as any other
            turn /= np.linalg.norm(turn, axis=1, keepdims=True)
            target = Motor.from_translation(points) @ Rotor.from_quaternion(turn)
        found = inverse_over(robot, target, rng.uniform(*(free_range(robot) or (0.0, 0.0)), m))
    usable = found.valid & within_limits(robot, found.q)
    return found.q[usable], np.nonzero(usable)[0]


def _between(rng: np.random.Generator, ends: Floats, count: int) -> Floats:
    """Points (count, d) of the box between the rows of `ends` (2, d)."""
    return ends[0] + rng.uniform(size=(count, ends.shape[1])) * (ends[1] - ends[0])


def turned_near(robot: Robot, q: Floats, near: Floats) -> Floats:
    """The postures (m, n) with every joint moved by whole turns, within its limits, to where it is nearest to `near` (n,)."""
    whole = np.ones(robot.n_joints, bool)
    for link in robot.links:
        if link.coordinate >= 0 and (link.kind != "revolute" or abs(link.multiplier) != 1.0):
            whole[link.coordinate] = False
    turned = np.where(whole, q + 2.0 * np.pi * np.round((near - q) / (2.0 * np.pi)), q)
    inside = (turned >= robot.limits.lower) & (turned <= robot.limits.upper)
    return np.where(inside, turned, q)
