"""The fastest timing of a path: TOPP-RA (the library toppra) under velocity and acceleration limits, then jerk where it is limited."""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..scenes import Trajectory
from ._timing import _hermite, _spline_slopes

Floats = NDArray[np.float64]

_GRID = 200  # grid points at least
_MOST = 4000
_WINDOWS = 12  # tried for the jerk, each 0.7 times the one before


@dataclass(frozen=True, slots=True)
class Profile:
    """Motion along a path: s, its speed and time at grid points, constant acceleration between them, at rest outside.

    `window` > 0: the average of that motion over the last `window` seconds, which has a bounded jerk.
    """

    s: Floats
    speed: Floats
    time: Floats
    window: float = 0.0

    @property
    def duration(self) -> float:
        return float(self.time[-1]) + self.window

    def raw(self, t: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Integral of s - s[0], s, ds/dt, d2s/dt2 at times t, without the average."""
        k = np.clip(np.searchsorted(self.time, t, side="right") - 1, 0, len(self.time) - 2)
        steps = np.diff(self.time)
        push = np.diff(self.speed) / steps
        way = self.s - self.s[0]
        area = np.concatenate([[0.0], np.cumsum(steps * (way[:-1] + steps * (self.speed[:-1] / 2 + push * steps / 6)))])
        left = np.clip(t - self.time[k], 0.0, steps[k])
        v, a = self.speed[k], push[k]
        late = np.maximum(t - self.time[-1], 0.0)
        inside = (t >= 0.0) & (late == 0.0)
        return (
            np.where(t < 0.0, 0.0, area[k] + left * (way[k] + left * (v / 2 + a * left / 6)) + late * way[-1]),
            np.where(t < 0.0, 0.0, way[k] + left * (v + a * left / 2)) + self.s[0],
            np.where(inside, v + a * left, 0.0),
            np.where(inside, a, 0.0),
        )

    def at(self, t: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """s and its first three derivatives by time; the third is only known with a window (0 else)."""
        now = self.raw(t)
        if self.window == 0.0:
            return now[1], now[2], now[3], np.zeros_like(t)
        before = self.raw(t - self.window)
        s, v, a, j = ((x - y) / self.window for x, y in zip(now, before))
        return np.clip(s + self.s[0], self.s[0], self.s[-1]), v, a, j

    def samples(self) -> Floats:
        """Times at which limits are looked at: within every stretch of constant acceleration, and at both its ends."""
        breaks = self.time if self.window == 0.0 else np.concatenate([self.time, self.time + self.window])
        breaks = np.unique(breaks)
        return np.concatenate([breaks[:-1] + f * np.diff(breaks) for f in (1e-9, 0.25, 0.5, 0.75, 1.0 - 1e-9)])


def time_optimal_path(
    waypoints: Floats,
    velocity: Floats,
    acceleration: Floats,
    time_step: float,
    names: tuple[str, ...] = (),
    jerk: Floats | None = None,
) -> Trajectory:
    """The same spline through the waypoints (k, n) as `timed_path`, as fast as the limits (n,) allow, at rest at both ends.

    TOPP-RA gives the speed along the spline at grid points. With `jerk` (n,) that motion is averaged over a window in time, which
    bounds its jerk by twice its acceleration over the window; of several windows the shortest motion is taken. Last, time is
    stretched by what the limits are exceeded between the grid points. Where TOPP-RA finds no timing, a trapezoid is stretched.
    """
    keep = np.concatenate([[True], np.abs(np.diff(waypoints, axis=0)).max(axis=1, initial=0.0) > 1e-12])
    knots = waypoints[keep]
    if len(knots) == 1:
        return Trajectory(np.zeros(1), knots, np.zeros_like(knots), np.zeros_like(knots), names)
    s = np.concatenate([[0.0], np.cumsum(np.max(np.abs(np.diff(knots, axis=0)) / velocity, axis=1))])
    spline = (s, knots, _spline_slopes(s, knots))
    fastest = _fastest(spline, velocity, acceleration) or _trapezoid(s)
    profiles = [fastest]
    if jerk is not None:
        longest = fastest.duration / 2.0
        profiles = [Profile(fastest.s, fastest.speed, fastest.time, longest * 0.7**k) for k in range(_WINDOWS)]
    stretches = [_stretch(spline, profile, velocity, acceleration, jerk) for profile in profiles]
    best = int(np.argmin([stretch * profile.duration for stretch, profile in zip(stretches, profiles)]))
    profile, stretch = profiles[best], stretches[best]
    count = max(2, int(np.ceil(profile.duration * stretch / time_step)) + 1)
    t = np.linspace(0.0, profile.duration, count)
    q, dq, ddq, _ = _joints(spline, profile, t)
    q[0], q[-1], dq[0], dq[-1] = knots[0], knots[-1], 0.0, 0.0
    return Trajectory(t * stretch, q, dq / stretch, ddq / stretch**2, names)


def _fastest(spline: tuple[Floats, Floats, Floats], velocity: Floats, acceleration: Floats) -> Profile | None:
    logging.getLogger("toppra").setLevel(logging.ERROR)
    from toppra import algorithm, constraint
    from toppra.interpolator import AbstractGeometricPath

    s, knots, _ = spline

    class Path(AbstractGeometricPath):
        """Our spline, as toppra wants it."""

        def __call__(self, path_positions, order=0):
            values = _hermite(*spline, np.atleast_1d(np.asarray(path_positions, dtype=np.float64)))[order]
            return values if np.ndim(path_positions) else values[0]

        @property
        def dof(self):
            return knots.shape[1]

        @property
        def path_interval(self):
            return np.array([s[0], s[-1]])

        @property
        def waypoints(self):
            return s, knots

    # short segments need no more points than their share; where there are many waypoints, two a segment
    parts = np.clip(np.ceil(np.diff(s) / s[-1] * _GRID), 2, max(2, _MOST // len(s))).astype(int)
    grid = [np.linspace(a, b, m, endpoint=False) for a, b, m in zip(s[:-1], s[1:], parts)]
    limits = [
        constraint.JointVelocityConstraint(np.column_stack([-velocity, velocity])),
        constraint.JointAccelerationConstraint(
            np.column_stack([-acceleration, acceleration]), constraint.DiscretizationType.Interpolation
        ),
    ]
    solver = algorithm.TOPPRA(limits, Path(), gridpoints=np.concatenate([*grid, s[-1:]]), solver_wrapper="seidel")
    speed = solver.compute_parameterization(0.0, 0.0)[1]
    at = np.concatenate([*grid, s[-1:]])
    if speed is None or not np.isfinite(speed).all() or (speed[1:-1] <= 0.0).any():
        return None
    speed = np.maximum(speed, 0.0)
    return Profile(at, speed, np.concatenate([[0.0], np.cumsum(2.0 * np.diff(at) / (speed[1:] + speed[:-1]))]))


def _trapezoid(s: Floats) -> Profile:
    """A fifth of the way to get up speed, a fifth to stop; the stretch makes it keep the limits."""
    at = np.unique(np.concatenate([s, np.linspace(0.0, s[-1], 2 * _GRID + 1)]))
    speed = np.sqrt(np.minimum(1.0, np.minimum(at, s[-1] - at) / (0.2 * s[-1])))
    return Profile(at, speed, np.concatenate([[0.0], np.cumsum(2.0 * np.diff(at) / (speed[1:] + speed[:-1]))]))


def _joints(spline, profile: Profile, t: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Joints (k, n) and their first three derivatives by time."""
    at, *rates = profile.at(t)
    v, a, j = (rate[:, None] for rate in rates)
    q, first, second = _hermite(spline[0], spline[1], spline[2], at)
    third = _third(spline, at)
    return (
        q,
        first * v,
        second * v**2 + first * a,
        third * v**3 + 3.0 * second * v * a + first * j,
    )


def _third(spline, at: Floats) -> Floats:
    """Third derivative of the spline: constant between its knots."""
    s, knots, slopes = spline
    k = np.clip(np.searchsorted(s, at, side="right") - 1, 0, len(s) - 2)
    h = np.diff(s)[:, None]
    cubic = (2.0 * (knots[:-1] - knots[1:]) + (slopes[:-1] + slopes[1:]) * h) * 6.0 / h**3
    return cubic[k]


def _stretch(spline, profile: Profile, velocity: Floats, acceleration: Floats, jerk: Floats | None) -> float:
    """By what time has to be stretched to keep the limits at the samples."""
    _, dq, ddq, dddq = _joints(spline, profile, profile.samples())
    needed = [(np.abs(dq) / velocity).max(), np.sqrt((np.abs(ddq) / acceleration).max())]
    if jerk is not None:
        needed.append(np.cbrt((np.abs(dddq) / jerk).max()))
    return float(max(needed)) * (1.0 + 1e-4)  # for what lies between the samples
