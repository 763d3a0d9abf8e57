"""The velocity that a goal asks for: joints, the tool's pose or its position, and a posture in the null space: compiled code."""

from __future__ import annotations

import math

import numpy as np

from ..distance._body_kernels import inner
from ._reactive_motion_kernels import GAIN, POSTURE, SPEED, TINY, TIP, TURN, closing_speed


@inner
def wanted(J, C, T, par, goal, posture, tool, q, M, Jt, H, u):
    """The velocity towards the goal, within the velocity limits; returns the error (m or rad, joint units for joints)."""
    n, gain, error, angle = q.shape[0], par[GAIN], 0.0, 0.0
    if goal[0] == 0.0:
        scale = gain
        for c in range(n):
            u[c] = goal[1 + c] - q[c]
            size = abs(u[c])
            error = max(error, size)
            if size > 0.0:
                scale = min(scale, min(M[2, c], closing_speed(size, 0.8 * M[3, c], gain)) / size)
        for c in range(n):
            u[c] *= scale
        return error, 0.0
    k = int(par[TIP])
    rank = 6 if goal[0] == 1.0 else 3
    x = T[k, 9] + T[k, 0] * tool[9] + T[k, 1] * tool[10] + T[k, 2] * tool[11]
    y = T[k, 10] + T[k, 3] * tool[9] + T[k, 4] * tool[10] + T[k, 5] * tool[11]
    z = T[k, 11] + T[k, 6] * tool[9] + T[k, 7] * tool[10] + T[k, 8] * tool[11]
    first = 10 if rank == 6 else 1
    v = H[6]
    v[0], v[1], v[2] = goal[first] - x, goal[first + 1] - y, goal[first + 2] - z
    error = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    scale = min(par[SPEED], closing_speed(error, 4.0 * par[SPEED], gain)) / error if error > 0.0 else 0.0
    for r in range(3):
        v[r] *= scale
    if rank == 6:
        R = H[7]
        for r in range(3):
            for c in range(3):  # the tool's rotation now
                R[3 * r + c] = T[k, 3 * r] * tool[c] + T[k, 3 * r + 1] * tool[3 + c] + T[k, 3 * r + 2] * tool[6 + c]
        E = H[8]
        for r in range(3):
            for c in range(3):
                E[3 * r + c] = (
                    goal[1 + 3 * r] * R[3 * c] + goal[2 + 3 * r] * R[3 * c + 1] + goal[3 + 3 * r] * R[3 * c + 2]
                )
        wx, wy, wz = 0.5 * (E[7] - E[5]), 0.5 * (E[2] - E[6]), 0.5 * (E[3] - E[1])
        s, cosine = math.sqrt(wx * wx + wy * wy + wz * wz), 0.5 * (E[0] + E[4] + E[8] - 1.0)
        angle = math.atan2(s, cosine)
        if s < 1e-7 and cosine < 0.0:  # half a turn: the axis is the longest column of E + 1
            best = 0
            for c in range(1, 3):
                if E[4 * c] > E[4 * best]:
                    best = c
            wx, wy, wz = E[best] + (best == 0), E[3 + best] + (best == 1), E[6 + best] + (best == 2)
            s = math.sqrt(wx * wx + wy * wy + wz * wz)
        scale = min(par[TURN], closing_speed(angle, 4.0 * par[TURN], gain)) / s if s > 0.0 else 0.0
        v[3], v[4], v[5] = scale * wx, scale * wy, scale * wz
    for r in range(rank):
        for c in range(n):
            Jt[r, c] = 0.0
    while k > 0:
        c, rate = J[k, 2], C[k, 12]
        zx, zy, zz = rate * T[k, 2], rate * T[k, 5], rate * T[k, 8]
        if J[k, 1] == 1:
            px, py, pz = x - T[k, 9], y - T[k, 10], z - T[k, 11]
            Jt[0, c] += zy * pz - zz * py
            Jt[1, c] += zz * px - zx * pz
            Jt[2, c] += zx * py - zy * px
            if rank == 6:
                Jt[3, c] += zx
                Jt[4, c] += zy
                Jt[5, c] += zz
        else:
            Jt[0, c] += zx
            Jt[1, c] += zy
            Jt[2, c] += zz
        k = J[k, 0]
    for c in range(n):  # towards the posture; the task takes away its own share of it below
        pull = par[POSTURE] * (posture[c] - q[c])
        u[c] = min(max(pull, -0.5 * M[2, c]), 0.5 * M[2, c])
    for r in range(rank):
        for c in range(n):
            v[r] -= Jt[r, c] * u[c]
    damping = 1e-8
    for attempt in range(2):
        least = np.inf
        for r in range(rank):  # Cholesky of J J^T + damping
            for c in range(r + 1):
                s = damping if r == c else 0.0
                for e in range(n):
                    s += Jt[r, e] * Jt[c, e]
                for e in range(c):
                    s -= H[r, e] * H[c, e]
                if r == c:
                    least = min(least, s)
                    H[r, r] = math.sqrt(max(s, 1e-16))
                else:
                    H[r, c] = s / H[c, c]
        if least > 2.5e-3 or attempt == 1:
            break
        damping = 2.5e-3 * (1.0 - max(least, 0.0) / 2.5e-3)  # near a singular posture
    for r in range(rank):
        for c in range(r):
            v[r] -= H[r, c] * v[c]
        v[r] /= H[r, r]
    for r in range(rank - 1, -1, -1):
        for c in range(r + 1, rank):
            v[r] -= H[c, r] * v[c]
        v[r] /= H[r, r]
    scale = 1.0
    for c in range(n):
        for r in range(rank):
            u[c] += Jt[r, c] * v[r]
        scale = min(scale, M[2, c] / max(abs(u[c]), TINY))
    for c in range(n):
        u[c] *= scale
    return error, angle
