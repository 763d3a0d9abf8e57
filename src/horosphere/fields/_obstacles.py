"""Whatever the caller gives as obstacles, sorted into balls, stars, walls and Joukowski shapes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..maps import Joukowski, Star, capsule, convex_hull, ellipsoid, lobed, smooth_box, smooth_cylinder
from ..numeric import at_most, float_array

Array = NDArray[np.float64]
ACCEPTED = (
    "a pair (centers (m, n), radii (m,))",
    "the entities Sphere and Plane",
    "the shapes Ball, Ellipsoid, Capsule, Cylinder, Box, HalfSpace, Mesh, PointCloud",
    "any star of horosphere.maps",
    "maps.Joukowski",
)


@dataclass(slots=True)
class Zones:
    """Obstacles in R^`dimension`, grown by `margin`: bodies are stars or balls (center, radius, name), in the caller's order."""

    dimension: int
    margin: float
    bodies: list[Any] = field(default_factory=list)
    walls: list[Array] = field(default_factory=list)
    wall_names: list[str] = field(default_factory=list)
    conformal: list[Joukowski] = field(default_factory=list)
    ellipse: Joukowski | None = (
        None  # the conformal map of the last ellipse of the plane, used if nothing else is there
    )
    notes: list[str] = field(default_factory=list)

    def add_ball(self, center: Any, radius: Any, name: str) -> None:
        center = float_array(center, name, ndim=1)
        self._fits(len(center), name)
        radius = float(float_array(radius, f"{name}: radius", ndim=0))
        if not radius > 0.0:
            raise InputError(f"expected a radius above 0, got {radius:g}", place=name)
        self.bodies.append((center, radius + self.margin, name))

    def add_star(self, star: Star, name: str, grown: bool = False) -> None:
        self._fits(star.dimension, name)
        star = star if grown or self.margin == 0.0 else star.grown(self.margin)
        if star.name != name:
            object.__setattr__(star, "name", name)
        if star.slack > 0.0:
            self.notes.append(f"{name}: enclosed with at most {at_most(star.slack, 3, power=3)} mm to spare")
        self.bodies.append(star)

    def add_halfspace(self, normal: Array, offset: float, name: str) -> None:
        """Free where normal . x >= offset."""
        self._fits(len(normal), name)
        self.walls.append(np.r_[normal, offset + self.margin, 0.0])
        self.wall_names.append(name)

    def _fits(self, n: int, name: str) -> None:
        if n != self.dimension:
            raise InputError(f"lies in R^{n}, the goal in R^{self.dimension}", place=name)


def read_zones(obstacles: Any, dimension: int, margin: float) -> Zones:
    """Raises InputError naming the obstacle for what cannot be used."""
    zones = Zones(dimension, margin)
    if obstacles is None:
        return zones
    if (
        isinstance(obstacles, (tuple, list))
        and len(obstacles) == 2
        and _numbers(obstacles[0])
        and _numbers(obstacles[1])
    ):
        centers = float_array(obstacles[0], "obstacle centers")
        if centers.size == 0 and np.size(obstacles[1]) == 0:
            return zones
        if centers.ndim != 2 or centers.shape[1] != dimension:
            raise InputError(
                f"expected obstacle centers of shape (m, {dimension}) like the goal, got {centers.shape}",
                place="obstacles",
            )
        radii = float_array(obstacles[1], "obstacle radii")
        if radii.ndim > 1 or (radii.ndim == 1 and len(radii) != len(centers)):
            raise InputError(f"got {len(centers)} obstacle centers and radii of shape {radii.shape}", place="obstacles")
        for k, (center, radius) in enumerate(zip(centers, np.broadcast_to(radii, len(centers)))):
            zones.add_ball(center, radius, f"obstacle {k}")
        return zones
    if not isinstance(obstacles, (tuple, list)):
        obstacles = [obstacles]
    for k, item in enumerate(obstacles):
        name = getattr(item, "name", "") or f"obstacle {k}"
        if isinstance(item, Star):
            zones.add_star(item, name)
        elif isinstance(item, Joukowski):
            zones._fits(2, name)
            zones.conformal.append(item)
        else:
            reader = _READERS.get(type(item).__name__)
            if reader is None:
                raise InputError(f"cannot use {type(item).__name__} as an obstacle", place=name, choices=ACCEPTED)
            reader(zones, item, name)
    return zones


