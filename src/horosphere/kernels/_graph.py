"""Symbolic scalars: arithmetic on them builds a hash-consed graph, so equal expressions are one node.

A sum is kept as a flat linear form {node: coefficient}, so commutators cancel and constants fold; a product treats a
sum as an atom, so nested products keep their shared parts. Nodes are tuples:

    ("in", index)   ("const", value)   ("sum", ((node, coefficient), ...))   ("*", i, j)   ("/", i, j)
    ("atom", i)     (function name, i, j, ...)

In a sum, node -1 stands for the constant 1.
"""

from __future__ import annotations

Node = tuple


class Graph:
    """The nodes of one trace; `add` returns the symbol of an existing equal node where there is one."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._index: dict[Node, int] = {}

    def add(self, *node) -> Symbol:
        index = self._index.get(node)
        if index is None:
            index = self._index[node] = len(self.nodes)
            self.nodes.append(node)
        return Symbol(self, index)

    def constant(self, value: float) -> Symbol:
        return self.add("const", float(value) + 0.0)  # + 0.0: minus zero is zero

    def linear(self, terms: dict[int, float]) -> Symbol:
        """The linear form `terms`, simplified to a constant or a node where it is one."""
        form = tuple(sorted((node, value) for node, value in terms.items() if value != 0.0))
        if not form:
            return self.constant(0.0)
        if len(form) == 1:
            node, value = form[0]
            if node == -1:
                return self.constant(value)
            if value == 1.0:
                return Symbol(self, node)
        return self.add("sum", form)


def operands(node: Node) -> list[int]:
    """The nodes that a node reads."""
    kind = node[0]
    if kind in ("in", "const"):
        return []
    if kind == "sum":
        return [i for i, _ in node[1] if i >= 0]
    return list(node[1:])


class Symbol:
    """A scalar whose value is known only when the traced kernel runs."""

    __slots__ = ("graph", "index")

    def __init__(self, graph: Graph, index: int) -> None:
        self.graph, self.index = graph, index

    @property
    def node(self) -> Node:
        return self.graph.nodes[self.index]

    @property
    def value(self) -> float | None:
        """The number, where this symbol is a constant."""
        return self.node[1] if self.node[0] == "const" else None

    def _lift(self, other: Symbol | float) -> Symbol:
        return other if isinstance(other, Symbol) else self.graph.constant(other)

    def _form(self) -> dict[int, float]:
        node = self.node
        if node[0] == "const":
            return {-1: node[1]}
        return dict(node[1]) if node[0] == "sum" else {self.index: 1.0}

    def _scaled(self, factor: float) -> Symbol:
        return self.graph.linear({i: c * factor for i, c in self._form().items()})

    def _plus(self, other: Symbol | float, factor: float) -> Symbol:
        form = self._form()
        for i, c in self._lift(other)._form().items():
            form[i] = form.get(i, 0.0) + factor * c
        return self.graph.linear(form)

    def _factored(self) -> tuple[float, Symbol]:
        """Pull a coefficient that all terms of a sum share up to sign out of it: 2a - 2b is 2 (a - b)."""
        node = self.node
        if node[0] == "sum":
            first = node[1][0][1]
            if all(abs(c) == abs(first) for _, c in node[1]):
                return first, self.graph.linear({i: c / first for i, c in node[1]})
        return 1.0, self

    def __add__(self, other: Symbol | float) -> Symbol:
        return self._plus(other, 1.0)

    __radd__ = __add__

    def __sub__(self, other: Symbol | float) -> Symbol:
        return self._plus(other, -1.0)

    def __rsub__(self, other: float) -> Symbol:
        return self._lift(other)._plus(self, -1.0)

    def __neg__(self) -> Symbol:
        return self._scaled(-1.0)

    def __mul__(self, other: Symbol | float) -> Symbol:
        if not isinstance(other, (Symbol, int, float)):
            return NotImplemented
        other = self._lift(other)
        if self.value is not None:
            return other._scaled(self.value)
        if other.value is not None:
            return self._scaled(other.value)
        (f, x), (g, y) = self._factored(), other._factored()
        i, j = sorted((x.index, y.index))
        return self.graph.linear({self.graph.add("*", i, j).index: f * g})

    __rmul__ = __mul__

    def __truediv__(self, other: Symbol | float) -> Symbol:
        other = self._lift(other)
        if other.value is not None:
            return self._scaled(1.0 / other.value)
        return self.graph.add("/", self.index, other.index)

    def __rtruediv__(self, other: float) -> Symbol:
        return self._lift(other) / self
