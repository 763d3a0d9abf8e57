from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self, final

import numpy as np
from numpy.typing import NDArray

from ..algebra import Multivector
from ..entities import Plane
from ..entities._build import refuse
from ..errors import InputError
from . import _kernels as k
from ._motor import Motor
from ._versor import REFLECTIONS, Versor, apply, refuse_operand


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Reflector(Versor):
    """Reflection in a plane, x -> -pi x pi [Humanoid, section IV-1]; `array` (..., 4) that of its unit Plane.

    Places and directions are reflected as vectors; the points of a pair keep their order. Two reflectors make a Motor.
    """

    SIZE: ClassVar[int] = 4

    def _check(self) -> None:
        Plane(self.array)

    @classmethod
    def from_plane(cls, plane: Plane) -> Self:
        """The reflection in a plane. Raises InputError for anything else."""
        if not isinstance(plane, Plane):
            raise InputError(f"expected a Plane, got {type(plane).__name__}", place="plane",
                             remedy="use Plane.from_normal_distance")  # fmt: skip
        refuse(~np.asarray(plane.is_real), "expected a real plane", "plane", "its normal is zero")
        return cls._wrap(plane.array.copy())

    @property
    def plane(self) -> Plane:
        """The mirror."""
        return Plane._wrap(self.array.copy())

    def __matmul__(self, other: Any) -> Any:
        """Reflect an entity; with another Reflector the Motor of both, `other` first [Humanoid, eq 12]."""
        if type(other) is Reflector:
            return apply(k.reflector_product, self, other, Motor)
        kernel = REFLECTIONS.get(type(other))
        if kernel is None:
            raise refuse_operand(self, other)
        return apply(kernel, self, other, type(other))

    def __invert__(self) -> Self:
        """Itself: a reflection undoes itself."""
        return self

    def as_matrix(self) -> NDArray[np.float64]:
        """The matrices (..., 4, 4), determinant -1."""
        n, d = self.array[..., :3], self.array[..., 3:]
        out = np.zeros((*self.shape, 4, 4))
        out[..., :3, :3] = np.eye(3) - 2.0 * n[..., :, None] * n[..., None, :]
        out[..., :3, 3] = 2.0 * d * n
        out[..., 3, 3] = 1.0
        return out

    def as_multivector(self) -> Multivector:
        return self.plane.as_ipns()

    def _text(self) -> str:
        return self.plane._text()
