"""How far, and how long, an arm still moves, and proofs that this is safe: compiled code.

The arrays are explained in `_reactive_kernels.py`, the proof in docs/live-loop.md. A stop: the velocity u for one period, then
(1 - i beta h) u in period i, beta = min a_j / |u_j|: the joints run straight, over S u in the time T.
"""

from __future__ import annotations

import math

import numpy as np

from ..distance._body_kernels import inner

# places in the array `par`
PERIOD, MARGIN, OWN_MARGIN, RATE, GAIN, TIP, SPEED, TURN, POSTURE, SWEEPS, TOLERANCE, ANGLE, RETREAT = range(13)
TINY = 1e-12
# a plain 0 or -1 in a call is a type of its own for numba, and the callee is compiled again for it
ZERO, NONE = np.int64(0), np.int64(-1)


@inner
def stopping(u, M, h):
    """(S, T): how far along u, and how long, until rest from the velocity u."""
    beta = np.inf
    for c in range(u.shape[0]):
        if u[c] != 0.0:
            beta = min(beta, M[3, c] / abs(u[c]))
    if beta * h >= 1.0:
        return h, h
    count = math.floor(1.0 / (beta * h))
    return h * (1.0 + count - 0.5 * beta * h * count * (count + 1.0)), h * (count + 1.0)


@inner
def closing_speed(room, brake, rate):
    """The fastest approach from a distance `room` that brakes by no more than `brake`, at last as rate * room; it joins smoothly."""
    if room * rate * rate <= brake:
        return rate * room
    return math.sqrt(2.0 * brake * (room - 0.5 * brake / (rate * rate)))


@inner
def lookout(speed, pull, rate):
    """Metres within which bodies that close at up to `speed` are taken into account; `pull`: the largest acceleration."""
    return speed / rate + speed * speed / max(pull, 0.2)


@inner
def twists(J, C, T, u, W):
    """W (k, 6): of every frame the angular velocity, and the velocity of its point at the world's origin, for joint rates u."""
    for k in range(J.shape[0]):
        parent = J[k, 0]
        for r in range(6):
            W[k, r] = W[parent, r] if parent >= 0 else 0.0
        if J[k, 1] > 0:
            rate = C[k, 12] * u[J[k, 2]]
            zx, zy, zz = rate * T[k, 2], rate * T[k, 5], rate * T[k, 8]
            if J[k, 1] == 1:
                px, py, pz = T[k, 9], T[k, 10], T[k, 11]
                W[k, 0] += zx
                W[k, 1] += zy
                W[k, 2] += zz
                zx, zy, zz = py * zz - pz * zy, pz * zx - px * zz, px * zy - py * zx
            W[k, 3] += zx
            W[k, 4] += zy
            W[k, 5] += zz


@inner
def along(W, k, stop, x, y, z, nx, ny, nz):
    """n . velocity of the point x of frame k, seen from frame `stop`."""
    wx, wy, wz = W[k, 0] - W[stop, 0], W[k, 1] - W[stop, 1], W[k, 2] - W[stop, 2]
    vx = W[k, 3] - W[stop, 3] + wy * z - wz * y
    vy = W[k, 4] - W[stop, 4] + wz * x - wx * z
    vz = W[k, 5] - W[stop, 5] + wx * y - wy * x
    return nx * vx + ny * vy + nz * vz


@inner
def motion(J, C, T, k, stop, x, y, z, radius, u, S):
    """Bounds for a point within `radius` of x on frame k while q runs over S u, seen from frame `stop`.

    (speed, bend): |dx/ds| <= speed, and |d2x/ds2| <= bend. From the tip down: rho bounds the distance to an axis on the way;
    |d2x / dq_j dq_k| <= rho of the joint nearer to the tip.
    """
    speed, bend = 0.0, 0.0
    while k != stop and k > 0:
        rate = abs(C[k, 12] * u[J[k, 2]])
        if rate > 0.0:
            if J[k, 1] == 1:
                zx, zy, zz = T[k, 2], T[k, 5], T[k, 8]
                px, py, pz = x - T[k, 9], y - T[k, 10], z - T[k, 11]
                cx, cy, cz = py * zz - pz * zy, pz * zx - px * zz, px * zy - py * zx
                rho = math.sqrt(cx * cx + cy * cy + cz * cz) + radius + S * speed
                bend += rate * (rate * rho + 2.0 * speed)
                speed += rate * rho
            else:
                speed += rate
        k = J[k, 0]
    return speed, bend


