"""exp and log of motors against extended precision and scipy, on both sides of every switch, with translations of order one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm, logm

import horosphere as hs
from horosphere.versors import _kernels as k

from .precise import relative_error, screw_matrix

SWITCH = 2 * np.sqrt(0.5)  # angle at which h = 1/2
ANGLES = [
    0.0, 1e-300, 1e-160, 1e-100, 1e-30, 1e-16, 1e-12, 2.8e-8, 1e-6, 1e-5, 1e-4, 1e-3, 0.1, 1.0,
    SWITCH * (1 - 1e-9), SWITCH * (1 - 1e-15), SWITCH * (1 + 1e-15), SWITCH * (1 + 1e-9),
    np.pi / 2, 3.0, np.pi - 1e-6, np.pi - 1e-9, np.pi - 1e-14, np.pi,
]  # fmt: skip
LARGE = [np.pi + 1e-14, np.pi + 1e-6, 4.0, 6.0, 2 * np.pi - 1e-6, 2 * np.pi - 1e-12, 2 * np.pi, 7.0, 40.0]


def screws(rng, angle, count, size=1.0):
    w, v = rng.normal(size=(2, count, 3))
    return np.concatenate([angle * w / np.linalg.norm(w, axis=-1, keepdims=True), size * v], -1)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("size", [0.0, 1.0, 1e4])
@pytest.mark.parametrize("angle", ANGLES + LARGE)
def test_exp_is_the_matrix_exponential(angle, size, seed):
    s = screws(np.random.default_rng(seed), angle, 6, size)
    matrices = hs.Motor.exp(s).as_matrix()
    bound = 4e-15 if angle < 8 else 2e-14
    for row, matrix in zip(s, matrices):
        rotation, translation = relative_error(matrix, row)
        assert rotation < bound and translation < bound


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("size", [0.0, 1.0, 1e4])
@pytest.mark.parametrize("angle", ANGLES)
def test_log_returns_the_screw(angle, size, seed):
    s = screws(np.random.default_rng(seed), angle, 16, size)
    back = hs.Motor.exp(s).log()
    if angle > np.pi - 1e-13:  # the axis may come back reversed: the same motion
        for row, matrix in zip(back, hs.Motor.exp(s).as_matrix()):
            assert max(relative_error(matrix, row)) < 1e-14
    else:
        np.testing.assert_allclose(back[:, :3], s[:, :3], rtol=1e-14, atol=1e-15 * angle)
        np.testing.assert_allclose(back[:, 3:], s[:, 3:], rtol=0, atol=2e-14 * max(size, 1e-300))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("angle", LARGE + ANGLES)
def test_log_is_the_short_way_and_the_same_for_minus_m(angle, seed):
    m = hs.Motor.exp(screws(np.random.default_rng(seed), angle, 8))
    s = m.log()
    assert (np.linalg.norm(s[:, :3], axis=-1) <= np.pi * (1 + 1e-15)).all()
    for row, matrix in zip(s, m.as_matrix()):
        assert max(relative_error(matrix, row)) < 4e-14
    again = (-m).log()
    for row, matrix in zip(again, m.as_matrix()):
        assert max(relative_error(matrix, row)) < 4e-14
    if abs(angle - np.pi) > 1e-13:
        np.testing.assert_allclose(again, s, rtol=0, atol=1e-15)


@pytest.mark.parametrize("seed", range(5))
def test_against_scipy(seed):
    s = screws(np.random.default_rng(seed), np.random.default_rng(seed).uniform(0.1, 3.0), 1)[0]
    matrix = expm(np.asarray(screw_matrix(s), float))
    np.testing.assert_allclose(hs.Motor.exp(s).as_matrix(), matrix, atol=1e-14)
    a = np.real(logm(matrix))
    np.testing.assert_allclose(hs.Motor.from_matrix(matrix).log(), [a[2, 1], a[0, 2], a[1, 0], *a[:3, 3]], atol=1e-12)


def test_log_of_the_identity_and_of_translations_is_exact():
    assert (hs.Motor.identity().log() == 0).all() and ((-hs.Motor.identity()).log() == 0).all()
    for size in (1e-300, 1e-12, 1.0, 1e4, 1e150):
        t = size * np.array([1.0, -2.0, 3.0])
        for m in (hs.Motor.from_translation(t), -hs.Motor.from_translation(t), hs.Translator.from_vector(t).as_motor()):
            np.testing.assert_array_equal(m.log(), [0, 0, 0, *t])
        np.testing.assert_array_equal(hs.Motor.exp([0, 0, 0, *t]).array, hs.Motor.from_translation(t).array)


@pytest.mark.parametrize("factor", [-3.0, 0.5, 1 + 1e-7, 1e3])
def test_log_and_renormalised_forget_the_weight(factor):
    m = hs.Motor.exp([0.3, -0.5, 1.0, 1.0, 2.0, -1.0])
    np.testing.assert_allclose(hs.Motor._wrap(m.array * factor).log(), m.log(), atol=1e-14)
    assert hs.Motor.renormalised(m.array * abs(factor)).isclose(m, atol=1e-14)


@pytest.mark.parametrize("seed", range(3))
def test_renormalised_is_unit_and_near(seed):
    rng = np.random.default_rng(seed)
    m = hs.Motor.exp(rng.normal(size=(20, 6)))
    noisy = m.array + 1e-4 * rng.normal(size=m.array.shape)
    clean = hs.Motor.renormalised(noisy)
    square = clean.as_multivector() * ~clean.as_multivector()
    assert square.isclose(hs.Multivector.scalar(np.ones(20)), atol=1e-14).all()
    assert np.abs(clean.array - m.array).max() < 2e-3
    assert hs.Motor.renormalised(m).isclose(m, rtol=1e-14, atol=1e-14).all()
    with pytest.raises(hs.InputError, match="rotation part"):
        hs.Motor.renormalised(np.zeros(8))


@pytest.mark.parametrize("count", [1, 7, 8, 19])
def test_lanes_scalars_and_reference_agree(count):
    rng = np.random.default_rng(count)
    s = np.concatenate([screws(rng, a, 1) for a in rng.choice(ANGLES + LARGE[:6], count)])
    m = k.motor_exp(s)
    np.testing.assert_allclose(m, k.motor_exp.reference(s), rtol=0, atol=1e-14)
    np.testing.assert_allclose(m, np.stack([k.motor_exp(row) for row in s]), rtol=0, atol=1e-14)
    np.testing.assert_allclose(k.motor_log(m), k.motor_log.reference(m), rtol=0, atol=1e-13)


def test_exp_is_the_exponential_of_the_algebra():
    s = np.random.default_rng(2).normal(size=6)
    w, v = s[:3], s[3:]
    e = hs.algebra.basis
    generator = hs.Multivector.vector([*w, 0, 0]) * e.Ie + (hs.Multivector.vector([*v, 0, 0]) ^ e.ei)
    assert (-0.5 * generator).exp().isclose(hs.Motor.exp(s).as_multivector(), rtol=1e-14)


@pytest.mark.parametrize("seed", range(3))
def test_interpolation_and_powers_follow_the_screw(seed):
    rng = np.random.default_rng(seed)
    a, b = hs.Motor.exp(rng.normal(size=(2, 6)))
    t = np.linspace(0, 1, 5)
    path = a.interpolate(b, t)
    assert path.shape == (5,) and path[0].is_same_motion(a) and path[-1].is_same_motion(b)
    step = np.real(logm(np.linalg.inv(a.as_matrix()) @ b.as_matrix()))
    for u, m in zip(t, path):
        np.testing.assert_allclose(m.as_matrix(), a.as_matrix() @ expm(u * step), atol=1e-12)
    assert (a**2).is_same_motion(a @ a) and (a**-1).is_same_motion(~a) and (a**0.5 @ a**0.5).is_same_motion(a)
    assert (-a).interpolate(b, 0.5).is_same_motion(path[2])


_part = st.floats(-20, 20, allow_subnormal=True)
_far = st.floats(-1e4, 1e4)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.tuples(_part, _part, _part, _far, _far, _far), st.tuples(_part, _part, _part, _far, _far, _far))
def test_any_screw(a, b):
    """exp against extended precision, log back to the same motion, and the product against that of the matrices."""
    bound = 4e-14  # up to 5 turns; the translation relative to |v|
    for s in (a, b):
        m = hs.Motor.exp(s)
        assert max(relative_error(m.as_matrix(), s)) < bound
        assert max(relative_error(m.as_matrix(), m.log())) < bound
        assert np.linalg.norm(m.log()[:3]) <= np.pi * (1 + 1e-15)
    product = hs.Motor.exp(a) @ hs.Motor.exp(b)
    size = max(1.0, *np.abs(a), *np.abs(b))
    expected = hs.Motor.exp(a).as_matrix() @ hs.Motor.exp(b).as_matrix()
    np.testing.assert_allclose(product.as_matrix(), expected, rtol=0, atol=1e-14 * size)
