"""docs/errata.md, sections II-IV of [Humanoid]: each printed formula fails and its correction holds, in the dense algebra."""

import numpy as np
import pytest

import horosphere as hs
from horosphere.algebra import Multivector, basis

e1, e2, e3, e4, e5, e0, ei, Ie, E, I = basis
RNG = np.random.default_rng(0)


def vec(x):
    return Multivector.vector([*x, 0.0, 0.0])


def up(x):
    return vec(x) + 0.5 * float(np.dot(x, x)) * ei + e0


def size(a):
    return np.abs(a.coefficients).max()


A, B, C = RNG.normal(size=(3, 3))
NORMAL = np.array([2.0, -1.0, 2.0]) / 3.0
D = 0.8
PI = vec(NORMAL) + D * ei


def test_eq_3_the_origin():
    printed = 0.5 * (e4 - e5)
    assert (ei | printed).scalar_part == 1.0 and (ei | e0).scalar_part == -1.0
    x = vec(A) + 0.5 * A @ A * ei + printed
    assert (x * x).scalar_part == pytest.approx(2 * A @ A)  # not null
    assert (up(A) * up(A)).scalar_part == pytest.approx(0, abs=1e-15)
    assert (up(A) | up(B)).scalar_part == pytest.approx(-0.5 * (A - B) @ (A - B))


def test_eqs_4_to_9_spheres_and_planes():
    sphere = up(A) - 0.5 * 0.7**2 * ei
    assert (sphere * sphere).scalar_part == pytest.approx(0.49)
    assert sphere.isclose(hs.Sphere.from_center_radius(A, 0.7).as_ipns())
    through = up(A) ^ up(B) ^ up(C) ^ ei  # eq 6
    n = np.cross(B - A, C - A)
    assert (through * I).isclose(vec(n) + float(n @ A) * ei, atol=1e-13)  # eq 7: pi = pi* I
    assert sphere.dual().isclose(sphere * I.inverse()) and not sphere.dual().isclose(sphere * I)  # eq 5 needs I^-1


def test_eq_10_the_line():
    a, b = up(A), up(B)
    line = (a ^ b ^ ei) * I
    n, bivector, vector = vec(B - A), vec(A) ^ vec(B - A), vec(np.cross(A, B - A))
    assert line.isclose(n * Ie + ei * bivector * Ie) and line.isclose(n * Ie - (ei ^ vector))
    assert not line.isclose(n * Ie - ei * bivector * Ie)  # as printed, m = p ^ n: the line through -p
    assert (n * Ie - ei * vector * Ie).grades() == (2, 3)  # as printed, m = p x n: mixed grades


def test_eq_11_reflection():
    image = up(A - 2 * (A @ NORMAL - D) * NORMAL)
    assert (-PI * up(A) * PI.inverse()).isclose(image)
    assert (PI * up(A) * PI.inverse()).isclose(-image)  # as printed: weight -1
    circle = up(A) ^ PI
    assert (PI * circle * PI).isclose((-PI * up(A) * PI) ^ (-PI * PI * PI))  # even grade: no sign


def test_eqs_12_13_translation():
    n = vec(NORMAL)
    t, a = PI * n, 2 * D * vec(NORMAL)
    assert t.isclose(1 - 0.5 * (a * ei)) and t.isclose(1 + 0.5 * (ei * a))
    assert not t.isclose(1 + 0.5 * (a * ei))  # as printed
    assert (t * up(A) * ~t).isclose(up(A + 2 * D * NORMAL))
    wrong = 1 + 0.5 * (a * ei)
    assert (wrong * up(A) * ~wrong).isclose(up(A - 2 * D * NORMAL))
    assert t.isclose(hs.Translator.from_vector(2 * D * NORMAL).as_multivector())


def test_eqs_14_15_rotation():
    n1, n2 = np.array([1.0, 0, 0]), np.array([np.cos(0.4), np.sin(0.4), 0])
    rotor = vec(n2) * vec(n1)
    plane = (vec(n1) ^ vec(n2)) / np.sin(0.4)
    assert rotor.isclose((-0.5 * 0.8 * plane).exp())
    assert rotor.isclose(hs.Rotor.from_axis_angle([0, 0, 1], 0.8).as_multivector())
    assert size(rotor - (-0.5 * 0.8 * (vec(n2) ^ vec(n1))).exp()) > 0.1  # as printed


def test_eqs_16_17_motor_and_screw():
    line = hs.Line.from_points(A, B)
    L = line.as_ipns()
    assert (L * L).isclose(Multivector.scalar(-1.0))
    m = np.cos(0.35) - np.sin(0.35) * L
    assert m.isclose((-0.35 * L).exp()) and m.isclose(hs.Motor.from_line_angle(line, 0.7).as_multivector())
    assert (m * up(A) * ~m).isclose(up(A))  # a pure rotation leaves the axis where it is: no screw
    screw = m * (1 - 0.5 * 0.3 * vec(line.direction) * ei)
    assert (screw * up(A) * ~screw).isclose(up(A + 0.3 * line.direction))
    assert screw.isclose(hs.Motor.from_line_angle(line, 0.7, 0.3).as_multivector())


def test_step_1_of_the_algorithm_distance_by_the_inner_product():
    """sqrt(-2 x.y) of two points 1e-8 apart has no digit left; the distance of the entities has all."""
    a, b = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 3.0 + 1e-8])
    exact = b[2] - a[2]
    printed = -2 * (up(a) | up(b)).scalar_part
    assert abs(printed - exact**2) > 0.5 * exact**2
    assert hs.Point.from_euclidean(a).distance_to(hs.Point.from_euclidean(b)) == exact
