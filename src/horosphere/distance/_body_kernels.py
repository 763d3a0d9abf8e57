"""A robot's capsules against solids and against each other: compiled code on scalars.

The robot comes as the arrays of `pack_robot`: only moving joints are left, each with its axis along z of its own frame, so
that placing a link costs one matrix product and one plane rotation. Rotation matrices, not motors: every frame carries many
points, and a point costs 9 products with a matrix.
  J (k, 3) int64: parent, kind (0 base, 1 revolute, 2 prismatic), index into q     C (k, 14): rotation (9), offset (3) from the
  parent's frame, multiplier, offset of the joint value
  L (m,) int64: frame of each capsule; -1: it hangs on the base and meets no solid
  K (m, 8): ends a, b, radius, radius of a ball about the middle that holds it
  P (p, 3) int64: pairs of capsules, and the frame both hang from
  F: what the rows S need beside them (`Packed.extra`), and which capsules (m) may touch which solids, or None: see `allowance`
  T (k, 12): world frames, rotation by rows and position      X (m, 8): world end a, vector b - a, reach of the
  motion, and what is added to distances from axes for their rounding
"""

from __future__ import annotations

import math

import numpy as np

from ..kernels import inner, jit
from ..shapes._segment_kernels import to_segment
from ._pair_kernels import segment_distance

REVOLUTE, PRISMATIC = 1, 2


@inner
def place(J, C, L, K, q, T, X):
    """World frames T and capsules X at the configuration q (n,)."""
    for k in range(J.shape[0]):
        kind, parent = J[k, 1], J[k, 0]
        value = C[k, 12] * q[J[k, 2]] + C[k, 13] if kind > 0 else 0.0
        c, s, slide = 1.0, 0.0, 0.0
        if kind == REVOLUTE:
            c, s = math.cos(value), math.sin(value)
        elif kind == PRISMATIC:
            slide = value
        for r in range(3):
            x, y, z, at = C[k, 3 * r], C[k, 3 * r + 1], C[k, 3 * r + 2], C[k, 9 + r]
            if parent >= 0:
                p0, p1, p2 = T[parent, 3 * r], T[parent, 3 * r + 1], T[parent, 3 * r + 2]
                x = p0 * C[k, 0] + p1 * C[k, 3] + p2 * C[k, 6]
                y = p0 * C[k, 1] + p1 * C[k, 4] + p2 * C[k, 7]
                z = p0 * C[k, 2] + p1 * C[k, 5] + p2 * C[k, 8]
                at = T[parent, 9 + r] + p0 * C[k, 9] + p1 * C[k, 10] + p2 * C[k, 11]
            T[k, 3 * r], T[k, 3 * r + 1], T[k, 3 * r + 2] = c * x + s * y, c * y - s * x, z
            T[k, 9 + r] = at + slide * z
    for i in range(L.shape[0]):
        k = max(L[i], 0)
        for r in range(3):
            p0, p1, p2 = T[k, 3 * r], T[k, 3 * r + 1], T[k, 3 * r + 2]
            X[i, r] = p0 * K[i, 0] + p1 * K[i, 1] + p2 * K[i, 2] + T[k, 9 + r]
            X[i, 3 + r] = p0 * (K[i, 3] - K[i, 0]) + p1 * (K[i, 4] - K[i, 1]) + p2 * (K[i, 5] - K[i, 2])
        X[i, 6] = 0.0


