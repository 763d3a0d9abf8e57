"""Signed distance of a segment to a solid, exactly: compiled code on scalars.

A segment is a + t u with t in [0, 1]; a point has u = 0. Every function returns (distance, t, nx, ny, nz): the signed
distance of the segment to the solid, the parameter of its witness point, and the unit vector along which a motion of that
point increases the distance. The witness on the solid is x - distance n. Inside, the distance is minus the length of the
shortest translation that takes the whole segment out of the solid.

A row S[j] describes a solid (see horosphere.shapes.pack):
  0 kind, 1-3 centre and 4 radius of a bounding ball, 5 rounding radius, 6- the numbers of the kind.
"""

from __future__ import annotations

import math

import numpy as np

from ..shapes._segment_kernels import clamp, inner, to_segment
from ..shapes._tree_kernels import to_cloud, to_mesh
from ._curved_kernels import to_cylinder, to_ellipsoid

SEGMENT, BOX, CYLINDER, HALF_SPACE, ELLIPSOID, CLOUD, MESH = 0, 1, 2, 3, 4, 5, 6


@inner
def _box_slope(t, a, u, h):
    """Half the derivative of the squared distance to a box along the segment: piecewise linear, never falling."""
    slope = 0.0
    for i in range(3):
        x = a[i] + t * u[i]
        excess = abs(x) - h[i]
        if excess > 0.0:
            slope += math.copysign(excess, x) * u[i]
    return slope


@inner
def to_box(a, u, h):
    """Distance of a segment to the box |x_i| <= h_i, in the box frame."""
    lo, hi = 0.0, 1.0
    for i in range(3):  # the part of the segment between each pair of faces
        if u[i] != 0.0:
            t0, t1 = (-h[i] - a[i]) / u[i], (h[i] - a[i]) / u[i]
            lo, hi = max(lo, min(t0, t1)), min(hi, max(t0, t1))
        elif abs(a[i]) > h[i]:
            lo = 2.0
    if lo > hi:
        lo, hi, t = 0.0, 1.0, 0.0
        g_lo, g_hi = 0.0, 0.0
        for k in range(8):  # the two ends, then the kinks: between the last two the slope is linear
            at = float(k) if k < 2 else 2.0
            if k > 1 and u[k // 2 - 1] != 0.0:
                at = ((1.0 if k % 2 else -1.0) * h[k // 2 - 1] - a[k // 2 - 1]) / u[k // 2 - 1]
            if k < 2 or lo < at < hi:
                g = _box_slope(at, a, u, h)
                if k == 0:
                    g_lo = g
                elif k == 1:
                    g_hi = g
                elif g < 0.0:
                    lo, g_lo = at, g
                else:
                    hi, g_hi = at, g
        if g_lo < 0.0:
            t = lo - g_lo * (hi - lo) / (g_hi - g_lo) if g_hi > 0.0 else 1.0
        x, y, z = a[0] + t * u[0], a[1] + t * u[1], a[2] + t * u[2]
        nx = math.copysign(max(abs(x) - h[0], 0.0), x)
        ny = math.copysign(max(abs(y) - h[1], 0.0), y)
        nz = math.copysign(max(abs(z) - h[2], 0.0), z)
        d = math.sqrt(nx * nx + ny * ny + nz * nz)
        if d > 0.0:
            return d, t, nx / d, ny / d, nz / d
    return _out_of_box(a, u, h)  # also where it touches within rounding


@inner
def _out_of_box(a, u, h):
    """Shortest translation of a segment out of a box it meets: over the face normals and the normals of edge x segment."""
    best, bt, bx, by, bz = np.inf, 0.0, 0.0, 0.0, 1.0
    for k in range(6):
        i = k % 3
        n = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        if k > 2:
            n = (n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0])
        length = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
        # an edge nearly parallel to the segment gives no direction of its own: the faces cover it to 1e-12
        if length > 1e-12 * (abs(u[0]) + abs(u[1]) + abs(u[2])):
            n = (n[0] / length, n[1] / length, n[2] / length)
            reach = abs(n[0]) * h[0] + abs(n[1]) * h[1] + abs(n[2]) * h[2]
            at = n[0] * a[0] + n[1] * a[1] + n[2] * a[2]
            along = n[0] * u[0] + n[1] * u[1] + n[2] * u[2] if k < 3 else 0.0
            for sign in (1.0, -1.0):
                depth = reach - min(sign * at, sign * (at + along))
                if depth < best:
                    best, bx, by, bz = depth, sign * n[0], sign * n[1], sign * n[2]
                    bt = 0.5 if along == 0.0 else (1.0 if sign * along < 0.0 else 0.0)
                    if k > 2:  # the point of the segment that slides over the edge: a + t u + depth n lies on it
                        along_edge, square = 0.0, 0.0
                        for c in range(3):
                            if c != i:
                                edge = math.copysign(h[c], sign * n[c]) - depth * sign * n[c]
                                along_edge += u[c] * (edge - a[c])
                                square += u[c] * u[c]
                        bt = clamp(along_edge / square)
    return -best, bt, bx, by, bz


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
    if kind == BOX:
        d, t, x, y, z = to_box(a, u, size)
    elif kind == CYLINDER:
        d, t, x, y, z = to_cylinder(a, u, size)
    else:
        d, t, x, y, z = to_ellipsoid(a, u, size)
    return (
        d,
        t,
        S[j, 6] * x + S[j, 9] * y + S[j, 12] * z,
        S[j, 7] * x + S[j, 10] * y + S[j, 13] * z,
        S[j, 8] * x + S[j, 11] * y + S[j, 14] * z,
    )
