"""Pieces of a redundancy's branch, each enclosed in a tube about its chord: compiled code.

A piece is known by its postures at both ends and one between; along it the task, m = n - 1 functions f of the n joints, is
constant. With q0 the middle of the chord, d its direction, L its length and N the right inverse of Df(q0) onto vectors across d:
if for all q = q0 + s d + y with |s| <= L / 2, y across d, |y| <= r
    |N (Df(q) - Df(q0))| <= a < 1,    |N Df(q) d| <= b,    L b / (1 - a) <= r,
then the level set of f there is one curve y(s) with |y'| <= b / (1 - a) from end to end, and so nowhere farther than half of
that times L from the chord. Df(q) is Df(q0) + D2f(q0)(q - q0, .) + D3f(q0)(s d, s d, .) / 2 and a rest bounded by the lengths of
the arm. Our derivation, docs/inverse-kinematics.md. J, C, L, K, T, X: see distance/_body_kernels.py.
"""

from __future__ import annotations

import math

import numpy as np

from ..distance._body_kernels import place
from ..kernels import inner, jit

OPEN, INSIDE, CROSSING, OUTSIDE = 0, 1, 2, 3  # go on in `_arc_kernels`
_ROUNDING = 2e-9  # ten times what the closed form may miss of the task at the ends: 1 - a is 0.1 at least
_WHOLE = 2.0 * math.pi


@inner
def plus(x, s, a, b):
    """x + s a x b."""
    return (
        x[0] + s * (a[1] * b[2] - a[2] * b[1]),
        x[1] + s * (a[2] * b[0] - a[0] * b[2]),
        x[2] + s * (a[0] * b[1] - a[1] * b[0]),
    )


@inner
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inner
def row(W, j, k):
    return W[j, k], W[j, k + 1], W[j, k + 2]


@inner
def carried(w, dw, dx, ddx, arm):
    """First and second rate of a point at `arm` from one that has the rates dx, ddx, on a body that turns at w, w rising by dw."""
    around = plus((0.0, 0.0, 0.0), 1.0, w, arm)
    return plus(dx, 1.0, w, arm), plus(plus(ddx, 1.0, dw, arm), 1.0, w, around)


@inner
def turned(T, k, x, y, z):
    """A vector of frame k in base axes."""
    return (
        T[k, 0] * x + T[k, 1] * y + T[k, 2] * z,
        T[k, 3] * x + T[k, 4] * y + T[k, 5] * z,
        T[k, 6] * x + T[k, 7] * y + T[k, 8] * z,
    )


