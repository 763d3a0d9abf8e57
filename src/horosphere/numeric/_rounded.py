"""Numbers in words that promise something: what is written holds as it is written."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal

_ALL_DIGITS = Context(prec=700)  # of any float64 to a few hundred places behind the point


def at_least(value: float, digits: int = 4, *, decimals: int | None = None, power: int = 0) -> str:
    """A lower bound, times 10^power, rounded down: to so many significant digits, or to `decimals` behind the point."""
    return _rounded(value, digits, decimals, power, ROUND_FLOOR)


def at_most(value: float, digits: int = 4, *, decimals: int | None = None, power: int = 0) -> str:
    """An upper bound, times 10^power, rounded up: to so many significant digits, or to `decimals` behind the point."""
    return _rounded(value, digits, decimals, power, ROUND_CEILING)


def _rounded(value: float, digits: int, decimals: int | None, power: int, way: str) -> str:
    if not math.isfinite(value):
        return f"{value:g}"
    exact = Decimal(repr(float(value))).scaleb(
        power
    )  # the shortest number that reads back as this one: 0.0235 stays 0.0235
    if decimals is not None:
        rounded = exact.quantize(Decimal(1).scaleb(-decimals), way, _ALL_DIGITS)
        return str(rounded.copy_abs() if rounded.is_zero() else rounded)
    if not exact:
        return "0"
    return f"{float(exact.quantize(Decimal(1).scaleb(exact.adjusted() - digits + 1), way, _ALL_DIGITS)):.{digits}g}"
