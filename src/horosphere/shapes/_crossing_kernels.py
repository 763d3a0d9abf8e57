"""Whether a closed surface crosses itself: compiled code on the trees of `_tree_kernels`."""

from __future__ import annotations

import numpy as np

from ..kernels import jit
from ._tree_kernels import DEPTH, _push, _to_triangle


@jit(_nrt=True)
def crosses_itself(nodes, ends, T, nearness):
    """Whether an edge comes nearer than `nearness` to a triangle with which it shares no corner, or a face lies on its neighbour.

    Two triangles that meet in more than they share do so at an edge of one of them that shares no corner with the other, or have
    an edge in common and are folded together there.
    """
    leaves = ends.shape[0] - 1
    stack, known = np.empty(DEPTH, np.int64), np.empty(DEPTH)
    for k in range(T.shape[0]):
        for c in range(3):
            p, q, n = 3 * c, 3 * ((c + 1) % 3), 12 + 3 * c
            if T[k, n] ** 2 + T[k, n + 1] ** 2 + T[k, n + 2] ** 2 < 1e-12:
                return True
            ax, ay, az, bx, by, bz = T[k, p], T[k, p + 1], T[k, p + 2], T[k, q], T[k, q + 1], T[k, q + 2]
            if (ax, ay, az) > (bx, by, bz):
                continue  # the neighbour's turn
            ux, uy, uz = bx - ax, by - ay, bz - az
            uu = ux * ux + uy * uy + uz * uz
            stack[0], known[0], top = 0, -np.inf, 0
            while top >= 0:
                node = stack[top]
                top -= 1
                if node < leaves - 1:
                    top = _push(nodes, 0, node, ax, ay, az, ux, uy, uz, uu, nearness, stack, known, top)
                    continue
                leaf = node - leaves + 1
                for i in range(ends[leaf], ends[leaf + 1]):
                    shared = False
                    for s in range(0, 9, 3):
                        shared |= T[i, s] == ax and T[i, s + 1] == ay and T[i, s + 2] == az
                        shared |= T[i, s] == bx and T[i, s + 1] == by and T[i, s + 2] == bz
                    if not shared and _to_triangle(T, i, ax, ay, az, ux, uy, uz, nearness)[2] >= 0:
                        return True
    return False
