"""Singular postures, folds, and where the snake is regular."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def singularity(joints: NDArray[np.float64], lengths: NDArray[np.float64], fraction: float) -> NDArray[np.float64]:
    """How far the wheel axes are from meeting in one point or being parallel: 0 exactly when they do, (...,).

    The wheel axis of link i is the line d_i + (d_i . p_i) einf (IPNS; for midpoint wheels Q_{i+1} - Q_i up to scale). All
    triple wedges of these lines vanish exactly when the smallest singular value of their coefficient rows does; the einf
    coefficient is taken about the centroid of the wheels and over their rms radius. [Snake] (7), corrected: docs/errata.md.
    """
    d = np.diff(joints, axis=-2)[..., 1:-1, :] / lengths[1:-1, None]
    p = joints[..., 1:-2, :] + fraction * lengths[1:-1, None] * d
    if d.shape[-2] < 3:
        return np.zeros(d.shape[:-2])
    arm = p - p.mean(axis=-2, keepdims=True)
    radius = np.sqrt((arm**2).sum(axis=-1).mean(axis=-1))[..., None, None]
    moment = (d * arm).sum(axis=-1, keepdims=True) / np.maximum(radius, 1e-300)
    return np.asarray(np.linalg.svd(np.concatenate([d, moment], axis=-1), compute_uv=False)[..., -1], dtype=np.float64)


def fold_joints(lengths: NDArray[np.float64], fraction: float) -> NDArray[np.intp]:
    """The joints j in 2 .. N-1 whose fold Phi_j = pi can be neither reached nor left.

    A fold is invariant exactly when the wheels of the two links then stand on one another: (1 - f) l_{j-1} = f l_j.
    For midpoint wheels that is l_{j-1} = l_j.
    """
    first, second = lengths[1:-2], lengths[2:-1]
    return 2 + np.flatnonzero(np.isclose((1.0 - fraction) * first, fraction * second, rtol=1e-12, atol=0.0))


def regularity(q: NDArray[np.float64], lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """Determinant of the brackets up to the generic degree for N = 4, 5, equal lengths and midpoint wheels, (...,).

    Rows: the basis elements of degrees 2, 3 (and 4) of the loop algebra, in units of 1/length; columns: the absolute angles
    of the wheeled links. The posture is regular exactly where it is not zero:

        N = 4:  -32 sin((Phi_2 - Phi_3)/2) cos(Phi_2/2) cos(Phi_3/2)
        N = 5:  -256 cos(Phi_2/2) cos(Phi_3/2)^2 cos(Phi_4/2) sin((Phi_2 - Phi_4)/2)

    Our derivation, proven exactly in derivations/snake_regularity.py.
    """
    half = 0.5 * q[..., 4 : len(lengths) + 1]
    c = np.cos(half)
    if len(lengths) == 5:
        return -32.0 * np.sin(half[..., 0] - half[..., 1]) * c[..., 0] * c[..., 1]
    return -256.0 * c[..., 0] * c[..., 1] ** 2 * c[..., 2] * np.sin(half[..., 0] - half[..., 2])
