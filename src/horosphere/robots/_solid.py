"""A mesh made ready to be covered: its surface and what it encloses in small pieces, and how deep a point lies in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..shapes import Mesh

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
CELLS = 150_000
"""Cells of the grid over the box of a mesh, about."""
FINE = 1.7
"""Longest edge, in cells, of the triangles that mark the grid with their corners and the middles of their edges: no point of one
is half a cell from all of these, so a walk from cell to cell through their faces cannot slip through the surface."""
SKIN = 1.8
"""Cells from the surface where depth is that of the mesh."""
_CORNERS = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8).T
BLOCK = 3
"""Cells along the side of a box over what is enclosed."""


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A triangle soup with what it encloses; metres.

    A cover is conservative if it holds `boxes` (b, 8, 3), the corners of boxes over the enclosed cells of a grid, and `triangles`
    (t, 3, 3), the rest of the surface. Enclosed is what cannot be reached from outside through the faces of cells without
    surface: voids, and pockets with an opening narrower than about two cells, count as solid.

    Attributes: `inside` (c, 3) middles of the enclosed cells; `cell` (m) side of the grid; `field` depth at its cells, about,
    negative outside, and `middle` (3,) of its first cell.
    """

    triangles: Floats
    boxes: Floats
    inside: Floats
    cell: float
    field: Floats
    middle: Floats
    _enclosed: NDArray[np.bool_]
    _whole: Mesh
    _outer: Mesh

    def depth(self, x: Floats) -> Floats:
        """Lower bound (m,) of the depth of points (m, 3) in the solid; outside, minus their distance to it or less: from
        the mesh where it is closed, and for enclosed points the distance to its outer triangles."""
        signed = self._whole.signed_distance(x)
        deep = self._encloses(x)
        if self._outer is self._whole:
            return np.where(deep, np.abs(signed), -signed)
        result = -signed
        if deep.any():
            result[deep] = np.maximum(result[deep], np.abs(self._outer.signed_distance(x[deep])))
        return result

    def away(self, x: Floats) -> Floats:
        """Distance (m,) of points (m, 3) to the solid, or more; 0 inside."""
        out = np.zeros(len(x))
        rest = ~self._encloses(x)
        out[rest] = np.maximum(self._whole.signed_distance(x[rest]), 0.0)
        return out

    def _encloses(self, x: Floats) -> NDArray[np.bool_]:
        """Which points (m, 3) lie in enclosed cells."""
        index = np.floor((x - self.middle) / self.cell + 0.5).astype(np.int64)
        known = ((index >= 0) & (index < self._enclosed.shape)).all(axis=1)
        deep = np.zeros(len(x), bool)
        deep[known] = self._enclosed[tuple(index[known].T)]
        return deep


def make_solid(triangles: Floats, tolerance: float = 0.0) -> Solid:
    """From the corners (t, 3, 3) of triangles, in any order and orientation, watertight or not; its cells need be no finer than a
    fifth of `tolerance` (m)."""
    from scipy.ndimage import binary_dilation, label

    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    size = high - low
    longest = max(float(size.max()), 1e-6)
    cell = max(
        float(np.prod(np.maximum(size, 0.02 * longest)) / CELLS) ** (1.0 / 3.0), longest / 250.0, 0.2 * tolerance
    )
    fine, origin_of = split(triangles, FINE * cell)
    origin = low - 1.5 * cell
    shape = tuple(np.ceil((high - origin) / cell).astype(int) + 2)
    surface = np.zeros(shape, bool)
    between = 0.5 * (fine + np.roll(fine, -1, axis=1))
    for marks in (fine, between):
        surface[tuple(np.floor((marks - origin) / cell).astype(np.int64).transpose(2, 0, 1))] = True
    regions = np.asarray(label(~surface)[0])  # type: ignore[index]
    outside = regions == regions[0, 0, 0]
    # surfaces may lie inside: shells that overlap, parts within parts
    enclosed = ~(outside | surface & np.asarray(binary_dilation(outside, np.ones((3, 3, 3), bool)), bool))
    outer = _touches(fine, ~enclosed, origin, cell, 0.5)
    whole = _mesh(triangles)
    within = np.zeros(len(triangles), bool)
    within[origin_of[~outer]] = True
    middle = origin + 0.5 * cell
    field = _field(enclosed, outside, middle, cell, whole)
    inside = middle + np.argwhere(enclosed) * cell
    boxes = _boxes(inside, cell, BLOCK * cell)
    # of triangles that go on inside, the parts outside
    parts = split(fine[outer & within[origin_of]], 0.5 * FINE * cell)[0]
    parts = parts[_touches(parts, ~enclosed, origin, cell, 0.25)]
    about = parts.mean(axis=1)
    reach = np.linalg.norm(parts - about[:, None], axis=2).max(axis=1)
    parts = parts[whole.signed_distance(about) > -reach]  # else within another closed part
    skin = _mesh(np.concatenate([triangles[~within], parts])) if within.any() else whole
    return Solid(fine[outer], boxes, inside, cell, field, middle, enclosed, whole, skin)


