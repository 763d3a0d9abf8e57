"""Triangles of solids, for drawing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Solid = tuple[Floats, NDArray[np.int64]]
"""Vertices (v, 3) and outward triangles (f, 3)."""


def revolve(profile: Floats, segments: int = 28) -> Solid:
    """The surface swept by `profile` (k, 2), pairs (distance from z, height) from bottom to top, first and last on the axis."""
    angle = np.arange(segments) * (2.0 * np.pi / segments)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inner = profile[1:-1]
    body = np.concatenate([np.column_stack([r * ring, np.full(segments, z)]) for r, z in inner])
    vertices = np.concatenate([[[0.0, 0.0, profile[0, 1]]], body, [[0.0, 0.0, profile[-1, 1]]]])
    i = np.arange(segments)
    j = (i + 1) % segments
    faces = [np.column_stack([np.zeros_like(i), 1 + j, 1 + i])]
    for k in range(len(inner) - 1):
        if np.array_equal(inner[k], inner[k + 1]):  # a ring written twice: an edge that stays sharp
            continue
        a, b = 1 + k * segments, 1 + (k + 1) * segments
        faces += [np.column_stack([a + i, a + j, b + j]), np.column_stack([a + i, b + j, b + i])]
    last = 1 + (len(inner) - 1) * segments
    faces.append(np.column_stack([last + i, last + j, np.full_like(i, len(vertices) - 1)]))
    return vertices, np.concatenate(faces)


def along(solid: Solid, a: ArrayLike, b: ArrayLike) -> Solid:
    """A solid of revolution moved so that its origin lies on `a` and its z axis points to `b`."""
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    z = b - a
    length = float(np.linalg.norm(z))
    if length < 1e-12:
        return solid[0] + a, solid[1]
    z = z / length
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    return solid[0] @ np.stack([x, np.cross(z, x), z]) + a, solid[1]


def capsule(a: ArrayLike, b: ArrayLike, radius: float, segments: int = 28) -> Solid:
    """All points within `radius` of the segment a-b; a ball where a = b."""
    length = float(np.linalg.norm(np.asarray(b, np.float64) - np.asarray(a, np.float64)))
    turn = np.linspace(0.0, 0.5 * np.pi, segments // 4 + 1)
    cap = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    profile = np.concatenate([cap[::-1] * [1.0, -1.0], cap + [0.0, length]])
    return along(revolve(profile, segments), a, b)


def ball(center: ArrayLike, radius: float, segments: int = 36) -> Solid:
    """A ball."""
    return capsule(center, center, radius, segments)


def cylinder(a: ArrayLike, b: ArrayLike, radius: float) -> Solid:
    """A cylinder with flat ends."""
    length = float(np.linalg.norm(np.asarray(b, np.float64) - np.asarray(a, np.float64)))
    profile = np.array([[0.0, 0.0], [radius, 0.0], [radius, 0.0], [radius, length], [radius, length], [0.0, length]])
    return along(revolve(profile, 48), a, b)


def box(center: ArrayLike, half_sizes: ArrayLike, rotation: Floats) -> Solid:
    """A box, each face with vertices of its own so that its edges look sharp."""
    vertices, faces = [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
            n = sign * np.eye(3)[axis]
            k = 4 * len(faces)
            vertices += [n - u - sign * v, n + u - sign * v, n + u + sign * v, n - u + sign * v]
            faces.append([[k, k + 1, k + 2], [k, k + 2, k + 3]])
    points = np.array(vertices) * np.asarray(half_sizes)
    return points @ np.asarray(rotation).T + np.asarray(center), np.array(faces, np.int64).reshape(-1, 3)


def slab(normal: Floats, distance: float, center: Floats, extent: float) -> Solid:
    """A thin plate that stands for the half-space n.x <= distance near `center`."""
    z = np.asarray(normal, np.float64)
    foot = center + (distance - float(z @ center)) * z
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(z, x), z], axis=1)
    thickness = 0.004 * extent
    return box(foot - thickness * z, [extent, extent, thickness], rotation)


def prism(outline: Floats, height: float) -> Solid:
    """A flat figure, star-shaped about the mean of its `outline` (k, 2) counter-clockwise, `height` thick about z = 0."""
    k = len(outline)
    middle = outline.mean(axis=0)
    flat = np.concatenate([outline, middle[None]])
    i = np.arange(k)
    j = (i + 1) % k
    vertices, faces = [], []
    for z, up in ((-0.5 * height, False), (0.5 * height, True)):
        base = sum(len(v) for v in vertices)
        vertices.append(np.column_stack([flat, np.full(k + 1, z)]))
        fan = np.column_stack([i, j, np.full(k, k)]) + base
        faces.append(fan if up else fan[:, ::-1])
    base = sum(len(v) for v in vertices)
    vertices += [np.column_stack([outline, np.full(k, z)]) for z in (-0.5 * height, 0.5 * height)]
    faces += [
        np.column_stack([base + i, base + j, base + k + j]),
        np.column_stack([base + i, base + k + j, base + k + i]),
    ]
    return np.concatenate(vertices), np.concatenate(faces).astype(np.int64)


def outline_of(obstacle: Any, count: int = 160) -> Floats | None:
    """The outline (k, 2) of a plane obstacle, counter-clockwise; None for a solid of space."""
    t: Floats = np.arange(count, dtype=np.float64) * (2.0 * np.pi / count)
    ring = np.stack([np.cos(t), np.sin(t)], axis=1)
    kind = type(obstacle).__name__
    shapes: dict[str, Callable[[], Floats]] = {
        "Ball": lambda: obstacle.center + obstacle.radius * ring,
        "EllipsoidND": lambda: obstacle.center + (ring * obstacle.semi_axes) @ obstacle.rotation.T,
        "Star": lambda: (
            obstacle.center
            + (obstacle.radius * (1.0 + obstacle.amplitude * np.cos(obstacle.lobes * (t - obstacle.angle))))[:, None]
            * ring
        ),
        "Aerofoil": lambda: _aerofoil(obstacle, t),
    }
    if kind not in shapes or (kind in ("Ball", "EllipsoidND") and len(obstacle.center) != 2):
        return None
    return shapes[kind]()


def _aerofoil(o: Any, t: Floats) -> Floats:
    p = o.mu + abs(o.k - o.mu) * np.exp(1j * t)
    q = np.exp(1j * o.angle) * (p + o.k**2 / p)
    return o.center + np.stack([q.real, q.imag], axis=1)


def solid_of(obstacle: Any, center: Floats, extent: float) -> Solid:
    """Triangles of any obstacle of a scene; `center` and `extent` bound what is drawn of an infinite one.

    A ball of R^n, n > 3, is drawn in its first three coordinates.
    """
    outline = outline_of(obstacle)
    if outline is not None:
        return prism(outline, 0.04 * extent)
    o, kind = obstacle, type(obstacle).__name__
    if kind == "Ball":
        return ball(o.center[:3], o.radius)
    if kind in ("Ellipsoid", "EllipsoidND"):
        vertices, faces = ball(np.zeros(3), 1.0)
        return (vertices * o.semi_axes[:3]) @ np.asarray(o.rotation)[:3, :3].T + o.center[:3], faces
    if kind == "Capsule":
        return capsule(o.a, o.b, o.radius)
    if kind == "Cylinder":
        return cylinder(o.a, o.b, o.radius)
    if kind == "Box":
        return box(o.center, o.half_sizes, o.rotation)
    if kind == "HalfSpace":
        return slab(o.normal, o.distance, center, extent)
    return np.asarray(o.vertices, np.float64), np.asarray(o.faces, np.int64)
