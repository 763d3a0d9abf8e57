"""Gaps between security zones, and how wide the shells around the stars may be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..maps import RoundHull, Star
from ..maps._cells import disjoint
from ..maps._directions import directions, unit

Array = NDArray[np.float64]


def separation(a: Star, b: Star, enough: float = np.inf) -> float:
    """A lower bound of the distance between two stars, metres, by slabs between their convex pieces; stops once `enough`.

    Not above 0 where a piece of the one meets a piece of the other, or no pieces are known and the balls around the stars meet.
    """
    simple = float(np.linalg.norm(b.center - a.center)) - a.outer - b.outer
    if simple >= enough or not (a.pieces and b.pieces):
        return simple
    least = np.inf
    for one in a.pieces:
        for other in b.pieces:
            least = min(least, _slab(one, other, enough))
            if least <= 0.0:
                break
    return max(least, simple)


def _slab(a: Star, b: Star, enough: float) -> float:
    """The widest slab found between two convex bodies.

    For unit w it is w . (c_b - c_a) - h_a(w) - h_b(-w) wide, h the supports: at the best w the distance itself.
    """
    between = b.center - a.center

    def slab(w: Array) -> Array:
        return w @ between - a.support(w) - b.support(-w)

    w = np.concatenate([unit(between[None])[0], directions(len(between))])
    values = slab(w)
    best = w[int(values.argmax())]
    value, spread = float(values.max()), 0.1
    rng = np.random.default_rng(0)
    while spread > 1e-7 and value < enough:
        trials = unit(best + spread * rng.standard_normal((16, len(best))))[0]
        values = slab(trials)
        if values.max() > value:
            best, value = trials[int(values.argmax())], float(values.max())
        else:
            spread *= 0.5
    return value


def shell_widths(stars: Sequence[Star], centers: Array, radii: Array, walls: Array) -> tuple[Array, list[str]]:
    """The widths of disjoint shells, half the outer radius where there is room, and what rests on samples.

    Convex bodies share the gap between them; where one may reach into a bay of the other the widths are shrunk until `disjoint`
    proves the shells apart.
    """
    wide = np.array([0.5 * star.outer for star in stars])
    for i, star in enumerate(stars):
        for center, radius in zip(centers, radii):
            if float(np.linalg.norm(center - star.center)) - radius - star.outer < wide[i]:
                ball = RoundHull(center, np.zeros(len(center)), radius, radius)
                wide[i] = min(wide[i], _fitting(star, wide[i], ball, 0.0)[0])
        for wall in walls:
            wide[i] = min(wide[i], 0.98 * wall_gap(star, wall))
    for i, a in enumerate(stars):
        for j in range(i):
            wide[i], wide[j] = _fitting(a, wide[i], stars[j], wide[j])
    notes = [
        f"{star.name}: its steepness was sampled, and gaps rest on it (give `steepest`)"
        for star in stars
        if not star.proven
    ]
    return wide, notes


def _fitting(a: Star, width_a: float, b: Star, width_b: float) -> tuple[float, float]:
    """The widths, or smaller ones with which the shells are disjoint; 0 where none were found."""
    enough = width_a + width_b
    if float(np.linalg.norm(a.center - b.center)) - a.outer - b.outer >= enough:
        return width_a, width_b
    if a.pieces and b.pieces:
        gap = separation(a, b, enough)
        if gap >= enough:
            return width_a, width_b
        if gap > 0.0:
            half = 0.49 * gap
            return min(width_a, max(half, 0.98 * gap - width_b)), min(width_b, max(half, 0.98 * gap - width_a))
    share = 1.0
    while disjoint(a, share * width_a, b, share * width_b) is not True:
        share *= 0.5
        if share < 1e-6:
            return 0.0, 0.0
    if share < 1.0:  # proven at share, not at twice that
        high = 2.0 * share
        while high - share > 0.15 * share:
            middle = 0.5 * (share + high)
            if disjoint(a, middle * width_a, b, middle * width_b) is True:
                share = middle
            else:
                high = middle
    return share * width_a, share * width_b


def wall_gap(star: Star, wall: Array) -> float:
    """A lower bound of the distance from a star to a wall (n + 2,), metres."""
    if wall[-1] > 0.0:
        return float(wall[-1] - np.linalg.norm(star.center - wall[:-2])) - star.outer
    return float(star.center @ wall[:-2] - wall[-2] - star.support(-wall[:-2]))


def touching(a: Star, b: Star) -> bool:
    """Whether two stars touch, overlap, or come so near that they cannot be told apart."""
    if a.pieces and b.pieces and separation(a, b, 1e-12) > 0.0:
        return False
    return disjoint(a, 0.0, b, 0.0) is not True
