"""Integrators of the wheeled links' absolute angles, and their derivatives with respect to piecewise constant inputs.

Runge-Kutta of order 8 with 11 stages (Cooper and Verner 1972): its nodes are those of 5-point Lobatto quadrature, so an
input needs five values a step. `rate` is 1/(f length) of links 1 .. N-1, `ratio` is (1-f)/f.
"""

from __future__ import annotations

import math

import numpy as np

from horosphere.kernels import jit

_S = math.sqrt(21.0)
NODES = np.array([0.0, 0.5, (7 + _S) / 14, (7 - _S) / 14, 1.0])
NODE_WEIGHTS = np.array([1 / 20, 16 / 45, 49 / 180, 49 / 180, 1 / 20])
_STAGE_NODE = np.array([0, 1, 1, 2, 2, 1, 3, 3, 1, 2, 4])
_B = np.array([1 / 20, 0, 0, 0, 0, 0, 0, 49 / 180, 16 / 45, 49 / 180, 1 / 20])
_A = np.zeros((11, 11))
_A[1, 0] = 1 / 2
_A[2, :2] = 1 / 4, 1 / 4
_A[3, :3] = 1 / 7, (-7 - 3 * _S) / 98, (21 + 5 * _S) / 49
_A[4, :4] = (11 + _S) / 84, 0, (18 + 4 * _S) / 63, (21 - _S) / 252
_A[5, :5] = (5 + _S) / 48, 0, (9 + _S) / 36, (-231 + 14 * _S) / 360, (63 - 7 * _S) / 80
_A[6, :6] = (
    (10 - _S) / 42,
    0,
    (-432 + 92 * _S) / 315,
    (633 - 145 * _S) / 90,
    (-504 + 115 * _S) / 70,
    (63 - 13 * _S) / 35,
)
_A[7, :7] = 1 / 14, 0, 0, 0, (14 - 3 * _S) / 126, (13 - 3 * _S) / 63, 1 / 9
_A[8, :8] = 1 / 32, 0, 0, 0, (91 - 21 * _S) / 576, 11 / 72, (-385 - 75 * _S) / 1152, (63 + 13 * _S) / 128
_A[9, :9] = (
    1 / 14,
    0,
    0,
    0,
    1 / 9,
    (-733 - 147 * _S) / 2205,
    (515 + 111 * _S) / 504,
    (-51 - 11 * _S) / 56,
    (132 + 28 * _S) / 245,
)
_A[10, 4:7] = (-42 + 7 * _S) / 18, (-18 + 28 * _S) / 45, (-273 - 53 * _S) / 72
_A[10, 7:10] = (301 + 53 * _S) / 72, (28 - 28 * _S) / 45, (49 - 7 * _S) / 18


@jit
def flow(theta, inputs, steps, rate, ratio, out):
    """Angles after every step: `inputs` (steps, 5, 2) at the nodes, `steps` (steps,) durations, `out` (steps + 1, k)."""
    count, k = steps.shape[0], theta.shape[0]
    slope = np.zeros((11, k))
    rest = np.zeros(k)
    for j in range(k):
        out[0, j] = theta[j]
    for n in range(count):
        h = steps[n]
        for stage in range(11):
            node = _STAGE_NODE[stage]
            ux, uy = inputs[n, node, 0], inputs[n, node, 1]
            for j in range(k):
                angle = out[n, j]
                for i in range(stage):
                    angle += h * _A[stage, i] * slope[i, j]
                s, c = math.sin(angle), math.cos(angle)
                across = c * uy - s * ux
                along = c * ux + s * uy
                slope[stage, j] = -rate[j] * across
                ux = c * along + ratio * s * across
                uy = s * along - ratio * c * across
        for j in range(k):
            # compensated sum: driving back amplifies every rounding error as exp(2 s / length)
            change = rest[j]
            for i in range(11):
                change += h * _B[i] * slope[i, j]
            total = out[n, j] + change
            rest[j] = change - (total - out[n, j])
            out[n + 1, j] = total


