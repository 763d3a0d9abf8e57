"""Float postures read as exact rational ones."""

from __future__ import annotations

from fractions import Fraction
from math import pi, tan

import numpy as np
from numpy.typing import NDArray

from ..numeric import wrap_angle

Direction = tuple[Fraction, Fraction]

_SAME = 16 * float(np.finfo(float).eps)  # two angles this close are one angle that went through rounding


def exact_number(value: float) -> Fraction:
    """The decimal number that a float prints as: 0.4 is 2/5, 2.0 is 2."""
    return Fraction(repr(float(value)))


def exact_directions(angles: NDArray[np.float64]) -> list[Direction]:
    """Exact rational (cos, sin) for each angle, radians, within 1e-15 of the float.

    Angles that agree to rounding get the same direction, opposite ones mirrored directions, supplementary ones
    directions mirrored in the other axis; 0, pi and +-pi/2 are themselves. Any other angle becomes the point of
    the unit circle with the simplest rational tan of the half angle that rounds to the float's.
    """
    wrapped = [float(a) if abs(a) <= pi else float(wrap_angle(a)) for a in angles]
    tolerance = [_SAME * max(1.0, abs(float(a))) for a in angles]
    known: list[tuple[float, Direction]] = [(0.0, (Fraction(1), Fraction(0))), (pi / 2, (Fraction(0), Fraction(1)))]
    directions = []
    for angle, slack in zip(wrapped, tolerance):
        size = abs(angle)
        acute = min(size, pi - size)
        match = [pair for reference, pair in known if abs(acute - reference) <= slack]
        if match:
            c, s = match[0]
        else:
            c, s = _rational(acute)
            known.append((acute, (c, s)))
        directions.append((-c if size > pi / 2 else c, -s if angle < 0 else s))
    return directions


def _rational(angle: float) -> Direction:
    t = Fraction(tan(angle / 2))
    t = _simplest(t - t / (1 << 54), t + t / (1 << 54))
    square = t * t
    return (1 - square) / (1 + square), 2 * t / (1 + square)


def _simplest(low: Fraction, high: Fraction) -> Fraction:
    """The fraction of least denominator in [low, high], 0 < low < high."""
    whole = low.numerator // low.denominator
    if whole == low:
        return Fraction(whole)
    if whole + 1 <= high:
        return Fraction(whole + 1)
    return whole + 1 / _simplest(1 / (high - whole), 1 / (low - whole))
