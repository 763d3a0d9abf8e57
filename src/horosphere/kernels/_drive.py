"""The loop that carries a traced expression over records: eight at a time on lanes, then the rest one by one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from hashlib import sha256
from math import prod
from typing import Any

from numba import njit
from numba.core import types

from . import _lanes
from ._cache import OPTIONS, attach_cache
from ._trace import Trace

_FROM_LANES = ("EIGHT", "ONE", "array_at", "load_records", "spread", "store_records", "sum_lanes")


ARGUMENTS = (types.intp, types.int64)


def driver(
    trace: Trace,
    inline: Callable,
    axes: Sequence[tuple[int, ...]],
    single: Sequence[bool],
    finite: bool,
    cached: bool = True,
) -> Any:
    """The dispatcher of `int64 kernel(double **arrays, int64 records)`: inputs, then outputs of the given axes.

    `single[k]`: input k is one record that serves all. finite: the last number of the trace says whether the inputs are
    finite; the kernel returns 0 if they are not for some record.
    """
    text = _text(trace, axes, single, finite)
    namespace = {name: getattr(_lanes, name) for name in _FROM_LANES} | {"__name__": __name__, "inline": inline}
    exec(compile(text, "<horosphere-kernel>", "exec"), namespace)
    options: dict[str, Any] = OPTIONS | {"no_cpython_wrapper": True}
    dispatcher = njit(**options)(namespace[trace.name])
    if cached:
        attach_cache(dispatcher, sha256(f"{trace.fingerprint} {text}".encode()).hexdigest())
    return dispatcher


def _text(trace: Trace, axes: Sequence[tuple[int, ...]], single: Sequence[bool], finite: bool) -> str:
    inputs = list(zip(trace.arguments, trace.widths, single, strict=True))
    outs = [f"out{k}" for k in range(len(axes))]
    arrays = [name for name, _, _ in inputs] + outs

    def loads(tag: str) -> str:
        return ", ".join(
            f"*one_{name}" if alone else f"*load_records({name}, i, {width}, {tag})" for name, width, alone in inputs
        )

    def stores() -> list[str]:
        lines, first = [], 0
        for out, shape in zip(outs, axes, strict=True):
            width = prod(shape)
            lines.append(f"        store_records({out}, i, values[{first}:{first + width}])")
            first += width
        return lines

    last = len(trace.outputs) - 1
    lines = [
        f"def {trace.name}(arrays, count):",
        *(f"    {name} = array_at(arrays, {k})" for k, name in enumerate(arrays)),
        *(f"    one_{name} = load_records({name}, 0, {width}, ONE)" for name, width, alone in inputs if alone),
        "    whole = count // 8 * 8",
        *(["    zeros, zero = spread(0.0, EIGHT), 0.0"] if finite else []),
        "    for i in range(0, whole, 8):",
        f"        values = inline({loads('EIGHT')})",
        *stores(),
        *([f"        zeros = zeros + values[{last}] * 0.0"] if finite else []),
        "    for i in range(whole, count):",
        f"        value = inline({loads('ONE')})",
        *(line.replace("values", "value") for line in stores()),
        *([f"        zero = zero + value[{last}] * 0.0"] if finite else []),
        "    return int(sum_lanes(zeros) + zero == 0.0)" if finite else "    return 1",
    ]
    return "\n".join(lines)
