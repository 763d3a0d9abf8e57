"""A trace as one numba intrinsic: the graph goes straight to LLVM, with no Python text and no type inference between.

The intrinsic takes numbers or lanes, so the same object is the single and the batch kernel.
"""

from __future__ import annotations

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from ._graph import operands
from ._lanes import common_type, convert
from ._trace import Trace

# Contraction makes a*b + c one rounding; "nsz" ignores the sign of zero. Reassociation would break the series guards.
FAST_MATH = ("contract", "nsz")


def emit(trace: Trace, builder, vector, inputs) -> list:
    """LLVM values of the outputs of `trace`, computed in the LLVM type `vector` (a number or lanes)."""
    nodes, uses, done = trace.graph.nodes, trace.uses, {}
    is_vector = isinstance(vector, ir.VectorType)
    element = vector.element if is_vector else vector
    suffix = (f"v{vector.count}" if is_vector else "") + ("f64" if isinstance(element, ir.DoubleType) else "f32")

    def constant(value: float):
        return ir.Constant(vector, [value] * vector.count) if is_vector else ir.Constant(vector, value)

    def call(name: str, *arguments):
        kind = ir.FunctionType(vector, [vector] * len(arguments))
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.{suffix}"), arguments)

    def add_signed(parts):
        """Sum of (value, is positive); a positive part first saves a negation."""
        parts = sorted(parts, key=lambda part: not part[1])
        total, positive = parts[0]
        if not positive:
            total = builder.fneg(total)
        for value, positive in parts[1:]:
            total = (builder.fadd if positive else builder.fsub)(total, value, flags=FAST_MATH)
        return total

    def linear(form):
        """c (a + b - ...) + ...: terms whose coefficients agree up to sign share one multiplication."""
        groups: dict[float, list] = {}
        for j, c in form:
            groups.setdefault(abs(c), []).append((j, c > 0))
        parts = []
        for size, members in groups.items():
            if members == [(-1, True)] or members == [(-1, False)]:
                parts.append((constant(size), members[0][1]))
                continue
            positive = any(p for _, p in members)
            inner = add_signed([(constant(1.0) if j < 0 else value(j), p == positive) for j, p in members])
            parts.append((inner if size == 1.0 else builder.fmul(inner, constant(size), flags=FAST_MATH), positive))
        return add_signed(parts)

    def value(i):
        if i in done:
            return done[i]
        node = nodes[i]
        kind = node[0]
        if kind == "in":
            result = inputs[node[1]]
        elif kind == "const":
            result = constant(node[1])
        elif kind == "sum":
            result = linear(node[1])
        else:
            a = [value(j) for j in node[1:]]
            if kind == "atom":
                result = a[0]
            elif kind == "*":
                result = builder.fmul(*a, flags=FAST_MATH)
            elif kind == "/":
                result = builder.fdiv(*a, flags=FAST_MATH)
            elif kind == "where_lt":
                result = builder.select(builder.fcmp_ordered("<", a[0], a[1]), a[2], a[3])
            elif kind in ("min", "max"):  # compare and select is one instruction; llvm.minnum costs three
                result = builder.select(builder.fcmp_ordered("<" if kind == "min" else ">", *a), *a)
            else:
                result = call(kind, *a)
        done[i] = result
        return result

    # A node that is read once is emitted where it is read: short live ranges. The others in order (no deep recursion).
    for i in trace.live:
        if uses[i] > 1 or len(operands(nodes[i])) == 1:
            value(i)
    return [value(i) for i in trace.outputs]


def as_intrinsic(trace: Trace):
    """A numba intrinsic that takes the inputs of `trace` one by one and returns its outputs as a tuple."""

    def typer(context, arguments):
        kind = common_type(arguments)
        sig = types.UniTuple(kind, len(trace.outputs))(*arguments)

        def code(context, builder, sig, args):
            inputs = [convert(context, builder, v, t, kind) for v, t in zip(args, sig.args)]
            return context.make_tuple(
                builder, sig.return_type, emit(trace, builder, context.get_value_type(kind), inputs)
            )

        return sig, code

    # numba asks for an explicit arity
    names = ", ".join(f"x{k}" for k in range(sum(trace.widths)))
    namespace = {"typer": typer}
    exec(f"def {trace.name}(context, {names}): return typer(context, ({names},))", namespace)
    return intrinsic(namespace[trace.name])
