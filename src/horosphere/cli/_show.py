"""`horosphere show`: the live view."""

from __future__ import annotations

from pathlib import Path

from . import _output as out


def show(
    scene: str,
    trajectory: Path | None = None,
    /,
    *,
    port: int | None = None,
    seconds: float | None = None,
    json: bool = False,
) -> int:
    """Shows a scene in the browser: drag the goal and the balls, the motion follows. Ctrl-C ends it.

    Example: `horosphere show humanoid-reach`

    Parameters
    ----------
    scene
        A scene file (YAML), or the name of a built-in scene.
    trajectory
        A motion to show; planned without it.
    port
        Port on this machine, 8080 or the next free one by default.
    seconds
        End after so many seconds.
    json
        Print the address as JSON.
    """
    from ..errors import InputError
    from ..io import load_trajectory
    from ..scenes import Scene
    from ..viewer import LiveView
    from ._check import ordered

    if port is not None and not 0 <= port <= 65535:
        raise InputError(f"expected a port in 0 .. 65535, got {port}", place="--port")
    with out.working("reading the scene"):
        problem = Scene.load(scene)
        motion = None if trajectory is None else ordered(problem, load_trajectory(trajectory), str(trajectory))
    with out.working("starting the view") as progress:
        from ..planning import plan

        out.announce_compiling(progress)
        view = LiveView(problem, plan, motion, port)
    try:
        if json:
            out.print_json({"address": view.address, "scene": problem.name})
        else:
            out.print_rows([("View", view.address), ("Stop", "Ctrl-C")])
        out.flush()
        view.run(seconds)
    except KeyboardInterrupt:
        pass  # the way to end it
    finally:
        view.close()
    return out.DONE
