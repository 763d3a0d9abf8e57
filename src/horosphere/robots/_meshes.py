"""Mesh files of a URDF: where they are on this disk, and their triangles."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from .._whole import require_whole
from ..errors import InputError
from ._bodies import Floats
from ._kept import digest

ALONE = (".stl", ".obj", ".ply", ".dae", ".off", ".glb")
"""Formats whose triangles stand in the file itself."""
FORMATS = (".stl", ".obj", ".ply", ".dae", ".off", ".glb", ".gltf", ".3mf")


def read_triangles(filename: str, scale: tuple[float, ...], urdf: Path) -> Floats:
    """Corners (t, 3, 3) of the triangles of a mesh that a URDF names, scaled; metres.

    The unit that a COLLADA file states is applied, as ROS does; its up-axis is not. Raises InputError with the reason.
    """
    path = resolve(filename, urdf)
    if path is None:
        raise InputError(
            f"mesh {filename} not found (set ROS_PACKAGE_PATH, or put it beside the URDF)",
            remedy="set ROS_PACKAGE_PATH, or put it beside the URDF",
        )
    import trimesh

    try:
        require_whole(path.read_bytes(), path.suffix)
        loaded = trimesh.load(str(path), force="mesh", process=False)
        faces = np.asarray(loaded.faces, np.int64)  # type: ignore[union-attr]
        if faces.min(initial=0) < 0:
            raise InputError("a face names a vertex below zero")
        triangles = np.asarray(loaded.vertices, np.float64)[faces]  # type: ignore[union-attr]
    except InputError as error:
        raise InputError(f"mesh {filename} cannot be read: {error.message}", remedy=error.remedy) from None
    except Exception as error:  # a reader of any of a dozen formats may fail in any way
        if path.suffix.lower() == ".dae" and isinstance(error, ImportError | ValueError):
            error = type(error)(f"{error}; COLLADA files need the package pycollada")
        why = f"{type(error).__name__}: {error}" if path.suffix.lower() in FORMATS else f"no mesh format: {path.suffix}"
        raise InputError(f"mesh {filename} cannot be read ({why})", choices=FORMATS) from None
    if not len(triangles):
        raise InputError(f"mesh {filename} holds no triangles")
    if not np.isfinite(triangles).all():
        bad = int(np.argwhere(~np.isfinite(triangles))[0, 0])
        raise InputError(f"mesh {filename}: triangle {bad} has a corner that is not finite")
    return triangles * np.array(scale) * _unit(path)


def content_of(filename: str, scale: tuple[float, ...], urdf: Path) -> str | None:
    """A key of all that the triangles of a mesh depend on, without reading them; None if it cannot be told so."""
    path = resolve(filename, urdf)
    if path is None or path.suffix.lower() not in ALONE:
        return None
    try:
        return digest(path.suffix.lower(), path.read_bytes(), scale)
    except OSError:
        return None


def _unit(path: Path) -> float:
    if path.suffix.lower() != ".dae":
        return 1.0
    found = re.search(rb"<unit\b[^>]*\bmeter=[\"']([0-9.eE+-]+)[\"']", path.read_bytes()[:20_000])
    return float(found.group(1)) if found else 1.0


def resolve(filename: str, urdf: Path) -> Path | None:
    """Local path of a mesh file name of a URDF, or None: `package://`, `model://`, `file://`, absolute, or beside the file;
    never downloads.

    `package://name/rest` is looked up in every folder above the URDF (as `name/rest`, as `rest` in a folder called `name` or
    with a `package.xml` of that name), then in ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.
    """
    scheme, _, inside = filename.partition("://")
    if inside and scheme in ("package", "model"):
        package, _, rest = inside.partition("/")
        candidates = []
        for folder in urdf.resolve().parents:
            candidates.append(folder / package / rest)
            if folder.name == package or _is_package(folder, package):
                candidates.append(folder / rest)
        for text in filter(None, os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)):
            candidates.append(Path(text) / package / rest)
            if Path(text).name == package:
                candidates.append(Path(text) / rest)
        for text in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
            candidates.append(Path(text) / "share" / package / rest)
    elif inside and scheme != "file":
        return None
    else:
        candidates = [urdf.resolve().parent / filename.removeprefix("file://")]
    return next((path for path in candidates if path.is_file()), None)


def _is_package(folder: Path, name: str) -> bool:
    try:
        return (
            re.search(rf"<name>\s*{re.escape(name)}\s*</name>", (folder / "package.xml").read_text("utf-8")) is not None
        )
    except (OSError, UnicodeDecodeError):
        return False
