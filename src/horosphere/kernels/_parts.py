"""Compiling sooner: what numba does again and again, once.

A large kernel spends its compile time less in LLVM than in numba's Python code, and much of it on what is known: machine code of
functions that are only ever inlined, and the types of the same operators over and over.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, wraps
from typing import Any


@cache
def part_compiler() -> Any:
    """The numba pipeline for functions that only compiled code calls (`jit(part=True)`): they are typed and lowered, nothing more.

    Numba optimises a callee and turns it into machine code before it is optimised once more, inlined, within each caller; here only
    the caller that has an address is. Such functions have no address, no wrapper, and are not kept on disk.
    """
    from numba import _dynfunc
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler
    from numba.core.compiler_machinery import PassManager, register_pass
    from numba.core.typed_passes import NativeLowering, NopythonRewrites
    from numba.core.untyped_passes import InlineClosureLikes

    class PartLibrary(JITCodeLibrary):
        """LLVM code that is there to be linked into other libraries."""

        def finalize(self) -> None:
            self._raise_if_finalized()
            for library in dict.fromkeys(self._linking_libraries):
                self._reload_init.update(library._reload_init)
                self._final_module.link_in(library._get_module_for_linking(), preserve=True)
            self._finalize_dynamic_globals()
            self._finalized = True

    @register_pass(mutates_CFG=True, analysis_only=False)
    class PartLowering(NativeLowering):
        _name = "part_lowering"

        def run_pass(self, state) -> bool:
            state.library = PartLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
            state.flags.no_compile = True
            super().run_pass(state)
            made = state["cr"]
            description = made.fndesc
            name = description.qualname.split(".")[-1]
            # what numba knows a callee by; nobody calls it
            handle = _dynfunc.make_function(description.lookup_module(), name, "", 0, made.env, (state.library,))
            state.targetctx.insert_user_function(handle, description, [state.library])
            state["cr"] = made._replace(cfunc=handle)
            return True

    class PartCompiler(Compiler):
        def define_pipelines(self) -> list[Any]:
            [plain] = super().define_pipelines()
            manager = PassManager("part")
            for kind, why in plain.passes:
                if kind not in (InlineClosureLikes, NopythonRewrites):  # of closures and array expressions
                    manager.passes.append((PartLowering if kind is NativeLowering else kind, why))
            manager.finalize()
            return [manager]

    return PartCompiler


@contextmanager
def remembering() -> Iterator[None]:
    """While one of our functions is compiled: numba looks up the type of the same operator on the same types once.

    It tries all that an operator may mean at every place where it stands, and compares its flags anew for each: a third of the time
    that a kernel of scalars and arrays takes. Other people's functions are compiled as ever: the lock is the one that numba holds
    while it compiles.
    """
    from numba.core import types
    from numba.core.compiler_lock import global_compiler_lock

    with global_compiler_lock:
        before = types.Function.get_call_type
        types.Function.get_call_type = _remembered_call_type()
        try:
            yield
        finally:
            types.Function.get_call_type = before


@cache
def _remembered_call_type() -> Any:
    """`types.Function.get_call_type` with a memory: the signature and the implementation it led to, by context, flags and types."""
    from numba.core import types
    from numba.core.targetconfig import ConfigStack

    plain = types.Function.get_call_type
    simple = types.Number, types.Boolean, types.Array, types.BaseTuple, types.NoneType
    known: dict[Any, tuple[Any, Any]] = {}
    kinds: list[Any] = []
    recent: list[Any] = [None, -1]

    def kind_of(flags: Any) -> int:
        if flags is not recent[0]:
            if flags not in kinds:
                kinds.append(flags)
            recent[:] = flags, kinds.index(flags)
        return recent[1]

    @wraps(plain)
    def get_call_type(self, context, args, kws):
        if kws or not all(isinstance(one, simple) for one in args):
            return plain(self, context, args, kws)
        key = self, context, kind_of(ConfigStack.top_or_none()), args
        found = known.get(key)
        if found is None:
            signature: Any = plain(self, context, args, kws)
            known[key] = signature, self._impl_keys[signature.args]
            return signature
        signature, implementation = found
        self._impl_keys[signature.args] = implementation
        return signature

    return get_call_type
