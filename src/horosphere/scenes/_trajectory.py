"""A motion in joint space, sampled in time."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Waypoints of a motion; between two of them every joint moves linearly unless velocities say otherwise.

    Attributes: `time` (k,) s, strictly increasing; `positions` (k, n) rad or m; `velocities`, `accelerations` (k, n) or None;
    `names` (n,) joint names, possibly empty; `is_timed` False: nobody stated times, these stand for waypoint numbers.
    Raises InputError on shapes that do not agree, NaN, or time that does not increase.
    """

    time: Floats
    positions: Floats
    velocities: Floats | None = None
    accelerations: Floats | None = None
    names: tuple[str, ...] = ()
    is_timed: bool = True

    def __post_init__(self) -> None:
        positions = _read_only(self.positions, "positions")
        time = np.array(float_array(self.time, "time", ndim=1))
        time.setflags(write=False)
        if len(positions) == 0:
            raise InputError("expected at least one waypoint", place="positions")
        if len(time) != len(positions):
            raise InputError(f"{len(time)} times but {len(positions)} waypoints", place="time")
        stuck = np.flatnonzero(np.diff(time) <= 0.0)
        if len(stuck):
            k = int(stuck[0])
            raise InputError(f"time does not increase: {time[k]:g} then {time[k + 1]:g} at index {k + 1}", place="time")
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "positions", positions)
        for name in ("velocities", "accelerations"):
            if getattr(self, name) is not None:
                rates = _read_only(getattr(self, name), name)
                if rates.shape != positions.shape:
                    raise InputError(f"expected shape {positions.shape}, got {rates.shape}", place=name)
                object.__setattr__(self, name, rates)
        if isinstance(self.names, str) or not isinstance(self.names, Iterable):
            raise InputError(f"expected the joints' names, got {self.names!r:.60}", place="names")
        object.__setattr__(self, "names", tuple(str(name) for name in self.names))
        if self.names and len(self.names) != positions.shape[1]:
            raise InputError(f"{len(self.names)} names but {positions.shape[1]} joints", place="names")

    def __len__(self) -> int:
        return len(self.time)

    @property
    def duration(self) -> float:
        """Seconds from the first waypoint to the last."""
        return float(self.time[-1] - self.time[0])

    @property
    def max_step(self) -> float:
        """The largest change of any joint between neighbouring waypoints (0 for one waypoint)."""
        return float(np.abs(np.diff(self.positions, axis=0)).max(initial=0.0))

    def at(self, time: ArrayLike) -> Floats:
        """Positions (..., n) at `time` (...,), linear between waypoints, held before the first and after the last."""
        t = float_array(time, "time")
        k = np.clip(np.searchsorted(self.time, t, side="right") - 1, 0, max(len(self.time) - 2, 0))
        if len(self.time) == 1:
            return np.broadcast_to(self.positions[0], (*t.shape, self.positions.shape[1])).copy()
        s = np.clip((t - self.time[k]) / (self.time[k + 1] - self.time[k]), 0.0, 1.0)[..., None]
        return (1.0 - s) * self.positions[k] + s * self.positions[k + 1]


def _read_only(value: ArrayLike, name: str) -> Floats:
    array = np.array(float_array(value, name, ndim=2))
    array.setflags(write=False)
    return array
