"""Direct calls: a kernel as a built-in function of arrays (or of values that hold one), without numba's dispatcher.

For one element numba's boxing costs more than the mathematics. A direct call is a built-in made at run time: Python hands
its arguments to the C function of `_trampoline`, which reads the arrays' fields and runs the kernel on their data. It
answers None for anything that is not plain (another type, dtype, shape, memory order; numbers that are not finite for a
kernel that minds), and the caller takes the general way. Where objects are not laid out as the trampoline expects,
everything takes the general way, and the kernel is called through ctypes.
"""

from __future__ import annotations

import ctypes
import struct
import sys
import sysconfig
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np

_NUMPY_ABI, _ABI_VERSION, _ARRAY_TYPE, _NEW_FROM_DESCR, _SET_BASE_OBJECT = 0x02000000, 0, 2, 94, 282
_METH_FASTCALL = 0x80
_KEPT: list[Any] = []  # what built-ins point to

# An argument: numpy.ndarray or a type that holds one in its slot `array`, and the axes of one record.
Argument = tuple[type, tuple[int, ...]]


class Direct:
    """`call(*inputs, *outs)`: the kernel's result, or None where the general way has to be taken.

    An out is an array to write into or None; all may be left out. A value returned around an out holds a read-only view
    of it. `alone` names the inputs that are one record for the whole batch.
    """

    __slots__ = ("alone", "call", "inputs", "outputs")

    def __init__(self, inputs: Sequence[Argument], outputs: Sequence[Argument], alone: Sequence[bool] = ()) -> None:
        self.inputs, self.outputs, self.alone = tuple(inputs), tuple(outputs), tuple(alone) or (False,) * len(inputs)
        self.call: Callable[..., Any] = _nothing

    def connect(self, address: int) -> None:
        """Let calls run `int64 kernel(double **arrays, int64 records)`, which returns 0 for the general way."""
        from . import _trampoline as t

        functions = numpy_functions()
        axes = [axes for _, axes in (*self.inputs, *self.outputs)]
        if functions is None or all(self.alone) or len(axes) > t.MAX_ARRAYS or max(map(len, axes)) > 2:
            return
        lead, readable = self.alone.index(False), t.CONTIGUOUS | t.ALIGNED
        words = [address, len(self.inputs), len(self.outputs), id(np.ndarray), id(np.dtype(np.float64)), id(None)]
        words += [*functions, lead]
        for (kind, axes), alone in zip(self.inputs, self.alone, strict=True):
            words += [id(kind), _slot(kind), readable, int(alone), len(axes), *axes, *(0,) * (4 - len(axes))]
        for kind, axes in self.outputs:
            value, slot = (0, 0) if kind is np.ndarray else (id(kind), _slot(kind))
            words += [
                id(np.ndarray),
                0,
                readable | t.WRITEABLE,
                0,
                len(axes),
                *axes,
                *(0,) * (2 - len(axes)),
                value,
                slot,
            ]
        _KEPT.append((self.inputs, self.outputs))
        make = ctypes.pythonapi.PyCFunction_NewEx
        make.restype, make.argtypes = ctypes.py_object, [ctypes.POINTER(_Method), ctypes.py_object, ctypes.c_void_p]
        self.call = make(ctypes.byref(_method()), struct.pack(f"{len(words)}q", *words), None)


def _nothing(*arguments: Any) -> None:
    """What stands for a direct call that is not there (yet): everything takes the general way."""


def machine_code(dispatcher: Any, kinds: tuple[Any, ...]) -> int:
    """The address of a compiled function with C's calling convention."""
    dispatcher.compile(kinds)
    compiled = dispatcher.overloads[kinds]
    _KEPT.append(compiled)
    return compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name)


def call_by_ctypes(address: int, arrays: Sequence[Any], records: int) -> bool:
    """Run a kernel on arrays that are known to be C-contiguous float64: the way that needs no knowledge of layouts."""
    pointers = (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
    return ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_int64)(address)(pointers, records) != 0


class _Method(ctypes.Structure):
    """PyMethodDef."""

    _fields_ = (("name", ctypes.c_char_p), ("code", ctypes.c_void_p), ("flags", ctypes.c_int), ("doc", ctypes.c_char_p))


@cache
def _method() -> _Method:
    from numba.core import types

    from ._trampoline import direct_call

    return _Method(b"direct", machine_code(direct_call, (types.intp,) * 3), _METH_FASTCALL, None)


# ---- the guard
@cache
def numpy_functions() -> tuple[int, int] | None:
    """Addresses of PyArray_NewFromDescr and PyArray_SetBaseObject; None where objects are not laid out as expected."""
    if sys.implementation.name != "cpython" or sysconfig.get_config_var("Py_GIL_DISABLED"):
        return None
    try:
        table = _numpy_table()
        version = ctypes.CFUNCTYPE(ctypes.c_uint)(table[_ABI_VERSION])()
        if version != _NUMPY_ABI or table[_ARRAY_TYPE] != id(np.ndarray) or not fields_are_where_expected():
            return None
    except (ImportError, AttributeError, ValueError, TypeError):
        return None
    return table[_NEW_FROM_DESCR], table[_SET_BASE_OBJECT]


def _numpy_table() -> Any:
    """The table of C functions that extension modules compiled against numpy use."""
    from numpy._core import _multiarray_umath  # type: ignore[attr-defined]

    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    return (ctypes.c_int64 * (_SET_BASE_OBJECT + 1)).from_address(pointer(_multiarray_umath._ARRAY_API, None))


def fields_are_where_expected() -> bool:
    """Whether the fields of some arrays, read at the trampoline's offsets, are what numpy says they are."""
    from . import _trampoline as t

    if struct.calcsize("P") != 8 or np.ndarray.__basicsize__ < t.ARRAY_FLAGS + 4:
        return False
    frozen, strided = np.zeros((3, 5, 7)), np.zeros((4, 6))[:, ::2]
    frozen.setflags(write=False)
    for array in (np.zeros(8), np.zeros((2, 3)), np.zeros(2, np.float32), frozen, strided):
        at, expected = id(array), array.flags
        flags = ctypes.c_int32.from_address(at + t.ARRAY_FLAGS).value
        if (
            ctypes.c_int64.from_address(at + t.OBJECT_TYPE).value != id(np.ndarray)
            or ctypes.c_int64.from_address(at + t.ARRAY_DATA).value != array.ctypes.data
            or ctypes.c_int32.from_address(at + t.ARRAY_AXES).value != array.ndim
            or ctypes.c_int64.from_address(at + t.ARRAY_DTYPE).value != id(array.dtype)
            or bool(flags & t.CONTIGUOUS) != expected.c_contiguous
            or bool(flags & t.ALIGNED) != expected.aligned
            or bool(flags & t.WRITEABLE) != expected.writeable
        ):
            return False
        shape = ctypes.c_int64.from_address(at + t.ARRAY_SHAPE).value
        if tuple((ctypes.c_int64 * array.ndim).from_address(shape)) != array.shape:
            return False
    return True


def _slot(kind: type) -> int:
    """Where an instance of `kind` keeps its slot `array`, in bytes; 0 for an array itself."""
    if kind is np.ndarray:
        return 0
    value, array = object.__new__(kind), np.zeros(1)
    kind.array.__set__(value, array)
    return 8 * list((ctypes.c_int64 * (kind.__basicsize__ // 8)).from_address(id(value))).index(id(array))
