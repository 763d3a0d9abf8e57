"""What every batched value shares: one read-only float64 array, leading axes batch, last axis coefficients."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Batch:
    """Abstract value around `array` (..., K); frozen, hashable, `==` compares exactly and gives one bool."""

    array: NDArray[np.float64]

    SIZE: ClassVar[int] = 0  # K
    __array_ufunc__: ClassVar[None] = None  # numpy leaves binary operators to us

    def __post_init__(self) -> None:
        array = float_array(self.array, f"{type(self).__name__}.array", last=self.SIZE)
        if array is self.array or array.base is not None or not array.flags.owndata:
            array = array.copy()
        array.setflags(write=False)
        _set_array(self, array)
        self._check()

    def _check(self) -> None:
        """Raise InputError when the coefficients are not in the canonical form of the type."""

    @classmethod
    def _wrap(cls, array: NDArray[np.float64]) -> Self:
        """The value around an array of ours, unchecked. It becomes read-only: hand over a view of a buffer that stays in use."""
        self = object.__new__(cls)
        array.setflags(write=False)
        _set_array(self, array)
        return self

    # ---- batch
    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape; () for a single value."""
        return self.array.shape[:-1]

    @property
    def ndim(self) -> int:
        """Number of batch axes."""
        return self.array.ndim - 1

    @property
    def size(self) -> int:
        """Number of values in the batch."""
        return int(np.prod(self.shape, dtype=int))

    def __len__(self) -> int:
        if self.array.ndim == 1:
            raise TypeError(f"a single {type(self).__name__} has no len()")
        return self.array.shape[0]

    def __getitem__(self, index: Any) -> Self:
        """Index the batch axes as numpy does."""
        if self.array.ndim == 1 and index is not Ellipsis and not (isinstance(index, tuple) and not index):
            raise TypeError(f"a single {type(self).__name__} cannot be indexed; its coefficients are in .array")
        key = index if isinstance(index, tuple) else (index,)
        if not any(k is Ellipsis for k in key):
            key = (*key, Ellipsis)
        return self._wrap(np.array(self.array[(*key, slice(None))]))

    def __iter__(self) -> Iterator[Self]:
        if self.array.ndim == 1:
            raise TypeError(f"a single {type(self).__name__} is not iterable")
        return (self._wrap(row.copy()) for row in self.array)

    def reshape(self, *shape: int) -> Self:
        """The same values with another batch shape (sizes, or one tuple of sizes)."""
        sizes = shape[0] if len(shape) == 1 and isinstance(shape[0], tuple) else shape
        try:
            array = self.array.reshape(*sizes, self.array.shape[-1])
        except (TypeError, ValueError):
            raise InputError(f"{self.size} values have no batch shape {sizes!r}", place="shape") from None
        return self._wrap(array.copy())

    def broadcast_to(self, shape: tuple[int, ...]) -> Self:
        """The values repeated to a batch shape."""
        try:
            array = np.broadcast_to(self.array, (*shape, self.array.shape[-1]))
        except (TypeError, ValueError):
            raise InputError(f"a batch of shape {self.shape} has no shape {shape!r}", place="shape") from None
        return self._wrap(array.copy())

    @classmethod
    def stack(cls, values: Any, axis: int = 0) -> Self:
        """Values of this type (equal batch shapes) along a new batch axis. Raises InputError on other types."""
        if not isinstance(values, Iterable):
            raise InputError(f"expected {cls.__name__} values, got {type(values).__name__}", place="values")
        rows = list(values)
        for i, v in enumerate(rows):
            if not isinstance(v, cls):
                raise InputError(f"expected {cls.__name__} values, got {type(v).__name__}", place=f"values[{i}]")
        if not rows:
            raise InputError(f"expected at least one {cls.__name__}, got none", place="values")
        if len({v.shape for v in rows}) > 1:
            raise InputError(f"expected equal batch shapes, got {[v.shape for v in rows]}", place="values")
        return cls._wrap(np.stack([v.array for v in rows], axis=axis if axis >= 0 else axis - 1))

    # ---- comparison, copying
    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return np.array_equal(self.array, other.array)

    def __hash__(self) -> int:
        return hash((type(self), self.array.shape, (self.array + 0.0).tobytes()))  # + 0.0: -0.0 == 0.0

    def isclose(self, other: Self, rtol: float = 1e-9, atol: float = 1e-12) -> NDArray[np.bool_]:
        """Elementwise over the batch: all coefficients equal within `atol + rtol * largest |coefficient|`."""
        if type(other) is not type(self):
            raise InputError(f"expected a {type(self).__name__}, got {type(other).__name__}", place="other")
        scale = np.maximum(np.abs(self.array).max(-1), np.abs(other.array).max(-1))
        return np.abs(self.array - other.array).max(-1) <= atol + rtol * scale

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict) -> Self:
        return self

    def __reduce__(self):
        return _rebuild, (type(self), np.array(self.array))

    # ---- display
    def _text(self) -> str:
        """A single value in words, without the type's name."""
        raise NotImplementedError

    def _latex(self) -> str:
        """A single value in LaTeX, without delimiters."""
        raise NotImplementedError

    def __repr__(self) -> str:
        if self.array.ndim == 1:
            return f"{type(self).__name__}({self._text()})"
        sizes = "x".join(map(str, self.shape))
        flat = self.array.reshape(-1, self.array.shape[-1])
        rows = [self._wrap(row.copy())._text() for row in flat[:3]]
        rows += ["..."] if len(flat) > 3 else []
        return f"{type(self).__name__}[{sizes}]" + "".join(f"\n  {row}" for row in rows)

    def _repr_latex_(self) -> str:
        if self.array.ndim == 1:
            return f"$\\displaystyle {self._latex()}$"
        flat = self.array.reshape(-1, self.array.shape[-1])
        rows = [self._wrap(row.copy())._latex() for row in flat[:6]] + ([r"\vdots"] if len(flat) > 6 else [])
        return r"$\displaystyle \begin{matrix}" + r" \\ ".join(rows) + r"\end{matrix}$"


_set_array = Batch.array.__set__  # type: ignore[attr-defined]  # the slot itself: half the cost of object.__setattr__


def _rebuild(cls: type[Batch], array: NDArray[np.float64]) -> Batch:
    return cls._wrap(array)
