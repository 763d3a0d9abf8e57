"""Files that a scene names: where they are, and meshes and point clouds read from them."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

MESHES = (".stl", ".obj", ".ply")
CLOUDS = (".npy", ".npz", ".csv", ".xyz", ".ply")


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


def _suffix(path: Path, known: tuple[str, ...], what: str) -> str:
    suffix = path.suffix.lower()
    if suffix not in known:
        raise InputError(f"{path.name!r}: no {what} is read from {suffix or 'a file without ending'!r}", choices=known)
    return suffix


def read_mesh(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices (v, 3) and triangles (f, 3) of an STL, OBJ or PLY file."""
    import trimesh

    _suffix(path, MESHES, "mesh")
    try:
        mesh = trimesh.load(path, force="mesh", process=False)  # processing drops what is not finite
        vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)  # type: ignore[union-attr]
    except Exception as error:
        raise InputError(f"{path.name!r} cannot be read as a mesh: {error}") from None
    if not np.isfinite(vertices).all():
        raise InputError(
            f"{path.name!r}: vertex {int(np.argwhere(~np.isfinite(vertices))[0, 0])} is not finite", remedy="repair it"
        )
    if not len(faces):
        raise InputError(f"{path.name!r} holds no triangles", remedy="expected an STL, OBJ or PLY file with faces")
    return vertices, faces


def read_cloud(path: Path) -> NDArray[np.float64]:
    """Points (m, 3) of an NPY, NPZ (array `points`, or the only one), CSV/XYZ text or PLY file."""
    suffix = _suffix(path, CLOUDS, "point cloud")
    try:
        if suffix == ".npy":
            points = np.load(path, allow_pickle=False)
        elif suffix == ".npz":
            with np.load(path, allow_pickle=False) as archive:
                points = archive["points" if "points" in archive.files else archive.files[0]]
        elif suffix == ".ply":
            import trimesh

            points = trimesh.load(path, process=False).vertices  # type: ignore[union-attr]
        else:
            points = _text(path)
        points = np.asarray(points, dtype=np.float64)
    except Exception as error:
        raise InputError(f"{path.name!r} cannot be read as a point cloud: {error}") from None
    if not points.size:
        raise InputError(f"{path.name!r} holds no points", remedy="leave an empty cloud out")
    if points.ndim != 2 or points.shape[1] < 3 or not len(points):
        raise InputError(f"{path.name!r}: expected points (m, 3), got shape {points.shape}")
    if not np.isfinite(points[:, :3]).all():
        raise InputError(f"{path.name!r}: point {int(np.argwhere(~np.isfinite(points[:, :3]))[0, 0])} is not finite")
    return points[:, :3]


def _text(path: Path) -> NDArray[np.float64]:
    lines = path.read_text(encoding="utf-8").replace(",", " ").replace(";", " ").splitlines()
    rows = [line.split() for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if rows and not _is_number(rows[0][0]):
        rows = rows[1:]  # a header
    return np.array([[float(x) for x in row[:3]] for row in rows])


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
