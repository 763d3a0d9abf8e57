"""Simulation and brackets against DOP853 on the plain model."""

import numpy as np
import plain_model as plain
import pytest

from horosphere.errors import InputError
from horosphere.snake import Snake, input_word, read_word, word_text


@pytest.mark.parametrize("fraction", [0.5, 0.4])
def test_piecewise_constant_inputs(fraction, rng):
    snake = Snake(lengths=rng.uniform(1, 2, 6), wheel_fraction=fraction)
    q, u = rng.uniform(-1, 1, snake.n), rng.normal(size=(5, 4))
    motion = snake.simulate(q, u, 2.0)
    expected = plain.drive(q, snake.lengths, fraction, u, 2.0)
    np.testing.assert_allclose(motion.end, expected, atol=1e-9)
    assert motion.reason == "" and motion.residual < 1e-12 and motion.time[-1] == pytest.approx(2.0)


def test_callables_and_splines(rng):
    from scipy.integrate import solve_ivp
    from scipy.interpolate import CubicSpline

    snake = Snake(6)
    q = rng.uniform(-1, 1, snake.n)
    spline = CubicSpline(np.linspace(0, 2, 6), rng.normal(size=(6, 4)))
    for controls in (lambda t: np.array([np.cos(3 * t), np.sin(2 * t), t, 1.0]), spline):
        motion = snake.simulate(q, controls, 2.0)
        edges = [0.0, *np.linspace(0, 2, 6)[1:]]
        state = q
        for a, b in zip(edges[:-1], edges[1:]):
            run = solve_ivp(
                lambda t, y, c=controls: plain.basis(y, snake.lengths, 0.5) @ c(t),
                (a, b),
                state,
                method="DOP853",
                rtol=1e-12,
                atol=1e-13,
            )
            state = run.y[:, -1]
        np.testing.assert_allclose(motion.end, state, atol=1e-9)


def test_eighth_order():
    from horosphere.snake._kernels import flow

    theta = np.array([0.3, -0.4, 0.9])
    rate = np.ones(3)
    ends = []
    for n in (8, 16, 128):
        inputs = np.tile([1.3, -0.7], (n, 5, 1))
        out = np.empty((n + 1, 3))
        flow(theta, inputs, np.full(n, 2.0 / n), rate, 1.0, out)
        ends.append(out[-1])
    slope = np.log2(np.abs(ends[0] - ends[2]).max() / np.abs(ends[1] - ends[2]).max())
    assert 7.5 < slope < 9.5


def test_wheels_never_slip_sideways(rng):
    """Displacement of each wheel point between close samples is along its link to second order."""
    snake = Snake(6)
    motion = snake.simulate(rng.uniform(-1, 1, snake.n), rng.normal(size=(200, 4)), 0.2)
    points = np.array([plain.wheels(p, snake.lengths, 0.5) for p in motion.q])[:, 1:-1]
    middle = np.array([plain.angles(p) for p in 0.5 * (motion.q[1:] + motion.q[:-1])])[:, 1:-1]
    steps = np.diff(points, axis=0)
    sideways = -np.sin(middle) * steps[..., 0] + np.cos(middle) * steps[..., 1]
    assert np.abs(sideways).max() < 1e-4 * np.abs(steps).max()


@pytest.mark.parametrize(
    "word, degree, order",
    [("12", 2, 2), ("112", 3, 3), ("212", 3, 3), ("1112", 4, 4), ("[1,[2,[1,2]]]", 4, 5), ("11112", 5, 5)],
)
def test_bracket_motions_have_the_order_of_their_bracket(word, degree, order):
    snake = Snake(7)
    q = np.array([0.1, 0.2, 0.3, 0.2, 0.5, -0.4, 0.8, -0.3, 0.1])
    result = snake.bracket_motion(q, word, 0.02)
    assert result.degree == degree
    assert abs(result.order - order) < 0.35
    if order == degree:
        assert abs(result.rest_order - degree - 1) < 0.5
        finer = snake.bracket_motion(q, word, 0.005 if degree < 5 else 0.01)
        np.testing.assert_allclose(finer.measured, finer.predicted, atol=0.2 * np.linalg.norm(finer.predicted))


def test_the_word_that_should_move_the_snake_at_t4_does_so_off_the_midpoint_only():
    q = np.array([0.1, 0.2, 0.3, 0.2, 0.5, -0.4, 0.8, -0.3, 0.1])
    middle = Snake(7).bracket_motion(q, "1212", 0.04)
    off = Snake(7, wheel_fraction=0.4).bracket_motion(q, "1212", 0.04)
    assert middle.order > 4.6 and off.order < 4.4
    assert np.linalg.norm(middle.predicted) < 1e-12 < np.linalg.norm(off.predicted)


def test_words_are_read_in_every_form():
    nested = (1, (2, (1, 2)))
    for form in ("1212", "[1,[2,[1,2]]]", "g1 g2 g1 g2", [1, 2, 1, 2], nested, np.array([1, 2, 1, 2])):
        assert read_word(form) == nested
    assert word_text(nested) == "[1,[2,[1,2]]]"
    assert len(input_word(read_word("12"), 1.0)) == 4
    assert sum(d for _, d in input_word(nested, 0.3)) == pytest.approx(0.0)


@pytest.mark.parametrize(
    "call, text",
    [
        (lambda s, q: s.simulate(q, np.zeros((3, 3))), "shape"),
        (lambda s, q: s.simulate(q, np.full((3, 4), np.nan)), "finite"),
        (lambda s, q: s.simulate(q, np.zeros((3, 4)), -1.0), "positive duration"),
        (lambda s, q: s.simulate(q, np.zeros((3, 4)), durations=[1.0, 2.0]), "shape"),
        (lambda s, q: s.simulate(q, lambda t: [np.nan] * 4), "finite"),
        (lambda s, q: s.bracket_motion(q, "12", 0.0), "positive leg time"),
    ],
)
def test_bad_input_is_named(call, text):
    with pytest.raises(InputError, match=text):
        call(Snake(6), np.zeros(8))
