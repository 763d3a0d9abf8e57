"""Covers of meshes on disk, so that a robot's second load takes no fitting: by content, options and version of the code."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np

from ..kernels._cache import cache_folder, source_stamp
from ._bodies import Body, Floats

Cover = tuple[list[Body], float]


def kept(triangles: Floats, options: str, make: Callable[[], Cover]) -> Cover:
    """What `make` gives for triangles (t, 3, 3) and options, or the same from an earlier call. A folder that cannot be written or
    a file that cannot be read means no cache."""
    digest = hashlib.sha256(f"{source_stamp('horosphere.robots._cover')} {np.__version__} {options}".encode())
    digest.update(np.ascontiguousarray(triangles).tobytes())
    path = cache_folder() / "covers" / f"{digest.hexdigest()[:40]}.npy"
    with suppress(OSError, ValueError, EOFError):
        rows = np.load(path, allow_pickle=False)
        if rows.ndim == 2 and rows.shape[1] == 7 and len(rows) > 1 and np.isfinite(rows).all():
            return [Body(row[:3], row[3:6], float(row[6])) for row in rows[1:]], float(rows[0, 0])
    bodies, slack = make()
    rows = np.array([[slack, *np.zeros(6)], *([*body.a, *body.b, body.radius] for body in bodies)])
    with suppress(OSError):
        _write(path, rows)
    return bodies, slack


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
