"""Snake scenes: from a scene file to navigation, its trajectory and the certificate in the form of `certify`."""

from __future__ import annotations

import numpy as np

from ..certify import Certificate
from ..errors import InputError
from ..numeric import at_least
from ..scenes import PostureTarget, Scene, SnakeRobot, Trajectory
from ._navigate import Navigation
from ._snake import Snake


def snake_of(scene: Scene) -> Snake:
    """The snake of a scene. Raises InputError if its robot is another one."""
    robot = scene.robot
    if not isinstance(robot, SnakeRobot):
        raise InputError(
            f"expected a scene with a snake, its robot is {getattr(robot, 'name', robot)!r}", place="robot"
        )
    return Snake(lengths=robot.lengths, wheel_fraction=robot.wheel_fraction)


def navigate_scene(scene: Scene, **options: object) -> Navigation:
    """Navigation as the scene says: width, clearance and seed from it; `options` override (weave, speed, workspace, ...)."""
    snake, robot = snake_of(scene), scene.robot
    assert isinstance(robot, SnakeRobot)
    for target, name in ((scene.start, "start"), (scene.goal, "goal")):
        if not isinstance(target, PostureTarget):
            raise InputError(
                "expected a posture", place=name, remedy="write {position: [x, y], heading: 0.0, joints: [Phi_1, ..]}"
            )
    assert isinstance(scene.start, PostureTarget) and isinstance(scene.goal, PostureTarget)
    given = {"width": robot.width, "clearance": scene.options.clearance, "seed": scene.options.seed}
    return snake.navigate(scene.start.q, scene.goal.q, list(scene.obstacles), **(given | options))


def trajectory_of(snake: Snake, result: Navigation) -> Trajectory | None:
    """The motion as a trajectory (time, q, dq), or None."""
    if result.motion is None:
        return None
    motion = result.motion
    keep = np.concatenate([[True], np.diff(motion.time) > 0.0])
    z = snake.to_angles(motion.q[keep])
    rates = snake.angle_rates(z, motion.inputs[keep])
    return Trajectory(motion.time[keep], motion.q[keep], rates, None, snake.names)


def certificate_of(scene: Scene, result: Navigation) -> Certificate | None:
    """The certificate of a navigation in the form of `certify`; the motion between waypoints is that of the snake itself."""
    from ._certify import NOT_CHECKED, off_target

    own = result.certificate
    if own is None or result.motion is None:
        return None
    asked = scene.options.clearance
    reasons = []
    if own.clearance < asked:
        reasons.append(f"the clearance is only certified to {at_least(own.clearance)} m")
    if own.self_clearance < 0.0:
        reasons.append("links come too close to one another")
    start_error, start_angle = off_target(result.motion.q[0], scene.start)
    goal_error, goal_angle = off_target(result.motion.end, scene.goal)
    return Certificate(
        certified=own.certified and result.solved,
        clearance=own.clearance,
        clearance_seen=own.sampled,
        margin=asked,
        self_clearance=own.self_clearance,
        self_clearance_seen=own.self_sampled,
        self_margin=0.0,
        nearest="body and obstacles",
        first_violation=None,
        violations=(),
        unresolved=(),
        reasons=(*reasons, NOT_CHECKED),
        goal_error=goal_error,
        goal_angle_error=goal_angle,
        start_error=start_error,
        start_angle_error=start_angle,
        limits_ok=True,
        velocities_ok=True,
        evaluations=own.samples,
        slack=result.motion.error,
    )
