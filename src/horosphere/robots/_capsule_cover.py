"""A cover of a mesh by capsules: the mesh is cut where that saves most volume, one capsule a part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ._bodies import GRAIN, Body, fit_capsule
from ._solid import Solid

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
CUTS = (0.12, 0.25, 0.375, 0.5, 0.625, 0.75, 0.88)
WORTH = 0.06
"""A cut must save this part of the whole volume."""


@dataclass(slots=True)
class Part:
    """Pieces of the solid, the capsule round them, and the best way to cut them in two."""

    pieces: Mask
    body: Body
    volume: float
    gain: float = 0.0
    halves: tuple[Mask, Mask] | None = None


def cover_by_capsules(solid: Solid, budget: int, tolerance: float, seed: int = 0) -> tuple[list[Body], float]:
    """At most `budget` capsules that hold the solid, and their slack: parts are cut in two by planes, always where that saves
    most volume, until the slack is below `tolerance` (m), the budget spent, or nothing gained. Our derivation."""
    directions = np.random.default_rng(seed).normal(size=(96, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    middles = solid.middles()
    parts = [_part(solid, middles, directions, np.ones(len(middles), bool))]
    whole = parts[0].volume
    while len(parts) < budget and slack_of([part.body for part in parts], solid) > tolerance:
        part = max(parts, key=lambda p: p.gain)
        if part.halves is None or part.gain < WORTH * whole:
            break
        parts.remove(part)
        parts += [_part(solid, middles, directions, half) for half in part.halves]
    parts = _exchange(solid, parts, directions)
    bodies = [part.body for part in parts]
    return bodies, slack_of(bodies, solid)


def slack_of(bodies: list[Body], solid: Solid) -> float:
    """How far capsules stand out of the solid, at most: r - depth along the axes, sampled, plus half a step for what is
    between (the depth changes by no more than the distance)."""
    worst = 0.0
    for body in bodies:
        length = float(np.linalg.norm(body.b - body.a))
        steps = int(np.clip(np.ceil(length / (0.25 * solid.cell)), 1, 400))
        along = body.a + np.linspace(0.0, 1.0, steps + 1)[:, None] * (body.b - body.a)
        worst = max(worst, float(np.max(body.radius - solid.depth(along))) + 0.5 * length / steps)
    return worst


def volume_of(body: Body) -> float:
    """Over pi."""
    return body.radius**2 * (float(np.linalg.norm(body.b - body.a)) + 4.0 / 3.0 * body.radius)


def round_points(points: Floats, directions: Floats) -> Body:
    """A capsule round all points: fitted to the outermost in many directions, then enlarged to the last of them."""
    body = fit_capsule(_outermost(points, directions), refine=12)
    return Body(body.a, body.b, float(_distance(points, body).max()) + GRAIN)


def _distance(points: Floats, body: Body) -> Floats:
    u = body.b - body.a
    t = np.clip((points - body.a) @ u / max(float(u @ u), 1e-300), 0.0, 1.0)
    return np.linalg.norm(points - body.a - t[:, None] * u, axis=1)


def _outermost(points: Floats, directions: Floats) -> Floats:
    return points[np.unique((points @ directions.T).argmax(axis=0))]


def _part(solid: Solid, middles: Floats, directions: Floats, pieces: Mask) -> Part:
    body = round_points(solid.points_of(pieces), directions)
    part = Part(pieces, body, volume_of(body))
    own = middles[pieces]
    if len(own) < 4:
        return part
    rough = volume_of(fit_capsule(_outermost(own, directions), rounds=30))
    for axis in np.linalg.svd(own - own.mean(axis=0), full_matrices=False)[2]:
        height = own @ axis
        for share in CUTS:
            below = height < height.min() + share * np.ptp(height)
            if not 2 <= below.sum() <= len(own) - 2:
                continue
            sides = [fit_capsule(_outermost(own[side], directions), rounds=30) for side in (below, ~below)]
            gain = (rough - sum(map(volume_of, sides))) * part.volume / max(rough, 1e-300)
            if gain > part.gain:
                first, second = np.zeros_like(pieces), np.zeros_like(pieces)
                first[np.flatnonzero(pieces)[below]] = second[np.flatnonzero(pieces)[~below]] = True
                part.gain, part.halves = gain, (first, second)
    return part


def _exchange(solid: Solid, parts: list[Part], directions: Floats, rounds: int = 3) -> list[Part]:
    """Give each piece to the capsule that it lies deepest in, and fit again, as long as that saves volume."""
    for _ in range(rounds if len(parts) > 1 else 0):
        need = np.array([solid.most(_distance(solid.points, p.body)) - p.body.radius for p in parts])
        owner = need.argmin(axis=0)
        groups = [owner == k for k in np.unique(owner)]
        bodies = [round_points(solid.points_of(group), directions) for group in groups]
        if sum(map(volume_of, bodies)) >= 0.999 * sum(part.volume for part in parts):
            break
        parts = [Part(group, body, volume_of(body)) for group, body in zip(groups, bodies)]
    return parts
