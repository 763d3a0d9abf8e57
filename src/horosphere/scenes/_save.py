"""A scene written as YAML."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path
from typing import Any

import numpy as np

from .._atomic import writing, writing_set
from ..errors import InputError
from ..numeric import file_path
from ..robots import Robot
from ..robots._save import as_yaml
from ._bodies import Aerofoil, EllipsoidND, PointRobot, SnakeRobot, Star
from ._options import ControlOptions, FieldOptions, Options
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
    matrix_quaternion,
)


def save_scene(scene: Any, path: str | Path) -> Path:
    """Writes `scene`, and beside it NAME.robot.yaml where its robot is no file; both are complete or nothing is changed."""
    path = file_path(path, "path")
    texts = texts_of(scene, path)
    with writing_set(path.parent, tuple(texts)) as stage:
        for name, text in texts.items():
            with writing(stage / name) as file:
                file.write(text)
    return path


def texts_of(scene: Any, path: Path) -> dict[str, str]:
    """What `save_scene` writes, by name of the file: the scene, and its robot where that is no file."""
    model = f"{path.stem}.robot.yaml"
    scene_text = dump(document(scene, path.resolve().parent, model))
    return {path.name: scene_text} | ({model: as_yaml(scene.robot)} if _is_model(scene) else {})


def document(scene: Any, folder: Path, model: str = "") -> dict[str, Any]:
    """The fields of the scene file, with paths relative to `folder`; `model`: file of a robot that is none."""
    data: dict[str, Any] = {"horosphere/scene": 1, "name": scene.name}
    if scene.description:
        data["description"] = scene.description
    data["robot"] = {"file": model} if _is_model(scene) else _robot(scene, folder)
    data["start"], data["goal"] = target_fields(scene.start), target_fields(scene.goal)
    specs = scene.origin.obstacles or (None,) * len(scene.obstacles)
    if scene.obstacles:
        data["obstacles"] = [
            _relative(spec, folder) if spec else obstacle_fields(obstacle)
            for spec, obstacle in zip(specs, scene.obstacles, strict=True)
        ]
    if scene.origin.attached and not _is_model(scene):  # a robot file holds what hangs on it, and what it may touch
        data["attached"] = [_relative(spec, folder) for spec in scene.origin.attached]
    if scene.origin.allowed and not _is_model(scene):
        data["allowed_obstacles"] = [list(pair) for pair in scene.origin.allowed]
    if scene.workspace is not None:
        data["workspace"] = {"center": _list(scene.workspace.center), "radius": float(scene.workspace.radius)}
    for key, record in (("options", Options), ("field", FieldOptions), ("control", ControlOptions)):
        values, defaults = getattr(scene, key), record()
        changed = {f.name: getattr(values, f.name) for f in dataclasses.fields(record)}
        changed = {name: value for name, value in changed.items() if value != getattr(defaults, name)}
        if changed:
            data[key] = {name: list(v) if isinstance(v, tuple) else v for name, v in changed.items()}
    return data


def _relative(spec: Any, folder: Path) -> Any:
    if not isinstance(spec, dict):
        return spec
    moved = dict(spec)
    for key in ("urdf", "srdf", "capsules", "file"):
        if isinstance(moved.get(key), str):
            moved[key] = os.path.relpath(moved[key], folder)
    return moved


def _robot(scene: Any, folder: Path) -> Any:
    robot = scene.robot
    if scene.origin.robot is not None:
        return _relative(scene.origin.robot, folder)
    if isinstance(robot, SnakeRobot):
        return {
            "type": "snake",
            "lengths": _list(robot.lengths),
            "wheel_fraction": robot.wheel_fraction,
            "width": robot.width,
        }
    values = dataclasses.asdict(robot)
    del values["name"]
    return {"type": "point" if isinstance(robot, PointRobot) else "unicycle", **values}


def _is_model(scene: Any) -> bool:
    """Is the robot a value of Python, which no file and no name stands for?"""
    return isinstance(scene.robot, Robot) and scene.origin.robot is None


def target_fields(target: Target) -> dict[str, Any]:
    """A start or goal as the fields of the file."""
    if isinstance(target, JointTarget):
        return {"joints": _list(target.q)}
    if isinstance(target, PositionTarget):
        return {"position": _list(target.position)}
    if isinstance(target, GripperPlaneTarget):
        return {"position": _list(target.position), "plane_normal": _list(target.normal)}
    if isinstance(target, PoseTarget):
        return {"position": _list(target.position), "quaternion_wxyz": _list(target.quaternion)}
    if isinstance(target, LineTarget):
        return {"line": {"point": _list(target.point), "direction": _list(target.direction)}}
    if isinstance(target, PlaneTarget):
        return {"plane": {"normal": _list(target.normal), "distance": float(target.distance)}}
    if isinstance(target, HeadingTarget):
        heading = {} if target.heading is None else {"heading": float(target.heading)}
        return {"position": _list(target.position), **heading}
    assert isinstance(target, PostureTarget)
    q = _list(target.q)
    return {"position": q[:2], "heading": q[2], "joints": q[3:]}


def obstacle_fields(o: Any) -> dict[str, Any]:
    """An obstacle as the fields of the file."""
    from .. import shapes

    named = {"name": o.name} if getattr(o, "name", "") else {}
    if isinstance(o, shapes.Ball):
        return {"type": "sphere", **named, "center": _list(o.center), "radius": float(o.radius)}
    if isinstance(o, (shapes.Ellipsoid, EllipsoidND)):
        fields = {"type": "ellipsoid", **named, "center": _list(o.center), "semi_axes": _list(o.semi_axes)}
        if len(o.center) == 2:
            return {**fields, "type": "ellipse", "angle": o.angle}
        return fields | _turn(o.rotation) if len(o.center) == 3 else fields
    if isinstance(o, Aerofoil):
        mu = [float(o.mu.real), float(o.mu.imag)]
        return {"type": "aerofoil", **named, "center": _list(o.center), "k": o.k, "mu": mu, "angle": o.angle}
    if isinstance(o, Star):
        return {
            "type": "star",
            **named,
            **{f: _plain(getattr(o, f)) for f in ("center", "radius", "lobes", "amplitude", "angle")},
        }
    if isinstance(o, (shapes.Capsule, shapes.Cylinder)):
        kind = type(o).__name__.lower()
        return {"type": kind, **named, "a": _list(o.a), "b": _list(o.b), "radius": float(o.radius)}
    if isinstance(o, shapes.Box):
        size = _list(2.0 * np.asarray(o.half_sizes))
        return {"type": "box", **named, "center": _list(o.center), "size": size} | _turn(o.rotation)
    if isinstance(o, shapes.HalfSpace):
        return {"type": "half-space", **named, "normal": _list(o.normal), "distance": float(o.distance)}
    if isinstance(o, shapes.Mesh):
        fill = {} if o.is_watertight else {"fill": "surface"}  # what is open has no inside
        return {"type": "mesh", **named, **fill, "vertices": o.vertices.tolist(), "faces": o.faces.tolist()}
    if isinstance(o, shapes.PointCloud):
        radius = np.unique(o.radius).tolist() if np.ptp(o.radius) == 0.0 else np.asarray(o.radius).tolist()
        values = {"points": np.asarray(o.points).tolist(), "radius": radius[0] if len(radius) == 1 else radius}
        return {"type": "points", **named, **values}
    raise InputError(f"no field of a scene file holds a {type(o).__name__}", place="Scene.obstacles")


def _turn(rotation: Any) -> dict[str, Any]:
    if np.array_equal(rotation, np.eye(3)):
        return {}
    return {"quaternion_wxyz": _list(matrix_quaternion(rotation))}


def _list(array: Any) -> list[float]:
    return [float(x) for x in np.ravel(array)]


def _plain(value: Any) -> Any:
    return _list(value) if isinstance(value, np.ndarray) else value


def dump(data: dict[str, Any]) -> str:
    """YAML text: blocks for the sections, one line for what fits one."""
    lines = []
    for key, value in data.items():
        if isinstance(value, list):
            lines += [f"{key}:"] + [f"  - {_flow(item)}" for item in value]
        elif isinstance(value, str) and "\n" in value:
            lines += [f"{key}: |"] + [f"  {line}".rstrip() for line in value.splitlines()]
        else:
            lines.append(f"{key}: {_flow(value)}")
    return "\n".join(lines) + "\n"


def _flow(value: Any) -> str:
    import yaml

    text = yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=10**9, allow_unicode=True)
    return text.removesuffix("\n").removesuffix("\n...")
