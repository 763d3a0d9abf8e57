"""A mesh enclosed in boxes: for whatever does not take triangles, with the slack stated."""

from __future__ import annotations

from typing import NamedTuple, cast
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import whole_number
from ._base import Floats
from ._flat import Box
from ._sampled import Mesh

FINEST = 96
"""Cells along the longest side of the mesh at first."""


class BoxCover(NamedTuple):
    """Boxes that hold a mesh and all that it encloses, and how far (m) a point of them can be from it at most."""

    boxes: tuple[Box, ...]
    slack: float


_known: WeakKeyDictionary[Mesh, dict[int, BoxCover]] = WeakKeyDictionary()


def box_cover(mesh: Mesh, most: int = 400) -> BoxCover:
    """At most `most` boxes: cells that the mesh meets, on a grid in its least box and as fine as that allows, joined.

    A closed mesh is filled, an open one is not. Every cell meets the mesh or lies within, so the slack is a cell's diagonal.
    Raises InputError for less than one box.
    """
    if not isinstance(mesh, Mesh):
        raise InputError(f"expected a Mesh, got {type(mesh).__name__}", place="mesh")
    most = whole_number(most, "most", 1)
    kept = _known.setdefault(mesh, {})
    if most not in kept:
        kept[most] = _cover(mesh, most)
    return kept[most]


def _cover(mesh: Mesh, most: int) -> BoxCover:
    axes, low, extent = _least_box(mesh.vertices)
    triangles = (mesh.vertices @ axes - low)[mesh.faces]
    finest = float(FINEST)
    while True:
        counts = np.maximum(np.ceil(extent / (extent.max() / finest) - 1e-9), 1.0).astype(np.int64)
        size = np.maximum(extent / counts, 1e-9)
        corners = _joined(_filled(mesh, triangles, axes, low, size, counts), most)
        if corners is not None or finest <= 1.0:
            break
        finest *= 0.8
    boxes = []
    for first, last in [(np.zeros(3), counts)] if corners is None else corners:
        half = 0.5 * (last - first) * size
        boxes.append(Box(axes @ (low + first * size + half), half * (1.0 + 1e-12), axes, name=mesh.name))
    return BoxCover(tuple(boxes), float(np.linalg.norm(size)))


def _least_box(vertices: Floats) -> tuple[Floats, Floats, Floats]:
    """Axes (columns), least corner along them, and side lengths of a small box: the world's axes unless others are better."""
    from trimesh.bounds import oriented_bounds

    extent = np.ptp(vertices, axis=0)
    best = np.eye(3), vertices.min(axis=0), extent
    try:
        axes = np.array(oriented_bounds(vertices)[0])[:3, :3].T
    except Exception:  # flat or needle-like: no hull
        return best
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    axes = np.linalg.svd(axes)[0] @ np.linalg.svd(axes)[2]  # a rotation to the last bit
    placed = vertices @ axes
    if np.ptp(placed, axis=0).prod() < 0.98 * extent.prod():
        best = axes, placed.min(axis=0), np.ptp(placed, axis=0)
    return best


def _filled(
    mesh: Mesh, triangles: Floats, axes: Floats, low: Floats, size: Floats, counts: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """The cells that the mesh meets or encloses: free cells that hang together lie all within or all without."""
    from scipy.ndimage import label

    from ._cell_kernels import mark_cells

    grid = np.zeros(tuple(counts), np.bool_)
    mark_cells(np.ascontiguousarray(triangles), size, grid)
    free, count = cast("tuple[NDArray[np.int64], int]", label(~grid))
    if count:
        _, at = np.unique(free.ravel(), return_index=True)
        cells = np.stack(np.unravel_index(at, grid.shape), axis=1)
        centres = (low + (cells + 0.5) * size) @ axes.T
        inside = mesh.signed_distance(centres) < 0.0
        inside[free[tuple(cells.T)] == 0] = True
        grid = inside[np.searchsorted(free[tuple(cells.T)], free)]
    return grid


def _joined(grid: NDArray[np.bool_], most: int) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]] | None:
    """Boxes of cells, first and last + 1, that hold every true one and no other; None if it takes more than `most`."""
    bare, found = grid.copy(), []
    flat = bare.reshape(-1)
    at = 0
    while True:
        at += int(np.argmax(flat[at:]))
        if not flat[at]:
            return found
        if len(found) == most:
            return None
        first, last = _grown(grid, np.array(np.unravel_index(at, grid.shape)))
        bare[tuple(slice(a, b) for a, b in zip(first, last))] = False
        found.append((first, last))


def _grown(grid: NDArray[np.bool_], first: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The cell `first` grown by true cells, layer by layer on every side in turn, so that it becomes compact."""
    last = first + 1
    sides = [(axis, up) for axis in range(3) for up in (True, False)]
    while sides:
        for axis, up in list(sides):
            lower, upper = first.copy(), last.copy()
            lower[axis], upper[axis] = (last[axis], last[axis] + 1) if up else (first[axis] - 1, first[axis])
            fits = lower[axis] >= 0 and upper[axis] <= grid.shape[axis]
            if fits and grid[tuple(slice(a, b) for a, b in zip(lower, upper))].all():
                first, last = np.minimum(first, lower), np.maximum(last, upper)
            else:
                sides.remove((axis, up))
    return first, last