@inner
def unproved(J, C, L, K, T, X, W, N, I, count, M, par, q, u, every):
    """How many pairs are not safe in one period of the velocity u and a stop: 0 if each keeps its margin until rest, or parts.

    In the direction n of a pair the ends of the two capsules move apart by at least g s - K s^2, for s along u: g = n . velocity,
    K half the bound of the second derivative. It parts if that never falls below 0, and rises during the whole period.
    With `every`, N[:, 8] says by how much g falls short, m/s; without, the first decides. -1: a joint's limit.
    """
    reach, time = stopping(u, M, par[PERIOD])
    for c in range(u.shape[0]):
        end = q[c] + reach * u[c]
        if (u[c] > 0.0 and end > M[1, c] + 1e-9) or (u[c] < 0.0 and end < M[0, c] - 1e-9):
            return NONE
    twists(J, C, T, u, W)
    still = True
    for c in range(u.shape[0]):
        still = still and u[c] == 0.0
    if still:
        return ZERO
    failed = ZERO
    for i in range(L.shape[0]):
        X[i, 7] = -1.0  # bounds of the motion of the capsule's ends, once they are asked for
    for p in range(count):
        i, j, stop = I[p, 0], I[p, 1], I[p, 3]
        d, nx, ny, nz, speed = N[p, 0], N[p, 4], N[p, 5], N[p, 6], N[p, 7]
        margin = par[MARGIN] if j < 0 else par[OWN_MARGIN]
        k = L[i]
        keeps, parts, to_keep, to_part = True, True, 0.0, 0.0
        N[p, 8] = 0.0
        x0, y0, z0 = N[p, 1], N[p, 2], N[p, 3]
        ends = 1 if X[i, 3] == 0.0 and X[i, 4] == 0.0 and X[i, 5] == 0.0 else 2
        if j < 0:
            if X[i, 7] < 0.0:
                fast, bend = motion(J, C, T, k, ZERO, X[i, 0], X[i, 1], X[i, 2], 0.0, u, reach)
                if ends == 2:
                    x, y, z = X[i, 0] + X[i, 3], X[i, 1] + X[i, 4], X[i, 2] + X[i, 5]
                    faster, more = motion(J, C, T, k, ZERO, x, y, z, 0.0, u, reach)
                    fast, bend = max(fast, faster), max(bend, more)
                X[i, 7], X[i, 8] = fast, 0.5 * bend
            if d - speed * time - X[i, 7] * reach >= margin + 1e-11:
                continue
        others, kj = 1, 0
        if j >= 0:
            kj = L[j]
            others = 1 if X[j, 3] == 0.0 and X[j, 4] == 0.0 and X[j, 5] == 0.0 else 2
        gap = d + K[i, 6]
        if j >= 0:
            gap += K[j, 6]
        for e in range(ends):
            x, y, z = X[i, 0] + e * X[i, 3], X[i, 1] + e * X[i, 4], X[i, 2] + e * X[i, 5]
            ahead = nx * (x - x0) + ny * (y - y0) + nz * (z - z0)
            rise = along(W, k, stop, x, y, z, nx, ny, nz)
            bend = X[i, 8] if j < 0 else 0.5 * motion(J, C, T, k, stop, x, y, z, 0.0, u, reach)[1]
            for f in range(others):
                more, rises, bends = ahead, rise, bend
                if j >= 0:
                    x, y, z = X[j, 0] + f * X[j, 3], X[j, 1] + f * X[j, 4], X[j, 2] + f * X[j, 5]
                    # the other witness is x0 - gap n, and its capsule ends lie behind it
                    more -= nx * (x - x0) + ny * (y - y0) + nz * (z - z0) + gap
                    rises -= along(W, kj, stop, x, y, z, nx, ny, nz)
                    bends += 0.5 * motion(J, C, T, kj, stop, x, y, z, 0.0, u, reach)[1]
                least = d + more + min(0.0, (rises - bends * reach) * reach - speed * time)
                keeps = keeps and least >= margin + 1e-11
                parts = parts and rises >= bends * max(reach, 2.0 * par[PERIOD])
                room = d + more - margin - 1e-11
                to_keep = max(to_keep, (speed * time - room) / reach + bends * reach - rises if room >= 0.0 else np.inf)
                to_part = max(to_part, bends * max(reach, 2.0 * par[PERIOD]) - rises)
        if not (keeps or parts):
            N[p, 8] = max(min(to_keep, to_part), 1e-6)
            failed += 1
            if not every:
                break
    return failed
