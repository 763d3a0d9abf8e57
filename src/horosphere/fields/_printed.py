"""The weights and the blended potential as [Rn] prints them, kept so that their figures and failures can be reproduced.

Nothing here is safe; what is wrong and why is in docs/errata.md.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def printed_weights(d: Array, boundary: float) -> Array:
    """[Rn] (9) with d_i read as the clearances (b, m): mu_i = 1/k + (mean d - d_i) / boundary over the k within `boundary`.

    Negative for k >= 3 and discontinuous where a third obstacle enters; at boundary 0 the nearest alone.
    """
    near = d <= d.min(axis=1, keepdims=True) + boundary
    k = near.sum(axis=1, keepdims=True)
    mean = np.where(near, d, 0.0).sum(axis=1, keepdims=True) / k
    width = boundary if boundary > 0.0 else np.inf
    return np.where(near, 1.0 / k + (mean - d) / width, 0.0)


def potential_term(points: Array, centers: Array, radii: Array, charges: Array, d: Array, boundary: float) -> Array:
    """What the gradient of the blended potential (8) adds to the blended field (b, n): - sum_i U_i grad mu_i, with (9).

    U_i = -q_i ln |x - S_i| depends on the unit of length.
    """
    if boundary <= 0.0:
        return np.zeros_like(points)
    near = d <= d.min(axis=1, keepdims=True) + boundary
    k = near.sum(axis=1, keepdims=True)
    y = points[:, None] - centers
    r = d + radii
    normals = np.where(near[..., None], y / r[..., None], 0.0)
    mean = normals.sum(axis=1, keepdims=True) / k[..., None]
    slopes = np.where(near[..., None], (mean - normals) / boundary, 0.0)
    return ((charges * np.log(r))[..., None] * slopes).sum(axis=1)
