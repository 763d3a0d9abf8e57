"""Any other arm: follow the tool path by the Jacobian, with what the task leaves free kept for clearance and limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import kinematics
from ..distance import signed
from ..scenes import GripperPlaneTarget, JointTarget, PoseTarget, Scene
from ..versors import Motor
from ._branches import ArmPath
from ._clearance import arm, margin, touch
from ._refusals import limit_reason

Floats = NDArray[np.float64]

_ITERATIONS = 40
_DAMPING = 1e-3  # of the task's inverse, in units of the arm's reach per radian
_COMFORT = 0.05  # metres above the clearance asked within which an obstacle pushes
_PUSH = 0.6  # of the largest joint step: what the null space may move between two points of the path
_CENTRE = (
    0.02  # radians: pull of the middle of the limits, at the limits, against a push of one by an obstacle that is near
)
_HALVINGS = 6  # of a path step whose joint step is too large


def follow_jacobian(scene: Scene, start: Floats, points: Floats) -> ArmPath:
    """Waypoints (k, n) from the configuration `start` with the tool on the polyline `points`; the last reaches the goal.

    Each point is reached by damped least squares; the null space climbs the clearance and draws away from the joint limits.
    A step whose joints move more than `max_joint_step` is halved. The orientation turns evenly to that of the goal if the
    goal has one, otherwise it is free.
    """
    robot, options = arm(scene), scene.options
    turn, first = None, kinematics.forward(robot, start)
    if isinstance(scene.goal, (PoseTarget, JointTarget)):
        final = scene.goal.motor() if isinstance(scene.goal, PoseTarget) else kinematics.forward(robot, scene.goal.q)
        turn = (~first @ final).log().copy()
        turn[3:] = 0.0
    elif isinstance(scene.goal, GripperPlaneTarget):
        return ArmPath(None, "a gripper plane is a target of the 5-DOF humanoid arm only")
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    fractions = lengths / max(lengths[-1], 1e-300)

    def pose(fraction: float) -> Floats:
        matrix = np.eye(4) if turn is None else (first @ Motor.exp(fraction * turn)).as_matrix()
        matrix[:3, 3] = [np.interp(fraction, fractions, points[:, c]) for c in range(3)]
        return matrix

    waypoints, done, k = [start], 0.0, 1
    while done < 1.0:
        goal_fraction, halvings = float(fractions[k]), 0
        while True:
            wanted = pose(goal_fraction)
            q, residual = _solve(scene, waypoints[-1], wanted, turn is not None)
            step = float(np.abs(q - waypoints[-1]).max())
            if residual <= options.goal_tolerance and step <= options.max_joint_step:
                break
            halvings += 1
            if halvings > _HALVINGS:
                where = np.round(wanted[:3, 3], 3).tolist()
                why = _why_stuck(scene, q, residual, step)
                return ArmPath(None, f"Jacobian following stops at {goal_fraction:.0%} of the tool path {where}: {why}")
            goal_fraction = 0.5 * (done + goal_fraction)
        if margin(scene, q[None])[0] < 0.0:
            where = np.round(wanted[:3, 3], 3).tolist()
            why = touch(scene, q[None])
            text = f"Jacobian following collides at {goal_fraction:.0%} of the tool path {where}: {why}"
            return ArmPath(None, text, touch=why)
        waypoints.append(q)
        done = goal_fraction
        if done >= fractions[k]:
            k += 1
    if isinstance(scene.goal, JointTarget):
        gap = np.abs(scene.goal.q - waypoints[-1]).max()
        count = max(1, int(np.ceil(gap / options.max_joint_step)))
        waypoints += [waypoints[-1] + s * (scene.goal.q - waypoints[-1]) for s in np.arange(1, count + 1) / count]
    return ArmPath(np.stack(waypoints))


def _solve(scene: Scene, start: Floats, wanted: Floats, oriented: bool) -> tuple[Floats, float]:
    """The configuration near `start` with the tool at `wanted`, and its error (m, rad)."""
    robot, options = arm(scene), scene.options
    lower, upper, middle = robot.limits.lower, robot.limits.upper, robot.limits.middle
    span = np.where(np.isfinite(upper - lower), upper - lower, np.inf)
    target = Motor.from_matrix(wanted)
    q, residual, budget = start.copy(), np.inf, _PUSH * options.max_joint_step
    for iteration in range(_ITERATIONS):
        reached = kinematics.forward(robot, q)
        J = kinematics.jacobian(robot, q)
        position = wanted[:3, 3] - reached.as_matrix()[:3, 3]
        if oriented:
            error = np.concatenate([(target @ ~reached).log()[:3], position])
        else:
            error, J = position, J[3:]
        residual = float(np.abs(error).max())
        pushed = iteration > 2 or budget <= 0.0
        if residual <= 0.1 * options.goal_tolerance and pushed:
            break
        push = np.zeros_like(q)
        if not pushed:
            push -= _CENTRE * np.where(np.isfinite(span), (q - middle) / span**2, 0.0)
            distance, gradient = signed(robot, q[None], scene.obstacles, gradient=True, static=False)
            urgency = 1.0 - (distance[0] - options.clearance) / _COMFORT
            if urgency > 0.0:
                push += min(urgency, 2.0) * gradient[0] / max(np.linalg.norm(gradient[0]), 1e-9)
            push *= min(1.0, 0.5 * budget / max(np.abs(push).max(), 1e-300))
            budget -= np.abs(push).max()
        dq = _task_and_push(J, error, push, q, lower, upper)
        q = np.clip(q + dq * min(1.0, 0.2 / max(np.abs(dq).max(), 1e-300)), lower, upper)
    return q, residual


def _task_and_push(J: Floats, error: Floats, push: Floats, q: Floats, lower: Floats, upper: Floats) -> Floats:
    """The joint step that mends `error` and makes of `push` what the task leaves free; joints at a limit do not press on it."""
    free = np.ones(len(q), bool)
    while True:
        A = J * free
        gram = A @ A.T
        damping = _DAMPING**2 if np.abs(error).max() > 1e-3 else 1e-12
        inverse = A.T @ np.linalg.inv(gram + damping * np.eye(len(gram)))
        dq = inverse @ error + (push - inverse @ (A @ push)) * free
        pressing = free & (((q <= lower) & (dq < 0.0)) | ((q >= upper) & (dq > 0.0)))
        if not pressing.any() or free.sum() <= len(error):
            return dq
        free &= ~pressing


def _why_stuck(scene: Scene, q: Floats, residual: float, step: float) -> str:
    robot, options = arm(scene), scene.options
    at_limit = np.flatnonzero((q <= robot.limits.lower + 1e-9) | (q >= robot.limits.upper - 1e-9))
    if residual > options.goal_tolerance:
        held = f"; at their limits: {', '.join(robot.joint_names[j] for j in at_limit)}" if len(at_limit) else ""
        return f"the tool stays {residual:.2g} m or rad away{held}"
    if step > options.max_joint_step:
        return f"a joint would jump by {np.degrees(step):.3g} degrees"
    return limit_reason(robot, q[None])
