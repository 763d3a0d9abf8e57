"""Gaps between security zones, and how wide the shells around the stars may be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..maps import Star
from ..maps._directions import directions, unit

Array = NDArray[np.float64]


def separation(a: Star, b: Star, enough: float = np.inf) -> float:
    """A lower bound of the distance between two stars, metres: the best separating slab found; stops once `enough`.

    For unit w the slab between them is w . (c_b - c_a) - h_a(w) - h_b(-w) wide, h the supports: exact at the best w for convex
    bodies, and not above 0 where one reaches into a bay of the other.
    """
    between = b.center - a.center
    simple = float(np.linalg.norm(between)) - a.outer - b.outer
    if simple >= enough:
        return simple

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
    return max(value, simple)


def apart(a: Star, b: Star, width_a: float, width_b: float) -> bool:
    """Whether the shells of a and b are disjoint, by sampling both outer boundaries (no proof)."""
    u = directions(a.dimension)
    for one, other, w1, w2 in ((a, b, width_a, width_b), (b, a, width_b, width_a)):
        r = one.radial(u)[0] + w1
        spacing = 0.01 * float(r.max()) if a.dimension == 2 else 0.05 * float(r.max())
        if float(other.level(one.center + r[:, None] * u).min()) - w2 < spacing:
            return False
    return True


def shell_widths(stars: Sequence[Star], centers: Array, radii: Array, walls: Array) -> tuple[Array, list[str]]:
    """The widths of disjoint shells, half the outer radius where there is room, and what was only sampled."""
    wide = np.array([0.5 * star.outer for star in stars])
    notes: list[str] = []
    for i, star in enumerate(stars):
        for center, radius in zip(centers, radii):
            near = float(np.linalg.norm(center - star.center)) - radius - star.outer
            if near < wide[i]:
                wide[i] = min(wide[i], 0.98 * ball_gap(star, center, radius))
        for wall in walls:
            wide[i] = min(wide[i], 0.98 * wall_gap(star, wall))
    for i, a in enumerate(stars):
        for j in range(i):
            b = stars[j]
            gap = separation(a, b, wide[i] + wide[j])
            if gap > 1e-3 * (wide[i] + wide[j]):
                if gap < wide[i] + wide[j]:
                    half = 0.49 * gap
                    wide[i], wide[j] = (
                        min(wide[i], max(half, 0.98 * gap - wide[j])),
                        min(wide[j], max(half, 0.98 * gap - wide[i])),
                    )
                continue
            share = 1.0
            while share > 1e-3 and not apart(a, b, share * wide[i], share * wide[j]):
                share *= 0.7
            wide[i], wide[j] = share * wide[i], share * wide[j]
            notes.append(f"shells of {a.name} and {b.name} reach into each other's bays: disjoint by sampling only")
    return wide, notes


def ball_gap(star: Star, center: Array, radius: float) -> float:
    """A lower bound of the distance between a star and a ball, metres."""
    from ..maps import RoundHull

    ball = RoundHull(center, np.zeros(len(center)), radius, radius)
    gap = separation(star, ball)
    if gap > 0.0:
        return gap
    share = 0.5 * star.outer
    while share > 1e-4 * star.outer and not apart(star, ball, share, 1e-9):
        share *= 0.7
    return share if share > 1e-4 * star.outer else gap


def wall_gap(star: Star, wall: Array) -> float:
    """A lower bound of the distance from a star to a wall (n + 2,), metres."""
    if wall[-1] > 0.0:
        return float(wall[-1] - np.linalg.norm(star.center - wall[:-2])) - star.outer
    return float(star.center @ wall[:-2] - wall[-2] - star.support(-wall[:-2]))


def touching(a: Star, b: Star) -> bool:
    """Whether two stars touch or overlap, as far as slabs and sampling can tell."""
    if separation(a, b, 1e-12) > 0.0:
        return False
    u = directions(a.dimension)
    pairs = ((a, b), (b, a))
    return any(
        float(q.level(p.center + p.radial(u)[0][:, None] * u).min()) <= 0.0 or q.contains(p.center) for p, q in pairs
    )
