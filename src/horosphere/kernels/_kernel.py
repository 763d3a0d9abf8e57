"""`kernel`: from a geometric expression to a function of arrays, compiled at its first call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ._cache import OPTIONS, attach_cache
from ._trace import ArgumentType, Trace


class Kernel:
    """One geometric expression: call it on arrays, use `.inline` in compiled loops, read `.source()` and `.llvm()`.

    An argument of K coefficients is an array (..., K), a plain number an array (...); leading axes broadcast. Tracing
    happens at first use, compiling at the first call, and compiled code is kept on disk.
    """

    def __init__(self, name: str, function: Callable, types: dict[str, ArgumentType], layout: Sequence[int] | int):
        self.name, self.__doc__ = name, function.__doc__
        self._function, self._types, self._layout = function, types, layout
        self._compiled: dict[tuple[bool, ...], Callable] = {}
        self._one_record: Callable | None = None  # the machine code, once it exists
        self._widths = [
            None if kind is None else len(kind) if isinstance(kind, tuple) else kind for kind in types.values()
        ]
        self.width_out = layout if isinstance(layout, int) else len(layout)
        self._single_shapes = [None if w is None else (w,) for w in self._widths]
        self._single_out = (self.width_out,)

    @cached_property
    def trace(self) -> Trace:
        return Trace.of(self.name, self._function, self._types, self._layout)

    @cached_property
    def inline(self) -> Callable:
        """For use inside `jit` functions: takes the coefficients one by one (numbers or lanes), returns a tuple."""
        from numba import config

        if config.DISABLE_JIT:
            return lambda *inputs: tuple(self.trace.evaluate(inputs))
        from ._lower import as_intrinsic

        return as_intrinsic(self.trace)

    def __call__(self, *arrays: NDArray[np.float64], out: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """The result, (..., K) with the broadcast leading axes of the arguments; written into `out` if given."""
        if self._one_record is not None:
            result = self._directly(arrays, out)
            if result is not None:
                return result
        return self._general(arrays, out)

    def _directly(self, arrays, out) -> NDArray[np.float64] | None:
        """The common case without detours: arrays of equal batch shape, ready for machine code. None: not that case."""
        try:
            if [a.shape for a in arrays] == self._single_shapes and (out is None or out.shape == self._single_out):
                result = np.empty(self.width_out) if out is None else out
                self._one_record(*arrays, result)  # type: ignore[misc]
                return result
        except (AttributeError, TypeError):  # no array, another dtype or memory order
            return None
        batch = getattr(arrays[0], "shape", (0,))[:-1] if arrays else ()
        shape = (*batch, self.width_out)
        if tuple(getattr(a, "shape", None) for a in arrays) != tuple([(*batch, w) for w in self._widths]):
            return None
        if out is None:
            out = np.empty(shape)
        elif out.shape != shape or not out.flags.c_contiguous:
            return None
        try:
            self._one_record(*[a.reshape(-1) for a in arrays], out.reshape(-1))  # type: ignore[misc]
        except TypeError:  # another dtype or memory order: the general way converts or says what is wrong
            return None
        return out

    def _general(self, arrays, out: NDArray[np.float64] | None) -> NDArray[np.float64]:
        arrays = [np.asarray(a, dtype=np.float64) for a in arrays]
        widths = self.trace.widths
        if len(arrays) != len(widths):
            raise InputError(f"expected {len(widths)} arrays ({', '.join(self._types)}), got {len(arrays)}")
        batches, single = [], []
        for k, (array, kind) in enumerate(zip(arrays, self._types.values(), strict=True)):
            if kind is not None and array.shape[-1:] != widths[k : k + 1]:
                raise InputError(f"expected shape (..., {widths[k]}), got {array.shape}", place=self.trace.arguments[k])
            batches.append(array.shape if kind is None else array.shape[:-1])
        batch = batches[0] if all(b == batches[0] for b in batches) else np.broadcast_shapes(*batches)
        shape = (*batch, self.width_out)
        if out is None:
            out = np.empty(shape)
        elif out.shape != shape or out.dtype != np.float64 or not out.flags.c_contiguous or not out.flags.writeable:
            raise InputError(f"expected a writable C-contiguous float64 array of shape {shape}", place="out")
        if _jit_disabled():
            return self._into(out, arrays)
        # A record that stands for the whole batch is loaded once, not copied; anything else is broadcast.
        flat = []
        for array, kind, own in zip(arrays, self._types.values(), batches, strict=True):
            alone = len(batch) > 0 and (own == () or all(n == 1 for n in own)) and own != batch
            if not alone and own != batch:
                array = np.broadcast_to(array, batch if kind is None else (*batch, array.shape[-1]))
            single.append(alone)
            flat.append(np.ascontiguousarray(array, dtype=np.float64).reshape(-1))
        self.compiled(tuple(single))(*flat, out.reshape(-1))
        return out

    def reference(self, *arrays: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same result by numpy, without compiling: the reference back end."""
        arrays = tuple(np.asarray(a, dtype=np.float64) for a in arrays)
        batch = np.broadcast_shapes(
            *(a.shape if kind is None else a.shape[:-1] for a, kind in zip(arrays, self._types.values(), strict=True))
        )
        return self._into(np.empty((*batch, self.width_out)), arrays)

    def _into(self, out: NDArray[np.float64], arrays) -> NDArray[np.float64]:
        columns: list[Any] = []
        for array, kind in zip(arrays, self._types.values(), strict=True):
            columns += [array] if kind is None else [array[..., k] for k in range(array.shape[-1])]
        values = self.trace.evaluate(columns)
        for k, value in enumerate(values):
            out[..., k] = value
        return out

    def compiled(self, single: tuple[bool, ...] | None = None) -> Callable:
        """The machine code as a function of flat arrays, the last one the result; its length says how many records.

        `single[k]`: argument k is one record that serves all. No checks: for callers that have made them.
        """
        key = single if single is not None else (False,) * len(self.trace.widths)
        if key not in self._compiled:
            self._compiled[key] = self._compile(key)
            if not any(key):
                self._one_record = self._compiled[key]
        return self._compiled[key]

    def _compile(self, single: tuple[bool, ...]) -> Callable:
        from numba import njit
        from numba.core import types

        from ._lanes import EIGHT, ONE, load_records, store_records

        names, widths = self.trace.arguments, self.trace.widths

        def loads(tag: str) -> str:
            return ", ".join(
                f"*one_{name}" if alone else f"*load_records({name}, i, {width}, {tag})"
                for name, width, alone in zip(names, widths, single, strict=True)
            )

        before = [f"    one_{n} = load_records({n}, 0, {w}, ONE)" for n, w, s in zip(names, widths, single) if s]
        text = "\n".join(
            [
                f"def {self.name}({', '.join(names)}, out):",
                *before,
                f"    count = out.size // {self.width_out}",
                "    whole = count // 8 * 8",
                "    for i in range(0, whole, 8):",
                f"        store_records(out, i, inline({loads('EIGHT')}))",
                "    for i in range(whole, count):",
                f"        store_records(out, i, inline({loads('ONE')}))",
            ]
        )
        namespace = {
            "__name__": __name__, "inline": self.inline, "EIGHT": EIGHT, "ONE": ONE,
            "load_records": load_records, "store_records": store_records,
        }  # fmt: skip
        exec(compile(text, "<horosphere-kernel>", "exec"), namespace)
        dispatcher = njit(**OPTIONS)(namespace[self.name])
        attach_cache(dispatcher, self.trace.fingerprint)
        flat_in = types.Array(types.float64, 1, "C", readonly=True)
        flat_out = types.Array(types.float64, 1, "C")
        dispatcher.compile((flat_in,) * len(widths) + (flat_out,))
        dispatcher.disable_compile()
        return dispatcher

    def source(self) -> str:
        """The traced expression as straight-line Python."""
        return self.trace.source()

    def llvm(self) -> str:
        """The optimised LLVM of the batch function (numba keeps none for code that came from the disk cache)."""
        return next(iter(self.compiled().inspect_llvm().values()))

    def __repr__(self) -> str:
        return f"Kernel({self.name}: {', '.join(self._types)} -> {self.width_out})"


def kernel(layout: Sequence[int] | int, **types: ArgumentType) -> Callable[[Callable], Kernel]:
    """Declare a geometric expression: `types` per argument (a layout of blades, `scalars(n)` or None for one number).

    `layout` is that of the result: blades of the returned MV, or how many numbers the function returns.
    """

    def wrap(function: Callable) -> Kernel:
        return Kernel(function.__name__, function, types, layout)

    return wrap


def _jit_disabled() -> bool:
    from numba import config

    return bool(config.DISABLE_JIT)
