"""Steering: arrival checked by DOP853 on the plain model."""

import numpy as np
import plain_model as plain
import pytest

from horosphere.errors import InputError
from horosphere.snake import Snake


def problem(snake, rng, distance):
    q0 = np.concatenate([rng.uniform(-1, 1, 3), rng.uniform(-1.2, 1.2, snake.links - 1)])
    way = rng.normal(size=snake.n)
    return q0, q0 + distance * way / np.linalg.norm(way)


@pytest.mark.parametrize("distance", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("links", [4, 5, 6, 7])
def test_arrives_exactly(links, distance, rng):
    snake = Snake(links)
    q0, q1 = problem(snake, rng, distance)
    result = snake.steer(q0, q1)
    assert result.solved, result.reason
    assert result.error <= 1e-9
    end = plain.drive(q0, snake.lengths, 0.5, result.inputs, 1.0)
    np.testing.assert_allclose(end, q1, atol=1e-6)  # the witness integrates an unstable way to 1e-12


def test_off_centre_wheels_and_unequal_lengths(rng):
    for snake in (Snake(5, wheel_fraction=0.6), Snake(lengths=[1.0, 1.5, 2.0, 1.2, 1.0])):
        q0, q1 = problem(snake, rng, 0.1)
        result = snake.steer(q0, q1)
        assert result.solved, result.reason
        np.testing.assert_allclose(
            plain.drive(q0, snake.lengths, snake.wheel_fraction, result.inputs, 1.0), q1, atol=1e-6
        )


def test_a_singular_posture_is_no_obstacle():
    snake = Snake(6)
    q1 = np.zeros(8)
    q1[1] = 0.1
    assert snake.steer(np.zeros(8), q1).solved


def test_nothing_to_do_is_done_with_no_input():
    q = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.1, 0.2, 0.3])
    result = Snake(6).steer(q, q + 2 * np.pi * np.array([0, 0, 1, 0, 0, 0, 0, -1]))
    assert result.solved and result.path_length == 0.0 and result.tries == 0


def test_shortening_shortens(rng):
    snake = Snake(6)
    q0, q1 = problem(snake, rng, 0.05)
    assert snake.steer(q0, q1).path_length < snake.steer(q0, q1, shorten=0).path_length


def test_failure_is_a_value():
    snake = Snake(9)
    q0, q1 = problem(snake, np.random.default_rng(5), 3.0)
    result = snake.steer(q0, q1, tries=1, iterations=1)
    assert not result.solved and "starting paths" in result.reason and not result.inputs.any()


@pytest.mark.parametrize(
    "call, text",
    [
        (lambda s: s.steer([0, 0, 0, 0, np.pi, 0, 0, 0], np.zeros(8)), "fold of joint 2"),
        (lambda s: s.steer(np.zeros(8), [0, 0, 0, 0, 0.1, 0.1, -np.pi, 0]), "fold of joint 4"),
        (lambda s: s.steer(np.zeros(8), np.zeros(8), tolerance=0.0), "tolerance"),
        (lambda s: s.steer(np.zeros(8), np.zeros(8), effort=3), "unknown option"),
        (lambda s: s.steer(np.zeros(8), np.zeros(8), segments=7), "even number"),
        (lambda s: s.steer(np.zeros(8), np.zeros(7)), "posture of 8"),
    ],
)
def test_bad_input_is_named(call, text):
    with pytest.raises(InputError, match=text):
        call(Snake(6))


@pytest.mark.slow
@pytest.mark.parametrize("links, share", [(5, 0.95), (6, 0.95), (7, 0.95), (8, 0.95), (9, 0.9)])
def test_success_on_random_problems(links, share):  # N = links - 1
    snake, rng, solved = Snake(links), np.random.default_rng(100 + links), 0
    for distance in np.geomspace(0.01, 1.0, 40):
        solved += snake.steer(*problem(snake, rng, distance)).solved
    assert solved >= share * 40
