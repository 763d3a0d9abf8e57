"""Arithmetic of the numerical inverse, written once: the error of a pose, a damped least-squares step in six rows."""

from __future__ import annotations

from typing import Any

from ..kernels import E0, EUCLIDEAN, MOTOR, MV, ROTOR, apply_motor, atan2, kernel, scalars, sqrt, where_lt

TINY = 1e-300


def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Any, b: Any) -> list[Any]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


@kernel(14, m=MOTOR, target=MOTOR, place=scalars(3), direction=scalars(3), axis=scalars(3), rules=scalars(3))
def goal_error(m, target, place, direction, axis, rules):
    """Error of the tool pose m: rotation vector (3), displacement (3), then tool point (3), tool axis (3), angle,
    distance.

    rules = (whole, aim, line), each 0 or 1: whole: the rotation is the logarithm of the rotor of target ~m; aim: the
    one that takes the tool's axis to `direction`; neither: zero. line: the displacement to `place` without its part
    along `direction`.
    """
    whole, aim, line = rules
    p = apply_motor(m, E0, EUCLIDEAN).on(EUCLIDEAN)
    moved = apply_motor(m, MV.of(EUCLIDEAN, axis) + E0, EUCLIDEAN).on(EUCLIDEAN)
    a = [moved[k] - p[k] for k in range(3)]
    d = [place[k] - p[k] for k in range(3)]
    along = _dot(d, direction) * line
    d = [d[k] - along * direction[k] for k in range(3)]

    e = (target.only(ROTOR) * ~m.only(ROTOR)).on(ROTOR)
    sign = where_lt(e[0], 0.0, -1.0, 1.0)  # M and -M are the same pose: the shorter way
    rotor = [e[3] * (sign * -1.0), e[2] * sign, e[1] * (sign * -1.0)]
    cosine_aim = _dot(a, direction)
    turn = _cross(a, direction)
    # axis opposite to the direction: turn about any normal of it
    flat = where_lt(_dot(turn, turn), 1e-20, where_lt(cosine_aim, 0.0, 1.0, 0.0), 0.0)
    x_large = where_lt(0.36, a[0] * a[0], 1.0, 0.0)
    normal = [x_large * a[2] * -1.0, a[2] * (1.0 - x_large), a[0] * x_large - a[1] * (1.0 - x_large)]
    turn = [turn[k] + flat * 1e-10 * normal[k] for k in range(3)]

    w = [rotor[k] * whole + turn[k] * aim for k in range(3)]
    cosine = e[0] * sign * whole + cosine_aim * aim + (1.0 - whole) * (1.0 - aim)
    sine = sqrt(_dot(w, w) + TINY)
    angle = atan2(sine, cosine) * (1.0 + whole)
    scale = angle / sine
    return [*(w[k] * scale for k in range(3)), *d, *p, *a, angle, sqrt(_dot(d, d))]


@kernel(6, column=scalars(6), tool=scalars(3), direction=scalars(3), rules=scalars(3), weight=None)
def restricted_column(column, tool, direction, rules, weight):
    """A column of the twist Jacobian as one of the weighted error: without what the goal leaves free."""
    whole, aim, line = rules
    w, v = column[:3], column[3:]
    roll, along = _dot(w, tool) * aim, _dot(v, direction) * line
    size = weight * (whole + aim)
    return [*((w[k] - roll * tool[k]) * size for k in range(3)), *(v[k] - along * direction[k] for k in range(3))]


@kernel(21, total=scalars(21), g=scalars(6))
def add_outer(total, g):
    """Lower triangle of total + g g^T, row by row."""
    pairs = [(r, s) for r in range(6) for s in range(r + 1)]
    return [total[k] + g[r] * g[s] for k, (r, s) in enumerate(pairs)]


@kernel(6, y=scalars(6), g=scalars(6), factor=None)
def add_scaled(y, g, factor):
    """y + factor g."""
    return [y[r] + g[r] * factor for r in range(6)]


@kernel(6, lower=scalars(21), y=scalars(6), damping=None)
def damped_solve(lower, y, damping):
    """x with (A + damping) x = y, A symmetric by its lower triangle: Cholesky's factorisation, unrolled."""
    at = {(r, s): lower[r * (r + 1) // 2 + s] for r in range(6) for s in range(r + 1)}
    inverse, x = [], list(y)
    for r in range(6):
        for s in range(r + 1):
            value = at[r, s] + damping if r == s else at[r, s]
            for k in range(s):
                value = value - at[r, k] * at[s, k]
            if r == s:
                inverse.append(1.0 / sqrt(value + TINY))
            else:
                at[r, s] = value * inverse[s]
    for r in range(6):
        for k in range(r):
            x[r] = x[r] - at[r, k] * x[k]
        x[r] = x[r] * inverse[r]
    for r in reversed(range(6)):
        for k in range(r + 1, 6):
            x[r] = x[r] - at[k, r] * x[k]
        x[r] = x[r] * inverse[r]
    return x


@kernel(1, g=scalars(6), x=scalars(6))
def dot6(g, x):
    """g . x."""
    return [sum(g[r] * x[r] for r in range(6))]
