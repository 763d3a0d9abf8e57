"""A unicycle: it follows the harmonic field with bounded speed, turn rate and acceleration."""

from __future__ import annotations

import numpy as np

from ..certify import certify
from ..control import Unicycle, drive
from ..errors import InputError
from ..scenes import HeadingTarget, Scene, Trajectory, UnicycleRobot
from ._plan import Plan, Progress
from ._point import harmonic_field


def plan_unicycle(scene: Scene, progress: Progress) -> Plan:
    """See `plan`; for a `UnicycleRobot`. The goal's heading, if it has one, is met by a turn on the spot."""
    robot, options = scene.robot, scene.options
    assert isinstance(robot, UnicycleRobot)
    start, goal = scene.start, scene.goal
    assert isinstance(start, HeadingTarget) and isinstance(goal, HeadingTarget)
    with progress.part("field"):
        try:
            field = harmonic_field(scene, robot.radius + options.clearance)
        except InputError as error:
            return Plan(scene, False, str(error))
    heading = start.heading
    if heading is None:  # free: look where the field leads
        way = field(start.position)
        heading = float(np.arctan2(way[1], way[0]))
    with progress.part("drive"):
        result = drive(
            field,
            [*start.position, heading],
            goal.position,
            robot=Unicycle(robot.radius, robot.max_speed, robot.max_turn_rate, robot.max_acceleration),
            room=field.room,
            period=scene.control.period,
            tolerance=options.goal_tolerance,
        )
    progress.notes.extend(field.notes)
    poses = result.poses
    if not result.reached:
        return Plan(scene, False, result.reason, "harmonic field", path=poses[:, :2])
    time, poses = result.time, np.column_stack([poses[:, :2], np.unwrap(poses[:, 2])])
    if goal.heading is not None:
        time, poses = _turned(time, poses, goal.heading, robot.max_turn_rate, options.time_step)
    trajectory = Trajectory(time, poses, names=("x", "y", "heading"))
    with progress.part("certificate"):
        certificate = certify(scene, trajectory)
    reason = "solved"
    if not certificate.certified:
        reason = f"the motion has no certificate: {certificate.first_violation or certificate.unresolved}"
    return Plan(scene, certificate.certified, reason, "harmonic field", trajectory, certificate, poses[:, :2])


def _turned(time, poses, heading: float, rate: float, step: float):
    """The motion followed by a turn on the spot to `heading`, the short way."""
    turn = (heading - poses[-1, 2] + np.pi) % (2.0 * np.pi) - np.pi
    count = max(1, int(np.ceil(abs(turn) / (rate * step))))
    more = np.repeat(poses[-1:], count, axis=0)
    more[:, 2] += turn * np.arange(1, count + 1) / count
    return np.concatenate([time, time[-1] + step * np.arange(1, count + 1)]), np.concatenate([poses, more])
