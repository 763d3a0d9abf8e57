"""The general element of G(4,1): dense, table-driven, slow, obvious; the oracle of every fast kernel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError, unknown_name
from ..numeric import float_array
from . import _tables as t
from ._batch import Batch
from ._format import combination, latex_name


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Multivector(Batch):
    """Element of G(4,1) by its 32 coefficients over 1, e1..e5, e12, .., e12345 (grade-lexicographic; e5 squares to -1).

    `*` geometric, `^` outer, `|` Hestenes inner product (0 with scalars), `~` reverse, `/` by scalars and by invertible
    elements; numbers and arrays of the batch shape count as scalars. Null basis: ei = e4 + e5, e0 = (e5 - e4)/2.
    """

    SIZE: ClassVar[int] = 32
    NAMES: ClassVar[tuple[str, ...]] = t.NAMES

    # ---- construction and reading
    @classmethod
    def scalar(cls, value: ArrayLike) -> Self:
        """Scalars `value` (...)."""
        x = float_array(value, "value")
        out = np.zeros((*x.shape, 32))
        out[..., 0] = x
        return cls._wrap(out)

    @classmethod
    def vector(cls, components: ArrayLike) -> Self:
        """The grade-1 element with `components` (..., 5) over e1..e5."""
        x = float_array(components, "components", last=5)
        out = np.zeros((*x.shape[:-1], 32))
        out[..., 1:6] = x
        return cls._wrap(out)

    @classmethod
    def blade(cls, name: str, coefficient: ArrayLike = 1.0) -> Self:
        """A multiple of the basis blade `name`, one of `Multivector.NAMES` such as "e12". Raises InputError."""
        if not isinstance(name, str) or name not in t.NAMES:
            raise unknown_name("blade", name, t.NAMES, place="name")
        c = float_array(coefficient, "coefficient")
        out = np.zeros((*c.shape, 32))
        out[..., t.NAMES.index(name)] = c
        return cls._wrap(out)

    @classmethod
    def from_null(cls, **coefficients: ArrayLike) -> Self:
        """From coefficients (...) over outer products of e1 e2 e3 e0 ei, by name: `e12=1, e0i=2`; s is the scalar."""
        parts = {k: float_array(v, k) for k, v in coefficients.items()}
        valid = ["s"] + ["e" + n for n in t.NULL_NAMES[1:]]
        out = np.zeros((*np.broadcast_shapes(*(p.shape for p in parts.values())), 32))
        for key, value in parts.items():
            if key not in valid:
                raise unknown_name("blade", key, valid)
            out[..., t.NULL_POSITION["" if key == "s" else key[1:]]] = value
        return cls._wrap(out @ t.FROM_NULL.T)

    def null(self, name: str) -> NDArray[np.float64]:
        """Coefficient (...) of an outer product of null-basis vectors, named as in `from_null`."""
        key = "" if isinstance(name, str) and name == "s" else str(name)[1:]
        if not isinstance(name, str) or key not in t.NULL_POSITION:
            raise unknown_name("blade", name, ["s"] + ["e" + n for n in t.NULL_NAMES[1:]], place="name")
        return self.array @ t.TO_NULL[t.NULL_POSITION[key]]

    @property
    def coefficients(self) -> NDArray[np.float64]:
        """(..., 32), grade-lexicographic over e1..e5, read-only."""
        return self.array

    def coefficient(self, name: str) -> NDArray[np.float64]:
        """The coefficient (...) of the basis blade `name`, one of `Multivector.NAMES`."""
        if not isinstance(name, str) or name not in t.NAMES:
            raise unknown_name("blade", name, t.NAMES, place="name")
        return self.array[..., t.NAMES.index(name)]

    @property
    def scalar_part(self) -> NDArray[np.float64]:
        """Grade-0 coefficient (...)."""
        return self.array[..., 0]

    # ---- products
    def __mul__(self, other: Multivector | ArrayLike) -> Multivector:
        if isinstance(other, Multivector):
            return _product(self, other, t.GEOMETRIC)
        return self._wrap(self.array * _scalars(other))

    def __rmul__(self, other: ArrayLike) -> Multivector:
        return self._wrap(self.array * _scalars(other))

    def __xor__(self, other: Multivector | ArrayLike) -> Multivector:
        return _product(self, _element(other), t.OUTER)

    def __rxor__(self, other: ArrayLike) -> Multivector:
        return _product(_element(other), self, t.OUTER)

    def __or__(self, other: Multivector | ArrayLike) -> Multivector:
        return _product(self, _element(other), t.INNER)

    def __ror__(self, other: ArrayLike) -> Multivector:
        return _product(_element(other), self, t.INNER)

    def left_contraction(self, other: Multivector | ArrayLike) -> Multivector:
        """The part of `self` removed from `other`: grade of other minus grade of self; scalars multiply."""
        return _product(self, _element(other), t.LEFT_CONTRACTION)

    def commutator(self, other: Multivector) -> Multivector:
        """(a b - b a) / 2."""
        return (self * other - other * self) * 0.5

    def __truediv__(self, other: Multivector | ArrayLike) -> Multivector:
        if isinstance(other, Multivector):
            return self * other.inverse()
        divisor = _scalars(other)
        if not np.all(divisor):
            raise InputError("division of a Multivector by zero", place="other")
        return self._wrap(self.array / divisor)

    def __rtruediv__(self, other: ArrayLike) -> Multivector:
        return _element(other) * self.inverse()

    # ---- sums
    def __add__(self, other: Multivector | ArrayLike) -> Multivector:
        return self._wrap(self.array + _element(other).array)

    __radd__ = __add__

    def __sub__(self, other: Multivector | ArrayLike) -> Multivector:
        return self._wrap(self.array - _element(other).array)

    def __rsub__(self, other: ArrayLike) -> Multivector:
        return self._wrap(_element(other).array - self.array)

    def __neg__(self) -> Multivector:
        return self._wrap(-self.array)

    def __pos__(self) -> Multivector:
        return self

    # ---- involutions, grades, duals
    def __invert__(self) -> Multivector:
        """Reverse: (-1)^(k(k-1)/2) on grade k."""
        return self._wrap(self.array * t.REVERSE)

    def involute(self) -> Multivector:
        """Grade involution: (-1)^k on grade k."""
        return self._wrap(self.array * t.INVOLUTE)

    def grade(self, *grades: int) -> Multivector:
        """The part of these grades (0..5)."""
        for k in grades:
            if not isinstance(k, int | np.integer) or k not in range(6):
                raise InputError(f"expected grades 0..5, got {k!r}", place="grades")
        return self._wrap(self.array * np.isin(t.GRADE, grades))

    def grades(self, tolerance: float = 1e-12) -> tuple[int, ...]:
        """Grades present anywhere in the batch above `tolerance` times the largest coefficient."""
        size = np.abs(self.array).reshape(-1, 32).max(0, initial=0.0)
        return tuple(int(k) for k in range(6) if size[k == t.GRADE].max() > tolerance * max(size.max(), 1e-300))

    def dual(self) -> Multivector:
        """X I^-1 = -X I: takes an IPNS blade to its OPNS blade."""
        return _product(self, _element(_INVERSE_I), t.GEOMETRIC)

    def undual(self) -> Multivector:
        """X I: takes an OPNS blade to its IPNS blade; inverse of `dual`."""
        return _product(self, _element(-_INVERSE_I), t.GEOMETRIC)

    # ---- inverse, exponential
    def inverse(self) -> Multivector:
        """X^-1: ~X/(X ~X) for versors and blades, else by solving X Y = 1. Raises InputError when there is none."""
        reverse = ~self
        square = (self * reverse).array
        scale = np.abs(square[..., 0])
        size = np.sum(self.array**2, axis=-1)
        if np.all(np.abs(square[..., 1:]).max(-1) <= 1e-12 * scale) and np.all(scale > 1e-14 * size):
            return self._wrap(reverse.array / square[..., :1])
        matrix = self.array[..., _OTHER] * _OTHER_SIGN  # Y -> X Y
        one = np.zeros((*self.shape, 32, 1))
        one[..., 0, 0] = 1.0
        if np.any(np.linalg.cond(matrix) > 1e13):
            raise InputError(
                "this Multivector has no inverse", remedy="null vectors such as points and zero divisors have none"
            )
        return self._wrap(np.asarray(np.linalg.solve(matrix, one)[..., 0], np.float64))

    def exp(self) -> Multivector:
        """exp X by scaling, a Taylor series of 20 terms, and squaring."""
        size = float(np.abs(self.array).sum(-1).max(initial=0.0))
        halvings = max(0, int(np.ceil(np.log2(max(size, 1e-300)))) + 1)
        x = self * 0.5**halvings
        total = term = _element(np.ones(self.shape))
        for k in range(1, 21):
            term = term * x * (1.0 / k)
            total = total + term
        for _ in range(halvings):
            total = total * total
        return total

    # ---- display
    def _text(self) -> str:
        return combination(self.array, t.NAMES)

    def _latex(self) -> str:
        return combination(self.array, [latex_name(n) for n in t.NAMES], latex=True)


def _product(a: Multivector, b: Multivector, signs: NDArray[np.float64]) -> Multivector:
    gathered = b.array[..., t.PARTNER] * signs
    return Multivector._wrap(np.matmul(gathered, a.array[..., :, None])[..., 0])


def _scalars(value: ArrayLike) -> NDArray[np.float64]:
    return float_array(value, "scalar")[..., None]


def _element(value: Multivector | ArrayLike) -> Multivector:
    return value if isinstance(value, Multivector) else Multivector.scalar(value)


# PARTNER[k, i] = j means e_i e_j ~ e_k; here the other way round: which i goes with a given j.
_OTHER = np.argsort(t.PARTNER, axis=1)
_OTHER_SIGN = np.take_along_axis(t.GEOMETRIC, _OTHER, axis=1)
_INVERSE_I = Multivector.blade("e12345", -1.0)
