"""From a scene file to a `Scene`, or to one error with everything that is wrong."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from . import _schema as s
from ._arms import STAND_INS, read_robot
from ._bodies import Aerofoil, EllipsoidND, Star, Workspace
from ._checks import problems
from ._files import read_cloud, read_mesh, resolve
from ._library import locate
from ._options import ControlOptions, FieldOptions, Options
from ._problems import Reader
from ._scene import Origin, Scene
from ._targets import quaternion_matrix, rpy_quaternion
from ._targets_read import angle, half_space, read_target, rotation
from ._yaml import Loc, read_yaml

VERSION = "horosphere/scene"
FIELDS = (
    VERSION,
    "name",
    "description",
    "robot",
    "start",
    "goal",
    "obstacles",
    "workspace",
    "options",
    "field",
    "control",
)


def load_scene(path: str | Path) -> Scene:
    """The scene in a file, or the built-in one of that name.

    Raises SceneError: every problem as file:line:column with the field, what is allowed and what came.
    """
    file = locate(path)
    reader = Reader(read_yaml(file))
    data = reader.document.data
    if not isinstance(data, dict):
        reader.fail((), "expected the fields of a scene", remedy=f"a scene starts with `{VERSION}: 1`")
        reader.finish()
    _header(reader, data)
    folder = file.resolve().parent
    robot, robot_spec = (None, None)
    if "robot" in data:
        robot, robot_spec = read_robot(reader, data["robot"], data.get("start"), folder)
    written = data.get("robot")
    target_robot = STAND_INS.get(str(written.get("type"))) if robot is None and isinstance(written, dict) else robot
    targets = {
        name: read_target(reader, data[name], (name,), target_robot) if name in data else None
        for name in ("start", "goal")
    }
    obstacles, specs = _obstacles(reader, data.get("obstacles"), folder)
    options = _options(reader, Options, s.OptionFields, data.get("options"), "options")
    field = _options(reader, FieldOptions, s.FieldFields, data.get("field"), "field")
    control = _options(reader, ControlOptions, s.ControlFields, data.get("control"), "control")
    wall = data.get("workspace") and reader.section(s.WorkspaceFields, data["workspace"], ("workspace",))
    workspace = Workspace(wall.center, wall.radius) if wall else None  # type: ignore[arg-type]
    if robot is not None:
        for problem in problems(robot, targets["start"], targets["goal"], tuple(obstacles), workspace, field):
            reader.problems.append(_as_written(problem, data))
    reader.finish()
    return Scene(
        robot=robot,  # type: ignore[arg-type]
        start=targets["start"],  # type: ignore[arg-type]
        goal=targets["goal"],  # type: ignore[arg-type]
        obstacles=tuple(obstacles),
        name=str(data.get("name") or file.stem),
        options=options,
        field=field,
        control=control,
        workspace=workspace,
        description=str(data.get("description") or "").strip(),
        source=str(file.resolve()),
        origin=Origin(robot_spec, tuple(specs)),
    )


def _header(reader: Reader, data: dict) -> None:
    if VERSION not in data:
        reader.fail((), f"the field {VERSION!r} is missing", remedy=f"begin the file with `{VERSION}: 1`")
    elif data[VERSION] != 1 or isinstance(data[VERSION], bool):
        reader.fail((VERSION,), f"version {data[VERSION]!r} is not known", choices=("1",))
    for key in data:
        if key not in FIELDS:
            reader.unknown((key,), "field", key, FIELDS, at_key=True)
    for key in ("robot", "start", "goal"):
        if key not in data:
            reader.fail((), f"missing field {key!r}")
    for key in ("name", "description"):
        if data.get(key) is not None and not isinstance(data[key], str):
            reader.fail((key,), f"expected a text, got {data[key]!r}")


def _as_written(problem: Any, data: dict) -> Any:
    """The problem at the field that is in the file (`joints_deg` for `joints`)."""
    loc = problem.loc
    if len(loc) == 2 and isinstance(data.get(loc[0]), dict) and loc[1] not in data[loc[0]]:
        other = f"{loc[1]}_deg"
        loc = (loc[0], other) if other in data[loc[0]] else loc[:1]
    return dataclasses.replace(problem, loc=loc)


def _options(reader: Reader, record: Any, model: Any, data: Any, key: str) -> Any:
    if data is None:
        return record()
    section = reader.section(model, data, (key,))
    if section is None:
        return record()
    values = section.model_dump(exclude_none=True)
    if "max_joint_step_deg" in values:
        values["max_joint_step"] = math.radians(values.pop("max_joint_step_deg"))
    if isinstance(values.get("exponents"), list):
        values["exponents"] = tuple(values["exponents"])
    return record(**values)


def _obstacles(reader: Reader, data: Any, folder: Path) -> tuple[list[Any], list[Any]]:
    if data is None:
        return [], []
    if not isinstance(data, list):
        reader.fail(("obstacles",), "expected a list of obstacles")
        return [], []
    found, specs = [], []
    for i, item in enumerate(data):
        loc: Loc = ("obstacles", i)
        spec = dict(item) if isinstance(item, dict) else None
        try:
            found.append(_obstacle(reader, item, loc, folder))
        except InputError as error:
            reader.caught(loc, error)
            found.append(None)
        if spec and isinstance(spec.get("file"), str) and found[-1] is not None:
            spec["file"] = str(resolve(spec["file"], folder))
        specs.append(spec)
    return found, specs


def _obstacle(reader: Reader, item: Any, loc: Loc, folder: Path) -> Any:
    if not isinstance(item, dict):
        return reader.fail(loc, "expected fields, one of them 'type'", choices=s.OBSTACLES)
    kind = item.get("type")
    if kind is None:
        return reader.fail(loc, "missing field 'type'", choices=s.OBSTACLES)
    if kind not in s.OBSTACLES:
        return reader.unknown((*loc, "type"), "obstacle type", kind, s.OBSTACLES)
    section = reader.section(s.OBSTACLES[kind], item, loc)
    if section is None:
        return None
    if isinstance(section, s.Points) and section.file is not None:
        return _cloud(section, read_cloud(resolve(section.file, folder)))
    if isinstance(section, s.Mesh) and section.file is not None:
        vertices, faces = read_mesh(resolve(section.file, folder))
        return _mesh(section, vertices, faces)
    return _solid(section)


def _solid(o: Any) -> Any:
    if isinstance(o, s.Sphere):
        return _shape("Ball", o.center, o.radius, name=o.name)
    if isinstance(o, s.Ellipsoid):
        return _ellipsoid(o)
    if isinstance(o, s.Ellipse):
        turn = angle(o.angle, o.angle_deg) or 0.0
        c, t = math.cos(turn), math.sin(turn)
        return EllipsoidND(o.center, o.semi_axes, np.array([[c, -t], [t, c]]), o.name)  # type: ignore[arg-type]
    if isinstance(o, s.AerofoilFields):
        return Aerofoil(o.center, o.k, complex(*o.mu), angle(o.angle, o.angle_deg) or 0.0, o.name)  # type: ignore[arg-type]
    if isinstance(o, s.StarFields):
        turn = angle(o.angle, o.angle_deg) or 0.0
        return Star(o.center, o.radius, o.lobes, o.amplitude, turn, o.name)  # type: ignore[arg-type]
    if isinstance(o, s.Capsule):
        return _shape("Capsule", o.a, o.b, o.radius, name=o.name)
    if isinstance(o, s.Cylinder):
        a, b = (o.a, o.b) if o.center is None else _ends(o)
        return _shape("Cylinder", a, b, o.radius, name=o.name)
    if isinstance(o, s.Box):
        return _shape("Box", o.center, 0.5 * np.array(o.size), quaternion_matrix(_turn(o)), name=o.name)
    if isinstance(o, s.HalfSpace):
        return _shape("HalfSpace", *half_space(o), name=o.name)
    if isinstance(o, s.Mesh):
        return _mesh(o, np.array(o.vertices), np.array(o.faces, np.int64))
    return _cloud(o, np.array(o.points))


def _cloud(o: s.Points, points: np.ndarray) -> Any:
    if isinstance(o.radius, list) and len(o.radius) != len(points):
        raise InputError(f"radius: {len(o.radius)} numbers for {len(points)} points")
    return _shape("PointCloud", points, o.radius, name=o.name)


def _shape(kind: str, *values: Any, name: str) -> Any:
    from .. import shapes

    return getattr(shapes, kind)(*values, name=name)


def _turn(section: Any) -> np.ndarray:
    quaternion = rotation(section)
    return rpy_quaternion(np.zeros(3)) if quaternion is None else quaternion


def _ends(o: s.Cylinder) -> tuple[np.ndarray, np.ndarray]:
    axis, length = np.array(o.axis), float(np.linalg.norm(o.axis))  # type: ignore[arg-type]
    if length < 1e-12:
        raise InputError("axis: expected a direction, got the zero vector")
    half = 0.5 * float(o.length) * axis / length  # type: ignore[arg-type]
    return np.array(o.center) - half, np.array(o.center) + half


def _ellipsoid(o: s.Ellipsoid) -> Any:
    n = len(o.center)
    if len(o.semi_axes) != n:
        raise InputError(f"semi_axes: expected {n} numbers as in center, got {len(o.semi_axes)}")
    turned = rotation(o)
    if n == 3:
        return _shape("Ellipsoid", o.center, o.semi_axes, quaternion_matrix(_turn(o)), name=o.name)
    if turned is not None:
        raise InputError(
            f"a rotation by quaternion or rpy belongs to three dimensions, the center has {n}",
            remedy="in the plane use type ellipse with angle",
        )
    return EllipsoidND(o.center, o.semi_axes, None, o.name)  # type: ignore[arg-type]


def _mesh(o: s.Mesh, vertices: np.ndarray, faces: np.ndarray) -> Any:
    placed = o.scale * vertices @ quaternion_matrix(_turn(o)).T + np.array(o.position)
    return _shape("Mesh", placed, faces, name=o.name)
