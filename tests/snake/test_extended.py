"""Angles in extended precision: against exact sums, against the return of a long way, and against floats where these suffice."""

from fractions import Fraction

import numpy as np
import pytest

from horosphere.snake import Snake
from horosphere.snake._extended import direction, extended_angles


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, -2.5, 7.1, -40.0])
def test_direction_has_32_digits(angle):
    c, c_low, s, s_low = (Fraction(v) for v in direction(angle))
    assert abs(float((c + c_low) ** 2 + (s + s_low) ** 2 - 1)) < 1e-31
    assert float(c) == pytest.approx(np.cos(angle), abs=1e-16)
    assert float(s) == pytest.approx(np.sin(angle), abs=1e-16)


def test_a_long_way_out_and_back_returns_where_floats_do_not():
    rng = np.random.default_rng(3)
    theta, k = rng.uniform(-1.2, 1.2, 7), 7
    heading = float(np.angle(-np.exp(1j * theta).sum()))
    out = np.repeat([[24.0 * np.cos(heading), 24.0 * np.sin(heading)]], 12, axis=0)
    inputs = np.concatenate([out, -out])
    nodes = np.repeat(np.repeat(inputs, 64, axis=0)[:, None], 5, axis=1)
    steps = np.full(len(nodes), 1.0 / 24 / 64)
    assert np.abs(extended_angles(theta, nodes, steps, np.ones(k), 1.0)[-1] - theta).max() < 1e-14
    from horosphere.snake._motion import _floats

    assert np.abs(_floats(theta, nodes, steps, np.ones(k), 1.0)[-1] - theta).max() > 1e-12


@pytest.mark.parametrize("seed, fraction", [(0, 0.5), (1, 0.6)])
def test_equals_the_float_integrator_on_short_ways(seed, fraction):
    rng = np.random.default_rng(seed)
    snake = Snake(6, wheel_fraction=fraction)
    theta = rng.uniform(-1, 1, 4)
    nodes = np.repeat(rng.normal(size=(8, 1, 2)), 5, axis=1)
    from horosphere.snake._motion import _floats

    args = theta, nodes, np.full(8, 0.03), snake.wheel_rates, snake.wheel_ratio
    np.testing.assert_allclose(extended_angles(*args), _floats(*args), atol=1e-14)
