"""Matrices that are rotations to rounding."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def nearest_rotation(R: Floats) -> Floats:
    """The rotation (n, n) nearest to a matrix that is one to 1e-9 or so: a step of Newton makes 1e-18 of it. What rounds by
    no more than 1e-15 stays as it is.

    Distances carried over by a matrix are trusted only as far as it is a rotation (docs/certificate.md).
    """
    one = np.eye(len(R))
    return R if np.abs(R.T @ R - one).max() <= 1e-15 else 0.5 * R @ (3.0 * one - R.T @ R)
