"""`horosphere show`: the live view."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from . import _output as out
from ._source import NOTHING, MoveIt
from ._values import Whole


def show(
    scene: str,
    trajectory: Path | None = None,
    /,
    *,
    moveit: MoveIt = NOTHING,
    port: Whole | None = None,
    seconds: float | None = None,
    json: bool = False,
) -> int:
    """Shows a scene in the browser: drag the goal and the balls, the motion follows. Ctrl-C ends it.

    A robot (a URDF with one tip, a robot file, a built-in name) is shown with its collision model and a slider for each joint.

    Example: `horosphere show humanoid-reach`

    Parameters
    ----------
    scene
        A scene file (YAML), or the name of a built-in scene; or a MoveIt scene: a file, or ARCHIVE:SET/NUMBER; or a robot.
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
    from ..viewer import LiveView, RobotView
    from ._check import ordered

    if port is not None and not 0 <= port <= 65535:
        raise InputError(f"expected a port in 0 .. 65535, got {port}", place="--port")
    if seconds is not None and not seconds > 0.0:
        raise InputError(f"expected seconds > 0, got {seconds}", place="--seconds")
    with out.working("reading the scene") as reading:
        robot = _robot(scene, reading)
        if robot is not None:
            return _serve(RobotView(robot, port), robot.name, seconds, json)
        problem = moveit.load(scene)
        motion = None if trajectory is None else ordered(problem, load_trajectory(trajectory), str(trajectory))
    with out.working("starting the view") as progress:
        from ..planning import plan

        out.announce_compiling(progress)
        view = LiveView(problem, plan, motion, port)
    return _serve(view, problem.name, seconds, json)


def _robot(name: str, reading: out.Working) -> Any:
    """The robot that `name` is; None if it is a scene."""
    from .. import robots, scenes

    path = Path(name)
    if name in robots.names() and name not in scenes.names():
        return robots.load(name)
    if path.suffix.lower() in (".yaml", ".yml") and path.is_file():
        with path.open(encoding="utf-8", errors="replace") as file:
            if not any(line.startswith("horosphere/robot:") for line in file):
                return None
    elif path.suffix.lower() != ".urdf":
        return None
    return robots.load(name, progress=reading.update)


def _serve(view: Any, name: str, seconds: float | None, json: bool) -> int:
    """Says where the view is, and runs it."""
    try:
        if json:
            out.print_json({"address": view.address, "scene": name})
        else:
            out.print_rows([("View", view.address), ("Stop", "Ctrl-C")])
        out.flush()
        view.run(seconds)
    except KeyboardInterrupt:
        pass  # the way to end it
    finally:
        view.close()
    return out.DONE
