"""A motion at the rate of a controller, without leaving what was certified."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..robots import Robot
from ..scenes import Scene, Trajectory
from ._timing import motion_limits

if TYPE_CHECKING:
    from ..certify import Certificate

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Resampled:
    """A trajectory with one waypoint every 1 / rate seconds.

    `how`: "certified anew" (a smooth curve, with its own `certificate`) or "same path" (joint for joint the polyline of the
    original, so its certificate holds; velocities are steps), followed by the reason where a smooth one was asked for.
    `stretch`: new duration over old, at least 1.
    """

    trajectory: Trajectory
    how: str
    certificate: Certificate | None
    stretch: float


def resample(trajectory: Trajectory, rate: float, scene: Scene | None = None) -> Resampled:
    """The motion at `rate` (1/s), for a controller that goes straight from one waypoint to the next.

    A certificate covers the polyline of the waypoints, and plain interpolation at other times cuts its corners. So
    - without `scene` every old waypoint becomes a new one: each segment lasts the next whole number of periods. The path, and with
      it the certificate, is the old one; speeds only fall. Velocities are those of the polyline, in steps.
    - with `scene` a smooth curve is sampled, within the limits of velocity and acceleration (and jerk) that its options ask of
      a plan, and certified anew. Of two curves the shorter in time that is certified is taken: cubics through positions and
      velocities, in time stretched until they keep the limits, or, for waypoints evenly spaced in time, the uniform cubic
      B-spline that they control. That one never exceeds limits that the differences of the waypoints keep, is two steps longer,
      and passes within a sixth of their second differences of them; only this one keeps a limit of the jerk. If neither is
      certified, or the trajectory states no velocities, it is as without, and `how` says why.
    Raises InputError for a rate that is not positive.
    """
    if not (isinstance(rate, (int, float)) and math.isfinite(rate) and rate > 0.0):
        raise InputError(f"expected a rate > 0 in 1/s, got {rate!r}", place="rate")
    if not isinstance(trajectory, Trajectory):
        raise InputError(f"expected a Trajectory, got {type(trajectory).__name__}", place="trajectory")
    if scene is not None and not isinstance(scene, Scene):
        raise InputError(f"expected a Scene or None, got {type(scene).__name__}", place="scene")
    if len(trajectory) == 1:
        return Resampled(trajectory, "same path", None, 1.0)
    h, how = 1.0 / float(rate), "same path"
    if scene is not None:
        from ..certify import certify

        why = "the trajectory states no velocities"
        for smooth in _smooth(trajectory, h, scene):
            certificate = certify(scene, smooth)
            if certificate.certified:
                return Resampled(smooth, "certified anew", certificate, smooth.duration / trajectory.duration)
            why = f"a smooth curve is not certified ({certificate.reason})"
        how = f"same path: {why}"
    same = _same_path(trajectory, h)
    return Resampled(same, how, None, same.duration / trajectory.duration)


def _same_path(trajectory: Trajectory, h: float) -> Trajectory:
    counts = np.maximum(np.ceil(np.diff(trajectory.time) / h - 1e-6), 1.0).astype(int)
    q = trajectory.positions
    rows = [q[:1]]
    for a, b, m in zip(q[:-1], q[1:], counts):
        share = np.arange(1, m + 1)[:, None] / m
        rows.append((1.0 - share) * a + share * b)
    positions = np.concatenate(rows)
    time = trajectory.time[0] + h * np.arange(len(positions))
    velocities = np.concatenate([np.diff(positions, axis=0) / h, np.zeros_like(q[:1])])
    return Trajectory(time, positions, velocities, None, trajectory.names)


def _smooth(trajectory: Trajectory, h: float, scene: Scene) -> list[Trajectory]:
    """Smooth curves with a waypoint every h seconds, the shortest in time first."""
    if trajectory.velocities is None or not trajectory.is_timed:
        return []
    limits = _limits(trajectory, scene)
    steps = np.diff(trajectory.time)
    curves = [_spline(trajectory, h, limits)] if np.ptp(steps) < 1e-6 * steps.mean() else []
    if not curves or scene.options.jerk is None:
        curves.append(_cubics(trajectory, h, limits))
    return sorted(curves, key=lambda curve: curve.duration)


def _limits(trajectory: Trajectory, scene: Scene) -> tuple[Floats, Floats, Floats]:
    """Limits (n,) of velocity, acceleration and jerk that a plan keeps, in the trajectory's order of joints; infinite but for arms."""
    n = trajectory.positions.shape[1]
    robot, jerk = scene.robot, np.full(n, scene.options.jerk or np.inf)
    if not isinstance(robot, Robot) or robot.n_joints != n:
        return np.full(n, np.inf), np.full(n, np.inf), jerk
    velocity, acceleration, _ = motion_limits(robot, scene.options)
    order = list(range(n))
    if sorted(trajectory.names) == sorted(robot.joint_names):
        order = [robot.joint_names.index(name) for name in trajectory.names]
    return velocity[order], acceleration[order], jerk


