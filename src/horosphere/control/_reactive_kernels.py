"""One period of the live loop for an arm: compiled code. docs/live-loop.md has the law, the guarantee and its proof.

The robot comes as in `horosphere.distance._body_kernels`, its capsules sorted by frame:
  F (k, 2) int64: first capsule of each frame and one past the last      B (k, 4): a ball in the frame that holds them
  G (g, 5) int64: self-collision groups: two frames, the frame both hang from, first pair and one past the last
  P (p, 2) int64: pairs of capsules      S, V, E: solids (rows of shapes.pack), how fast each may move, m/s, and the velocity
  that it probably has; of an unknown one (NaN) that it comes straight on
  O (m, s) bool: which capsules may touch which solids, or (0, 0): none
  M (5, n): lower, upper, velocity, acceleration limits, weights of the projection
  par: see `_reactive_motion_kernels.py`
  goal: kind (0 joints, 1 pose, 2 point), then q, or rotation by rows and position, or position
"""

from __future__ import annotations

import math

import numpy as np

from ..distance._body_kernels import add_slope, inner, place, self_distance
from ..distance._pair_kernels import segment_distance
from ..kernels import jit
from ._reactive_goal_kernels import wanted
from ._reactive_motion_kernels import (
    ANGLE,
    MARGIN,
    NONE,
    OWN_MARGIN,
    PERIOD,
    RATE,
    RETREAT,
    SWEEPS,
    TINY,
    TOLERANCE,
    ZERO,
    closing_speed,
    lookout,
    motion,
    stopping,
    unproved,
)

MOVING, ARRIVED, BLOCKED, RETREATING, STOPPING, STOPPED = range(6)
HALF_SPACE = 3.0
SLIDE = 2e-4  # m
CLOSE = 0.02  # m
# how often what a proof lacks is asked for in a step, how much of it, and what share of the velocity limits is no change
MENDS, SPARE, SAME = np.int64(3), 1.5, 1e-5


