"""A mesh made ready to be covered: its surface and what it encloses in small pieces, and how deep a point lies in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
CELLS = 120_000
"""Cells of the grid over the box of a mesh, about."""
PIECES = 6_000
"""Most pieces of the surface."""
DEEP = 2.5
"""Cells from the surface where large boxes will do."""
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

    Attributes: `points` (p, 3) of the pieces in turn, `starts` (k,) first point of each; `leading`: how many come before
    the boxes next to the surface, which are nearly always held with it; `inside` (c, 3) centres of enclosed
    cells; `vertices` (v, 3) on the surface; `cell` (m) side of the fine grid.
    """

    points: Floats
    starts: Integers
    leading: int
    inside: Floats
    vertices: Floats
    cell: float
    _origin: Floats
    _enclosed: NDArray[np.bool_]
    _rough: Floats
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
        result = np.empty(len(x))
        result[~deep] = -self._tree.query(x[~deep])[0]
        if deep.any():
            reach = self._outer.query(x[deep])[0]
            result[deep] = np.sqrt(np.maximum(reach**2 - (FINE * self.cell) ** 2 / 3.0, 0.0))
        return result

    def rough_depth(self, x: Floats) -> Floats:
        """Depth (m,) of points (m, 3) to within about a cell, negative outside: fast, and no bound."""
        from scipy.ndimage import map_coordinates

        place = (x - self._origin) / self.cell - 0.5
        return np.asarray(map_coordinates(self._rough, place.T, order=1, mode="nearest"))

    def deepest(self) -> Floats:
        """Centres (m, 3) of the enclosed cells that no neighbour lies deeper than, deepest first."""
        from scipy.ndimage import maximum_filter

        best = np.argwhere(self._enclosed & (self._rough >= maximum_filter(self._rough, size=3)))
        order = np.argsort(-self._rough[tuple(best.T)], kind="stable")
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


def make_solid(triangles: Floats, tolerance: float = 0.0) -> Solid:
    """From the corners (t, 3, 3) of triangles, in any order and orientation, watertight or not; its cells need be no finer than a
    fifth of `tolerance` (m)."""
    from scipy.ndimage import binary_dilation, distance_transform_edt, label
    from scipy.spatial import cKDTree

    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    size = high - low
    longest = max(float(size.max()), 1e-6)
    cell = max(
        float(np.prod(np.maximum(size, 0.02 * longest)) / CELLS) ** (1.0 / 3.0), longest / 250.0, 0.2 * tolerance
    )
    fine = split(triangles, FINE * cell)
    origin = low - 1.5 * cell
    shape = tuple(np.ceil((high - origin) / cell).astype(int) + 2)
    surface = np.zeros(shape, bool)
    for marks in (fine, 0.5 * (fine + np.roll(fine, -1, axis=1))):
        surface[tuple(np.floor((marks.reshape(-1, 3) - origin) / cell).astype(np.int64).T)] = True
    regions = np.asarray(label(~surface)[0])  # type: ignore[index]
    outside = regions == regions[0, 0, 0]
    # surfaces may lie inside: shells that overlap, parts within parts
    enclosed = ~(outside | surface & np.asarray(binary_dilation(outside, np.ones((3, 3, 3), bool)), bool))
    vertices = fine.reshape(-1, 3)[distinct(fine.reshape(-1, 3))[0]]
    index = tuple(np.floor((vertices - origin) / cell).astype(np.int64).T)
    # of a triangle that has a part in a cell beside an outside one, all corners are within three cells of that one
    near = np.asarray(binary_dilation(outside, np.ones((3, 3, 3), bool), iterations=3), bool)
    outer = vertices[near[index]]
    inside = origin + (np.argwhere(enclosed) + 0.5) * cell
    coarse = cell
    while len(np.unique(_keys(vertices, coarse))) > PIECES:
        coarse *= 1.25
    rough = cell * np.where(
        enclosed,
        np.asarray(distance_transform_edt(enclosed)) - 0.5,
        0.5 - np.asarray(distance_transform_edt(~enclosed)),
    )
    sets = [_surface_pieces(split(triangles, 0.6 * coarse), coarse)]
    deep = rough[enclosed] > DEEP * cell
    sets += [_boxes(inside[own], cell, side * cell) for own, side in ((deep, 3.0), (~deep, 2.0)) if own.any()]
    points = np.ascontiguousarray(np.concatenate([found for found, _ in sets]))
    counts = np.concatenate([count for _, count in sets])
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    leading = len(sets[0][1]) + (len(sets[1][1]) if deep.any() else 0)
    return Solid(
        points, starts, leading, inside, vertices, cell, origin, enclosed, rough, cKDTree(vertices), cKDTree(outer)
    )


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


def _surface_pieces(triangles: Floats, coarse: float) -> tuple[Floats, Integers]:
    """Points of the pieces of the surface one after the other, and how many each has: the corners of its triangles, or, of
    those with more than eight, the corners of the smaller of two boxes round them, along the frame or their principal axes."""
    corners = triangles.reshape(-1, 3)
    representative, number = distinct(corners)
    place = np.unique(_keys(triangles.mean(axis=1), coarse), return_inverse=True)[1]
    both = np.unique(np.repeat(place, 3) * len(representative) + number)
    points = corners[representative[both % len(representative)]]
    starts = _first_of_equal(both // len(representative))
    counts = np.diff(np.append(starts, len(points)))
    crowded = counts > 8
    if not crowded.any():
        return points, counts
    few, many = points[np.repeat(~crowded, counts)], points[np.repeat(crowded, counts)]
    sizes = counts[crowded]
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    middles = np.add.reduceat(many, starts) / sizes[:, None]
    offset = many - np.repeat(middles, sizes, axis=0)
    spread = np.add.reduceat(offset[:, :, None] * offset[:, None, :], starts)
    turns = np.linalg.eigh(spread)[1]
    found, diagonals = [], []
    for frames in (np.broadcast_to(np.eye(3), turns.shape), turns):
        inside = np.einsum("ni,nij->nj", offset, np.repeat(frames, sizes, axis=0))
        low, high = (f.reduceat(inside, starts, axis=0) for f in (np.minimum, np.maximum))
        grain = 1e-12 + 1e-12 * np.abs(middles).max()  # the turns round
        box = _corners(low - grain, high + grain).reshape(-1, 8, 3)
        found.append(np.einsum("kcj,kij->kci", box, frames) + middles[:, None])
        diagonals.append(np.linalg.norm(high - low, axis=1))
    boxes = np.where((diagonals[1] < diagonals[0])[:, None, None], found[1], found[0])
    return np.concatenate([few, boxes.reshape(-1, 3)]), np.concatenate([counts[~crowded], np.full(len(sizes), 8)])


def _boxes(centres: Floats, cell: float, side: float) -> tuple[Floats, Integers]:
    """Corners of boxes over cells with these centres, one for each cell of a grid of this side, and their counts."""
    place = _keys(centres, side)
    order = np.argsort(place, kind="stable")
    first = _first_of_equal(place[order])
    low, high = (f.reduceat(centres[order], first, axis=0) for f in (np.minimum, np.maximum))
    return _corners(low - 0.5 * cell, high + 0.5 * cell), np.full(len(first), 8)


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
