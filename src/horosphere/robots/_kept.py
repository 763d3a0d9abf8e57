"""What loading a robot computes, on disk, so that the second load takes none of it: by content and version of the code."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..kernels._cache import cache_folder, source_stamp

Floats = NDArray[np.float64]


def kept(what: str, key: str, make: Callable[[], Floats]) -> Floats:
    """The array (n, m) that `make` gives for a key, or the same from an earlier call. A folder that cannot be written or a file that
    cannot be read means no cache."""
    found = find(what, key)
    if found is not None:
        return found
    rows = make()
    with suppress(OSError):
        _write(_place(what, key), rows)
    return rows


def find(what: str, key: str) -> Floats | None:
    """What is kept for a key, None if nothing is."""
    with suppress(OSError, ValueError, EOFError):
        rows = np.load(_place(what, key), allow_pickle=False)
        if rows.ndim == 2 and len(rows) and rows.dtype == np.float64 and np.isfinite(rows).all():
            return rows
    return None


def digest(*parts: object) -> str:
    """A key of numbers, words, arrays, and lists of them."""
    found = hashlib.sha256()
    for part in parts:
        if isinstance(part, list | tuple):
            found.update(f"{len(part)}:{digest(*part)}".encode())
        elif isinstance(part, np.ndarray):
            found.update(f"{part.shape}".encode() + np.ascontiguousarray(part).tobytes())
        else:
            found.update(part if isinstance(part, bytes) else f"{part!r};".encode())
    return found.hexdigest()[:40]


def _place(what: str, key: str) -> Path:
    return cache_folder() / what / f"{digest(_version(), key)}.npy"


@cache
def _version() -> str:
    """Of what covers are made by, and what pairs are judged by."""
    modules = ("_cover", "_meshes", "_apart")
    return " ".join([np.__version__, *(source_stamp(f"horosphere.robots.{name}") for name in modules)])


def _write(path: Path, rows: Floats) -> None:
    """Under another name first: a reader sees all of the file or none."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as file:
            np.save(file, rows)
        os.replace(name, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(name)
        raise
