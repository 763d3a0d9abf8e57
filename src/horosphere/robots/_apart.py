"""Two links whose bodies overlap though their geometry never meets: shown for every posture, from the triangles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _placement
from ._cover import Surface
from ._kept import digest, kept
from ._robot import Limits, Link

if TYPE_CHECKING:
    from ..shapes import Mesh

Floats = NDArray[np.float64]
POINTS = 2_000
"""On the surface of the moving link, about."""
POSTURES = 150
"""Boxes of joint values looked at before giving up."""
SEEN = 0.05
"""Metres beyond which a gap is not measured."""


def least_gap(
    links: Sequence[Link], limits: Limits, surfaces: tuple[Floats | None, Floats | None], pair: tuple[int, int]
) -> float | None:
    """Metres, at most 5 cm, that the triangles (t, 3, 3) of two links keep apart at least, over all values of the joints between
    them, of which one or two move. None where that cannot be shown.

    Every point of the lower link's surface is within e / sqrt(3) of a corner of its triangles, cut to edges below e. A box of
    joint values is settled when the corners at its middle are further from the other link than that and than they can move in
    it; others are halved. Our derivation.
    """
    first, second = surfaces
    path = _path(links, *pair)
    if path is None or first is None or second is None:
        return None
    joints = [k for k in path if links[k].kind != "fixed"]
    coordinates = sorted({links[k].coordinate for k in joints})
    if not 1 <= len(coordinates) <= 2:
        return None
    below, above = (second, first) if path[0] == pair[1] else (first, second)
    search = _Search(links, limits, joints, coordinates, (min(pair), max(pair)), below, above)
    return search.bound()


def known_gap(
    links: Sequence[Link], limits: Limits, surfaces: tuple[Surface | None, Surface | None], pair: tuple[int, int]
) -> float | None:
    """The same for surfaces that are made when they are needed; what was found is kept on disk."""
    first, second = surfaces
    path = _path(links, *pair)
    if path is None or first is None or second is None:
        return None
    way = [(k.kind, k.origin, k.axis, k.multiplier, k.offset, k.coordinate) for k in (links[i] for i in path)]
    parts = [part for joint in way for part in joint]
    coordinates = sorted({links[k].coordinate for k in path if links[k].kind != "fixed"})
    key = digest(first.key, second.key, pair, *parts, limits.lower[coordinates], limits.upper[coordinates])

    def make() -> Floats:
        gap = least_gap(links, limits, (first.triangles(), second.triangles()), pair)
        return np.array([[-1.0 if gap is None else gap]])

    gap = float(kept("pairs", key, make)[0, 0])
    return gap if gap > 0.0 else None


class _Search:
    """The postures of one pair of links, and how near their surfaces come in them."""

    def __init__(
        self,
        links: Sequence[Link],
        limits: Limits,
        joints: list[int],
        coordinates: list[int],
        pair: tuple[int, int],
        below: Floats,
        above: Floats,
    ) -> None:
        self.links, self.joints, self.coordinates, self.pair = links, joints, coordinates, pair
        self.points, self.coarse = _corners(below)
        from ..shapes._forest import grow

        self.rows, self.forest = grow(_mesh(above))
        self.below, self.one = _mesh(below), above[:1, 0]
        self.q = np.clip(0.0, limits.lower, limits.upper)
        self.low, self.high = np.transpose([self._range(c, limits.lower[c], limits.upper[c]) for c in coordinates])

    def _range(self, coordinate: int, low: float, high: float) -> tuple[float, float]:
        """What there is to look at: all that the limits allow, or one turn of the joint."""
        moved = [self.links[k] for k in self.joints if self.links[k].coordinate == coordinate]
        if len(moved) > 1 or moved[0].kind != "revolute":
            return low, high
        turn = 2.0 * np.pi / abs(moved[0].multiplier)
        low = low if np.isfinite(low) else -0.5 * turn
        return low, min(high, low + turn)

    def placed(self, values: Floats) -> tuple[Any, Floats]:
        """Frames of all links, and the points in the base frame."""
        self.q[self.coordinates] = values
        frames = _placement.link_frames(self.links, self.q)
        return frames, _placement.move_points(frames[self.pair[1]], self.points)

    def distance(self, frames: Any, world: Floats, limit: float, enough: float) -> float:
        """Of the points to the other link; any value below `enough` says no more than that."""
        from ..shapes._point_kernels import least_distance

        R, at = _placement.rotation_translation(frames[self.pair[0]])
        there = np.ascontiguousarray((world - at) @ R)
        f = self.forest
        return float(least_distance(self.rows, f.nodes, f.ends, f.triangles, there, limit, enough))

    def bound(self) -> float | None:
        """A lower bound of the gap; None if the surfaces meet, or there were too many boxes."""
        if not np.isfinite(self.high - self.low).all():
            return None
        boxes, gap, seen = [(0.5 * (self.low + self.high), 0.5 * (self.high - self.low))], SEEN, 0
        while boxes:
            middle, half = boxes.pop()
            seen += 1
            if seen > POSTURES:
                return None
            frames, world = self.placed(middle)
            moved = self.moved(frames, world, half)
            need = self.coarse + float(moved.sum())
            d = self.distance(frames, world, need + min(gap, 0.005), need)
            if d > need:
                gap = min(gap, d - need)
                continue
            if d <= 0.0 or need < 1.2 * self.coarse:
                return None
            c = int(np.argmax(moved))
            half = half * np.where(np.arange(len(half)) == c, 0.5, 1.0)
            shift = np.where(np.arange(len(half)) == c, half, 0.0)
            boxes += [(middle - shift, half), (middle + shift, half)]
        # the surfaces never meet: one posture tells whether one link lies within the other in all of them
        return gap if self.outside() else None

    def moved(self, frames: Any, world: Floats, half: Floats) -> Floats:
        """How far (m) each coordinate can move a point while it stays within `half` of its value."""
        moved = np.zeros(len(self.coordinates))
        for k in self.joints:
            link = self.links[k]
            c = self.coordinates.index(link.coordinate)
            lever = 1.0
            if link.kind == "revolute":
                R, at = _placement.rotation_translation(frames[k])
                axis, x = R @ link.axis, world - at
                square = (x * x).sum(axis=1) - (x @ axis) ** 2
                lever = float(np.sqrt(max(square.max(), 0.0))) + float(moved.sum())
            moved[c] += abs(link.multiplier) * half[c] * lever
        return moved

    def outside(self) -> bool:
        """Whether the upper link does not lie within the lower one."""
        frames, _ = self.placed(0.5 * (self.low + self.high))
        inside = _placement.move_points(frames[self.pair[0]], self.one)
        R, at = _placement.rotation_translation(frames[self.pair[1]])
        return bool(self.below.signed_distance((inside - at) @ R)[0] > 0.0)


def _path(links: Sequence[Link], i: int, j: int) -> list[int] | None:
    """The links from the lower one up to, and without, the other one; None where neither hangs on the other."""
    lower, upper = max(i, j), min(i, j)
    path = [lower]
    while path[-1] > upper:
        path.append(links[path[-1]].parent)
    return path[:-1] if path[-1] == upper else None


def _mesh(triangles: Floats) -> Mesh:
    from ..shapes import Mesh

    return Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def _corners(triangles: Floats) -> tuple[Floats, float]:
    """Corners (m, 3) of the triangles cut until no edge is above e, and e / sqrt(3)."""
    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = 0.5 * float(np.linalg.norm(sides, axis=1).sum())
    edge = max(float(np.sqrt(2.0 * area / POINTS)), 0.002)
    found: list[Floats] = []
    while len(triangles):
        a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
        lengths = np.stack(
            [np.linalg.norm(b - a, axis=1), np.linalg.norm(c - b, axis=1), np.linalg.norm(a - c, axis=1)]
        )
        fine = lengths.max(axis=0) <= edge
        found.append(triangles[fine].reshape(-1, 3))
        triangles = triangles[~fine]
        longest = lengths[:, ~fine].argmax(axis=0)
        rows = np.arange(len(triangles))
        p, r, s = triangles[rows, longest], triangles[rows, (longest + 1) % 3], triangles[rows, (longest + 2) % 3]
        m = 0.5 * (p + r)
        triangles = np.concatenate([np.stack([p, m, s], axis=1), np.stack([m, r, s], axis=1)])
    return np.unique(np.concatenate(found), axis=0), edge / float(np.sqrt(3.0))
