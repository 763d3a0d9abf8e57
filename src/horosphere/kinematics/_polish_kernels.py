"""Newton steps on the true axes of an arm, from postures that a nearly exact structure gave."""

import math

import numpy as np

from ..kernels import jit
from ._screw_kernels import add, cross, load_pose, product, row, settled, sub, times, transposed, turn_matrix


@jit
def polish(arm, limits, motors, Q, valid, locked, steps, residual):
    """Newton steps on the true axes for rows (m, branches, n) that a nearly exact structure gave; residual (m,
    branches).

    locked: index of a joint to leave alone, or -1."""
    n = Q.shape[2]
    J, e = np.empty((6, n)), np.empty(6)
    H, dq = np.empty((6, 7)), np.empty(n)
    for i in range(motors.shape[0]):
        R, t = load_pose(motors, i, arm, n)
        for k in range(Q.shape[1]):
            if not valid[i, k]:
                continue
            q = Q[i, k]
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
                e[0], e[1], e[2] = 0.5 * (D[7] - D[5]), 0.5 * (D[2] - D[6]), 0.5 * (D[3] - D[1])
                e[3], e[4], e[5] = t[0] - x[0], t[1] - x[1], t[2] - x[2]
                size = 0.0
                for r in range(6):
                    size = max(size, abs(e[r]))
                residual[i, k] = size
                if size < 1e-13 or step == steps:
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
                    dq[j] = 0.0
                    for r in range(6):
                        dq[j] += J[r, j] * H[r, 6]
                    longest = max(longest, abs(dq[j]))
                for j in range(n):
                    q[j] += dq[j] * min(1.0, 0.2 / max(longest, 1e-300))
            for j in range(n):
                q[j] = settled(math.sin(q[j]), math.cos(q[j]), limits[0, j], limits[1, j])
