"""Newton steps on the true axes of an arm, from postures that a nearly exact structure gave: eight postures side by side."""

import math

import numpy as np

from ..kernels import (
    EIGHT,
    inner,
    jit,
    lane_abs,
    lane_max,
    lane_min,
    lane_where_lt,
    load_lanes,
    max_lane,
    spread,
    store_columns,
    store_lanes,
)
from ._screw_kernels import (
    add,
    cross,
    load_pose,
    product,
    row,
    settled,
    sine_cosine,
    sub,
    times,
    transposed,
    turn_matrix,
)

_sine_cosine = sine_cosine.inline
DONE = 1e-13  # residual (m, rad)
LONGEST = 0.2  # radians of one step


@inner
def polish_lanes(arm, limits, pose, Q, going, locked, done, steps, patient, work):
    """Newton steps on the true axes from the postures Q (n, 8) to one pose, in place; returns the residuals, lanes.

    pose: rotation and translation of the last link. going: lanes, 1.0 for postures that are wanted, 0.0 for what stays as it is.
    locked: index of a joint to leave alone, or -1. done: a residual (m, rad) that is small enough. work (98, 8): memory. patient: go
    on where a residual does not become a half; without it postures that will not get there cost three steps, not all.
    """
    R, t = pose
    n, q = Q.shape[0], Q.reshape(-1)
    J, H = work[:48].reshape(-1), work[48:90].reshape(-1)  # (n, 6, 8), (6, 7, 8)
    step_of = work[90:].reshape(-1)
    zero, one = spread(0.0, EIGHT), spread(1.0, EIGHT)
    size = spread(math.inf, EIGHT)
    for step in range(steps + 1):
        M, x = (one, zero, zero, zero, one, zero, zero, zero, one), (zero, zero, zero)
        for j in range(n):
            a, p = row(arm, j), row(arm, n + j)
            g = times(M, a)
            m = cross(g, sub(t, add(times(M, p), x)))
            k = 0.0 if j == locked else 1.0
            store_columns(J, 48 * j, (k * g[0], k * g[1], k * g[2], k * m[0], k * m[1], k * m[2]))
            s, c = _sine_cosine(load_lanes(q, 8 * j, EIGHT))
            T = turn_matrix(a, s, c)
            x = add(x, times(M, sub(p, times(T, p))))
            M = product(M, T)
        D = product(R, transposed(M))
        e = (0.5 * (D[7] - D[5]), 0.5 * (D[2] - D[6]), 0.5 * (D[3] - D[1]), t[0] - x[0], t[1] - x[1], t[2] - x[2])
        previous = size
        size = lane_max(lane_max(lane_abs(e[0]), lane_abs(e[1])), lane_max(lane_abs(e[2]), lane_abs(e[3])))
        size = lane_max(size, lane_max(lane_abs(e[4]), lane_abs(e[5])))
        going = lane_where_lt(size, done, 0.0, going)
        if not patient and step > 2:
            going = lane_where_lt(0.5 * previous, size, lane_where_lt(1e-12, size, 0.0, going), going)
        if step == steps or max_lane(going) == 0.0:
            break
        # Least-norm step: (J J^T + tiny) y = e, dq = J^T y; the symmetric matrix by its upper half.
        for r in range(6):
            for c in range(r, 6):
                s = spread(1e-17 if r == c else 0.0, EIGHT)
                for j in range(n):
                    s = s + load_lanes(J, 48 * j + 8 * r, EIGHT) * load_lanes(J, 48 * j + 8 * c, EIGHT)
                store_lanes(H, 56 * r + 8 * c, s)
            store_lanes(H, 56 * r + 48, e[r])
        for r in range(6):
            inverse = 1.0 / load_lanes(H, 56 * r + 8 * r, EIGHT)
            for r2 in range(r + 1, 6):
                f = load_lanes(H, 56 * r + 8 * r2, EIGHT) * inverse
                for c in range(r2, 7):
                    store_lanes(
                        H,
                        56 * r2 + 8 * c,
                        load_lanes(H, 56 * r2 + 8 * c, EIGHT) - f * load_lanes(H, 56 * r + 8 * c, EIGHT),
                    )
        for r in range(5, -1, -1):
            y = load_lanes(H, 56 * r + 48, EIGHT)
            for c in range(r + 1, 6):
                y = y - load_lanes(H, 56 * r + 8 * c, EIGHT) * load_lanes(H, 56 * c + 48, EIGHT)
            store_lanes(H, 56 * r + 48, y / load_lanes(H, 56 * r + 8 * r, EIGHT))
        longest = zero
        for j in range(n):
            s = zero
            for r in range(6):
                s = s + load_lanes(J, 48 * j + 8 * r, EIGHT) * load_lanes(H, 56 * r + 48, EIGHT)
            store_lanes(step_of, 8 * j, s)
            longest = lane_max(longest, lane_abs(s))
        share = going * lane_min(1.0, LONGEST / lane_max(longest, 1e-300))
        for j in range(n):
            store_lanes(q, 8 * j, load_lanes(q, 8 * j, EIGHT) + share * load_lanes(step_of, 8 * j, EIGHT))
    for j in range(n):
        s, c = _sine_cosine(load_lanes(q, 8 * j, EIGHT))
        store_lanes(q, 8 * j, settled(s, c, limits[0, j], limits[1, j]))
    return size


@jit
def polish(arm, limits, motors, Q, valid, locked, steps, residual):
    """`polish_lanes` for rows (m, branches <= 8, n) that a nearly exact structure gave; residual (m, branches) of the valid ones."""
    branches, n = Q.shape[1], Q.shape[2]
    work, q, going, left = np.empty((98, 8)), np.zeros((n, 8)), np.zeros(8), np.empty(8)
    for i in range(motors.shape[0]):
        pose = load_pose(motors, i, arm, n)
        for k in range(branches):
            going[k] = 1.0 if valid[i, k] else 0.0
            for j in range(n):
                q[j, k] = Q[i, k, j]
        store_lanes(
            left, 0, polish_lanes(arm, limits, pose, q, load_lanes(going, 0, EIGHT), locked, DONE, steps, True, work)
        )
        for k in range(branches):
            if valid[i, k]:
                residual[i, k] = left[k]
                for j in range(n):
                    Q[i, k, j] = q[j, k]
