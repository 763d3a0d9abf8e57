"""`Lanes`: a numba type that is W numbers side by side in one machine vector, and what loads and stores it.

Numba never vectorises straight-line geometry over the records of an (n, K) array, so the lanes are explicit: a lane tag
(a tuple of W zeros, whose *type* carries W) selects the width, and one function body serves single numbers (ONE) and
vectors (EIGHT). Arrays of records are loaded with a transpose in registers, so they stay in the natural layout.
"""

from __future__ import annotations

import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.errors import TypingError
from numba.core.typing.templates import signature
from numba.extending import intrinsic, lower_builtin, models, register_model, type_callable

from ._shuffles import aligned, deinterleave, interleave, load_group, shuffle, transpose

ONE = (0,)
EIGHT = (0,) * 8

_I32, _I64 = ir.IntType(32), ir.IntType(64)


class Lanes(types.Type):
    """W numbers of a float type, computed on together."""

    def __init__(self, dtype, width: int) -> None:
        self.dtype, self.width = dtype, width
        super().__init__(name=f"lanes({dtype}, {width})")


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, kind) -> None:
        super().__init__(manager, kind, ir.VectorType(manager.lookup(kind.dtype).get_value_type(), kind.width))


_NUMBERS = (types.Float, types.Integer, types.IntegerLiteral)


def common_type(arguments):
    """The lane type among `arguments` if the others are numbers, float64 if all are numbers."""
    lanes = [a for a in arguments if isinstance(a, Lanes)]
    if not all(isinstance(a, (Lanes, *_NUMBERS)) for a in arguments):
        raise TypingError(f"expected numbers or lanes, got {arguments}")
    return lanes[0] if lanes else types.float64


def convert(context, builder, value, source, target):
    """`value` of numba type `source` as `target`: a number becomes equal lanes."""
    if isinstance(source, Lanes):
        return value
    if not isinstance(target, Lanes):
        return context.cast(builder, value, source, target)
    value = context.cast(builder, value, source, target.dtype)
    vector = context.get_value_type(target)
    undefined = ir.Constant(vector, ir.Undefined)
    single = builder.insert_element(undefined, value, _I32(0))
    return builder.shuffle_vector(single, undefined, ir.Constant(ir.VectorType(_I32, target.width), [0] * target.width))


def _arithmetic(symbol, instruction: str) -> None:
    @type_callable(symbol)
    def _typing(context):
        def typer(a, b):
            if all(isinstance(t, (Lanes, *_NUMBERS)) for t in (a, b)) and (
                isinstance(a, Lanes) or isinstance(b, Lanes)
            ):
                return signature(a if isinstance(a, Lanes) else b, a, b)
            return None

        return typer

    def lower(context, builder, sig, args):
        x, y = (convert(context, builder, v, t, sig.return_type) for v, t in zip(args, sig.args))
        return getattr(builder, instruction)(x, y, flags=("contract", "nsz"))

    pairs = [(Lanes, Lanes)] + [(Lanes, t) for t in _NUMBERS] + [(t, Lanes) for t in _NUMBERS]
    for a, b in pairs:
        lower_builtin(symbol, a, b)(lower)


for _symbol, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _arithmetic(_symbol, _instruction)


@type_callable(operator.neg)
def _negation(context):
    return lambda a: signature(a, a) if isinstance(a, Lanes) else None


@lower_builtin(operator.neg, Lanes)
def _lower_negation(context, builder, sig, args):
    return builder.fneg(args[0])


def lane_type(dtype, width: int):
    return dtype if width == 1 else Lanes(dtype, width)


# ---------------------------------------------------------------- memory
def _data_pointer(context, builder, array_type, array, offset):
    data = (
        array
        if isinstance(array_type, types.CPointer)
        else context.make_array(array_type)(context, builder, array).data
    )
    return builder.gep(data, [offset])


@intrinsic
def array_at(typing_context, pointers, k):
    """The k-th of the pointers to float64 at an address: stands for a C-contiguous array whose length is known."""
    kind = types.CPointer(types.float64)

    def code(context, builder, sig, args):
        address = builder.inttoptr(args[0], context.get_value_type(kind).as_pointer())
        return builder.load(builder.gep(address, [args[1]]))

    return kind(types.intp, types.intp), code


