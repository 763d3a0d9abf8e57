"""Angles of the wheeled links in extended precision, where driving back amplifies the rounding of floats."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_BITS = 160
_ONE = 1 << _BITS


def extended_angles(theta: Array, inputs: Array, steps: Array, rate: Array, ratio: float) -> Array:
    """Angles (s + 1, k) after every step, as `_kernels.flow`, computed with about 32 digits and rounded at the end."""
    from ._extended_kernels import extended_flow

    out = np.empty((len(steps) + 1, len(theta)))
    trig = np.array([direction(float(angle)) for angle in theta]).reshape(-1, 4)
    start = np.array(theta, dtype=np.float64)
    extended_flow(start, trig, np.ascontiguousarray(inputs), np.array(steps), np.array(rate), float(ratio), out)
    return out


def direction(angle: float) -> tuple[float, float, float, float]:
    """Cosine and sine of an angle, each as a float and the rest."""
    numerator, denominator = angle.as_integer_ratio()
    x = (numerator << _BITS) // (denominator << 12)  # angle / 4096, then twelve doublings of the angle
    cos, sin, term, n = _ONE, 0, _ONE, 0
    while term and n < 200:
        n += 1
        term = (term * x >> _BITS) // n
        if n % 2:
            sin += -term if n % 4 == 3 else term
        else:
            cos += -term if n % 4 == 2 else term
    for _ in range(12):
        cos, sin = (cos * cos - sin * sin) >> _BITS, (2 * sin * cos) >> _BITS
    return (*_pair(cos), *_pair(sin))


def _pair(value: int) -> tuple[float, float]:
    exact = Fraction(value, _ONE)
    high = float(exact)
    return high, float(exact - Fraction(high))


def two_to(x: float) -> float:
    """The power of two next above x: a factor that changes no digit."""
    return 2.0 ** math.ceil(math.log2(x))
