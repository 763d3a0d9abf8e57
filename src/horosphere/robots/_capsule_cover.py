"""A cover of a mesh by capsules: the mesh is cut where that saves most, one capsule a part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ._bodies import GRAIN, Body, distance_to_axis, fit_capsule
from ._slack import slack_of
from ._solid import Solid

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
CUTS = (0.12, 0.25, 0.375, 0.5, 0.625, 0.75, 0.88)
SCALES = (1.0, 1.04, 1.1, 1.2, 1.35)
SAMPLES = 4_000
WORTH = 0.03
"""A cut must save this part of the excess."""


@dataclass(slots=True, eq=False)
class Part:
    """Pieces of the solid, the capsule round them, its excess, and the best way to cut them in two."""

    pieces: Mask
    body: Body
    excess: float
    gain: float = 0.0
    halves: tuple[Mask, Mask] | None = None


class _Fitter:
    """Capsules round parts of a solid. The excess of capsules is the integral, over what they hold beyond the solid, of the
    distance to it, by seeded random points: it punishes volume, and what stands out far most."""

    def __init__(self, solid: Solid, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.solid = solid
        self.middles = solid.middles()
        self.directions = rng.normal(size=(96, 3))
        self.directions /= np.linalg.norm(self.directions, axis=1)[:, None]
        low, high = solid.points.min(axis=0), solid.points.max(axis=0)
        room = 0.25 * np.sort(high - low)[1] + solid.cell
        x = rng.uniform(low - room, high + room, (SAMPLES, 3))
        beyond = np.maximum(-solid.depth(x), 0.0)
        self.x, self.weight = x[beyond > 0.0], beyond[beyond > 0.0]

    def excess(self, *bodies: Body) -> float:
        held = np.zeros(len(self.x), bool)
        for body in bodies:
            held |= distance_to_axis(self.x, body) <= body.radius
        return float(self.weight[held].sum())

    def outermost(self, points: Floats) -> Floats:
        return points[np.unique((points @ self.directions.T).argmax(axis=0))]

    def body(self, pieces: Mask) -> Body:
        """Round all points of the pieces: the axis fits the outermost in many directions, the radius is the one of `SCALES`
        times the least that has the least excess, the ends follow from it."""
        points = self.solid.points_of(pieces)
        first = fit_capsule(self.outermost(points), rounds=50, refine=12)
        u = first.b - first.a
        length = float(np.linalg.norm(u))
        if length < 1e-9:
            return Body(first.a, first.b, float(distance_to_axis(points, first).max()) + GRAIN)
        u = u / length
        along = (points - first.a) @ u
        square = ((points - first.a) ** 2).sum(axis=1) - along**2
        least = float(np.sqrt(max(square.max(), 0.0)))
        found = []
        for radius in (least * scale for scale in SCALES):
            give = np.sqrt(np.maximum(radius**2 - square, 0.0))
            low, high = float((along + give).min()), float((along - give).max())
            if low > high:
                low = high = 0.5 * (low + high)
            body = Body(first.a + low * u, first.a + high * u, radius)
            found.append((self.excess(body), body))
        body = min(found, key=lambda item: item[0])[1]
        return Body(body.a, body.b, float(distance_to_axis(points, body).max()) + GRAIN)

    def part(self, pieces: Mask) -> Part:
        body = self.body(pieces)
        part = Part(pieces, body, self.excess(body))
        own = self.middles[pieces]
        if len(own) < 4:
            return part
        rough = self.excess(fit_capsule(self.outermost(own), rounds=14))
        for axis in np.linalg.svd(own - own.mean(axis=0), full_matrices=False)[2]:
            height = own @ axis
            for share in CUTS:
                below = height < height.min() + share * np.ptp(height)
                if not 2 <= below.sum() <= len(own) - 2:
                    continue
                sides = [fit_capsule(self.outermost(own[side]), rounds=14) for side in (below, ~below)]
                gain = rough - self.excess(*sides)
                if gain > part.gain:
                    first, second = np.zeros_like(pieces), np.zeros_like(pieces)
                    first[np.flatnonzero(pieces)[below]] = second[np.flatnonzero(pieces)[~below]] = True
                    part.gain, part.halves = gain, (first, second)
        return part


def cover_by_capsules(solid: Solid, budget: int, tolerance: float, seed: int = 0) -> tuple[list[Body], float]:
    """At most `budget` capsules that hold the solid, and their slack: parts are cut in two by planes, always where that saves
    most excess, until the slack is below `tolerance` (m), the budget spent, or too little gained. Our derivation."""
    fitter = _Fitter(solid, seed)
    parts = [fitter.part(np.ones(len(fitter.middles), bool))]
    while len(parts) < budget and slack_of([part.body for part in parts], solid) > tolerance:
        part = max(parts, key=lambda p: p.gain)
        if part.halves is None or part.gain < WORTH * sum(p.excess for p in parts):
            break
        parts.remove(part)
        parts += [fitter.part(half) for half in part.halves]
    bodies = _exchange(fitter, [part.body for part in parts])
    return bodies, slack_of(bodies, solid)


def _exchange(fitter: _Fitter, bodies: list[Body], rounds: int = 3) -> list[Body]:
    """Give each piece to the capsule that it lies deepest in, and fit again, as long as that saves excess."""
    solid, best = fitter.solid, fitter.excess(*bodies)
    for _ in range(rounds if len(bodies) > 1 else 0):
        need = np.array([solid.most(distance_to_axis(solid.points, body)) - body.radius for body in bodies])
        owner = need.argmin(axis=0)
        found = [fitter.body(owner == k) for k in np.unique(owner)]
        excess = fitter.excess(*found)
        if excess >= 0.999 * best:
            break
        bodies, best = found, excess
    return bodies
