"""`horosphere robot`: what is made of a robot file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from . import _output as out


def robot(
    file: str,
    /,
    *,
    base: str | None = None,
    tip: str | None = None,
    capsules: Path | None = None,
    link_radius: float | None = None,
    out_file: Annotated[Path | None, Parameter(name="--out")] = None,
    json: bool = False,
) -> int:
    """Shows what horosphere makes of a robot: chain, limits, collision model, closed-form inverse kinematics.

    Example: `horosphere robot humanoid-arm`

    Parameters
    ----------
    file
        A URDF, a robot file (YAML), or the name of a built-in robot.
    base
        First link of the chain (URDF), the root by default.
    tip
        Last link of the chain (URDF); needed if the tree has several leaves.
    capsules
        A capsule file with the collision bodies, for a robot whose meshes are missing.
    link_radius
        Metres; capsules of this radius along the links that have no collision body.
    out_file
        Write the robot as a file (YAML) that `robot: {file: ...}` of a scene reads.
    json
        Print everything as JSON.
    """
    from .. import robots

    with out.working("reading the robot"):
        options: dict[str, Any] = {"base": base, "tip": tip, "link_radius": link_radius}
        loaded = robots.load(file, capsules=capsules, **options)
        data = robots.describe(loaded)
        if out_file is not None:
            from ..io import output_folder

            output_folder(out_file.parent)
            robots.save(loaded, out_file)
            data["written"] = str(out_file)
    if json:
        out.print_json(data)
        return out.DONE
    form = data["closed_form"]
    bodies = data["collision"]["bodies"]
    rows = [
        ("Robot", f"{data['name']}, {len(data['joints'])} joints"),
        ("Source", data["source"]),
        ("Chain", " > ".join(data["chain"])),
        ("Inverse kinematics", f"closed form, {form['name']}" if form else "numerical"),
        ("Collision model", f"{len(bodies)} bodies on {', '.join(data['collision']['links'])}" if bodies else "NONE"),
        ("Self-collision", f"{len(data['collision']['self_pairs'])} pairs of links are checked"),
    ]
    if out_file is not None:
        rows.append(("Written", out_file))
    out.print_rows(rows)
    _print_joints(data["joints"])
    out.print_notes(data["notes"])
    return out.DONE


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
        table.add_row(joint["name"], joint["type"], *cells, "-" if effort is None else f"{effort:g}")
    out.print_table(table)


def _amount(value: float | None, turns: bool, per: str = "") -> str:
    if value is None:
        return "-"
    return f"{math.degrees(value):.4g} deg{per}" if turns else f"{value:.4g} m{per}"
