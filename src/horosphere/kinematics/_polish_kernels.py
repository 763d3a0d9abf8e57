"""Newton steps on the true axes of an arm, from postures that a nearly exact structure gave."""

import math

import numpy as np

from ..kernels import inner, jit
from ._screw_kernels import add, cross, load_pose, product, row, settled, sub, times, transposed, turn_matrix


@inner
def polish_row(arm, limits, pose, q, locked, steps, patient, work):
    """Newton steps on the true axes from the posture q (n,), in place; returns the residual.

    pose: rotation and translation of the last link. locked: index of a joint to leave alone, or -1. work (13, >= 7): memory.
    patient: go on where the residual does not become a half; without it rows that will not get there cost three steps, not all.
    """
    R, t = pose
    n = q.shape[0]
    J, H = work[:6], work[6:12]
    size = math.inf
    for step in range(steps + 1):
        M, x = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
        for j in range(n):
            a, p = row(arm, j), row(arm, n + j)
            m = cross(times(M, a), sub(t, add(times(M, p), x)))
            g = times(M, a)
            for r in range(3):
                J[r, j], J[3 + r, j] = (0.0, 0.0) if j == locked else (g[r], m[r])
            T = turn_matrix(a, math.sin(q[j]), math.cos(q[j]))
            x = add(x, times(M, sub(p, times(T, p))))
            M = product(M, T)
        D = product(R, transposed(M))
        e = (0.5 * (D[7] - D[5]), 0.5 * (D[2] - D[6]), 0.5 * (D[3] - D[1]), t[0] - x[0], t[1] - x[1], t[2] - x[2])
        previous, size = size, 0.0
        for r in range(6):
            size = max(size, abs(e[r]))
        if size < 1e-13 or step == steps or (not patient and step > 2 and size > 0.5 * previous and size > 1e-12):
            break
        # Least-norm step: (J J^T + tiny) y = e, dq = J^T y.
        for r in range(6):
            for c in range(6):
                s = 1e-17 if r == c else 0.0
                for j in range(n):
                    s += J[r, j] * J[c, j]
                H[r, c] = s
            H[r, 6] = e[r]
        for r in range(6):
            for r2 in range(r + 1, 6):
                f = H[r2, r] / H[r, r]
                for c in range(r, 7):
                    H[r2, c] -= f * H[r, c]
        for r in range(5, -1, -1):
            for c in range(r + 1, 6):
                H[r, 6] -= H[r, c] * H[c, 6]
            H[r, 6] /= H[r, r]
        longest = 0.0
        for j in range(n):
            s = 0.0
            for r in range(6):
                s += J[r, j] * H[r, 6]
            work[12, j] = s
            longest = max(longest, abs(s))
        for j in range(n):
            q[j] += work[12, j] * min(1.0, 0.2 / max(longest, 1e-300))
    for j in range(n):
        q[j] = settled(math.sin(q[j]), math.cos(q[j]), limits[0, j], limits[1, j])
    return size


@jit
def polish(arm, limits, motors, Q, valid, locked, steps, residual):
    """`polish_row` for rows (m, branches, n) that a nearly exact structure gave; residual (m, branches)."""
    work = np.empty((13, 7))
    for i in range(motors.shape[0]):
        pose = load_pose(motors, i, arm, Q.shape[2])
        for k in range(Q.shape[1]):
            if valid[i, k]:
                residual[i, k] = polish_row(arm, limits, pose, Q[i, k], locked, steps, True, work)
