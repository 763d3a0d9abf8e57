"""Segments against point clouds and meshes, through a tree of balls: compiled code on scalars.

The arrays are those of `_forest.Forest`; numbers of a row of `pack`:
  6 first node, 7 number of leaves, 8 first entry of `ends`, 9: 0 a surface, 1 a solid, 2 a convex solid,
  3 a solid whose surface may cross itself
  10, 11 first and last + 1 of its triangles or balls, 12-17 the corners of its box
A triangle (34): corners 0-8, unit normal 9-11 (zero if the corners lie in a line: only its edges count), sums of the normals at
its edges 12-20 (the edge after corner k at 12 + 3 k), sums of the normals at its corners weighted by angles 21-29, a ball round
it 30-33. A ball (4): centre, radius.
Node i of a tree with k leaves has the children 2 i + 1 and 2 i + 2; nodes k - 1 .. 2 k - 2 are the leaves.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from ..kernels import inner, jit
from ._segment_kernels import clamp, closest_parameters, unit_normal_to
from ._winding_kernels import winds_round

# as `inner`, with arrays of its own; said aloud, since numba hands down the flag of the caller
allocating = partial(jit, _nrt=True, part=True)

DEPTH = 64
SAMPLES = 33
"""Points of a segment at which the depth in a solid that is not convex is looked at, before the deepest is refined."""
TOUCHING = 1e-13
"""Metres below which a segment counts as crossing a triangle."""


@inner
def _gap(ax, ay, az, ux, uy, uz, uu, x, y, z):
    """Distance of a segment to a point, and its parameter."""
    dx, dy, dz = x - ax, y - ay, z - az
    t = clamp((dx * ux + dy * uy + dz * uz) / uu) if uu > 0.0 else 0.0
    dx, dy, dz = dx - t * ux, dy - t * uy, dz - t * uz
    return math.sqrt(dx * dx + dy * dy + dz * dz), t


@allocating
def to_cloud(S, j, nodes, ends, balls, ax, ay, az, ux, uy, uz, limit):
    """Distance of a segment to the nearest ball of a cloud, as in `segment_distance`; `limit` or more if none is nearer."""
    uu = ux * ux + uy * uy + uz * uz
    root, leaves, first = int(S[j, 6]), int(S[j, 7]), int(S[j, 8])
    stack, known = np.empty(DEPTH, np.int64), np.empty(DEPTH)
    stack[0], known[0], top = 0, -np.inf, 0
    best, best_t, item = limit, 0.0, -1
    while top >= 0:
        node, bound = stack[top], known[top]
        top -= 1
        if bound >= best:
            continue
        if node >= leaves - 1:
            leaf = first + node - leaves + 1
            for k in range(ends[leaf], ends[leaf + 1]):
                d, t = _gap(ax, ay, az, ux, uy, uz, uu, balls[k, 0], balls[k, 1], balls[k, 2])
                if d - balls[k, 3] < best:
                    best, best_t, item = d - balls[k, 3], t, k
            continue
        top = _push(nodes, root, node, ax, ay, az, ux, uy, uz, uu, best, stack, known, top)
    if item < 0:
        return best, 0.0, 0.0, 0.0, 1.0
    x = ax + best_t * ux - balls[item, 0]
    y = ay + best_t * uy - balls[item, 1]
    z = az + best_t * uz - balls[item, 2]
    length = math.sqrt(x * x + y * y + z * z)
    if length > 0.0:
        return best, best_t, x / length, y / length, z / length
    x, y, z = unit_normal_to(ux, uy, uz)
    return best, best_t, x, y, z


@inner
def _push(nodes, root, node, ax, ay, az, ux, uy, uz, uu, best, stack, known, top):
    """Puts the children that can hold something nearer than `best` on the stack, the nearer one on top."""
    left, right = 2 * node + 1, 2 * node + 2
    a, b = root + left, root + right
    to_left = _gap(ax, ay, az, ux, uy, uz, uu, nodes[a, 0], nodes[a, 1], nodes[a, 2])[0] - nodes[a, 3]
    to_right = _gap(ax, ay, az, ux, uy, uz, uu, nodes[b, 0], nodes[b, 1], nodes[b, 2])[0] - nodes[b, 3]
    if to_left > to_right:
        left, right, to_left, to_right = right, left, to_right, to_left
    if to_right < best:
        top += 1
        stack[top], known[top] = right, to_right
    if to_left < best:
        top += 1
        stack[top], known[top] = left, to_left
    return top


@inner
def _point_in_prism(T, k, x, y, z):
    """Whether the foot of a point in the plane of triangle k lies in the triangle."""
    for c in range(3):
        p, q = 3 * c, 3 * ((c + 1) % 3)
        ex, ey, ez = T[k, q] - T[k, p], T[k, q + 1] - T[k, p + 1], T[k, q + 2] - T[k, p + 2]
        dx, dy, dz = x - T[k, p], y - T[k, p + 1], z - T[k, p + 2]
        across = T[k, 9] * (ey * dz - ez * dy) + T[k, 10] * (ez * dx - ex * dz) + T[k, 11] * (ex * dy - ey * dx)
        if across < 0.0:
            return False
    return True


@inner
def _to_triangle(T, k, ax, ay, az, ux, uy, uz, best):
    """(distance, t, feature) of a segment to triangle k if it is less than `best`.

    Features: 0 the face, 1-3 edges, 4-6 corners. The nearest points lie on an edge, or below an end of the segment, or the
    segment goes through.
    """
    feature, best_t = -1, 0.0
    nx, ny, nz = T[k, 9], T[k, 10], T[k, 11]
    height = nx * (ax - T[k, 0]) + ny * (ay - T[k, 1]) + nz * (az - T[k, 2])
    rise = nx * ux + ny * uy + nz * uz
    lowest = 0.0 if height * (height + rise) < 0.0 else min(abs(height), abs(height + rise))
    if lowest >= best:
        return best, 0.0, -1
    flat = nx == 0.0 and ny == 0.0 and nz == 0.0
    if height * (height + rise) <= 0.0 and rise != 0.0:
        t = clamp(-height / rise)
        if _point_in_prism(T, k, ax + t * ux, ay + t * uy, az + t * uz):
            return 0.0, t, 0
    for end in range(0 if flat else 2):
        t = float(end)
        d = abs(height + t * rise)
        if d < best and _point_in_prism(T, k, ax + t * ux, ay + t * uy, az + t * uz):
            best, best_t, feature = d, t, 0
    for c in range(3):
        p, q = 3 * c, 3 * ((c + 1) % 3)
        ex, ey, ez = T[k, q] - T[k, p], T[k, q + 1] - T[k, p + 1], T[k, q + 2] - T[k, p + 2]
        wx, wy, wz = T[k, p] - ax, T[k, p + 1] - ay, T[k, p + 2] - az
        t, s = closest_parameters(ux, uy, uz, ex, ey, ez, wx, wy, wz)
        dx, dy, dz = t * ux - wx - s * ex, t * uy - wy - s * ey, t * uz - wz - s * ez
        d = math.sqrt(dx * dx + dy * dy + dz * dz)
        if d < best:
            best, best_t = d, t
            feature = 1 + c if 0.0 < s < 1.0 else (4 + c if s <= 0.0 else 4 + (c + 1) % 3)
    return best, best_t, feature


@allocating
def _nearest(S, j, nodes, ends, T, ax, ay, az, ux, uy, uz, limit):
    """(distance, t, triangle, feature) of a segment to the surface; triangle -1 if none is nearer than `limit`."""
    uu = ux * ux + uy * uy + uz * uz
    root, leaves, first = int(S[j, 6]), int(S[j, 7]), int(S[j, 8])
    stack, known = np.empty(DEPTH, np.int64), np.empty(DEPTH)
    stack[0], known[0], top = 0, -np.inf, 0
    best, best_t, item, feature = limit, 0.0, -1, 0
    while top >= 0 and best > 0.0:
        node, bound = stack[top], known[top]
        top -= 1
        if bound >= best:
            continue
        if node >= leaves - 1:
            leaf = first + node - leaves + 1
            for k in range(ends[leaf], ends[leaf + 1]):
                rough = _gap(ax, ay, az, ux, uy, uz, uu, T[k, 30], T[k, 31], T[k, 32])[0] - T[k, 33]
                if rough < best:
                    d, t, f = _to_triangle(T, k, ax, ay, az, ux, uy, uz, best)
                    if f >= 0:
                        best, best_t, item, feature = d, t, k, f
            continue
        top = _push(nodes, root, node, ax, ay, az, ux, uy, uz, uu, best, stack, known, top)
    return best, best_t, item, feature


@inner
def _foot(T, k, feature, x, y, z):
    """The point of a feature of triangle k that is nearest to x."""
    if feature == 0:
        h = T[k, 9] * (x - T[k, 0]) + T[k, 10] * (y - T[k, 1]) + T[k, 11] * (z - T[k, 2])
        return x - h * T[k, 9], y - h * T[k, 10], z - h * T[k, 11]
    if feature > 3:
        p = 3 * (feature - 4)
        return T[k, p], T[k, p + 1], T[k, p + 2]
    p, q = 3 * (feature - 1), 3 * (feature % 3)
    ex, ey, ez = T[k, q] - T[k, p], T[k, q + 1] - T[k, p + 1], T[k, q + 2] - T[k, p + 2]
    s = (ex * (x - T[k, p]) + ey * (y - T[k, p + 1]) + ez * (z - T[k, p + 2])) / (ex * ex + ey * ey + ez * ez)
    return T[k, p] + s * ex, T[k, p + 1] + s * ey, T[k, p + 2] + s * ez


@inner
def _within(S, j, nodes, ends, T, k, feature, x, y, z, dx, dy, dz):
    """Whether x lies in a solid; its nearest point on the surface lies on this feature of triangle k, at x - d.

    By the face's normal, or the sum of the normals round an edge or corner (weighted by their angles); of a surface that crosses
    itself by its winding number. Source: Baerentzen and Aanaes 2005, signed distance computation using the angle weighted
    pseudonormal; their proof wants a surface that does not cross itself.
    """
    if S[j, 9] == 0.0:
        return False
    if S[j, 9] == 3.0:
        return winds_round(S, j, nodes, ends, T, x, y, z)
    c = 9 + 3 * feature
    return dx * T[k, c] + dy * T[k, c + 1] + dz * T[k, c + 2] < 0.0


@inner
def _point(S, j, nodes, ends, T, x, y, z, limit):
    """Signed distance of a point to a solid and the direction of increase; `limit` or more if nothing is nearer."""
    d, _, k, feature = _nearest(S, j, nodes, ends, T, x, y, z, 0.0, 0.0, 0.0, limit)
    if k < 0:
        return d, 0.0, 0.0, 1.0
    fx, fy, fz = _foot(T, k, feature, x, y, z)
    dx, dy, dz = x - fx, y - fy, z - fz
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    if length <= TOUCHING:
        return 0.0, T[k, 9], T[k, 10], T[k, 11]
    sign = -1.0 if _within(S, j, nodes, ends, T, k, feature, x, y, z, dx, dy, dz) else 1.0
    return sign * length, sign * dx / length, sign * dy / length, sign * dz / length


@inner
def to_mesh(S, j, nodes, ends, T, ax, ay, az, ux, uy, uz, limit):
    """Distance of a segment to a mesh, as in `segment_distance`; `limit` or more if it is no nearer.

    Apart: exact. Within a convex solid: minus the shortest translation out; within another: minus the greatest depth of a
    point of the segment that was found; a surface alone (not closed): 0 where it is crossed.
    """
    solid = S[j, 9] > 0.0
    if solid:  # only what lies outside the box cannot lie deep inside without coming near the surface
        mx, my, mz = ax + 0.5 * ux, ay + 0.5 * uy, az + 0.5 * uz
        if S[j, 12] <= mx <= S[j, 15] and S[j, 13] <= my <= S[j, 16] and S[j, 14] <= mz <= S[j, 17]:
            limit = np.inf
    d, t, k, feature = _nearest(S, j, nodes, ends, T, ax, ay, az, ux, uy, uz, limit)
    if k < 0:
        return d, 0.0, 0.0, 0.0, 1.0
    if d > TOUCHING:
        x, y, z = ax + t * ux, ay + t * uy, az + t * uz
        fx, fy, fz = _foot(T, k, feature, x, y, z)
        dx, dy, dz = x - fx, y - fy, z - fz
        if not _within(S, j, nodes, ends, T, k, feature, x, y, z, dx, dy, dz):
            length = math.sqrt(dx * dx + dy * dy + dz * dz)
            return d, t, dx / length, dy / length, dz / length
    elif not solid:
        return 0.0, t, T[k, 9], T[k, 10], T[k, 11]
    if S[j, 9] == 2.0:
        return _out_of_convex(S, j, T, ax, ay, az, ux, uy, uz)
    return _deepest(S, j, nodes, ends, T, ax, ay, az, ux, uy, uz, t)


@inner
def _out_of_convex(S, j, T, ax, ay, az, ux, uy, uz):
    """Shortest translation of a segment out of a convex polytope: over the normals of faces and of edge x segment."""
    best, bt, bx, by, bz = np.inf, 0.0, 0.0, 0.0, 1.0
    uu = ux * ux + uy * uy + uz * uz
    for k in range(int(S[j, 10]), int(S[j, 11])):
        nx, ny, nz = T[k, 9], T[k, 10], T[k, 11]
        if nx == 0.0 and ny == 0.0 and nz == 0.0:
            continue
        rise = nx * ux + ny * uy + nz * uz
        depth = nx * (T[k, 0] - ax) + ny * (T[k, 1] - ay) + nz * (T[k, 2] - az) - min(rise, 0.0)
        if depth < best:
            best, bx, by, bz = depth, nx, ny, nz
            bt = 0.5 if rise == 0.0 else (1.0 if rise < 0.0 else 0.0)
        for c in range(3):
            # the other face at this edge; only edges on the outline seen along the segment have a normal of their own
            mx, my, mz = T[k, 12 + 3 * c] - nx, T[k, 13 + 3 * c] - ny, T[k, 14 + 3 * c] - nz
            if uu == 0.0 or rise * (mx * ux + my * uy + mz * uz) >= 0.0:
                continue
            p, q = 3 * c, 3 * ((c + 1) % 3)
            ex, ey, ez = T[k, q] - T[k, p], T[k, q + 1] - T[k, p + 1], T[k, q + 2] - T[k, p + 2]
            vx, vy, vz = ey * uz - ez * uy, ez * ux - ex * uz, ex * uy - ey * ux
            length = math.sqrt(vx * vx + vy * vy + vz * vz)
            if length <= 1e-12 * math.sqrt(uu):
                continue
            if vx * (nx + mx) + vy * (ny + my) + vz * (nz + mz) < 0.0:
                length = -length
            vx, vy, vz = vx / length, vy / length, vz / length
            depth = vx * (T[k, p] - ax) + vy * (T[k, p + 1] - ay) + vz * (T[k, p + 2] - az)
            if depth < best:
                best, bx, by, bz = depth, vx, vy, vz
                wx, wy, wz = T[k, p] - ax - depth * vx, T[k, p + 1] - ay - depth * vy, T[k, p + 2] - az - depth * vz
                bt = closest_parameters(ux, uy, uz, ex, ey, ez, wx, wy, wz)[0]
    return -best, bt, bx, by, bz


@inner
def _deepest(S, j, nodes, ends, T, ax, ay, az, ux, uy, uz, first):
    """The point of a segment that is deepest in a solid: looked for at even distances and at `first`, then refined."""
    best, bt = _point(S, j, nodes, ends, T, ax + first * ux, ay + first * uy, az + first * uz, np.inf)[0], first
    moves = ux != 0.0 or uy != 0.0 or uz != 0.0
    for i in range(SAMPLES if moves else 0):
        t = i / (SAMPLES - 1.0)
        d = _point(S, j, nodes, ends, T, ax + t * ux, ay + t * uy, az + t * uz, np.inf)[0]
        if d < best:
            best, bt = d, t
    step = 1.0 / (SAMPLES - 1.0)
    while moves and step > 1e-9:
        step *= 0.5
        for side in range(2):
            t = clamp(bt + (step if side else -step))
            d = _point(S, j, nodes, ends, T, ax + t * ux, ay + t * uy, az + t * uz, np.inf)[0]
            if d < best:
                best, bt = d, t
    d, nx, ny, nz = _point(S, j, nodes, ends, T, ax + bt * ux, ay + bt * uy, az + bt * uz, np.inf)
    if moves and 0.0 < bt < 1.0:  # where two faces are equally near, the deepest point slides: what stays is across u
        t = min(bt + 1e-7, 1.0)
        _, nx, ny, nz = _point(S, j, nodes, ends, T, ax + t * ux, ay + t * uy, az + t * uz, np.inf)
        t = max(bt - 1e-7, 0.0)
        _, mx, my, mz = _point(S, j, nodes, ends, T, ax + t * ux, ay + t * uy, az + t * uz, np.inf)
        after, before = nx * ux + ny * uy + nz * uz, mx * ux + my * uy + mz * uz
        share = after / (after - before) if after > 0.0 > before else 0.0
        nx, ny, nz = nx + share * (mx - nx), ny + share * (my - ny), nz + share * (mz - nz)
    return min(d, 0.0), bt, nx, ny, nz
