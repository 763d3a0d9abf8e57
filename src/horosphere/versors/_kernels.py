"""Motor products, actions, exponential and logarithm: each expression once, as geometric algebra.

A screw (w, v) is the bivector B = w I_e + v ei, its motor exp(-B/2). With b = -B/2, J = e123 ei (J^2 = 0, J b = b J):

    b^2 = -h + p J,    exp b = C + (p S/2) J + (S + (p D/2) J) b,
    C = cos phi, S = sin(phi)/phi, D = (S - C)/h,  h = phi^2, phi half the angle.

S needs no series (sin is exact to rounding at any size). D does, for the 0/0 only: its rounding error eps/h enters
times |p b| <= h |v|, so both sides of the switch are exact to rounding of the translation.
"""

from __future__ import annotations

import math

from horosphere.kernels import (
    BIVECTOR,
    E0,
    E1,
    E2,
    E3,
    EI,
    EUCLIDEAN,
    MOTOR,
    MV,
    ROTOR,
    VECTOR,
    apply_motor,
    atan2,
    blades,
    kernel,
    maximum,
    polynomial,
    scalars,
    sincos,
    sqrt,
    where_lt,
)

J = blades("123i")[0]
_E12, _E13, _E23 = blades("12", "13", "23")
_ROTATION, _DUAL = blades("12", "13", "23"), blades("1i", "2i", "3i")
PLANE = blades("1", "2", "3", "i")
_TINY = 1e-300  # keeps 0/0 away; far below what the coefficients resolve

_SWITCH = 0.5  # of h; nine terms of the series have an error of 5e-19 there
_D_SERIES = [(-1.0) ** k * (2 * k + 2) / math.factorial(2 * k + 3) for k in range(9)]


def _difference_quotient(h, s, c):
    """D = (S - C)/h, at h = 0 its limit 1/3."""
    return where_lt(h, _SWITCH, polynomial(h, _D_SERIES), (s - c) / maximum(h, _SWITCH))


def generator(screw):
    """The bivector w I_e + v ei of a screw (w, v): six symbols in, MV out."""
    return MV.of(BIVECTOR, [screw[2], -screw[1], screw[0], *screw[3:]])


def exponential(bivector):
    """exp(-B/2) as an MV on MOTOR."""
    b = bivector * -0.5
    square = b * b
    h, p = -square[0], square[J]
    phi = sqrt(h + _TINY)
    sine, c = sincos(phi)
    s = sine / phi
    d = _difference_quotient(h, s, c)
    return b * s + b * MV({J: 0.5 * d * p}) + MV({0: c, J: 0.5 * s * p})


def _norm(m):
    return sqrt(m[0] * m[0] + sum(m[b] * m[b] for b in _ROTATION))


def logarithm(motor):
    """B with exp(-B/2) = M or -M (the same motion), the angle in [0, pi]; M need not be normalised."""
    scale = 1.0 / _norm(motor)
    m = motor * where_lt(motor[0], 0.0, -scale, scale)
    k = sqrt(sum(m[b] * m[b] for b in _ROTATION) + _TINY)
    phi = atan2(k, m[0])
    inverse_s = phi / k
    h = phi * phi  # the twist is p J (D/2) of the module's formula, with D / S^2 = (k - c phi)/(phi k^2)
    direct = (k - m[0] * phi) / where_lt(h, _SWITCH, 1.0, phi * k * k)
    twist = where_lt(h, _SWITCH, polynomial(h, _D_SERIES) * (inverse_s * inverse_s), direct) * m[J]
    return (m.only(BIVECTOR) - MV({J: twist}) * m.only(_ROTATION)) * (-2.0 * inverse_s)


def as_screw(bivector):
    """The six symbols (w, v) of a bivector."""
    return [bivector[_E23], -bivector[_E13], bivector[_E12], *(bivector[b] for b in _DUAL)]


# ---- the group
@kernel(MOTOR, a=MOTOR, b=MOTOR)
def motor_product(a, b):
    """a b: b first, then a."""
    return a * b


@kernel(ROTOR, a=ROTOR, b=ROTOR)
def rotor_product(a, b):
    """a b of rotors."""
    return a * b


@kernel(MOTOR, a=PLANE, b=PLANE)
def reflector_product(a, b):
    """pi_a pi_b: reflection in b, then in a [Humanoid, eqs 12-15]."""
    return a * b


@kernel(MOTOR, screw=scalars(6), finite=True)
def motor_exp(screw):
    """exp(-(w I_e + v ei)/2)."""
    return exponential(generator(screw))


@kernel(6, m=MOTOR)
def motor_log(m):
    """The screw of a motor, angle in [0, pi]."""
    return as_screw(logarithm(m))


@kernel(MOTOR, a=MOTOR, b=MOTOR, t=None)
def motor_interpolate(a, b, t):
    """a exp(t log(~a b)): the screw motion from a to b at constant speed."""
    return a * exponential(logarithm(~a * b) * t)


@kernel(MOTOR, m=MOTOR)
def motor_renormalised(m):
    """m / sqrt(m ~m), where m ~m = a + b J: the nearest unit motor."""
    square = m * ~m
    scale = 1.0 / sqrt(square[0])
    return m * (MV({0: scale, J: -0.5 * square[J] * scale / square[0]}))


@kernel(MOTOR, l=BIVECTOR, angle=None, advance=None)
def motor_of_line(l, angle, advance):
    """exp(-angle/2 L) (1 - advance/2 n ei): turn about a line and advance along it [Humanoid, eqs 16-17]."""
    s, c = sincos(0.5 * angle)
    n = MV.of(EUCLIDEAN, [l[_E23], -l[_E13], l[_E12]])
    return (MV({0: c}) - l * s) * (MV({0: 1.0}) - (n * EI) * (0.5 * advance))


