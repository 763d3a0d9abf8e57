"""Navigation: the certificate against a dense sampling of its own."""

import numpy as np
import plain_model as plain
import pytest

from horosphere.errors import InputError
from horosphere.snake import Snake


def body_clearance(q, lengths, centers, radii, width):
    joints = plain.joints(q, lengths)
    t = np.linspace(0, 1, 60)[:, None]
    points = np.concatenate([a + t * (b - a) for a, b in zip(joints[:-1], joints[1:])])
    return min(np.linalg.norm(points - c, axis=1).min() - r for c, r in zip(centers, radii)) - 0.5 * width


def straight(snake, x, y, heading):
    q = np.zeros(snake.n)
    q[:3] = x, y, heading + np.pi
    return q


@pytest.fixture(scope="module")
def slalom():
    snake = Snake(6)
    obstacles = (np.array([[20.0, 1.0], [32.0, -2.0]]), np.array([3.0, 3.0]))
    q0, q1 = straight(snake, 0, 0, 0.0), straight(snake, 56, 0, 0.0)
    return snake, q0, q1, obstacles, snake.navigate(q0, q1, obstacles)


def test_reaches_the_goal_among_discs(slalom):
    snake, q0, q1, _, result = slalom
    assert result.solved, result.reason
    assert result.failure == "" and result.error < 1e-6
    np.testing.assert_array_equal(result.motion.q[0], q0)
    assert np.abs(np.exp(1j * result.motion.end[2:]) - np.exp(1j * q1[2:])).max() < 1e-6


def test_certificate_bounds_dense_samples(slalom):
    snake, _, _, (centers, radii), result = slalom
    certificate = result.certificate
    assert certificate.certified and certificate.clearance >= 0.05 and not certificate.unresolved
    sampled = [body_clearance(q, snake.lengths, centers, radii, 0.1) for q in result.motion.q[::2]]
    assert certificate.clearance <= min(sampled) + 1e-9
    assert certificate.sampled == pytest.approx(min(sampled), abs=0.05)


def test_certificate_finds_what_lies_between_samples():
    """A disc that the body passes through between two postures of a coarse motion."""
    from horosphere.snake._world import Surroundings, certify_motion

    snake = Snake(5)
    motion = snake.simulate(straight(snake, 0, 0, 0.0), np.array([[6.0, 0.0, 0.0, 0.0]]), 1.0, tolerance=1.0)
    clear = Surroundings(np.array([[3.0, 1.0]]), np.array([0.8]), None, None, ())
    touching = Surroundings(np.array([[3.0, 1.0]]), np.array([0.99]), None, None, ())
    assert certify_motion(snake, motion, clear, 0.05, 0.1).certified
    assert not certify_motion(snake, motion, touching, 0.05, 0.1).certified


def test_weaving_leaves_the_singular_postures():
    snake = Snake(6)
    q0, q1 = straight(snake, 0, 0, 0.0), straight(snake, 60, 0, 0.0)
    plainly, weaving = (snake.navigate(q0, q1, (np.zeros((0, 2)), np.zeros(0)), weave=w) for w in (0.0, 0.5))
    assert plainly.solved and weaving.solved
    middle = [r.singularity(snake)[len(r.motion.time) // 4 : len(r.motion.time) // 2] for r in (plainly, weaving)]
    assert np.median(middle[1]) > 10 * np.median(middle[0])


def test_failure_is_classified():
    snake = Snake(6)
    ring = [[58 + 16 * np.cos(a), 16 * np.sin(a)] for a in np.linspace(0, 2 * np.pi, 10, endpoint=False)]
    result = snake.navigate(straight(snake, 0, 0, 0.0), straight(snake, 64, 0, 0.0), (ring, np.full(len(ring), 5.0)))
    assert not result.solved
    assert result.failure in ("path", "body") and result.reason and len(result.attempts) > 3


@pytest.mark.parametrize(
    "obstacles, text",
    [
        (([[0.0, 0.3]], [0.5]), "q0: an obstacle is"),
        (([[30.0, 0.3]], [0.5]), "q1: an obstacle is"),
        (([[5.0, 5.0]], [0.5, 0.2]), "one radius"),
        ([3.0], "plane obstacles"),
    ],
)
def test_bad_worlds_are_named(obstacles, text):
    snake = Snake(6)
    with pytest.raises(InputError, match=text):
        snake.navigate(straight(snake, 0, 0, 0), straight(snake, 30, 0, 0), obstacles)


def test_bad_options_are_named():
    snake = Snake(6)
    with pytest.raises(InputError, match="unknown option"):
        snake.navigate(np.zeros(8), straight(snake, 30, 0, 0), [], wide=1)
    with pytest.raises(InputError, match="lower corner"):
        snake.navigate(np.zeros(8), straight(snake, 30, 0, 0), [], workspace=([1, 1], [0, 0]))


def test_dubins_curves_join_their_ends(rng):
    from horosphere.snake._dubins import dubins

    for _ in range(50):
        a, b = rng.uniform(-5, 5, (2, 3))
        curves = dubins(tuple(a), tuple(b), 1.5, 0.01)
        assert curves
        lengths = [np.linalg.norm(np.diff(c[:, :2], axis=0), axis=1).sum() for c in curves]
        assert lengths == sorted(lengths) or np.allclose(lengths, sorted(lengths), atol=1e-2)
        for curve in curves:
            np.testing.assert_allclose(curve[-1, :2], b[:2], atol=1e-6)
            assert np.abs(np.exp(1j * curve[-1, 2]) - np.exp(1j * b[2])) < 1e-6
