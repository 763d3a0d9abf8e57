"""How far a configuration is from a start or a goal."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..robots import Robot
from ..robots._placement import compose, link_frames, rotation_translation
from ..scenes import (
    GripperPlaneTarget,
    HeadingTarget,
    JointTarget,
    LineTarget,
    PlaneTarget,
    PoseTarget,
    PositionTarget,
    PostureTarget,
    Target,
    quaternion_matrix,
)

Floats = NDArray[np.float64]


def arm_error(robot: Robot, q: Floats, target: Target) -> tuple[float, float]:
    """(metres at the tool, radians) for an arm; joint targets: (largest joint difference, 0)."""
    if isinstance(target, JointTarget):
        free = np.isinf(robot.limits.lower) & np.isinf(robot.limits.upper)
        step = q - target.q
        turned = np.remainder(step + math.pi, 2.0 * math.pi) - math.pi
        return float(np.abs(np.where(free & _revolute(robot), turned, step)).max(initial=0.0)), 0.0
    R, p = rotation_translation(compose(link_frames(robot.links, q)[robot.tip], robot.tool))
    if isinstance(target, PoseTarget):
        return float(np.linalg.norm(p - target.position)), _angle(R.T @ quaternion_matrix(target.quaternion))
    if isinstance(target, GripperPlaneTarget):  # the gripper points along y of the tool frame
        slope = float(R[:, 1] @ target.normal)
        return float(np.linalg.norm(p - target.position)), abs(math.asin(min(max(slope, -1.0), 1.0)))
    if isinstance(target, LineTarget):
        return float(np.linalg.norm(np.cross(p - target.point, target.direction))), 0.0
    if isinstance(target, PlaneTarget):
        return abs(float(p @ target.normal) - target.distance), 0.0
    assert isinstance(target, PositionTarget), target
    return float(np.linalg.norm(p - target.position)), 0.0


def body_error(x: Floats, target: Target) -> tuple[float, float]:
    """(metres, radians) for a point robot (n,) or a unicycle (x, y, heading)."""
    if isinstance(target, HeadingTarget):
        turned = 0.0 if target.heading is None or len(x) < 3 else math.remainder(x[2] - target.heading, 2.0 * math.pi)
        return float(np.linalg.norm(x[:2] - target.position)), abs(turned)
    assert isinstance(target, (PositionTarget, PostureTarget)), target
    at: Any = target.position if isinstance(target, PositionTarget) else target.q
    return float(np.linalg.norm(x[: len(at)] - at)), 0.0


def _revolute(robot: Robot) -> NDArray[np.bool_]:
    turns = np.zeros(robot.n_joints, bool)
    for link in robot.links:
        if link.kind == "revolute":
            turns[link.coordinate] = True
    return turns


def _angle(R: Floats) -> float:
    """Of a rotation matrix, accurate near 0 and near pi."""
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return math.atan2(float(np.linalg.norm(axis)), float(np.trace(R)) - 1.0)
