"""The search for a cover of a solid: axes of few bodies that hold it and stand out little."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ._bodies import Floats
from ._search_kernels import grow, lacks_of, polish
from ._solid import Solid, thinned

POINTS = 9_000
"""Of the surface that the search looks at first, at most; a fifth as many within."""
ALL = 60_000
"""Points that are looked at after each search, at most."""
MORE = 1_000
"""Points that were forgotten are added, so many at most each time."""
LOOKS = 8
"""Times that all points are looked at."""
REPAIRS = 40
"""Times that some neighbours are taken out and laid anew, at most."""
TRIES, CLIMBS, ROUNDS = 6, 200, 1_000
"""Starts for a new body, steps of each, and steps that shift some bodies together."""
STEP = 1.04
"""The slack grows by this as long as the budget does not do."""
NOISE = 1 << 16
Points = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """What the search knows of a solid: points (3, p) to hold, and random numbers."""

    solid: Solid
    points: Points
    capsules: bool
    noise: Floats
    rng: np.random.Generator

    def lacks(self, axes: Floats, points: Points | None = None) -> Points:
        """Slack (k, p) with which a body about each axis holds each point."""
        points, s = self.points if points is None else points, self.solid
        out = np.empty((len(axes), points.shape[1]), np.float32)
        lacks_of(s.field, s.middle, s.cell, points, np.ascontiguousarray(axes), out)
        return out

    def grown(self, which: NDArray[np.bool_], slack: float, most: int) -> tuple[Floats, int]:
        """At most so many new axes for the chosen points, and how many of these stay bare."""
        points, axes, s = np.ascontiguousarray(self.points[:, which]), np.zeros((most, 6)), self.solid
        given = (points, slack, self.capsules, 2.0 * slack, self._turned(), axes, TRIES, CLIMBS)
        count, bare = grow(s.field, s.middle, s.cell, *given)
        return axes[:count], bare

    def polished(self, axes: Floats, which: NDArray[np.bool_], slack: float) -> tuple[Floats, float]:
        """Axes moved to hold the chosen points with a slack, and the slack with which they do."""
        if not len(axes) or not which.any():
            return axes, 0.0 if len(axes) else np.inf
        points, axes, s = np.ascontiguousarray(self.points[:, which]), axes.copy(), self.solid
        given = (points, slack, self.capsules, 2.0 * slack, self._turned(), axes, ROUNDS)
        return axes, float(polish(s.field, s.middle, s.cell, *given))

    def _turned(self) -> Floats:
        """The random numbers, from another place on."""
        return np.roll(self.noise, int(self.rng.integers(NOISE)))


def find_axes(solid: Solid, budget: int, tolerance: float, capsules: bool, seed: int) -> tuple[Floats, Floats, float]:
    """At most `budget` axes (k, 6), ends equal unless `capsules`, their depth (k,), and the slack (m), about: no less than
    `tolerance`, but as little as the search finds.

    Bodies are laid one by one, each to hold most of what is bare. Then neighbours are taken out and laid anew by one less; the
    slack grows until the budget does. This is done for some points, and again with those that were forgotten.
    """
    rng = np.random.default_rng(seed)
    surface = thinned(rng.permutation(solid.triangles.reshape(-1, 3)), ALL)
    within = thinned(rng.permutation(np.concatenate([solid.boxes.reshape(-1, 3), solid.inside])), ALL // 2)
    everything = _rows(np.concatenate([surface, within]))
    within = thinned(within, POINTS // 4)
    margin = np.clip(0.5 * solid.depth(within), 0.0, 0.3 * tolerance)
    sample = [_rows(thinned(surface, POINTS)), _rows(within, margin)]
    search = Search(solid, np.concatenate(sample, axis=1), capsules, rng.normal(size=NOISE), rng)
    slack, top = tolerance, float(np.linalg.norm(np.ptp(surface, axis=0))) + tolerance
    rough = replace(search, points=np.ascontiguousarray(search.points[:, ::6]))
    most, chosen = int(1.4 * budget) + 1, np.ones(rough.points.shape[1], bool)
    while slack < top:
        _, bare = rough.grown(chosen, slack, most)
        if bare == 0:
            break
        slack *= 1.3 if bare > 0.04 * len(chosen) else 1.1
    axes, _ = search.grown(np.ones(search.points.shape[1], bool), slack, 2 * budget + 4)
    if not len(axes):
        axes = np.tile(0.5 * (surface.min(axis=0) + surface.max(axis=0)), 2)[None]
    for look in range(LOOKS):
        axes, slack = _settled(search, axes, slack, budget, tolerance, 0 if look else REPAIRS)
        over = search.lacks(axes, everything).min(axis=0) - slack
        worst = np.flatnonzero(over > 0.02 * slack)
        if not len(worst) or look == LOOKS - 1:
            break
        more = everything[:, worst[np.argsort(-over[worst], kind="stable")]]
        search = replace(search, points=np.concatenate([search.points, _rows(thinned(more[:3].T, MORE))], axis=1))
    depth = np.array([-search.lacks(axis[None], _rows(axis[None, :3]))[0, 0] for axis in axes], np.float64)
    return axes, depth, slack


def _settled(
    search: Search, axes: Floats, slack: float, budget: int, tolerance: float, times: int
) -> tuple[Floats, float]:
    """Axes that hold all points, within the budget, and their slack."""
    lacks = search.lacks(axes)
    bare = lacks.min(axis=0) > slack
    if bare.any():
        axes, _ = search.polished(axes, np.ones(len(bare), bool), slack)
        lacks = search.lacks(axes)
        bare = lacks.min(axis=0) > slack
        if bare.any():
            axes = np.concatenate([axes, search.grown(bare, slack, 2 * budget + 4)[0]])
            lacks = search.lacks(axes)
    axes, lacks = _fewer(search, axes, lacks, slack, min(times, 4 * len(axes)), 1)
    while len(axes) > budget:
        slack *= STEP
        axes, lacks = _fewer(search, axes, lacks, slack, REPAIRS // 3, budget)
    while slack > tolerance:
        less = max(slack / STEP, tolerance)
        trial, most = search.polished(axes, np.ones(lacks.shape[1], bool), less)
        if most > less:
            more, left = search.grown(search.lacks(trial).min(axis=0) > less, less, budget - len(trial))
            if left:
                break
            trial = np.concatenate([trial, more])
        axes, slack = trial, less
    return axes, slack


def _fewer(search: Search, axes: Floats, lacks: Points, slack: float, times: int, enough: int) -> tuple[Floats, Points]:
    """The axes with groups of neighbours laid anew, by one less where that can be, until there are `enough`; and their lacks."""
    for _ in range(times):
        if len(axes) <= enough:
            break
        count = min(int(search.rng.integers(2, 6)), len(axes))
        middles = 0.5 * (axes[:, :3] + axes[:, 3:])
        away = np.linalg.norm(middles - middles[search.rng.integers(len(axes))], axis=1)
        away += 1.5 * slack * search.rng.random(len(axes))
        keep = np.sort(np.argsort(away, kind="stable")[count:])
        bare = lacks[keep].min(axis=0, initial=np.inf) > slack
        if not bare.any():
            axes, lacks = axes[keep], lacks[keep]
            continue
        new, left = search.grown(bare, slack, count)
        if left or len(new) == count > 1:
            trial, most = search.polished(new[: count - 1], bare, slack) if count > 1 else (new, np.inf)
            if most <= slack:
                new, left = trial, 0
        if not left:
            axes = np.concatenate([axes[keep], new])
            lacks = np.concatenate([lacks[keep], search.lacks(new)])
    return axes, lacks


def _rows(points: Floats | Points, margin: Floats | float = 0.0) -> Points:
    """Points (m, 3) to hold with a margin, as (4, m)."""
    return np.concatenate([points.T, np.broadcast_to(margin, (1, len(points)))]).astype(np.float32)