@inner
def task_at(T, C, path, tool, normal, span, d, M, E, D, W):
    """Df, D2f(d, .), D3f(d, d, .) into M, E, D (m rows) at the frames T; returns a bound of the Frobenius norm of D2f.

    f: the rotation vector of the tool from its orientation here (the skew part of R R0^T; or, where `normal` is not zero, the
    part of the tool's direction along it), then the tool point over `span`. Columns in the order of the joints along `path`.
    tool (6,): point and direction in the last frame. W (n, 15) is working memory: axis and its two rates, two rates of its point.
    """
    n, last = path.shape[0], path[path.shape[0] - 1]
    zero = (0.0, 0.0, 0.0)
    w, dw, dx, ddx = zero, zero, zero, zero  # of the body that carries the joint, while the joints run along d
    for j in range(n):
        k = path[j]
        if j > 0:
            b = path[j - 1]
            arm = T[k, 9] - T[b, 9], T[k, 10] - T[b, 10], T[k, 11] - T[b, 11]
            dx, ddx = carried(w, dw, dx, ddx, arm)
        u = C[k, 12] * T[k, 2], C[k, 12] * T[k, 5], C[k, 12] * T[k, 8]
        du, ddu = carried(w, dw, zero, zero, u)
        for r in range(3):
            W[j, r], W[j, 3 + r], W[j, 6 + r], W[j, 9 + r], W[j, 12 + r] = u[r], du[r], ddu[r], dx[r], ddx[r]
        w = w[0] + d[j] * u[0], w[1] + d[j] * u[1], w[2] + d[j] * u[2]
        dw = dw[0] + d[j] * du[0], dw[1] + d[j] * du[1], dw[2] + d[j] * du[2]
    offset, g = turned(T, last, tool[0], tool[1], tool[2]), turned(T, last, tool[3], tool[4], tool[5])
    dx, ddx = carried(w, dw, dx, ddx, offset)
    dg, ddg = carried(w, dw, zero, zero, g)
    across = normal[0], normal[1], normal[2]
    flat = dot(across, across) > 0.0
    low, total = 1 if flat else 3, 0.0
    for j in range(n):
        k = path[j]
        u, du, ddu = row(W, j, 0), row(W, j, 3), row(W, j, 6)
        a = offset[0] + T[last, 9] - T[k, 9], offset[1] + T[last, 10] - T[k, 10], offset[2] + T[last, 11] - T[k, 11]
        da, dda = (
            (dx[0] - W[j, 9], dx[1] - W[j, 10], dx[2] - W[j, 11]),
            (ddx[0] - W[j, 12], ddx[1] - W[j, 13], ddx[2] - W[j, 14]),
        )
        v = plus(zero, 1.0 / span, u, a)
        dv = plus(plus(zero, 1.0 / span, u, da), 1.0 / span, du, a)
        ddv = plus(plus(plus(zero, 1.0 / span, u, dda), 2.0 / span, du, da), 1.0 / span, ddu, a)
        for i in range(j + 1):
            wi, twice = row(W, i, 0), 1.0 if i == j else 2.0
            along, turn = dot(wi, v), dot(wi, u)
            total += twice * (dot(v, v) - along * along)
            total += twice if flat else twice * 0.25 * (1.0 - turn * turn)
        if flat:
            M[0, j] = dot(across, plus(zero, 1.0, u, g))
            E[0, j] = dot(across, plus(plus(zero, 1.0, u, dg), 1.0, du, g))
            D[0, j] = dot(across, plus(plus(plus(zero, 1.0, u, ddg), 2.0, du, dg), 1.0, ddu, g))
        else:
            # a rotation's rate w counts as (w tr Q - Q w) / 2 in f, Q = R R0^T = 1 + s w^ + s^2 (dw^ + w^ w^) / 2
            ddu = plus(plus(plus(ddu, -1.0, w, du), -0.5, dw, u), -0.5, w, plus(zero, 1.0, w, u))
            du = plus(du, -0.5, w, u)
            f = dot(w, w)
            for r in range(3):
                M[r, j], E[r, j], D[r, j] = u[r], du[r], ddu[r] - f * u[r]
        for r in range(3):
            M[low + r, j], E[low + r, j], D[low + r, j] = v[r], dv[r], ddv[r]
    return math.sqrt(total)


@inner
def right_inverse(M, N):
    """N (n, m): the first m = n - 1 columns of the inverse of M (n, n), which is spent. False where there is none."""
    n, m = N.shape
    for r in range(n):
        for c in range(m):
            N[r, c] = 1.0 if r == c else 0.0
    for k in range(n):
        top = k
        for r in range(k + 1, n):
            if abs(M[r, k]) > abs(M[top, k]):
                top = r
        if not abs(M[top, k]) > 1e-12:
            return False
        if top != k:
            for c in range(n):
                M[k, c], M[top, c] = M[top, c], M[k, c]
            for c in range(m):
                N[k, c], N[top, c] = N[top, c], N[k, c]
        scale = 1.0 / M[k, k]
        for c in range(k, n):
            M[k, c] *= scale
        for c in range(m):
            N[k, c] *= scale
        for r in range(n):
            f = M[r, k]
            if r != k and f != 0.0:
                for c in range(k, n):
                    M[r, c] -= f * M[k, c]
                for c in range(m):
                    N[r, c] -= f * N[k, c]
    return True


@inner
def rest(d, half, r, levers, span):
    """A bound (Frobenius) of Df(q0 + s d + y) - Df(q0) - D2f(s d + y, .) - s^2 D3f(d, d, .) / 2 for |s| <= half, |y| <= r.

    Third derivatives with y in them, and fourth ones: in the rotation at most 1, in the point the lever of the outermost joint.
    """
    n = d.shape[0]
    along, off, total = 0.0, math.sqrt(float(n)) * r, 0.0
    for j in range(n):
        along += half * abs(d[j])
    third = (along + 0.5 * off) * off
    for k in range(n):
        value, sum_ = 0.0, 0.0
        for j in range(n):
            more = sum_ + half * abs(d[j]) + r
            value += (more * more * more - sum_ * sum_ * sum_) * levers[max(j, k)]
            sum_ = more
        a, b = third + sum_ * sum_ * sum_ / 6.0, (third * levers[k] + value / 6.0) / span
        total += a * a + b * b
    return math.sqrt(total)


@inner
def shrunk(N, E, d):
    """Frobenius norm of N E, and the length of N E d."""
    n, m = N.shape
    total, along = 0.0, 0.0
    for i in range(n):
        t = 0.0
        for j in range(n):
            y = 0.0
            for c in range(m):
                y += N[i, c] * E[c, j]
            total += y * y
            t += y * d[j]
        along += t * t
    return math.sqrt(total), math.sqrt(along)


