"""`horosphere plan`: from a scene to a certified motion, with its files."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from . import _output as out
from ._source import NOTHING, MoveIt
from ._values import Whole

WRITTEN = ("trajectory.npz", "trajectory.csv", "certificate.json", "report.html")


def plan(
    scene: str,
    /,
    *,
    moveit: MoveIt = NOTHING,
    out_folder: Annotated[Path | None, Parameter(name="--out")] = None,
    save: tuple[Path, ...] = (),
    clearance: float | None = None,
    method: Literal["auto", "field", "tree", "reactive", "reactive-or-tree"] | None = None,
    path_step: float | None = None,
    time: float | None = None,
    time_limit: float | None = None,
    seed: Whole | None = None,
    report: Annotated[bool, Parameter(negative="--no-report")] = True,
    json: bool = False,
) -> int:
    """Moves the robot of a scene from start to goal without collision, proves it, and writes what came out.

    Example: `horosphere plan humanoid-reach`

    A MoveIt scene needs a robot: `horosphere plan scene0001.yaml --robot panda.urdf`.

    Writes trajectory.npz, trajectory.csv, certificate.json and report.html. Exit code 0: solved and certified,
    1: not solved (the reason is printed), 2: bad input.

    Parameters
    ----------
    scene
        A scene file (YAML), or the name of a built-in scene (see `horosphere scenes`); or a MoveIt scene: a file, or
        ARCHIVE:SET/NUMBER.
    out_folder
        Folder for the results; out/NAME by default.
    save
        One more file for the trajectory; .npz, .csv or .mcap (ROS 2, opens in Foxglove). May be given several times.
    clearance
        Metres to keep between robot and obstacles, instead of the scene's.
    method
        auto (the field, else a tree), field (no tree search), tree, reactive (the law of the live loop, no tree), reactive-or-tree.
    path_step
        Metres between points of the tool path, instead of the scene's (0.02 if it says nothing).
    time
        Seconds to go on after the first certified plan of tree or reactive law, for one that is shorter and further from
        obstacles, instead of the scene's (1 if it says nothing; 0: not).
    time_limit
        Seconds to look for the first plan, instead of the scene's (10 if it says nothing).
    seed
        Of the random numbers, instead of the scene's (0 if it says nothing).
    report
        Write report.html (needs the extra `view`).
    json
        Print the result as JSON.
    """
    from ..io import output_folder

    with out.working("reading the scene"):
        problem = moveit.load(scene)
    folder = output_folder(out_folder if out_folder is not None else Path("out") / problem.name)
    for path in save:
        _check_ending(path)
        output_folder(path.parent)
    asked = {
        "clearance": clearance, "method": method, "path_step": path_step, "improvement_time": time, "time_limit": time_limit,
        "seed": seed,
    }  # fmt: skip
    options = checked_options({name: value for name, value in asked.items() if value is not None})
    with out.working("planning") as progress:
        from ..planning import plan as run

        out.announce_compiling(progress)
        result = run(problem, **options)
        problem = getattr(result, "scene", problem)
        if report:
            progress.update("drawing the report")
        files, summary, data = results(problem, result, report)
        progress.update("writing")
        names, removed = write_all(folder, data, files, result.trajectory, save)
    data["files"] = names
    if removed:
        data["hints"].append(f"removed {', '.join(removed)} of an earlier run from {folder}")
    if json:
        out.print_json(data)
    else:
        out.print_verdict(summary.verdict, summary.good)
        out.print_rows([*summary.rows, ("Files", ", ".join(names))])
        out.print_notes(data["hints"])
        out.print_notes(summary.notes)
    return out.DONE if summary.good else out.FAILED


def checked_options(given: dict[str, Any]) -> dict[str, Any]:
    """Options of the command line under the same rules as those of a scene file."""
    import pydantic

    from ..errors import InputError
    from ..scenes._schema import OptionFields

    try:
        OptionFields.model_validate(given)
    except pydantic.ValidationError as error:
        first = error.errors()[0]
        name = str(first["loc"][0]).replace("improvement_time", "time").replace("_", "-")
        message = f"{first['msg'][0].lower() + first['msg'][1:]}, got {first['input']!r}"
        raise InputError(message, place=f"--{name}") from None
    return given


def _check_ending(path: Path) -> None:
    from ..errors import InputError
    from ..io import TRAJECTORY_ENDINGS

    if path.suffix.lower() not in TRAJECTORY_ENDINGS:
        raise InputError(
            f"no trajectory format has the ending {path.suffix!r}", place=str(path), choices=TRAJECTORY_ENDINGS
        )


def results(scene: Any, result: Any, report: bool) -> tuple[dict[str, Any], Any, dict[str, Any]]:
    """Contents of further files by name, the summary, and what certificate.json and `--json` say."""
    from ..viewer import goal_error, has_viser, measure, report_html, summarise

    trajectory = result.trajectory
    facts = {
        "certificate": result.certificate,
        "solved": result.solved,
        "reason": result.reason,
        "solved_by": result.solved_by,
        "timings": result.timings,
        "notes": tuple(result.notes),
    }
    measures = None if trajectory is None else measure(scene, trajectory)
    summary = summarise(scene, trajectory, measures, **facts)
    data = {
        "scene": scene.name,
        "source": scene.source,
        "solved": bool(result.solved),
        "verdict": summary.verdict,
        "reason": result.reason,
        "solved_by": result.solved_by,
        "clearance_required": scene.options.clearance,
        "goal_error": goal_error(measures),
        "max_step": None if trajectory is None else trajectory.max_step,
        "duration": None if trajectory is None else trajectory.duration,
        "timings": result.timings,
        "improvement": getattr(result, "improvement", None),
        "certificate": certificate_data(result.certificate),
        "robot": getattr(scene.robot, "name", ""),
        "collision_model": dict(summary.rows)["Collision model"],
        "options": dataclasses.asdict(scene.options),
        "notes": list(summary.notes),
    }
    files: dict[str, Any] = {}
    hints = []
    if report and not has_viser():
        hints.append("no report: it needs the extra `view` (pip install 'horosphere[view]')")
    elif report:
        files["report.html"] = report_html(scene, trajectory, path=result.path, **facts)
    return files, summary, {**data, "hints": hints}


def certificate_data(certificate: Any) -> Any:
    """A certificate as plain values."""
    from ..io import plain

    return plain(certificate.as_dict() if hasattr(certificate, "as_dict") else certificate)


def digest(path: Path) -> str:
    """SHA-256 of a file: what a certificate is about."""
    import hashlib

    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_all(
    folder: Path, data: dict[str, Any], files: dict[str, Any], trajectory: Any, more: tuple[Path, ...] = ()
) -> tuple[list[str], list[str]]:
    """Writes the results, all of them or none; those of an earlier run in the folder go away with it. Returns the files, and the
    names of those that were there before and are not now. `data` learns the digests of the trajectory's files."""
    from ..io import save_trajectory, to_json, writing, writing_set

    before = [name for name in WRITTEN if (folder / name).is_file()]
    with writing_set(folder, WRITTEN) as stage:
        for name in WRITTEN:
            if name.startswith("trajectory") and trajectory is not None:
                save_trajectory(trajectory, stage / name)
            elif name == "certificate.json":
                if trajectory is not None:
                    data["sha256"] = {file.name: digest(file) for file in sorted(stage.glob("trajectory.*"))}
                with writing(stage / name) as file:
                    file.write(to_json({key: value for key, value in data.items() if key != "hints"}) + "\n")
            elif name in files:
                with writing(stage / name) as file:
                    file.write(files[name])
        if trajectory is not None:
            for path in more:
                save_trajectory(trajectory, path)
    written = [folder / name for name in WRITTEN if (folder / name).exists()]
    removed = [name for name in before if not (folder / name).exists()]
    return [str(path) for path in (*written, *(more if trajectory is not None else ()))], removed
