"""The vocabulary of the closed-form arms: points, spheres, planes and lines on symbolic multivectors, and the ratio
formula.

Everything here is traced (see docs/kernels.md): it costs nothing at run time but the scalars that survive. IPNS is the
canonical form; `dual` gives the OPNS one. For unit planes (or lines) Xa, Xb through the axis L of a joint that turns
Xa into Xb, the ratio Xb / Xa = exp(-theta L), so

    theta = atan2(<Xb ~Xa L>, <Xb ~Xa>)                                                            (our derivation)

has the right sign in every quadrant, which the cosines of [Humanoid] section V step 5 have not; and only L needs unit
length.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from ..kernels import E0, E1, E2, E3, EI, EUCLIDEAN, MV, PSEUDOSCALAR, VECTOR, atan2, sqrt, where_lt
from ..kernels import maximum as _maximum

Vector = Sequence  # three scalars
_I3 = E1 * E2 * E3


def euclid(x: MV) -> list:
    """The three Euclidean coefficients of a vector."""
    return x.on(EUCLIDEAN)


def vector(x: Vector) -> MV:
    """The Euclidean vector with these three components."""
    return MV.of(EUCLIDEAN, x)


def dot(a: MV, b: MV):
    """The inner product of two vectors, a scalar."""
    return (a | b)[0]


def cross(a: MV, b: MV) -> MV:
    """The vector (a ^ b) / e123 of two Euclidean vectors."""
    return -((a ^ b) * _I3)


def norm(x: MV):
    """The length of the Euclidean part of a vector: what normalises a plane."""
    return sqrt(sum(c * c for c in euclid(x)))


def point(x: MV) -> MV:
    """x + x^2/2 e_inf + e_0 of a Euclidean vector."""
    return x + EI * (dot(x, x) * 0.5) + E0


def sphere(center: MV, radius) -> MV:
    """The IPNS sphere c - r^2/2 e_inf about a point."""
    return center - EI * (radius * radius * 0.5)


def plane(normal: MV, through: MV) -> MV:
    """The IPNS plane n + (n.p) e_inf."""
    return normal + EI * dot(normal, vector(euclid(through)))


def dual(x: MV) -> MV:
    """IPNS to OPNS: X* = X I^-1 (the traced pseudoscalar is -I)."""
    return x * PSEUDOSCALAR


def undual(x: MV) -> MV:
    """OPNS to IPNS: X = X* I."""
    return -(x * PSEUDOSCALAR)


def line(through: MV, direction: MV) -> MV:
    """The IPNS line p ^ n ^ e_inf through a point."""
    return undual(through ^ direction ^ EI)


def direction(axis: MV) -> MV:
    """The Euclidean direction of an IPNS line n e123 - e_inf ^ (p x n)."""
    return -(axis.only(tuple(b for b in range(8))) * _I3)


def select(a, b, x: MV, y: MV) -> MV:
    """x where a < b, else y."""
    return MV({blade: where_lt(a, b, x[blade], y[blade]) for blade in {*x.terms, *y.terms}})


def ratio(xb: MV, xa: MV, axis: MV):
    """The angle in (-pi, pi] by which the joint about the unit line `axis` turns xa into xb (planes, or lines,
    through it).
    """
    q = xb * ~xa
    sine, cosine = (q * axis)[0], q[0]
    angle = atan2(sine, cosine)
    return where_lt(-math.pi, angle, angle, math.pi)


def half_turn(angle):
    """angle + pi in (-pi, pi]."""
    return where_lt(0.0, angle, angle - math.pi, angle + math.pi)


def negated(angle):
    """-angle in (-pi, pi]."""
    return where_lt(angle, math.pi, -angle, angle)


def rotation(axis: MV, sine_half, cosine_half) -> MV:
    """The motor exp(-theta/2 L), right-handed about a unit line."""
    return MV({0: cosine_half}) - axis * sine_half


def pair_points(pair: MV) -> tuple[MV, MV, Any, Any]:
    """Both Euclidean points of an OPNS pair B = a ^ b, then B^2 and v^2 with v = B.e_inf.

    (B -/+ sqrt(B^2)) v^-1 are a and b; an imaginary pair (B^2 < 0) gives its centre twice.
    """
    v = pair | EI
    v2 = dot(v, v)
    b2 = (pair * pair)[0]
    root = sqrt(_maximum(b2, 0.0))
    inverse = v * (1.0 / where_lt(0.0, v2, v2, 1.0))
    a, b = ((pair - MV({0: root})).times(inverse, layout=VECTOR), (pair + MV({0: root})).times(inverse, layout=VECTOR))
    return vector(euclid(a)), vector(euclid(b)), b2, v2
