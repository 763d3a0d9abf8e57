"""The certificate of any trajectory of a snake that runs straight in its coordinates between waypoints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..certify import Certificate
from ..errors import InputError
from ..numeric import at_least, at_most, wrap_angle
from ..scenes import Scene, SnakeRobot, Trajectory
from ._scene import snake_of
from ._snake import Snake
from ._world import Surroundings, bounded, self_distance

Array = NDArray[np.float64]

_SLIP = 0.02  # of a link: how far a wheel may be dragged sideways in all, since waypoints lie apart
_NEAR = 1e-3  # of start and goal, metres and rad
NOT_CHECKED = (
    "neighbouring links share a joint and are not checked against each other; a snake scene has no input limits"
)


def certify_trajectory(scene: Scene, trajectory: Trajectory) -> Certificate:
    """Certificate of a trajectory (columns x, y, theta, Phi_1, ..) in a snake scene: body, links, wheels, start and goal.

    Between waypoints the absolute angles change linearly, so that a body point travels no further than joint 0 does plus the
    sum of l_i |d theta_i|: the clearance is at least half of (both clearances less that way), halved until it decides.
    `reasons` says how far wheels slip sideways in all. Raises InputError. Our derivation.
    """
    snake, robot = snake_of(scene), scene.robot
    assert isinstance(robot, SnakeRobot)
    q, time = trajectory.positions, trajectory.time
    if q.shape[1] != snake.n:
        raise InputError(
            f"expected {snake.n} columns for {snake.links} links, got {q.shape[1]}",
            place="trajectory",
            remedy="the columns are x, y, theta, Phi_1, ..: " + ", ".join(snake.names),
        )
    around, half = Surroundings.of(list(scene.obstacles), None), 0.5 * robot.width

    def look(postures: Array) -> tuple[Array, Array, Array]:
        joints = snake.joints(postures)
        return around.of_body(joints, half), self_distance(joints) - 2.0 * half, _travel(snake, postures)

    asked = scene.options.clearance

    def refine(i: int) -> tuple[float, float, int]:
        used, bound, own = 0, -np.inf, -np.inf
        for pieces in (16, 256):
            part = np.linspace(0.0, 1.0, pieces + 1)[:, None]
            free, apart, travel = look(q[i] + part * (q[i + 1] - q[i]))
            bound = float((0.5 * (free[:-1] + free[1:] - travel)).min())
            own = float((0.5 * (apart[:-1] + apart[1:]) - travel).min())
            used += len(free)
            if bound >= asked and own >= 0.0:
                break
        return bound, own, used

    found = bounded(time, *look(q), asked, refine)
    slip = _slip(snake, q)
    start, goal = (off_target(q[i], target) for i, target in ((0, scene.start), (-1, scene.goal)))
    reasons = []
    if found.clearance < asked:
        reasons.append(f"the body's clearance is only certified to {at_least(found.clearance)} m of {asked:g} m")
    if found.self_clearance < 0.0:
        reasons.append("links come too close to one another")
    if slip > _SLIP * float(snake.lengths.min()):
        reasons.append(f"a wheel slips sideways by {at_most(slip, 2)} m in all")
    for (metres, angle), name in ((start, "start"), (goal, "goal")):
        if max(metres, angle) > _NEAR:
            reasons.append(f"the {name} is missed by {metres:.3g} m, {angle:.3g} rad")
    good = not reasons
    head = [f"between the waypoints a wheel slips sideways by at most {at_most(slip, 2)} m in all"] if good else []
    return Certificate(
        certified=good,
        clearance=found.clearance,
        clearance_seen=found.sampled,
        margin=asked,
        self_clearance=found.self_clearance,
        self_clearance_seen=found.self_sampled,
        self_margin=0.0,
        nearest="body and obstacles",
        first_violation=None,
        violations=(),
        unresolved=(),
        reasons=(*reasons, *head, NOT_CHECKED),
        goal_error=goal[0],
        goal_angle_error=goal[1],
        start_error=start[0],
        start_angle_error=start[1],
        limits_ok=True,
        velocities_ok=True,
        evaluations=found.samples,
        slack=0.0,
    )


def off_target(q: Array, target: object) -> tuple[float, float]:
    """Distance of joint 0 (m) and largest angle (rad) by which a posture misses a posture target."""
    wanted = getattr(target, "q", None)
    if wanted is None:
        return float("inf"), float("inf")
    return float(np.linalg.norm(q[:2] - wanted[:2])), float(np.abs(wrap_angle(q[2:] - wanted[2:])).max())


def _travel(snake: Snake, q: Array) -> Array:
    change = np.diff(q, axis=0)
    turning = np.abs(np.cumsum(change[:, 2:], axis=1)) @ snake.lengths
    return np.linalg.norm(change[:, :2], axis=1) + turning


def _slip(snake: Snake, q: Array) -> float:
    """How far a wheel is dragged sideways over the whole way, metres: the most of all wheels, by the middle of each step."""
    if len(q) < 2:
        return 0.0
    across = np.einsum("kij,kj->ki", snake.pfaff(0.5 * (q[:-1] + q[1:])), np.diff(q, axis=0))
    return float(np.abs(across).sum(axis=0).max(initial=0.0))
