"""Bodies to try for a cover of a mesh: balls, and capsules along straight lines through it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ._bodies import Floats, fit_capsule
from ._solid import Solid

PLACES = 300
"""Points of each sort that bodies are tried at, at most."""
LEVELS = (0.7, 1.4, 2.5)
"""Depths at which places next to the surface are tried, in tolerances. A ball at depth d next to two faces at a right angle holds
their edge if it stands out by 0.41 d."""
ALIKE = 0.9
"""An axis goes on as long as it lies this share as deep as the place it starts from."""
CUTS = (0.25, 0.375, 0.5, 0.625, 0.75)


@dataclass(frozen=True, slots=True, eq=False)
class Axes:
    """Segments a, b (c, 3), points where a == b, and how deep (c,) they lie, about."""

    a: Floats
    b: Floats
    depth: Floats

    def chosen(self, which: object) -> Axes:
        """Some of them."""
        return Axes(self.a[which], self.b[which], self.depth[which])  # type: ignore[index]

    def joined(self, other: Axes) -> Axes:
        """These and others."""
        pairs = ((self.a, other.a), (self.b, other.b), (self.depth, other.depth))
        return Axes(*(np.concatenate(pair) for pair in pairs))


def make_candidates(solid: Solid, capsules: bool, tolerance: float, rng: np.random.Generator) -> Axes:
    """Points, and if `capsules` segments too, that could be axes of bodies which stand out by about `tolerance` (m)."""
    deep = _places(solid, tolerance, rng)
    pools = (solid.vertices, solid.middles())  # between the surfaces of thin parts lies no cell
    skin = np.concatenate([pool[rng.permutation(len(pool))[: PLACES // 2]] for pool in pools])
    points = np.concatenate([deep, skin])
    a = b = points
    if capsules:
        directions = _directions(solid)
        parts = [(points, points), _round_halves(solid, directions), _grown(solid, deep, directions)]
        a, b = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    return Axes(a, b, depth_along(solid, a, b))


def depth_along(solid: Solid, a: Floats, b: Floats) -> Floats:
    """Least depth (c,) in the solid at points of segments, three cells apart."""
    length = np.linalg.norm(b - a, axis=1)
    counts = np.clip(np.ceil(length / (3.0 * solid.cell)).astype(int) + 1, 1, 60)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    rank = np.arange(counts.sum()) - np.repeat(starts, counts)
    t = rank / np.repeat(np.maximum(counts - 1, 1), counts)
    x = np.repeat(a, counts, axis=0) + t[:, None] * np.repeat(b - a, counts, axis=0)
    return np.minimum.reduceat(solid.depth(x), starts)


def _places(solid: Solid, tolerance: float, rng: np.random.Generator) -> Floats:
    """Cells deeper than those round them, any cells, and those next to the surface that lie deeper than a ball needs to be to
    hold an edge or a corner there."""
    from scipy.spatial import cKDTree

    if not len(solid.inside):
        return np.zeros((0, 3))
    found = [pool[rng.permutation(len(pool))[: PLACES // 2]] for pool in (solid.deepest(), solid.inside)]
    depth, middles = solid.rough_depth(solid.inside), solid.middles()
    for level in LEVELS:
        cells = solid.inside[depth >= level * tolerance]
        if len(cells):
            nearest = np.unique(cKDTree(cells).query(middles)[1])
            found.append(cells[nearest[rng.permutation(len(nearest))[:PLACES]]])
    return np.concatenate(found)


def _directions(solid: Solid) -> Floats:
    """The axes of the frame and the principal ones, without those that are nearly the same."""
    centered = solid.points - solid.points.mean(axis=0)
    found = list(np.linalg.eigh(centered.T @ centered)[1].T[::-1])
    for axis in np.eye(3):
        if max(abs(float(axis @ other)) for other in found) < 0.99:
            found.append(axis)
    return np.array(found)


def _grown(solid: Solid, places: Floats, directions: Floats) -> tuple[Floats, Floats]:
    """Through each place and along each direction the longest segment that lies about as deep as the place."""
    if not len(places):
        return places, places
    origins = np.repeat(places, len(directions), axis=0)
    along = np.tile(directions, (len(places), 1))
    reach = float(np.linalg.norm(np.ptp(solid.points, axis=0)))
    count = int(np.ceil(reach / solid.cell))
    steps = np.arange(1, count + 1) * solid.cell
    least = ALIKE * solid.rough_depth(origins)
    ends = []
    for sign in (-1.0, 1.0):
        x = origins[:, None] + (sign * steps)[None, :, None] * along[:, None]
        stays = solid.rough_depth(x.reshape(-1, 3)).reshape(len(origins), count) >= least[:, None]
        go = np.where(stays.all(axis=1), count, stays.argmin(axis=1))
        ends.append(origins + (sign * solid.cell * go)[:, None] * along)
    place = np.round(np.concatenate(ends, axis=1) / (1.5 * solid.cell)).astype(np.int64)
    unlike = np.unique(place, axis=0, return_index=True)[1]
    return ends[0][unlike], ends[1][unlike]


def _round_halves(solid: Solid, directions: Floats) -> tuple[Floats, Floats]:
    """Axes of small capsules round everything, and round what lies on either side of planes across the directions."""
    middles, points = solid.middles(), solid.points
    middles = middles[:: max(len(middles) // 1_500, 1)]
    sets = [np.ones(len(middles), bool)]
    for axis in directions[:3]:
        height = middles @ axis
        for share in CUTS:
            below = height < height.min() + share * np.ptp(height)
            sets += [side for side in (below, ~below) if side.sum() >= 2]
    spread = np.random.default_rng(0).normal(size=(64, 3))
    found = []
    for pieces in sets:
        own = points if pieces.all() else middles[pieces]
        outer = own[np.unique((own @ spread.T).argmax(axis=0))]
        found.append(fit_capsule(outer, rounds=20))
    return np.array([body.a for body in found]), np.array([body.b for body in found])
