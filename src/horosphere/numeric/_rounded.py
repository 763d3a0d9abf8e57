"""Numbers in words that promise something: what is written holds as it is written."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal


def at_least(value: float, digits: int = 4, *, decimals: int | None = None, power: int = 0) -> str:
    """A lower bound, times 10^power, rounded down: to so many significant digits, or to `decimals` behind the point."""
    return _rounded(value, digits, decimals, power, ROUND_FLOOR)


def at_most(value: float, digits: int = 4, *, decimals: int | None = None, power: int = 0) -> str:
    """An upper bound, times 10^power, rounded up: to so many significant digits, or to `decimals` behind the point."""
    return _rounded(value, digits, decimals, power, ROUND_CEILING)


def _rounded(value: float, digits: int, decimals: int | None, power: int, way: str) -> str:
    if not math.isfinite(value):
        return f"{value:g}"
    exact = Decimal(repr(float(value) + 0.0)).scaleb(
        power
    )  # the shortest number that reads back as this one, so 0.0235 stays 0.0235
    if decimals is not None:
        return str(exact.quantize(Decimal(1).scaleb(-decimals), way))
    if not exact:
        return "0"
    return f"{float(exact.quantize(Decimal(1).scaleb(exact.adjusted() - digits + 1), way)):.{digits}g}"
