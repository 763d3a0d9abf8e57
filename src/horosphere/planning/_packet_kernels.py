"""Robot, solids, working memory and the task as one argument: an int64 array of addresses and sizes, which compiled code opens.

Numba passes an array as seven numbers and compiles a call again in every caller: with 21 arrays in each signature that was half
of the compile time, and most of the time of a call. The arrays behind a packet must outlive it.

  first the addresses of functions, see EDGE .. CLOCK; then three words for each array of a part: address, length, second length
  (1 if there is none)
"""

from __future__ import annotations

import ctypes
from functools import cache, partial
from time import perf_counter_ns
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels import inner, jit

called = partial(jit, _nrt=False, no_cpython_wrapper=True)
"""For what is called through its address in a packet."""


EDGE, PACK_SCENE, GROW_TREES, SIMPLIFY, CERTIFY, CLOCK, MODEL_AT = range(7)
"""Where the addresses are: of `edge_clear`, of the steps of `plan`, of a clock; and where the words of the model begin."""


PACK, GROW, RESUME, FINISH, CHECK = range(5)
"""What `plan` begins with: the scene; the trees; trees that are there; a path that is there; only whether it is certified."""
TREES_FULL, START_BLOCKED, GOALS_BLOCKED, NOT_CERTIFIED, TIME_OVER, PAUSED = range(-1, -7, -1)
"""Why `plan` has no path; nothing found yet is 0."""
CHUNK = 2000
"""Iterations of the trees after which `plan` looks at the clock; a rung has two such chunks."""


class PlainPacket(list):
    """Without a compiler: the functions, and the arrays as they are."""

    parts: tuple[Any, ...] = ()

    def with_scene(self, world: tuple[Any, ...], allowed: NDArray[np.uint8]) -> PlainPacket:
        """The same with another scene."""
        packet = PlainPacket(self)
        model, _, scratch, search, scene, task = self.parts
        packet.parts = model, world, scratch, search, (*scene[:3], allowed, *scene[4:]), task
        return packet

    def with_samples(self, samples: NDArray[np.float32]) -> PlainPacket:
        """The same with other samples."""
        packet = PlainPacket(self)
        packet.parts = (*self.parts[:3], (samples, *self.parts[3][1:]), *self.parts[4:])
        return packet


def packet_of(functions: tuple[Any, ...], parts: tuple[tuple[Any, ...], ...]) -> Any:
    """A packet for functions EDGE .. CERTIFY (their addresses) and (model, world, scratch, search, scene, task).

    See `_edge_kernels`, `_tree_kernels`, `_plan_kernels`.
    """
    if not isinstance(functions[0], int):
        packet = PlainPacket([*functions, perf_counter_ns])
        packet.parts = parts
        return packet
    words = [*functions, clock_address()]
    for part in parts:
        words += words_of(part)
    return np.array(words, np.int64)


@cache
def clock_address() -> int:
    """Of the C function behind `time.perf_counter_ns`: int64 (void), or in later versions of Python void (int64 *)."""
    for name in ("_PyTime_GetPerfCounter", "PyTime_PerfCounterRaw"):
        if hasattr(ctypes.pythonapi, name):
            return ctypes.cast(getattr(ctypes.pythonapi, name), ctypes.c_void_p).value or 0
    return ctypes.cast(_CALLED_BACK, ctypes.c_void_p).value or 0


_CALLED_BACK = ctypes.CFUNCTYPE(ctypes.c_int64)(perf_counter_ns)


def words_of(arrays: tuple[NDArray[Any], ...]) -> list[int]:
    """Three words for each array; they must be C-contiguous."""
    words: list[int] = []
    for array in arrays:
        words += (array.__array_interface__["data"][0], len(array), array.shape[1] if array.ndim == 2 else 1)
    return words


WORLD_AT = MODEL_AT + 3 * 9
"""Where the words of the world begin, behind those of the model."""
SAMPLES_AT = WORLD_AT + 3 * (6 + 6)
ALLOWED_AT = SAMPLES_AT + 3 * (10 + 3)
"""Where the words of `samples` are, the first of the search, and those of `allowed`, the fourth of the scene."""


def _compiled() -> tuple[Any, ...]:
    from llvmlite import ir
    from numba.core import cgutils, types
    from numba.extending import intrinsic
    from numba.np.arrayobj import populate_array

    single, whole = types.Array(types.float32, 2, "C"), types.Array(types.int64, 2, "C")
    row, numbers = types.Array(types.float32, 1, "C"), types.Array(types.int64, 1, "C")
    real, reals, small = (
        types.Array(types.float64, 1, "C"),
        types.Array(types.float64, 2, "C"),
        types.Array(types.uint8, 2, "C"),
    )
    parts_of = [types.Tuple(part) for part in (
        (whole, single, whole, single, whole, single, single, whole, whole),  # model
        (single, single, single, single, single, whole),  # world
        (row, row, numbers, single, row, single),  # scratch
        (single, row, row, single, numbers, single, whole, single, numbers, single),  # search
        (reals, real, real, small, real, numbers, numbers, numbers),  # scene
        (real, reals, numbers),  # task
    )]  # fmt: skip

    def opener(first, last):
        kind = types.Tuple(parts_of[first:last])
        begin = MODEL_AT + 3 * sum(len(part) for part in parts_of[:first])

        @intrinsic
        def opened(typing_context, packet):
            def code(context, builder, sig, args):
                start, place = context.make_array(packet)(context, builder, args[0]).data, begin
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

        return opened

    @intrinsic
    def now(typing_context, packet):
        """Nanoseconds of `time.perf_counter_ns`."""

        def code(context, builder, sig, args):
            word = ir.IntType(64)
            start = context.make_array(packet)(context, builder, args[0]).data
            form = ir.FunctionType(word, [word.as_pointer()])
            # it is returned, or stored (see `clock_address`): an argument that is not asked for does no harm in C
            stored = cgutils.alloca_once_value(builder, word(0))
            clock = builder.inttoptr(builder.load(builder.gep(start, [word(CLOCK)])), form.as_pointer())
            returned = builder.call(clock, [stored])
            value = builder.load(stored)
            return builder.select(builder.icmp_signed("==", value, word(0)), returned, value)

        return types.int64(packet), code

    from ..kernels import call_compiled

    @inner
    def check_edge(packet, q, v, count, how, margin, self_margin):
        """What `edge_clear` says."""
        return call_compiled(packet[EDGE], (q, v, count, how, margin, self_margin, packet))

    return opener(0, 3), opener(3, 6), now, check_edge


def opened_plain(packet: PlainPacket) -> tuple[Any, ...]:
    return packet.parts[:3]


def opened_task_plain(packet: PlainPacket) -> tuple[Any, ...]:
    return packet.parts[3:]


def now_plain(packet: PlainPacket) -> int:
    return packet[CLOCK]()


def check_edge_plain(packet: PlainPacket, *arguments: Any) -> int:
    return packet[EDGE](*arguments, packet)


NAMES = "opened", "opened_task", "now", "check_edge"
"""`opened`: the parts ((model), (world), (scratch)) of a packet; `opened_task`: ((search), (scene), (task))."""


def __getattr__(name: str) -> Any:
    if name in NAMES:
        from numba import config

        plain = opened_plain, opened_task_plain, now_plain, check_edge_plain
        globals().update(zip(NAMES, plain if config.DISABLE_JIT else _compiled()))
        return globals()[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
