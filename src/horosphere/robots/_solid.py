"""A mesh made ready to be covered: its surface and what it encloses in small pieces, and how deep a point lies in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
CELLS = 40_000
"""Cells of the grid over the box of a mesh, about."""
PIECES = 1_500
"""Most pieces of the surface."""
POINTS = 25_000
"""Above so many points, crowded pieces are replaced by the corners of their boxes."""
FINE = 1.7
"""Longest edge, in cells, of the triangles that mark the grid with their corners and the middles of their edges: no point of one
is half a cell from all of these, so a walk from cell to cell through their faces cannot slip through the surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A triangle soup with what it encloses; metres.

    A cover is conservative if it holds every piece: ball or capsule are convex, so a piece lies inside if its points do. The
    pieces are the triangles (cut where they are long) by cells of a coarse grid, and boxes over the enclosed cells of a fine
    one. Enclosed is what cannot be reached from outside through the faces of cells without surface: voids, and pockets with an
    opening narrower than about two cells, count as solid.

    Attributes: `points` (p, 3) of the pieces in turn, `starts` (k,) first point of each; `inside` (c, 3) centres of enclosed
    cells; `vertices` (v, 3) on the surface; `cell` (m) side of the fine grid.
    """

    points: Floats
    starts: Integers
    inside: Floats
    vertices: Floats
    cell: float
    _origin: Floats
    _enclosed: NDArray[np.bool_]
    _tree: Any
    _outer: Any

    def depth(self, x: Floats) -> Floats:
        """Lower bound (m,) of the depth of points (m, 3) in the solid; outside, minus an upper bound of their distance to it.

        The nearest point of a triangle without an edge above e has a corner within e / sqrt(3), at a right angle or nearer to
        the point: so depth^2 >= (distance to the corners)^2 - e^2 / 3.
        """
        index = np.floor((x - self._origin) / self.cell).astype(np.int64)
        known = ((index >= 0) & (index < self._enclosed.shape)).all(axis=1)
        deep = np.zeros(len(x), bool)
        deep[known] = self._enclosed[tuple(index[known].T)]
        result = -self._tree.query(x)[0]
        if deep.any():
            reach = self._outer.query(x[deep])[0]
            result[deep] = np.sqrt(np.maximum(reach**2 - (FINE * self.cell) ** 2 / 3.0, 0.0))
        return result

    def deepest(self) -> Floats:
        """Centres (m, 3) of the enclosed cells that no neighbour lies deeper than, deepest first."""
        from scipy.ndimage import distance_transform_edt, maximum_filter

        depth = np.asarray(distance_transform_edt(self._enclosed))
        best = np.argwhere(self._enclosed & (depth >= maximum_filter(depth, size=3)))
        order = np.argsort(-depth[tuple(best.T)], kind="stable")
        return self._origin + (best[order] + 0.5) * self.cell

    def most(self, values: Floats) -> Floats:
        """The largest of `values` (..., p), given at the points, over each piece (..., k)."""
        return np.maximum.reduceat(values, self.starts, axis=-1)

    def middles(self) -> Floats:
        """Middles (k, 3) of the boxes of the pieces."""
        low, high = (f.reduceat(self.points, self.starts, axis=0) for f in (np.minimum, np.maximum))
        return 0.5 * (low + high)

    def points_of(self, pieces: NDArray[np.bool_]) -> Floats:
        """Points of the chosen pieces (a mask)."""
        counts = np.diff(np.append(self.starts, len(self.points)))
        return self.points[np.repeat(pieces, counts)]


def make_solid(triangles: Floats) -> Solid:
    """From the corners (t, 3, 3) of triangles, in any order and orientation, watertight or not."""
    from scipy.ndimage import binary_dilation, label
    from scipy.spatial import cKDTree

    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    size = high - low
    longest = max(float(size.max()), 1e-6)
    cell = max(float(np.prod(np.maximum(size, 0.02 * longest)) / CELLS) ** (1.0 / 3.0), longest / 250.0)
    fine = split(triangles, FINE * cell)
    origin = low - 1.5 * cell
    shape = tuple(np.ceil((high - origin) / cell).astype(int) + 2)
    surface = np.zeros(shape, bool)
    for marks in (fine, 0.5 * (fine + np.roll(fine, -1, axis=1))):
        surface[tuple(np.floor((marks.reshape(-1, 3) - origin) / cell).astype(np.int64).T)] = True
    regions = np.asarray(label(~surface)[0])  # type: ignore[index]
    outside = regions == regions[0, 0, 0]
    enclosed = ~(outside | surface)
    vertices = fine.reshape(-1, 3)[distinct(fine.reshape(-1, 3))[0]]
    index = tuple(np.floor((vertices - origin) / cell).astype(np.int64).T)
    # of a triangle that has a part in a cell beside an outside one, all corners are within three cells of that one
    near = np.asarray(binary_dilation(outside, np.ones((3, 3, 3), bool), iterations=3), bool)
    outer = vertices[near[index]]
    inside = origin + (np.argwhere(enclosed) + 0.5) * cell
    coarse = 2.0 * cell
    while len(np.unique(_keys(vertices, coarse))) > PIECES:
        coarse *= 1.25
    points, starts = _pieces(split(triangles, coarse), inside, cell, coarse)
    return Solid(points, starts, inside, vertices, cell, origin, enclosed, cKDTree(vertices), cKDTree(outer))


def split(triangles: Floats, longest: float) -> Floats:
    """The same surface in triangles (t, 3, 3) without an edge longer than `longest`: the longest edges are halved."""
    done, rest = [], triangles
    while len(rest):
        edges = np.linalg.norm(rest - np.roll(rest, -1, axis=1), axis=2)
        k = edges.argmax(axis=1)
        fits = edges.max(axis=1) <= longest
        done.append(rest[fits])
        rest, k = rest[~fits], k[~fits]
        rows = np.arange(len(rest))
        a, b, c = rest[rows, k], rest[rows, (k + 1) % 3], rest[rows, (k + 2) % 3]
        middle = 0.5 * (a + b)
        rest = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
    return np.concatenate(done)


def _pieces(triangles: Floats, inside: Floats, cell: float, coarse: float) -> tuple[Floats, Integers]:
    """Points of the pieces one after the other, and where each starts."""
    corners = triangles.reshape(-1, 3)
    representative, number = distinct(corners)
    place = np.unique(_keys(triangles.mean(axis=1), coarse), return_inverse=True)[1]
    both = np.unique(np.repeat(place, 3) * len(representative) + number)
    points = corners[representative[both % len(representative)]]
    starts = _first_of_equal(both // len(representative))
    counts = np.diff(np.append(starts, len(points)))
    if len(points) > POINTS:
        low, high = (f.reduceat(points, starts, axis=0) for f in (np.minimum, np.maximum))
        crowded = counts > 8
        points = np.concatenate([points[np.repeat(~crowded, counts)], _corners(low[crowded], high[crowded])])
        counts = np.concatenate([counts[~crowded], np.full(int(crowded.sum()), 8)])
    if len(inside):
        place = _keys(inside, coarse)
        order = np.argsort(place, kind="stable")
        first = _first_of_equal(place[order])
        low, high = (f.reduceat(inside[order], first, axis=0) for f in (np.minimum, np.maximum))
        points = np.concatenate([points, _corners(low - 0.5 * cell, high + 0.5 * cell)])
        counts = np.concatenate([counts, np.full(len(first), 8)])
    return np.ascontiguousarray(points), np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)


def distinct(points: Floats) -> tuple[Integers, Integers]:
    """Positions of distinct rows of `points` (m, 3), and which of them each row equals: by a hash of the bits, then checked."""
    bits = (points + 0.0).view(np.uint64)  # -0.0 is 0.0
    mixed = bits * np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
    mixed ^= mixed >> np.uint64(29)
    _, first, number = np.unique(mixed.sum(axis=1), return_index=True, return_inverse=True)
    if not np.array_equal(points[first][number], points):
        _, first, number = np.unique(points, axis=0, return_index=True, return_inverse=True)
    return first, number.reshape(-1)


def _keys(points: Floats, side: float) -> Integers:
    """One number a point, the same for points in the same cell of a grid."""
    place = np.floor(points / side).astype(np.int64) + (1 << 20)
    return (place[:, 0] << 42) | (place[:, 1] << 21) | place[:, 2]


def _first_of_equal(ordered: Integers) -> Integers:
    """Where a new value starts."""
    return np.concatenate([[0], np.flatnonzero(ordered[1:] != ordered[:-1]) + 1]).astype(np.int64)


def _corners(low: Floats, high: Floats) -> Floats:
    """Corners (8 k, 3) of boxes."""
    choice = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8).T.astype(bool)
    return np.where(choice, high[:, None], low[:, None]).reshape(-1, 3)
