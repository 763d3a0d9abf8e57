"""`horosphere field`: the picture of a harmonic field."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from . import _output as out

PICTURES = (".png", ".svg", ".pdf")


def field(
    scene: str,
    /,
    *,
    out_file: Annotated[Path | None, Parameter(name="--out")] = None,
    motion: Annotated[bool, Parameter(negative="--no-motion")] = True,
    json: bool = False,
) -> int:
    """Draws the field of a scene: security zones, gradient lines, unstable points, the motion; in the plane equipotentials,
    in space the distances to the zones and which of them count.

    Example: `horosphere field rn-fig1-basic`

    Parameters
    ----------
    scene
        A scene file (YAML) with a robot of type point or unicycle, or the name of a built-in scene.
    out_file
        Where to draw it: .png, .svg or .pdf; out/NAME/field.png by default.
    motion
        Draw the line that the robot follows, too.
    json
        Print what was drawn as JSON.
    """
    from ..errors import InputError
    from ..io import output_folder
    from ..scenes import PointRobot, Scene, UnicycleRobot
    from ..scenes._moveit_files import names_moveit

    if names_moveit(scene):
        raise InputError(
            "the picture of a field shows a point or a unicycle, not that of a MoveIt scene, which is an arm",
            place=scene,
            remedy="`horosphere plan` writes a report of its motion",
        )
    problem = Scene.load(scene)
    robot, start = problem.robot, getattr(problem.start, "position", None)
    if not isinstance(robot, (PointRobot, UnicycleRobot)) or start is None or problem.dimension > 3:
        raise InputError(
            "the picture of a field shows a point or a unicycle in the plane or in space, "
            f"not {robot.name!r} in R^{problem.dimension}",
            place=scene,
            remedy="`horosphere plan` writes a report of its motion",
        )
    file = out_file if out_file is not None else Path("out") / problem.name / "field.png"
    if file.suffix.lower() not in PICTURES:
        raise InputError(f"no picture has the ending {file.suffix!r}", place=str(file), choices=PICTURES)
    output_folder(file.parent)
    with out.working("drawing the field") as progress:
        from ..planning import harmonic_field

        out.announce_compiling(progress)
        drawn = harmonic_field(problem, robot.radius + problem.options.clearance)
        path: Any = drawn.trace(start, step=problem.options.path_step) if motion else None
        _write(drawn, path, problem.name, file, getattr(robot, "unit", "m"))
    data = {"scene": problem.name, "written": str(file), "reached": getattr(path, "reached", None)}
    data |= {"reason": getattr(path, "reason", None), "length": getattr(path, "length", None)}
    if json:
        out.print_json(data)
    else:
        rows = [("Field", problem.name), ("Written", file)]
        out.print_rows([*rows, ("Motion", f"{path.reason}, {path.length:.3f} m")] if motion else rows)
    return out.DONE if path is None or path.reached else out.FAILED


def _write(drawn: Any, path: Any, title: str, file: Path, unit: str) -> None:
    import matplotlib

    from ..io import writing

    matplotlib.use("Agg")
    axes = drawn.plot(path, title=title, unit=unit)
    with writing(file, "wb") as stream:
        axes.figure.savefig(stream, format=file.suffix[1:].lower(), dpi=150)
