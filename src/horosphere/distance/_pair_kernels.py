"""Signed distance of a segment to a solid, exactly: compiled code on scalars.

A segment is a + t u with t in [0, 1]; a point has u = 0. Every function returns (distance, t, nx, ny, nz): the signed
distance of the segment to the solid, the parameter of its witness point, and the unit vector along which a motion of that
point increases the distance. The witness on the solid is x - distance n. Inside, the distance is minus the length of the
shortest translation that takes the whole segment out of the solid.

A row S[j] describes a solid (see horosphere.shapes.pack):
  0 kind, 1-3 centre and 4 radius of a bounding ball, 5 rounding radius, 6- the numbers of the kind.
"""

from __future__ import annotations

import numpy as np

from ..kernels import inner
from ..shapes._segment_kernels import to_segment
from ..shapes._tree_kernels import to_cloud, to_mesh
from ._plane_kernels import to_convex

SEGMENT, HALF_SPACE, CLOUD, MESH = 0, 3, 5, 6


@inner
def segment_distance(S, j, ax, ay, az, ux, uy, uz, framed, forest=None, limit=np.inf):
    """Signed distance of the segment a + t u to solid j of the rows S, with t and the unit direction of increase.

    `framed` None says that no row is a box, cylinder or ellipsoid, `forest` None that none is a mesh or a large cloud: then
    their code is not compiled (see `Packed`). A mesh or cloud that is no nearer than `limit` may answer with `limit`.
    """
    kind, radius = S[j, 0], S[j, 5]
    if kind == SEGMENT:
        d, t, nx, ny, nz = to_segment(ax, ay, az, ux, uy, uz, S[j, 6], S[j, 7], S[j, 8], S[j, 9], S[j, 10], S[j, 11])
        return d - radius, t, nx, ny, nz
    if kind == HALF_SPACE:
        nx, ny, nz = S[j, 6], S[j, 7], S[j, 8]
        at, along = nx * ax + ny * ay + nz * az, nx * ux + ny * uy + nz * uz
        t = 0.5 if along == 0.0 else (1.0 if along < 0.0 else 0.0)
        return at + min(along, 0.0) - S[j, 9], t, nx, ny, nz
    if forest is not None:
        nodes, ends, balls, triangles = forest
        if kind == CLOUD:
            return to_cloud(S, j, nodes, ends, balls, ax, ay, az, ux, uy, uz, limit)
        if kind == MESH:
            return to_mesh(S, j, nodes, ends, triangles, ax, ay, az, ux, uy, uz, limit)
    if framed is None:
        return np.inf, 0.0, 0.0, 0.0, 0.0
    px, py, pz = ax - S[j, 1], ay - S[j, 2], az - S[j, 3]
    # the frame of a box, cylinder or ellipsoid: its axes are the rows of 6-14
    a = (
        S[j, 6] * px + S[j, 7] * py + S[j, 8] * pz,
        S[j, 9] * px + S[j, 10] * py + S[j, 11] * pz,
        S[j, 12] * px + S[j, 13] * py + S[j, 14] * pz,
    )
    u = (
        S[j, 6] * ux + S[j, 7] * uy + S[j, 8] * uz,
        S[j, 9] * ux + S[j, 10] * uy + S[j, 11] * uz,
        S[j, 12] * ux + S[j, 13] * uy + S[j, 14] * uz,
    )
    size = (S[j, 15], S[j, 16], S[j, 17])
    d, t, x, y, z = to_convex(kind, a, u, size)
    return (
        d,
        t,
        S[j, 6] * x + S[j, 9] * y + S[j, 12] * z,
        S[j, 7] * x + S[j, 10] * y + S[j, 13] * z,
        S[j, 8] * x + S[j, 11] * y + S[j, 14] * z,
    )
