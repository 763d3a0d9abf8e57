"""The geometry of a joint, written once: used on numbers, on lanes, and with a robot's constants folded in.

A joint with unit axis u turns by exp(-q/2 A) with A = u e123 (revolute), or slides by exp(-q/2 A) with A = u e_inf
(prismatic).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..kernels import BIVECTOR, E0, EI, EUCLIDEAN, MOTOR, MV, VECTOR, apply_motor, blades, kernel, scalars, sincos

TURNS, SLIDES = blades("23", "13", "12"), blades("1i", "2i", "3i")


def axis_generator(kind: str, u: Sequence[Any]) -> MV:
    """The generator A of a joint: the axis as an IPNS line through the origin, or the direction times e_inf."""
    return MV.of(TURNS, (u[0], u[1] * -1.0, u[2])) if kind == "revolute" else MV.of(SLIDES, u)


def joint_motor(kind: str, u: Sequence[Any], q: Any) -> MV:
    """exp(-q/2 A)."""
    if kind == "prismatic":
        return MV({0: 1.0}) + axis_generator(kind, u) * (q * -0.5)
    s, c = sincos(q * 0.5)
    return MV({0: c}) - axis_generator(kind, u) * s


def tip_column(generator: MV, x: Sequence[Any]) -> list[Any]:
    """Twist (angular, linear at x) of a unit joint rate about a generator L in base axes.

    The angular part is the direction of L; the linear part is the Euclidean part of X . L with X the conformal point
    at x: the inner-product theorem, d/dq (exp(-q L/2) X exp(q L/2)) = X . L ([Snake], [Humanoid]).
    """
    point = MV.of(EUCLIDEAN, x) + E0 + EI * ((x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) * 0.5)
    moved = point.times(generator, lambda r, s, t: t == 1, layout=EUCLIDEAN)
    n1, n2, n3 = generator.on(TURNS)
    return [n1, n2 * -1.0, n3, *moved.on(EUCLIDEAN)]


@kernel(MOTOR, m=MOTOR, k=MOTOR)
def compose(m, k):
    """m @ k."""
    return m * k


@kernel(MOTOR, m=MOTOR, k=MOTOR, u=scalars(3), q=None)
def turn(m, k, u, q):
    """Pose after a revolute joint: parent m, origin k, axis u, angle q."""
    return m * k * joint_motor("revolute", u, q)


@kernel(MOTOR, m=MOTOR, k=MOTOR, u=scalars(3), q=None)
def slide(m, k, u, q):
    """Pose after a prismatic joint."""
    return m * k * joint_motor("prismatic", u, q)


@kernel(3, m=MOTOR, x=EUCLIDEAN)
def move_point(m, x):
    """Position in the base frame of a point of the frame m."""
    return apply_motor(m, x + E0, EUCLIDEAN).on(EUCLIDEAN)


@kernel(BIVECTOR, m=MOTOR, u=scalars(3))
def turn_generator(m, u):
    """The axis, in base axes, of a revolute joint with frame m and axis u: an IPNS line."""
    return apply_motor(m, axis_generator("revolute", u), BIVECTOR)


@kernel(BIVECTOR, m=MOTOR, u=scalars(3))
def slide_generator(m, u):
    """The direction times e_inf, in base axes, of a prismatic joint."""
    return apply_motor(m, axis_generator("prismatic", u), BIVECTOR)


@kernel(VECTOR, x=VECTOR, g=BIVECTOR)
def vector_rate(x, g):
    """[X, G] / 2 = X . G of a point, sphere or plane."""
    return (x * g - g * x).only(VECTOR) * 0.5


@kernel(BIVECTOR, x=BIVECTOR, g=BIVECTOR)
def line_rate(x, g):
    """[X, G] / 2 of an IPNS line."""
    return (x * g - g * x).only(BIVECTOR) * 0.5


@kernel(6, m=MOTOR, u=scalars(3), x=scalars(3))
def turn_column(m, u, x):
    """Column of the tip Jacobian at x of a revolute joint with frame m and axis u."""
    return tip_column(apply_motor(m, axis_generator("revolute", u), BIVECTOR), x)


@kernel(6, m=MOTOR, u=scalars(3), x=scalars(3))
def slide_column(m, u, x):
    """The same of a prismatic joint."""
    return tip_column(apply_motor(m, axis_generator("prismatic", u), BIVECTOR), x)
