from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra import Multivector
from ..algebra._format import vector
from ..errors import InputError
from ._build import EPS, blade_of, cross, length, refuse, unit, vectors
from ._circle import round_parameters
from ._entity import Entity
from ._line import Line
from ._sphere import Sphere, radius_text, real_root


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class PointPair(Entity):
    """Two points c - r u and c + r u, a ^ b in this order [Humanoid, Table I].

    `array` (..., 7) = (center c, unit direction u from first to second, radius^2), imaginary if negative.
    Direction 0 and radius^2 -inf is a meet without points anywhere, as of a circle and a parallel plane.
    """

    SIZE: ClassVar[int] = 7

    def _check(self) -> None:
        refuse(np.abs(length(self.array[..., 3:6]) - 1.0) > 8 * EPS, "expected a unit direction", "PointPair.array",
               "use PointPair.from_points")  # fmt: skip

    @classmethod
    def from_points(cls, a: ArrayLike, b: ArrayLike) -> Self:
        """From two points (..., 3). Raises InputError when they coincide."""
        p, q = vectors((a, "a"), (b, "b"))
        half = 0.5 * (q - p)
        u = unit(half, "b - a", "a PointPair needs two different points")
        return cls._wrap(np.concatenate([p + half, u, length(half)[..., None] ** 2], axis=-1))

    @property
    def points(self) -> NDArray[np.float64]:
        """Both points (..., 2, 3), first and second; NaN where not real."""
        step = np.asarray(self.radius)[..., None] * self.array[..., 3:6]
        center = self.array[..., :3]
        return np.stack([center - step, center + step], axis=-2)

    @property
    def center(self) -> NDArray[np.float64]:
        """The point midway (..., 3)."""
        return self.array[..., :3].copy()

    @property
    def direction(self) -> NDArray[np.float64]:
        """Unit direction (..., 3) from the first point to the second."""
        return self.array[..., 3:6].copy()

    @property
    def radius_squared(self) -> NDArray[np.float64]:
        """Square of half the distance of the points (...); negative where imaginary."""
        return self.array[..., 6].copy()

    @property
    def radius(self) -> NDArray[np.float64]:
        """Half the distance of the points (...), metres; NaN where not real."""
        return real_root(self.array[..., 6])

    @property
    def is_real(self) -> NDArray[np.bool_]:
        return self.array[..., 6] >= 0.0

    @property
    def line(self) -> Line:
        """The line through both points, first to second."""
        return Line._of(self.center, self.direction)

    @property
    def sphere(self) -> Sphere:
        """The smallest sphere through both points."""
        return Sphere._wrap(self.array[..., [0, 1, 2, 6]])

    def as_opns(self) -> Multivector:
        """a ^ b / |a - b|, also for imaginary pairs; the zero blade where there are no points anywhere."""
        c, u = self.array[..., :3], self.array[..., 3:6]
        r2 = np.where(np.isneginf(self.array[..., 6:7]), 0.0, self.array[..., 6:7])
        along = np.sum(c * u, axis=-1, keepdims=True)
        half = 0.5 * (np.sum(c * c, axis=-1, keepdims=True) + r2)
        moment, infinity = cross(c, u), along * c - half * u
        return Multivector.from_null(
            e10=-u[..., 0], e20=-u[..., 1], e30=-u[..., 2], e0i=along[..., 0],
            e23=moment[..., 0], e13=-moment[..., 1], e12=moment[..., 2],
            e1i=infinity[..., 0], e2i=infinity[..., 1], e3i=infinity[..., 2],
        )  # fmt: skip

    def as_ipns(self) -> Multivector:
        return self.as_opns().undual()

    @classmethod
    def from_ipns(cls, blade: Multivector) -> Self:
        blade = blade_of(blade, 3, "PointPair")
        return cls._wrap(round_parameters(blade.dual(), cls))

    @classmethod
    def from_opns(cls, blade: Multivector) -> Self:
        if not isinstance(blade, Multivector):
            raise InputError(f"expected a Multivector, got {type(blade).__name__}", place="blade")
        return cls.from_ipns(blade.undual())

    def _text(self) -> str:
        if self.array[6] >= 0.0:
            a, b = self.points
            return f"{vector(a)}, {vector(b)}"
        return f"center={vector(self.array[:3])}, direction={vector(self.array[3:6])}, {radius_text(self.array[6])}"