@inner
def look(J, C, L, F, B, K, S, V, O, G, P, T, X, M, par, top, reach, stop_time, N, I, A, b, seen):
    """Pairs that matter this period: N (c, 9) = distance, witness, direction, speed, what `unproved` says;
    I (c, 5) = capsule, other capsule, what it meets, frame that both hang from, frame of the other.

    A pair is left out if no velocity |u| <= top can make it matter. A, b: the rows a . u >= b, for the nearest capsule of every
    frame and solid and those that are close, and for the nearest pair of two frames. Returns (pairs, rows). seen: the least
    distance to a solid, capsule, solid, and of the robot's own pairs, capsule, pair.
    """
    rate, count, rows, contacts = par[RATE], ZERO, ZERO, O.shape[0] > 0
    seen[0], seen[1], seen[2], seen[3], seen[4], seen[5] = np.inf, -1.0, -1.0, np.inf, -1.0, -1.0
    for k in range(1, J.shape[0]):
        if F[k, 1] > F[k, 0]:
            cx = T[k, 9] + T[k, 0] * B[k, 0] + T[k, 1] * B[k, 1] + T[k, 2] * B[k, 2]
            cy = T[k, 10] + T[k, 3] * B[k, 0] + T[k, 4] * B[k, 1] + T[k, 5] * B[k, 2]
            cz = T[k, 11] + T[k, 6] * B[k, 0] + T[k, 7] * B[k, 1] + T[k, 8] * B[k, 2]
            fast = motion(J, C, T, k, ZERO, cx, cy, cz, B[k, 3], top, reach)[0]
            pull = motion(J, C, T, k, ZERO, cx, cy, cz, B[k, 3], M[3], 0.0)[0]
            for i in range(F[k, 0], F[k, 1]):
                X[i, 7] = -1.0  # a bound of its own speed, once it is asked for
            for j in range(S.shape[0]):
                need = par[MARGIN] + SLIDE + max(fast * reach + V[j] * stop_time, lookout(fast + V[j], pull, rate))
                if S[j, 0] == HALF_SPACE:
                    rough = S[j, 6] * cx + S[j, 7] * cy + S[j, 8] * cz - S[j, 9] - B[k, 3]
                else:
                    x, y, z = cx - S[j, 1], cy - S[j, 2], cz - S[j, 3]
                    rough = math.sqrt(x * x + y * y + z * z) - S[j, 4] - B[k, 3]
                if rough >= need and rough >= seen[0]:
                    continue
                nearest, best, first = np.inf, NONE, count
                for i in range(F[k, 0], F[k, 1]):
                    if contacts and O[i, j]:
                        continue
                    if S[j, 0] != HALF_SPACE:
                        x = X[i, 0] + 0.5 * X[i, 3] - S[j, 1]
                        y = X[i, 1] + 0.5 * X[i, 4] - S[j, 2]
                        z = X[i, 2] + 0.5 * X[i, 5] - S[j, 3]
                        rough = math.sqrt(x * x + y * y + z * z) - S[j, 4] - K[i, 7]
                        if rough >= need and rough >= seen[0]:
                            continue
                        if X[i, 7] < 0.0:
                            x, y, z = X[i, 0] + 0.5 * X[i, 3], X[i, 1] + 0.5 * X[i, 4], X[i, 2] + 0.5 * X[i, 5]
                            X[i, 7] = motion(J, C, T, k, ZERO, x, y, z, K[i, 7] - K[i, 6], top, reach)[0]
                        own = X[i, 7]
                        close = max(own * reach + V[j] * stop_time, lookout(own + V[j], pull, rate))
                        if rough >= par[MARGIN] + SLIDE + close and rough >= seen[0]:
                            continue
                    d, t, nx, ny, nz = segment_distance(S, j, X[i, 0], X[i, 1], X[i, 2], X[i, 3], X[i, 4], X[i, 5], 1)
                    d -= K[i, 6]
                    if d < seen[0]:
                        seen[0], seen[1], seen[2] = d, i, j
                    if d < need:
                        if count == N.shape[0]:
                            return NONE, rows
                        keep(N, I, count, d, X, i, t, nx, ny, nz, V[j], NONE, j, ZERO, ZERO)
                        if d < nearest:
                            nearest, best = d, count
                        count += 1
                for pair in range(first, count):
                    # the nearest body of the link, and others where it is close: they turn into its way
                    if rows < A.shape[0] and (pair == best or N[pair, 0] < par[MARGIN] + CLOSE):
                        add_row(J, C, T, K, N, I, pair, k, par[MARGIN], A, b, rows)
                        rows += 1
    for g in range(G.shape[0]):
        ka, kb, stop = G[g, 0], G[g, 1], G[g, 2]
        ax = T[ka, 9] + T[ka, 0] * B[ka, 0] + T[ka, 1] * B[ka, 1] + T[ka, 2] * B[ka, 2]
        ay = T[ka, 10] + T[ka, 3] * B[ka, 0] + T[ka, 4] * B[ka, 1] + T[ka, 5] * B[ka, 2]
        az = T[ka, 11] + T[ka, 6] * B[ka, 0] + T[ka, 7] * B[ka, 1] + T[ka, 8] * B[ka, 2]
        cx = T[kb, 9] + T[kb, 0] * B[kb, 0] + T[kb, 1] * B[kb, 1] + T[kb, 2] * B[kb, 2]
        cy = T[kb, 10] + T[kb, 3] * B[kb, 0] + T[kb, 4] * B[kb, 1] + T[kb, 5] * B[kb, 2]
        cz = T[kb, 11] + T[kb, 6] * B[kb, 0] + T[kb, 7] * B[kb, 1] + T[kb, 8] * B[kb, 2]
        fast = motion(J, C, T, ka, stop, ax, ay, az, B[ka, 3], top, reach)[0]
        fast += motion(J, C, T, kb, stop, cx, cy, cz, B[kb, 3], top, reach)[0]
        pull = motion(J, C, T, ka, stop, ax, ay, az, B[ka, 3], M[3], 0.0)[0]
        pull += motion(J, C, T, kb, stop, cx, cy, cz, B[kb, 3], M[3], 0.0)[0]
        need = par[OWN_MARGIN] + SLIDE + max(fast * reach, lookout(fast, pull, rate))
        x, y, z = ax - cx, ay - cy, az - cz
        rough = math.sqrt(x * x + y * y + z * z) - B[ka, 3] - B[kb, 3]
        if rough >= need and rough >= seen[3]:
            continue
        nearest, best = np.inf, NONE
        for p in range(G[g, 3], G[g, 4]):
            i, j = P[p, 0], P[p, 1]
            x = X[i, 0] + 0.5 * X[i, 3] - X[j, 0] - 0.5 * X[j, 3]
            y = X[i, 1] + 0.5 * X[i, 4] - X[j, 1] - 0.5 * X[j, 4]
            z = X[i, 2] + 0.5 * X[i, 5] - X[j, 2] - 0.5 * X[j, 5]
            room = max(need, seen[3]) + K[i, 7] + K[j, 7]
            if x * x + y * y + z * z >= room * room:
                continue
            d, t, nx, ny, nz = self_distance(K, X, i, j)
            if d < seen[3]:
                seen[3], seen[4], seen[5] = d, i, p
            if d < need:
                if count == N.shape[0]:
                    return NONE, rows
                keep(N, I, count, d, X, i, t, nx, ny, nz, 0.0, j, p, stop, L[j])
                if d < nearest:
                    nearest, best = d, count
                count += 1
        if best >= 0 and rows < A.shape[0]:
            add_row(J, C, T, K, N, I, best, ka, par[OWN_MARGIN], A, b, rows)
            rows += 1
    return count, rows


