"""The certificate of a point robot or a unicycle: a ball on a polyline."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..distance import ROUNDING
from ..errors import InputError
from ..scenes import Aerofoil, EllipsoidND, PointRobot, Star, UnicycleRobot, kind_of
from ._arrival import body_error
from ._ball import ball_clearance
from ._certificate import Certificate, Unresolved, Violation

if TYPE_CHECKING:
    from ..scenes import Scene

Floats = NDArray[np.float64]
SPEED_TOLERANCE = 1e-6


def certify_ball(scene: Scene, positions: Floats, times: Floats | None) -> Certificate:
    """For `certify`: exact for balls, to 1e-6 m for other solids; workspace wall, speed, start and goal."""
    from ._certify import moment, reasons

    robot, options = scene.robot, scene.options
    if not isinstance(robot, (PointRobot, UnicycleRobot)):
        raise InputError(
            f"not for a {type(robot).__name__}",
            place="scene.robot",
            remedy="snake.certify_trajectory, if it is a snake",
        )
    n = scene.dimension
    if positions.ndim != 2 or len(positions) == 0 or positions.shape[1] < n:
        raise InputError(f"expected waypoints (k, {n}), got {positions.shape}", place="trajectory")
    path, margin = np.ascontiguousarray(positions[:, :n]), options.clearance
    scale = float(np.linalg.norm(path, axis=1).max()) + max((_extent(o) for o in scene.obstacles), default=0.0)
    slack = ROUNDING * (8.0 * n + 200.0) * (scale + robot.radius)  # docs/certificate.md
    violations: list[Violation] = []
    unresolved: list[Unresolved] = []
    lower, upper, nearest, evaluations = np.inf, np.inf, "nothing to touch", 0
    for index, obstacle in enumerate(scene.obstacles):
        name = obstacle.name or f"{kind_of(obstacle)} {index}"
        c = ball_clearance(path, robot.radius, obstacle, margin, slack)
        evaluations += c.evaluations
        if c.upper < upper:
            upper, nearest = c.upper, f"{robot.name} to {name}, {1e3 * c.upper:.2f} m{getattr(robot, 'unit', 'm')}"
        lower = min(lower, c.lower)
        if c.first is not None:
            segment, fraction, value = c.first
            time = moment(times, segment, fraction)
            violations.append(Violation("obstacle", robot.name, name, value, margin, segment, fraction, time))
        elif c.lower < margin:
            at = c.segment + c.fraction
            time = moment(times, c.segment, c.fraction)
            unresolved.append(Unresolved("obstacle", at, at, c.lower, time, time))
    wall = scene.workspace
    if wall is not None and n == len(wall.center):  # a ball about a point is convex: the waypoints decide
        room = wall.radius - robot.radius - np.linalg.norm(path - wall.center, axis=1)
        if (room < 0.0).any():
            k = int(np.argmax(room < 0.0))
            at, far = _at(k), float(wall.radius - room[k])
            violations.append(Violation("workspace", robot.name, "wall", far, wall.radius, *at, moment(times, *at)))
    velocities_ok = True
    if times is not None and len(path) > 1:
        speed = np.linalg.norm(np.diff(path, axis=0), axis=1) / np.diff(times)
        fast = speed > robot.max_speed * (1.0 + SPEED_TOLERANCE)
        velocities_ok = not fast.any()
        if fast.any():
            k = int(np.argmax(fast))
            value = float(speed[k])
            violations.append(
                Violation("velocity", robot.name, "speed limit", value, robot.max_speed, k, 0.0, moment(times, k, 0.0))
            )
    errors = []
    for name, k in (("start", 0), ("goal", len(path) - 1)):
        error = body_error(positions[k], getattr(scene, name))
        errors.append(error)
        for value, limit, what in (
            (error[0], options.goal_tolerance, "position error"),
            (error[1], options.angle_tolerance, "angle error"),
        ):
            if not value <= limit:
                at = _at(k)
                violations.append(Violation(name, robot.name, what, value, limit, *at, moment(times, *at)))
    violations.sort(key=lambda v: (v.segment + v.fraction, v.kind == "goal"))
    certified = not violations and not unresolved
    return Certificate(
        certified=certified,
        clearance=lower,
        clearance_seen=upper,
        margin=margin,
        self_clearance=np.inf,
        self_clearance_seen=np.inf,
        self_margin=0.0,
        nearest=nearest,
        first_violation=violations[0] if violations else None,
        violations=tuple(violations),
        unresolved=tuple(unresolved),
        reasons=reasons(violations, unresolved, certified, lower, margin),
        goal_error=errors[1][0],
        goal_angle_error=errors[1][1],
        start_error=errors[0][0],
        start_angle_error=errors[0][1],
        limits_ok=True,
        velocities_ok=velocities_ok,
        evaluations=evaluations,
        slack=slack,
    )


def _at(k: int) -> tuple[int, float]:
    return (k - 1, 1.0) if k > 0 else (0, 0.0)


def _extent(obstacle: Any) -> float:
    """Of the coordinates of a solid (m), roughly: how far it reaches from the origin."""
    if isinstance(obstacle, Aerofoil):  # the image of |P - mu| = R under P + k^2 / P
        R, off = abs(obstacle.k - obstacle.mu), abs(obstacle.mu)
        return float(np.linalg.norm(obstacle.center)) + off + R + obstacle.k**2 / max(abs(R - off), 1e-300)
    if isinstance(obstacle, Star):
        return float(np.linalg.norm(obstacle.center)) + obstacle.radius * (1.0 + obstacle.amplitude)
    if isinstance(obstacle, EllipsoidND):
        return float(np.linalg.norm(obstacle.center) + obstacle.semi_axes.max())
    center, radius = obstacle.bounding_ball()
    return float(np.linalg.norm(center)) + (radius if np.isfinite(radius) else 0.0)
