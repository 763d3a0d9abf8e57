"""Inverse kinematics of any robot by damped least squares on motors."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..entities import Line, Point
from ..errors import InputError
from ..numeric import float_array, number, whole_number
from ..robots import Robot
from ..robots._robot import require_robot
from ..versors import Motor
from ._forward import forward
from ._solutions import IkSolutions
from ._tree import chain

Floats = NDArray[np.float64]
STARTS = 512


def numerical_inverse(
    robot: Robot,
    target: Any,
    seed: ArrayLike | None = None,
    *,
    solutions: int = 1,
    tool_axis: ArrayLike = (0.0, 0.0, 1.0),
    tolerance: float = 1e-9,
    attempts: int = 100,
    iterations: int = 60,
    random_seed: int = 0,
) -> IkSolutions:
    """Joint values within the limits that bring the tool to a target, found by damped least squares with restarts.

    target: Motor (pose), Point (position of the tool point), Line (the tool's axis lies on it, in its direction), or
    a pair (Point, Line) or (Point, direction (..., 3)): position, and direction of the tool's axis. Leading axes are
    batch.
    seed: (n,) or (..., n) first start (default: the middle of the limits); further ones are drawn from `random_seed`.
    solutions: how many different ones to look for (joint values more than 0.02 apart); rows beyond those found repeat
    the first.
    tool_axis: (3,) in the tool frame. tolerance: metres and radians. iterations: at most, for each of at most
    `attempts` starts.
    Not solved is a value: `valid` is False, the row is the best reached, `residual` and `reason` say how far and why.
    Error: rotor logarithm of target ~M and displacement; step J^T (J J^T + d)^-1 e, d in proportion to |e|^2
    (Levenberg-Marquardt). Raises InputError for a target of another kind, wrong shapes, numbers that are not finite.
    Source: our derivation.
    """
    from . import _numeric_kernels

    require_robot(robot)
    goals, rules, batch = _goals(target)
    axis = float_array(tool_axis, "tool_axis", last=3, ndim=1)
    if not np.linalg.norm(axis) > 0.0:
        raise InputError("the zero vector is no direction", place="tool_axis")
    solutions, attempts = whole_number(solutions, "solutions", 1), whole_number(attempts, "attempts", 1)
    iterations, random_seed = whole_number(iterations, "iterations", 1), whole_number(random_seed, "random_seed", 0)
    tolerance = number(tolerance, "tolerance", above=0.0)
    n, limits, flat = robot.n_joints, robot.limits, goals.reshape(-1, 14)
    first = limits.middle if seed is None else float_array(seed, "seed", last=n)
    first = np.clip(np.broadcast_to(first, (*batch, n)).reshape(-1, n), limits.lower, limits.upper)
    starts, tips = _starts(robot, random_seed)
    q = np.empty((len(flat), solutions, n))
    left = np.full((len(flat), solutions, 2), np.inf)
    count, tries = np.zeros(len(flat), np.int64), np.zeros(len(flat), np.int64)
    arrays = chain(robot)
    _numeric_kernels.solve_batch(
        *arrays, limits.lower.copy(), limits.upper.copy(), flat, axis / np.linalg.norm(axis),
        rules, 0.3 * max(reach(robot), 1e-3), first, starts, tips,
        min(attempts, STARTS + 1), iterations, tolerance, q, left, count, tries,
        np.empty((len(arrays.parents), 8)), np.empty((n, 6)), *np.empty((2, 14)), *np.empty((3, n)), np.empty(STARTS),
    )  # fmt: skip
    valid = np.arange(solutions) < count[:, None]
    filled = np.maximum(count, 1)
    rows = np.minimum(np.arange(solutions), filled[:, None] - 1)
    q = np.take_along_axis(q, rows[..., None], axis=1)
    left = np.take_along_axis(left, rows[..., None], axis=1)
    reasons = [
        _reason(robot, goals.reshape(-1, 14)[b], rules, q[b, 0], left[b, 0], int(tries[b])) if not count[b] else ""
        for b in range(len(flat))
    ]
    reason: Any = reasons[0] if batch == () else np.array(reasons, object).reshape(batch)
    return IkSolutions(
        q.reshape(*batch, solutions, n),
        valid.reshape(*batch, solutions),
        np.arange(solutions)[:, None],
        left.max(axis=-1).reshape(*batch, solutions),
        False,
        reason,
        bits=("found",),
    )


def reach(robot: Robot) -> float:
    """An upper bound (m) of the distance of the tool point from the first joint; prismatic joints count with their range."""
    arrays = chain(robot)
    total = 0.0
    for i in range(1, len(arrays.parents)):
        total += 2.0 * float(np.linalg.norm(arrays.origins[i, 4:]))
    for i in range(len(arrays.parents)):
        if arrays.kinds[i] == 2:
            c = arrays.coords[i]
            ends = arrays.mult[i] * np.array([robot.limits.lower[c], robot.limits.upper[c]]) + arrays.offs[i]
            total += float(np.abs(ends).max())
    return total


def search_box(robot: Robot) -> tuple[Floats, Floats]:
    """Limits (n,), (n,) with a turn (revolute) or a metre (prismatic) in place of infinity."""
    lower, upper = robot.limits.lower.copy(), robot.limits.upper.copy()
    for link in robot.links:
        if link.coordinate >= 0:
            width = np.pi if link.kind == "revolute" else 1.0
            c = link.coordinate
            if not np.isfinite(lower[c]):
                lower[c] = upper[c] - 2 * width if np.isfinite(upper[c]) else -width
            if not np.isfinite(upper[c]):
                upper[c] = lower[c] + 2 * width
    return lower, upper


def _starts(robot: Robot, random_seed: int) -> tuple[Floats, Floats]:
    """Random joint values (s, n) within the limits, and their tool frames (s, 8)."""
    name = f"starts {random_seed}"
    if name not in robot.memo:
        low, high = search_box(robot)
        starts = np.random.default_rng(random_seed).uniform(low, high, (STARTS, robot.n_joints))
        robot.memo[name] = (starts, forward(robot, starts).array.copy())
    return robot.memo[name]


def _goals(target: Any) -> tuple[Floats, Floats, tuple[int, ...]]:
    """Goals (..., 14), the rules of `_goal_kernels.goal_error`, the batch shape."""
    parts = target if isinstance(target, tuple) and len(target) == 2 else (target, None)
    place, direction = parts
    if isinstance(place, Motor) and direction is None:
        motor = place.array
        goals = np.zeros((*motor.shape[:-1], 14))
        goals[..., :8] = motor
        goals[..., 8:11] = (place @ Point.from_euclidean(np.zeros(3))).as_euclidean()
        rules = (1.0, 0.0, 0.0)
    elif isinstance(place, Line) and direction is None:
        n, m = place.direction, place.moment
        goals = np.zeros((*n.shape[:-1], 14))
        goals[..., 8:11], goals[..., 11:] = np.cross(n, m), n
        rules = (0.0, 1.0, 1.0)
    elif isinstance(place, Point):
        x = place.as_euclidean()
        n = np.zeros(3)
        if direction is not None:
            n = (
                direction.direction
                if isinstance(direction, Line)
                else float_array(direction, "direction of the target", last=3)
            )
            size = np.linalg.norm(n, axis=-1, keepdims=True)
            if not (size > 0.0).all():
                raise InputError("the zero vector is no direction", place="target")
            n = n / size
        goals = np.zeros((*np.broadcast_shapes(x.shape, n.shape)[:-1], 14))
        goals[..., 8:11], goals[..., 11:] = x, n
        rules = (0.0, 0.0 if direction is None else 1.0, 0.0)
    else:
        raise InputError(
            f"a target of type {type(target).__name__}",
            place="target",
            choices=("Motor (pose)", "Point (position)", "Line (tool axis)", "(Point, Line or direction)"),
        )
    if not np.isfinite(goals).all():
        raise InputError("the target is not finite", place="target")
    return goals, np.array(rules), goals.shape[:-1]


def _reason(robot: Robot, goal: Floats, rules: Floats, q: Floats, left: Floats, tries: int) -> str:
    """Why the best that was reached is not the goal."""
    base = chain(robot).origins[0]
    start = Motor._wrap(base.copy()) @ Point.from_euclidean(np.zeros(3))
    away = goal[8:11] - start.as_euclidean()
    if rules[2] == 1.0:
        away = away - (away @ goal[11:]) * goal[11:]
    span = reach(robot)
    if np.linalg.norm(away) > span:
        return f"unreachable: {np.linalg.norm(away):.4g} m from the first joint, and the arm spans at most {span:.4g} m"
    limits = robot.limits
    close = (q - limits.lower < 1e-9) | (limits.upper - q < 1e-9)
    turned = f" and {left[0]:.3g} rad" if rules[0] or rules[1] else ""  # a point asks for no orientation
    text = f"not reached: the best of {tries} attempts is {left[1]:.3g} m{turned} away"
    if close.any():
        names = ", ".join(name for name, hit in zip(robot.joint_names, close) if hit)
        text += f", with {names} at the limit"
    return text
