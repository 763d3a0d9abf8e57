from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra import Multivector
from ..algebra._format import number, vector
from ..entities._build import cross, length, refuse, together, unit, vectors
from ..numeric import float_array
from . import _kernels as k
from ._matrix import rotation
from ._motor import Motor
from ._versor import Versor, apply

_REVERSE = np.array([1.0, -1, -1, -1])


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Rotor(Versor):
    """Rotation about the origin, cos(angle/2) - sin(angle/2) n I_e; `array` (..., 4) over (1, e12, e13, e23)."""

    SIZE: ClassVar[int] = 4

    def _check(self) -> None:
        refuse(np.abs(length(self.array) - 1.0) > 1e-6, "expected a unit rotor", "Rotor.array",
               "use Rotor.from_axis_angle or from_quaternion")  # fmt: skip

    @classmethod
    def identity(cls, shape: tuple[int, ...] = ()) -> Self:
        """No rotation, as a batch of this shape."""
        return cls._wrap(np.broadcast_to(np.array([1.0, 0, 0, 0]), (*shape, 4)).copy())

    @classmethod
    def from_axis_angle(cls, axis: ArrayLike, angle: ArrayLike) -> Self:
        """Right-handed by `angle` (...), radians, about `axis` (..., 3), made unit. InputError for a zero axis."""
        n, a = together([*vectors((axis, "axis")), float_array(angle, "angle")[..., None]], ["axis", "angle"])
        n = unit(n, "axis", "give a direction that is not zero")
        return cls._of_quaternion(np.cos(0.5 * a), np.sin(0.5 * a) * n)

    @classmethod
    def exp(cls, rotation_vector: ArrayLike) -> Self:
        """From rotation vectors (..., 3), radians."""
        w = float_array(rotation_vector, "rotation_vector", last=3)
        return cls._wrap(np.array(k.motor_exp(np.concatenate([w, np.zeros_like(w)], axis=-1))[..., :4]))

    @classmethod
    def from_quaternion(cls, wxyz: ArrayLike) -> Self:
        """From quaternions (..., 4), scalar first, made unit. Raises InputError for zero."""
        q = unit(float_array(wxyz, "wxyz", last=4), "wxyz", "give a quaternion that is not zero")
        return cls._of_quaternion(q[..., :1], q[..., 1:])

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Self:
        """From rotation matrices (..., 3, 3); off by rounding (1e-6) is accepted. Raises InputError otherwise."""
        return cls._wrap(k.rotor_of_matrix(rotation(matrix, "matrix")))

    @classmethod
    def between(cls, a: ArrayLike, b: ArrayLike) -> Self:
        """The smallest rotation that turns direction a (..., 3) into b; any of them where they are opposite."""
        u, v = vectors((a, "a"), (b, "b"))
        u, v = unit(u, "a", "give a direction"), unit(v, "b", "give a direction")
        other = cross(u, np.eye(3)[np.argmin(np.abs(u), axis=-1)])
        half = u + v
        size = length(half)[..., None]
        half = np.where(size > 1e-8, half / np.maximum(size, 1e-8), unit(other, "a", ""))
        return cls._of_quaternion(np.sum(u * half, axis=-1, keepdims=True), cross(u, half))

    @classmethod
    def _of_quaternion(cls, w: NDArray[np.float64], xyz: NDArray[np.float64]) -> Self:
        return cls._wrap(np.concatenate([w, -xyz[..., 2:], xyz[..., 1:2], -xyz[..., :1]], axis=-1))

    def as_quaternion(self) -> NDArray[np.float64]:
        """(..., 4), scalar first."""
        return self.array[..., [0, 3, 2, 1]] * np.array([1.0, -1.0, 1.0, -1.0])

    def log(self) -> NDArray[np.float64]:
        """The rotation vector (..., 3), radians, of length in [0, pi]."""
        return self.as_motor().log()[..., :3]

    def as_axis_angle(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Unit axis (..., 3) and angle (...) in [0, pi]; the z-axis for no rotation."""
        w = self.log()
        angle = length(w)
        size = angle[..., None]
        return np.where(size > 0.0, w / np.where(size > 0.0, size, 1.0), np.array([0.0, 0.0, 1.0])), angle

    def as_matrix(self) -> NDArray[np.float64]:
        """Rigid transforms (..., 4, 4)."""
        return self.as_motor().as_matrix()

    def as_rotation_matrix(self) -> NDArray[np.float64]:
        """Rotation matrices (..., 3, 3)."""
        return self.as_matrix()[..., :3, :3].copy()

    def as_motor(self) -> Motor:
        """The same motion as a Motor."""
        return Motor._wrap(np.concatenate([self.array, np.zeros_like(self.array)], axis=-1))

    def as_multivector(self) -> Multivector:
        return self.as_motor().as_multivector()

    def __matmul__(self, other: Any) -> Any:
        """Compose with a versor (a Rotor gives a Rotor, others a Motor), or move an entity."""
        if type(other) is Rotor:
            return apply(k.rotor_product, self, other, Rotor)
        return self.as_motor() @ other

    def __invert__(self) -> Self:
        return self._wrap(self.array * _REVERSE)

    def __neg__(self) -> Self:
        """-R, the same rotation."""
        return self._wrap(-self.array)

    def _text(self) -> str:
        axis, angle = self.as_axis_angle()
        return f"axis={vector(axis)}, angle={number(float(angle))}"