@inner
def keep(N, I, at, d, X, i, t, nx, ny, nz, speed, other, what, stop, frame):
    N[at, 0], N[at, 4], N[at, 5], N[at, 6], N[at, 7] = d, nx, ny, nz, speed
    for r in range(3):
        N[at, 1 + r] = X[i, r] + t * X[i, 3 + r]
    I[at, 0], I[at, 1], I[at, 2], I[at, 3], I[at, 4] = i, other, what, stop, frame


@inner
def add_row(J, C, T, K, N, I, pair, k, margin, A, b, row):
    """a . u: the rate of the pair's distance; b (rows, 7): how far it is from the margin, speed, three demands and a . a of
    `project`, pair."""
    a = A[row]
    for c in range(a.shape[0]):
        a[c] = 0.0
    d, x, y, z = N[pair, 0], N[pair, 1], N[pair, 2], N[pair, 3]
    nx, ny, nz, i, j = N[pair, 4], N[pair, 5], N[pair, 6], I[pair, 0], I[pair, 1]
    add_slope(J, C, T, k, x, y, z, nx, ny, nz, a)
    if j >= 0:
        d += K[i, 6] + K[j, 6]
        add_slope(J, C, T, I[pair, 4], x - d * nx, y - d * ny, z - d * nz, -nx, -ny, -nz, a)
    b[row, 0], b[row, 1], b[row, 6] = N[pair, 0] - margin, N[pair, 7], pair


@inner
def tighten(J, C, L, T, K, N, I, count, par, u, A, b, rows):
    """Ask for what u lacks where `unproved` found that it falls short, and for a little more; returns how many rows there are."""
    for p in range(count):
        if N[p, 8] > 0.0:
            r = ZERO
            while r < rows and b[r, 6] != p:
                r += 1
            if r == A.shape[0]:
                return rows
            if r == rows:
                margin = par[MARGIN] if I[p, 1] < 0 else par[OWN_MARGIN]
                add_row(J, C, T, K, N, I, p, L[I[p, 0]], margin, A, b, r)
                b[r, 2] = b[r, 3] = b[r, 4] = -np.inf
                rows += 1
            have = 0.0
            for c in range(u.shape[0]):
                have += A[r, c] * u[c]
            need = max(have, b[r, 2]) + SPARE * N[p, 8]
            for level in range(2, 5):
                b[r, level] = max(b[r, level], need)
    return rows