@intrinsic(prefer_literal=True)
def load_records(typing_context, array, i, k, tag):
    """Records i, i+1, ... (one a lane) of a C-contiguous array of records of k numbers -> k-tuple of lanes.

    The array may have any number of axes; records are counted in memory order.
    """
    if not isinstance(k, types.IntegerLiteral):
        return None
    count, width, dtype = k.literal_value, tag.count, array.dtype
    lanes = lane_type(dtype, width)
    result = types.UniTuple(lanes, count)

    def code(context, builder, sig, args):
        start = _data_pointer(context, builder, array, args[0], builder.mul(args[1], ir.Constant(args[1].type, count)))
        if width == 8 and count >= 4:
            values = []
            for first in range(0, count, 4):
                own = min(4, count - first)  # the last group overlaps the one before, nothing is read past the end
                values += load_group(builder, start, count, min(first, count - 4), dtype.bitwidth)[4 - own :]
            return context.make_tuple(builder, result, values)
        if width > 1:
            start = builder.bitcast(start, context.get_value_type(lanes).as_pointer())
        values = [aligned(builder.load(builder.gep(start, [_I64(c)])), dtype.bitwidth) for c in range(count)]
        return context.make_tuple(builder, result, deinterleave(builder, values, width) if width > 1 else values)

    return result(array, types.intp, k, tag), code


@intrinsic(prefer_literal=True)
def prefetch_records(typing_context, array, i, k):
    """Ask for eight records of k numbers from i on, one line of the cache each, before they are loaded."""
    if not isinstance(k, types.IntegerLiteral):
        return None
    count = k.literal_value

    def code(context, builder, sig, args):
        start = _data_pointer(context, builder, array, args[0], builder.mul(args[1], ir.Constant(args[1].type, count)))
        byte = ir.IntType(8).as_pointer()
        form = ir.FunctionType(ir.VoidType(), [byte, _I32, _I32, _I32])
        prefetch = cgutils.get_or_insert_function(builder.module, form, "llvm.prefetch.p0i8")
        for line in range(count):  # eight records are as many lines of eight numbers
            address = builder.bitcast(builder.gep(start, [_I64(8 * line)]), byte)
            builder.call(prefetch, [address, _I32(0), _I32(3), _I32(1)])  # to read, into the nearest cache, data
        return context.get_dummy_value()

    return types.void(array, types.intp, k), code


@intrinsic
def store_records(typing_context, array, i, values):
    """Write a tuple of lanes as records i, i+1, ... of a C-contiguous array (inverse of `load_records`)."""
    kinds = list(values)
    count, lanes, dtype = len(kinds), common_type(kinds), array.dtype

    def code(context, builder, sig, args):
        start = _data_pointer(context, builder, array, args[0], builder.mul(args[1], ir.Constant(args[1].type, count)))
        items = cgutils.unpack_tuple(builder, args[2], count)
        items = [convert(context, builder, v, t, lanes) for v, t in zip(items, kinds)]
        if isinstance(lanes, Lanes) and count > lanes.width:
            width = lanes.width
            for first in range(0, count, width):
                first = min(first, count - width)
                for r, row in enumerate(transpose(builder, items[first : first + width])):
                    address = builder.gep(start, [_I64(r * count + first)])
                    aligned(builder.store(row, builder.bitcast(address, row.type.as_pointer())), dtype.bitwidth)
            return context.get_dummy_value()
        if isinstance(lanes, Lanes):
            items = interleave(builder, items, lanes.width)
            start = builder.bitcast(start, items[0].type.as_pointer())
        for c, item in enumerate(items):
            aligned(builder.store(item, builder.gep(start, [_I64(c)])), dtype.bitwidth)
        return context.get_dummy_value()

    return types.void(array, types.intp, values), code


@intrinsic
def load_lanes(typing_context, array, offset, tag):
    """Numbers offset, offset+1, ... of a C-contiguous array, one a lane."""
    lanes = lane_type(array.dtype, tag.count)

    def code(context, builder, sig, args):
        start = _data_pointer(context, builder, array, args[0], args[1])
        return aligned(
            builder.load(builder.bitcast(start, context.get_value_type(lanes).as_pointer())), array.dtype.bitwidth
        )

    return lanes(array, types.intp, tag), code


@intrinsic
def store_lanes(typing_context, array, offset, value):
    """Write lanes to numbers offset, offset+1, ... of a C-contiguous array."""

    def code(context, builder, sig, args):
        start = _data_pointer(context, builder, array, args[0], args[1])
        aligned(builder.store(args[2], builder.bitcast(start, args[2].type.as_pointer())), array.dtype.bitwidth)
        return context.get_dummy_value()

    return types.void(array, types.intp, value), code


@intrinsic(prefer_literal=True)
def load_columns(typing_context, array, offset, k, tag):
    """k lanes in a row, from number `offset` of a C-contiguous array on: a tuple of lanes (structure of arrays)."""
    if not isinstance(k, types.IntegerLiteral):
        return None
    count, lanes = k.literal_value, lane_type(array.dtype, tag.count)
    result = types.UniTuple(lanes, count)

    def code(context, builder, sig, args):
        start = _data_pointer(context, builder, array, args[0], args[1])
        start = builder.bitcast(start, context.get_value_type(lanes).as_pointer())
        values = [aligned(builder.load(builder.gep(start, [_I64(c)])), array.dtype.bitwidth) for c in range(count)]
        return context.make_tuple(builder, result, values)

    return result(array, types.intp, k, tag), code