# ---- matrices
@kernel(16, axes=[(4, 4)], m=MOTOR)
def motor_matrix(m):
    """The 4 x 4 matrix of a unit motor, row by row."""
    columns = [apply_motor(m, x, EUCLIDEAN).on(EUCLIDEAN) for x in (E1, E2, E3, E0)]
    return [column[row] for row in range(3) for column in columns] + [0.0, 0.0, 0.0, 1.0]


def _rotor_of_matrix(r):
    """The rotor of a rotation matrix (list of 9, row by row), scalar >= 0: the best conditioned of four formulas."""
    (a, b, c), (d, e, f), (g, h, i) = r[:3], r[3:6], r[6:]
    x, y, z = h - f, c - g, d - b  # 4 s n, off-diagonal differences
    xy, xz, yz = d + b, c + g, h + f
    quaternions = [
        [1.0 + a + e + i, x, y, z],
        [x, 1.0 + a - e - i, xy, xz],
        [y, xy, 1.0 - a + e - i, yz],
        [z, xz, yz, 1.0 - a - e + i],
    ]

    def larger(p, q):  # each a pair (size, quaternion)
        return where_lt(p[0], q[0], q[0], p[0]), [where_lt(p[0], q[0], v, u) for u, v in zip(p[1], q[1], strict=True)]

    sized = [(quaternions[k][k], quaternions[k]) for k in range(4)]
    _, q = larger(larger(sized[0], sized[1]), larger(sized[2], sized[3]))
    scale = 1.0 / sqrt(sum(u * u for u in q))
    w, x, y, z = (u * where_lt(q[0], 0.0, -scale, scale) for u in q)
    return MV.of(ROTOR, [w, -z, y, -x])


@kernel(ROTOR, r=scalars(9))
def rotor_of_matrix(r):
    """The rotor of a 3 x 3 rotation matrix, row by row."""
    return _rotor_of_matrix(r)


@kernel(MOTOR, t=scalars(16))
def motor_of_matrix(t):
    """The motor of a 4 x 4 rigid transform, row by row: translator times rotor."""
    move = MV.of(EUCLIDEAN, [t[3], t[7], t[11]])
    return (MV({0: 1.0}) - (move * EI) * 0.5) * _rotor_of_matrix([*t[:3], *t[4:7], *t[8:11]])


@kernel(3, m=MOTOR)
def motor_translation(m):
    """Where a unit motor takes the origin."""
    return apply_motor(m, E0, EUCLIDEAN).on(EUCLIDEAN)


# ---- action of unit motors on entities
def _place(m, x):
    return apply_motor(m, MV.of(EUCLIDEAN, x) + E0, EUCLIDEAN).on(EUCLIDEAN)


def _direction(m, v):
    return apply_motor(m, MV.of(EUCLIDEAN, v), EUCLIDEAN).on(EUCLIDEAN)


def _null(x, weight):
    """The point array: x, weight, x^2/2, exactly null after every action."""
    return MV.of(VECTOR, [*x, weight, weight * (0.5 * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]))])


@kernel(VECTOR, m=MOTOR, x=VECTOR)
def motor_point(m, x):
    """M x ~M."""
    weight = x.on(VECTOR)[3]
    return _null(apply_motor(m, x.only(VECTOR[:4]), EUCLIDEAN).on(EUCLIDEAN), weight)


@kernel(BIVECTOR, m=MOTOR, x=BIVECTOR)
def motor_line(m, x):
    """M L ~M."""
    return apply_motor(m, x, BIVECTOR)


@kernel(PLANE, m=MOTOR, x=PLANE)
def motor_plane(m, x):
    """M pi ~M."""
    return apply_motor(m, x, PLANE)


@kernel(4, m=MOTOR, x=scalars(4))
def motor_sphere(m, x):
    """M s ~M in centred form: the center moves, the radius stays."""
    return [*_place(m, x[:3]), x[3]]


@kernel(7, m=MOTOR, x=scalars(7))
def motor_round(m, x):
    """Circle or point pair in centred form: place, direction, squared radius."""
    return [*_place(m, x[:3]), *_direction(m, x[3:6]), x[6]]


# ---- reflections in a unit plane
def _mirror(p, x):
    return (p * x) * p * -1.0


@kernel(VECTOR, p=PLANE, x=VECTOR)
def reflect_point(p, x):
    """-pi x pi [Humanoid, section IV-1]."""
    return _null(_mirror(p, x.only(VECTOR[:4])).on(EUCLIDEAN), x.on(VECTOR)[3])


@kernel(PLANE, p=PLANE, x=PLANE)
def reflect_plane(p, x):
    """-pi x pi."""
    return _mirror(p, x)


@kernel(BIVECTOR, p=PLANE, x=BIVECTOR)
def reflect_line(p, x):
    """-pi L pi: the line from a to b becomes the one between their images, in this direction."""
    return _mirror(p, x)


@kernel(4, p=PLANE, x=scalars(4))
def reflect_sphere(p, x):
    """Center reflected, radius kept."""
    return [*_mirror(p, MV.of(EUCLIDEAN, x[:3]) + E0).on(EUCLIDEAN), x[3]]


@kernel(7, p=PLANE, x=scalars(7))
def reflect_round(p, x):
    """Center and direction reflected, radius kept."""
    center = _mirror(p, MV.of(EUCLIDEAN, x[:3]) + E0).on(EUCLIDEAN)
    return [*center, *_mirror(p, MV.of(EUCLIDEAN, x[3:6])).on(EUCLIDEAN), x[6]]