@inner
def project(u, A, b, rows, M, lo, hi, lam, nu, sweeps):
    """u becomes the nearest velocity (in the weights) with lo <= u <= hi and a . u >= b2, and >= b3, b4 if possible, for every row.

    Hildreth's sweeps. A row may give way at a price, its own stiffness over 1e-4 for b2, 0.02 for b3, 0.3 for b4: where retreats
    from several sides contradict each other, they share what is missing, and none costs another its b2. The limits never give way.
    """
    n = u.shape[0]
    for r in range(rows):
        lam[r, 0] = lam[r, 1] = lam[r, 2] = b[r, 5] = 0.0
        for c in range(n):
            b[r, 5] += M[4, c] * A[r, c] * A[r, c]
    for c in range(n):
        clipped = min(max(u[c], lo[c]), hi[c])
        nu[c] = clipped - u[c]
        u[c] = clipped
    for _ in range(sweeps):
        change = 0.0
        for r in range(rows):
            s, g = 0.0, b[r, 5]
            for c in range(n):
                s += A[r, c] * u[c]
            if g > TINY:
                for level in range(3):
                    if level > 0 and b[r, 2 + level] == b[r, 1 + level]:
                        continue
                    give = (1e-4, 0.02, 0.3)[level]
                    old = lam[r, level]
                    new = max(0.0, old + (b[r, 2 + level] - s - give * g * old) / ((1.0 + give) * g))
                    if new != old:
                        lam[r, level] = new
                        change = max(change, abs(new - old) * g)
                        s += (new - old) * g
                        for c in range(n):
                            u[c] += (new - old) * M[4, c] * A[r, c]
        for c in range(n):
            free = u[c] - nu[c]
            clipped = min(max(free, lo[c]), hi[c])
            change = max(change, abs(clipped - u[c]))
            nu[c] = clipped - free
            u[c] = clipped
        if change < 1e-6:
            break


