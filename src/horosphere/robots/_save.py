"""Robots written to files: YAML with everything, URDF for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .._atomic import writing
from ..errors import InputError
from ..numeric import file_path
from ._document import LIMIT_NAMES
from ._robot import LinkPair, Robot, require_robot


def save(robot: Robot, path: str | Path) -> None:
    """Write a robot as YAML, which `load` reads back to the last bit, or as URDF (`.urdf`): chain, limits, collision bodies as
    spheres and cylinders. The file appears whole or not at all. Raises InputError for another ending."""
    require_robot(robot)
    path = file_path(path, "path")
    ending = path.suffix.lower()
    if ending in (".yaml", ".yml"):
        text = as_yaml(robot)
    elif ending == ".urdf":
        from ._urdf_write import as_urdf

        text = as_urdf(robot)
    else:
        raise InputError(
            f"no robot is written to {path.suffix or 'a file without ending'!r}",
            place=str(path),
            choices=(".yaml", ".urdf"),
        )
    with writing(path) as file:
        file.write(text)


def as_yaml(robot: Robot) -> str:
    """The text of a robot file."""
    import yaml

    names = robot.link_names
    entries: list[dict[str, Any]] = []
    seen: set[int] = set()
    for link in robot.links:
        entry: dict[str, Any] = {"name": link.name}
        if link.parent >= 0:
            entry |= {"parent": names[link.parent], "motor": link.origin.tolist()}
        if link.kind != "fixed":
            entry |= {"type": link.kind, "axis": link.axis.tolist()}
            joint = robot.joint_names[link.coordinate]
            if link.coordinate in seen or (link.multiplier, link.offset) != (1.0, 0.0):
                entry["mimic"] = {"joint": joint, "multiplier": link.multiplier, "offset": link.offset}
            else:
                values = {key: float(getattr(robot.limits, key)[link.coordinate]) for key in LIMIT_NAMES}
                entry |= {"joint": joint, "limits": {key: v for key, v in values.items() if np.isfinite(v)}}
            seen.add(link.coordinate)
        entries.append(entry)
    bodies: dict[str, list[dict[str, Any]]] = {}
    caps = robot.capsules
    for k in range(len(caps)):
        item = {"a": caps.a[k].tolist(), "b": caps.b[k].tolist(), "radius": float(caps.radius[k]), "note": caps.note[k]}
        bodies.setdefault(names[caps.link[k]], []).append(item)
    document: dict[str, Any] = {"horosphere/robot": 1, "name": robot.name, "source": robot.source}
    held = {"links": len(robot.links), "capsules": len(caps), "pairs": len(robot.pair_table or robot.self_pairs)}
    document |= {"holds": held, "links": entries}  # before what it counts: it outlives a cut
    document |= {"tip": names[robot.tip], "tool": {"motor": robot.tool.tolist()}, "capsules": bodies}
    if robot.pair_table:
        document["pairs"] = [_pair_entry(pair) for pair in robot.pair_table]
    else:
        document["self_pairs"] = [[names[i], names[j]] for i, j in robot.self_pairs]
    if robot.allowed_obstacles:
        document["allowed_obstacles"] = [list(pair) for pair in robot.allowed_obstacles]
    document["notes"] = list(robot.notes)
    if robot.closed_form is not None:
        document["closed_form"] = {robot.closed_form[0]: dict(robot.closed_form[1])}
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=140)


def _pair_entry(pair: LinkPair) -> dict[str, Any]:
    entry = {"links": [pair.first, pair.second], "checked": pair.checked, "why": pair.reason}
    return entry if pair.touching is None else entry | {"touching": pair.touching}
