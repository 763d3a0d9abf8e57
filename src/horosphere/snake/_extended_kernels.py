"""The integrator of `_kernels` in pairs of floats (about 32 digits), for motions that amplify the rounding of single floats.

A number is high + low with |low| <= half a unit in the last place of high (Dekker 1971). The state of a link is its direction
(cos, sin), so that no sine need be taken in pairs; its angle is integrated beside it.
"""

from __future__ import annotations

import numpy as np

from horosphere.kernels import jit

from ._kernels import STAGE_NODE, TABLEAU, WEIGHTS

_A, _A_LOW = TABLEAU
_B, _B_LOW = WEIGHTS
_exact = jit(fastmath=False)  # fused operations would lose what the pairs keep


@_exact
def add(ah, al, bh, bl):
    """Sum of two pairs."""
    total = ah + bh
    part = total - ah
    rest = (ah - (total - part)) + (bh - part) + (al + bl)
    high = total + rest
    return high, rest - (high - total)


@_exact
def multiply(ah, al, bh, bl):
    """Product of two pairs; the halves' products are exact."""
    product = ah * bh
    t = 134217729.0 * ah
    a1 = t - (t - ah)
    a2 = ah - a1
    t = 134217729.0 * bh
    b1 = t - (t - bh)
    b2 = bh - b1
    rest = ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2
    rest += ah * bl + al * bh
    high = product + rest
    return high, rest - (high - product)


@_exact
def extended_flow(theta, trig, inputs, steps, rate, ratio, out):
    """As `_kernels.flow`; `trig` (k, 4) holds cos and sin of `theta` in pairs; `out` (steps + 1, k) is rounded."""
    count, k = steps.shape[0], theta.shape[0]
    state = np.zeros((k, 3, 2))  # cos, sin, angle
    slope = np.zeros((11, k, 3, 2))
    scaled = np.zeros((12, 11, 2))
    for j in range(k):
        state[j, 0, 0], state[j, 0, 1], state[j, 1, 0], state[j, 1, 1] = trig[j, 0], trig[j, 1], trig[j, 2], trig[j, 3]
        state[j, 2, 0] = theta[j]
        out[0, j] = theta[j]
    before = 0.0
    for n in range(count):
        h = steps[n]
        if h != before:
            before = h
            for i in range(11):
                for j in range(11):
                    scaled[i, j, 0], scaled[i, j, 1] = multiply(_A[i, j], _A_LOW[i, j], h, 0.0)
                scaled[11, i, 0], scaled[11, i, 1] = multiply(_B[i], _B_LOW[i], h, 0.0)
        for stage in range(11):
            node = STAGE_NODE[stage]
            uxh, uxl, uyh, uyl = inputs[n, node, 0], 0.0, inputs[n, node, 1], 0.0
            for j in range(k):
                ch, cl, sh, sl = state[j, 0, 0], state[j, 0, 1], state[j, 1, 0], state[j, 1, 1]
                for i in range(stage):
                    ah, al = scaled[stage, i, 0], scaled[stage, i, 1]
                    if ah != 0.0:
                        ph, pl = multiply(ah, al, slope[i, j, 0, 0], slope[i, j, 0, 1])
                        ch, cl = add(ch, cl, ph, pl)
                        ph, pl = multiply(ah, al, slope[i, j, 1, 0], slope[i, j, 1, 1])
                        sh, sl = add(sh, sl, ph, pl)
                # across = c uy - s ux, along = c ux + s uy
                ph, pl = multiply(ch, cl, uyh, uyl)
                qh, ql = multiply(-sh, -sl, uxh, uxl)
                xh, xl = add(ph, pl, qh, ql)
                ph, pl = multiply(ch, cl, uxh, uxl)
                qh, ql = multiply(sh, sl, uyh, uyl)
                yh, yl = add(ph, pl, qh, ql)
                wh, wl = multiply(xh, xl, -rate[j], 0.0)
                slope[stage, j, 0, 0], slope[stage, j, 0, 1] = multiply(-sh, -sl, wh, wl)
                slope[stage, j, 1, 0], slope[stage, j, 1, 1] = multiply(ch, cl, wh, wl)
                slope[stage, j, 2, 0], slope[stage, j, 2, 1] = wh, wl
                # u = d along - ratio n across
                xh, xl = multiply(xh, xl, ratio, 0.0)
                ph, pl = multiply(ch, cl, yh, yl)
                qh, ql = multiply(sh, sl, xh, xl)
                uxh, uxl = add(ph, pl, qh, ql)
                ph, pl = multiply(sh, sl, yh, yl)
                qh, ql = multiply(-ch, -cl, xh, xl)
                uyh, uyl = add(ph, pl, qh, ql)
        for j in range(k):
            for part in range(3):
                ah, al = state[j, part, 0], state[j, part, 1]
                for i in range(11):
                    bh, bl = scaled[11, i, 0], scaled[11, i, 1]
                    if bh != 0.0:
                        ph, pl = multiply(bh, bl, slope[i, j, part, 0], slope[i, j, part, 1])
                        ah, al = add(ah, al, ph, pl)
                state[j, part, 0], state[j, part, 1] = ah, al
            out[n + 1, j] = state[j, 2, 0]
