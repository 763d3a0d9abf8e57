from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _kernels as kernels
from ._blend import nearest_weights, simplex_weights, smooth_weights
from ._index import CellIndex, build_index
from ._printed import potential_term, printed_weights

Array = NDArray[np.float64]
COMPILED = {"nearest": 0.0, "simplex": 1.0, "smooth": 2.0, "sum": 3.0}
BLENDS = (*COMPILED, "printed", "printed-potential")


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """Balls of R^n with their charges, the walls of the workspace and the boundary width, ready for the compiled loops.

    `centers` (m, n), `radii`, `charges`, `exponents` (m,), `walls` (k, n + 2) rows (inward normal, offset, 0) or (centre, 0,
    radius), metres; entries are numbered balls, walls, sensor range.
    """

    goal: Array
    centers: Array
    radii: Array
    charges: Array
    exponents: Array
    walls: Array
    boundary: float
    sensor_range: float
    blend: str
    packed: tuple[Any, ...]
    index: CellIndex | None = None

    @classmethod
    def build(cls, goal, centers, radii, charges, exponents, walls, boundary, sensor_range, blend) -> World:
        """Pack the arrays the way `_kernels` reads them, relative to the goal."""
        n = len(goal)
        middles = centers - goal
        shifted = np.array(walls).reshape(-1, n + 2)
        curved = shifted[:, -1] > 0.0
        shifted[curved, :n] -= goal
        shifted[~curved, n] -= shifted[~curved, :n] @ goal
        gaps = wall_distances(walls, centers) - radii[:, None]
        limits = np.full((1, len(radii)), sensor_range)
        far = np.linalg.norm(middles, axis=1)
        table = np.concatenate([middles.T, np.stack([radii, charges, exponents, far]), gaps.T, limits])
        code = COMPILED.get(blend, 0.0)
        settings = np.zeros(kernels.DIRECTION + n)
        settings[kernels.BOUNDARY], settings[kernels.RANGE], settings[kernels.BLEND] = boundary, sensor_range, code
        settings[kernels.REACH] = (0.0, boundary, 2.0 * boundary, np.inf)[int(code)]
        # what a world does not have is not compiled either
        plain = blend == "smooth" and bool((exponents == 2.0).all())
        packed = (
            np.ascontiguousarray(table),
            np.ascontiguousarray(shifted) if len(walls) else None,
            None if plain else True,
            settings,
        )
        return cls(goal, centers, radii, charges, exponents, walls, boundary, sensor_range, blend, packed)

    @property
    def entries(self) -> int:
        return len(self.radii) + len(self.walls) + bool(np.isfinite(self.sensor_range))

    def scratch(self) -> tuple[Array, Array, Array, NDArray[np.int64]]:
        count = len(self.radii) + len(self.walls) + 1
        return np.empty(count), np.empty(count), np.empty(count), np.empty(count, np.int64)

    def scaled(self, points: Array) -> Array:
        """|x - g|^2 E (b, n) at `points` (b, n), E with goal strength 1 / |x - g|."""
        if self.blend not in COMPILED:
            return self._printed(points)
        out, near = np.empty_like(points), points - self.goal
        table, walls, general, settings = self.packed
        if self.index is not None:
            at, few = self.index, np.empty(len(table) * self.index.most_candidates)
            lists = (at.grid, at.starts, at.entries, at.unit, at.fuzz, at.records)
            kernels.walk_indexed(near, out, *lists, table, few, walls, general, settings, *self.scratch())
        else:
            kernels.walk(near, out, table, walls, general, settings, *self.scratch())
        return out

    def indexed(self, cells: int | None) -> World:
        """The same world with its balls in a grid of cells."""
        middles = self.centers - self.goal
        return replace(self, index=build_index(middles, self.radii, self.packed[0], self.boundary, cells))

    def _printed(self, points: Array) -> Array:
        m = len(self.radii)
        to_goal = self.goal - points
        if m == 0:
            return to_goal
        d = self.clearances(points)[:, :m]
        y = points[:, None] - self.centers
        ratio = (to_goal**2).sum(axis=-1)[:, None] / (y**2).sum(axis=-1)
        share = printed_weights(d, self.boundary) * self.charges * ratio ** (0.5 * self.exponents)
        e = to_goal + (share[..., None] * y).sum(axis=1)
        if self.blend == "printed-potential":
            extra = potential_term(points, self.centers, self.radii, self.charges, d, self.boundary)
            e += (to_goal**2).sum(axis=-1, keepdims=True) * extra
        return e

    def weights(self, points: Array) -> Array:
        """The weight (b, entries) of every entry at `points` (b, n)."""
        d = self.clearances(points)
        if self.blend == "sum":
            return np.ones_like(d)
        if self.blend == "nearest":
            return nearest_weights(d)
        if self.blend == "simplex":
            return simplex_weights(d, self.boundary)
        if self.blend == "smooth":
            return smooth_weights(d, self.boundary, self.gaps())
        return printed_weights(d, self.boundary)

    def clearances(self, points: Array) -> Array:
        """Distances (b, entries) of `points` (b, n) to every ball, wall and the sensor range."""
        parts = [np.linalg.norm(points[:, None] - self.centers, axis=-1) - self.radii]
        if len(self.walls):
            parts.append(wall_distances(self.walls, points))
        if np.isfinite(self.sensor_range):
            parts.append(np.full((len(points), 1), self.sensor_range))
        return np.concatenate(parts, axis=1)

    def gaps(self) -> Array:
        """Gaps (entries, entries) between the entries; infinite where both have charge 0."""
        m, k = len(self.radii), self.entries
        gap = np.full((k, k), np.inf)
        apart = np.linalg.norm(self.centers[:, None] - self.centers, axis=-1)
        gap[:m, :m] = apart - self.radii[:, None] - self.radii
        np.fill_diagonal(gap, np.inf)
        if k > m:
            columns = np.full((m, k - m), self.sensor_range)
            columns[:, : len(self.walls)] = wall_distances(self.walls, self.centers) - self.radii[:, None]
            gap[:m, m:], gap[m:, :m] = columns, columns.T
        return gap

    def least_gap(self) -> tuple[float, tuple[int, int]]:
        """The least gap between two balls and which they are."""
        best, pair = np.inf, (0, 0)
        for first in range(0, len(self.radii), 256):
            rows = slice(first, first + 256)
            gap = np.linalg.norm(self.centers[rows, None] - self.centers, axis=-1) - self.radii[rows, None] - self.radii
            local = np.arange(gap.shape[0])
            gap[local, first + local] = np.inf
            k = int(np.argmin(gap))
            if gap.flat[k] < best:
                best, pair = float(gap.flat[k]), (first + k // gap.shape[1], k % gap.shape[1])
        return best, pair

    def trace(self, start: Array, step: float, tolerance: float, keep: float, clip: bool, max_steps: int):
        """Points (k, n) and (code, least clearance, length, sideways steps) of the motion from `start`."""
        table, walls, general, options = self.packed
        points, scratch, sideways = np.empty((max_steps + 1, len(start))), self.scratch(), 0
        points[0] = start - self.goal
        away = float(np.linalg.norm(points[0]))
        s = options.copy()
        s[kernels.STEP], s[kernels.TOLERANCE], s[kernels.KEEP] = step, tolerance, keep if clip else 0.0
        s[kernels.PATIENCE], s[kernels.GAIN] = max(500.0, 4.0 * away / step), 1e-12 * away
        s[kernels.CLOSEST], s[kernels.BEST] = np.inf, away
        out = np.empty((1, len(start)))
        count = kernels.walk(points, out, table, walls, general, s, *scratch)
        while s[kernels.CODE] == kernels.RAY:
            s[kernels.GIVEN], s[kernels.DIRECTION :] = self._off_the_ray(points[count - 1], step, int(s[kernels.NEAR]))
            sideways += 1
            count += kernels.walk(points[count - 1 :], out, table, walls, general, s, *scratch) - 1
        points = points[:count] + self.goal
        points[0] = start
        return points, (s[kernels.CODE], s[kernels.CLOSEST], s[kernels.LENGTH], sideways)

    def _off_the_ray(self, x: Array, step: float, near: int) -> tuple[float, Array]:
        """Length and direction (n,) of a step from `x` (n,), relative to the goal, on the unstable ray of ball `near`."""
        n, away = len(x), float(np.linalg.norm(x))
        ray, axis = x / away, int(np.argmin(np.abs(x)))
        side = -ray[axis] * ray
        side[axis] += 1.0
        side /= np.linalg.norm(side)
        R = self.radii[near]
        if np.linalg.norm(x - self.packed[0][:n, near]) - R < 1e-9 * R:
            # at the unstable point itself: along the surface, the one step that gains nothing
            return min(step, away, 0.001 * R), side
        lean = 0.05
        size = np.sqrt(1.0 + lean * lean)
        return min(step, away / size), (lean * side - ray) / size


def wall_distances(walls: Array, points: Array) -> Array:
    """Distances (b, k) of `points` (b, n) to the `walls` (k, n + 2), negative outside the workspace."""
    flat = points @ walls[:, :-2].T - walls[:, -2]
    curved = walls[:, -1] - np.linalg.norm(points[:, None] - walls[:, :-2], axis=-1)
    return np.where(walls[:, -1] > 0.0, curved, flat)
