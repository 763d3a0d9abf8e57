"""From waypoints to a timed trajectory: a cubic spline in joint space, run through at a trapezoidal speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, unknown_name
from ..robots import Robot
from ..scenes import Options, Trajectory

Floats = NDArray[np.float64]

# Where a robot states no limit: a careful speed, and the acceleration that reaches full speed in a quarter of a second.
DEFAULT_VELOCITY = 1.0
DEFAULT_RISE_TIME = 0.25
TIMINGS = ("smooth", "time-optimal")


def motion_limits(robot: Robot, options: Options) -> tuple[Floats, Floats, tuple[str, ...]]:
    """Velocity and acceleration limits (n,) that a plan keeps, and a note for each kind that the robot does not state."""
    if options.timing not in TIMINGS:
        raise unknown_name("timing", options.timing, TIMINGS)
    if options.jerk is not None and options.timing != "time-optimal":
        raise InputError("a jerk limit needs timing: time-optimal", place="options.jerk")
    velocity, acceleration = robot.limits.velocity.copy(), robot.limits.acceleration.copy()
    notes = []
    if not np.isfinite(velocity).all():
        notes.append(f"no velocity limit stated for some joints: {DEFAULT_VELOCITY:g} rad/s or m/s used")
        velocity[~np.isfinite(velocity)] = DEFAULT_VELOCITY
    if not np.isfinite(acceleration).all():
        notes.append(f"no acceleration limits stated: full speed is reached in {DEFAULT_RISE_TIME:g} s")
        missing = ~np.isfinite(acceleration)
        acceleration[missing] = velocity[missing] / DEFAULT_RISE_TIME
    return velocity * options.velocity_scale, acceleration * options.acceleration_scale, tuple(notes)


def timed(robot: Robot, waypoints: Floats, options: Options) -> Trajectory:
    """Waypoints (k, n) as a trajectory sampled every `options.time_step`, at rest at both ends.

    With the spline q(s) and the speed v = ds/dt <= V, |dv/dt| <= A, joint speeds are |q'| V and joint accelerations at
    most |q'| A + |q''| V^2; V and A are the largest that keep every limit with half of the acceleration for each term.
    With `options.timing` time-optimal the same spline is run through as fast as TOPP-RA allows.
    """
    velocity, acceleration, _ = motion_limits(robot, options)
    jerk = None if options.jerk is None else np.full(robot.n_joints, options.jerk)
    return timed_path(waypoints, velocity, acceleration, options.time_step, robot.joint_names, options.timing, jerk)


def timed_path(
    waypoints: Floats,
    velocity: Floats,
    acceleration: Floats,
    time_step: float,
    names: tuple[str, ...],
    timing: str = "smooth",
    jerk: Floats | None = None,
) -> Trajectory:
    """As `timed`, for any coordinates with limits `velocity`, `acceleration` and, if time-optimal, `jerk` (n,)."""
    if timing == "time-optimal":
        from ._time_optimal import time_optimal_path

        return time_optimal_path(waypoints, velocity, acceleration, time_step, names, jerk)
    keep = np.concatenate([[True], np.abs(np.diff(waypoints, axis=0)).max(axis=1, initial=0.0) > 1e-12])
    knots = waypoints[keep]
    if len(knots) == 1:
        return Trajectory(np.zeros(1), knots, np.zeros_like(knots), np.zeros_like(knots), names)
    # Distance along the path in units of the time that the fastest joint would need: the spline's parameter.
    spans = np.max(np.abs(np.diff(knots, axis=0)) / velocity, axis=1)
    s = np.concatenate([[0.0], np.cumsum(spans)])
    slopes = _spline_slopes(s, knots)
    fine = np.unique(np.concatenate([s, *(s[:-1] + f * spans for f in np.arange(1, 8) / 8)]))
    _, first, second = _hermite(s, knots, slopes, fine)
    tiny = 1e-300
    top_speed = min(
        (velocity / (np.abs(first) + tiny)).min(), np.sqrt((0.5 * acceleration / (np.abs(second) + tiny)).min())
    )
    rise = (0.5 * acceleration / (np.abs(first) + tiny)).min()
    peak = min(top_speed, np.sqrt(rise * s[-1]))  # a short path never reaches the top speed
    ramp = peak / rise
    duration = ramp + s[-1] / peak
    count = max(2, int(np.ceil(duration / time_step)) + 1)
    t = np.linspace(0.0, duration, count)
    left = np.minimum(t, ramp)
    right = np.minimum(duration - t, ramp)
    position = np.where(
        t < ramp,
        0.5 * rise * left**2,
        np.where(t > duration - ramp, s[-1] - 0.5 * rise * right**2, peak * (t - 0.5 * ramp)),
    )
    speed = rise * np.minimum(left, right)
    push = np.where(t < ramp, rise, np.where(t > duration - ramp, -rise, 0.0))
    q, first, second = _hermite(s, knots, slopes, np.clip(position, 0.0, s[-1]))
    q[0], q[-1] = knots[0], knots[-1]
    dq = first * speed[:, None]
    ddq = second * speed[:, None] ** 2 + first * push[:, None]
    return Trajectory(t, q, dq, ddq, names)


def _spline_slopes(s: Floats, q: Floats) -> Floats:
    """First derivatives at the knots of the natural cubic spline through (s, q): a tridiagonal system."""
    k = len(s)
    h = np.diff(s)
    rise = np.diff(q, axis=0) / h[:, None]
    lower, diagonal, upper = np.zeros(k), np.zeros(k), np.zeros(k)
    right = np.zeros_like(q)
    diagonal[0], upper[0], right[0] = 2.0, 1.0, 3.0 * rise[0]
    diagonal[-1], lower[-1], right[-1] = 2.0, 1.0, 3.0 * rise[-1]
    lower[1:-1], upper[1:-1] = h[1:], h[:-1]
    diagonal[1:-1] = 2.0 * (h[1:] + h[:-1])
    right[1:-1] = 3.0 * (h[1:, None] * rise[:-1] + h[:-1, None] * rise[1:])
    for i in range(1, k):
        factor = lower[i] / diagonal[i - 1]
        diagonal[i] -= factor * upper[i - 1]
        right[i] -= factor * right[i - 1]
    slopes = np.empty_like(q)
    slopes[-1] = right[-1] / diagonal[-1]
    for i in range(k - 2, -1, -1):
        slopes[i] = (right[i] - upper[i] * slopes[i + 1]) / diagonal[i]
    return slopes


def _hermite(s: Floats, q: Floats, slopes: Floats, at: Floats) -> tuple[Floats, Floats, Floats]:
    """Value, first and second derivative at parameters `at` of the cubic with these values and slopes at the knots."""
    k = np.clip(np.searchsorted(s, at, side="right") - 1, 0, len(s) - 2)
    h = (s[k + 1] - s[k])[:, None]
    u = (at - s[k])[:, None] / h
    a, b, m, n = q[k], q[k + 1], slopes[k] * h, slopes[k + 1] * h
    cubic, square = 2.0 * (a - b) + m + n, 3.0 * (b - a) - 2.0 * m - n
    value = a + u * (m + u * (square + u * cubic))
    return value, (m + u * (2.0 * square + 3.0 * u * cubic)) / h, (2.0 * square + 6.0 * u * cubic) / h**2
