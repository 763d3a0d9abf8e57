"""All directions of R^n in small cells, for statements that must hold in every one of them and not only on samples."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ._directions import unit

if TYPE_CHECKING:
    from ._star import Star

Array = NDArray[np.float64]
MOST_CELLS = 20_000
"""At once; beyond it a question stays open."""


def first_cells(n: int) -> tuple[Array, float]:
    """Middles (2 n, n) of the faces of the cube [-1, 1]^n and half their side; a cell stands for the directions through it."""
    return np.concatenate([np.eye(n), -np.eye(n)]), 1.0


def halved(middles: Array, half: float) -> tuple[Array, float]:
    """Every cell in 2^(n-1) of half its side."""
    n = middles.shape[1]
    corners = np.stack(np.meshgrid(*[(-0.5 * half, 0.5 * half)] * (n - 1), indexing="ij"), axis=-1).reshape(-1, n - 1)
    face = np.abs(np.abs(middles) - 1.0).argmin(axis=1)
    across = np.array([[k for k in range(n) if k != f] for f in range(n)])[face]
    out = np.repeat(middles[:, None], len(corners), axis=1)
    rows = np.arange(len(middles))[:, None]
    out[rows[..., None], np.arange(len(corners))[None, :, None], across[:, None, :]] += corners
    return out.reshape(-1, n), 0.5 * half


def cover(middles: Array, half: float) -> tuple[Array, Array]:
    """Unit directions (k, n) of the cells and angles (k,) within which all directions of each cell lie."""
    u, away = unit(middles)
    # a point of the cell is within half sqrt(n-1) of its middle: seen from the origin under at most this angle
    return u, np.arcsin(np.minimum(half * np.sqrt(middles.shape[1] - 1.0) / away, 1.0))


def grid(n: int, most: int = 1500) -> tuple[Array, Array]:
    """`cover` of equal cells, at most about `most` of them."""
    middles, half = first_cells(n)
    while len(middles) * 2 ** (n - 1) <= most:
        middles, half = halved(middles, half)
    return cover(middles, half)


def extreme_radii(star: Star) -> tuple[float, float]:
    """Bounds (low, high) of the star's radii: to 2 % where `MOST_CELLS` cells do, else as near as they come; low may fall below 0."""
    for within in (0.02, 0.1, 0.4):
        low, high, closed = _extremes(star, within)
        if closed:
            break
    return low, high


def _extremes(star: Star, within: float) -> tuple[float, float, bool]:
    middles, half = first_cells(star.dimension)
    steep, low, high, least, most = star.steepness, np.inf, 0.0, np.inf, 0.0
    while True:
        u, angle = cover(middles, half)
        r = star.radial(u)[0]
        least, most = min(least, float(r.min())), max(most, float(r.max()))
        below, above = r - steep * angle, r + steep * angle
        open_ = (below < (1.0 - within) * least) | (above > (1.0 + within) * most)
        closed = not open_.any()
        if closed or open_.sum() * 2 ** (star.dimension - 1) > MOST_CELLS:
            return min(low, float(below.min())), max(high, float(above.max())), closed
        low, high = min(low, float(below[~open_].min(initial=np.inf))), max(high, float(above[~open_].max(initial=0.0)))
        middles, half = halved(middles[open_], half)


def disjoint(a: Star, width_a: float, b: Star, width_b: float) -> bool | None:
    """Whether the shells r < r_a(u) + width_a and r < r_b(u) + width_b of two stars have no common point; None: not resolved.

    A star is connected: if the outer boundary of the one meets nothing of the other and does not go around its centre, they are
    disjoint. On a cell of directions within angle t the boundary of a lies within t sqrt((r + S_a t)^2 + S_a^2) of its middle, S the
    bound of |grad r|. The middle, a distance l beyond b's shell on the ray from b's centre, is at least l / sqrt(1 + (S_b / r_b)^2)
    away from it, r_b the radius of the shell there: on the way the radius is not below r_b, so that l changes by no more than
    sqrt(1 + (S_b / r_b)^2) a metre. Cells that this does not settle are halved. Up to rounding.
    """
    if float(a.level(b.center)) <= width_a:
        return False
    middles, half = first_cells(a.dimension)
    steep_a, steep_b = a.steepness, b.steepness
    while True:
        u, angle = cover(middles, half)
        r = a.radial(u)[0] + width_a
        x = a.center + r[:, None] * u
        v, away = unit(x - b.center)
        shell = b.radial(v)[0] + width_b
        beyond = away - shell
        if beyond.min() <= 0.0:
            return False
        reach = angle * np.hypot(r + steep_a * angle, steep_a)
        free = beyond / np.hypot(1.0, steep_b / shell)
        if b.convex:
            free = np.maximum(free, b.distance(x) - width_b)
        open_ = reach >= free
        if not open_.any():
            return True
        if open_.sum() * 2 ** (a.dimension - 1) > MOST_CELLS or half < 1e-9:
            return None
        middles, half = halved(middles[open_], half)
