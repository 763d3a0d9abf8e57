from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array, number, wrap_angle
from ._speed import SpeedProfile

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Unicycle:
    """A disc that rolls forward at 0 <= v <= `max_speed` m/s, turns at |rate| <= `max_turn_rate` rad/s, speeds up at bounded rate."""

    radius: float = 0.0
    max_speed: float = 1.0
    max_turn_rate: float = 2.0
    max_acceleration: float = 4.0

    def __post_init__(self) -> None:
        for name in ("max_speed", "max_turn_rate", "max_acceleration"):
            number(getattr(self, name), name, above=0.0)
        number(self.radius, "radius", least=0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """A simulated drive: `time` (k,), `poses` (k, 3) x, y, heading, `speeds`, `turn_rates` (k,) held from each time on, `reason`."""

    time: Array
    poses: Array
    speeds: Array
    turn_rates: Array
    reason: str
    clearance: float

    @property
    def reached(self) -> bool:
        return self.reason == "reached"


def drive(
    direction: Callable[[Array], Array],
    start: ArrayLike,
    goal: ArrayLike,
    *,
    robot: Unicycle | None = None,
    room: Callable[[Array, Array], Array] | None = None,
    clearance: Callable[[Array], Array] | None = None,
    period: float = 0.02,
    keep: float = 0.5,
    tolerance: float = 1e-2,
    duration: float = 120.0,
) -> Drive:
    """Follow a planar field of directions with a unicycle from the pose `start` (x, y, heading) to the point `goal` (2,).

    Every period the heading turns towards the direction a step ahead, at most at the turn rate; the speed falls with the heading
    error and the curvature. `room`(x (b, 2), u (b, 2)) -> (b,) m, the straight way free of obstacles as `HarmonicField.room` gives
    it: the arc of a period is no longer than the fraction `keep` of the least room over *all* its headings, so that all of it
    stays free whatever the period (zones at convex distance; proof in docs/fields.md). Such a stop is not bounded by the
    acceleration. `clearance`(x (b, 2)) -> (b,) m, of the centre, is recorded less the robot's radius.
    """
    pose = float_array(start, "start", ndim=1, last=3).copy()
    g = float_array(goal, "goal", ndim=1, last=2)
    robot = robot or Unicycle()
    for name, value in (("period", period), ("keep", keep), ("tolerance", tolerance), ("duration", duration)):
        if not value > 0.0:
            raise InputError(f"expected a number above 0, got {value:g}", place=name)
    profile = SpeedProfile(robot.max_speed, 0.5 * robot.max_acceleration, 0.5 * robot.max_acceleration)
    x, heading, v, t = pose[:2], float(pose[2]), 0.0, 0.0
    log, dense = [], [x]
    reason = f"not reached within {duration:g} s"
    while t < duration:
        rest = float(np.linalg.norm(g - x))
        if rest <= tolerance:
            reason = "reached"
            break
        speed, e = profile(x, g, direction)
        ahead = direction(x + min(speed * period, 0.5 * rest) * e)
        bearing = np.arctan2(e[1], e[0])
        # aim where the field points ahead, unless it turns so much there that following it would mean standing still here
        aim = ahead if float(ahead @ e) > 0.8 else e
        if room is not None:
            aim = _freest(aim, x, room, speed * period)
        error = float(wrap_angle(np.arctan2(aim[1], aim[0]) - heading))
        rate = float(np.clip(error / period, -robot.max_turn_rate, robot.max_turn_rate))
        off = float(wrap_angle(bearing - (heading + 0.5 * rate * period)))
        bend = float(np.linalg.norm(ahead - e)) / max(speed * period, 1e-9)
        speed = min(speed, 0.8 * robot.max_turn_rate / max(bend, 1e-9))
        speed *= max(0.0, np.cos(off)) ** 2
        v = min(speed, v + robot.max_acceleration * period, rest * max(0.0, np.cos(off)) / period)
        if room is not None and v > 0.0:
            v = min(v, keep * _arc_room(room, x, heading, rate * period) / period)
        log.append((t, *x, heading, v, rate))
        for fraction in (0.25, 0.5, 0.75, 1.0):
            dense.append(x + _arc(heading, v, rate, fraction * period))
        x, heading, t = dense[-1], float(wrap_angle(heading + rate * period)), t + period
    log.append((t, *x, heading, 0.0, 0.0))
    table = np.array(log)
    least = np.inf if clearance is None else float(np.min(clearance(np.array(dense)))) - robot.radius
    return Drive(table[:, 0], table[:, 1:4], table[:, 4], table[:, 5], reason, least)


def _arc_room(room: Callable[[Array, Array], Array], x: Array, heading: float, turn: float) -> float:
    """A lower bound, in metres, of the room at `x` over all headings from `heading` through `turn` (at most half a turn).

    Along u(t) the room before zone i is d_i / c_i(t), c_i(t) = -n_i . u(t), a cosine of t. Between two samples f apart c_i is at most
    its larger end value, or, with its peak between them, that value / cos(f / 2): the nearer sample is within f / 2 of the peak.
    """
    samples = np.linspace(0.0, turn, 9)
    ways = np.stack([np.cos(heading + samples), np.sin(heading + samples)], axis=-1)
    return float(np.cos(0.5 * (samples[1] - samples[0])) * np.min(room(np.broadcast_to(x, ways.shape), ways)))


def _freest(aim: Array, x: Array, room: Callable[[Array, Array], Array], wanted: float) -> Array:
    """`aim` itself where there is room for the `wanted` metres along it, else the heading near it that gets furthest that way."""
    if float(room(x, aim)) >= wanted:
        return aim
    turns = np.deg2rad([0, 2, -2, 5, -5, 10, -10, 20, -20, 40, -40, 60, -60])
    c, s = np.cos(turns), np.sin(turns)
    ways = np.stack([c * aim[0] - s * aim[1], s * aim[0] + c * aim[1]], axis=-1)
    gains = np.minimum(room(np.broadcast_to(x, ways.shape), ways), wanted) * c
    return ways[int(np.argmax(gains))]


def _arc(heading: float, v: float, rate: float, h: float) -> Array:
    """Displacement of a unicycle after h seconds, exact."""
    half = 0.5 * rate * h
    chord = v * h * np.sinc(half / np.pi)
    return chord * np.array([np.cos(heading + half), np.sin(heading + half)])
