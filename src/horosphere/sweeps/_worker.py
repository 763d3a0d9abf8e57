"""The process that solves problems: tasks come as lines of JSON on standard input, rows go as lines to standard output.

A process of its own for every worker, so that one that crashes or hangs takes nobody else down, and names what it was at.
"""

from __future__ import annotations

import faulthandler
import json
import os
import sys
import time
from typing import Any


def solve(task: dict[str, Any]) -> dict[str, Any]:
    """One row of the table: what became of a task. Never raises for what a problem does."""
    row: dict[str, Any] = {"key": task["key"], "problem": task["name"], "scene": task["scene"], "seed": task["seed"]}
    started = time.perf_counter()
    try:
        row |= _solved(task)
    except Exception as error:
        from ..errors import HorosphereError

        expected = isinstance(error, HorosphereError)
        said = "; ".join(str(e) for e in getattr(error, "errors", None) or (error,))
        row |= {
            "status": "bad input" if expected else "failed",
            "reason": said if expected else f"{type(error).__name__}: {said}",
        }
    return row | {"seconds": time.perf_counter() - started}


def _solved(task: dict[str, Any]) -> dict[str, Any]:
    from ..io import plain, save_trajectory
    from ..planning import plan
    from ..scenes import Scene

    scene = Scene.load(task["scene"])
    result = plan(scene, **task["options"])
    motion, certificate = result.trajectory, result.certificate
    if task["save"] and motion is not None:
        save_trajectory(motion, task["save"])
    return plain(
        {
            "status": "solved" if result.solved else "not solved",
            "reason": "" if result.solved else result.reason,
            "solved_by": result.solved_by,
            "certified": bool(getattr(certificate, "certified", False)),
            "clearance": getattr(certificate, "clearance", None),
            "required": result.scene.options.clearance,
            "duration": getattr(motion, "duration", None),
            "waypoints": None if motion is None else len(motion),
        }
    )


def main() -> None:
    """Solves until the input ends."""
    faulthandler.enable()
    rows = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what libraries print is no row
    for line in sys.stdin:
        rows.write(json.dumps(solve(json.loads(line))) + "\n")
        rows.flush()


if __name__ == "__main__":
    main()
