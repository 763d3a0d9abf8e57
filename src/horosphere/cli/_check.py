"""`horosphere check`: certifies a trajectory, whoever made it."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from . import _output as out
from ._plan import certificate_data
from ._source import NOTHING, MoveIt

CHECKED = ("certificate.json", "report.html")
_UNTIMED = "the trajectory has no times: mean velocities were not checked, and its waypoints are shown one second apart"

_DEGREES = "angles of a trajectory are radians; taken as degrees these would all lie inside the limits of the joints: convert them"


def check(
    scene: str,
    trajectory: Path,
    /,
    *,
    moveit: MoveIt = NOTHING,
    clearance: float | None = None,
    out_folder: Annotated[Path | None, Parameter(name="--out")] = None,
    json: bool = False,
) -> int:
    """Certifies a trajectory in a scene: clearance at every instant, joint limits, goal error.

    Example: `horosphere check humanoid-reach out/humanoid-reach/trajectory.npz`

    Exit code 0: certified, 1: not, with the first violation, 2: bad input.

    Parameters
    ----------
    scene
        A scene file (YAML), or the name of a built-in scene (see `horosphere scenes`); or a MoveIt scene: a file, or
        ARCHIVE:SET/NUMBER.
    trajectory
        An .npz (arrays time and q), .csv (columns time and one per joint) or .mcap file, also of another planner.
    clearance
        Metres to keep between robot and obstacles, instead of the scene's.
    out_folder
        Folder for certificate.json and report.html; nothing is written without it.
    json
        Print the result as JSON.
    """
    from ..io import load_trajectory, output_folder
    from ..scenes import SnakeRobot
    from ._plan import checked_options, digest

    with out.working("reading"):
        problem = moveit.load(scene)
        if clearance is not None:
            options = dataclasses.replace(problem.options, **checked_options({"clearance": clearance}))
            problem = problem.with_(options=options)
        motion = ordered(problem, load_trajectory(trajectory), str(trajectory))
    folder = None if out_folder is None else output_folder(out_folder)
    with out.working("certifying") as progress:
        from ..certify import certify
        from ..io import to_json, writing, writing_set
        from ..scenes._checks import looks_like_degrees
        from ..viewer import goal_error, has_viser, measure, report_html, summarise

        out.announce_compiling(progress)
        if isinstance(problem.robot, SnakeRobot):
            from ..snake import certify_trajectory

            certificate = certify_trajectory(problem, motion)
        else:
            certificate = certify(problem, motion)
        measures = measure(problem, motion)
        said = certificate.reasons[0] if certificate.reasons else ""
        notes = () if motion.is_timed else (_UNTIMED,)
        if hasattr(problem.robot, "limits") and looks_like_degrees(problem.robot, motion.positions):
            notes += (_DEGREES,)
        summary = summarise(problem, motion, measures, certificate=certificate, reason=said, notes=notes)
        data: dict[str, Any] = {
            "scene": problem.name,
            "trajectory": str(trajectory),
            "sha256": {trajectory.name: digest(trajectory)},
            "certified": bool(certificate.certified),
            "verdict": summary.verdict,
            "clearance_required": problem.options.clearance,
            "goal_error": goal_error(measures),
            "max_step": motion.max_step,
            "duration": motion.duration,
            "certificate": certificate_data(certificate),
            "collision_model": dict(summary.rows)["Collision model"],
            "notes": list(summary.notes),
        }
        files = []
        if folder is not None:
            contents = {"certificate.json": to_json(data) + "\n"}
            if has_viser():
                progress.update("drawing the report")
                contents["report.html"] = report_html(problem, motion, certificate=certificate, notes=notes)
            with writing_set(folder, CHECKED) as stage:
                for name, text in contents.items():
                    with writing(stage / name) as file:
                        file.write(text)
            files = [str(folder / name) for name in contents]
    if json:
        out.print_json({**data, "files": files})
    else:
        out.print_verdict(summary.verdict, summary.good)
        out.print_rows([*summary.rows, *([("Files", ", ".join(files))] if files else [])])
        out.print_notes(summary.notes)
    return out.DONE if summary.good else out.FAILED


def ordered(scene: Any, motion: Any, place: str) -> Any:
    """The trajectory with its columns in the robot's order of joints; InputError if they are not the robot's."""
    from ..errors import InputError

    names = getattr(scene.robot, "joint_names", None)
    count = motion.positions.shape[1]
    expected = len(names) if names else coordinates(scene)
    if names and motion.names and set(motion.names) == set(names):
        order = [motion.names.index(name) for name in names]
        columns = {
            key: None if getattr(motion, key) is None else getattr(motion, key)[:, order]
            for key in ("positions", "velocities", "accelerations")
        }
        return dataclasses.replace(motion, names=tuple(names), **columns)
    if names and motion.names and set(motion.names) & set(names):
        strange = sorted(set(motion.names) - set(names)) or sorted(set(names) - set(motion.names))
        raise InputError(
            f"its joints are not those of {scene.robot.name!r}: {', '.join(strange)}", place=place, choices=names
        )
    if count != expected:
        raise InputError(
            f"{count} columns, but {scene.robot.name!r} has {expected}"
            + (f" joints ({', '.join(names)})" if names else ""),
            place=place,
        )
    if names and motion.names:
        raise InputError(
            f"it was made for another robot, or names the joints otherwise: it moves {', '.join(motion.names)}, "
            f"{scene.robot.name!r} has {', '.join(names)}",
            place=place,
        )
    return motion


def coordinates(scene: Any) -> int:
    """Length of a configuration of a robot that is no arm."""
    kind = type(scene.robot).__name__
    return {"PointRobot": scene.dimension, "UnicycleRobot": 3}.get(kind) or scene.robot.links + 2
