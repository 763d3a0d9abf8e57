"""Solids on lanes: squared distances of points to solids, float32, and the packing of a scene.

Every square is that of the distance from the solid, zero inside; a ball of radius r touches it where square < r^2.
"""

from __future__ import annotations

import math

import numpy as np

from ..kernels import absolute, inner, kernel, maximum, minimum, scalars, sqrt

BOX, CAPSULE, CYLINDER, ELLIPSOID, HALF_SPACE = 0, 1, 2, 3, 4


@kernel(1, p=scalars(3), row=scalars(8))
def upright_square(p, row):
    """Box with two vertical faces pairs: centre, direction (ux, uy) of its first axis, half sizes."""
    cx, cy, cz, ux, uy, ha, hb, hc = row
    x, y, z = p[0] - cx, p[1] - cy, p[2] - cz
    a = maximum(absolute(ux * x + uy * y) - ha, 0.0)
    b = maximum(absolute(ux * y - uy * x) - hb, 0.0)
    c = maximum(absolute(z) - hc, 0.0)
    return [a * a + b * b + c * c]


@kernel(1, p=scalars(3), row=scalars(16))
def box_square(p, row):
    """Box: centre, axes (rows), half sizes."""
    d = [p[k] - row[k] for k in range(3)]
    total = 0.0
    for k in range(3):
        along = sum((row[3 + 3 * k + j] * d[j] for j in range(1, 3)), row[3 + 3 * k] * d[0])
        excess = maximum(absolute(along) - row[12 + k], 0.0)
        total = total + excess * excess
    return [total]


@kernel(1, p=scalars(3), row=scalars(8))
def segment_square(p, row):
    """Segment: centre, unit direction, half length, (radius: for the caller)."""
    d = [p[k] - row[k] for k in range(3)]
    t = row[3] * d[0] + row[4] * d[1] + row[5] * d[2]
    t = maximum(minimum(t, row[6]), -row[6])
    w = [d[k] - t * row[3 + k] for k in range(3)]
    return [w[0] * w[0] + w[1] * w[1] + w[2] * w[2]]


@kernel(1, p=scalars(3), row=scalars(8))
def cylinder_square(p, row):
    """Cylinder: centre, unit axis, half length, radius."""
    d = [p[k] - row[k] for k in range(3)]
    t = row[3] * d[0] + row[4] * d[1] + row[5] * d[2]
    w = [d[k] - t * row[3 + k] for k in range(3)]
    a = maximum(sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) - row[7], 0.0)
    b = maximum(absolute(t) - row[6], 0.0)
    return [a * a + b * b]


ELLIPSOID_STEPS = 5


@kernel(1, p=scalars(3), row=scalars(16))
def ellipsoid_square(p, row):
    """Ellipsoid: centre, axes (rows), squared semi-axes: a lower bound of the square, close to it.

    |x - y|^2 over sum y_k^2 / s_k^2 <= 1 is at least t (sum x_k^2 / (t + s_k^2) - 1) for every t >= 0 (Lagrange's dual); the
    derivative's zero is approached by Newton's method from below. However far it gets, the bound holds.
    """
    d = [p[k] - row[k] for k in range(3)]
    squares = []
    for k in range(3):
        along = sum((row[3 + 3 * k + j] * d[j] for j in range(1, 3)), row[3 + 3 * k] * d[0])
        squares.append(along * along)
    s = [row[12 + k] for k in range(3)]
    # g(t) = sum s x^2 / (t + s)^2 - 1 is convex and falling: Newton from the left never overshoots
    norm = squares[0] * s[0] + squares[1] * s[1] + squares[2] * s[2]
    largest = maximum(maximum(s[0], s[1]), s[2])
    t = maximum(sqrt(norm) - largest, 0.0)
    for k in range(3):
        t = maximum(t, sqrt(squares[k] * s[k]) - s[k])
    for _ in range(ELLIPSOID_STEPS):
        value, slope = -1.0, 0.0
        for k in range(3):
            inverse = 1.0 / (t + s[k])
            part = squares[k] * s[k] * inverse * inverse
            value = value + part
            slope = slope + part * inverse
        t = maximum(t + 0.5 * value / maximum(slope, 1e-20), 0.0)
    total = -1.0 - 1e-6  # rounding must not raise the bound
    for k in range(3):
        total = total + squares[k] / (t + s[k])
    return [maximum(t * total, 0.0)]


@inner
def _square_of(row, x, y, z):
    """Squared distance of a point to a packed solid, float64."""
    dx, dy, dz = x - row[1], y - row[2], z - row[3]
    a = row[4] * dx + row[5] * dy + row[6] * dz
    kind = int(row[0])
    if kind == CAPSULE or kind == CYLINDER:  # noqa: SIM109 (a tuple takes long to compile)
        t = max(abs(a) - row[13], 0.0)
        across = dx * dx + dy * dy + dz * dz - a * a
        if kind == CYLINDER:
            r = max(math.sqrt(max(across, 0.0)) - row[14], 0.0)
            return t * t + r * r
        r = max(math.sqrt(max(across, 0.0) + t * t) - row[14], 0.0)
        return r * r
    b = row[7] * dx + row[8] * dy + row[9] * dz
    c = row[10] * dx + row[11] * dy + row[12] * dz
    a, b, c = max(abs(a) - row[13], 0.0), max(abs(b) - row[14], 0.0), max(abs(c) - row[15], 0.0)
    return a * a + b * b + c * c  # of an ellipsoid: to the box around it


