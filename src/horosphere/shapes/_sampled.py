"""Mesh and point cloud: obstacles that come from sensors and CAD."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array
from ._base import Floats, Shape, points_of, private, set_fields


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Mesh(Shape):
    """A solid bounded by triangles: `vertices` (k, 3) in metres, `faces` (m, 3) indices into them."""

    vertices: Floats
    faces: NDArray[np.int64]
    name: str = ""

    def __post_init__(self) -> None:
        vertices = private(self.vertices, "Mesh.vertices", last=3, ndim=2)
        try:
            raw = np.asarray(self.faces)
        except ValueError:
            raise InputError(
                "its rows differ in length, expected (m, 3)", place="Mesh.faces", remedy="triangulate them"
            ) from None
        if raw.size == 0:
            raise InputError(
                "no faces, a mesh has at least one", place="Mesh.faces", remedy="a PointCloud has points only"
            )
        if raw.ndim != 2 or raw.shape[1] != 3 or not np.issubdtype(raw.dtype, np.integer):
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
        """Whether every edge lies between exactly two faces; vertices at the same place count as one."""
        return not len(self.open_edges())

    def open_edges(self) -> Floats:
        """The edges (k, 2, 3) that do not lie between exactly two faces: where the mesh does not say what is inside."""
        from ._shells import open_edges

        return open_edges(self.vertices, self.faces)

    def hull(self) -> Mesh:
        """The convex hull. Raises InputError for a flat mesh."""
        from scipy.spatial import ConvexHull, QhullError

        try:
            found = ConvexHull(self.vertices)
        except QhullError:
            raise InputError(
                "its vertices lie in one plane: it has no convex hull", place=self.name or "Mesh"
            ) from None
        corners = found.points[found.simplices]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        inward = (normal * found.equations[:, :3]).sum(axis=1) < 0.0
        return Mesh(found.points, np.where(inward[:, None], found.simplices[:, ::-1], found.simplices), self.name)

    def signed_distance(self, points: ArrayLike) -> Floats:
        """To the nearest triangle, negative inside the closed parts; inside several parts that overlap, minus the depth in one."""
        from ._forest import grow
        from ._point_kernels import mesh_points

        x = points_of(points, 3)
        rows, forest = grow(self)
        distance = np.empty(x.size // 3)
        mesh_points(rows, forest.nodes, forest.ends, forest.triangles, np.array(x.reshape(-1, 3)), distance)
        return distance.reshape(x.shape[:-1])

    def bounding_ball(self) -> tuple[Floats, float]:
        """About the middle of the bounding box."""
        centre = 0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0))
        return centre, float(np.linalg.norm(self.vertices - centre, axis=1).max())


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class PointCloud(Shape):
    """Balls of `radius` (m, one or one a point) about `points` (m, 3)."""

    points: Floats
    radius: float | Floats
    name: str = ""

    def __post_init__(self) -> None:
        points = private(self.points, "PointCloud.points", last=3, ndim=2)
        given = float_array(self.radius, "PointCloud.radius")
        if given.shape not in ((), (len(points),)):
            raise InputError(
                f"expected one number or one for each of the {len(points)} points, got shape {given.shape}",
                place="PointCloud.radius",
            )
        radius = private(np.broadcast_to(given, len(points)), "PointCloud.radius")
        if len(points) == 0:
            raise InputError("expected at least one point", place="PointCloud.points")
        if (radius < 0.0).any():
            raise InputError(f"expected numbers >= 0, got {radius.min():g}", place="PointCloud.radius")
        set_fields(self, points=points, radius=radius)

    def signed_distance(self, points: ArrayLike) -> Floats:
        """To the nearest ball; inside several, minus the depth in the deepest (a lower bound of the depth in their union)."""
        from ._forest import grow
        from ._point_kernels import cloud_points

        x = points_of(points, 3)
        rows, forest = grow(self)
        distance = np.empty(x.size // 3)
        cloud_points(rows, forest.nodes, forest.ends, forest.balls, np.array(x.reshape(-1, 3)), distance)
        return distance.reshape(x.shape[:-1])

    def bounding_ball(self) -> tuple[Floats, float]:
        """About the middle of the bounding box."""
        if self not in _balls:
            centre = 0.5 * (self.points.min(axis=0) + self.points.max(axis=0))
            centre.setflags(write=False)  # it is kept, and handed out
            _balls[self] = centre, float((np.linalg.norm(self.points - centre, axis=1) + self.radius).max())
        return _balls[self]


_balls: WeakKeyDictionary[PointCloud, tuple[Floats, float]] = WeakKeyDictionary()
"""Bounding balls of clouds: of a million points it takes a sixth of a second, and a plan asks again and again."""
