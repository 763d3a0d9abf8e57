"""How far a cover stands out of the solid that it covers: an upper bound."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._bodies import Body, Floats
from ._solid import Solid, corners_of, depth_along

GRAIN = 3e-4
"""Metres, or a thirtieth: the bound is no more than this above the distance of a point that was seen."""


def slack_of(bodies: list[Body], solid: Solid) -> float:
    """No point of the capsules is further (m) from the solid than this, and some point is nearly as far.

    A ball of radius r about a point at depth d stands out by at most r - d. Bodies for which that is too much are cut
    into cubes: the distance to the solid changes by no more than the way, so in a cube it is at most that of the point of the
    body nearest to its middle, and half the diagonal. Cubes that may hold a point further out than the furthest seen are cut in eight.
    """
    if not bodies:
        return 0.0
    a, b = np.array([body.a for body in bodies]), np.array([body.b for body in bodies])
    radius = np.array([body.radius for body in bodies])
    bound = radius - depth_along(solid, a, b) + 0.25 * solid.cell  # between the points of an axis
    seen = 0.0
    half = 0.5 * float(radius.mean())
    body, centre = _cubes(np.minimum(a, b) - radius[:, None], np.maximum(a, b) + radius[:, None], half)
    while len(body):
        foot = _feet(centre, a[body], b[body])
        away = np.linalg.norm(centre - foot, axis=1)
        diagonal = 3.0**0.5 * half
        inside = away <= radius[body] + diagonal
        body, centre, foot, away = body[inside], centre[inside], foot[inside], away[inside]
        nearest = foot + (centre - foot) * np.minimum(1.0, radius[body] / np.maximum(away, 1e-12))[:, None]
        out = solid.away(nearest)
        seen = max(seen, float(out.max(initial=0.0)))
        grain = max(GRAIN, 0.03 * seen)
        rest = (out + diagonal > seen + grain) & (bound[body] > seen + grain)
        half *= 0.5
        body = np.repeat(body[rest], 8)
        centre = corners_of(centre[rest] - half, centre[rest] + half).reshape(-1, 3)
    return seen + max(GRAIN, 0.03 * seen)


def _cubes(low: Floats, high: Floats, half: float) -> tuple[NDArray[np.int64], Floats]:
    """Middles of cubes that fill boxes (k, 3), and the box of each."""
    owners, middles = [], []
    for k in range(len(low)):
        axes = [
            low[k, c] + half * (2.0 * np.arange(np.ceil((high[k, c] - low[k, c]) / (2.0 * half))) + 1.0)
            for c in range(3)
        ]
        found = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        owners.append(np.full(len(found), k))
        middles.append(found)
    return np.concatenate(owners), np.concatenate(middles)


def _feet(x: Floats, a: Floats, b: Floats) -> Floats:
    """The point of each segment a, b (m, 3) that is nearest to x (m, 3)."""
    u = b - a
    t = ((x - a) * u).sum(axis=1) / np.maximum((u * u).sum(axis=1), 1e-300)
    return a + np.clip(t, 0.0, 1.0)[:, None] * u
