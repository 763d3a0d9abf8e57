from __future__ import annotations

from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

Array = NDArray[np.float64]
MOST_CELLS = 200_000


@dataclass(frozen=True, slots=True, eq=False)
class CellIndex:
    """For every cell of a grid the balls that can have a weight anywhere in it, packed for `_kernels.walk_indexed`.

    With m the cell's middle and h its half diagonal, d_i(x) >= d_i(m) - h and min d(x) <= min d(m) + h, so that only balls with
    d_i(m) < min d(m) + 2 h + 2 boundary can count: the indexed field is the same function, not an approximation.
    """

    grid: Array
    starts: NDArray[np.int64]
    blocks: Array
    rows: int

    @property
    def mean_candidates(self) -> float:
        return float(np.diff(self.starts[:-1]).mean()) / self.rows


def build_index(centers: Array, radii: Array, table: Array, boundary: float, cells: int | None = None) -> CellIndex:
    """Index balls of the plane or of space; `table` (rows, m) is what to pack, `cells` about how many cells to make."""
    from scipy.spatial import cKDTree

    m, n = centers.shape
    if n > 3:
        raise InputError(f"a grid of cells pays in the plane and in space, not in R^{n}", place="indexed")
    low, high = (centers - radii[:, None]).min(axis=0), (centers + radii[:, None]).max(axis=0)
    spare = 0.05 * (high - low) + 1e-9
    low, high = low - spare, high + spare
    wanted = min(max(4 * m, 4096) if cells is None else cells, MOST_CELLS)
    side = float((np.prod(high - low) / wanted) ** (1.0 / n))
    count = np.maximum(np.ceil((high - low) / side), 1.0).astype(int)
    axes = [low[k] + side * (np.arange(count[k]) + 0.5) for k in range(n)]
    middles = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, n)
    half = 0.5 * side * np.sqrt(n)
    tree = cKDTree(centers)
    away, nearest = tree.query(middles)
    reach = away - radii[nearest] + 2.0 * half + 2.0 * boundary + float(radii.max())
    blocks, sizes, rows = [], [], len(table)
    for first in range(0, len(middles), 50_000):
        cell = slice(first, first + 50_000)
        found = tree.query_ball_point(middles[cell], reach[cell], return_sorted=True)
        counts = np.array([len(items) for items in found])
        owner = np.repeat(np.arange(len(counts)), counts)
        ball = np.fromiter(chain.from_iterable(found), np.int64, len(owner))
        d = np.linalg.norm(centers[ball] - middles[cell][owner], axis=1) - radii[ball]
        least = np.minimum.reduceat(d, np.cumsum(counts) - counts)
        near = d < least[owner] + 2.0 * half + 2.0 * boundary + 1e-12
        owner, ball = owner[near], ball[near]
        counts = np.bincount(owner, minlength=len(counts))
        starts = np.cumsum(counts) - counts
        # every cell's table row after row
        at = starts[owner] * rows + np.arange(len(owner)) - starts[owner]
        block = np.empty(len(owner) * rows)
        for row in range(rows):
            block[at + row * counts[owner]] = table[row, ball]
        blocks.append(block)
        sizes.append(counts * rows)
    blocks.append(table.ravel())
    sizes.append(np.array([table.size]))
    starts = np.concatenate([[0], np.cumsum(np.concatenate(sizes))]).astype(np.int64)
    grid = np.stack([low, np.full(n, 1.0 / side), count.astype(np.float64)])
    return CellIndex(grid, starts, np.concatenate(blocks), rows)
