"""What every obstacle has: a name, checked read-only arrays, a signed distance, a bounding ball."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array, nearest_rotation

Floats = NDArray[np.float64]


class Shape(ABC):
    """A solid obstacle in world coordinates (metres)."""

    __slots__ = ("planner_rows",)
    name: str
    planner_rows: bytes
    """What the tree planner has made of it, once it has: a shape does not change."""

    @property
    def dimension(self) -> int:
        """Of the space the solid lives in."""
        return 3

    @abstractmethod
    def signed_distance(self, points: ArrayLike) -> Floats:
        """Distance (...,) of points (..., n) to the surface, metres; negative inside; exact unless the class says so."""

    @abstractmethod
    def bounding_ball(self) -> tuple[Floats, float]:
        """Centre (n,) and radius of a ball that holds the solid; the radius is infinite for a half-space."""


def private(value: ArrayLike, place: str, last: int | None = None, ndim: int = 1) -> Floats:
    """A checked, read-only copy."""
    array = np.array(float_array(value, place, last=last, ndim=ndim), dtype=np.float64, order="C")
    array.setflags(write=False)
    return array


def number(value: Any, place: str, *, positive: bool = False) -> float:
    """A finite float, at least zero (above zero if `positive`)."""
    x = float(private(value, place, ndim=0))
    if x < 0.0 or (positive and x == 0.0):
        raise InputError(f"expected a number {'>' if positive else '>='} 0, got {x:g}", place=place)
    return x


def rotation_matrix(value: ArrayLike | None, place: str) -> Floats:
    """A proper rotation (3, 3), given to 1e-9 and made one to rounding. None is the identity."""
    R = private(np.eye(3) if value is None else value, place, last=3, ndim=2)
    if R.shape != (3, 3):
        raise InputError(f"expected shape (3, 3), got {R.shape}", place=place)
    error = float(np.abs(R @ R.T - np.eye(3)).max())
    if error > 1e-9:
        raise InputError(
            f"not a rotation: R R^T differs from 1 by {error:.2g}", place=place, remedy="columns: the solid's axes"
        )
    if np.linalg.det(R) < 0.0:
        raise InputError("a reflection (determinant -1), not a rotation", place=place, remedy="flip one column")
    return private(nearest_rotation(R), place, last=3, ndim=2)


def points_of(value: ArrayLike, dimension: int) -> Floats:
    """The argument of `signed_distance`."""
    return float_array(value, "points", last=dimension)


def set_fields(shape: object, **values: Any) -> None:
    """Write fields of a frozen dataclass while it is made."""
    for name, value in values.items():
        object.__setattr__(shape, name, value)
