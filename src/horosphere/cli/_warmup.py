"""`horosphere warmup`: compiles the kernels ahead of the first use."""

from __future__ import annotations

import time
from typing import Any

from . import _output as out

SCENES = ("humanoid-reach", "panda-table", "nao-reach", "rn-fig1-basic")
"""One of each kind: closed form, tree, Jacobian, a point in the plane."""

ARMS = ("panda", "iiwa14", "humanoid-arm")
"""One of each kind of redundancy: q7, the elbow's angle, the turn about the gripper's axis."""


def warmup(*, json: bool = False) -> int:
    """Compiles and caches what `plan`, `check`, the live loop and the free arcs of redundant arms need.

    The last two are used from Python (`control.Reactive`; `kinematics.free_arcs`, `roomiest`). It takes about 40 seconds of
    processor time, once a machine and version; then the first run is as quick as every other.

    Example: `horosphere warmup`

    Parameters
    ----------
    json
        Print the result as JSON.
    """
    from ..kernels import cache_folder, is_cache_writable

    started = time.perf_counter()
    parts = (("planning built-in scenes", _plan), ("the live loop", _live_loop), ("free arcs", _free_arcs))
    done: dict[str, Any] = {}
    with out.working(parts[0][0]) as progress:
        out.announce_compiling(progress)
        for name, part in parts:
            progress.update(name)
            compiled, began = len(out.compiled_names()), time.perf_counter()
            part()
            done[name] = {
                "compiled": len(out.compiled_names()) - compiled,
                "seconds": time.perf_counter() - began,
            }
    data = {
        "scenes": list(SCENES),
        "parts": done,
        "compiled": len(out.compiled_names()),
        "seconds": time.perf_counter() - started,
        "cache": str(cache_folder()) if is_cache_writable() else None,
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


def _plan() -> None:
    from ..planning import plan
    from ..scenes import Scene

    for name in SCENES:
        plan(Scene.load(name))


def _live_loop() -> None:
    import numpy as np

    from ..control import Reactive
    from ..kinematics import forward

    robot, q = _at_ease(ARMS[0])
    Reactive(robot, (np.array([[0.6, 0.6, 0.6]]), np.array([0.05])), goal=forward(robot, q)).step(q)


def _free_arcs() -> None:
    import numpy as np

    from ..kinematics import GripperOnPlane, forward, roomiest
    from ..shapes import Ball, Box, PointCloud

    at, size = np.full(3, 2.0), np.full(3, 0.1)
    ball, box, cloud = Ball(at, 0.1), Box(at, size), PointCloud(at + 0.01 * np.arange(100.0)[:, None], 0.01)
    kinds = ([ball], [box], [box, cloud])  # each a code of its own
    for name, some in ((ARMS[0], kinds), *((name, kinds[:1]) for name in ARMS[1:])):
        robot, q = _at_ease(name)
        pose = forward(robot, q)
        target = pose if robot.n_joints > 5 else GripperOnPlane(pose.translation, pose.as_matrix()[:3, 0])
        for obstacles in some:
            roomiest(robot, target, obstacles, self_clearance=0.0)  # which asks for the free arcs


def _at_ease(name: str) -> tuple[Any, Any]:
    """A robot, and its joints in the middle of their ranges."""
    from .. import robots

    robot = robots.load(name)
    return robot, robot.limits.middle
