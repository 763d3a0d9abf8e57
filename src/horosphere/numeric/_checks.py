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
    try:
        array = np.ascontiguousarray(value, dtype=np.float64) if np.ndim(value) else np.asarray(value, np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"expected numbers, got {type(value).__name__} ({error})", place=name) from None
    if ndim is not None and array.ndim != ndim:
        raise InputError(f"expected {ndim} axes, got shape {array.shape}", place=name)
    if last is not None and (array.ndim == 0 or array.shape[-1] != last):
        raise InputError(f"expected shape (..., {last}), got {array.shape}", place=name)
    if finite and not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError(f"expected finite numbers, got {array[where]} at index {where}", place=name)
    return array
