"""How large bodies must be to hold the pieces of a solid: the loop that numpy calls."""

from __future__ import annotations

import math

import numpy as np

from ..kernels import jit


@jit
def needs_of(points, starts, a, b, out):
    """Radius out (k, c) that a body about each segment a, b (c, 3) needs to hold each piece: the largest distance of its
    points (p, 3), from `starts` (k + 1,). In single precision, rounded up."""
    for c in range(a.shape[0]):
        ax, ay, az = a[c, 0], a[c, 1], a[c, 2]
        ux, uy, uz = b[c, 0] - ax, b[c, 1] - ay, b[c, 2] - az
        square = ux * ux + uy * uy + uz * uz
        scale = 1.0 / square if square > 1e-18 else 0.0
        for k in range(starts.shape[0] - 1):
            most = 0.0
            for i in range(starts[k], starts[k + 1]):
                x, y, z = points[i, 0] - ax, points[i, 1] - ay, points[i, 2] - az
                t = min(max((x * ux + y * uy + z * uz) * scale, 0.0), 1.0)
                x, y, z = x - t * ux, y - t * uy, z - t * uz
                most = max(most, x * x + y * y + z * z)
            out[k, c] = np.float32(math.sqrt(most)) + np.float32(1e-6)