def _cubics(trajectory: Trajectory, h: float, limits: tuple[Floats, Floats, Floats]) -> Trajectory:
    """Cubics through positions and velocities; their acceleration jumps at the waypoints: no limit of the jerk is kept."""
    t, q, v = trajectory.time, trajectory.positions, trajectory.velocities
    assert v is not None
    steps = np.diff(t)[:, None]
    a, b, m, n = q[:-1], q[1:], v[:-1] * steps, v[1:] * steps
    cubic, square = 2.0 * (a - b) + m + n, 3.0 * (b - a) - 2.0 * m - n
    # control points of the first two derivatives bound them
    first = np.concatenate([v, (m + square) / steps])
    second = np.concatenate([square / steps**2, (square + 3.0 * cubic) / steps**2]) * 2.0
    at, stretch = _moments(trajectory.duration, h, _needed(limits, first, second))
    k = np.clip(np.searchsorted(t, t[0] + at, side="right") - 1, 0, len(t) - 2)
    a, m, square, cubic, span = a[k], m[k], square[k], cubic[k], steps[k]
    u = (t[0] + at - t[k])[:, None] / span
    positions = a + u * (m + u * (square + u * cubic))
    velocities = (m + u * (2.0 * square + 3.0 * u * cubic)) / span
    accelerations = (2.0 * square + 6.0 * u * cubic) / span**2
    return _sampled(trajectory, h, stretch, positions, velocities, accelerations)


def _spline(trajectory: Trajectory, h: float, limits: tuple[Floats, Floats, Floats]) -> Trajectory:
    """The uniform cubic B-spline with the waypoints as control points, the first and the last three times: at rest there.

    Its derivatives are means of the differences of the control points.
    """
    q, step = trajectory.positions, trajectory.duration / (len(trajectory) - 1)
    points = np.concatenate([q[:1], q[:1], q, q[-1:], q[-1:]])
    first, second, third = (np.diff(points, n=n, axis=0) / step**n for n in (1, 2, 3))
    at, stretch = _moments((len(q) + 1) * step, h, _needed(limits, first, second, third))
    k = np.clip((at / step).astype(int), 0, len(q))
    u = (at / step - k)[:, None]
    weights = ((1.0 - u) ** 3, 4.0 - 6.0 * u**2 + 3.0 * u**3, 1.0 + 3.0 * u + 3.0 * u**2 - 3.0 * u**3, u**3)
    positions = np.sum([weight * points[k + i] for i, weight in enumerate(weights)], axis=0) / 6.0
    rates = ((1.0 - u) ** 2 * first[k] + (1.0 + 2.0 * u - 2.0 * u**2) * first[k + 1] + u**2 * first[k + 2]) / 2.0
    pushes = (1.0 - u) * second[k] + u * second[k + 1]
    return _sampled(trajectory, h, stretch, positions, rates, pushes)


def _needed(limits: tuple[Floats, Floats, Floats], *derivatives: Floats) -> float:
    """By what time has to be stretched until derivatives (k, n), the first, the second, ... by time, keep their limits."""
    most = [(np.abs(d) / limit).max() ** (1.0 / n) for n, (d, limit) in enumerate(zip(derivatives, limits), start=1)]
    return max(1.0, *map(float, most))


def _moments(duration: float, h: float, needed: float) -> tuple[Floats, float]:
    """Times at which the curve is sampled, from 0 to `duration`, and the stretch, which makes them whole periods h."""
    count = max(1, math.ceil(duration * needed / h - 1e-9))
    return np.linspace(0.0, duration, count + 1), count * h / duration


def _sampled(old: Trajectory, h: float, stretch: float, q: Floats, dq: Floats, ddq: Floats) -> Trajectory:
    q[0], q[-1] = old.positions[0], old.positions[-1]
    return Trajectory(old.time[0] + h * np.arange(len(q)), q, dq / stretch, ddq / stretch**2, old.names)
