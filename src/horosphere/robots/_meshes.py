"""Collision geometry of a URDF link as capsules; where its meshes are on this disk."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from . import _bodies, _placement
from ._bodies import Body
from ._urdf import Shape, Urdf


def link_bodies(urdf: Urdf, link: str) -> tuple[list[Body], list[str]]:
    """Capsules round the collision geometry of a link, in its frame, and what could not be read."""
    bodies: list[Body] = []
    problems: list[str] = []
    for shape in urdf.collisions[link]:
        if shape.kind == "sphere":
            found = _bodies.from_sphere(*shape.sizes)
        elif shape.kind == "cylinder":
            found = _bodies.from_cylinder(*shape.sizes)
        elif shape.kind == "box":
            found = _bodies.from_box(np.array(shape.sizes))
        else:
            found, problem = _mesh_bodies(urdf, shape)
            if problem:
                problems.append(problem)
        rotation, translation = _placement.rotation_translation(shape.origin)
        bodies += [body.moved(rotation, translation) for body in found]
    return bodies, problems


def _mesh_bodies(urdf: Urdf, mesh: Shape) -> tuple[list[Body], str]:
    path = resolve(mesh.filename, urdf.path)
    if path is None:
        return [], f"mesh {mesh.filename} not found"
    import trimesh

    try:
        loaded = trimesh.load(str(path), force="mesh")
        vertices = np.asarray(loaded.vertices, float) * np.array(mesh.sizes)
        if not len(loaded.faces) or not np.isfinite(vertices).all():
            return [], f"mesh {mesh.filename} is empty or not finite"
        return _bodies.from_triangles(vertices, np.asarray(loaded.faces, np.int64)), ""
    except Exception as error:  # a reader of any of a dozen formats may fail in any way; the robot stays usable
        return [], f"mesh {mesh.filename} cannot be read ({type(error).__name__}: {error})"


def resolve(filename: str, urdf: Path) -> Path | None:
    """Local path of a mesh file name of a URDF, or None: `package://`, `file://`, absolute, or beside the file; never
    downloads.

    `package://name/rest` is looked up in every folder above the URDF (as `name/rest`, and as `rest` in a folder
    called `name`), then in ROS_PACKAGE_PATH.
    """
    if filename.startswith("package://"):
        package, _, rest = filename.removeprefix("package://").partition("/")
        candidates = []
        for folder in urdf.resolve().parents:
            candidates.append(folder / package / rest)
            if folder.name == package:
                candidates.append(folder / rest)
        for text in filter(None, os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)):
            candidates.append(Path(text) / package / rest)
            if Path(text).name == package:
                candidates.append(Path(text) / rest)
    elif "://" in filename and not filename.startswith("file://"):
        return None
    else:
        candidates = [urdf.resolve().parent / filename.removeprefix("file://")]
    return next((path for path in candidates if path.is_file()), None)
