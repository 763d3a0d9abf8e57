from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

Array = NDArray[np.float64]
MOST_CELLS = 200_000


@dataclass(frozen=True, slots=True, eq=False)
class CellIndex:
    """For every cell of a grid the numbers of the balls that can have a weight anywhere in it, for `_kernels.walk_indexed`.

    With m the middle of a box and h its half diagonal, d_i(x) >= d_i(m) - h and min d(x) <= min d(m) + h, so that only balls
    with d_i(m) <= min d(m) + 2 h + 2 boundary can count: the indexed field is the same function, not an approximation. The
    grid is halved down to its cells, and each box sifts the list of the one it lies in.
    `starts` (cells + 1,) into `entries` (e, 2): the number of a ball and its distance d(m), in units of `unit`, rounded down; the
    nearest first, so that a search of the cell may stop early. `fuzz` is more than rounding makes of a distance (m).
    `records` (m, rows): what is known of a ball, in one place.
    """

    grid: Array
    starts: NDArray[np.int64]
    entries: NDArray[np.int32]
    unit: float
    fuzz: float
    records: Array

    @property
    def mean_candidates(self) -> float:
        """Balls a cell."""
        return len(self.entries) / (len(self.starts) - 1)

    @property
    def most_candidates(self) -> int:
        """Balls of the fullest cell."""
        return int(np.diff(self.starts).max())

    @property
    def bytes(self) -> int:
        """Memory of the index."""
        return self.grid.nbytes + self.starts.nbytes + self.entries.nbytes + self.records.nbytes


def build_index(centers: Array, radii: Array, table: Array, boundary: float, cells: int | None = None) -> CellIndex:
    """Index balls of the plane or of space; `table` (rows, m) is what is known of them, `cells` about how many cells to make.

    Raises InputError in more than three dimensions.
    """
    from ._kernels import arrange, sift

    m, n = centers.shape
    if n > 3:
        raise InputError(f"a grid of cells pays in the plane and in space, not in R^{n}", place="indexed")
    low, high = (centers - radii[:, None]).min(axis=0), (centers + radii[:, None]).max(axis=0)
    spare = 0.05 * (high - low) + 1e-9
    low, high = low - spare, high + spare
    wanted = min(max(4 * m, 4096) if cells is None else cells, MOST_CELLS)
    side = _side(high - low, wanted)
    count = np.maximum(np.ceil((high - low) / side), 1.0).astype(np.int64)
    # boxes of cells: first and last + 1 on each axis
    boxes = np.stack([np.zeros(n, np.int64), count])[None]
    starts, balls, scratch = np.array([0, m]), np.arange(m, dtype=np.int32), np.empty(m)
    extent = float(np.abs([low, high]).max())
    fuzz = 1e-9 * extent
    while (boxes[:, 1] - boxes[:, 0]).max() > 1:
        boxes, parent = _halved(boxes)
        middle = low + 0.5 * side * boxes.sum(axis=1)
        half = 0.5 * side * np.linalg.norm(boxes[:, 1] - boxes[:, 0], axis=1)
        first, nothing = np.empty(len(boxes) + 1, np.int64), np.empty(0, np.int32)
        job = (centers, radii, middle, half, parent, starts, balls, 2.0 * boundary + fuzz, first)
        sift(*job, nothing, scratch)
        kept = np.empty(first[-1], np.int32)
        sift(*job, kept, scratch)
        starts, balls = first, kept
    order = np.argsort(np.ravel_multi_index(tuple(boxes[:, 0].T), tuple(count)))  # as a point finds its cell
    sizes = np.diff(starts)[order]
    first, entries = np.concatenate([[0], np.cumsum(sizes)]), np.empty((len(balls), 2), np.int32)
    unit = 4.0 * extent / 2.0**31
    arrange(centers, radii, low + side * (boxes[:, 0] + 0.5), order, starts, balls, unit, first, entries, scratch)
    grid = np.stack([low, np.full(n, 1.0 / side), count.astype(np.float64)])
    return CellIndex(grid, first, entries, unit, fuzz, np.ascontiguousarray(table.T))


def _side(size: Array, wanted: float) -> float:
    """The edge of about `wanted` cubic cells in a box of this size (n,); what is flatter than a cell is one cell thick."""
    longest = np.sort(size)[::-1]
    sides = [float((np.prod(longest[:k]) / wanted) ** (1.0 / k)) for k in range(1, len(size) + 1)]
    return next(side for side, least in zip(reversed(sides), reversed(longest)) if side <= least)


def _halved(boxes: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Each box (b, 2, n) in halves along every axis where it has more than one cell, and where each comes from."""
    parent = np.arange(len(boxes))
    for k in range(boxes.shape[2]):
        wide = boxes[:, 1, k] - boxes[:, 0, k] > 1
        upper, cut = boxes[wide].copy(), (boxes[wide, 0, k] + boxes[wide, 1, k]) // 2
        boxes = boxes.copy()
        boxes[wide, 1, k] = cut
        upper[:, 0, k] = cut
        boxes, parent = np.concatenate([boxes, upper]), np.concatenate([parent, parent[wide]])
    order = np.argsort(parent, kind="stable")
    return boxes[order], parent[order]
