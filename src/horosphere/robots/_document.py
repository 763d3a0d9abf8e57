"""Robots from YAML files: the built-in catalogue, and what `save` writes.

    horosphere/robot: 1
    name: two-link
    source: drawn by hand
    links:
      - {name: base}
      - {name: arm, parent: base, joint: shoulder, type: revolute, xyz: [0, 0, 0.1], axis: [0, 1, 0],
         limits: {lower: -90 deg, upper: 90 deg, velocity: 2.0}}
    tip: arm
    tool: {xyz: [0, 0, 0.3]}
    closed_form: {srs_arm: {dbs: 0.1, ...}}       # optional
    capsules: {arm: {radius: 0.04}}               # optional, as in a capsule file
    holds: {links: 2, capsules: 1, pairs: 0}      # optional; a file that was cut off holds fewer

A frame is `xyz` (metres) with `rpy` (radians) or `rpy_deg`, or the eight numbers of `motor`. Angles may be written as
'90 deg'.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, unknown_name
from ..numeric import float_array
from . import _pairs, _placement
from ._bodies import Body
from ._robot import Capsules, Limits, Link, LinkPair, Robot
from ._sidecar import read_capsules, read_yaml

_TOP = (
    *("horosphere/robot", "name", "source", "notes", "links", "tip", "tool", "closed_form", "capsules"),
    *("self_pairs", "pairs", "allowed_obstacles", "holds"),
)
_FRAME = ("xyz", "rpy", "rpy_deg", "motor")
_LINK = ("name", "parent", "joint", "type", "axis", "limits", "mimic", *_FRAME)
LIMIT_NAMES = ("lower", "upper", "velocity", "acceleration", "effort")


def load_document(path: Path) -> Robot:
    """A robot from its YAML file."""
    return build(read_yaml(path), str(path))


def build(document: Any, place: str) -> Robot:
    """A robot from the content of such a file; `place` starts every error message."""
    table = _mapping(document, _TOP, place)
    if table.get("horosphere/robot") != 1:
        raise InputError("expected 'horosphere/robot: 1'", place=place, remedy="is this a robot file?")
    entries = table.get("links")
    if not isinstance(entries, list) or not entries:
        raise InputError("expected a list of links", place=f"{place}: links")
    names: list[str] = []
    joints: list[str] = []
    rows: list[list[float]] = []
    links: list[Link] = []
    for k, raw in enumerate(entries):
        entry = _mapping(raw, _LINK, f"{place}: links[{k}]")
        name = str(entry.get("name", ""))
        where = f"{place}: link {name!r}"
        if not name or name in names:
            raise InputError("every link needs a name of its own", place=where)
        if k and entry.get("parent") not in names:
            raise unknown_name("parent", str(entry.get("parent")), names, place=where)
        parent = names.index(entry["parent"]) if k else -1
        names.append(name)
        kind = entry.get("type", "fixed")
        if kind == "fixed":
            links.append(Link(name, parent, _frame(entry, where)))
            continue
        if kind not in ("revolute", "continuous", "prismatic"):
            raise unknown_name("joint type", str(kind), ("fixed", "revolute", "continuous", "prismatic"), place=where)
        axis = float_array(entry.get("axis", [0, 0, 1]), f"{where}: axis", last=3, ndim=1)
        if not axis.any():
            raise InputError("the axis is the zero vector", place=where)
        multiplier, offset = 1.0, 0.0
        if "mimic" in entry:
            mimic = _mapping(entry["mimic"], ("joint", "multiplier", "offset"), f"{where}: mimic")
            if mimic.get("joint") not in joints:
                raise unknown_name("joint", str(mimic.get("joint")), joints, place=f"{where}: mimic")
            coordinate = joints.index(mimic["joint"])
            multiplier = _number(mimic.get("multiplier", 1.0), f"{where}: multiplier")
            offset = _number(mimic.get("offset", 0.0), f"{where}: offset")
        else:
            coordinate = len(joints)
            joints.append(str(entry.get("joint", name)))
            rows.append(_limits(entry.get("limits", {}), kind, where))
        joint = "prismatic" if kind == "prismatic" else "revolute"
        axis = axis / np.linalg.norm(axis)
        links.append(Link(name, parent, _frame(entry, where), joint, axis, coordinate, multiplier, offset))
    tip_name = table.get("tip", names[-1])
    if tip_name not in names:
        raise unknown_name("link for the tip", str(tip_name), names, place=place)
    tip = names.index(tip_name)
    tool = _frame(_mapping(table.get("tool", {}), _FRAME, f"{place}: tool"), f"{place}: tool")
    limits = Limits(*np.array(rows, float).reshape(-1, 5).T)
    capsules = pack(
        read_capsules(_mapping(table.get("capsules", {}), names, f"{place}: capsules"), links, tip, tool), names
    )
    _check_held(table, len(links), len(capsules), place)
    pairs, pair_table, dropped = _self_pairs(table, names, place) or _pairs.choose_pairs(links, limits, capsules)
    return Robot(
        name=str(table.get("name", "robot")),
        links=tuple(links),
        tip=tip,
        joint_names=tuple(joints),
        limits=limits,
        tool=tool,
        closed_form=_closed_form(table.get("closed_form"), place),
        capsules=capsules,
        self_pairs=pairs,
        source=str(table.get("source", place)),
        notes=(*map(str, table.get("notes", ())), *dropped),
        pair_table=pair_table,
        allowed_obstacles=tuple(
            _two(item, f"{place}: allowed_obstacles") for item in table.get("allowed_obstacles", ())
        ),
    )


def _check_held(table: Mapping[str, Any], links: int, capsules: int, place: str) -> None:
    """What the file says that it holds; half a file is YAML, too, of a robot with fewer bodies and fewer pairs that are checked."""
    if "holds" not in table:
        return
    pairs = table.get("pairs", table.get("self_pairs"))
    found = {"links": links, "capsules": capsules, "pairs": len(pairs) if isinstance(pairs, list) else 0}
    for what, said in _mapping(table["holds"], tuple(found), f"{place}: holds").items():
        if said != found[what]:
            raise InputError(
                f"it says that it holds {said} {what}, it holds {found[what]}",
                place=place,
                remedy="it was cut off: write it again; or it was edited: correct `holds`, or take it out",
            )


def _self_pairs(
    table: Mapping[str, Any], names: list[str], place: str
) -> tuple[np.ndarray, tuple[LinkPair, ...], list[str]] | None:
    """The pairs that a file gives, if it does: `pairs` with the reasons, or `self_pairs`, those that are checked."""
    rows: list[LinkPair] = []
    for key in ("pairs", "self_pairs"):
        if not isinstance(table.get(key, []), list):
            raise InputError("expected a list", place=f"{place}: {key}", remedy="without the field they are chosen")
    if "pairs" in table:
        for k, raw in enumerate(table["pairs"]):
            where = f"{place}: pairs[{k}]"
            entry = _mapping(raw, ("links", "checked", "why", "touching"), where)
            first, second = _two(entry.get("links"), f"{where}: links")
            if not isinstance(entry.get("checked"), bool):
                raise InputError("expected 'checked: true' or 'checked: false'", place=where)
            share = entry.get("touching")
            share = None if share is None else _number(share, f"{where}: touching")
            rows.append(LinkPair(first, second, entry["checked"], str(entry.get("why", "")), share))
        chosen = [(row.first, row.second) for row in rows if row.checked]
    elif "self_pairs" in table:
        chosen = [_two(item, f"{place}: self_pairs") for item in table["self_pairs"]]
    else:
        return None
    for name in (name for pair in chosen for name in pair):
        if name not in names:
            raise unknown_name("link", name, names, place=f"{place}: pairs")
    return np.array([[names.index(n) for n in pair] for pair in chosen], np.int64).reshape(-1, 2), tuple(rows), []


def _two(value: Any, place: str) -> tuple[str, str]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise InputError("expected two names", place=place)
    return str(value[0]), str(value[1])


def pack(bodies: Mapping[str, list[Body]], names: list[str]) -> Capsules:
    """Capsules of all links, in the order of the links."""
    flat = [(k, body) for k, name in enumerate(names) for body in bodies.get(name, ())]
    if not flat:
        return Capsules.none()
    link = np.array([k for k, _ in flat], np.int64)
    a, b = np.array([body.a for _, body in flat]), np.array([body.b for _, body in flat])
    return Capsules(link, a, b, np.array([body.radius for _, body in flat]), tuple(body.note for _, body in flat))


def _mapping(value: Any, allowed: Any, place: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise InputError(f"expected a mapping, got {type(value).__name__}", place=place, choices=tuple(allowed))
    for key in value:
        if key not in allowed:
            raise unknown_name("field", str(key), allowed, place=place)
    return value


def _number(value: Any, place: str) -> float:
    """A number; '90 deg' is in radians afterwards, and strings that YAML did not take for numbers (1e-6) are read."""
    scale = 1.0
    if isinstance(value, str) and value.endswith("deg"):
        value, scale = value.removesuffix("deg").strip(), np.pi / 180
    try:
        number = float(value) * scale
    except (TypeError, ValueError):
        raise InputError(f"expected a number, got {value!r}", place=place) from None
    if np.isnan(number):
        raise InputError("expected a number, got NaN", place=place)
    return number


def _frame(entry: Mapping[str, Any], place: str) -> _placement.Floats:
    if "motor" in entry:
        return float_array(entry["motor"], f"{place}: motor", last=8, ndim=1)
    xyz = float_array(entry.get("xyz", [0, 0, 0]), f"{place}: xyz", last=3, ndim=1)
    if "rpy_deg" in entry:
        return _placement.from_rpy(xyz, np.radians(float_array(entry["rpy_deg"], f"{place}: rpy_deg", last=3, ndim=1)))
    return _placement.from_rpy(xyz, float_array(entry.get("rpy", [0, 0, 0]), f"{place}: rpy", last=3, ndim=1))


def _limits(given: Any, kind: str, place: str) -> list[float]:
    table = _mapping(given, LIMIT_NAMES, f"{place}: limits")
    default = [-np.inf, np.inf, np.inf, np.inf, np.inf]
    values = [
        _number(table[key], f"{place}: {key}") if key in table else default[k] for k, key in enumerate(LIMIT_NAMES)
    ]
    if kind == "continuous":
        values[:2] = default[:2]
    if values[0] > values[1]:
        raise InputError(f"lower limit {values[0]:g} > upper limit {values[1]:g}", place=place)
    if min(values[2:]) <= 0:
        raise InputError("velocity, acceleration and effort limits must be positive", place=place)
    return values


def _closed_form(given: Any, place: str) -> tuple[str, dict[str, float]] | None:
    if given is None:
        return None
    ((name, parameters),) = _mapping(
        given, ("humanoid_arm", "srs_arm", "six_axis_arm"), f"{place}: closed_form"
    ).items()
    return name, {str(key): _number(value, f"{place}: closed_form.{key}") for key, value in parameters.items()}