@jit(_nrt=False)
def step_into(J, C, L, K, F, B, S, V, E, O, G, P, M, par, goal, posture, tool, q, before, expected, work, I, out):
    """One period: q (n,), velocity `before` (n,); `expected` (n,) is where q has to be for the stop from `before` to be proved.

    out: u (n,), reason, nearest solid (distance, capsule, solid), nearest own pair (3), proved, errors (2), time to rest, pairs,
    rows. work: `_reactive_pack.workspace`. Returns False if q is not finite.
    """
    T, X, W, N, A, b, H, Jt, U, lam = work
    n, h = q.shape[0], par[PERIOD]
    lo, hi, top, u, fallback, nu, base, trial = U[0], U[1], U[2], U[3], U[4], U[5], U[6], U[7]
    chained = True
    for c in range(n):
        if not math.isfinite(q[c]):
            return False
        chained = chained and abs(q[c] - expected[c]) <= 1e-9
    place(J, C, L, K, q, T, X)
    beta = np.inf
    for c in range(n):
        if before[c] != 0.0:
            beta = min(beta, M[3, c] / abs(before[c]))
    reach, time = stopping(before, M, h)
    for c in range(n):
        fallback[c] = max(0.0, 1.0 - beta * h) * before[c] if beta < np.inf else 0.0
        least, most = before[c] - M[3, c] * h, before[c] + M[3, c] * h
        least, most = min(max(least, -M[2, c]), max(most, -M[2, c])), max(min(most, M[2, c]), min(least, M[2, c]))
        # slower towards the end of its range, as far as its acceleration allows
        above, below = M[1, c] - q[c], q[c] - M[0, c]
        fast = min(closing_speed(above, 0.8 * M[3, c], par[RATE]), 0.9 * above / reach)
        slow = -min(closing_speed(below, 0.8 * M[3, c], par[RATE]), 0.9 * below / reach)
        hi[c] = min(max(fast, least), most)
        lo[c] = max(min(slow, most), least)
        top[c] = max(abs(lo[c]), abs(hi[c]), abs(fallback[c]))
    longest, latest = stopping(top, M, h)
    count, rows = look(
        J, C, L, F, B, K, S, V, O, G, P, T, X, M, par, top, longest, latest + h, N, I, A, b, out[n + 1 : n + 7]
    )
    error, angle = wanted(J, C, T, par, goal, posture, tool, q, M, Jt, H, base)
    away, found, rows = False, rows, ZERO
    for r in range(found):
        p, speed = int(b[r, 6]), b[r, 1]
        i, j, stop = I[p, 0], I[p, 1], I[p, 3]
        bend = motion(J, C, T, L[i], stop, N[p, 1], N[p, 2], N[p, 3], 0.0, before, reach)[1]
        if j >= 0:
            gap = N[p, 0] + K[i, 6] + K[j, 6]
            bend += motion(J, C, T, L[j], stop, N[p, 1], N[p, 2], N[p, 3], gap, before, reach)[1]
        brake, most = 1e-3, 1e-9
        for c in range(n):
            brake += 0.5 * abs(A[r, c]) * M[3, c]
            most += abs(A[r, c]) * top[c]
        # room to slide along: the curved part of the way at this speed, and a little more
        room = b[r, 0] - SLIDE - 0.5 * bend * reach * reach
        calm = closing_speed(room, brake, par[RATE])  # what a body at rest would allow
        coming = 0.0
        if j < 0:
            coming = N[p, 4] * E[I[p, 2], 0] + N[p, 5] * E[I[p, 2], 1] + N[p, 6] * E[I[p, 2], 2]
            coming = 0.0 if math.isnan(coming) else max(coming, 0.0)
        closing = calm
        if room > 0.0:
            closing = min(closing, (0.9 * room - speed * time) / reach)
        if closing < 0.0:  # it has to part from what may be there before it rests
            closing = -bend * reach - 0.02 * most if b[r, 0] < speed * time else 0.0
        if speed > 0.0:
            calm = max(calm, par[RETREAT] * room)
        away = away or (speed - calm > 0.0 and (speed > 0.0 or b[r, 0] < 0.0))
        seen_to_do = max(coming - calm, -closing)
        might_do = max(speed - calm, seen_to_do)
        if might_do > -most:  # else no velocity within reach breaks it
            b[rows, 2], b[rows, 3], b[rows, 4], b[rows, 6] = -closing, seen_to_do, might_do, p
            for c in range(n):
                A[rows, c] = A[r, c]
            rows += 1
    reason = STOPPING
    sure = False
    if count >= 0:
        ramp = 1.0
        for c in range(n):  # as far towards it as the acceleration allows, in a straight line
            if abs(base[c] - before[c]) * ramp > M[3, c] * h:
                ramp = M[3, c] * h / abs(base[c] - before[c])
        for attempt in range(5):
            share = (1.0, 0.3, 1.0, 0.5, 1.0)[attempt]
            sweeps = int(par[SWEEPS]) * ((4 if away else 1) if attempt < 4 else 40)
            failed, mends = ZERO, MENDS if attempt % 2 == 0 else ZERO
            for mend in range(1 + mends):
                if attempt % 2 == 0:
                    for c in range(n):
                        u[c] = before[c] + ramp * (base[c] - before[c]) if attempt == 0 else fallback[c]
                    project(u, A, b, rows, M, lo, hi, lam, nu, sweeps)
                change = 0.0
                for c in range(n):
                    change = max(change, abs(u[c] - trial[c]) / M[2, c])
                    trial[c] = fallback[c] + share * (u[c] - fallback[c])
                if mend > 0 and change < SAME:
                    break  # what is lacking is not to be had
                failed = unproved(J, C, L, K, T, X, W, N, I, count, M, par, q, trial, mend < mends)
                if failed <= 0:
                    break
                if mend < mends:
                    rows = tighten(J, C, L, T, K, N, I, count, par, u, A, b, rows)
            if failed == 0:
                sure, reason = True, MOVING
                break
    if not sure:
        for c in range(n):
            trial[c] = fallback[c]
        sure = chained or (count >= 0 and unproved(J, C, L, K, T, X, W, N, I, count, M, par, q, trial, False) == 0)
    largest = 0.0
    for c in range(n):
        out[c] = trial[c]
        largest = max(largest, abs(trial[c]) / M[2, c])
    if reason == STOPPING:
        if largest == 0.0:
            reason = STOPPED
    elif away:
        reason = RETREATING if largest > 1e-6 else STOPPED
    elif error <= par[TOLERANCE] and angle <= par[ANGLE]:
        reason = ARRIVED
    elif largest < 1e-4:
        reason = BLOCKED
    out[n], out[n + 7], out[n + 8], out[n + 9] = reason, 1.0 if sure else 0.0, error, angle
    out[n + 10], out[n + 11], out[n + 12] = stopping(trial, M, h)[1] if largest > 0.0 else 0.0, count, rows
    return True
