"""Conservative capsules: collision geometry lies inside them, and each says how far it stands out (its slack)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numeric import at_most

Floats = NDArray[np.float64]
GRAIN = 1e-9
"""Radii are enlarged by this (metres): rounding must not put a corner outside."""
_SCAN = 1.0 + np.linspace(0.0, 1.0, 61) ** 2 * 1.5


@dataclass(frozen=True, slots=True)
class Body:
    """A capsule in some frame, where it came from, and how far it stands out of what it holds at most (m)."""

    a: Floats
    b: Floats
    radius: float
    note: str = ""
    slack: float = 0.0

    def moved(self, rotation: Floats, translation: Floats) -> Body:
        """The capsule turned, then shifted."""
        return Body(
            rotation @ self.a + translation, rotation @ self.b + translation, self.radius, self.note, self.slack
        )


def distance_to_axis(points: Floats, body: Body) -> Floats:
    """Distance (m,) of points (m, 3) to the segment of a capsule."""
    u = body.b - body.a
    t = np.clip((points - body.a) @ u / max(float(u @ u), 1e-300), 0.0, 1.0)
    return np.linalg.norm(points - body.a - t[:, None] * u, axis=1)


def fit_segment(along: Floats, across: Floats, pad: Floats | float = 0.0) -> tuple[float, float, float]:
    """Capsule on a given axis, of least volume, round balls at heights `along` and distances `across` from that axis.

    Returns (low, high, radius). For a radius r >= max(across + pad), ball k lies inside iff the segment comes within
    sqrt((r - pad)^2 - across^2) of its height; so the shortest segment is known for each r, and r is scanned.
    """
    least = float(np.max(across + pad))
    radii = (least * _SCAN)[:, None]
    give = np.sqrt(np.maximum((radii - pad) ** 2 - across**2, 0.0))
    low, high = np.min(along + give, axis=1), np.max(along - give, axis=1)
    low, high = np.where(low > high, 0.5 * (low + high), [low, high])
    volume = radii[:, 0] ** 2 * (high - low + 4.0 / 3.0 * radii[:, 0])
    k = int(np.argmin(volume))
    return float(low[k]), float(high[k]), float(radii[k, 0]) + GRAIN


def enclosing_ball(centers: Floats, radii: Floats) -> Floats:
    """Centre and radius (4,) of a small ball that holds balls (m, 3), (m,): stepping towards the furthest."""
    best, radius = centers[0], np.inf
    center = 0.5 * ((centers - radii[:, None]).min(axis=0) + (centers + radii[:, None]).max(axis=0))
    for k in range(60):
        reach = np.linalg.norm(centers - center, axis=1) + radii
        far = int(np.argmax(reach))
        if reach[far] < radius:
            best, radius = center, float(reach[far])
        center = center + (centers[far] - center) / (k + 3.0)
    return np.array([*best, radius + GRAIN])


def from_sphere(radius: float) -> list[Body]:
    """A ball is a capsule of length zero: exact."""
    return [Body(np.zeros(3), np.zeros(3), radius, "sphere, exact")]


def as_balls(body: Body, most: int, tolerance: float = 0.005) -> list[Body]:
    """At most `most` balls along a capsule that hold it, no more than a slack of `tolerance` (m) needs.

    With the outermost at its ends, balls of radius R hold a capsule of radius r if R^2 = r^2 + (half their distance)^2.
    """
    length = float(np.linalg.norm(body.b - body.a))
    if length < 1e-9:
        return [Body(body.a, body.a, body.radius + length, body.note, body.slack + length)]
    gaps = int(np.ceil(0.5 * length / np.sqrt(2.0 * body.radius * tolerance + tolerance**2)))
    gaps = min(gaps, most - 1)
    radius = float(np.hypot(body.radius, 0.5 * length / gaps)) if gaps else body.radius + 0.5 * length
    places = body.a + (np.linspace(0.0, 1.0, gaps + 1) if gaps else np.array([0.5]))[:, None] * (body.b - body.a)
    larger = radius + GRAIN - body.radius
    note = f"{body.note}; as balls, {at_most(larger, decimals=4)} m larger"
    return [Body(p, p, radius + GRAIN, note, body.slack + larger) for p in places]


def from_cylinder(radius: float, length: float, tolerance: float = np.inf) -> list[Body]:
    """A capsule round a cylinder along z: of least volume of those with a slack of at most `tolerance` (m), or else the one with
    the least.

    About an axis inside, a capsule of radius R stands out of the sides by R - radius, and of the flat ends, whose rims it holds, by
    R - sqrt(R^2 - radius^2): the wider, the less. It is a ball where its ends meet. Our derivation.
    """
    half = 0.5 * length
    _, end, r = fit_segment(np.array([-half, half]), np.array([radius, radius]))
    if r - min(radius, half - end) > tolerance:
        most = tolerance - 2.0 * GRAIN
        wide = (radius**2 + most**2) / (2.0 * most) if most > 0.0 else np.inf
        r = min(wide, 2.0**0.5 * radius, float(np.hypot(radius, half)))
        end = max(half - float(np.sqrt(max(r**2 - radius**2, 0.0))), 0.0)
        r += GRAIN
    z = np.array([0.0, 0.0, 1.0])
    slack = r - min(radius, half - end)  # as for a box
    return [Body(-end * z, end * z, r, f"cylinder, slack at most {at_most(slack, decimals=4)} m", slack)]


def from_box(size: Floats, most: int = 8) -> list[Body]:
    """Parallel capsules along the longest side, enough of them that none is much wider than the shortest.

    The distance to a convex solid is convex, so a capsule stands out most about one of its ends: by its radius less the depth of
    that end, since the face nearest to it is the one that is passed furthest.
    """
    order = np.argsort(size)[::-1]
    long, wide, thin = (float(size[k]) for k in order)
    count = int(np.clip(np.ceil(wide / max(thin, 1e-9) - 1e-9), 1, most))
    cell = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, 8).T * [long, wide / count, thin]
    low, high, radius = fit_segment(cell[:, 0], np.hypot(cell[:, 1], cell[:, 2]))
    axes = np.eye(3)[order]
    bodies = []
    for k in range(count):
        foot = ((k + 0.5) / count - 0.5) * wide * axes[1]
        bodies.append(Body(foot + low * axes[0], foot + high * axes[0], radius))
    depth = min(float(np.min(0.5 * np.asarray(size) - np.abs(end))) for body in bodies for end in (body.a, body.b))
    slack = radius - depth
    note = f"box, slack at most {at_most(slack, decimals=4)} m"
    return [Body(body.a, body.b, body.radius, note, slack) for body in bodies]