@jit
def segment_flow(theta, inputs, duration, sub, rate, ratio, chain, ends, tangent):
    """Ends (m, k) of m segments of equal `duration` and constant `inputs` (m, 2) from starts `theta` (m, k), in `sub` steps each.

    `tangent` (m, k, k + 2): derivative of the ends by start and input. `chain`: each segment starts where the last one ended.
    """
    count, k = theta.shape
    h = duration / sub
    width = k + 2
    slope = np.zeros((11, k))
    slopes = np.zeros((11, k, width))
    dux, duy, dth = np.zeros(width), np.zeros(width), np.zeros(width)
    angles, rest = np.zeros(k), np.zeros(k)
    for m in range(count):
        for j in range(k):
            if chain and m > 0:
                theta[m, j] = ends[m - 1, j]
            else:
                rest[j] = 0.0
            angles[j] = theta[m, j]
            for c_ in range(width):
                tangent[m, j, c_] = 1.0 if c_ == j else 0.0
        for _ in range(sub):
            for stage in range(11):
                ux, uy = inputs[m, 0], inputs[m, 1]
                for c_ in range(width):
                    dux[c_] = 1.0 if c_ == k else 0.0
                    duy[c_] = 1.0 if c_ == k + 1 else 0.0
                for j in range(k):
                    angle = angles[j]
                    for c_ in range(width):
                        dth[c_] = tangent[m, j, c_]
                    for i in range(stage):
                        a = h * _A[stage, i]
                        if a != 0.0:
                            angle += a * slope[i, j]
                            for c_ in range(width):
                                dth[c_] += a * slopes[i, j, c_]
                    s, c = math.sin(angle), math.cos(angle)
                    across = c * uy - s * ux
                    along = c * ux + s * uy
                    w = -rate[j]
                    slope[stage, j] = w * across
                    for c_ in range(width):
                        d_across = c * duy[c_] - s * dux[c_] - along * dth[c_]
                        d_along = c * dux[c_] + s * duy[c_] + across * dth[c_]
                        slopes[stage, j, c_] = w * d_across
                        # u' = d (d.u) - ratio n (n.u), and d turns into n, n into -d
                        first = d_along + ratio * across * dth[c_]
                        second = along * dth[c_] - ratio * d_across
                        dux[c_] = c * first - s * second
                        duy[c_] = s * first + c * second
                    ux = c * along + ratio * s * across
                    uy = s * along - ratio * c * across
            for j in range(k):
                change = rest[j]
                for i in range(11):
                    b = h * _B[i]
                    if b != 0.0:
                        change += b * slope[i, j]
                        for c_ in range(width):
                            tangent[m, j, c_] += b * slopes[i, j, c_]
                total = angles[j] + change
                rest[j] = change - (total - angles[j])
                angles[j] = total
        for j in range(k):
            ends[m, j] = angles[j]


@jit
def arrow_solve(matrix, width, border, right):
    """Solve in place for a symmetric positive matrix (n, n), zero beyond `width` of the diagonal but for the last `border` rows.

    By Cholesky within that pattern, which has no fill: 50 times less work than a dense solve here, and no BLAS threads.
    """
    n = right.shape[0]
    for i in range(n):
        first = 0 if i >= n - border else max(0, i - width)
        for j in range(first, i + 1):
            start = first if j >= n - border else max(first, j - width)
            total = matrix[i, j]
            for c in range(start, j):
                total -= matrix[i, c] * matrix[j, c]
            matrix[i, j] = math.sqrt(max(total, 1e-300)) if i == j else total / matrix[j, j]
    for i in range(n):
        first = 0 if i >= n - border else max(0, i - width)
        total = right[i]
        for c in range(first, i):
            total -= matrix[i, c] * right[c]
        right[i] = total / matrix[i, i]
    for i in range(n - 1, -1, -1):
        right[i] /= matrix[i, i]
        first = 0 if i >= n - border else max(0, i - width)
        for c in range(first, i):
            right[c] -= matrix[i, c] * right[i]