@intrinsic
def store_columns(typing_context, array, offset, values):
    """Write a tuple of lanes one behind the other, from number `offset` of a C-contiguous array on."""
    lanes = common_type(list(values))

    def code(context, builder, sig, args):
        start = _data_pointer(context, builder, array, args[0], args[1])
        start = builder.bitcast(start, context.get_value_type(lanes).as_pointer())
        for c, (item, kind) in enumerate(zip(cgutils.unpack_tuple(builder, args[2], len(values)), values)):
            item = convert(context, builder, item, kind, lanes)
            aligned(builder.store(item, builder.gep(start, [_I64(c)])), array.dtype.bitwidth)
        return context.get_dummy_value()

    return types.void(array, types.intp, values), code


@intrinsic
def spread(typing_context, value, tag):
    """A number as equal lanes of the tag's width."""
    lanes = lane_type(types.float64 if not isinstance(value, types.Float) else value, tag.count)

    def code(context, builder, sig, args):
        return convert(context, builder, args[0], value, lanes)

    return lanes(value, tag), code


@intrinsic(prefer_literal=True)
def no_lanes(typing_context, k, tag):
    """k lanes of zeros: what a loop carries before it has something."""
    if not isinstance(k, types.IntegerLiteral):
        return None
    result = types.UniTuple(lane_type(types.float64, tag.count), k.literal_value)
    return result(k, tag), lambda context, builder, sig, args: context.get_constant_null(result)


def _reduction(name: str):
    @intrinsic
    def reduce(typing_context, value):
        result = value.dtype if isinstance(value, Lanes) else value

        def code(context, builder, sig, args):
            x = args[0]
            if not isinstance(value, Lanes):
                return x
            width = value.width
            while width > 1:
                width //= 2
                low = shuffle(builder, x, x, list(range(width)))
                high = shuffle(builder, x, x, list(range(width, 2 * width)))
                if name == "add":
                    x = builder.fadd(low, high)
                else:
                    x = builder.select(builder.fcmp_ordered(name, low, high), low, high)
            return builder.extract_element(x, _I32(0))

        return result(value), code

    return reduce


min_lane, max_lane, sum_lanes = _reduction("<"), _reduction(">"), _reduction("add")


# ---------------------------------------------------------------- functions and tests, lane by lane
def _unary(name: str):
    @intrinsic
    def function(typing_context, x):
        kind = common_type((x,))

        def code(context, builder, sig, args):
            value = convert(context, builder, args[0], x, kind)
            suffix = f"v{kind.width}f{kind.dtype.bitwidth}" if isinstance(kind, Lanes) else f"f{kind.bitwidth}"
            form = ir.FunctionType(value.type, [value.type])
            return builder.call(cgutils.get_or_insert_function(builder.module, form, f"llvm.{name}.{suffix}"), [value])

        return kind(x), code

    return function


def _choice(comparison: str):
    @intrinsic
    def function(typing_context, x, y):
        kind = common_type((x, y))

        def code(context, builder, sig, args):
            a, b = (convert(context, builder, v, t, kind) for v, t in zip(args, sig.args))
            return builder.select(builder.fcmp_ordered(comparison, a, b), a, b)

        return kind(x, y), code

    return function


lane_sqrt, lane_abs = _unary("sqrt"), _unary("fabs")
lane_min, lane_max = _choice("<"), _choice(">")


@intrinsic
def lane_where_lt(typing_context, a, b, x, y):
    """x where a < b, else y, lane by lane."""
    kind = common_type((a, b, x, y))

    def code(context, builder, sig, args):
        v = [convert(context, builder, value, t, kind) for value, t in zip(args, sig.args)]
        return builder.select(builder.fcmp_ordered("<", v[0], v[1]), v[2], v[3])

    return kind(a, b, x, y), code


@intrinsic
def lane_mask_lt(typing_context, a, b):
    """The lanes where a < b as the bits of an int64 (bit l is lane l); 0 if there is none."""
    kind = common_type((a, b))

    def code(context, builder, sig, args):
        x, y = (convert(context, builder, value, t, kind) for value, t in zip(args, sig.args))
        test = builder.fcmp_ordered("<", x, y)
        if isinstance(kind, Lanes):
            test = builder.bitcast(test, ir.IntType(kind.width))
        return builder.zext(test, _I64)

    return types.int64(a, b), code
