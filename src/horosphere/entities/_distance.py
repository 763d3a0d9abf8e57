"""Distances of pairs of entities, by differences of coordinates: never through sqrt(-2 x.y), which has no digits left
below 1e-8 [Humanoid, step 1 of the algorithm; see the errata].

A Line and a Circle, and two Circles, have none in closed form (their equations have degree 4 and 8).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ._build import check_shapes, cross, length
from ._circle import Circle
from ._entity import DISTANCES, Entity
from ._kernels import PARALLEL
from ._line import Line
from ._pair import PointPair
from ._plane import Plane
from ._point import Point
from ._sphere import Sphere

Array = NDArray[np.float64]


def _dot(a: Array, b: Array) -> Array:
    return np.sum(a * b, axis=-1)


def _point_point(a: Point, b: Point) -> Array:
    return length(a.array[..., :3] - b.array[..., :3])


def _point_line(p: Point, l: Line) -> Array:
    return length(cross(p.array[..., :3], l.direction) - l.moment)


def _point_plane(p: Point, e: Plane) -> Array:
    return np.abs(_dot(p.array[..., :3], e.array[..., :3]) - e.array[..., 3])


def _point_sphere(p: Point, s: Sphere) -> Array:
    return length(p.array[..., :3] - s.array[..., :3]) - s.radius


def _point_circle(p: Point, c: Circle) -> Array:
    gap, normal = p.array[..., :3] - c.array[..., :3], c.array[..., 3:6]
    return np.hypot(_dot(gap, normal), length(cross(normal, gap)) - c.radius)


def _line_line(a: Line, b: Line) -> Array:
    n, m = a.direction, b.direction
    gap, normal = b.point - a.point, cross(n, m)
    sine = length(normal)
    parallel = sine <= PARALLEL
    across = np.abs(_dot(gap, normal)) / np.where(parallel, 1.0, sine)
    return np.where(parallel, length(cross(gap, n)), across)


def _line_plane(l: Line, e: Plane) -> Array:
    n = e.array[..., :3]
    parallel = np.abs(_dot(l.direction, n)) <= PARALLEL
    return np.where(parallel, np.abs(_dot(l.point, n) - e.array[..., 3]), 0.0)


def _line_sphere(l: Line, s: Sphere) -> Array:
    return length(cross(s.array[..., :3], l.direction) - l.moment) - s.radius


def _plane_plane(a: Plane, b: Plane) -> Array:
    n, m = a.array[..., :3], b.array[..., :3]
    parallel = length(cross(n, m)) <= PARALLEL
    return np.where(parallel, np.abs(a.array[..., 3] - np.sign(_dot(n, m)) * b.array[..., 3]), 0.0)


def _plane_sphere(e: Plane, s: Sphere) -> Array:
    return np.abs(_dot(e.array[..., :3], s.array[..., :3]) - e.array[..., 3]) - s.radius


def _plane_circle(e: Plane, c: Circle) -> Array:
    n = e.array[..., :3]
    height = np.abs(_dot(n, c.array[..., :3]) - e.array[..., 3])
    return np.maximum(height - c.radius * length(cross(n, c.array[..., 3:6])), 0.0)


def _sphere_sphere(a: Sphere, b: Sphere) -> Array:
    return length(a.array[..., :3] - b.array[..., :3]) - a.radius - b.radius


def _sphere_circle(s: Sphere, c: Circle) -> Array:
    return _point_circle(Point.from_euclidean(s.center), c) - s.radius


def _of_pair(distance: Callable[..., Array]) -> Callable[..., Array]:
    """The nearer of both points."""

    def nearer(pair: PointPair, other: Entity) -> Array:
        points = np.where(np.asarray(pair.is_real)[..., None, None], pair.points, 0.0)
        first, second = (Point.from_euclidean(points[..., i, :]) for i in (0, 1))
        return np.minimum(distance(first, other), distance(second, other))

    return nearer


def _register(first: type, second: type, distance: Callable) -> None:
    def checked(a: Entity, b: Entity) -> Array:
        try:
            value = distance(a, b)
            return np.where(np.logical_and(a.is_real, b.is_real), value, np.inf)[()]
        except ValueError:
            check_shapes(a, b)
            raise

    DISTANCES[first, second] = checked
    if first is not second:
        DISTANCES[second, first] = lambda b, a: checked(a, b)


for _first, _second, _function in (
    (Point, Point, _point_point),
    (Point, Line, _point_line),
    (Point, Plane, _point_plane),
    (Point, Sphere, _point_sphere),
    (Point, Circle, _point_circle),
    (Line, Line, _line_line),
    (Line, Plane, _line_plane),
    (Line, Sphere, _line_sphere),
    (Plane, Plane, _plane_plane),
    (Plane, Sphere, _plane_sphere),
    (Plane, Circle, _plane_circle),
    (Sphere, Sphere, _sphere_sphere),
    (Sphere, Circle, _sphere_circle),
):
    _register(_first, _second, _function)
    if _first is Point:
        _register(PointPair, _second, _of_pair(_function))
_register(PointPair, PointPair, _of_pair(lambda p, pair: _of_pair(_point_point)(pair, p)))