def _numbers(value: Any) -> bool:
    try:
        return np.asarray(value).dtype.kind in "fiub" or np.size(value) == 0
    except ValueError:
        return False


def _ball(zones: Zones, item: Any, name: str) -> None:
    center = np.asarray(item.center, dtype=np.float64)
    if center.ndim == 1:
        zones.add_ball(center, item.radius, name)
        return
    flat = center.reshape(-1, center.shape[-1])
    for k, (c, r) in enumerate(zip(flat, np.broadcast_to(item.radius, center.shape[:-1]).reshape(-1))):
        zones.add_ball(c, r, f"{name}[{k}]")


def _halfspace(zones: Zones, item: Any, name: str) -> None:
    normals = np.reshape(item.normal, (-1, np.shape(item.normal)[-1]))
    for normal, distance in zip(normals, np.reshape(item.distance, -1)):
        zones.add_halfspace(normal, float(distance), name)


def _box(zones: Zones, item: Any, name: str) -> None:
    # the box is grown, not the smooth body around it: less to spare
    zones.add_star(smooth_box(item.center, np.asarray(item.half_sizes) + zones.margin, item.rotation), name, grown=True)


def _cylinder(zones: Zones, item: Any, name: str) -> None:
    along = (item.b - item.a) * (zones.margin / np.linalg.norm(item.b - item.a))
    zones.add_star(smooth_cylinder(item.a - along, item.b + along, item.radius + zones.margin), name, grown=True)


def _mesh(zones: Zones, item: Any, name: str) -> None:
    if not item.is_watertight:
        raise InputError(
            "the mesh is not watertight: it may miss a part",
            place=name,
            remedy="mend it, or give its vertices as a PointCloud to take their convex hull",
        )
    star = convex_hull(item.vertices, name=name)
    hollow = _hull_volume(item.vertices) - _volume(item.vertices, item.faces)
    if hollow > 1e-6 * star.outer**3:
        zones.notes.append(
            f"{name}: the mesh is not convex, its convex hull (with {hollow:.3g} m^3 more) stands for it"
        )
    zones.add_star(star, name)


def _volume(vertices: Array, faces: NDArray[np.int64]) -> float:
    a, b, c = np.moveaxis(vertices[faces] - vertices.mean(axis=0), 1, 0)
    return abs(float((a * np.cross(b, c)).sum())) / 6.0


def _hull_volume(vertices: Array) -> float:
    from scipy.spatial import ConvexHull

    return float(ConvexHull(vertices).volume)


def _cloud(zones: Zones, item: Any, name: str) -> None:
    zones.add_star(convex_hull(item.points, float(np.max(item.radius)), name=name), name)


def _aerofoil(zones: Zones, item: Any, name: str) -> None:
    zones.conformal.append(Joukowski.aerofoil(item.k, item.mu, item.center, item.angle, name=name))


def _planar_star(zones: Zones, item: Any, name: str) -> None:
    zones.add_star(lobed(item.center, item.radius, item.amplitude, item.lobes, -item.lobes * item.angle), name)


def _ellipsoid(zones: Zones, item: Any, name: str) -> None:
    zones.add_star(ellipsoid(item.center, item.semi_axes, item.rotation), name)
    if zones.dimension == 2:
        zones.ellipse = Joukowski.ellipse(item.semi_axes[0], item.semi_axes[1], item.center, item.angle, name=name)


def _capsule(zones: Zones, item: Any, name: str) -> None:
    zones.add_star(capsule(item.a, item.b, item.radius), name)


# by name: shapes, entities and the planar obstacles of scenes come from layers beside and above this one
_READERS: dict[str, Callable[[Zones, Any, str], None]] = {
    "Sphere": _ball,
    "Ball": _ball,
    "Plane": _halfspace,
    "HalfSpace": _halfspace,
    "Ellipsoid": _ellipsoid,
    "EllipsoidND": _ellipsoid,
    "Capsule": _capsule,
    "Box": _box,
    "Cylinder": _cylinder,
    "Mesh": _mesh,
    "PointCloud": _cloud,
    "Aerofoil": _aerofoil,
    "Star": _planar_star,
}
