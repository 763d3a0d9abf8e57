"""Calls of compiled functions through their address.

Numba compiles a callee again inside every function that calls it, at every level; a large function that several others
call is compiled once if they call it through its address, which they take as an argument.
"""

from __future__ import annotations

from typing import Any

from numba import typeof
from numba.core import cgutils, types
from numba.extending import intrinsic

_KEPT: list[Any] = []


def address_of(function: Any, *arguments: Any) -> int:
    """The address of a `jit` function compiled for arguments like these; it must return an int64 and raise nothing."""
    kinds = tuple(typeof(value) for value in arguments)
    function.compile(kinds)
    compiled = function.overloads[kinds]
    if compiled.signature.return_type != types.int64:
        raise TypeError(f"{function.__name__} returns {compiled.signature.return_type}, not int64")
    _KEPT.append(compiled)
    return compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)


@intrinsic
def call_compiled(typing_context, address, arguments):
    """The int64 that the function at `address` (see `address_of`) returns for a tuple of arguments."""
    kinds = tuple(arguments)

    def code(context, builder, sig, args):
        form = context.call_conv.get_function_type(types.int64, kinds)
        function = builder.inttoptr(args[0], form.as_pointer())
        values = cgutils.unpack_tuple(builder, args[1], len(kinds))
        return context.call_conv.call_function(builder, function, types.int64, kinds, values)[1]

    return types.int64(types.int64, arguments), code


def address_of_python(function: Any, *arguments: Any) -> Any:
    """Without a compiler the function stands for its own address."""
    return function


def call_compiled_python(address: Any, arguments: tuple[Any, ...]) -> int:
    return address(*arguments)
