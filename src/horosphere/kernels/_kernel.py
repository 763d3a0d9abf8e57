"""`kernel`: from a geometric expression to a function of arrays, compiled at its first call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array
from ._direct import Direct, call_by_ctypes, machine_code
from ._trace import ArgumentType, Trace

Floats = NDArray[np.float64]


class Kernel:
    """One geometric expression: call it on arrays, use `.inline` in compiled loops, read `.source()` and `.llvm()`.

    An argument of K coefficients is an array (..., K), a plain number an array (...); leading axes broadcast. Tracing
    happens at first use, compiling at the first call, and compiled code is kept on disk.

    axes: the axes of one record of each output, where the numbers go to several arrays or to one of more axes.
    finite: refuse numbers that are not finite.
    """

    def __init__(
        self,
        name: str,
        function: Callable,
        types: dict[str, ArgumentType],
        layout: Sequence[int] | int,
        *,
        axes: Sequence[tuple[int, ...]] = (),
        finite: bool = False,
    ):
        self.name, self.__doc__ = name, function.__doc__
        self._function, self._types, self._layout, self._finite = function, types, layout, finite
        self.width_out = layout if isinstance(layout, int) else len(layout)
        self.axes = tuple(axes) or ((self.width_out,),)
        self._axes_in = tuple(() if t is None else (t,) if isinstance(t, int) else (len(t),) for t in types.values())
        self._compiled: dict[tuple[bool, ...], tuple[int, Direct]] = {}  # by which inputs are single records
        self._none_single, self._one_out = (False,) * len(types), len(self.axes) == 1
        self._waiting: list[Direct] = []
        self._directs = [self.direct([np.ndarray] * len(types), [np.ndarray] * len(self.axes))]

    @cached_property
    def trace(self) -> Trace:
        trace = Trace.of(self.name, self._function, self._types, self._layout)
        return trace.with_sum_of_inputs() if self._finite else trace

    @cached_property
    def inline(self) -> Callable:
        """For use inside `jit` functions: takes the coefficients one by one (numbers or lanes), returns a tuple."""
        if _jit_disabled():
            return lambda *inputs: tuple(self.trace.evaluate(inputs))
        from ._lower import as_intrinsic

        return as_intrinsic(self.trace)

    def __call__(self, *arrays: Floats, out: Any = None) -> Any:
        """The result, (..., K) with the broadcast leading axes of the arguments; written into `out` if given.

        Several outputs are a tuple, and so is their `out`, which may be or overlap an argument.
        """
        given = arrays if out is None else (*arrays, out) if self._one_out else (*arrays, *out)
        for direct in self._directs:
            result = direct.call(*given)
            if result is not None:
                return result
        return self._general(arrays, out)

    def direct(self, inputs: Sequence[type], outputs: Sequence[type]) -> Direct:
        """The kernel on values of these types (numpy.ndarray, or one with a slot `array`), without a detour.

        Its calls answer None, the sign to take the general way, until the kernel is compiled and whenever an argument
        is not plain.
        """
        made = Direct(
            list(zip(inputs, self._axes_in, strict=True)),
            list(zip(outputs, self.axes, strict=True)),
        )
        if self._none_single in self._compiled:
            made.connect(self._compiled[self._none_single][0])
        else:
            self._waiting.append(made)
        return made

    def _general(self, arrays, out: Any) -> Any:
        arrays = [np.asarray(a, dtype=np.float64) for a in arrays]
        if len(arrays) != len(self._axes_in):
            raise InputError(f"expected {len(self._axes_in)} arrays ({', '.join(self._types)}), got {len(arrays)}")
        batches = []
        for name, array, axes in zip(self._types, arrays, self._axes_in, strict=True):
            if axes and array.shape[-1:] != axes:
                raise InputError(f"expected shape (..., {axes[0]}), got {array.shape}", place=name)
            batches.append(array.shape[:-1] if axes else array.shape)
        batch = batches[0] if all(b == batches[0] for b in batches) else np.broadcast_shapes(*batches)
        outs = self._outs(batch, (None,) * len(self.axes) if out is None else (out,) if len(self.axes) == 1 else out)
        # A record that stands for the whole batch is loaded once, not copied; anything else is broadcast.
        single = tuple(len(batch) > 0 and own != batch and prod(own) == 1 for own in batches)
        for k, (own, axes) in enumerate(zip(batches, self._axes_in, strict=True)):
            if own != batch and not single[k]:
                arrays[k] = np.broadcast_to(arrays[k], (*batch, *axes))
            if out is not None and any(np.may_share_memory(arrays[k], o) for o in outs):
                arrays[k] = arrays[k].copy()
        good = self._into(outs, arrays) if _jit_disabled() else self.run(single, *map(_plain, arrays), *outs)
        if not good:
            for name, array in zip(self._types, arrays, strict=True):
                float_array(array, name)  # raises; if all are finite, only their sum overflowed
        return outs[0] if len(outs) == 1 else tuple(outs)

    def _outs(self, batch: tuple[int, ...], given: Sequence[Any]) -> list[Floats]:
        if len(given) != len(self.axes):
            raise InputError(f"expected {len(self.axes)} arrays, got {len(given)}", place="out")
        return [output_array(array, (*batch, *axes)) for array, axes in zip(given, self.axes, strict=True)]

    def reference(self, *arrays: Floats) -> Any:
        """The same result by numpy, without compiling: the reference back end."""
        arrays = tuple(np.asarray(a, dtype=np.float64) for a in arrays)
        batches = (a.shape[:-1] if axes else a.shape for a, axes in zip(arrays, self._axes_in, strict=True))
        outs = self._outs(np.broadcast_shapes(*batches), (None,) * len(self.axes))
        self._into(outs, arrays)
        return outs[0] if len(outs) == 1 else tuple(outs)

    def _into(self, outs: Sequence[Floats], arrays) -> bool:
        columns: list[Any] = []
        for array, axes in zip(arrays, self._axes_in, strict=True):
            columns += [array[..., k] for k in range(axes[0])] if axes else [array]
        with np.errstate(over="ignore", invalid="ignore"):  # machine code does not warn either
            values = iter(self.trace.evaluate(columns))
        for out, axes in zip(outs, self.axes, strict=True):
            for index in np.ndindex(axes):
                out[(..., *index)] = next(values)
        return not self._finite or bool(np.isfinite(next(values)).all())

    def run(self, single: tuple[bool, ...], *arrays: Floats) -> bool:
        """The machine code on inputs and outs that fit, C-contiguous float64; no checks: for callers that made them.

        `single[k]`: input k is one record that serves all. Returns whether the inputs are finite (True for a kernel
        that does not mind).
        """
        address, direct = self._compiled.get(single) or self._compile(single)
        if direct.call(*arrays) is not None:
            return True
        records = arrays[len(single)].size // prod(self.axes[0])
        return call_by_ctypes(address, arrays, records)

    def _compile(self, single: tuple[bool, ...]) -> tuple[int, Direct]:
        from ._drive import ARGUMENTS, driver

        address = machine_code(driver(self.trace, self.inline, self.axes, single, self._finite), ARGUMENTS)
        if any(single):
            kinds = [(np.ndarray, axes) for axes in self._axes_in], [(np.ndarray, axes) for axes in self.axes]
            direct = Direct(*kinds, alone=single)
            direct.connect(address)
            self._directs.append(direct)
        else:
            direct = self._directs[0]
            for waiting in self._waiting:
                waiting.connect(address)
            self._waiting.clear()
        self._compiled[single] = address, direct
        return address, direct

    def source(self) -> str:
        """The traced expression as straight-line Python."""
        return self.trace.source()

    def llvm(self) -> str:
        """The optimised LLVM of the batch function, compiled anew: none is kept on disk."""
        from ._drive import ARGUMENTS, driver

        fresh = driver(self.trace, self.inline, self.axes, self._none_single, self._finite, cached=False)
        fresh.compile(ARGUMENTS)
        return next(iter(fresh.inspect_llvm().values()))

    def __repr__(self) -> str:
        return f"Kernel({self.name}: {', '.join(self._types)} -> {self.width_out})"


def kernel(
    layout: Sequence[int] | int, *, axes: Sequence[tuple[int, ...]] = (), finite: bool = False, **types: ArgumentType
) -> Callable[[Callable], Kernel]:
    """Declare a geometric expression: `types` per argument (a layout of blades, `scalars(n)` or None for one number).

    `layout` is that of the result: blades of the returned MV, or how many numbers the function returns. axes, finite: as
    for `Kernel`.
    """

    def wrap(function: Callable) -> Kernel:
        return Kernel(function.__name__, function, types, layout, axes=axes, finite=finite)

    return wrap


def output_array(given: Any, shape: tuple[int, ...]) -> Floats:
    """A new array, or the caller's if it fits; InputError otherwise."""
    if given is None:
        return np.empty(shape)
    if not isinstance(given, np.ndarray):
        raise InputError(f"expected a numpy array of shape {shape}, got {type(given).__name__}", place="out")
    flags = given.flags
    plain = flags.c_contiguous and flags.aligned and flags.writeable
    if given.shape != shape or given.dtype != np.float64 or not plain:
        raise InputError(
            f"expected a writable C-contiguous float64 array of shape {shape}, got {given.dtype} {given.shape}",
            place="out",
        )
    return given


def _plain(array: Floats) -> Floats:
    return array if array.flags.c_contiguous and array.flags.aligned else np.require(array, requirements=["C", "A"])


def _jit_disabled() -> bool:
    from numba import config

    return bool(config.DISABLE_JIT)
