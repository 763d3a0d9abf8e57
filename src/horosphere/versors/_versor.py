"""The abstract base of the versors: `@` composes and acts, `~` inverts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..algebra import Batch, Multivector
from ..algebra._format import combination, latex_name
from ..algebra._tables import NULL_NAMES, TO_NULL
from ..entities import Circle, Line, Plane, Point, PointPair, Sphere
from ..entities._build import check_shapes
from ..errors import InputError
from ..kernels import Kernel
from . import _kernels as k

# entity type -> kernel of the motor action, of the reflection
ACTIONS: dict[type, Kernel] = {
    Point: k.motor_point,
    Line: k.motor_line,
    Plane: k.motor_plane,
    Sphere: k.motor_sphere,
    Circle: k.motor_round,
    PointPair: k.motor_round,
}
REFLECTIONS: dict[type, Kernel] = {
    Point: k.reflect_point,
    Line: k.reflect_line,
    Plane: k.reflect_plane,
    Sphere: k.reflect_sphere,
    Circle: k.reflect_round,
    PointPair: k.reflect_round,
}
_LATEX_NAMES = ["1"] + [latex_name("e" + n) for n in NULL_NAMES[1:]]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Versor(Batch):
    """Abstract unit versor. `a @ b`: b first, then a; `v @ entity`: the moved entity; batches broadcast."""

    def __matmul__(self, other: Any) -> Any:
        raise NotImplementedError

    def __invert__(self) -> Self:
        """The inverse, which for a unit versor is the reverse."""
        raise NotImplementedError

    def as_multivector(self) -> Multivector:
        """The versor as a general element."""
        raise NotImplementedError

    def as_matrix(self) -> NDArray[np.float64]:
        """The 4x4 matrix (..., 4, 4) that does the same to homogeneous coordinates."""
        raise NotImplementedError

    def _latex(self) -> str:
        return combination(TO_NULL @ self.as_multivector().coefficients, _LATEX_NAMES, latex=True)


def apply(kernel: Callable, a: Batch, b: Batch, result: type) -> Any:
    """Run a kernel on two values; shapes that do not broadcast are named."""
    try:
        return result._wrap(kernel(a.array, b.array))
    except ValueError:
        check_shapes(a, b)
        raise


def refuse_operand(versor: Versor, other: object) -> InputError:
    """The error for `versor @ other` with something that it does not act on."""
    name = type(versor).__name__
    remedy = None
    if isinstance(other, (np.ndarray, list, tuple)):
        remedy = "wrap coordinates in Point.from_euclidean, or use as_matrix()"
    elif isinstance(other, (Versor, Multivector)):
        remedy = "apply one after the other, or multiply their as_multivector()"
    return InputError(
        f"{name} @ {type(other).__name__} is not defined",
        place="@",
        remedy=remedy,
        choices=["Motor", "Rotor", "Translator", *(t.__name__ for t in ACTIONS)],
    )
