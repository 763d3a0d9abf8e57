"""Numbers and linear combinations as text and as LaTeX."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def number(x: float) -> str:
    """Six significant digits, no trailing zeros, no minus on zero."""
    return f"{float(x) + 0.0:.6g}"


def vector(v: np.ndarray) -> str:
    """`[x, y, z]` with short numbers; what is below 1e-15 of the largest is printed as 0."""
    floor = 1e-15 * np.abs(v).max(initial=0.0)
    return "[" + ", ".join(number(x if abs(x) > floor or x != x else 0.0) for x in v) + "]"


def combination(coefficients: np.ndarray, names: Sequence[str], latex: bool = False) -> str:
    """`1 + 2 e12 - e3`: terms above 1e-15 of the largest coefficient; "0" when there is none."""
    largest = np.abs(coefficients).max(initial=0.0)
    text = ""
    for c, name in zip(coefficients, names, strict=True):
        if abs(c) <= 1e-15 * largest:
            continue
        size = number(abs(c))
        if latex and "e" in size:
            mantissa, exponent = size.split("e")
            size = rf"{mantissa}\cdot 10^{{{int(exponent)}}}"
        gap = r"\," if latex else " "
        term = size if name == "1" else name if size == "1" else f"{size}{gap}{name}"
        text += (" - " if c < 0 else " + ") + term if text else ("-" if c < 0 else "") + term
    return text or "0"


def latex_name(name: str) -> str:
    """LaTeX of a blade name: `e123` -> `e_{123}`, null-basis digits 0 and i as subscripts (i is infinity)."""
    if name in ("1", ""):
        return "1"
    digits = name.removeprefix("e").replace("i", r"\infty ")
    return f"e_{{{digits}}}"
