"""A mesh made ready to be covered: its surface and what it encloses in small pieces, and how deep a point lies in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
CELLS = 60_000
"""Cells of the grid over the box of a mesh, about."""
PIECES = 2_500
"""Most pieces of the surface."""
POINTS = 40_000
"""Above so many points, crowded pieces are replaced by the corners of their boxes."""
FINE = 0.85
"""Longest edge, in cells, of the triangles that mark the grid: no point of one is half a cell from all its corners, so a walk
from cell to cell through their faces cannot slip through the surface."""


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
    index = np.floor((fine - origin) / cell).astype(np.int64)
    surface = np.zeros(shape, bool)
    surface[tuple(index.reshape(-1, 3).T)] = True
    outside = label(~surface)[0]
    outside = outside == outside[0, 0, 0]
    enclosed = ~(outside | surface)
    near = binary_dilation(outside, np.ones((3, 3, 3), bool), iterations=2)
    outer = fine[near[tuple(index.reshape(-1, 3).T)].reshape(-1, 3).any(axis=1)]
    vertices = np.unique(fine.reshape(-1, 3), axis=0)
    inside = origin + (np.argwhere(enclosed) + 0.5) * cell
    coarse = 2.0 * cell
    while len(np.unique(np.floor(vertices / coarse), axis=0)) > PIECES:
        coarse *= 1.25
    points, starts = _pieces(split(triangles, coarse), inside, cell, coarse)
    return Solid(points, starts, inside, vertices, cell, origin, enclosed, cKDTree(vertices), cKDTree(outer.reshape(-1, 3)))


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
    place = np.floor(triangles.mean(axis=1) / coarse).astype(np.int64)
    rows = np.concatenate([np.repeat(place, 3, axis=0), triangles.reshape(-1, 3)], axis=1)
    rows = np.unique(rows, axis=0)
    points, starts = rows[:, 3:], _first_rows(rows[:, :3])
    counts = np.diff(np.append(starts, len(points)))
    if len(points) > POINTS:
        low, high = (f.reduceat(points, starts, axis=0) for f in (np.minimum, np.maximum))
        crowded = counts > 8
        points = np.concatenate([points[np.repeat(~crowded, counts)], _corners(low[crowded], high[crowded])])
        counts = np.concatenate([counts[~crowded], np.full(int(crowded.sum()), 8)])
    if len(inside):
        place = np.floor(inside / coarse).astype(np.int64)
        order = np.lexsort(place.T)
        first = _first_rows(place[order])
        low, high = (f.reduceat(inside[order], first, axis=0) for f in (np.minimum, np.maximum))
        points = np.concatenate([points, _corners(low - 0.5 * cell, high + 0.5 * cell)])
        counts = np.concatenate([counts, np.full(len(first), 8)])
    return np.ascontiguousarray(points), np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)


def _first_rows(sorted_rows: NDArray[Any]) -> Integers:
    """Where a new row starts."""
    new = (sorted_rows[1:] != sorted_rows[:-1]).any(axis=1)
    return np.concatenate([[0], np.flatnonzero(new) + 1]).astype(np.int64)


def _corners(low: Floats, high: Floats) -> Floats:
    """Corners (8 k, 3) of boxes."""
    choice = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8).T.astype(bool)
    return np.where(choice, high[:, None], low[:, None]).reshape(-1, 3)
