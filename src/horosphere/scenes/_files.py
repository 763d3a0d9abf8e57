"""Files that a scene names: where they are, and meshes read from them."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._whole import require_whole
from ..errors import InputError

MESHES = (".stl", ".obj", ".ply")


def resolve(name: str, folder: Path) -> Path:
    """The file `name` of a scene in `folder`; `package://NAME/...` is looked up upwards from there, then in ROS_PACKAGE_PATH.

    Raises InputError if there is no such file, naming where it was looked for.
    """
    if name.startswith("package://"):
        inside = name.removeprefix("package://")
        package, _, rest = inside.partition("/")
        roots = [Path(p) for p in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if p]
        looked = [f / inside for f in (folder, *folder.parents)]
        looked += [path for root in roots for path in (root / inside, *([root / rest] if root.name == package else []))]
        for path in looked:
            if path.is_file():
                return path.resolve()
        raise InputError(
            f"no package {package!r} with {rest!r} beside the scene, in a folder above it, or in ROS_PACKAGE_PATH",
            remedy="set ROS_PACKAGE_PATH, or write the path relative to the scene file",
        )
    path = (folder / Path(name.removeprefix("file://")).expanduser()).resolve()
    if not path.is_file():
        what = "is a folder" if path.is_dir() else "does not exist"
        raise InputError(f"file {name!r} {what} (looked at {path})", remedy="paths are relative to the scene file")
    return path


def suffix_of(path: Path, known: tuple[str, ...], what: str) -> str:
    """The ending of a file, one of `known`."""
    suffix = path.suffix.lower()
    if suffix not in known:
        raise InputError(f"{path.name!r}: no {what} is read from {suffix or 'a file without ending'!r}", choices=known)
    return suffix


def read_mesh(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices (v, 3) and triangles (f, 3) of an STL, OBJ or PLY file. Raises InputError if it cannot be read or is not whole."""
    import trimesh

    suffix = suffix_of(path, MESHES, "mesh")
    try:
        require_whole(path.read_bytes(), suffix)
        mesh = trimesh.load(path, force="mesh", process=False)  # processing drops what is not finite
        vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)  # type: ignore[union-attr]
    except InputError as error:
        raise InputError(f"{path.name!r} cannot be read as a mesh: {error.message}", remedy=error.remedy) from None
    except Exception as error:
        remedy = "if its faces have different numbers of corners, triangulate it" if suffix == ".ply" else None
        raise InputError(f"{path.name!r} cannot be read as a mesh: {error}", remedy=remedy) from None
    if not np.isfinite(vertices).all():
        raise InputError(
            f"{path.name!r}: vertex {int(np.argwhere(~np.isfinite(vertices))[0, 0])} is not finite", remedy="repair it"
        )
    if not len(faces):
        raise InputError(
            f"{path.name!r} holds no triangles", remedy="expected an STL, OBJ or PLY file with faces; was it cut off?"
        )
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise InputError(
            f"{path.name!r}: a face names a vertex that is not one of the {len(vertices):,}", remedy="repair it"
        )
    return vertices, faces
