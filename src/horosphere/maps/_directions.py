from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def unit(y: Array) -> tuple[Array, Array]:
    """Unit vectors of y (..., n) and their lengths; the first axis where y = 0."""
    r = np.linalg.norm(y, axis=-1)
    u = np.divide(y, r[..., None], out=np.zeros_like(y, dtype=np.float64), where=r[..., None] > 0.0)
    if (r == 0.0).any():
        u[r == 0.0, 0] = 1.0
    return u, r


@cache
def directions(n: int, count: int | None = None) -> Array:
    """Well-spread unit vectors (count, n): a circle, a golden spiral, else normal deviates from a fixed seed; read-only."""
    if n == 2:
        angle = np.arange(count or 720) * (2.0 * np.pi / (count or 720))
        u = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    elif n == 3:
        k = np.arange(count or 2000) + 0.5
        z = 1.0 - 2.0 * k / len(k)
        angle = np.pi * (1.0 + 5.0**0.5) * k
        s = np.sqrt(1.0 - z * z)
        u = np.stack([s * np.cos(angle), s * np.sin(angle), z], axis=-1)
    else:
        u = np.random.default_rng(n).standard_normal((count or 4000, n))
        u = np.concatenate([np.eye(n), -np.eye(n), u / np.linalg.norm(u, axis=-1, keepdims=True)])
    u.flags.writeable = False
    return u
