from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A motion through the field.

    `points` (k, n) metres, first the start; `reason` is "reached" or says what happened; `length` and `clearance` (the least
    distance to a security zone along the straight segments, negative inside) in metres; `notes` says what was done on the way,
    such as a sideways step off the unstable ray.
    """

    points: NDArray[np.float64]
    reason: str
    length: float
    clearance: float
    notes: tuple[str, ...] = ()

    @property
    def reached(self) -> bool:
        return self.reason == "reached"

    def as_points(self) -> Any:
        """The points as conformal points `Point` (k, 5); paths of the plane lie in z = 0."""
        from ..entities import Point

        n = self.points.shape[1]
        if n > 3:
            from ..errors import InputError

            raise InputError(f"conformal points here are those of 3-D space, the path lies in R^{n}", place="points")
        return Point.from_euclidean(np.pad(self.points, ((0, 0), (0, 3 - n))))

    def __repr__(self) -> str:
        k, n = self.points.shape
        return f"Path({k} points in R^{n}, {self.reason!r}, length={self.length:.6g}, clearance={self.clearance:.6g})"
