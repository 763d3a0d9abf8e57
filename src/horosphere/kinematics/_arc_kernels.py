"""What pieces of a redundancy's branch clear, judged over the whole tube that holds them: compiled code.

J, C, L, K, S, P, F, T, X: see distance/_body_kernels.py; the tube: `_tube_kernels.enclose`.
"""

from __future__ import annotations

import math

import numpy as np

from ..distance._body_kernels import ignored, place, self_distance
from ..distance._pair_kernels import segment_distance
from ..kernels import inner, jit
from ._tube_kernels import CROSSING, INSIDE

FREE, BLOCKED = 4, 5


@inner
def cross(ax, ay, az, bx, by, bz):
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@inner
def drift(J, C, T, X, i, k, stop, step, r):
    """How far a point of capsule i's axis (frame k) can move against frame `stop` while q leaves the middle by s step + y,
    |s| <= 1, |y| <= r.

    The first order along `step` exactly, since the joints of a redundant motion largely undo each other; the second by the
    levers: |d2x / dq_i dq_j| is at most that of the outer joint.
    """
    ax, ay, az = X[i, 0], X[i, 1], X[i, 2]
    ex, ey, ez = ax + X[i, 3], ay + X[i, 4], az + X[i, 5]
    ux, uy, uz, vx, vy, vz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    moved, second, levers = 0.0, 0.0, 0.0
    while k != stop and k > 0:
        rate = C[k, 12]
        f, z = rate * step[J[k, 2]], abs(rate) * (abs(step[J[k, 2]]) + r)
        wx, wy, wz = T[k, 2], T[k, 5], T[k, 8]
        px, py, pz, sx, sy, sz, lever = wx, wy, wz, wx, wy, wz, 1.0
        if J[k, 1] == 1:
            px, py, pz = cross(wx, wy, wz, ax - T[k, 9], ay - T[k, 10], az - T[k, 11])
            sx, sy, sz = cross(wx, wy, wz, ex - T[k, 9], ey - T[k, 10], ez - T[k, 11])
            lever = math.sqrt(max(px * px + py * py + pz * pz, sx * sx + sy * sy + sz * sz))
        ux, uy, uz, vx, vy, vz = ux + f * px, uy + f * py, uz + f * pz, vx + f * sx, vy + f * sy, vz + f * sz
        lever += moved  # in any posture of the tube
        second += z * (z * lever + 2.0 * moved)
        levers += (rate * lever) ** 2
        moved += z * lever
        k = J[k, 0]
    first = math.sqrt(max(ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz))
    return min(first + r * math.sqrt(levers) + 0.5 * second, moved)


@jit
def judge(J, C, L, K, S, P, F, need, own, middle, half, reach, state):
    """Makes pieces BLOCKED where one pair is nearer than wanted all along, and those INSIDE the limits FREE where none is anywhere.

    need, own: metres wanted from solids, and between self pairs. Pieces that are neither INSIDE nor CROSSING are left alone.
    """
    T, X = np.empty((J.shape[0], 12)), np.empty((L.shape[0], 7))
    for b in range(state.shape[0]):
        if state[b] != INSIDE and state[b] != CROSSING:
            continue
        step, r = half[b], reach[b]
        place(J, C, L, K, middle[b], T, X)
        free, blocked = state[b] == INSIDE, False
        for i in range(L.shape[0]):
            moved = drift(J, C, T, X, i, L[i], J[0, 0], step, r)
            X[i, 6] = moved
            mx, my, mz = X[i, 0] + 0.5 * X[i, 3], X[i, 1] + 0.5 * X[i, 4], X[i, 2] + 0.5 * X[i, 5]
            for j in range(S.shape[0] if L[i] >= 0 and not blocked else 0):
                x, y, z = mx - S[j, 1], my - S[j, 2], mz - S[j, 3]
                near = K[i, 7] + S[j, 4] + moved + need
                if near <= 0.0 or x * x + y * y + z * z >= near * near or ignored(F[2], i, j):
                    continue
                limit = max(K[i, 6] + need + moved, 1e-9)  # further away it makes no difference
                d = segment_distance(
                    S, j, X[i, 0], X[i, 1], X[i, 2], X[i, 3], X[i, 4], X[i, 5], F[0], F[1], limit
                )[0]  # fmt: skip
                if d >= limit:
                    continue
                d -= K[i, 6]
                if d - moved < need:
                    free = False
                    if d + moved < need:
                        blocked = True
                        break
        for p in range(0 if blocked else P.shape[0]):
            i, j = P[p, 0], P[p, 1]
            x = X[i, 0] + 0.5 * X[i, 3] - X[j, 0] - 0.5 * X[j, 3]
            y = X[i, 1] + 0.5 * X[i, 4] - X[j, 1] - 0.5 * X[j, 4]
            z = X[i, 2] + 0.5 * X[i, 5] - X[j, 2] - 0.5 * X[j, 5]
            near = K[i, 7] + K[j, 7] + X[i, 6] + X[j, 6] + own
            if near <= 0.0 or x * x + y * y + z * z >= near * near:
                continue
            # only what lies between the two links counts
            moved = drift(J, C, T, X, i, L[i], P[p, 2], step, r) + drift(J, C, T, X, j, L[j], P[p, 2], step, r)
            d = self_distance(K, X, i, j)[0]
            if d - moved < own:
                free = False
                if d + moved < own:
                    blocked = True
                    break
        if blocked:
            state[b] = BLOCKED
        elif free:
            state[b] = FREE
