"""Integrators of the wheeled links' absolute angles, and their derivatives with respect to piecewise constant inputs.

Runge-Kutta of order 8 with 11 stages (Cooper and Verner 1972): its nodes are those of 5-point Lobatto quadrature, so an
input needs five values a step. `rate` is 1/(f length) of links 1 .. N-1, `ratio` is (1-f)/f.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from horosphere.kernels import jit

_ROOT = Fraction(math.isqrt(21 * 10**80), 10**40)  # of 21


def _pair(values: list[Fraction]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Numbers rounded to floats, and what the rounding left."""
    high = [float(v) for v in values]
    return np.array(high), np.array([float(v - Fraction(h)) for v, h in zip(values, high)])


# entries (a + b sqrt 21) / d as (a, b, d), column by column where not zero
_STAGES: tuple[dict[int, tuple[int, int, int]], ...] = (
    {},
    {0: (1, 0, 2)},
    {0: (1, 0, 4), 1: (1, 0, 4)},
    {0: (1, 0, 7), 1: (-7, -3, 98), 2: (21, 5, 49)},
    {0: (11, 1, 84), 2: (18, 4, 63), 3: (21, -1, 252)},
    {0: (5, 1, 48), 2: (9, 1, 36), 3: (-231, 14, 360), 4: (63, -7, 80)},
    {0: (10, -1, 42), 2: (-432, 92, 315), 3: (633, -145, 90), 4: (-504, 115, 70), 5: (63, -13, 35)},
    {0: (1, 0, 14), 4: (14, -3, 126), 5: (13, -3, 63), 6: (1, 0, 9)},
    {0: (1, 0, 32), 4: (91, -21, 576), 5: (11, 0, 72), 6: (-385, -75, 1152), 7: (63, 13, 128)},
    {0: (1, 0, 14), 4: (1, 0, 9), 5: (-733, -147, 2205), 6: (515, 111, 504), 7: (-51, -11, 56), 8: (132, 28, 245)},
    {4: (-42, 7, 18), 5: (-18, 28, 45), 6: (-273, -53, 72), 7: (301, 53, 72), 8: (28, -28, 45), 9: (49, -7, 18)},
)
_STAGE_WEIGHTS = {0: (1, 0, 20), 7: (49, 0, 180), 8: (16, 0, 45), 9: (49, 0, 180), 10: (1, 0, 20)}


def _row(entries: dict[int, tuple[int, int, int]]) -> list[Fraction]:
    return [(a + b * _ROOT) / d for a, b, d in (entries.get(i, (0, 0, 1)) for i in range(11))]


_S = float(_ROOT)
NODES = np.array([0.0, 0.5, (7 + _S) / 14, (7 - _S) / 14, 1.0])
NODE_WEIGHTS = np.array([1 / 20, 16 / 45, 49 / 180, 49 / 180, 1 / 20])
STAGE_NODE = np.array([0, 1, 1, 2, 2, 1, 3, 3, 1, 2, 4])
WEIGHTS = _pair(_row(_STAGE_WEIGHTS))
TABLEAU = tuple(part.reshape(11, 11) for part in _pair([v for row in _STAGES for v in _row(row)]))
_A, _B, _STAGE_NODE = TABLEAU[0], WEIGHTS[0], STAGE_NODE


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