@inner
def tube(M, N, E, D, d, slope, long, curved, levers, span):
    """(r, reach): radius in which the level set is one curve, and how far that is from the chord at most; infinite if not proved.

    M (n, n), E, D (m, n): Df with d as last row, D2f(d, .), D3f(d, d, .), in the order of the joints of d; M, N (n, m), slope (m,)
    are spent.
    """
    n, m = N.shape
    half = 0.5 * long
    for c in range(m):
        slope[c] = 0.0
        for j in range(n):
            slope[c] += M[c, j] * d[j]
    if not right_inverse(M, N):
        return math.inf, math.inf
    norm, b0 = 0.0, 0.0
    for i in range(n):
        s = 0.0
        for c in range(m):
            norm += N[i, c] * N[i, c]
            s += N[i, c] * slope[c]
        b0 += s * s
    norm = math.sqrt(norm)
    bend, turn = shrunk(N, E, d)
    bend3, turn3 = shrunk(N, D, d)
    a0, b0 = half * (bend + 0.5 * half * bend3), math.sqrt(b0) + half * (turn + 0.5 * half * turn3)
    rounding = norm * _ROUNDING
    r = 1.2 * long * b0 + rounding
    for _ in range(4):
        more = norm * rest(d, half, r, levers, span)
        a = a0 + norm * curved * r + more
        if not a < 0.9:
            break
        rise = (b0 + bend * r + more) / (1.0 - a)
        if long * rise + rounding <= r:
            return r, half * rise + rounding
        r = 1.2 * (long * rise + rounding)
    return math.inf, math.inf


@inner
def inside(x, lower, upper):
    """The angle x moved by turns to within one of (-pi, pi], nearest to the middle of its limits: as inverse kinematics takes it."""
    if not upper - lower < math.inf:
        return x
    x -= _WHOLE * math.floor(x / _WHOLE + 0.5)
    return x + _WHOLE * min(max(math.floor((0.5 * (lower + upper) - x) / _WHOLE + 0.5), -1.0), 1.0)


@jit
def enclose(J, C, L, K, path, tool, normal, span, levers, lower, upper, A, B, between, middle, half, reach, state):
    """For pieces from postures A to B (b, n) with one `between`: the chord's middle (b, n), half of it (b, n) and the tube's reach.

    state (b,), where it is INSIDE on entry: OPEN if no tube is proved, INSIDE or OUTSIDE if all of it is inside the limits or
    outside of one, CROSSING else. The posture between has to be in the tube: it tells the piece from the rest of a closed curve.
    """
    n = A.shape[1]
    T, X = np.empty((J.shape[0], 12)), np.empty((L.shape[0], 7))
    M, N, E, D = np.empty((n, n)), np.empty((n, n - 1)), np.empty((n - 1, n)), np.empty((n - 1, n))
    W = np.empty((n, 15))
    d, slope, at = np.empty(n), np.empty(n - 1), np.empty(n, np.int64)
    for j in range(n):
        at[j] = J[path[j], 2]
    for b in range(A.shape[0]):
        q, long = middle[b], 0.0
        for c in range(n):
            step = B[b, c] - A[b, c]
            step -= _WHOLE * math.floor(step / _WHOLE + 0.5)
            q[c], half[b, c] = A[b, c] + 0.5 * step, 0.5 * step
            long += step * step
        long = math.sqrt(long)
        if state[b] != INSIDE or not 1e-12 < long < 1.5:
            state[b] = OPEN
            continue
        for j in range(n):
            d[j] = 2.0 * half[b, at[j]] / long
        place(J, C, L[:0], K, q, T, X)
        curved = task_at(T, C, path, tool, normal, span, d, M, E, D, W)
        for j in range(n):
            M[n - 1, j] = d[j]
        r, reach[b] = tube(M, N, E, D, d, slope, long, curved, levers, span)
        along, off = 0.0, 0.0
        for j in range(n):
            step = between[b, at[j]] - q[at[j]]
            step -= _WHOLE * math.floor(step / _WHOLE + 0.5)
            along += step * d[j]
            off += step * step
        if not (reach[b] < math.inf and abs(along) < 0.5 * long and off - along * along <= r * r):
            state[b] = OPEN
            continue
        for c in range(n):
            x = inside(q[c], lower[c], upper[c])
            room = min(x - lower[c], upper[c] - x)
            if room < -abs(half[b, c]) - reach[b]:
                state[b] = OUTSIDE
                break
            if room < abs(half[b, c]) + reach[b]:
                state[b] = CROSSING
