"""`horosphere robot`: what is made of a robot file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from . import _output as out
from ._source import USUAL, Loading

_YAML = (".yaml", ".yml")


def robot(
    file: str,
    /,
    *,
    loading: Loading = USUAL,
    pairs: bool = False,
    out_file: Annotated[Path | None, Parameter(name="--out")] = None,
    view: Path | None = None,
    scene: Path | None = None,
    force: bool = False,
    json: bool = False,
) -> int:
    """Shows what horosphere makes of a robot: chain, limits, collision model, closed-form inverse kinematics.

    Example: `horosphere robot humanoid-arm`

    Parameters
    ----------
    file
        A URDF, a robot file (YAML), or the name of a built-in robot.
    pairs
        List all pairs of links: checked against each other or not, and why.
    out_file
        Write the robot as a file: YAML, which `robot: {file: ...}` of a scene reads, or URDF, with spheres and cylinders.
    view
        Write the collision model as an HTML page to look at (needs the extra `view`). `horosphere show FILE` shows it live.
    scene
        Write a first scene for this robot (YAML: start, goal, a table), which `horosphere plan` solves as it stands. Its robot is
        the file of --out if that is YAML, otherwise FILE with the options given here.
    force
        Write over a scene that exists.
    json
        Print everything as JSON.
    """
    from .. import robots
    from ..kinematics import classify

    _check_files(out_file, view, scene, force)
    with out.working("reading the robot") as working:
        loaded = robots.load(file, progress=working.update, **loading.given)
        data = robots.describe(loaded)
        if out_file is not None:
            from ..io import output_folder

            output_folder(out_file.parent)
            robots.save(loaded, out_file)
            data["written"] = str(out_file)
        if scene is not None:
            from ..io import output_folder
            from ..planning import starter_scene

            working.update("looking for a first scene")
            written = _as_written(file, loading)
            if out_file is not None and out_file.suffix.lower() in _YAML:  # the model as it is: nothing is covered anew
                written = {"file": str(out_file.resolve())}
            first = starter_scene(loaded, written, name=scene.stem)
            output_folder(scene.parent)
            first.save(scene)
            data["scene"] = str(scene)
        if view is not None:
            from ..io import output_folder, writing
            from ..viewer import robot_html

            working.update("drawing")
            page = robot_html(loaded)
            output_folder(view.parent)
            with writing(view) as file_:
                file_.write(page)
            data["view"] = str(view)
    structure = classify(loaded)
    data |= _tool_pose(loaded)
    data["inverse_kinematics"] = {
        "name": structure.name,
        "branches": structure.branches,
        "parameter": structure.parameter,
        "reasons": structure.reasons,
        "near_misses": structure.near_misses,
        "position": None if structure.position is None else str(structure.position),
    }
    if json:
        out.print_json(data)
        return out.DONE
    bodies = data["collision"]["bodies"]
    rows = [
        ("Robot", f"{data['name']}, {len(data['joints'])} joints"),
        ("Source", data["source"]),
        ("Chain", " > ".join(data["chain"])),
        ("Tool", _tool_text(data)),
        ("Inverse kinematics", f"closed form, {structure}" if structure.is_closed_form else str(structure)),
        ("Collision model", f"{len(bodies)} bodies on {', '.join(data['collision']['links'])}" if bodies else "NONE"),
        ("Self-collision", _pair_counts(data["collision"]["pairs"], len(data["collision"]["self_pairs"]))),
    ]
    if data["collision"]["static_links"]:
        rows.append(("Stand still", ", ".join(data["collision"]["static_links"])))
    written = [str(path) for path in (out_file, scene, view) if path is not None]
    if written:
        rows.append(("Written", ", ".join(written)))
    out.print_rows(rows)
    _print_joints(data["joints"])
    if pairs:
        _print_pairs(data["collision"]["pairs"])
    out.print_notes(data["notes"])
    return out.DONE


def _check_files(out_file: Path | None, view: Path | None, scene: Path | None, force: bool) -> None:
    """Before anything is computed: endings, and that no scene is lost."""
    from ..errors import InputError

    for path, endings, what in ((view, (".html", ".htm"), "page"), (scene, _YAML, "scene")):
        if path is not None and path.suffix.lower() not in endings:
            raise InputError(f"no {what} has the ending {path.suffix!r}", place=str(path), choices=endings)
    if scene is not None and out_file is not None and scene.resolve() == out_file.resolve():
        raise InputError("the robot and the scene cannot be one file", place=str(scene), remedy="give two names")
    if scene is not None and scene.exists() and not force:
        raise InputError("the file exists already", place=str(scene), remedy="another name, or --force")


def _as_written(file: str, loading: Loading) -> Any:
    """The robot as a scene file has it: a name, or a file with the options that are not the usual ones."""
    path = Path(file)
    given = {name: str(v.resolve()) if isinstance(v, Path) else v for name, v in loading.given.items()}
    if not path.is_file():
        return {"name": file, **given} if given else file
    kind = "file" if path.suffix.lower() in _YAML else "urdf"
    return {kind: str(path.resolve()), **given}


def _tool_pose(robot: Any) -> dict[str, Any]:
    """Where the tool is with every joint in the middle of its range (at 0 without limits), and a bound of its reach (m)."""
    import numpy as np

    from ..kinematics import forward
    from ..kinematics._numeric import reach
    from ..scenes import matrix_quaternion

    q = robot.limits.middle
    pose = forward(robot, q)
    place = {
        "q": q.tolist(),
        "position": pose.translation.tolist(),
        "quaternion_wxyz": matrix_quaternion(pose.as_matrix()[:3, :3]).tolist(),
    }
    far = reach(robot)
    return {"tool_pose": place, "reach": far if np.isfinite(far) else None}


def _tool_text(data: dict[str, Any]) -> str:
    """Where the tool is, as a scene says it."""
    from ..numeric import at_most

    place, far = data["tool_pose"], data["reach"]
    at, turn = (", ".join(f"{round(v, 4) + 0.0:g}" for v in place[key]) for key in ("position", "quaternion_wxyz"))
    text = f"with all joints in the middle: {{position: [{at}], quaternion_wxyz: [{turn}]}}"
    return text if far is None else f"{text}; at most {at_most(far, decimals=3)} m from the first joint"


def _pair_counts(pairs: list[dict[str, Any]], checked: int) -> str:
    """How many pairs are checked, and for which reasons the others are not."""
    from collections import Counter

    reasons = Counter(pair["why"].split(":")[0] for pair in pairs if not pair["checked"])
    others = ", ".join(f"{count} {reason}" for reason, count in reasons.most_common())
    return f"{checked} pairs of links are checked" + (f"; not checked: {others}" if others else "")


def _print_pairs(pairs: list[dict[str, Any]]) -> None:
    from rich.table import Table

    table = Table(box=None, padding=(0, 2, 0, 0))
    for name in ("link", "link", "checked", "why"):
        table.add_column(name, header_style="dim", overflow="fold")
    for pair in pairs:
        first, second = map(out.plain_text, pair["links"])
        table.add_row(first, second, "yes" if pair["checked"] else "no", out.plain_text(pair["why"]))
    out.print_table(table)


def _print_joints(joints: list[dict[str, Any]]) -> None:
    from rich.table import Table

    table = Table(box=None, padding=(0, 2, 0, 0), title_justify="left")
    for name in ("joint", "type", "lower", "upper", "velocity", "acceleration", "effort"):
        table.add_column(name, justify="left" if name in ("joint", "type") else "right", header_style="dim")
    for joint in joints:
        turns = joint["type"] != "prismatic"
        cells = [_amount(joint[key], turns) for key in ("lower", "upper")]
        cells += [_amount(joint["velocity"], turns, "/s"), _amount(joint["acceleration"], turns, "/s2")]
        effort = joint["effort"]
        table.add_row(
            joint["name"], joint["type"], *cells, "-" if effort is None else f"{effort:g} {'N m' if turns else 'N'}"
        )
    out.print_table(table)


def _amount(value: float | None, turns: bool, per: str = "") -> str:
    if value is None:
        return "-"
    return f"{math.degrees(value):.4g} deg{per}" if turns else f"{value:.4g} m{per}"
