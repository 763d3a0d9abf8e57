from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra import Multivector
from ..algebra._format import vector
from ..entities import Line
from ..entities._build import cross, length, null_coefficients, refuse, together
from ..errors import InputError
from ..numeric import float_array
from . import _kernels as k
from ._matrix import rigid
from ._versor import ACTIONS, Versor, apply, refuse_operand

_REVERSE = np.array([1.0, -1, -1, -1, -1, -1, -1, 1])
_NAMES = ("s", "e12", "e13", "e23", "e1i", "e2i", "e3i", "e123i")


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Motor(Versor):
    """Rigid motion [Humanoid, eqs 16-18]; `array` (..., 8) over (1, e12, e13, e23, e1i, e2i, e3i, e123i).

    M and -M are the same motion. `M_world_tool` is the tool's pose in the world: `M_world_base @ M_base_tool`.
    """

    SIZE: ClassVar[int] = 8

    def _check(self) -> None:
        m = self.array
        norm = np.sum(m[..., :4] ** 2, axis=-1)
        study = m[..., 0] * m[..., 7] - m[..., 1] * m[..., 6] + m[..., 2] * m[..., 5] - m[..., 3] * m[..., 4]
        size = np.maximum(np.abs(m[..., 4:]).max(-1), 1.0)
        refuse((np.abs(norm - 1.0) > 1e-6) | (np.abs(study) > 1e-6 * size), "expected a unit motor", "Motor.array",
               "Motor.renormalised(array) makes one of nearby coefficients")  # fmt: skip

    # ---- construction
    @classmethod
    def identity(cls, shape: tuple[int, ...] = ()) -> Self:
        """The motion that leaves everything where it is, as a batch of this shape."""
        out = np.zeros((*shape, 8))
        out[..., 0] = 1.0
        return cls._wrap(out)

    @classmethod
    def exp(cls, screw: ArrayLike) -> Self:
        """From screws (..., 6) = (rotation vector w, radians; translation part v, metres): exp(-(w I_e + v ei)/2).

        Its matrix is expm [[ [w]x, v ], [0, 0]]. Exact to rounding for every angle. Our derivation.
        """
        motor = _EXP.call(screw)
        return cls._wrap(k.motor_exp(float_array(screw, "screw", last=6))) if motor is None else motor

    @classmethod
    def from_line_angle(cls, line: Line, angle: ArrayLike, advance: ArrayLike = 0.0) -> Self:
        """Turn by `angle` (...), radians, right-handed about a line, and move `advance` (...), metres, along it.

        (cos(angle/2) - sin(angle/2) L)(1 - advance/2 n ei) [Humanoid, eqs 16-17]. InputError for a line not real.
        """
        if not isinstance(line, Line):
            raise InputError(f"expected a Line, got {type(line).__name__}", place="line",
                             remedy="use Line.from_point_direction")  # fmt: skip
        refuse(~np.asarray(line.is_real), "expected a real line", "line", "parallel planes meet in none")
        angle, advance = float_array(angle, "angle"), float_array(advance, "advance")
        l, a, b = together([line.array, angle[..., None], advance[..., None]], ["line", "angle", "advance"])
        return cls._wrap(k.motor_of_line(l, a[..., 0], b[..., 0]))

    @classmethod
    def from_matrix(cls, T: ArrayLike) -> Self:
        """From rigid transforms (..., 4, 4); rotations off by rounding (1e-6) pass. Raises InputError otherwise."""
        return cls._wrap(k.motor_of_matrix(rigid(T, "T")))

    @classmethod
    def from_translation(cls, vector: ArrayLike) -> Self:
        """The pure translation by vectors (..., 3), metres."""
        t = float_array(vector, "vector", last=3)
        out = np.zeros((*t.shape[:-1], 8))
        out[..., 0], out[..., 4:7] = 1.0, -0.5 * t
        return cls._wrap(out)

    @classmethod
    def renormalised(cls, array: ArrayLike | Motor) -> Self:
        """The nearest unit motor M / sqrt(M ~M) of coefficients (..., 8). InputError when the rotation part is zero."""
        m = array.array if isinstance(array, Motor) else float_array(array, "array", last=8)
        refuse(~np.any(m[..., :4] != 0.0, axis=-1), "expected a rotation part that is not zero", "array",
               "a motor needs its first four coefficients")  # fmt: skip
        return cls._wrap(k.motor_renormalised(m))

    @classmethod
    def from_multivector(cls, value: Multivector) -> Self:
        """From a general element that is a unit motor. Raises InputError otherwise."""
        if not isinstance(value, Multivector):
            raise InputError(f"expected a Multivector, got {type(value).__name__}", place="value")
        rest = value.coefficients - cls._of_null(null_coefficients(value, *_NAMES)).coefficients
        refuse(np.abs(rest).max(-1) > 1e-9 * np.abs(value.coefficients).max(-1), "expected a motor", "value",
               "it has parts outside (1, e_jk, e_k ei, e123 ei)")  # fmt: skip
        return cls(null_coefficients(value, *_NAMES))

    # ---- reading
    def log(self) -> NDArray[np.float64]:
        """The screw (..., 6) = (w, v) with exp(screw) the same motion, |w| in [0, pi]; that of -M is that of M.

        Exact to rounding at the identity, for pure translations and at pi. Our derivation.
        """
        screw = _LOG.call(self)
        return k.motor_log(self.array) if screw is None else screw

    def as_matrix(self) -> NDArray[np.float64]:
        """Rigid transforms (..., 4, 4)."""
        matrix = _MATRIX.call(self)
        return k.motor_matrix(self.array) if matrix is None else matrix

    @property
    def translation(self) -> NDArray[np.float64]:
        """Where the origin goes (..., 3), metres: the last column of `as_matrix()`."""
        return k.motor_translation(self.array)

    def as_screw(self) -> tuple[Line, NDArray[np.float64], NDArray[np.float64]]:
        """Axis, angle in [0, pi] (...), advance along the axis (...), metres: the inverse of `from_line_angle`.

        A pure translation has angle 0 and an axis through the origin; the identity has the z-axis.
        """
        screw = self.log()
        w, v = screw[..., :3], screw[..., 3:]
        angle = length(w)
        turning = (angle > 0.0)[..., None]
        n = np.where(turning, w, v)
        size = length(n)[..., None]
        n = np.where(size > 0.0, n / np.where(size > 0.0, size, 1.0), np.array([0.0, 0.0, 1.0]))
        advance = np.sum(v * n, axis=-1)
        safe = np.where(angle > 0.0, angle, 1.0)[..., None]
        point = np.where(turning, cross(n, v) / safe, 0.0)
        return Line._of(point, n), angle, advance

    def as_multivector(self) -> Multivector:
        return self._of_null(self.array)

    @staticmethod
    def _of_null(array: NDArray[np.float64]) -> Multivector:
        return Multivector.from_null(**{name: array[..., i] for i, name in enumerate(_NAMES)})

    # ---- the group
    def __matmul__(self, other: Any) -> Any:
        """Compose with a versor, or move an entity: M X ~M."""
        direct = _DIRECT.get(type(other))
        if direct is not None and (result := direct.call(self, other)) is not None:
            return result
        kernel = _KERNELS.get(type(other))
        if kernel is not None:
            return apply(kernel, self, other, type(other))
        if isinstance(other, Versor) and (motor := getattr(other, "as_motor", None)) is not None:
            return apply(k.motor_product, self, motor(), Motor)
        if isinstance(other, Multivector):
            m = self.as_multivector()
            return m * other * ~m
        raise refuse_operand(self, other)

    def __invert__(self) -> Self:
        return self._wrap(self.array * _REVERSE)

    def __neg__(self) -> Self:
        """-M, the same motion."""
        return self._wrap(-self.array)

    def __pow__(self, exponent: ArrayLike) -> Motor:
        """The motion `exponent` times as far along the same screw: exp(exponent log M)."""
        return Motor.exp(self.log() * float_array(exponent, "exponent")[..., None])

    def as_motor(self) -> Motor:
        return self

    def interpolate(self, other: Motor, t: ArrayLike) -> Motor:
        """The screw motion from self (t = 0) to other (t = 1), the short way: self exp(t log(~self other))."""
        if not isinstance(other, Motor):
            raise InputError(f"expected a Motor, got {type(other).__name__}", place="other")
        t = float_array(t, "t")
        a, b, s = together([self.array, other.array, t[..., None]], ["self", "other", "t"])
        return Motor._wrap(k.motor_interpolate(a, b, s[..., 0]))

    def is_same_motion(self, other: Self, atol: float = 1e-12) -> NDArray[np.bool_]:
        """Elementwise: equal up to the sign, within atol times the largest coefficient (at least 1)."""
        return self.isclose(other, rtol=atol, atol=atol) | self.isclose(-other, rtol=atol, atol=atol)

    def _text(self) -> str:
        screw = self.log()
        return f"rotation={vector(screw[:3])}, translation={vector(self.translation)}"


_KERNELS = {**ACTIONS, Motor: k.motor_product}
_DIRECT = {kind: kernel.direct([Motor, kind], [kind]) for kind, kernel in _KERNELS.items()}
_EXP, _LOG = k.motor_exp.direct([np.ndarray], [Motor]), k.motor_log.direct([Motor], [np.ndarray])
_MATRIX = k.motor_matrix.direct([Motor], [np.ndarray])
