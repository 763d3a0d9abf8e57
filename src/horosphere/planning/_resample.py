"""A motion at the rate of a controller, without leaving what was certified."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..scenes import Scene, Trajectory

if TYPE_CHECKING:
    from ..certify import Certificate

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Resampled:
    """A trajectory with one waypoint every 1 / rate seconds.

    `how`: "same path" (joint for joint the polyline of the original, so its certificate holds) or "certified anew" (a smooth curve
    through its waypoints, with its own `certificate`). `stretch`: new duration over old, at least 1.
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
    - with `scene` cubics through positions and velocities are sampled instead, which is smooth, and the result is certified anew.
      If that fails, or the trajectory has no velocities, it is as without.
    Raises InputError for a rate that is not positive.
    """
    if not (isinstance(rate, (int, float)) and math.isfinite(rate) and rate > 0.0):
        raise InputError(f"expected a rate > 0 in 1/s, got {rate!r}", place="rate")
    if len(trajectory) == 1:
        return Resampled(trajectory, "same path", None, 1.0)
    h = 1.0 / float(rate)
    if scene is not None and trajectory.velocities is not None:
        from ..certify import certify

        smooth = _smooth(trajectory, h)
        certificate = certify(scene, smooth)
        if certificate.certified:
            return Resampled(smooth, "certified anew", certificate, smooth.duration / trajectory.duration)
    same = _same_path(trajectory, h)
    return Resampled(same, "same path", None, same.duration / trajectory.duration)


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


def _smooth(trajectory: Trajectory, h: float) -> Trajectory:
    """Cubics through positions and velocities, in time stretched to a whole number of periods."""
    t, q, v = trajectory.time, trajectory.positions, trajectory.velocities
    assert v is not None
    count = max(1, math.ceil(trajectory.duration / h - 1e-9))
    stretch = count * h / trajectory.duration
    at = np.clip(t[0] + np.arange(count + 1) * h / stretch, t[0], t[-1])
    k = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
    span = (t[k + 1] - t[k])[:, None]
    u = (at - t[k])[:, None] / span
    a, b, m, n = q[k], q[k + 1], v[k] * span, v[k + 1] * span
    cubic, square = 2.0 * (a - b) + m + n, 3.0 * (b - a) - 2.0 * m - n
    positions = a + u * (m + u * (square + u * cubic))
    positions[0], positions[-1] = q[0], q[-1]
    velocities = (m + u * (2.0 * square + 3.0 * u * cubic)) / span / stretch
    accelerations = (2.0 * square + 6.0 * u * cubic) / span**2 / stretch**2
    return Trajectory(t[0] + h * np.arange(count + 1), positions, velocities, accelerations, trajectory.names)
