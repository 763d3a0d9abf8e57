"""Numbers on the command line: a number that is not whole is no count, and is not rounded to one."""

from __future__ import annotations

from typing import Annotated, Any

from cyclopts import Parameter


def _whole(_: Any, tokens: Any) -> int:
    text = tokens[0].value
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"expected a whole number, got {text!r}") from None


Whole = Annotated[int, Parameter(converter=_whole)]
