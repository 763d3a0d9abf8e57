"""Robot, solids and working memory as one argument: an int64 array of addresses and sizes, which compiled code opens.

Numba passes an array as seven numbers and compiles a call again in every caller: with 21 arrays in each signature that was half
of the compile time, and most of the time of a call. The arrays behind a packet must outlive it.

  word 0: address of `edge_clear`; then three words for each array of KIND: address, length, second length (1 if there is none)
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels import jit

inner = partial(jit, _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True)
"""For what is called from compiled code alone: compiles sooner."""


class PlainPacket(list):
    """Without a compiler: [the edge check], and the arrays as they are."""

    parts: tuple[Any, ...] = ()


def packet_of(edge: Any, parts: tuple[tuple[Any, ...], ...]) -> Any:
    """A packet for `edge_clear` (its address) and (model, world, scratch), see `_edge_kernels`."""
    if not isinstance(edge, int):
        packet = PlainPacket([edge])
        packet.parts = parts
        return packet
    words = [edge]
    for part in parts:
        words += words_of(part)
    return np.array(words, np.int64)


def words_of(arrays: tuple[NDArray[Any], ...]) -> list[int]:
    """Three words for each array; they must be C-contiguous."""
    words: list[int] = []
    for array in arrays:
        words += (array.__array_interface__["data"][0], len(array), array.shape[1] if array.ndim == 2 else 1)
    return words


WORLD_AT = 1 + 3 * 9
"""Where the words of the world begin, behind those of the model."""


def _compiled() -> tuple[Any, Any]:
    from llvmlite import ir
    from numba.core import cgutils, types
    from numba.extending import intrinsic
    from numba.np.arrayobj import populate_array

    single, whole = types.Array(types.float32, 2, "C"), types.Array(types.int64, 2, "C")
    row, numbers = types.Array(types.float32, 1, "C"), types.Array(types.int64, 1, "C")
    kind = types.Tuple((
        types.Tuple((whole, single, whole, single, whole, single, single, whole, whole)),
        types.Tuple((single, single, single, single, single, whole)),
        types.Tuple((row, row, numbers, single, row, single)),
    ))  # fmt: skip

    @intrinsic
    def opened(typing_context, packet):
        """((model), (world), (scratch)) as in `_edge_kernels`."""

        def code(context, builder, sig, args):
            start, place = context.make_array(packet)(context, builder, args[0]).data, 1
            word = ir.IntType(64)

            def load(k):
                return builder.load(builder.gep(start, [word(k)]))

            parts = []
            for part in kind.types:
                arrays = []
                for one in part.types:
                    array = context.make_array(one)(context, builder)
                    size = one.dtype.bitwidth // 8
                    pointer = builder.inttoptr(load(place), context.get_data_type(one.dtype).as_pointer())
                    shape = [load(place + 1 + k) for k in range(one.ndim)]
                    steps = [builder.mul(shape[1], word(size)), word(size)] if one.ndim == 2 else [word(size)]
                    populate_array(
                        array, data=pointer, shape=cgutils.pack_array(builder, shape),
                        strides=cgutils.pack_array(builder, steps), itemsize=word(size), meminfo=None,
                    )  # fmt: skip
                    arrays.append(array._getvalue())
                    place += 3
                parts.append(context.make_tuple(builder, part, arrays))
            return context.make_tuple(builder, kind, parts)

        return kind(packet), code

    from ..kernels import call_compiled

    @inner
    def check_edge(packet, q, v, count, how, margin, self_margin):
        """What `edge_clear` says."""
        return call_compiled(packet[0], (q, v, count, how, margin, self_margin, packet))

    return opened, check_edge


def opened_plain(packet: PlainPacket) -> tuple[Any, ...]:
    return packet.parts


def check_edge_plain(packet: PlainPacket, *arguments: Any) -> int:
    return packet[0](*arguments, packet)


def __getattr__(name: str) -> Any:
    if name in ("opened", "check_edge"):
        from numba import config

        found = (opened_plain, check_edge_plain) if config.DISABLE_JIT else _compiled()
        globals()["opened"], globals()["check_edge"] = found
        return globals()[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
