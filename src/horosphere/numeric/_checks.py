from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError


def float_array(
    value: ArrayLike, name: str, last: int | None = None, ndim: int | None = None, finite: bool = True
) -> NDArray[np.float64]:
    """`value` as a C-contiguous float64 array; an input that is one already is returned as it is.

    `last` is the expected length of the last axis, `ndim` the expected number of axes.
    Raises InputError naming `name`, what was expected and what came (or the index of the first NaN or infinity).
    """
    if type(value) is np.ndarray and value.dtype == np.float64:
        array = np.ascontiguousarray(value) if value.ndim else value
    else:
        array = _converted(value, name)
    if ndim is not None and array.ndim != ndim:
        raise InputError(f"expected {ndim} axes, got shape {array.shape}", place=name)
    if last is not None and (array.ndim == 0 or array.shape[-1] != last):
        raise InputError(f"expected shape (..., {last}), got {array.shape}", place=name)
    if finite and not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError(f"expected finite numbers, got {array[where]} at index {where}", place=name)
    return array


def _converted(value: ArrayLike, name: str) -> NDArray[np.float64]:
    """Anything that numpy reads as real numbers; text, complex numbers, times and masked elements are none."""
    if value is None:
        raise InputError("expected numbers, got None", place=name)
    try:
        raw = np.asarray(value)
        if raw.dtype.kind not in "fiubO":
            kind = {"c": "complex numbers", "U": "text", "S": "text", "M": "dates", "m": "times"}.get(
                raw.dtype.kind, "other things"
            )
            raise InputError(f"expected numbers, got {kind} ({raw.dtype})", place=name)
        if np.ma.is_masked(value):
            raise InputError("expected numbers, got masked elements", place=name, remedy="fill or drop them")
        return np.ascontiguousarray(raw, dtype=np.float64) if raw.ndim else np.asarray(raw, np.float64)
    except InputError:
        raise
    except (TypeError, ValueError) as error:
        raise InputError(f"expected numbers, got {type(value).__name__} ({error})", place=name) from None


def is_number(text: str) -> bool:
    """Whether a cell of a text file is a number; "nan" and "inf" are."""
    try:
        float(text)
    except ValueError:
        return False
    return True
