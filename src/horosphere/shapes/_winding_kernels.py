"""How often a closed surface winds round a point: compiled code on the trees of `_tree_kernels`."""

from __future__ import annotations

import math

import numpy as np

from ..kernels import inner, jit

RAYS = np.array(
    [[0.48, 0.36, 0.8], [-0.64, 0.6, 0.48], [0.36, -0.8, -0.48], [-0.28, -0.576, 0.768], [0.6, 0.64, -0.48]]
)
"""Unit vectors along which drawings seldom have edges; the next is taken where one meets an edge."""
UNSURE = 1e-14
"""Products of three vectors, over their lengths, whose sign may be wrong: rounding makes less than 10 units of them."""


@inner
def _crossing(T, k, x, y, z, dx, dy, dz):
    """How a ray from x meets triangle k: 0 not, 1 from behind, -1 from the front (its normal), 2 too near an edge to tell."""
    ax, ay, az = T[k, 0] - x, T[k, 1] - y, T[k, 2] - z
    bx, by, bz = T[k, 3] - x, T[k, 4] - y, T[k, 5] - z
    cx, cy, cz = T[k, 6] - x, T[k, 7] - y, T[k, 8] - z
    ux, uy, uz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    vx, vy, vz = cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax
    wx, wy, wz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    u, v, w = dx * ux + dy * uy + dz * uz, dx * vx + dy * vy + dz * vz, dx * wx + dy * wy + dz * wz
    a, b, c = (
        math.sqrt(ax * ax + ay * ay + az * az),
        math.sqrt(bx * bx + by * by + bz * bz),
        math.sqrt(cx * cx + cy * cy + cz * cz),
    )
    above = int(u > UNSURE * b * c) + int(v > UNSURE * c * a) + int(w > UNSURE * a * b)
    below = int(u < -UNSURE * b * c) + int(v < -UNSURE * c * a) + int(w < -UNSURE * a * b)
    if above > 0 and below > 0:
        return 0
    volume = (
        ax * ux + ay * uy + az * uz
    )  # of the tetrahedron from x, times six: with the sign of u, v, w if it lies ahead
    if above + below < 3 or abs(volume) <= UNSURE * a * b * c:
        return 2
    if above == 3:
        return 1 if volume > 0.0 else 0
    return -1 if volume < 0.0 else 0


@jit(_nrt=True, part=True)
def winds_round(S, j, nodes, ends, T, x, y, z):
    """Whether the winding number of a closed surface about a point is not zero; true where no ray can tell, on its edges.

    It is the number of times that a ray leaves through the surface less the times that it enters.
    """
    if not (S[j, 12] <= x <= S[j, 15] and S[j, 13] <= y <= S[j, 16] and S[j, 14] <= z <= S[j, 17]):
        return False
    root, leaves, first = int(S[j, 6]), int(S[j, 7]), int(S[j, 8])
    stack = np.empty(64, np.int64)
    for ray in range(RAYS.shape[0]):
        dx, dy, dz = RAYS[ray, 0], RAYS[ray, 1], RAYS[ray, 2]
        stack[0], top, number, sure = 0, 0, 0, True
        while top >= 0 and sure:
            node = stack[top]
            top -= 1
            r = nodes[root + node, 3]
            px, py, pz = nodes[root + node, 0] - x, nodes[root + node, 1] - y, nodes[root + node, 2] - z
            along = px * dx + py * dy + pz * dz
            px, py, pz = px - along * dx, py - along * dy, pz - along * dz
            if along < -r or px * px + py * py + pz * pz > r * r:
                continue
            if node < leaves - 1:
                stack[top + 1], stack[top + 2] = 2 * node + 1, 2 * node + 2
                top += 2
                continue
            leaf = first + node - leaves + 1
            for k in range(ends[leaf], ends[leaf + 1]):
                found = _crossing(T, k, x, y, z, dx, dy, dz)
                if found == 2:
                    sure = False
                    break
                number += found
        if sure:
            return number != 0
    return True
