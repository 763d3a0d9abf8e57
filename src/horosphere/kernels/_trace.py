"""A traced function: its graph, printed as Python or evaluated with numpy (the reference back end)."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ._graph import Graph, Symbol, operands
from ._multivector import MV

# What an argument of a traced function is: a tuple of blades (it arrives as an MV), `scalars(n)` (a list of n symbols),
# or None (one symbol).
ArgumentType = tuple[int, ...] | int | None

_NUMPY: dict[str, Callable] = {
    "*": np.multiply,
    "/": np.divide,
    "atom": lambda x: x,
    "sqrt": np.sqrt,
    "fabs": np.abs,
    "floor": np.floor,
    "rint": np.rint,
    "min": np.minimum,
    "max": np.maximum,
    "where_lt": lambda a, b, x, y: np.where(np.less(a, b), x, y),
}


def scalars(n: int) -> int:
    """The type of an argument that is an (..., n) array of plain numbers."""
    return n


@dataclass(frozen=True)
class Trace:
    """The graph of one function: `widths[k]` numbers come in by argument k, the nodes `outputs` go out."""

    name: str
    arguments: tuple[str, ...]
    widths: tuple[int, ...]
    graph: Graph
    outputs: tuple[int, ...]

    @staticmethod
    def of(name: str, function: Callable, types: dict[str, ArgumentType], layout: Sequence[int] | int) -> Trace:
        """Run `function` on symbols. `layout`: the blades of its MV result, or how many numbers it returns."""
        graph, arguments, first = Graph(), [], 0
        for kind in types.values():
            width = _width(kind)
            symbols: list = [graph.add("in", first + k) for k in range(width)]
            first += width
            arguments.append(
                MV.of(kind, symbols) if isinstance(kind, tuple) else symbols[0] if kind is None else symbols
            )
        result = function(*arguments)
        values = list(result) if isinstance(layout, int) else result.on(layout)
        if isinstance(layout, int) and len(values) != layout:
            raise TypeError(f"{name} returns {len(values)} numbers, {layout} were declared")
        outputs = tuple((v if isinstance(v, Symbol) else graph.constant(v)).index for v in values)
        return Trace(name, tuple(types), tuple(_width(kind) for kind in types.values()), graph, outputs)

    def with_sum_of_inputs(self) -> Trace:
        """The same with one more output: NaN or infinite when an input is (or when the sum overflows)."""
        inputs = {self.graph.add("in", k).index: 1.0 for k in range(sum(self.widths))}
        total = self.graph.linear(inputs)
        return replace(self, outputs=(*self.outputs, total.index))

    @cached_property
    def live(self) -> list[int]:
        """The nodes that the outputs need, operands first."""
        seen, stack = set(), list(self.outputs)
        while stack:
            i = stack.pop()
            if i not in seen:
                seen.add(i)
                stack += operands(self.graph.nodes[i])
        return sorted(seen)

    @cached_property
    def uses(self) -> dict[int, int]:
        """How often each live node is read."""
        count: dict[int, int] = dict.fromkeys(self.live, 0)
        for i in [j for node in self.live for j in operands(self.graph.nodes[node])] + list(self.outputs):
            count[i] += 1
        return count

    @cached_property
    def fingerprint(self) -> str:
        """A hash of the expression: what the disk cache files compiled code under."""
        text = repr((self.name, self.widths, self.outputs, [(i, self.graph.nodes[i]) for i in self.live]))
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def evaluate(self, inputs: Sequence[Any]) -> list[Any]:
        """The outputs for these input numbers or arrays, by numpy, one operation at a time."""
        values: dict[int, Any] = {}
        for i in self.live:
            node = self.graph.nodes[i]
            if node[0] == "in":
                values[i] = inputs[node[1]]
            elif node[0] == "const":
                values[i] = node[1]
            elif node[0] == "sum":
                values[i] = sum(c if j < 0 else c * values[j] for j, c in node[1])
            else:
                values[i] = _NUMPY[node[0]](*(values[j] for j in node[1:]))
        return [values[i] for i in self.outputs]

    def source(self) -> str:
        """The trace as straight-line Python, one assignment per shared or called node: for reading."""
        names = [f"{a}{k}" if w > 1 else a for a, w in zip(self.arguments, self.widths, strict=True) for k in range(w)]
        text: dict[int, str] = {}
        lines = []
        for i in self.live:
            node = self.graph.nodes[i]
            kind = node[0]
            if kind == "in":
                text[i] = names[node[1]]
                continue
            if kind == "const":
                text[i] = repr(node[1])
                continue
            if kind == "sum":
                expression = _sum_text(node[1], text)
            elif kind in "*/":
                expression = f"{text[node[1]]} {kind} {text[node[2]]}"
            elif kind == "atom":
                expression = text[node[1]]
            else:
                expression = f"{kind}({', '.join(text[j] for j in node[1:])})"
            if self.uses[i] > 1 or kind not in ("sum", "*", "/"):
                lines.append(f"    v{i} = {expression}")
                text[i] = f"v{i}"
            else:
                text[i] = f"({expression})"
        returned = ", ".join(text[i] for i in self.outputs)
        return "\n".join([f"def {self.name}({', '.join(names)}):", *lines, f"    return ({returned},)"]) + "\n"

    def operations(self) -> dict[str, int]:
        """How many additions, multiplications and calls one evaluation costs."""
        count: dict[str, int] = {}
        for i in self.live:
            node = self.graph.nodes[i]
            if node[0] == "sum":
                count["+"] = count.get("+", 0) + len(node[1]) - 1
                count["*"] = count.get("*", 0) + len({abs(c) for _, c in node[1]} - {1.0})
            elif node[0] not in ("in", "const", "atom"):
                count[node[0]] = count.get(node[0], 0) + 1
        return count


def _width(kind: ArgumentType) -> int:
    return len(kind) if isinstance(kind, tuple) else 1 if kind is None else kind


def _sum_text(form, text: dict[int, str]) -> str:
    parts = []
    for j, c in form:
        name = "" if j < 0 else text[j]
        size = repr(abs(c)) if j < 0 else name if abs(c) == 1.0 else f"{abs(c)!r} * {name}"
        parts.append((" - " if c < 0 else " + ") + size)
    head = parts[0][3:] if parts[0].startswith(" + ") else "-" + parts[0][3:]
    return head + "".join(parts[1:])
