"""Mesh and point cloud: obstacles that come from sensors and CAD."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ._base import Floats, Shape, points_of, private, set_fields


@dataclass(frozen=True, slots=True, eq=False)
class Mesh(Shape):
    """A solid bounded by triangles: `vertices` (k, 3) in metres, `faces` (m, 3) indices into them."""

    vertices: Floats
    faces: NDArray[np.int64]
    name: str = ""

    def __post_init__(self) -> None:
        vertices = private(self.vertices, "Mesh.vertices", last=3, ndim=2)
        raw = np.asarray(self.faces)
        if raw.ndim != 2 or raw.shape[1] != 3 or len(raw) == 0 or not np.issubdtype(raw.dtype, np.integer):
            raise InputError(f"expected integers of shape (m, 3), got {raw.dtype} {raw.shape}", place="Mesh.faces")
        faces = np.array(raw, dtype=np.int64, order="C")
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise InputError(
                f"an index lies outside 0 .. {len(vertices) - 1}: {faces.min()} .. {faces.max()}", place="Mesh.faces"
            )
        faces.setflags(write=False)
        set_fields(self, vertices=vertices, faces=faces)

    @property
    def is_watertight(self) -> bool:
        """Whether every edge is shared by exactly two faces that run along it in opposite directions."""
        edges = np.concatenate([self.faces[:, [i, (i + 1) % 3]] for i in range(3)])
        forward, counts = np.unique(edges, axis=0, return_counts=True)
        backward = np.unique(edges[:, ::-1], axis=0)
        return bool((counts == 1).all() and forward.shape == backward.shape and (forward == backward).all())

    def signed_distance(self, points: ArrayLike) -> Floats:
        """Distance to the nearest triangle, negative where the winding number is not zero (needs a watertight mesh)."""
        x = points_of(points, 3)
        flat = x.reshape(-1, 3)
        corners = self.vertices[self.faces]
        distance = np.array([_to_triangles(p, corners) for p in flat])
        if self.is_watertight:
            distance *= np.where([abs(_winding(p, corners)) > 0.5 for p in flat], -1.0, 1.0)
        return distance.reshape(x.shape[:-1])

    def bounding_ball(self) -> tuple[Floats, float]:
        """About the middle of the bounding box."""
        centre = 0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0))
        return centre, float(np.linalg.norm(self.vertices - centre, axis=1).max())


@dataclass(frozen=True, slots=True, eq=False)
class PointCloud(Shape):
    """Balls of `radius` (m, one or one a point) about `points` (m, 3)."""

    points: Floats
    radius: float | Floats
    name: str = ""

    def __post_init__(self) -> None:
        points = private(self.points, "PointCloud.points", last=3, ndim=2)
        radius = private(np.broadcast_to(np.asarray(self.radius, np.float64), len(points)), "PointCloud.radius")
        if len(points) == 0:
            raise InputError("expected at least one point", place="PointCloud.points")
        if (radius < 0.0).any():
            raise InputError(f"expected numbers >= 0, got {radius.min():g}", place="PointCloud.radius")
        set_fields(self, points=points, radius=radius)

    def signed_distance(self, points: ArrayLike) -> Floats:
        """To the nearest ball; inside several, minus the depth in the deepest (a lower bound of the depth in their union)."""
        x = points_of(points, 3)
        flat = x.reshape(-1, 3)
        nearest = [float((np.linalg.norm(self.points - p, axis=1) - self.radius).min()) for p in flat]
        return np.array(nearest).reshape(x.shape[:-1])

    def bounding_ball(self) -> tuple[Floats, float]:
        """About the middle of the bounding box."""
        centre = 0.5 * (self.points.min(axis=0) + self.points.max(axis=0))
        return centre, float((np.linalg.norm(self.points - centre, axis=1) + self.radius).max())


def _to_triangles(p: Floats, corners: Floats) -> float:
    """Distance of p (3,) to the nearest of the triangles (m, 3, 3): over the faces and the edges."""
    a, edges = corners, np.roll(corners, -1, axis=1) - corners
    squares = np.maximum((edges**2).sum(-1), 1e-300)
    t = np.clip(((p - a) * edges).sum(-1) / squares, 0.0, 1.0)
    nearest = np.linalg.norm(p - a - t[..., None] * edges, axis=-1).min()
    normal = np.cross(edges[:, 0], edges[:, 1])
    length = np.linalg.norm(normal, axis=-1)
    inside = (np.einsum("mij,mij->mi", np.cross(normal[:, None], edges), p - a) >= 0.0).all(-1) & (length > 0.0)
    if inside.any():
        height = np.abs((normal * (p - a[:, 0])).sum(-1))[inside] / length[inside]
        nearest = min(nearest, height.min())
    return float(nearest)


def _winding(p: Floats, corners: Floats) -> float:
    """Sum of the signed solid angles of the triangles seen from p, over 4 pi (Van Oosterom and Strackee's formula)."""
    a, b, c = (corners[:, i] - p for i in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    volume = (a * np.cross(b, c)).sum(-1)
    cosine = la * lb * lc + (a * b).sum(-1) * lc + (b * c).sum(-1) * la + (c * a).sum(-1) * lb
    return float(np.arctan2(volume, cosine).sum() / (2.0 * np.pi))
