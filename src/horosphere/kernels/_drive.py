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

_WIDE, _AHEAD = 14, 48
"""Numbers a record from which on the inputs are asked for ahead, and by how many records: out of cache the processor's own guesses
fall short of a copy's speed where long records of two arrays are read at once. In cache it costs a few percent."""
_FROM_LANES = (
    "EIGHT",
    "ONE",
    "array_at",
    "load_records",
    "no_lanes",
    "prefetch_records",
    "spread",
    "store_records",
    "sum_lanes",
)


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
    batched = [(name, width) for name, width, alone in inputs if not alone]

    def loads(at: str, indent: str) -> list[str]:
        return [f"{indent}next_{name} = load_records({name}, {at}, {width}, EIGHT)" for name, width in batched]

    def call(source: str) -> str:
        return f"inline(*({' + '.join(f'one_{n}' if alone else f'{source}_{n}' for n, _, alone in inputs)}))"

    def stores(values: str, at: str, indent: str) -> list[str]:
        lines, first = [], 0
        for out, shape in zip(outs, axes, strict=True):
            width = prod(shape)
            lines.append(f"{indent}store_records({out}, {at}, {values}[{first}:{first + width}])")
            first += width
        return lines

    ahead = batched if sum(width for _, width in batched) >= _WIDE else []
    last = len(trace.outputs) - 1
    lines = [
        f"def {trace.name}(arrays, count):",
        *(f"    {name} = array_at(arrays, {k})" for k, name in enumerate(arrays)),
        *(f"    one_{name} = load_records({name}, 0, {width}, ONE)" for name, width, alone in inputs if alone),
        "    whole = count // 8 * 8",
        *(["    zeros, zero = spread(0.0, EIGHT), 0.0"] if finite else []),
        "    if whole > 0:",
        *loads("0", " " * 8),
        f"        values = no_lanes({len(trace.outputs)}, EIGHT)",
        "        for i in range(0, whole + 8, 8):",
        "            done = values",
        *([f"            zeros = zeros + done[{last}] * 0.0"] if finite else []),
        f"            values = {call('next')}",
        *loads("i + 8 if i + 8 < whole else 0", " " * 12),
        *stores("done", "i - 8 if i > 0 else 0", " " * 12),
        *(f"            prefetch_records({name}, i + {_AHEAD}, {width})" for name, width in ahead),
        "    for i in range(whole, count):",
        *(f"        last_{name} = load_records({name}, i, {width}, ONE)" for name, width in batched),
        f"        value = {call('last')}",
        *stores("value", "i", " " * 8),
        *([f"        zero = zero + value[{last}] * 0.0"] if finite else []),
        "    return int(sum_lanes(zeros) + zero == 0.0)" if finite else "    return 1",
    ]
    return "\n".join(lines)
