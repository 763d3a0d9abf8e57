"""Seeded random worlds on which the guarantees are tried and the peers compared.

Families: 20 discs; 60 balls in R^3; 80 balls in R^4; 60 balls in R^6; 8 flat ellipses; 8 lobed stars; 9 plates in R^3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import unknown_name
from ..maps import Star, ellipsoid, lobed
from ..maps._cells import disjoint
from ..numeric import whole_number
from ._merge import as_star
from ._shells import separation

Array = NDArray[np.float64]
FAMILIES = ("discs", "balls", "balls-4d", "balls-6d", "flat-ellipses", "lobed-stars", "plates")
_BALLS = {
    "discs": (2, 20, 0.3, 0.8),
    "balls": (3, 60, 0.5, 1.1),
    "balls-4d": (4, 80, 0.6, 1.4),
    "balls-6d": (6, 60, 1.0, 2.2),
}
BOX, GAP = 10.0, 0.03


@dataclass(frozen=True, slots=True, eq=False)
class RandomWorld:
    """A start and a goal (n,) in [0, 10]^n, at least 6 m apart and outside the disjoint obstacles between them."""

    family: str
    seed: int
    start: Array
    goal: Array
    obstacles: Any


def random_world(family: str, seed: int) -> RandomWorld:
    """The world of `family` with this seed: see the module's families.

    Zones keep gaps of at least 0.03 m. Raises InputError for an unknown family.
    """
    if family not in FAMILIES:
        raise unknown_name("family", family, FAMILIES, place="family")
    rng = np.random.default_rng([FAMILIES.index(family), whole_number(seed, "seed", 0)])
    n = _BALLS[family][0] if family in _BALLS else 3 if family == "plates" else 2
    while True:
        start, goal = rng.uniform(0.5, BOX - 0.5, (2, n))
        if np.linalg.norm(start - goal) >= 6.0:
            break
    if family in _BALLS:
        _, count, low, high = _BALLS[family]
        centers, radii = _scatter(rng, start, goal, count, low, high)
        return RandomWorld(family, seed, start, goal, (centers, radii))
    return RandomWorld(family, seed, start, goal, _scatter_stars(rng, start, goal, family))


def _scatter(rng, start: Array, goal: Array, count: int, low: float, high: float) -> tuple[Array, Array]:
    centers: list[Array] = []
    radii: list[float] = []
    while len(centers) < count:
        c, r = rng.uniform(0.0, BOX, len(goal)), float(rng.uniform(low, high))
        if min(np.linalg.norm(c - start), np.linalg.norm(c - goal)) < r + GAP:
            continue
        if centers and (np.linalg.norm(np.array(centers) - c, axis=1) - np.array(radii) - r).min() < GAP:
            continue
        centers.append(c)
        radii.append(r)
    return np.array(centers), np.array(radii)


def _scatter_stars(rng, start: Array, goal: Array, family: str) -> list[Star]:
    stars: list[Star] = []
    n = len(goal)
    count, tries = (9 if family == "plates" else 8), 0
    # plates stand in clusters of three around a common middle; the others lie about the way to the goal
    middles = [start + t * (goal - start) + rng.normal(0.0, 0.6, n) for t in (0.25, 0.5, 0.75)]
    while len(stars) < count and tries < 4000:
        tries += 1
        name = f"{family} {len(stars)}"
        if family == "plates":
            turn = np.linalg.qr(rng.standard_normal((n, n)))[0]
            center = middles[len(stars) % 3] + rng.uniform(-1.2, 1.2, n)
            star: Star = ellipsoid(
                center, [rng.uniform(0.6, 1.2), rng.uniform(0.6, 1.2), rng.uniform(0.06, 0.12)], turn, name=name
            )
        else:
            center = middles[int(rng.integers(3))] + rng.uniform(-2.5, 2.5, n)
            if family == "flat-ellipses":
                a = rng.uniform(0.0, np.pi)
                turn = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
                star = ellipsoid(center, [rng.uniform(0.8, 1.4), rng.uniform(0.08, 0.14)], turn, name=name)
            else:
                lobes = int(rng.integers(3, 7))
                star = lobed(
                    center, rng.uniform(0.5, 0.9), rng.uniform(0.2, 0.45), lobes, rng.uniform(0.0, 6.28), name=name
                )
        if min(star.level(start), star.level(goal)) < 0.1 or not all(_clear(star, other) for other in stars):
            continue
        stars.append(star)
    return stars


def _clear(a: Star, b: Star) -> bool:
    if a.convex:
        return separation(a, b, GAP) >= GAP
    return disjoint(a, 0.5 * GAP, b, 0.5 * GAP) is True


def as_stars(world: RandomWorld) -> list[Star]:
    """The obstacles as stars, for peers that want outlines."""
    if isinstance(world.obstacles, tuple):
        return [as_star((c, float(r), f"ball {k}")) for k, (c, r) in enumerate(zip(*world.obstacles))]
    return list(world.obstacles)
