"""Conservative capsules: collision geometry lies inside them, and each says how far it stands out (its slack)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
GRAIN = 1e-9
"""Radii are enlarged by this (metres): rounding must not put a corner outside."""


@dataclass(frozen=True, slots=True)
class Body:
    """A capsule in some frame, and where it came from."""

    a: Floats
    b: Floats
    radius: float
    note: str = ""

    def moved(self, rotation: Floats, translation: Floats) -> Body:
        """The capsule turned, then shifted."""
        return Body(rotation @ self.a + translation, rotation @ self.b + translation, self.radius, self.note)


def fit_segment(along: Floats, across: Floats, pad: Floats | float = 0.0) -> tuple[float, float, float]:
    """Capsule on a given axis, of least volume, round balls at heights `along` and distances `across` from that axis.

    Returns (low, high, radius). For a radius r >= max(across + pad), ball k lies inside iff the segment comes within
    sqrt((r - pad)^2 - across^2) of its height; so the shortest segment is known for each r, and r is scanned.
    """
    least = float(np.max(across + pad))
    best = (0.0, 0.0, np.inf, np.inf)
    for r in least * (1.0 + np.linspace(0.0, 1.0, 101) ** 2 * 1.5):
        give = np.sqrt(np.maximum((r - pad) ** 2 - across**2, 0.0))
        low, high = float(np.min(along + give)), float(np.max(along - give))
        if low > high:
            low = high = 0.5 * (low + high)
        volume = r * r * (high - low + 4.0 / 3.0 * r)
        if volume < best[3] * (1.0 - 1e-12):
            best = (low, high, float(r), volume)
    return best[0], best[1], best[2] + GRAIN


def enclosing_center(points: Floats) -> Floats:
    """Centre (d,) of a ball that nearly is the smallest round `points` (m, d): Badoiu and Clarkson's iteration."""
    center = points.mean(axis=0)
    for k in range(1, 400):
        far = points[np.argmax(np.sum((points - center) ** 2, axis=1))]
        center = center + (far - center) / (k + 1.0)
    return center


def fit_capsule(points: Floats, pad: Floats | float = 0.0) -> Body:
    """A small capsule round balls of radius `pad` at `points` (m, 3); tries the principal axes of the points."""
    centered = points - points.mean(axis=0)
    axes = np.linalg.svd(centered, full_matrices=True)[2] if len(points) > 1 else np.eye(3)
    found: list[tuple[float, Body]] = []
    for k in range(3):
        axis, sides = axes[k], np.delete(axes, k, axis=0)
        flat = points @ sides.T
        middle = enclosing_center(flat)
        low, high, radius = fit_segment(points @ axis, np.linalg.norm(flat - middle, axis=1), pad)
        foot = middle @ sides
        body = Body(foot + low * axis, foot + high * axis, radius)
        found.append((radius**2 * (high - low + 4.0 / 3.0 * radius), body))
    return min(found, key=lambda item: item[0])[1]


def from_sphere(radius: float) -> list[Body]:
    """A ball is a capsule of length zero: exact."""
    return [Body(np.zeros(3), np.zeros(3), radius, "sphere, exact")]


def from_cylinder(radius: float, length: float) -> list[Body]:
    """A capsule round a cylinder along z."""
    low, high, r = fit_segment(np.array([-0.5, 0.5]) * length, np.array([radius, radius]))
    z = np.array([0.0, 0.0, 1.0])
    body = Body(low * z, high * z, r)

    def distance(p: Floats) -> Floats:
        rim = np.maximum(np.hypot(p[:, 0], p[:, 1]) - radius, 0.0)
        return np.hypot(rim, np.maximum(np.abs(p[:, 2]) - 0.5 * length, 0.0))

    return [Body(body.a, body.b, r, f"cylinder, slack {_slack([body], distance):.4f} m")]


def from_box(size: Floats, most: int = 8) -> list[Body]:
    """Parallel capsules along the longest side, enough of them that none is much wider than the shortest."""
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
    half = 0.5 * np.asarray(size)
    slack = _slack(bodies, lambda p: np.linalg.norm(np.maximum(np.abs(p) - half, 0.0), axis=1))
    return [Body(body.a, body.b, body.radius, f"box, slack {slack:.4f} m") for body in bodies]


def from_triangles(vertices: Floats, faces: NDArray[np.int64], most: int = 4) -> list[Body]:
    """Capsules round slices of a mesh along its longest axis; one more slice only if it saves a sixth of the volume."""
    used = vertices[np.unique(faces)]
    axis = np.linalg.svd(used - used.mean(axis=0), full_matrices=False)[2][0]
    heights = used @ axis
    best: list[Body] = []
    best_volume = np.inf
    for count in range(1, most + 1):
        cuts = np.linspace(heights.min(), heights.max(), count + 1)
        slices = [_slice(vertices, faces, axis, cuts[k], cuts[k + 1]) for k in range(count)]
        bodies = [fit_capsule(points) for points in slices if len(points)]
        volume = sum(b.radius**2 * (np.linalg.norm(b.b - b.a) + 4.0 / 3.0 * b.radius) for b in bodies)
        if volume < 0.83 * best_volume:
            best, best_volume = bodies, volume
    from scipy.spatial import cKDTree

    tree = cKDTree(_dense(vertices, faces, 0.03 * float(np.ptp(used, axis=0).max())))
    slack = _slack(best, lambda p: tree.query(p)[0])
    return [Body(body.a, body.b, body.radius, f"mesh, slack about {slack:.4f} m") for body in best]


def _slice(vertices: Floats, faces: NDArray[np.int64], axis: Floats, low: float, high: float) -> Floats:
    """Vertices of the mesh between two planes, and the points where its edges cross them."""
    height = vertices @ axis
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    used = np.unique(faces)
    parts = [vertices[used][(height[used] >= low - GRAIN) & (height[used] <= high + GRAIN)]]
    h0, h1 = height[edges[:, 0]], height[edges[:, 1]]
    for level in (low, high):
        cross = (h0 - level) * (h1 - level) < 0
        w = ((level - h0[cross]) / (h1[cross] - h0[cross]))[:, None]
        parts.append(vertices[edges[cross, 0]] * (1 - w) + vertices[edges[cross, 1]] * w)
    return np.concatenate(parts)


def _dense(vertices: Floats, faces: NDArray[np.int64], spacing: float) -> Floats:
    """Points on the triangles, no further apart than about `spacing`."""
    corners = vertices[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    points = [vertices[np.unique(faces)]]
    for k in range(1, 17):
        chosen = corners[np.clip(np.ceil(longest / spacing), 1, 16) == k]
        i, j = np.array([(i, j) for i in range(k + 1) for j in range(k + 1 - i)]).T / k
        weights = np.stack([i, j, 1.0 - i - j], axis=1)
        points.append(np.einsum("wc,fcx->fwx", weights, chosen).reshape(-1, 3))
    return np.concatenate(points)


def _slack(bodies: list[Body], distance: Any) -> float:
    """Largest distance of the capsules' surfaces from the solid they cover, on a grid of about three degrees."""
    theta = np.linspace(0.0, np.pi, 61)
    phi = np.linspace(0.0, 2.0 * np.pi, 73)[:-1]
    directions = np.array([[np.cos(t), np.sin(t) * np.cos(p), np.sin(t) * np.sin(p)] for t in theta for p in phi])
    worst = 0.0
    for body in bodies:
        for end in (body.a, body.b):
            worst = max(worst, float(np.max(distance(end + body.radius * directions))))
    return worst
