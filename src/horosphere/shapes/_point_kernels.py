"""Distances of many points to a cloud or a mesh: the loop that numpy calls."""

from __future__ import annotations

import numpy as np

from ..kernels import jit
from ._tree_kernels import _point, to_cloud


@jit
def cloud_points(S, nodes, ends, balls, X, D):
    """Signed distance D (m,) of points X (m, 3) to the nearest ball."""
    for i in range(X.shape[0]):
        D[i] = to_cloud(S, 0, nodes, ends, balls, X[i, 0], X[i, 1], X[i, 2], 0.0, 0.0, 0.0, np.inf)[0]


@jit
def mesh_points(S, nodes, ends, triangles, X, D):
    """Signed distance D (m,) of points X (m, 3) to the nearest of the solids and surfaces in S."""
    for i in range(X.shape[0]):
        D[i] = np.inf
        for j in range(S.shape[0]):
            D[i] = min(D[i], _point(S, j, nodes, ends, triangles, X[i, 0], X[i, 1], X[i, 2], np.inf)[0])


@jit
def least_distance(S, nodes, ends, triangles, X, limit, enough):
    """Least signed distance of points X (m, 3), at most `limit`; the first one below `enough` ends the search."""
    least = limit
    for j in range(S.shape[0]):
        for i in range(X.shape[0]):
            least = min(least, _point(S, j, nodes, ends, triangles, X[i, 0], X[i, 1], X[i, 2], least)[0])
            if least < enough:
                return least
    return least
