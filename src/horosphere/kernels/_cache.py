"""Compiled code on disk, stamped by a hash of everything it is made from.

Numba's own cache looks only at the file of the function itself, so it misses a changed callee elsewhere; here the stamp
covers the compiler and every source that the function's module imports. Numba also fails at import where nothing is
writable; here a folder that cannot be written means no cache.
"""

from __future__ import annotations

import ast
import gc
import hashlib
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from typing import Any

from ._parts import part_compiler, remembering

PACKAGE = Path(__file__).resolve().parent.parent
OPTIONS: dict[str, Any] = {"fastmath": {"contract", "nsz"}, "error_model": "numpy", "nogil": True}


def cache_folder() -> Path:
    """Where compiled kernels are kept: HOROSPHERE_CACHE, else the user's cache folder."""
    root = os.environ.get("HOROSPHERE_CACHE")
    if root:
        return Path(root)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home())) / "horosphere" / "kernels"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "horosphere" / "kernels"


def is_cache_writable() -> bool:
    """Whether what is compiled can be kept: else it is compiled anew in every process."""
    import tempfile

    try:
        cache_folder().mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=cache_folder()):
            return True
    except OSError:
        return False


@cache
def compiler_stamp() -> str:
    """A hash of the kernel compiler and of the versions below it: names the cache folder."""
    import llvmlite
    import numba

    digest = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__} {sys.version_info[:2]}".encode())
    for path in sorted(PACKAGE.glob("kernels/*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def source_stamp(module: str) -> str:
    """A hash of a module's source and of all sources of the package that it imports, directly or not."""
    pending, sources = [module], {}
    while pending:
        name = pending.pop()
        if name not in sources and (imported := _source_and_imports(name)) is not None:
            sources[name], names = imported
            pending += names
    digest = hashlib.sha256()
    for name in sorted(sources):
        digest.update(name.encode() + sources[name])
    return digest.hexdigest()[:16]


@cache
def _source_and_imports(name: str) -> tuple[bytes, tuple[str, ...]] | None:
    """The source of a module of this package and the modules that it imports; None for others and the compiler's own."""
    path = _source_file(name)
    if path is None or PACKAGE.joinpath("kernels") in path.parents:
        return None
    source, names = path.read_bytes(), []
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom):
            base = package.rsplit(".", node.level - 1)[0] if node.level else ""
            target = ".".join(part for part in (base, node.module) if part)
            for alias in node.names:
                # a module of a package is imported itself: with the package all of the project would count
                inside = f"{target}.{alias.name}"
                names.append(target if _source_file(inside) is None else inside)
        elif isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
    return source, tuple(names)


@cache
def _source_file(module: str) -> Path | None:
    """The file of a module of this package; None for other modules and for names that are not modules."""
    root, _, rest = module.partition(".")
    if root != PACKAGE.name:
        return None
    path = PACKAGE.joinpath(*rest.split(".")) if rest else PACKAGE
    return next((p for p in (path.with_suffix(".py"), path / "__init__.py") if p.is_file()), None)


def attach_cache(dispatcher, content: str) -> None:
    """Give a numba dispatcher our disk cache; `content` tells functions of the same name apart."""
    from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

    pause_garbage_collection()
    compile_plainly = dispatcher.compile

    def compile_remembering(signature):
        with remembering():
            return compile_plainly(signature)

    dispatcher.compile = compile_remembering

    class Locator(_CacheLocator):
        def __init__(self, function) -> None:
            self._function = function

        def get_cache_path(self) -> str:
            return str(cache_folder() / compiler_stamp())

        def get_source_stamp(self) -> str:
            return source_stamp(self._function.__module__ or "")

        def get_disambiguator(self) -> str:
            # names the file: an index of other sources may speak of modules that are not there
            return hashlib.sha256(f"{content} {self.get_source_stamp()}".encode()).hexdigest()[:16]

        @classmethod
        def from_function(cls, function, path):
            locator = cls(function)
            try:
                locator.ensure_cache_path()
            except OSError:
                return None
            return locator

    class Implementation(CompileResultCacheImpl):
        _locator_classes = (Locator,)

    class Cache(FunctionCache):
        _impl_class = Implementation

        def save_overload(self, sig, data) -> None:
            with suppress(OSError):  # a full disk: then it is compiled again next time
                super().save_overload(sig, data)

    try:
        dispatcher._cache = Cache(dispatcher.py_func)
    except RuntimeError:  # no folder can be written
        return


def _content(function) -> str:
    code = function.__code__
    return hashlib.sha256(repr((function.__module__, function.__qualname__)).encode() + code.co_code).hexdigest()


def jit(function: Callable | None = None, *, part: bool = False, **options) -> Any:
    """numba.njit with the project's flags and disk cache, for hand-written loops (in files named `_*kernels.py`).

    Flags: contraction and no signed zeros, numpy's error model, no lock held. `part`: it is called from compiled code alone, and not
    through its address; that compiles sooner.
    """
    from numba import config, njit

    def wrap(f: Callable):
        if config.DISABLE_JIT:
            return f
        chosen: dict[str, Any] = {**OPTIONS, "no_cfunc_wrapper": True, **options}
        if part:
            chosen |= {"pipeline_class": part_compiler(), "no_cpython_wrapper": True}
            return njit(**chosen)(f)
        dispatcher = njit(**chosen)(f)
        attach_cache(dispatcher, _content(f))
        return dispatcher

    return wrap if function is None else wrap(function)


inner = partial(jit, _nrt=False, part=True)
"""`jit` for what compiled code alone calls, by its name, and which makes no arrays: compiles sooner."""


def on_compile(callback: Callable[[str], None]) -> None:
    """Call `callback(name)` whenever a function is compiled (not when it comes from the disk cache)."""
    _listen(lambda event: callback(event.data["dispatcher"].py_func.__name__), lambda event: None)


def _listen(start: Callable[[Any], None], end: Callable[[Any], None]) -> None:
    from numba.core import event

    class Listener(event.Listener):
        def on_start(self, event) -> None:
            start(event)

        def on_end(self, event) -> None:
            end(event)

    event.register("numba:compile", Listener())


@cache
def pause_garbage_collection() -> None:
    """Let no garbage be collected while numba compiles: its many small objects make that 15 % of the time."""
    paused: list[bool] = []

    def on_start(event) -> None:
        paused.append(gc.isenabled())
        gc.disable()

    def on_end(event) -> None:
        if paused.pop():
            gc.enable()

    _listen(on_start, on_end)
