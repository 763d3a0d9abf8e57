"""`start` and `goal` of a scene file, by the fields that are there."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..errors import InputError
from . import _schema as s
from ._bodies import PointRobot, SnakeRobot, UnicycleRobot
from ._problems import Reader
from ._targets import (
    GripperPlaneTarget,
    HeadingTarget,
    JointTarget,
    LineTarget,
    PlaneTarget,
    PoseTarget,
    PositionTarget,
    PostureTarget,
    Target,
    rpy_quaternion,
)
from ._yaml import Loc

_KINDS = "joints, position, position + plane_normal, position + rpy, line or plane"


def rotation(section: Any) -> np.ndarray | None:
    """The quaternion that a section writes in one of three ways, None if in none."""
    if section.quaternion_wxyz is not None:
        q = np.array(section.quaternion_wxyz)
        if abs(np.linalg.norm(q) - 1.0) > 1e-3:
            raise InputError(f"quaternion_wxyz has length {np.linalg.norm(q):.6g}", remedy="a rotation has length 1")
        return q / np.linalg.norm(q)
    if section.rpy_deg is not None:
        return rpy_quaternion(np.radians(section.rpy_deg))
    if section.rpy is not None and max(map(abs, section.rpy)) > 2.0 * math.pi:
        raise InputError(
            f"rpy: {max(section.rpy, key=abs):g} radians are more than a turn", remedy="degrees are written as rpy_deg"
        )
    return None if section.rpy is None else rpy_quaternion(section.rpy)


def angle(radians: float | None, degrees: float | None) -> float | None:
    """An angle in radians from whichever of the two fields is there."""
    return math.radians(degrees) if degrees is not None else radians


def read_target(reader: Reader, data: Any, loc: Loc, robot: Any) -> Target | None:
    """The target written at `loc`; None with the problems noted. `robot` None: not readable, names are not resolved."""
    if not isinstance(data, dict):
        return reader.fail(loc, f"expected fields ({_KINDS})")
    if isinstance(robot, PointRobot):
        section = reader.section(s.PositionFields, data, loc)
        return section and PositionTarget(section.position)  # type: ignore[arg-type]
    if isinstance(robot, UnicycleRobot):
        section = reader.section(s.HeadingFields, data, loc)
        return section and HeadingTarget(section.position, angle(section.heading, section.heading_deg))  # type: ignore[arg-type]
    if isinstance(robot, SnakeRobot):
        return _posture(reader, data, loc)
    try:
        return _arm_target(reader, data, loc, robot)
    except InputError as error:
        return reader.caught(loc, error)


def _posture(reader: Reader, data: dict, loc: Loc) -> Target | None:
    section = reader.section(s.PostureFields, data, loc)
    if section is None:
        return None
    degrees = section.joints_deg
    joints = section.joints if degrees is None else np.radians(np.array(degrees))
    return PostureTarget([*section.position, angle(section.heading, section.heading_deg), *joints])  # type: ignore[arg-type]


def _arm_target(reader: Reader, data: dict, loc: Loc, robot: Any) -> Target | None:
    if "joints" in data or "joints_deg" in data:
        section = reader.section(s.JointFields, data, loc)
        return section and _joint_target(reader, section, loc, robot)
    if "line" in data:
        section = reader.section(s.OnLine, data, loc)
        return section and LineTarget(section.line.point, section.line.direction)  # type: ignore[arg-type]
    if "plane" in data:
        if isinstance(data["plane"], dict) and reader.section(s.PlaneFields, data["plane"], (*loc, "plane")) is None:
            return None
        section = reader.section(s.InPlane, data, loc)
        return section and PlaneTarget(*half_space(section.plane))
    if "plane_normal" in data:
        section = reader.section(s.GripperPlaneFields, data, loc)
        return section and GripperPlaneTarget(section.position, section.plane_normal)  # type: ignore[arg-type]
    if any(data.get(name) is not None for name in s.ROTATION):
        section = reader.section(s.PoseFields, data, loc)
        return section and PoseTarget(section.position, rotation(section))  # type: ignore[arg-type]
    if "position" not in data:
        choices = {*s.JointFields.model_fields, *s.PoseFields.model_fields, "plane_normal", "line", "plane"}
        for key in data:
            if key not in choices:
                reader.unknown((*loc, key), "field", key, choices, at_key=True)
        return reader.fail(loc, f"expected one of: {_KINDS}")
    unknown = [key for key in data if key != "position"]
    for key in unknown:
        reader.unknown((*loc, key), "field", key, {*s.PoseFields.model_fields, "plane_normal"}, at_key=True)
    section = reader.section(s.PositionFields, {"position": data["position"]}, loc)
    return PositionTarget(section.position) if section and not unknown else None  # type: ignore[arg-type]


def half_space(section: s.PlaneFields | s.HalfSpace) -> tuple[np.ndarray, float]:
    """Unit normal and distance from `normal` with `distance` or `point`."""
    normal = np.array(section.normal)
    length = float(np.linalg.norm(normal))
    if length < 1e-12:
        raise InputError("normal: expected a direction, got the zero vector")
    normal = normal / length
    return normal, float(normal @ section.point) if section.point is not None else float(section.distance) / length  # type: ignore[arg-type]


def _joint_target(reader: Reader, section: s.JointFields, loc: Loc, robot: Any) -> Target | None:
    key = "joints" if section.joints is not None else "joints_deg"
    value = getattr(section, key)
    if isinstance(value, dict):
        if robot is None:
            return None
        for name in value:
            if name not in robot.joint_names:
                reader.unknown((*loc, key, name), "joint", name, robot.joint_names, at_key=True)
        missing = [name for name in robot.joint_names if name not in value]
        if missing:
            return reader.fail((*loc, key), f"no value for the joints {', '.join(missing)}")
        value = [value[name] for name in robot.joint_names if name in value]
    q = np.array(value, dtype=np.float64)
    if key == "joints_deg":
        prismatic = _prismatic(robot)
        q = np.array([x if j in prismatic else math.radians(x) for j, x in enumerate(q)])
    return JointTarget(q)


def _prismatic(robot: Any) -> set[int]:
    links = () if robot is None else robot.links
    return {link.coordinate for link in links if link.kind == "prismatic"}
