from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def wrap_angle(angle: ArrayLike) -> NDArray[np.float64]:
    """The same angle in (-pi, pi], radians."""
    x = np.asarray(angle, dtype=np.float64)
    return np.pi - np.mod(np.pi - x, 2.0 * np.pi)
