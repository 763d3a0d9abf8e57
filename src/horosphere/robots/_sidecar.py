"""Collision capsules from a small YAML file or a radius, for robots whose meshes are missing or too coarse.

horosphere/capsules: 1
links:
  l_wrist: {radius: 0.03}                                # along the segments from this joint to the next ones
  torso: [{a: [0, 0, -0.05], b: [0, 0, 0.1], radius: 0.06, note: chest}]
  Head: []                                               # nothing to collide with
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, unknown_name
from ..numeric import float_array
from . import _placement
from ._bodies import Body
from ._robot import Link


def read_yaml(path: Path) -> Any:
    """The content of a YAML file; InputError with file:line:column if it is not YAML."""
    import yaml

    try:
        return yaml.load(path.read_text(encoding="utf-8"), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", place=str(path)) from None
    except UnicodeDecodeError:
        raise InputError("not a text file", place=str(path)) from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = f"{path}:{mark.line + 1}:{mark.column + 1}" if mark else str(path)
        raise InputError(f"not valid YAML: {getattr(error, 'problem', error)}", place=place) from None


def read_capsules(
    given: str | Path | Mapping[str, Any], links: Sequence[Link], tip: int, tool: _placement.Floats
) -> dict[str, list[Body]]:
    """Capsules by link name from a file or a mapping (either the whole document or just its `links`)."""
    place = "capsules"
    document: Any = given
    if isinstance(given, (str, Path)):
        place, document = str(given), read_yaml(Path(given))
    if not isinstance(document, Mapping):
        raise InputError(f"expected a mapping of link names, got {type(document).__name__}", place=place)
    table = document.get("links", {}) if "horosphere/capsules" in document else document
    if document.get("horosphere/capsules", 1) != 1 or not isinstance(table, Mapping):
        raise InputError("expected 'horosphere/capsules: 1' and a mapping 'links'", place=place)
    names = [link.name for link in links]
    result: dict[str, list[Body]] = {}
    for name, entry in table.items():
        if name not in names:
            raise unknown_name("link", str(name), names, place=place)
        where = f"{place}: link {name!r}"
        if isinstance(entry, (int, float)) and not isinstance(entry, bool):
            entry = {"radius": entry}
        if isinstance(entry, Mapping) and not ({"a", "b"} & set(entry)):
            _only(entry, ("radius",), where)
            result[name] = joint_segments(links, names.index(name), tip, tool, _radius(entry, where))
            continue
        items = [entry] if isinstance(entry, Mapping) else entry
        if not isinstance(items, Sequence) or isinstance(items, str):
            raise InputError("expected a radius, a capsule {a, b, radius} or a list of them", place=where)
        result[name] = [_capsule(item, where) for item in items]
    return result


def joint_segments(links: Sequence[Link], index: int, tip: int, tool: _placement.Floats, radius: float) -> list[Body]:
    """Capsules from a link's joint to the joints that it carries (and to the tool, on the tip link)."""
    ends = [
        _placement.rotation_translation(link.origin)[1]
        for link in links
        if link.parent == index and _carries(links, link, tip)
    ]
    if index == tip:
        ends.append(_placement.rotation_translation(tool)[1])
    unique: list[np.ndarray] = []
    for end in ends:
        if np.linalg.norm(end) > 1e-6 and not any(np.linalg.norm(end - u) < 1e-6 for u in unique):
            unique.append(end)
    note = f"joint-to-joint segment, radius {radius:g} m"
    if not unique and index == tip:
        return [Body(np.zeros(3), np.zeros(3), radius, f"ball at the tip's origin, radius {radius:g} m")]
    return [Body(np.zeros(3), end, radius, note) for end in unique]


def _carries(links: Sequence[Link], link: Link, tip: int) -> bool:
    """Is the link on the way to the tip?"""
    i = tip
    while i > 0 and links[i] is not link:
        i = links[i].parent
    return links[i] is link


def _only(entry: Mapping[str, Any], allowed: tuple[str, ...], place: str) -> None:
    for key in entry:
        if key not in allowed:
            raise unknown_name("field", str(key), allowed, place=place)


def _radius(entry: Mapping[str, Any], place: str) -> float:
    if "radius" not in entry:
        raise InputError("radius is missing", place=place)
    radius = float(float_array(entry["radius"], f"{place}: radius", ndim=0))
    if radius <= 0:
        raise InputError(f"radius {radius:g} is not positive", place=place)
    return radius


def _capsule(item: Any, place: str) -> Body:
    if not isinstance(item, Mapping):
        raise InputError("expected a capsule {a, b, radius}", place=place)
    _only(item, ("a", "b", "radius", "note"), place)
    if "a" not in item:
        raise InputError("end a is missing", place=place)
    a = float_array(item["a"], f"{place}: a", last=3, ndim=1)
    b = float_array(item.get("b", item["a"]), f"{place}: b", last=3, ndim=1)
    return Body(a, b, _radius(item, place), str(item.get("note", "from the capsule file")))
