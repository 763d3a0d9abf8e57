"""Arms as a scene writes them: which robot, its collision bodies, its limits."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from .. import robots
from ..errors import InputError
from . import _schema as s
from ._bodies import PointRobot, SnakeRobot, UnicycleRobot
from ._files import resolve
from ._problems import Reader, likely
from ._yaml import Loc

KEYS = ("name", "urdf", "file", "mechanism", "type")
STAND_INS = {"point": PointRobot(), "ball": PointRobot(), "unicycle": UnicycleRobot(), "snake": SnakeRobot()}


def stand_in(data: Any) -> tuple[Any, int | None]:
    """What start and goal are read for where the robot itself cannot be read (None: any arm), and the dimension of its space where
    that is known."""
    if isinstance(data, dict) and "type" in data:
        found = STAND_INS.get(likely(data["type"], s.BODIES) or "")
        return found, 2 if isinstance(found, (UnicycleRobot, SnakeRobot)) else None
    known = isinstance(data, str) or (isinstance(data, dict) and any(key in data for key in KEYS))
    return None, 3 if known else None


def read_robot(reader: Reader, data: Any, start: Any, folder: Path) -> tuple[Any, Any]:
    """The robot of the scene and how it was written (absolute paths); (None, None) with the problems noted."""
    loc: Loc = ("robot",)
    if isinstance(data, str):
        ending = Path(data).suffix.lower()
        data = {
            "urdf" if ending in (".urdf", ".xml", ".xacro") else "file" if ending in (".yaml", ".yml") else "name": data
        }
    if not isinstance(data, dict):
        reader.fail(
            loc, f"expected the name of a robot, or fields with one of {', '.join(KEYS)}", choices=robots.names()
        )
        return None, None
    if not any(key in data for key in KEYS):
        reader.fail(loc, f"expected one of the fields {', '.join(KEYS)}")
        return None, None
    if "type" in data or "mechanism" in data:
        key = "type" if "type" in data else "mechanism"
        models = s.BODIES if key == "type" else s.MECHANISMS
        if not isinstance(data[key], str) or data[key] not in models:
            reader.unknown((*loc, key), f"robot {key}", data[key], models)
            meant = likely(data[key], models)
            if meant is not None:
                reader.look(models[meant], data, loc)
            return None, None
        section = reader.section(models[data[key]], data, loc)
    else:
        model = s.UrdfRobot if "urdf" in data else s.FileRobot if "file" in data else s.NamedRobot
        section = reader.section(model, data, loc)
    if section is None:
        return None, None
    try:
        if isinstance(section, (s.Point, s.Unicycle, s.Snake)):
            return _body(reader, section, start), dict(data)
        return _arm(section, data, folder, reader, loc)
    except InputError as error:
        reader.caught(loc, error)
        return None, None


def _body(reader: Reader, section: Any, start: Any) -> PointRobot | UnicycleRobot | SnakeRobot | None:
    values = section.model_dump(exclude={"type"})
    if isinstance(section, s.Unicycle):
        return UnicycleRobot(**values)
    if isinstance(section, s.Snake):
        links, length = section.links or 6, section.length or 2.0
        return SnakeRobot(section.lengths or [length] * links, section.wheel_fraction, section.width)  # type: ignore[arg-type]
    if section.dimension is None:
        position = start.get("position") if isinstance(start, dict) else None
        if not isinstance(position, list):
            return reader.fail(("robot",), "no dimension, and no start position to take it from")
        values["dimension"] = max(len(position), 2)
    return PointRobot(**values)


def _arm(section: Any, data: dict, folder: Path, reader: Reader, loc: Loc) -> tuple[Any, Any]:
    spec = dict(data)
    if isinstance(section, s.MechanismFields):
        numbers = section.model_dump(exclude={*s.Arm.model_fields, "mechanism", "link_radius"})
        radius = section.link_radius
        if isinstance(section, s.HumanoidArm) and radius is not None:
            numbers["radii"] = radius if isinstance(radius, list) else [radius] * 3
        elif radius is not None:
            numbers["radius"] = radius
        return _limited(getattr(robots, section.mechanism)(**numbers), section, reader, loc), spec
    options: dict[str, Any] = {}
    where = getattr(section, "name", None)
    if where is None:
        key = "urdf" if isinstance(section, s.UrdfRobot) else "file"
        where = spec[key] = str(resolve(getattr(section, key), folder))
    if isinstance(section, s.UrdfRobot):
        keys = ("base", "tip", "locked", "group", "collision", "budget", "tolerance", "geometry")
        options = {key: getattr(section, key) for key in keys if getattr(section, key) is not None}
        if section.srdf is not None:
            options["srdf"] = spec["srdf"] = str(resolve(section.srdf, folder))
    if section.capsules is not None:
        options["capsules"] = spec["capsules"] = str(resolve(section.capsules, folder))
    if isinstance(section.link_radius, dict):
        if section.capsules is not None:
            raise InputError(
                "'capsules' and radii by link exclude each other", remedy="put the radii into the capsule file"
            )
        options["capsules"] = section.link_radius
    elif section.link_radius is not None:
        options["link_radius"] = section.link_radius
    robot = robots.load(where, **options)
    return _limited(robot, section, reader, loc), spec


def _limited(robot: Any, section: s.Arm, reader: Reader, loc: Loc) -> Any:
    changes = {}
    for name in ("lower", "upper", "velocity", "acceleration"):
        degrees = getattr(section, f"{name}_deg", None)
        value = getattr(section, name) if degrees is None else np.radians(degrees)
        if value is None:
            continue
        key = name if degrees is None else f"{name}_deg"
        array = np.broadcast_to(value, robot.n_joints) if np.ndim(value) == 0 else np.asarray(value, np.float64)
        if len(array) != robot.n_joints:
            reader.fail((*loc, key), f"{robot.name!r} has {robot.n_joints} joints, got {len(array)} numbers")
        else:
            changes[name] = array
    if not changes:
        return robot
    low, high = (np.asarray(changes.get(key, getattr(robot.limits, key))) for key in ("lower", "upper"))
    for j in np.flatnonzero(low > high):
        reader.fail(loc, f"joint {robot.joint_names[j]!r} is left no position: lower {low[j]:g} > upper {high[j]:g}")
    if (low > high).any():
        return None
    return dataclasses.replace(robot, limits=dataclasses.replace(robot.limits, **changes))
