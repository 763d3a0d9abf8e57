"""Compiled code on disk, under a folder named by a hash of every kernel source.

Numba's own cache looks only at the file of the function itself, so it misses a changed callee elsewhere, and it fails
at import where nothing is writable; here a folder that cannot be written means no cache.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

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


@cache
def source_stamp() -> str:
    """A hash of the compiler and of every `_kernels.py`, `_*_kernels.py` of the package, and of the versions below."""
    import llvmlite
    import numba

    digest = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__} {sys.version_info[:2]}".encode())
    for path in sorted([*PACKAGE.glob("kernels/*.py"), *PACKAGE.rglob("_*kernels.py")]):
        digest.update(path.relative_to(PACKAGE).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def attach_cache(dispatcher, content: str) -> None:
    """Give a numba dispatcher our disk cache; `content` tells functions of the same name apart."""
    from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

    class Locator(_CacheLocator):
        def __init__(self, function) -> None:
            self._function = function

        def get_cache_path(self) -> str:
            return str(cache_folder() / source_stamp())

        def get_source_stamp(self) -> str:
            return source_stamp()

        def get_disambiguator(self) -> str:
            return content[:16]

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

    try:
        dispatcher._cache = Cache(dispatcher.py_func)
    except RuntimeError:  # no folder can be written
        return


def _content(function) -> str:
    code = function.__code__
    return hashlib.sha256(repr((function.__module__, function.__qualname__)).encode() + code.co_code).hexdigest()


def jit(function: Callable | None = None, **options) -> Any:
    """numba.njit with the project's flags and disk cache, for hand-written loops (in files named `_*kernels.py`).

    Flags: contraction and no signed zeros, numpy's error model, no lock held.
    """
    from numba import config, njit

    def wrap(f: Callable):
        if config.DISABLE_JIT:
            return f
        dispatcher = njit(**{**OPTIONS, **options})(f)
        attach_cache(dispatcher, _content(f))
        return dispatcher

    return wrap if function is None else wrap(function)


def on_compile(callback: Callable[[str], None]) -> None:
    """Call `callback(name)` whenever a function is compiled (not when it comes from the disk cache)."""
    from numba.core import event

    class Listener(event.Listener):
        def on_start(self, event) -> None:
            callback(event.data["dispatcher"].py_func.__name__)

        def on_end(self, event) -> None:
            pass

    event.register("numba:compile", Listener())
