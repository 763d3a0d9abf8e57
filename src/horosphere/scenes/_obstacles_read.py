"""Obstacles of a scene file as shapes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from . import _schema as s
from ._bodies import Aerofoil, EllipsoidND, Star
from ._clouds import read_cloud
from ._files import read_mesh, resolve
from ._problems import Reader, likely
from ._targets import quaternion_matrix, rpy_quaternion
from ._targets_read import angle, half_space, rotation
from ._yaml import Loc

HUGE = 20.0  # metres: an obstacle from a file that is larger may be in millimetres


def read_obstacles(reader: Reader, data: Any, folder: Path) -> tuple[list[Any], list[Any]]:
    """The obstacles, None for what cannot be read (the problems noted), and how they were written, with absolute paths."""
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
            found.append(read_obstacle(reader, item, loc, folder))
        except InputError as error:
            reader.caught(loc, error)
            found.append(None)
        if spec and isinstance(spec.get("file"), str) and found[-1] is not None:
            spec["file"] = str(resolve(spec["file"], folder))
        specs.append(spec)
    return found, specs


def read_obstacle(reader: Reader, item: Any, loc: Loc, folder: Path, also: tuple[str, ...] = ()) -> Any:
    """One obstacle, or None with the problems noted; `also`: further fields that messages name as valid."""
    if not isinstance(item, dict):
        return reader.fail(loc, "expected fields, one of them 'type'", choices=s.OBSTACLES)
    kind = item.get("type")
    if kind is None:
        return reader.fail(loc, "missing field 'type'", choices=s.OBSTACLES)
    if not isinstance(kind, str) or kind not in s.OBSTACLES:
        reader.unknown((*loc, "type"), "obstacle type", kind, s.OBSTACLES)
        meant = likely(kind, s.OBSTACLES)
        return None if meant is None else reader.look(s.OBSTACLES[meant], item, loc, also)
    section = reader.section(s.OBSTACLES[kind], item, loc, also)
    if section is None:
        return None
    if isinstance(section, s.Points) and section.file is not None:
        points, notes = read_cloud(resolve(section.file, folder))
        reader.notes += notes
        reader.notes += _size_note(section, points)
        return _cloud(section, points)
    if isinstance(section, s.Mesh) and section.file is not None:
        vertices, faces = read_mesh(resolve(section.file, folder))
        reader.notes += _size_note(section, vertices)
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
        return _mesh(o, np.array(o.vertices), np.array(o.faces))
    return _cloud(o, np.array(o.points))


def _cloud(o: s.Points, points: np.ndarray) -> Any:
    if isinstance(o.radius, list) and len(o.radius) != len(points):
        raise InputError(f"radius: {len(o.radius)} numbers for {len(points)} points")
    return _shape("PointCloud", _placed(o, points), o.radius, name=o.name)


def _placed(o: s.Points | s.Mesh, points: np.ndarray) -> np.ndarray:
    """Points (m, 3) of the obstacle's own frame, scaled, turned, moved."""
    return o.scale * points @ quaternion_matrix(_turn(o)).T + np.array(o.position)


def _size_note(o: s.Points | s.Mesh, points: np.ndarray) -> list[str]:
    """Files in millimetres are read as metres: what is very large is said."""
    size = o.scale * np.ptp(points, axis=0).max(initial=0.0)
    if size < HUGE:
        return []
    return [f"{o.file}: {size:,.0f} m long; are these millimetres? Then write scale: {1e-3 * o.scale:g}"]


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
    mesh = _shape("Mesh", _placed(o, vertices), faces, name=o.name)
    if o.fill == "hull":
        return mesh.hull()
    edges = mesh.open_edges() if o.fill == "solid" else np.zeros((0, 2, 3))
    if len(edges):
        at = np.round(edges[0].mean(axis=0), 4).tolist()
        raise InputError(
            f"the mesh is not watertight: {len(edges)} of its edges do not lie between two faces, the first at {at}",
            remedy="repair it; or fill: hull takes its convex hull, fill: surface its triangles without an inside",
        )
    return mesh
