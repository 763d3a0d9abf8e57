"""What an argument has to be: numbers, a path. Each check returns it as it is used, or raises InputError with its name."""

from __future__ import annotations

import operator
import os
from pathlib import Path
from typing import Any

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
        raise InputError(f"expected {f'{ndim} axes' if ndim else 'one number'}, got shape {array.shape}", place=name)
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


def number(value: Any, name: str, *, above: float = -np.inf, least: float = -np.inf, most: float = np.inf) -> float:
    """One float within bounds; infinite only where no bound says otherwise."""
    x = float(float_array(value, name, ndim=0, finite=False))
    if np.isnan(x) or x <= above or x < least or x > most:
        bounds = [f"above {above:g}"] * (above > -np.inf) + [f"at least {least:g}"] * (least > -np.inf)
        bounds += [f"at most {most:g}"] * (most < np.inf)
        raise InputError(" ".join(("expected a number", " and ".join(bounds))).rstrip() + f", got {x:g}", place=name)
    return x


def whole_number(value: Any, name: str, least: int) -> int:
    """An integer of at least `least`; a float is none, whatever its value."""
    try:
        k = operator.index(value)
    except TypeError:
        raise InputError(f"expected a whole number, got {value!r:.60}", place=name) from None
    if k < least:
        raise InputError(f"expected at least {least}, got {k}", place=name)
    return k


def file_path(value: Any, name: str) -> Path:
    """A path from a str or a Path."""
    text = os.fspath(value) if isinstance(value, str | os.PathLike) else None
    if not isinstance(text, str):
        raise InputError(f"expected the path of a file, got {type(value).__name__}", place=name)
    return Path(text)


def is_number(text: str) -> bool:
    """Whether a cell of a text file is a number; "nan" and "inf" are."""
    try:
        float(text)
    except ValueError:
        return False
    return True
