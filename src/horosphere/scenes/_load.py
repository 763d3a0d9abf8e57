"""From a scene file to a `Scene`, or to one error with everything that is wrong."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from . import _schema as s
from ._arms import read_robot, stand_in
from ._bodies import Workspace
from ._checks import AS_DEGREES, problems
from ._held import read_allowed, read_held
from ._library import locate
from ._moveit_files import ProblemSet, from_document, is_archive, is_moveit, split
from ._moveit_robot import robot_for
from ._obstacles_read import read_obstacles
from ._options import ControlOptions, FieldOptions, Options
from ._problems import Reader
from ._scene import Origin, Scene
from ._targets_read import read_target
from ._yaml import Document, read_yaml

if TYPE_CHECKING:
    from ..robots import Robot

VERSION = "horosphere/scene"
ROBOT = "horosphere/robot"
_FIRST_SCENE = "`horosphere robot FILE --scene first.yaml` writes a first scene for it"
FIELDS = (
    VERSION,
    "name",
    "description",
    "robot",
    "start",
    "goal",
    "obstacles",
    "attached",
    "allowed_obstacles",
    "workspace",
    "options",
    "field",
    "control",
)


def load_scene(
    path: str | Path,
    robot: Robot | str | Path | None = None,
    tip: str | None = None,
    srdf: str | Path | None = None,
    request: str | Path | None = None,
) -> Scene:
    """The scene in a file, the built-in one of that name, or that of a MoveIt problem: see `Scene.load`.

    Raises SceneError: every problem as file:line:column with the field, what is allowed and what came.
    """
    place, name = split(path)
    if name or is_archive(place):
        found = ProblemSet.read(place)
        name = found.find(name)
        problem = found.problem(found.scenes[name], request)
        return problem.scene(robot_for(problem, robot, tip, srdf), name=name.replace("/", "-"))
    file = locate(path)
    if file.suffix.lower() == ".urdf":
        raise InputError("a robot, expected a scene", place=str(path), remedy=_FIRST_SCENE)
    document = read_yaml(file)
    if is_moveit(document.data):
        problem = from_document(file, document, request)
        return problem.scene(robot_for(problem, robot, tip, srdf), source=str(file.resolve()))
    given = {"robot": robot, "tip": tip, "srdf": srdf, "request": request}
    if any(value is not None for value in given.values()):
        extra = ", ".join(f"`{key}`" for key, value in given.items() if value is not None)
        raise InputError(
            f"{extra}: for MoveIt scenes, and this is none",
            place=str(path),
            remedy="a scene of ours says it itself (docs/scenes.md)",
        )
    return _own_scene(file, document)


def _own_scene(file: Path, document: Document) -> Scene:
    reader = Reader(document)
    data = reader.document.data
    if not isinstance(data, dict):
        reader.fail((), "expected the fields of a scene", remedy=f"a scene starts with `{VERSION}: 1`")
        reader.finish()
    if VERSION not in data and ROBOT in data:
        reader.fail((), "a robot, expected a scene", remedy=_FIRST_SCENE)
        reader.finish()
    _header(reader, data)
    folder = file.resolve().parent
    robot, robot_spec = (None, None)
    if "robot" in data:
        robot, robot_spec = read_robot(reader, data["robot"], data.get("start"), folder)
    target_robot, dimension = (robot, None) if robot is not None else stand_in(data.get("robot"))
    targets = {
        name: read_target(reader, data[name], (name,), target_robot) if name in data else None
        for name in ("start", "goal")
    }
    obstacles, specs = read_obstacles(reader, data.get("obstacles"), folder)
    robot, held = read_held(reader, data.get("attached"), robot, folder)
    robot, allowed = read_allowed(reader, data.get("allowed_obstacles"), robot, obstacles)
    options = _options(reader, Options, s.OptionFields, data.get("options"), "options")
    field = _options(reader, FieldOptions, s.FieldFields, data.get("field"), "field")
    control = _options(reader, ControlOptions, s.ControlFields, data.get("control"), "control")
    wall = data.get("workspace") and reader.section(s.WorkspaceFields, data["workspace"], ("workspace",))
    workspace = Workspace(wall.center, wall.radius) if wall else None  # type: ignore[arg-type]
    found = problems(robot, targets["start"], targets["goal"], tuple(obstacles), workspace, field, dimension)
    reader.problems += [_as_written(problem, data) for problem in found]
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
        origin=Origin(robot_spec, tuple(specs), held, allowed),
        notes=tuple(reader.notes),
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
    remedy = None if problem.remedy == AS_DEGREES and loc[-1] == "joints_deg" else problem.remedy
    return dataclasses.replace(problem, loc=loc, remedy=remedy)


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