def _touches(
    triangles: Floats, cells: NDArray[np.bool_], origin: Floats, cell: float, reach: float
) -> NDArray[np.bool_]:
    """Which triangles may have a part in one of the cells: no point of one is further than `reach` cells, along each axis, from
    all of its corners and the middles of its edges."""
    found = np.zeros(len(triangles), bool)
    for marks in (triangles, 0.5 * (triangles + np.roll(triangles, -1, axis=1))):
        for shift in _CORNERS - 0.5:
            index = np.floor((marks - origin) / cell + 2.0 * reach * shift).astype(np.int64)
            found |= cells[tuple(index.transpose(2, 0, 1))].any(axis=1)
    return found


def _mesh(triangles: Floats) -> Mesh:
    return Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def _field(enclosed: NDArray[np.bool_], outside: NDArray[np.bool_], middle: Floats, cell: float, mesh: Mesh) -> Floats:
    """Depth at the cells: that of the mesh next to the surface; further in and out that of the nearest such cell on the way to
    the other side, and the distance to it."""
    from scipy.ndimage import distance_transform_edt

    inward: Any = distance_transform_edt(enclosed, return_indices=True)
    outward = np.asarray(distance_transform_edt(outside))
    skin = (np.asarray(inward[0]) < SKIN) & (outward < 1.1)
    field = np.zeros(enclosed.shape)
    field[skin] = -mesh.signed_distance(middle + np.argwhere(skin) * cell)
    field[skin & enclosed] = np.abs(field[skin & enclosed])
    deep = enclosed & ~skin
    field[deep] = cell * inward[0][deep] + field[tuple(inward[1][:, deep])]
    away = ~enclosed & ~skin
    field[away] = cell * (0.5 - outward[away])
    return field


def depth_along(solid: Solid, a: Floats, b: Floats) -> Floats:
    """Depth (c,) in the solid that segments a, b (c, 3) have at points half a cell apart, at least."""
    counts = np.ceil(np.linalg.norm(b - a, axis=1) / (0.5 * solid.cell)).astype(int) + 1
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    rank = np.arange(counts.sum()) - np.repeat(starts, counts)
    t = rank / np.repeat(np.maximum(counts - 1, 1), counts)
    x = np.repeat(a, counts, axis=0) + t[:, None] * np.repeat(b - a, counts, axis=0)
    return np.minimum.reduceat(solid.depth(x), starts)


def split(triangles: Floats, longest: float) -> tuple[Floats, Integers]:
    """The same surface in triangles (t, 3, 3) without an edge longer than `longest`, and which of the given ones each is part of:
    the longest edges are halved."""
    done, rest, number = [triangles[:0]], triangles, np.arange(len(triangles))
    parts = [number[:0]]
    while len(rest):
        edges = np.linalg.norm(rest - np.roll(rest, -1, axis=1), axis=2)
        k = edges.argmax(axis=1)
        fits = edges.max(axis=1) <= longest
        done.append(rest[fits])
        parts.append(number[fits])
        rest, k, number = rest[~fits], k[~fits], np.tile(number[~fits], 2)
        rows = np.arange(len(rest))
        a, b, c = rest[rows, k], rest[rows, (k + 1) % 3], rest[rows, (k + 2) % 3]
        middle = 0.5 * (a + b)
        rest = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return np.concatenate(done), np.concatenate(parts)


def _boxes(centres: Floats, cell: float, side: float) -> Floats:
    """Corners (b, 8, 3) of boxes over cells with these centres, one for each cell of a grid of this side."""
    if not len(centres):
        return np.zeros((0, 8, 3))
    place = _keys(centres, side)
    order = np.argsort(place, kind="stable")
    first = _first_of_equal(place[order])
    low, high = (f.reduceat(centres[order], first, axis=0) for f in (np.minimum, np.maximum))
    return corners_of(low - 0.5 * cell, high + 0.5 * cell)


def _keys(points: NDArray[Any], side: float) -> Integers:
    """One number a point, the same for points in the same cell of a grid."""
    place = np.floor(points / side).astype(np.int64) + (1 << 20)
    return (place[:, 0] << 42) | (place[:, 1] << 21) | place[:, 2]


def _first_of_equal(ordered: Integers) -> Integers:
    """Where a new value starts."""
    return np.concatenate([[0], np.flatnonzero(ordered[1:] != ordered[:-1]) + 1]).astype(np.int64)


def corners_of(low: Floats, high: Floats) -> Floats:
    """Corners (k, 8, 3) of boxes."""
    return np.where(_CORNERS > 0, high[:, None], low[:, None])


def thinned(points: NDArray[Any], most: int) -> NDArray[Any]:
    """At most so many of points (m, 3), spread evenly: the first one in each cell of a grid."""
    if len(points) <= most:
        return points
    side = 1.5 * float(np.ptp(points, axis=0).max()) / most**0.5 + 1e-9
    while True:
        first = np.unique(_keys(points, side), return_index=True)[1]
        if len(first) <= most:
            return points[np.sort(first)]
        side *= 1.25
