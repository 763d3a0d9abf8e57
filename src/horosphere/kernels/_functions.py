"""Functions of symbolic scalars. All are branch-free, so the same trace runs on one number or on a vector of lanes.

Plain numbers are accepted too and folded, which keeps robot-specialised traces small.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ._graph import Symbol

Scalar = Symbol | float


def _call(name: str, fold, *arguments: Scalar) -> Scalar:
    graph = next((a.graph for a in arguments if isinstance(a, Symbol)), None)
    if graph is None:
        return fold(*arguments)
    lifted = [a if isinstance(a, Symbol) else graph.constant(a) for a in arguments]
    if all(a.value is not None for a in lifted):
        return graph.constant(fold(*(a.value for a in lifted)))
    return graph.add(name, *(a.index for a in lifted))


def sqrt(x: Scalar) -> Scalar:
    return _call("sqrt", math.sqrt, x)


def absolute(x: Scalar) -> Scalar:
    return _call("fabs", abs, x)


def floor(x: Scalar) -> Scalar:
    return _call("floor", math.floor, x)


def round_even(x: Scalar) -> Scalar:
    """The nearest integer, ties to even."""
    return _call("rint", round, x)


def minimum(x: Scalar, y: Scalar) -> Scalar:
    return _call("min", min, x, y)


def maximum(x: Scalar, y: Scalar) -> Scalar:
    return _call("max", max, x, y)


def where_lt(a: Scalar, b: Scalar, x: Scalar, y: Scalar) -> Scalar:
    """x where a < b, else y; both are computed, so x and y must be finite on either side of the test."""
    return _call("where_lt", lambda a, b, x, y: x if a < b else y, a, b, x, y)


def atom(x: Scalar) -> Scalar:
    """x as one opaque term: keeps a sum from being merged into another, where the order of rounding matters."""
    return x.graph.add("atom", x.index) if isinstance(x, Symbol) and x.node[0] == "sum" else x


def polynomial(x: Scalar, coefficients: Sequence[float]) -> Scalar:
    """c0 + c1 x + c2 x^2 + ... by Horner's rule."""
    result: Scalar = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        result = atom(x * result + c)
    return result


# pi/2 in three parts of 33 bits: k times a part is exact for |k| < 2^20.
_HALF_PI = (1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624871116645580e-21)
# sin(r)/r and cos(r) on [-pi/4, pi/4] in r^2, the minimax coefficients of fdlibm (k_sin.c, k_cos.c).
_SIN = (
    -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04,
    2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10,
)  # fmt: skip
_COS = (
    4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05,
    -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11,
)  # fmt: skip


def sincos(x: Scalar) -> tuple[Scalar, Scalar]:
    """(sin x, cos x), error below 2 ulp of 1 for |x| < 1e6 (Cody-Waite reduction by pi/2, then polynomials)."""
    if not isinstance(x, Symbol):
        return math.sin(x), math.cos(x)
    k = round_even(x * (2.0 / math.pi))
    r = x
    for part in _HALF_PI:
        r = atom(r - k * part)
    z = atom(r * r)
    sine = r + r * z * polynomial(z, _SIN)
    cosine = 1.0 - 0.5 * z + z * z * polynomial(z, _COS)
    quadrant = k - 4.0 * floor(k * 0.25)
    odd = quadrant - 2.0 * floor(quadrant * 0.5)
    s, c = where_lt(odd, 0.5, sine, cosine), where_lt(odd, 0.5, cosine, sine)
    return where_lt(quadrant, 1.5, s, -s), where_lt(absolute(quadrant - 1.5), 1.0, -c, c)


# atan(t)/t on [0, tan(pi/8)] in t^2, minimax, relative error below 2e-16.
_ATAN = (
    1.0, -0.3333333333333312, 0.1999999999994089, -0.1428571427925024, 0.11111110744919396, -0.09090896809056438,
    0.07692045330765912, -0.06662951812061838, 0.05846878285787001, -0.050351024039430294, 0.037965256099576565,
    -0.017805395704537506,
)  # fmt: skip


def atan2(y: Scalar, x: Scalar) -> Scalar:
    """The angle of (x, y) in [-pi, pi], error below 4 ulp; atan2(0, 0) is 0."""
    if not isinstance(y, Symbol) and not isinstance(x, Symbol):
        return math.atan2(y, x)
    ax, ay = absolute(x), absolute(y)
    small, large = minimum(ax, ay), maximum(ax, ay)
    threshold = 0.41421356237309503 * large  # tan(pi/8): above it use atan(m) = pi/4 + atan((m-1)/(m+1))
    top = where_lt(threshold, small, small - large, small)
    bottom = where_lt(threshold, small, small + large, large)
    t = top / where_lt(0.0, bottom, bottom, 1.0)
    angle = t * polynomial(atom(t * t), _ATAN)
    angle = where_lt(threshold, small, angle + math.pi / 4, angle)
    angle = where_lt(ax, ay, math.pi / 2 - angle, angle)
    angle = where_lt(x, 0.0, math.pi - angle, angle)
    return where_lt(y, 0.0, -angle, angle)