@inner
def reach(J, C, T, X, i, k, stop, h):
    """How far a point of capsule i's axis (frame k) can move against frame `stop` while coordinate c moves by at most h[c].

    From the tip down: a point turns about axis j on a circle whose radius is at most its distance to the axis now, plus what
    the joints beyond j can move it; the distance to a line is convex along the capsule, so its two ends decide.
    """
    moved = 0.0
    while k != stop and k > 0:
        rate = abs(C[k, 12]) * h[J[k, 2]]
        if rate > 0.0:
            if J[k, 1] == REVOLUTE:
                zx, zy, zz = T[k, 2], T[k, 5], T[k, 8]
                x, y, z = X[i, 0] - T[k, 9], X[i, 1] - T[k, 10], X[i, 2] - T[k, 11]
                cx, cy, cz = y * zz - z * zy, z * zx - x * zz, x * zy - y * zx
                far = cx * cx + cy * cy + cz * cz
                x, y, z = x + X[i, 3], y + X[i, 4], z + X[i, 5]
                cx, cy, cz = y * zz - z * zy, z * zx - x * zz, x * zy - y * zx
                far = max(far, cx * cx + cy * cy + cz * cz)
                moved += rate * (math.sqrt(far) + X[i, 7] + moved)
            else:
                moved += rate
        k = J[k, 0]
    return moved


@inner
def self_distance(K, X, i, j):
    """Signed distance of two capsules of the robot, the witness parameter on i, and the direction of increase for i."""
    d, t, nx, ny, nz = to_segment(
        X[i, 0], X[i, 1], X[i, 2], X[i, 3], X[i, 4], X[i, 5], X[j, 0], X[j, 1], X[j, 2], X[j, 3], X[j, 4], X[j, 5]
    )
    return d - K[i, 6] - K[j, 6], t, nx, ny, nz


@inner
def ignored(A, i, j):
    """Whether capsule i may touch solid j; A (capsules, solids) or None."""
    if A is None:
        return False
    return A[i, j]


@inner
def probe(J, C, L, K, S, P, q, h, need, T, X, F):
    """Clearance at q, and a lower bound of it while every coordinate c stays within h[c] of q[c].

    Returns (clearance, bound, item, other): the nearest capsule and solid (or m + the self pair) at q. Pairs whose bound
    reaches `need` are not looked at closer. Where nothing moves (h is empty), `need` falls with the clearance.
    """
    place(J, C, L, K, q, T, X)
    solids, moving, base = S.shape[0], h.shape[0] > 0, J[0, 0]
    clearance, bound, item, other = np.inf, np.inf, -1, -1
    for i in range(L.shape[0]):
        moved = reach(J, C, T, X, i, L[i], base, h) if moving else 0.0
        X[i, 6] = moved
        mx, my, mz = X[i, 0] + 0.5 * X[i, 3], X[i, 1] + 0.5 * X[i, 4], X[i, 2] + 0.5 * X[i, 5]
        for j in range(solids if L[i] >= 0 else 0):
            if ignored(F[2], i, j):
                continue
            x, y, z = mx - S[j, 1], my - S[j, 2], mz - S[j, 3]
            rough = math.sqrt(x * x + y * y + z * z) - K[i, 7] - S[j, 4] - moved
            if rough >= need:
                bound = min(bound, rough)
            else:
                # further away it makes no difference; what crosses a surface is always seen
                limit = max(K[i, 6] + max(need + moved, clearance), 1e-9)
                d = segment_distance(
                    S, j, X[i, 0], X[i, 1], X[i, 2], X[i, 3], X[i, 4], X[i, 5], F[0], F[1], limit
                )[0]  # fmt: skip
                seen = d < limit
                d -= K[i, 6]
                bound = min(bound, d - moved)
                if seen and d < clearance:
                    clearance, item, other = d, i, j
                    if not moving:
                        need = min(need, d)
    for p in range(P.shape[0]):
        i, j = P[p, 0], P[p, 1]
        x = X[i, 0] + 0.5 * X[i, 3] - X[j, 0] - 0.5 * X[j, 3]
        y = X[i, 1] + 0.5 * X[i, 4] - X[j, 1] - 0.5 * X[j, 4]
        z = X[i, 2] + 0.5 * X[i, 5] - X[j, 2] - 0.5 * X[j, 5]
        rough = math.sqrt(x * x + y * y + z * z) - K[i, 7] - K[j, 7] - X[i, 6] - X[j, 6]
        if rough >= need:
            bound = min(bound, rough)
        else:
            moved = 0.0
            if moving:  # only what lies between the two links counts
                moved = reach(J, C, T, X, i, L[i], P[p, 2], h) + reach(J, C, T, X, j, L[j], P[p, 2], h)
            d = self_distance(K, X, i, j)[0]
            bound = min(bound, d - moved)
            if d < clearance:
                clearance, item, other = d, i, solids + p
                if not moving:
                    need = min(need, d)
    return clearance, bound, item, other


