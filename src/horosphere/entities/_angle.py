"""Angles of pairs of entities, by atan2: exact also where sine or cosine alone has no digits left."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ._build import check_shapes, cross, length
from ._circle import Circle
from ._entity import ANGLES, Entity
from ._line import Line
from ._pair import PointPair
from ._plane import Plane
from ._sphere import Sphere

Array = NDArray[np.float64]


def _along(x: Line | PointPair) -> Array:
    return x.direction


def _normal(x: Plane | Circle) -> Array:
    return x.normal


def _between(u: Array, v: Array) -> Array:
    """The angle of two directions in [0, pi]."""
    return np.arctan2(length(cross(u, v)), np.sum(u * v, axis=-1))


def _inclination(u: Array, n: Array) -> Array:
    """The angle of a direction and the plane of normal n in [0, pi/2]."""
    return np.arctan2(np.abs(np.sum(u * n, axis=-1)), length(cross(u, n)))


def _half_angle(numerator: Array, denominator: Array) -> Array:
    """2 atan sqrt(numerator/denominator), NaN where one is negative."""
    real = (numerator >= 0.0) & (denominator >= 0.0)
    angle = 2.0 * np.arctan2(np.sqrt(np.maximum(numerator, 0.0)), np.sqrt(np.maximum(denominator, 0.0)))
    return np.where(real, angle, np.nan)


def _sphere_sphere(a: Sphere, b: Sphere) -> Array:
    """Between the radii at a common point, s1.s2 = r1 r2 cos: Heron's factors of the triangle (r1, r2, distance)."""
    d, r, s = length(a.array[..., :3] - b.array[..., :3]), a.radius, b.radius
    return _half_angle((d - r + s) * (d + r - s), (r + s + d) * (r + s - d))


def _sphere_plane(a: Sphere, e: Plane) -> Array:
    """s.pi = r cos = n.c - d: 0 where the sphere touches the plane from the side of the normal."""
    h, r = np.sum(a.array[..., :3] * e.array[..., :3], axis=-1) - e.array[..., 3], a.radius
    return _half_angle(r - h, r + h)


def _register(first: type, second: type, angle: Callable[..., Array]) -> None:
    def checked(a: Entity, b: Entity) -> Array:
        try:
            return np.asarray(angle(a, b))[()]
        except ValueError:
            check_shapes(a, b)
            raise

    ANGLES[first, second] = checked
    if first is not second:
        ANGLES[second, first] = lambda b, a: checked(a, b)


for _first in (Line, PointPair):
    _register(_first, Line, lambda a, b: _between(_along(a), _along(b)))
    for _second in (Plane, Circle):
        _register(_first, _second, lambda a, b: _inclination(_along(a), _normal(b)))
_register(PointPair, PointPair, lambda a, b: _between(_along(a), _along(b)))
for _first, _second in ((Plane, Plane), (Plane, Circle), (Circle, Circle)):
    _register(_first, _second, lambda a, b: _between(_normal(a), _normal(b)))
_register(Sphere, Sphere, _sphere_sphere)
_register(Sphere, Plane, _sphere_plane)
