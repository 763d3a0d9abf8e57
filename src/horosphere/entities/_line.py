from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra import Multivector
from ..algebra._format import vector
from ._build import EPS, blade_of, cross, length, null_coefficients, refuse, unit, vectors
from ._entity import Entity

_SIGNS = np.array([1.0, -1.0, 1.0])


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Line(Entity):
    """Directed line n I_e + m ei, m = p x n [Humanoid, eq 10, see the errata]; the axis of a rotation exp(-angle/2 L).

    `array` (..., 6) over (e12, e13, e23, e1i, e2i, e3i) = (n3, -n2, n1, m1, m2, m3), the layout of motor logarithms.
    Direction 0 is the meet of parallel planes: not real, its moment is the gap n1 d2 - n2 d1.
    """

    SIZE: ClassVar[int] = 6

    def _check(self) -> None:
        n, m = self.direction, self.moment
        size = length(n)
        bad = (np.abs(size - 1.0) > 8 * EPS) & (size != 0.0)
        bad |= np.abs(np.sum(n * m, axis=-1)) > 1e-9 * np.maximum(length(m), 1.0) * size
        refuse(bad, "expected a unit direction and a moment at right angles to it", "Line.array",
               "use Line.from_point_direction")  # fmt: skip

    @classmethod
    def from_points(cls, a: ArrayLike, b: ArrayLike) -> Self:
        """From a to b (..., 3): a ^ b ^ ei. Raises InputError when they coincide."""
        p, q = vectors((a, "a"), (b, "b"))
        return cls._of(p, unit(q - p, "b - a", "a Line needs two different points"))

    @classmethod
    def from_point_direction(cls, point: ArrayLike, direction: ArrayLike) -> Self:
        """Through a point (..., 3) along a direction (..., 3), made unit. Raises InputError when that is zero."""
        p, n = vectors((point, "point"), (direction, "direction"))
        return cls._of(p, unit(n, "direction", "give a direction that is not zero"))

    @classmethod
    def _of(cls, point: NDArray[np.float64], n: NDArray[np.float64]) -> Self:
        return cls._wrap(np.concatenate([n[..., ::-1] * _SIGNS, cross(point, n)], axis=-1))

    @property
    def direction(self) -> NDArray[np.float64]:
        """Unit direction n (..., 3)."""
        return self.array[..., 2::-1] * _SIGNS

    @property
    def moment(self) -> NDArray[np.float64]:
        """Moment m = p x n (..., 3), metres, of any of its points p."""
        return self.array[..., 3:].copy()

    @property
    def point(self) -> NDArray[np.float64]:
        """The point n x m (..., 3) nearest to the origin."""
        return cross(self.direction, self.moment)

    @property
    def is_real(self) -> NDArray[np.bool_]:
        return np.any(self.array[..., :3] != 0.0, axis=-1)

    def project(self, points: ArrayLike) -> NDArray[np.float64]:
        """The nearest points (..., 3) of the line."""
        x, n, foot = vectors((points, "points"), (self.direction, "direction"), (self.point, "point"))
        return foot + np.sum((x - foot) * n, axis=-1, keepdims=True) * n

    def as_ipns(self) -> Multivector:
        x = np.moveaxis(self.array, -1, 0)
        return Multivector.from_null(e12=x[0], e13=x[1], e23=x[2], e1i=x[3], e2i=x[4], e3i=x[5])

    @classmethod
    def from_ipns(cls, blade: Multivector) -> Self:
        x = null_coefficients(blade_of(blade, 2, "Line"), "e12", "e13", "e23", "e1i", "e2i", "e3i")
        rest = null_coefficients(blade, "e10", "e20", "e30", "e0i")
        n, m = x[..., 2::-1] * _SIGNS, x[..., 3:]
        weight = length(n)
        size = np.maximum(weight, length(m))
        bad = (weight <= 1e-14 * size) | (np.abs(rest).max(-1) > 1e-9 * size)
        bad |= np.abs(np.sum(n * m, axis=-1)) > 1e-9 * size * weight
        refuse(bad, "this blade is no Line", "blade", "a Line is n I_e + m ei with n.m = 0")
        n, m = n / weight[..., None], m / weight[..., None]
        return cls._of(cross(n, m), n)

    def _text(self) -> str:
        if not self.is_real:
            return f"not real, gap={vector(self.moment)}"
        return f"point={vector(self.point)}, direction={vector(self.direction)}"
