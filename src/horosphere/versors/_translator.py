from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra import Multivector
from ..algebra._format import vector
from ..numeric import float_array
from ._motor import Motor
from ._versor import Versor, apply


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Translator(Versor):
    """Translation 1 - t ei/2 [Humanoid, eq 13, see the errata]; `array` (..., 3) over (e1i, e2i, e3i) = -t/2."""

    SIZE: ClassVar[int] = 3

    @classmethod
    def identity(cls, shape: tuple[int, ...] = ()) -> Self:
        """No translation, as a batch of this shape."""
        return cls._wrap(np.zeros((*shape, 3)))

    @classmethod
    def from_vector(cls, t: ArrayLike) -> Self:
        """By vectors (..., 3), metres."""
        return cls._wrap(-0.5 * float_array(t, "t", last=3))

    def as_vector(self) -> NDArray[np.float64]:
        """The vectors t (..., 3), metres."""
        return -2.0 * self.array

    def as_matrix(self) -> NDArray[np.float64]:
        """Rigid transforms (..., 4, 4)."""
        return self.as_motor().as_matrix()

    def as_motor(self) -> Motor:
        """The same motion as a Motor."""
        return Motor.from_translation(self.as_vector())

    def as_multivector(self) -> Multivector:
        return self.as_motor().as_multivector()

    def __matmul__(self, other: Any) -> Any:
        """Compose with a versor (a Translator gives a Translator, others a Motor), or move an entity."""
        if type(other) is Translator:
            return apply(np.add, self, other, Translator)
        return self.as_motor() @ other

    def __invert__(self) -> Self:
        return self._wrap(-self.array)

    def _text(self) -> str:
        return vector(self.as_vector())
