"""What the closed forms of an arm leave free: values to look at, and the postures at them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import kinematics
from ..entities import Point
from ..kinematics._point_arms import last_range
from ..robots import Robot

Floats = NDArray[np.float64]

FREE_SAMPLES, FINE_SAMPLES = 72, 576  # of the redundancy circle: 5 degrees apart; where none of these is free, 0.6
POINT_SAMPLES = 36, 20  # of the two freedoms that a position alone leaves an arm of kind us5: psi, q5


def free_range(robot: Robot) -> tuple[float, float] | None:
    """The least and the largest value of the redundancy of the robot's closed form, None without one."""
    parameter = kinematics.classify(robot).parameter
    if parameter is None:
        return None
    if parameter in ("phi", "psi"):
        return -np.pi, np.pi
    joint = int(parameter[1:]) - 1
    lower, upper = np.clip([robot.limits.lower[joint], robot.limits.upper[joint]], -np.pi, np.pi)
    return float(lower), float(upper)


def free_grid(robot: Robot, count: int = FREE_SAMPLES) -> tuple[Floats, float]:
    """`count` values of the redundancy of the robot's closed form to look at, and their spacing: a circle, or a joint's range."""
    ends = free_range(robot)
    if ends is None:
        return np.zeros(1), 0.0
    if kinematics.classify(robot).parameter in ("phi", "psi"):
        return np.linspace(*ends, count, endpoint=False), 2.0 * np.pi / count
    return np.linspace(*ends, count), (ends[1] - ends[0]) / (count - 1)


def inverse_over(robot: Robot, target: Any, free: Floats) -> kinematics.IkSolutions:
    """All branches of a closed form at every value of the redundancy, if the robot has one."""
    given: dict[str, Any] = {}
    parameter = kinematics.classify(robot).parameter
    if parameter:
        given[parameter] = free
    return kinematics.inverse(robot, target, **given)


def point_range(robot: Robot) -> Floats:
    """Least and largest values (2, 2) of psi and q5 of the closed form for a position alone."""
    return np.transpose([(-np.pi, np.pi), last_range(robot.limits.lower[4], robot.limits.upper[4])])


def point_grid(robot: Robot) -> tuple[Floats, Floats]:
    """Values (m, 2) of psi and q5 to look at for a position alone, and their spacing (2,)."""
    turns, rolls = POINT_SAMPLES
    (first, lower), (end, upper) = point_range(robot)
    psi, last = np.linspace(first, end, turns, endpoint=False), np.linspace(lower, upper, rolls)
    values = np.stack(np.meshgrid(psi, last, indexing="ij"), axis=-1).reshape(-1, 2)
    return values, np.array([2.0 * np.pi / turns, (upper - lower) / (rolls - 1)])


def inverse_over_point(robot: Robot, points: Floats, free: Floats) -> kinematics.IkSolutions:
    """All branches of the closed form for a position alone, at values (m, 2) of psi and q5; points (3,) or (m, 3)."""
    return kinematics.inverse(robot, Point.from_euclidean(points), psi=free[:, 0], q5=free[:, 1])
