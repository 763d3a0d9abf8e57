from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array, number
from ._sliding import SlidingMode
from ._speed import SpeedProfile

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PointMass:
    """The ball robot of [Rn] section 4: `radius` metres, the dynamics of a point x'' = u + w, |u| <= `max_acceleration`."""

    radius: float = 0.0
    max_acceleration: float = 4.0

    def __post_init__(self) -> None:
        number(self.radius, "radius", least=0.0)
        number(self.max_acceleration, "max_acceleration", above=0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """A simulated run: `time` (k,) s, `positions`, `velocities` (k, n), `inputs` (k, n) m/s^2 held from each time on.

    `errors` (k,) m/s are the sizes of v - v_d and `clearances` (k,) m the least values of the given clearance function in
    the periods that begin there; `reason` is "reached" or says what happened; `clearance` the least value along the whole run,
    `inflation` by how much the zones would have to be larger for it to stay above 0. What to grow zones by beforehand:
    `tracking_inflation`, for the `worst_error` within that growth.
    """

    time: Array
    positions: Array
    velocities: Array
    inputs: Array
    errors: Array
    clearances: Array
    reason: str
    clearance: float

    @property
    def reached(self) -> bool:
        return self.reason == "reached"

    @property
    def inflation(self) -> float:
        return max(0.0, -self.clearance)

    def rms_error(self, after: float = 0.0) -> float:
        """Root mean square of the velocity error from `after` seconds on, m/s."""
        late = self.errors[self.time >= after]
        return float(np.sqrt((late**2).mean())) if len(late) else 0.0

    def worst_error(self, nearer: float = np.inf) -> float:
        """The largest velocity error, m/s, at the ends of the periods with a clearance below `nearer` m; 0 where there were none."""
        near = self.clearances < nearer
        near[1:] |= near[:-1]
        return float(self.errors[near].max(initial=0.0))

    def total_variation(self) -> float:
        """Of the input, per second of the run: the measure of chattering, m/s^3."""
        moved = np.linalg.norm(np.diff(self.inputs, axis=0), axis=1).sum()
        return float(moved / max(self.time[-1] - self.time[0], 1e-300))


def track(
    direction: Callable[..., Array],
    start: ArrayLike,
    goal: ArrayLike,
    *,
    period: float = 0.01,
    law: SlidingMode | str = "implicit-unit-vector",
    speed: SpeedProfile | None = None,
    robot: PointMass | None = None,
    velocity: ArrayLike | None = None,
    disturbance: Callable[[float, Array], Array] | float = 0.0,
    clearance: Callable[[Array], Array] | None = None,
    grow_radius: float = 0.0,
    tolerance: float = 1e-2,
    duration: float = 60.0,
    substeps: int = 5,
) -> Track:
    """Simulate a ball that follows a field of unit directions by sliding-mode control, from rest unless `velocity` is given.

    `direction`(x) -> (n,); `period` s between control instants, the input being held in between and the plant integrated in
    `substeps` with the `disturbance`: a size in m/s^2 (turning slowly) or w(t, x) -> (n,). `clearance`(x (b, n)) -> (b,) m, of the
    centre, is recorded less the robot's radius. `grow_radius` > 0 is [Rn]'s second heuristic: direction(x, extra) is asked for
    zones grown by extra = grow_radius x the speed of approach (s times m/s). Reached: within `tolerance` m of the goal.
    Raises InputError for numbers out of range; what happens in the run is a value. Source: [Rn] 2.2; implicit law: docs/fields.md.
    """
    x = float_array(start, "start", ndim=1).copy()
    g = float_array(goal, "goal", ndim=1, last=len(x))
    v = np.zeros_like(x) if velocity is None else float_array(velocity, "velocity", ndim=1, last=len(x)).copy()
    robot = robot or PointMass()
    speed = speed or SpeedProfile(braking=0.4 * robot.max_acceleration, lateral=0.4 * robot.max_acceleration)
    law = SlidingMode(robot.max_acceleration, law) if isinstance(law, str) else law
    law.reset()
    for name, value in (("period", period), ("tolerance", tolerance), ("duration", duration), ("substeps", substeps)):
        if not value > 0.0:
            raise InputError(f"expected a number above 0, got {value:g}", place=name)
    wind = disturbance if callable(disturbance) else _slow_turn(float(disturbance), len(x))
    log: list[tuple[float, Array, Array, Array, float]] = []
    dense = [x]
    extra, t, reason = 0.0, 0.0, f"not reached within {duration:g} s"

    def wanted(y: Array) -> Array:
        toward = (lambda z: direction(z, extra)) if grow_radius else direction
        size, e = speed(y, g, toward)
        return size * e

    while t < duration:
        if np.linalg.norm(x - g) <= tolerance:
            reason = "reached"
            break
        if grow_radius and clearance is not None:
            extra = grow_radius * _approach(clearance, x, v)
        aim = wanted(x)
        error = v - (wanted(x + period * v) if law.looks_ahead else aim)
        u = law(error, period)
        u = u / max(1.0, float(np.linalg.norm(u)) / robot.max_acceleration)
        log.append((t, x, v, u, float(np.linalg.norm(v - aim))))
        h = period / substeps
        for k in range(substeps):
            a = u + wind(t + (k + 0.5) * h, x)
            x = x + h * v + 0.5 * h * h * a
            v = v + h * a
            dense.append(x)
        t += period
    log.append((t, x, v, np.zeros_like(x), float(np.linalg.norm(v - wanted(x)))))
    time, positions, velocities, inputs, errors = (np.array(column) for column in zip(*log))
    least = np.full(len(time), np.inf)
    if clearance is not None:
        along = np.asarray(clearance(np.array(dense)), dtype=np.float64) - robot.radius
        # of every period, both its ends included
        least[:-1] = np.minimum(
            along[:-1].reshape(-1, int(substeps)).min(axis=1), along[int(substeps) :: int(substeps)]
        )
        least[-1] = along[-1]
    return Track(time, positions, velocities, inputs, errors, least, reason, float(least.min()))


def _slow_turn(size: float, n: int) -> Callable[[float, Array], Array]:
    """A disturbance of constant size whose direction turns about once in four seconds."""

    def wind(t: float, _: Array) -> Array:
        w = np.zeros(n)
        w[0], w[1] = size * np.cos(1.5 * t), size * np.sin(1.5 * t)
        return w

    return wind


def _approach(clearance: Callable[[Array], Array], x: Array, v: Array) -> float:
    """How fast the clearance shrinks at x with velocity v, m/s, not below 0."""
    h = 1e-4
    here, there = clearance(np.stack([x, x + h * v]))
    return max(0.0, float(here - there) / h)


def tracking_inflation(radius: ArrayLike, distance: ArrayLike, speed: float | SpeedProfile, error: float) -> Array:
    """By how much (...) a zone of `radius` R must be grown so that a robot with velocity error up to `error` does not enter it.

    On the sphere of radius R inside the grown zone R + x the planar-log field of the grown zone still points outwards: x is the least
    growth with speed times outward share >= `error` all over that sphere, the speed in m/s constant or by a profile (which slows down
    where lines bend). `distance` D > R from the zone's centre to the goal; infinite where no growth short of the goal does. For a
    zone that is met alone; our derivation (docs/fields.md).
    """
    R, D = np.broadcast_arrays(float_array(radius, "radius"), float_array(distance, "distance"))
    if (R <= 0.0).any() or (D <= R).any():
        raise InputError("expected 0 < radius < distance", place="radius, distance")
    if not isinstance(speed, SpeedProfile):
        speed = number(speed, "speed", above=0.0)
    error = number(error, "error", least=0.0)
    result = np.empty(R.shape)
    for k in np.ndindex(R.shape):
        most = float(D[k] - R[k]) * (1.0 - 1e-9)
        low = high = 0.0

        def falls_short(growth: float, k=k) -> bool:
            return _outward_speed(float(R[k]), float(D[k]), growth, speed) < error

        if error > 0.0:
            ladder = np.geomspace(1e-9 * most, most, 40)
            high = next((float(growth) for growth in ladder if not falls_short(growth)), np.inf)
            low = 0.5 * high if high < np.inf else 0.0  # one rung of the ladder lower
        while high < np.inf and high - low > 1e-3 * high:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if falls_short(middle) else (low, middle)
        result[k] = high
    return result


def _outward_speed(R: float, D: float, growth: float, speed: float | SpeedProfile) -> float:
    """The least outward part of the velocity, m/s, on the sphere of radius R in the field of the zone R + growth."""
    # the angle from the antipode, near which the part is least: dense there
    off = np.concatenate([[0.0], np.geomspace(1e-6, np.pi, 1000 if not isinstance(speed, SpeedProfile) else 120)])
    center, q = np.array([D, 0.0]), (R + growth) / (R + growth + D)
    normal = np.stack([np.cos(off), np.sin(off)], axis=-1)
    x = center + R * normal

    def direction(z: Array) -> Array:
        y = z - center
        e = q * y / (y * y).sum(axis=-1, keepdims=True) - z / (z * z).sum(axis=-1, keepdims=True)
        return e / np.maximum(np.linalg.norm(e, axis=-1, keepdims=True), 1e-300)

    share = (direction(x) * normal).sum(axis=-1)
    if isinstance(speed, SpeedProfile):
        share = share * [speed(z, np.zeros(2), direction)[0] for z in x]
        return float(share.min())
    return float(share.min()) * speed
