"""Ways out and back, from which steering starts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_REACHES = (0.5, 0.7, 0.4, 0.6, 1.0, 0.4, 0.85)  # length of the way out over the length of the wheeled body


def out_and_back(theta: Array, segments: int, attempt: int, body: float, rng: np.random.Generator) -> Array:
    """A way out, and back the same way, which returns exactly: in turns straight ahead, along waves, and random loops."""
    half = segments // 2
    t = (np.arange(half) + 0.5) / half
    if attempt % 3 == 2:  # shorter ways, from which Newton's method arrives less often
        out = np.zeros((half, 2))
        for axis in range(2):
            for harmonic in (1, 2, 3):
                weight, phase = rng.normal(), rng.uniform(0.0, 2.0 * np.pi)
                out[:, axis] += 0.25 * body * weight * np.sin(np.pi * harmonic * t + phase)
        return np.concatenate([out, -out[::-1]])
    heading = np.full(half, float(np.angle(-np.exp(1j * theta).sum())))
    if attempt > 1:
        waves, phase = rng.uniform(0.3, 1.5), rng.uniform(0.0, 2.0 * np.pi)
        heading += rng.uniform(-0.6, 0.6) + rng.uniform(0.2, 1.5) * np.sin(2.0 * np.pi * waves * t + phase)
    length = body * _REACHES[attempt % len(_REACHES)]
    out = 2.0 * length * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    return np.concatenate([out, -out[::-1]])
