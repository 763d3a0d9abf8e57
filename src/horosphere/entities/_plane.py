from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra import Multivector
from ..algebra._format import number, vector
from ..numeric import float_array
from ._build import EPS, blade_of, cross, length, null_coefficients, refuse, together, triangle, unit, vectors
from ._entity import Entity


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Plane(Entity):
    """Plane n.x = d as n + d ei [Humanoid, eqs 6-7]; `array` (..., 4) over (e1, e2, e3, ei) = (unit n, d)."""

    SIZE: ClassVar[int] = 4

    def _check(self) -> None:
        refuse(np.abs(length(self.array[..., :3]) - 1.0) > 8 * EPS, "expected a unit normal", "Plane.array",
               "use Plane.from_normal_distance")  # fmt: skip

    @classmethod
    def from_normal_distance(cls, normal: ArrayLike, distance: ArrayLike) -> Self:
        """n.x = distance, metres along n = normal (..., 3) made unit. Raises InputError for a zero normal."""
        n, d = together(
            [*vectors((normal, "normal")), float_array(distance, "distance")[..., None]], ["normal", "distance"]
        )
        return cls._wrap(np.concatenate([unit(n, "normal", "give a direction that is not zero"), d], axis=-1))

    @classmethod
    def from_point_normal(cls, point: ArrayLike, normal: ArrayLike) -> Self:
        """Through a point (..., 3) with a normal (..., 3)."""
        p, n = vectors((point, "point"), (normal, "normal"))
        n = unit(n, "normal", "give a direction that is not zero")
        return cls._wrap(np.concatenate([n, np.sum(n * p, axis=-1, keepdims=True)], axis=-1))

    @classmethod
    def from_points(cls, a: ArrayLike, b: ArrayLike, c: ArrayLike) -> Self:
        """Through three points (..., 3), normal along (b - a) x (c - a). InputError when they are collinear."""
        p, q, r = triangle(*vectors((a, "a"), (b, "b"), (c, "c")), what="a Plane")
        return cls.from_point_normal(p, cross(q - p, r - p))

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normal (..., 3)."""
        return self.array[..., :3].copy()

    @property
    def distance(self) -> NDArray[np.float64]:
        """Signed distance (...) of the plane from the origin along the normal, metres."""
        return self.array[..., 3].copy()

    @property
    def point(self) -> NDArray[np.float64]:
        """The point (..., 3) nearest to the origin."""
        return self.array[..., :3] * self.array[..., 3:4]

    @property
    def is_real(self) -> NDArray[np.bool_]:
        return np.any(self.array[..., :3] != 0.0, axis=-1)

    def side_of(self, points: ArrayLike) -> NDArray[np.float64]:
        """Signed distance n.x - d (...) of points (..., 3), metres: positive on the side the normal points to."""
        x, n = vectors((points, "points"), (self.array[..., :3], "normal"))
        return np.sum(x * n, axis=-1) - self.array[..., 3]

    def project(self, points: ArrayLike) -> NDArray[np.float64]:
        """The nearest points (..., 3) of the plane."""
        x, n = vectors((points, "points"), (self.array[..., :3], "normal"))
        return x - self.side_of(points)[..., None] * n

    def as_ipns(self) -> Multivector:
        x = self.array
        return Multivector.from_null(e1=x[..., 0], e2=x[..., 1], e3=x[..., 2], ei=x[..., 3])

    @classmethod
    def from_ipns(cls, blade: Multivector) -> Self:
        x = null_coefficients(blade_of(blade, 1, "Plane"), "e1", "e2", "e3", "e0", "ei")
        refuse(np.abs(x[..., 3]) > 1e-12 * np.abs(x).max(-1), "this vector has an e0 part: no Plane", "blade",
               "use Sphere.from_ipns")  # fmt: skip
        weight = length(x[..., :3])
        refuse(weight == 0.0, "this vector has no normal: no Plane", "blade", "it is infinity")
        return cls.from_normal_distance(x[..., :3], x[..., 4] / weight)

    def _text(self) -> str:
        return f"normal={vector(self.array[:3])}, distance={number(self.array[3])}"
