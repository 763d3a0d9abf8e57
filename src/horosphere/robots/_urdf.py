"""URDF files, checked while they are read: every complaint names the file, the line and the element.

A reader of our own: parsers at hand import a mesh library (1.2 s of CPU) and repair or accept silently what should be
refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, unknown_name
from . import _placement

MOVABLE = ("revolute", "continuous", "prismatic")
REFUSED = ("floating", "planar")
SHAPES = ("sphere", "cylinder", "capsule", "box", "mesh")
REMEDY_XML = "repair the file; xacro files must be expanded first (xacro robot.xacro > robot.urdf)"


@dataclass(frozen=True, slots=True)
class Shape:
    """A shape in its link's frame: sphere (radius), cylinder and capsule (radius, length along z), box (sides), mesh (scale)."""

    kind: str
    sizes: tuple[float, ...]
    origin: _placement.Floats
    filename: str = ""


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint; `mimic` is (joint, multiplier, offset); `lower`, `upper` respect soft limits, `hard` does not."""

    name: str
    type: str
    parent: str
    child: str
    line: int
    origin: _placement.Floats
    axis: _placement.Floats
    lower: float
    upper: float
    hard: tuple[float, float]
    velocity: float
    effort: float
    mimic: tuple[str, float, float] | None


@dataclass(slots=True)
class Urdf:
    """What a URDF file says: links, the joint that carries each, collision and visual shapes."""

    path: Path
    name: str
    links: list[str] = field(default_factory=list)
    joints: dict[str, Joint] = field(default_factory=dict)
    """By the name of the child link."""
    collisions: dict[str, list[Shape]] = field(default_factory=dict)
    visuals: dict[str, list[Shape]] = field(default_factory=dict)

    def place(self, joint: Joint) -> str:
        """file:line: joint 'name', for error messages."""
        return f"{self.path}:{joint.line}: joint {joint.name!r}"

    def children(self) -> dict[str, list[str]]:
        """Child links by parent link, in the order of the file."""
        result: dict[str, list[str]] = {name: [] for name in self.links}
        for child, joint in self.joints.items():
            result[joint.parent].append(child)
        return result


def read_urdf(path: Path) -> Urdf:
    """Read and check a URDF file; meshes are only named, not opened."""
    root = parse_xml(path)
    _check(root, path)
    urdf = Urdf(path, root.get("name") or path.stem)
    for element in root.iterfind("link"):
        name = element.get("name")
        urdf.links.append(name)
        for what, shapes in (("collision", urdf.collisions), ("visual", urdf.visuals)):
            shapes[name] = [_shape(item) for item in element.iterfind(what) if item.find("geometry") is not None]
    names, seen = set(urdf.links), {}
    for element in root.iterfind("joint"):
        joint = _joint(element)
        for end, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in names:
                raise InputError(f"{end} link {link!r} is not defined", place=urdf.place(joint))
        if joint.child in seen:
            raise InputError(
                f"link {joint.child!r} has two parents (joints {seen[joint.child]!r} and {joint.name!r})",
                place=urdf.place(joint),
                remedy="closed loops are not supported: cut the loop at one joint",
            )
        seen[joint.child] = joint.name
        urdf.joints[joint.child] = joint
    _check_tree(urdf)
    return urdf


def _floats(element: Any, attribute: str, default: tuple[float, ...]) -> tuple[float, ...]:
    text = None if element is None else element.get(attribute)
    return default if text is None else tuple(float(word) for word in text.replace(",", " ").split())


def _origin(element: Any) -> _placement.Floats:
    origin = element.find("origin")
    return _placement.from_rpy(_floats(origin, "xyz", (0.0, 0.0, 0.0)), _floats(origin, "rpy", (0.0, 0.0, 0.0)))


def _shape(element: Any) -> Shape:
    shape = element.find("geometry")[0]
    if shape.tag == "mesh":
        scale = _floats(shape, "scale", (1.0,))
        return Shape("mesh", scale * 3 if len(scale) == 1 else scale, _origin(element), shape.get("filename"))
    sizes = [value for attribute in _REQUIRED[shape.tag] for value in _floats(shape, attribute, ())]
    return Shape(shape.tag, tuple(sizes), _origin(element))


def _joint(element: Any) -> Joint:
    kind, limit, safety, mimic = (
        element.get("type"),
        element.find("limit"),
        element.find("safety_controller"),
        element.find("mimic"),
    )
    axis = np.array(_floats(element.find("axis"), "xyz", (1.0, 0.0, 0.0)))
    hard = (_floats(limit, "lower", (0.0,))[0], _floats(limit, "upper", (0.0,))[0])
    if kind == "continuous" or limit is None:
        hard = (-np.inf, np.inf)
    lower, upper = hard
    # URDF: both soft limits default to 0, so a controller without them has 0 = 0 and none are meant
    soft = (_floats(safety, "soft_lower_limit", (0.0,))[0], _floats(safety, "soft_upper_limit", (0.0,))[0])
    if kind != "continuous" and soft[0] < soft[1]:
        lower, upper = max(lower, soft[0]), min(upper, soft[1])
    return Joint(
        name=element.get("name"),
        type=kind,
        parent=element.find("parent").get("link"),
        child=element.find("child").get("link"),
        line=element.sourceline,
        origin=_origin(element),
        axis=axis / np.linalg.norm(axis) if axis.any() else axis,
        lower=lower,
        upper=upper,
        hard=hard,
        # zero means "not given" in most files: a joint that may not move would be fixed
        velocity=_floats(limit, "velocity", (0.0,))[0] or np.inf,
        effort=_floats(limit, "effort", (0.0,))[0] or np.inf,
        mimic=None
        if mimic is None
        else (mimic.get("joint"), _floats(mimic, "multiplier", (1.0,))[0], _floats(mimic, "offset", (0.0,))[0]),
    )


def parse_xml(path: Path, what: str = "a URDF") -> Any:
    """The root of an XML file, which must be <robot>."""
    if not path.is_file():
        raise no_file(path)
    from lxml import etree

    parser = etree.XMLParser(remove_comments=True)
    try:
        try:
            root = etree.parse(str(path), parser).getroot()
        except etree.XMLSyntaxError:
            # a prefix that is not declared (drake:acceleration): sound XML, and every other reader takes it
            if any(entry.domain != etree.ErrorDomains.NAMESPACE for entry in parser.error_log):
                raise
            root = etree.parse(str(path), etree.XMLParser(remove_comments=True, recover=True)).getroot()
    except etree.XMLSyntaxError as error:
        line, column = error.position
        raise InputError(
            f"not well-formed XML: {str(error.msg).split(', line')[0]}",
            place=f"{path}:{line}:{column}",
            remedy=REMEDY_XML,
        ) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error}", place=str(path)) from None
    if root.tag != "robot":
        raise InputError(
            f"the root element is <{root.tag}>, not <robot> as in {what}",
            place=f"{path}:{root.sourceline}",
            remedy=REMEDY_XML,
        )
    _refuse_xacro(root, path, ".urdf" if what == "a URDF" else ".srdf")
    return root


def no_file(path: Path, remedy: str | None = None, choices: Iterable[str] | None = None) -> InputError:
    """The error for a path that is no file: a folder (which URDFs are in it), a device, or nothing (`remedy`, `choices`)."""
    if path.is_dir():
        inside = [str(found) for pattern in ("*.urdf", "*/*.urdf") for found in sorted(path.glob(pattern))][:12]
        remedy = "name one of them" if inside else "there is no URDF in it or in a folder of it; name a file"
        return InputError("a folder, not a file", place=str(path), choices=inside or None, remedy=remedy)
    if path.exists():
        return InputError("not a regular file", place=str(path), remedy="name a file on the disk")
    return InputError("no such file", place=str(path), remedy=remedy, choices=choices)


def _refuse_xacro(root: Any, path: Path, ending: str) -> None:
    """What is still to be expanded would be missing from the robot. Expanded files may keep the name space, but no elements of it."""
    elements = [item for item in root.iter() if isinstance(item.tag, str)]
    macros = [item for item in elements if re.match(r"xacro:|\{[^}]*xacro", item.tag)]
    parts = [inner for item in root if item.tag in ("link", "joint") for inner in item.iter()]
    open_ = [item for item in parts if any("${" in text or "$(" in text for text in item.attrib.values())]
    named = any("xacro" in uri for uri in root.nsmap.values())
    if not (macros or open_ or (named and root.find("link") is None and ending == ".urdf")):
        return
    first = min((*macros[:1], *open_[:1]), key=lambda item: item.sourceline, default=root)
    tag = first.tag if first not in macros else f"xacro:{re.split('[}:]', first.tag)[-1]}"
    stem = path.name.removesuffix(".xacro").removesuffix(ending)
    to = stem + ending if stem + ending != path.name else f"{stem}-expanded{ending}"
    asked = [f"{m.get('name')}:=..." for m in macros if m.tag.endswith("}arg") and m.get("default") is None]
    raise InputError(
        f"xacro that is not expanded, first <{tag}>" if macros or open_ else "a xacro file without links",
        place=f"{path}:{first.sourceline}",
        remedy=f"expand it: {' '.join(['xacro', path.name, *asked])} > {to} (xacro comes with ROS, or pip install xacro)",
    )


# element, attributes that are numbers, how many each holds, attributes that must be there
_NUMBERS = {
    "origin": (("xyz", 3), ("rpy", 3)),
    "axis": (("xyz", 3),),
    "limit": (("lower", 1), ("upper", 1), ("velocity", 1), ("effort", 1)),
    "mimic": (("multiplier", 1), ("offset", 1)),
    "safety_controller": (("soft_lower_limit", 1), ("soft_upper_limit", 1)),
    "sphere": (("radius", 1),),
    "cylinder": (("radius", 1), ("length", 1)),
    "capsule": (("radius", 1), ("length", 1)),
    "box": (("size", 3),),
    "mesh": (("scale", 3),),
}
_REQUIRED = {
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "box": ("size",),
    "mesh": ("filename",),
    "mimic": ("joint",),
}
_PARTS = ("inertial", "visual", "collision")  # of a link


def _check(root: Any, path: Path) -> None:
    """Refuse what is missing, not a number or contradictory."""
    lines: dict[str, int] = {}
    for element in root:
        if element.tag not in ("link", "joint"):
            continue
        line, name = element.sourceline, element.get("name")
        if not name:
            raise InputError(f"<{element.tag}> without a name", place=f"{path}:{line}")
        key = f"{element.tag} {name}"
        if key in lines:
            raise InputError(
                f"{element.tag} {name!r} is defined twice, first in line {lines[key]}", place=f"{path}:{line}"
            )
        lines[key] = line
        known = [part for part in element if element.tag == "joint" or part.tag in _PARTS]  # not what others put there
        for inner in (deeper for part in known for deeper in part.iter()):
            _check_numbers(inner, f"{path}:{inner.sourceline}: {element.tag} {name!r}")
        if element.tag == "joint":
            _check_joint(element, f"{path}:{line}: joint {name!r}")


def _check_numbers(element: Any, place: str) -> None:
    for attribute in _REQUIRED.get(element.tag, ()):
        if element.get(attribute) is None:
            raise InputError(f"<{element.tag}> without {attribute}", place=place)
    if element.tag == "geometry" and len(element) != 1:
        raise InputError(f"<geometry> holds {len(element)} shapes, not one", place=place)
    if element.tag == "geometry" and element[0].tag not in SHAPES:
        raise unknown_name("shape", element[0].tag, SHAPES, place=place)
    for attribute, count in _NUMBERS.get(element.tag, ()):
        text = element.get(attribute)
        if text is None:
            continue
        try:
            values = [float(word) for word in text.replace(",", " ").split()]
        except ValueError:
            raise InputError(f"<{element.tag} {attribute}={text!r}>: expected numbers", place=place) from None
        if len(values) != count and not (attribute == "scale" and len(values) == 1):
            raise InputError(
                f"<{element.tag} {attribute}={text!r}>: expected {count} numbers, got {len(values)}", place=place
            )
        if not all(np.isfinite(values)) and not (element.tag == "limit" and not any(np.isnan(values))):
            raise InputError(f"<{element.tag} {attribute}={text!r}>: expected finite numbers", place=place)
        if element.tag in ("sphere", "cylinder", "capsule", "box") and min(values) < 0:
            raise InputError(f"<{element.tag} {attribute}={text!r}>: negative size", place=place)


def _check_joint(element: Any, place: str) -> None:
    kind = element.get("type")
    if kind not in ("fixed", *MOVABLE, *REFUSED):
        raise InputError(f"joint type {kind!r}", place=place, choices=("fixed", *MOVABLE))
    for end in ("parent", "child"):
        if element.find(end) is None or not element.find(end).get("link"):
            raise InputError(f"<{end} link=...> is missing", place=place)
    if kind not in MOVABLE:
        return
    axis = element.find("axis")
    if axis is not None and not any(float(w) for w in axis.get("xyz", "1 0 0").split()):
        raise InputError("the axis is the zero vector", place=place)
    limit = element.find("limit")
    if kind != "continuous":
        if limit is None:
            raise InputError(
                f"a {kind} joint needs <limit>", place=place, remedy="add it, or make the joint continuous"
            )
        lower, upper = float(limit.get("lower", 0.0)), float(limit.get("upper", 0.0))
        if lower > upper:
            raise InputError(
                f"lower limit {lower:g} > upper limit {upper:g}", place=f"{place} (line {limit.sourceline})"
            )


def _loop(urdf: Urdf, link: str) -> list[str]:
    """The links that go round in a circle above a link, the first named again at the end."""
    path = [link]
    while path.count(path[-1]) < 2:
        path.append(urdf.joints[path[-1]].parent)
    return path[path.index(path[-1]) :][::-1]


def _check_tree(urdf: Urdf) -> None:
    """Nothing goes round in a circle, and mimics have a master."""
    joints = {joint.name: joint for joint in urdf.joints.values()}
    for child, joint in urdf.joints.items():
        if joint.lower > joint.upper:
            raise InputError(f"its soft limits lie outside its limits {list(joint.hard)}", place=urdf.place(joint))
        link, steps = joint.parent, 0
        while link in urdf.joints and steps <= len(urdf.links):
            link, steps = urdf.joints[link].parent, steps + 1
        if steps > len(urdf.links):
            raise InputError(
                f"link {child!r} is its own ancestor: {' > '.join(_loop(urdf, child))}",
                place=urdf.place(joint),
                remedy="closed loops are not supported: cut the loop at one joint",
            )
        master, steps = joint, 0
        while master.mimic is not None:
            if master.mimic[0] not in joints:
                break  # `build_chain` locks it, or refuses it on the chain
            master, steps = joints[master.mimic[0]], steps + 1
            if steps > len(joints):
                raise InputError("mimics itself", place=urdf.place(joint))
        if joint.mimic is not None and master.type not in MOVABLE:
            raise InputError(f"mimics {master.name!r}, which is {master.type}", place=urdf.place(joint))
