"""Meets and joins, each written once as geometric algebra.

Round entities travel in centred form (see `_entity.py`). Every product is taken in the frame of one of the arguments
(the smaller one) and moved back, so that nothing is lost far from the origin: |c|^2 - r^2 would lose all of a small r.
"""

from __future__ import annotations

import math
from typing import Any

from horosphere.kernels import (
    BIVECTOR,
    E0,
    EI,
    EUCLIDEAN,
    MV,
    PSEUDOSCALAR,
    VECTOR,
    absolute,
    atom,
    blades,
    kernel,
    scalars,
    sqrt,
    where_lt,
)

Scalar = Any  # a symbol or a number
SPHERE, PLANE, ROUND = scalars(4), scalars(4), scalars(7)
_WITH_E0, _WITH_EI = blades("10", "20", "30"), blades("1i", "2i", "3i")
_E12, _E13, _E23, _E0I, _E0 = blades("12", "13", "23", "0i", "0")
PARALLEL = 1e-12  # sine up to which planes and lines count as parallel
_EMPTY = 1e-30  # relative square below which the direction of a meet is rounding


# ---- small vectors of symbols
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def minus(a, b):
    return [atom(a[k] - b[k]) for k in range(3)]


# ---- typed coefficients -> blades (IPNS)
def vector(v):
    return MV.of(EUCLIDEAN, v)


def sphere(center, radius_squared):
    return vector(center) + E0 + EI * (0.5 * (dot(center, center) - radius_squared))


def plane(normal, distance):
    return vector(normal) + EI * distance


def circle(center, normal, radius_squared):
    return sphere(center, radius_squared) ^ plane(normal, dot(normal, center))


# ---- blades -> typed coefficients
def _unit(v, threshold):
    """(unit vector, 1/length, condition): zero vector where |v|^2 <= threshold."""
    square = dot(v, v)
    length = sqrt(where_lt(threshold, square, square, 1.0))
    return [where_lt(threshold, square, x / length, 0.0) for x in v], 1.0 / length, square


def circle_parameters(z, threshold: Scalar = 0.0):
    """Center, normal, radius squared of an IPNS circle s ^ pi; (0, 0, -inf) where |normal|^2 <= threshold."""
    normal, scale, square = _unit([-z[b] for b in _WITH_E0], threshold)
    d = z[_E0I] * scale
    moment = [-(z[_E23] * scale), z[_E13] * scale, -(z[_E12] * scale)]  # normal x center
    center = [d * n + x for n, x in zip(normal, cross(moment, normal), strict=True)]
    q = d * d - dot([z[b] * scale for b in _WITH_EI], normal)
    r2 = dot(center, center) - 2.0 * q
    return _where_full(threshold, square, center, normal, r2)


def pair_parameters(p, threshold: Scalar = 0.0):
    """Center, direction, radius squared of an IPNS point pair; (0, 0, -inf) where |direction|^2 <= threshold."""
    b = p * PSEUDOSCALAR  # OPNS: X I^-1
    u, scale, square = _unit([-b[k] for k in _WITH_E0], threshold)
    along = b[_E0I] * scale
    moment = [b[_E23] * scale, -(b[_E13] * scale), b[_E12] * scale]  # center x u
    center = [along * n + x for n, x in zip(u, cross(u, moment), strict=True)]
    half = along * along - dot([b[k] * scale for k in _WITH_EI], u)  # (center^2 + radius^2) / 2
    return _where_full(threshold, square, center, u, 2.0 * half - dot(center, center))


def _where_full(threshold, square, center, direction, r2):
    keep = [where_lt(threshold, square, x, 0.0) for x in center]
    return [*keep, *direction, where_lt(threshold, square, r2, -math.inf)]


def _moved(parameters, anchor):
    return [x + a for x, a in zip(parameters[:3], anchor, strict=True)] + parameters[3:]


# ---- meets
@kernel(7, a=SPHERE, b=SPHERE)
def sphere_sphere(a, b):
    """Circle of two spheres, s1 ^ s2, in the frame of the smaller one."""
    anchor = [where_lt(b[3], a[3], y, x) for x, y in zip(a[:3], b[:3], strict=True)]
    z = sphere(minus(a, anchor), a[3]) ^ sphere(minus(b, anchor), b[3])
    return _moved(circle_parameters(z, _EMPTY * (absolute(a[3]) + absolute(b[3]))), anchor)


