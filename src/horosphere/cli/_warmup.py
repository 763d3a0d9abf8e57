"""`horosphere warmup`: compiles the kernels ahead of the first use."""

from __future__ import annotations

import time

from . import _output as out

SCENES = ("humanoid-reach", "panda-table", "nao-reach", "rn-fig1-basic")
"""One of each kind: closed form, tree, Jacobian, a point in the plane."""


def warmup(*, json: bool = False) -> int:
    """Compiles and caches what `plan` and `check` need, so that the first run is as quick as every other.

    Example: `horosphere warmup`

    Parameters
    ----------
    json
        Print the result as JSON.
    """
    from ..kernels import cache_folder
    from ..scenes import Scene

    started = time.perf_counter()
    done = []
    with out.working("planning built-in scenes") as progress:
        out.announce_compiling(progress)
        from ..planning import plan

        for name in SCENES:
            plan(Scene.load(name))
            done.append(name)
    data = {
        "scenes": done,
        "compiled": len(out.compiled_names()),
        "seconds": time.perf_counter() - started,
        "cache": str(cache_folder()) if cache_folder() else None,
    }
    if json:
        out.print_json(data)
    else:
        what = f"{data['compiled']} functions compiled" if data["compiled"] else "everything was compiled already"
        out.print_rows(
            [
                ("Kernels", what),
                ("Time", f"{data['seconds']:.1f} s"),
                ("Cache", data["cache"] or "none (no folder can be written)"),
            ]
        )
    return out.DONE
