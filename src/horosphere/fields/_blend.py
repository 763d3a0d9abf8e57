"""The weights with which nearby zones share the motion, in plain numpy: for pictures, diagnosis, and as the kernels' witness."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def nearest_weights(d: Array) -> Array:
    """The nearest entry alone (abrupt switching, [Rn] Fig. 2a); distances d (b, m)."""
    mu = np.zeros_like(d)
    if d.shape[1]:
        mu[np.arange(len(d)), d.argmin(axis=1)] = 1.0
    return mu


def simplex_weights(d: Array, boundary: float) -> Array:
    """The Euclidean projection of -d / boundary on the simplex; equals [Rn] (9) wherever that is not negative."""
    if boundary <= 0.0:
        return nearest_weights(d)
    order = np.sort(d - d.min(axis=1, keepdims=True), axis=1) / boundary
    count = np.arange(1, d.shape[1] + 1)
    tau = (1.0 + np.cumsum(order, axis=1)) / count
    last = (order < tau).sum(axis=1) - 1
    chosen = np.take_along_axis(tau, last[:, None], axis=1)
    return np.maximum(chosen - (d - d.min(axis=1, keepdims=True)) / boundary, 0.0)


def smooth_weights(d: Array, boundary: float, gaps: Array) -> Array:
    """w_i = product over j of h((d_j - d_i) / min(boundary, gap_ij)), normalised; h the quintic step from -1 to 1. Twice
    continuously differentiable, and on the boundary of zone i all weight is on i whatever `boundary` is."""
    if boundary <= 0.0:
        return nearest_weights(d)
    width = np.maximum(np.minimum(boundary, gaps), 1e-300)
    np.fill_diagonal(width, 1.0)
    t = np.clip(0.5 + 0.5 * (d[:, None, :] - d[:, :, None]) / width, 0.0, 1.0)
    h = t**3 * (10.0 + t * (6.0 * t - 15.0))
    k = d.shape[1]
    h[:, np.arange(k), np.arange(k)] = 1.0
    w = h.prod(axis=2)
    return w / w.sum(axis=1, keepdims=True)