@kernel(7, s=SPHERE, p=PLANE)
def sphere_plane(s, p):
    """Circle of a sphere and a plane, s ^ pi."""
    normal, center = p[:3], s[:3]
    z = sphere([0.0, 0.0, 0.0], s[3]) ^ plane(normal, atom(p[3] - dot(normal, center)))
    return _moved(circle_parameters(z), center)


@kernel(BIVECTOR, a=PLANE, b=PLANE)
def plane_plane(a, b):
    """Line of two planes, pi1 ^ pi2; direction 0 where they are parallel: the moment is then the gap."""
    line = plane(a[:3], a[3]) ^ plane(b[:3], b[3])
    direction = [line[k] for k in (_E12, _E13, _E23)]
    _, scale, square = _unit(direction, PARALLEL**2)
    full = [where_lt(PARALLEL**2, square, x * scale, 0.0) for x in direction]
    return MV.of(BIVECTOR, [*full, *(line[k] * scale for k in _WITH_EI)])


@kernel(VECTOR, l=BIVECTOR, p=PLANE)
def line_plane(l, p):
    """Point of a line and a plane from the flat point (L ^ pi)* = x ^ ei; (direction, 0, 0) where they are parallel."""
    flat = (l ^ plane(p[:3], p[3])) * PSEUDOSCALAR
    weight = flat[_E0I]
    size = absolute(weight)
    safe = where_lt(PARALLEL, size, weight, 1.0)
    x = [flat[k] / safe for k in _WITH_EI]
    direction = [l[_E23], -l[_E13], l[_E12]]
    point = [where_lt(PARALLEL, size, a, b) for a, b in zip(x, direction, strict=True)]
    one = where_lt(PARALLEL, size, 1.0, 0.0)
    return MV.of(VECTOR, [*point, one, one * (0.5 * dot(point, point))])


@kernel(7, c=ROUND, p=PLANE)
def circle_plane(c, p):
    """Point pair of a circle and a plane, z ^ pi, in the frame of the circle; no direction where they are parallel."""
    center, normal = c[:3], c[3:6]
    pair = circle([0.0, 0.0, 0.0], normal, c[6]) ^ plane(p[:3], atom(p[3] - dot(p, center)))
    return _moved(pair_parameters(pair, PARALLEL**2), center)


@kernel(7, c=ROUND, s=SPHERE)
def circle_sphere(c, s):
    """Point pair of a circle and a sphere, z ^ s, in the frame of the smaller one."""
    anchor = [where_lt(s[3], c[6], y, x) for x, y in zip(c[:3], s[:3], strict=True)]
    gap = minus(s, c)
    pair = circle(minus(c, anchor), c[3:6], c[6]) ^ sphere(minus(s, anchor), s[3])
    threshold = _EMPTY * (absolute(c[6]) + absolute(s[3]) + dot(gap, gap))
    return _moved(pair_parameters(pair, threshold), anchor)


@kernel(7, l=BIVECTOR, s=SPHERE)
def line_sphere(l, s):
    """Point pair of a line and a sphere, L ^ s, in the frame of the sphere."""
    center = s[:3]
    direction = [l[_E23], -l[_E13], l[_E12]]
    moment = minus([l[k] for k in _WITH_EI], cross(center, direction))
    local = MV.of(BIVECTOR, [l[_E12], l[_E13], l[_E23], *moment])
    return _moved(pair_parameters(local ^ sphere([0.0, 0.0, 0.0], s[3])), center)


# ---- joins: through points, in the frame of the first
def _up(x):
    return sphere(x, 0.0)


@kernel(7, a=scalars(3), b=scalars(3), c=scalars(3))
def circle_of_points(a, b, c):
    """Circle through three points, (a ^ b ^ c) I: center, normal along (b - a) x (c - a), radius squared."""
    z = -((E0 ^ _up(minus(b, a)) ^ _up(minus(c, a))) * PSEUDOSCALAR)
    parameters = circle_parameters(z)
    return _moved([*parameters[:6], dot(parameters, parameters)], a)  # it passes through the frame's origin


@kernel(4, a=scalars(3), b=scalars(3), c=scalars(3), d=scalars(3))
def sphere_of_points(a, b, c, d):
    """Sphere through four points, (a ^ b ^ c ^ d) I over its weight: center, radius squared."""
    s = (E0 ^ _up(minus(b, a)) ^ _up(minus(c, a)) ^ _up(minus(d, a))) * PSEUDOSCALAR
    weight = s[_E0]
    safe = where_lt(0.0, absolute(weight), weight, 1.0)
    center = [s[k] / safe for k in EUCLIDEAN]
    return [*(x + y for x, y in zip(center, a, strict=True)), dot(center, center)]
