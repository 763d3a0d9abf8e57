"""Points halved again and again across their longest side, and balls round the parts: compiled code."""

from __future__ import annotations

import math

import numpy as np

from ..kernels import jit


@jit
def halve(points, order, first):
    """Reorders points (m, 3), and `order` with them: each stretch first[i] .. first[i + 1] gets its lower half, along its
    longest side, before its middle. Source: Hoare's selection."""
    for node in range(first.shape[0] - 1):
        start, stop = first[node], first[node + 1]
        middle = (start + stop) // 2
        axis, widest = 0, -1.0
        for c in range(3):
            low, high = np.inf, -np.inf
            for i in range(start, stop):
                low, high = min(low, points[i, c]), max(high, points[i, c])
            if high - low > widest:
                axis, widest = c, high - low
        a, b = start, stop - 1
        while a < b and widest > 0.0:
            x, y, z = points[a, axis], points[(a + b) // 2, axis], points[b, axis]
            pivot = max(min(x, y), min(max(x, y), z))
            i, j = a, b
            while i <= j:
                while points[i, axis] < pivot:
                    i += 1
                while points[j, axis] > pivot:
                    j -= 1
                if i <= j:
                    for c in range(3):
                        points[i, c], points[j, c] = points[j, c], points[i, c]
                    order[i], order[j] = order[j], order[i]
                    i += 1
                    j -= 1
            if middle <= j:
                b = j
            elif middle >= i:
                a = i
            else:
                break


@jit
def bound(points, radii, ends, balls):
    """A ball (k, 4) round the balls (m, 3), (m,) of each stretch ends[i] .. ends[i + 1]: about the middle of their box."""
    low, high = np.empty(3), np.empty(3)
    for node in range(ends.shape[0] - 1):
        for c in range(3):
            low[c], high[c] = np.inf, -np.inf
            for i in range(ends[node], ends[node + 1]):
                low[c], high[c] = min(low[c], points[i, c] - radii[i]), max(high[c], points[i, c] + radii[i])
            balls[node, c] = 0.5 * (low[c] + high[c])
        reach = 0.0
        for i in range(ends[node], ends[node + 1]):
            x, y, z = points[i, 0] - balls[node, 0], points[i, 1] - balls[node, 1], points[i, 2] - balls[node, 2]
            reach = max(reach, math.sqrt(x * x + y * y + z * z) + radii[i])
        balls[node, 3] = reach * (1.0 + 1e-12)