@inner
def sort_solids(m, margin, scene, world):
    """Fills `world` from the first m solids of the scene; returns the largest coordinate that matters.

        scene = (rows, root, spans, allowed, near, kinds, order, count)

        rows (m, 16), in float64, overwritten: kind, centre, three axes (rows; of a capsule, cylinder or half-space the first
        only), three sizes (box: half sizes; ellipsoid: semi-axes; capsule, cylinder: half length, radius; half-space: distance).
        root (3,): a point that does not move; spans (C,): no point of body c is ever further from it. Solids further than every
    span are dropped.
        allowed (C, m) or empty: body c may touch solid i; such solids come first, and `reach` gets their bits (of the first 63
        of a kind; others are kept clear of).
        `count` (5,): how many there are in each list; near, kinds, order (m,): working memory.
    """
    rows, root, spans, allowed, near, kinds, order, count = scene
    upright, boxes, cylinders, capsules, ellipsoids, reach = world
    for k in range(5):
        count[k] = 0
    for g in range(spans.shape[0]):
        for k in range(10):
            reach[g, k] = 0
    longest = 0.0
    for g in range(spans.shape[0]):
        longest = max(longest, spans[g])
    extent = 0.0
    for i in range(m):
        row = rows[i]
        kind = int(row[0])
        if kind == HALF_SPACE:  # a box that fills it as far as the robot reaches
            nx, ny, nz, distance = row[4], row[5], row[6], row[13]
            size = 2.0 * (longest + margin) + 1.0
            foot = distance - (nx * root[0] + ny * root[1] + nz * root[2])  # height of the face over the root
            below = size + max(foot, 0.0)
            if abs(nx) < 0.6:
                ux, uy, uz = 0.0, nz, -ny
            else:
                ux, uy, uz = -nz, 0.0, nx
            length = math.sqrt(ux * ux + uy * uy + uz * uz)
            ux, uy, uz = ux / length, uy / length, uz / length
            depth = foot - 0.5 * below
            row[0], row[1], row[2], row[3] = BOX, root[0] + depth * nx, root[1] + depth * ny, root[2] + depth * nz
            row[7], row[8], row[9] = ux, uy, uz
            row[10], row[11], row[12] = ny * uz - nz * uy, nz * ux - nx * uz, nx * uy - ny * ux
            row[13], row[14], row[15] = 0.5 * below, size, size
            kind = BOX
        near[i] = math.sqrt(_square_of(row, root[0], root[1], root[2])) - margin
        for g in range(allowed.shape[0]):
            if allowed[g, i]:
                near[i] = min(near[i], -1e9)
        if kind == BOX:
            for k in range(3):  # an upright box is turned so that its last axis is vertical
                if abs(row[6 + 3 * k]) > 1.0 - 1e-14:
                    for j in range(3):
                        row[4 + 3 * k + j], row[10 + j] = row[10 + j], row[4 + 3 * k + j]
                    row[13 + k], row[15] = row[15], row[13 + k]
                    break
            kinds[i] = 0 if abs(row[12]) > 1.0 - 1e-14 else 1
        else:
            kinds[i] = 2 if kind == CYLINDER else 3 if kind == CAPSULE else 4
        if near[i] > longest:
            kinds[i] = -1
        else:
            count[kinds[i]] += 1
            for k in range(3):
                extent = max(extent, abs(row[1 + k]) + row[13] + row[14] + row[15])
    for i in range(m):
        order[i] = i
    gap = m // 2
    while gap > 0:  # Shell's sort; numpy's takes longer to compile than all the rest
        for i in range(gap, m):
            item, k = order[i], i
            while k >= gap and near[order[k - gap]] > near[item]:
                order[k] = order[k - gap]
                k -= gap
            order[k] = item
        gap = 1 if gap == 2 else int(gap / 2.2)
    for k in range(5):
        count[k] = 0
    for rank in range(m):
        i = order[rank]
        kind = kinds[i]
        if kind < 0:
            continue
        k = count[kind]
        row = rows[i]
        if kind == 0:
            for j in range(3):
                upright[k, j], upright[k, 5 + j] = row[1 + j], row[13 + j]
            upright[k, 3], upright[k, 4] = row[4], row[5]
        elif kind == 2 or kind == 3:
            axial = cylinders if kind == 2 else capsules
            for j in range(6):
                axial[k, j] = row[1 + j]
            axial[k, 6], axial[k, 7] = row[13], row[14]
        else:
            target = boxes if kind == 1 else ellipsoids
            for j in range(15):
                target[k, j] = row[1 + j]
            target[k, 15] = 0.0
            if kind == 4:
                for j in range(3):
                    target[k, 12 + j] = row[13 + j] * row[13 + j]
        for g in range(allowed.shape[0]):
            if allowed[g, i] and k < 63:
                reach[g, 5 + kind] |= np.int64(1) << k
        count[kind] += 1
        for g in range(spans.shape[0]):
            if near[i] <= spans[g]:
                reach[g, kind] = count[kind]
    return extent
