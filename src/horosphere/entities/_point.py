from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra import Multivector
from ..algebra._format import vector
from ..numeric import float_array
from ._build import EPS, blade_of, null_coefficients, refuse
from ._entity import Entity


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Point(Entity):
    """Point x + e0 + x^2/2 ei; `array` (..., 5) over (e1, e2, e3, e0, ei), weight 1 [Humanoid, eq 3, see the errata].

    The meet of a parallel line and plane is (direction, 0, 0): weight 0, not real.
    """

    SIZE: ClassVar[int] = 5

    def _check(self) -> None:
        x, weight, last = self.array[..., :3], self.array[..., 3], self.array[..., 4]
        half = 0.5 * np.sum(x * x, axis=-1) * weight
        refuse(((weight != 1.0) & (weight != 0.0)) | (np.abs(last - half) > 8 * EPS * np.abs(half)),
               "expected coefficients (x, 1, x^2/2)", "Point.array", "use Point.from_euclidean(xyz)")  # fmt: skip

    @classmethod
    def from_euclidean(cls, xyz: ArrayLike) -> Self:
        """From coordinates (..., 3), metres. Raises InputError on other shapes and on NaN."""
        if type(xyz) is np.ndarray and xyz.shape == (3,) and xyz.dtype == np.float64:  # the single point, fast
            a, b, c = xyz.tolist()
            half = 0.5 * (a * a + b * b + c * c)
            if half < np.inf:
                return cls._wrap(np.array((a, b, c, 1.0, half)))
        x = float_array(xyz, "xyz", last=3)
        out = np.empty((*x.shape[:-1], 5))
        out[..., :3], out[..., 3], out[..., 4] = x, 1.0, 0.5 * np.sum(x * x, axis=-1)
        return cls._wrap(out)

    @classmethod
    def origin(cls) -> Self:
        """The origin e0."""
        return cls._wrap(np.array([0.0, 0.0, 0.0, 1.0, 0.0]))

    def as_euclidean(self) -> NDArray[np.float64]:
        """Coordinates (..., 3), metres; NaN where not real."""
        x = self.array[..., :3]
        real = self.array[..., 3:4]
        return x.copy() if real.all() else np.where(real != 0.0, x, np.nan)

    @property
    def is_real(self) -> NDArray[np.bool_]:
        return self.array[..., 3] != 0.0

    @property
    def direction(self) -> NDArray[np.float64]:
        """Where not real: the direction (..., 3) in which the line and the plane run along each other; else zero."""
        return np.where(self.array[..., 3:4] != 0.0, 0.0, self.array[..., :3])

    def as_ipns(self) -> Multivector:
        x = self.array
        return Multivector.from_null(
            e1=x[..., 0], e2=x[..., 1], e3=x[..., 2], e0=x[..., 3], ei=np.where(x[..., 3] != 0.0, x[..., 4], 0.0)
        )

    def as_opns(self) -> Multivector:
        """The point itself: x ^ x = 0."""
        return self.as_ipns()

    @classmethod
    def from_ipns(cls, blade: Multivector) -> Self:
        x = null_coefficients(blade_of(blade, 1, "Point"), "e1", "e2", "e3", "e0", "ei")
        weight = x[..., 3]
        euclidean = np.sum(x[..., :3] ** 2, axis=-1)
        refuse(weight == 0.0, "this vector has no e0 part: no Point", "blade", "it is a plane or infinity")
        square = euclidean - 2.0 * weight * x[..., 4]
        refuse(np.abs(square) > 1e-9 * (euclidean + weight**2 + np.abs(weight * x[..., 4])),
               "this vector is not null: no Point", "blade", "use Sphere.from_ipns")  # fmt: skip
        return cls.from_euclidean(x[..., :3] / weight[..., None])

    @classmethod
    def from_opns(cls, blade: Multivector) -> Self:
        return cls.from_ipns(blade)

    def __add__(self, offset: ArrayLike) -> Point:
        """The point moved by a vector (..., 3), metres."""
        return Point.from_euclidean(self.as_euclidean() + float_array(offset, "offset", last=3))

    def __sub__(self, other: Point | ArrayLike) -> Point | NDArray[np.float64]:
        """The vector (..., 3) from another point to this one, or the point moved back by a vector."""
        if isinstance(other, Point):
            return self.as_euclidean() - other.as_euclidean()
        return Point.from_euclidean(self.as_euclidean() - float_array(other, "offset", last=3))

    def _text(self) -> str:
        return vector(self.array[:3]) if self.array[3] else f"at infinity along {vector(self.array[:3])}"