@inner
def add_slope(J, C, T, k, x, y, z, nx, ny, nz, g):
    """Adds to g (n,) the derivative of n . x for the point x carried by frame k."""
    while k > 0:
        zx, zy, zz = T[k, 2], T[k, 5], T[k, 8]
        if J[k, 1] == REVOLUTE:
            px, py, pz = x - T[k, 9], y - T[k, 10], z - T[k, 11]
            slope = nx * (zy * pz - zz * py) + ny * (zz * px - zx * pz) + nz * (zx * py - zy * px)
        else:
            slope = nx * zx + ny * zy + nz * zz
        g[J[k, 2]] += C[k, 12] * slope
        k = J[k, 0]


@jit
def signed_batch(J, C, L, K, S, P, Q, D, G, F):
    """Least signed distance D (b,) of configurations Q (b, n), and its gradient G (b, n) if G has rows."""
    T, X, h = np.empty((J.shape[0], 12)), np.empty((L.shape[0], 8)), np.empty(0)
    for b in range(Q.shape[0]):
        D[b], _, i, j = probe(J, C, L, K, S, P, Q[b], h, np.inf, T, X, F)
        if G.shape[0] > 0:
            g = G[b]
            for c in range(g.shape[0]):
                g[c] = 0.0
            if i >= 0:
                other = -1
                if j < S.shape[0]:
                    d, t, nx, ny, nz = segment_distance(
                        S, j, X[i, 0], X[i, 1], X[i, 2], X[i, 3], X[i, 4], X[i, 5], F[0], F[1]
                    )
                else:
                    other = P[j - S.shape[0], 1]
                    d, t, nx, ny, nz = self_distance(K, X, i, other)
                x, y, z = X[i, 0] + t * X[i, 3], X[i, 1] + t * X[i, 4], X[i, 2] + t * X[i, 5]
                add_slope(J, C, T, L[i], x, y, z, nx, ny, nz, g)
                if other >= 0:  # the other witness, carried the other way
                    d += K[i, 6] + K[other, 6]
                    add_slope(J, C, T, L[other], x - d * nx, y - d * ny, z - d * nz, -nx, -ny, -nz, g)


@jit
def table_into(J, C, L, K, S, P, q, W, F):
    """Every capsule against every solid, then every self pair: W (m s + p, 7) = distance, point on the axis, direction."""
    T, X = np.empty((J.shape[0], 12)), np.empty((L.shape[0], 8))
    place(J, C, L, K, q, T, X)
    solids = S.shape[0]
    for row in range(W.shape[0]):
        p = row - L.shape[0] * solids
        if p < 0:
            i, j = row // solids, row % solids
            if L[i] < 0 or ignored(F[2], i, j):
                W[row] = 0.0
                W[row, 0] = np.inf
                continue
            d, t, nx, ny, nz = segment_distance(S, j, X[i, 0], X[i, 1], X[i, 2], X[i, 3], X[i, 4], X[i, 5], F[0], F[1])
            d -= K[i, 6]
        else:
            i = P[p, 0]
            d, t, nx, ny, nz = self_distance(K, X, i, P[p, 1])
        W[row, 0] = d
        for r in range(3):
            W[row, 1 + r] = X[i, r] + t * X[i, 3 + r]
        W[row, 4], W[row, 5], W[row, 6] = nx, ny, nz
