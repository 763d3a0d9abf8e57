"""Timed trajectories: derivatives by finite differences, limits, rest at both ends, the waypoints met."""

import numpy as np
import pytest

from horosphere import robots
from horosphere.planning._timing import _hermite, _spline_slopes, timed
from horosphere.scenes import Options


@pytest.mark.parametrize("seed", range(5))
def test_limits_are_kept_and_derivatives_are_right(seed):
    rng = np.random.default_rng(seed)
    robot = robots.load("panda")
    n = robot.n_joints
    middle = 0.5 * (robot.limits.lower + robot.limits.upper)
    waypoints = middle + np.cumsum(rng.normal(size=(12, n)) * 0.08, axis=0)
    path = timed(robot, waypoints, Options(time_step=0.002))
    assert (np.abs(path.velocities) <= robot.limits.velocity * (1 + 1e-9)).all()
    if np.isfinite(robot.limits.acceleration).all():
        assert (np.abs(path.accelerations) <= robot.limits.acceleration * (1 + 1e-9)).all()
    np.testing.assert_array_equal(path.positions[[0, -1]], waypoints[[0, -1]])
    np.testing.assert_allclose(path.velocities[[0, -1]], 0.0, atol=1e-9)
    h = path.time[1] - path.time[0]
    slope = (path.positions[2:] - path.positions[:-2]) / (2 * h)
    np.testing.assert_allclose(slope, path.velocities[1:-1], atol=0.02 * np.abs(path.velocities).max())
    for point in waypoints:  # the path goes through every waypoint, up to the sampling in time
        assert np.abs(path.positions - point).max(axis=1).min() <= np.abs(np.diff(path.positions, axis=0)).max()


def test_spline_is_twice_differentiable_and_natural():
    rng = np.random.default_rng(0)
    s, q = np.cumsum(rng.uniform(0.5, 2, 8)), rng.normal(size=(8, 3))
    slopes = _spline_slopes(s, q)
    inner, e = s[1:-1], 1e-9
    for order in (0, 1, 2):
        left, right = _hermite(s, q, slopes, inner - e)[order], _hermite(s, q, slopes, inner + e)[order]
        np.testing.assert_allclose(left, right, atol=1e-6)
    np.testing.assert_allclose(_hermite(s, q, slopes, s[[0, -1]])[2], 0.0, atol=1e-10)
    np.testing.assert_allclose(_hermite(s, q, slopes, s)[0], q, atol=1e-12)


def test_short_paths_never_reach_full_speed():
    robot = robots.load("panda")
    start = 0.5 * (robot.limits.lower + robot.limits.upper)
    path = timed(robot, np.stack([start, start + 1e-4]), Options())
    assert len(path) >= 2 and path.duration < 0.2
    assert len(timed(robot, np.stack([start, start]), Options())) == 1
