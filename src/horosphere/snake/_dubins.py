"""Shortest curves of bounded curvature between two directed points of the plane (Dubins 1957)."""

from __future__ import annotations

from math import acos, atan2, cos, hypot, pi, sin, sqrt

import numpy as np
from numpy.typing import NDArray


def _turn(angle: float) -> float:
    """In [0, 2 pi), with what rounding leaves just under a full turn taken as none."""
    angle %= 2.0 * pi
    return 0.0 if angle > 2.0 * pi - 1e-9 else angle


def _words(d: float, a: float, b: float) -> list[tuple[str, tuple[float, float, float]]]:
    """The six candidate curves for unit radius: goal at distance d along the axis, headings a and b from it."""
    sa, ca, sb, cb, cab = sin(a), cos(a), sin(b), cos(b), cos(a - b)
    found = []
    square = 2.0 + d * d - 2.0 * cab + 2.0 * d * (sa - sb)
    if square >= 0:
        t = atan2(cb - ca, d + sa - sb)
        found.append(("LSL", (_turn(t - a), sqrt(square), _turn(b - t))))
    square = 2.0 + d * d - 2.0 * cab + 2.0 * d * (sb - sa)
    if square >= 0:
        t = atan2(ca - cb, d - sa + sb)
        found.append(("RSR", (_turn(a - t), sqrt(square), _turn(t - b))))
    square = -2.0 + d * d + 2.0 * cab + 2.0 * d * (sa + sb)
    if square >= 0:
        p = sqrt(square)
        t = atan2(-ca - cb, d + sa + sb) - atan2(-2.0, p)
        found.append(("LSR", (_turn(t - a), p, _turn(t - b))))
    square = -2.0 + d * d + 2.0 * cab - 2.0 * d * (sa + sb)
    if square >= 0:
        p = sqrt(square)
        t = atan2(ca + cb, d - sa - sb) - atan2(2.0, p)
        found.append(("RSL", (_turn(a - t), p, _turn(b - t))))
    value = (6.0 - d * d + 2.0 * cab + 2.0 * d * (sa - sb)) / 8.0
    if abs(value) <= 1:
        p = _turn(2.0 * pi - acos(value))
        t = _turn(a - atan2(ca - cb, d - sa + sb) + 0.5 * p)
        found.append(("RLR", (t, p, _turn(a - b - t + p))))
    value = (6.0 - d * d + 2.0 * cab + 2.0 * d * (sb - sa)) / 8.0
    if abs(value) <= 1:
        p = _turn(2.0 * pi - acos(value))
        t = _turn(-a - atan2(ca - cb, d + sa - sb) + 0.5 * p)
        found.append(("LRL", (t, p, _turn(b - a - t + p))))
    return sorted(found, key=lambda item: sum(item[1]))


def dubins(
    start: tuple[float, float, float], goal: tuple[float, float, float], radius: float, step: float
) -> list[NDArray[np.float64]]:
    """Curves (k, 3) of (x, y, heading) from start to goal, shortest first, sampled every `step` metres or less."""
    dx, dy = (goal[0] - start[0]) / radius, (goal[1] - start[1]) / radius
    base = atan2(dy, dx)
    curves = []
    for word, parts in _words(hypot(dx, dy), start[2] - base, goal[2] - base):
        x, y, heading = start
        rows = [np.array([[x, y, heading]])]
        for letter, part in zip(word, parts):
            count = max(1, int(np.ceil(part * radius / step)))
            s = np.linspace(0.0, part, count + 1)[1:]
            if letter == "S":
                block = np.stack(
                    [x + radius * s * cos(heading), y + radius * s * sin(heading), np.full(count, heading)], axis=1
                )
            else:
                way = 1.0 if letter == "L" else -1.0
                angles = heading + way * s
                block = np.stack(
                    [
                        x + radius * way * (np.sin(angles) - sin(heading)),
                        y - radius * way * (np.cos(angles) - cos(heading)),
                        angles,
                    ],
                    axis=1,
                )
            rows.append(block)
            x, y, heading = (float(v) for v in block[-1])
        curve = np.concatenate(rows)
        if np.hypot(curve[-1, 0] - goal[0], curve[-1, 1] - goal[1]) < 1e-6 * max(1.0, radius):
            curves.append(curve)
    return curves
