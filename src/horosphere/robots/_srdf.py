"""SRDF files (MoveIt): groups, end effectors, pairs of links that are not checked against each other."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import InputError, unknown_name
from ._urdf import Joint, Urdf, parse_xml


@dataclass(frozen=True, slots=True)
class EndEffector:
    """An end effector: its group of links hangs on `parent_link`."""

    name: str
    group: str
    parent_link: str


@dataclass(slots=True)
class Srdf:
    """What an SRDF file says: groups as (base, tip) where they are chains; pairs and why; `passive` joints; named `states`."""

    path: Path
    robot: str
    groups: dict[str, tuple[str, str] | None] = field(default_factory=dict)
    end_effectors: list[EndEffector] = field(default_factory=list)
    disabled: dict[frozenset[str], str] = field(default_factory=dict)
    enabled: set[frozenset[str]] = field(default_factory=set)
    disabled_links: set[str] = field(default_factory=set)
    states: dict[str, dict[str, float]] = field(default_factory=dict)

    @property
    def chains(self) -> tuple[str, ...]:
        """Names of the groups that are chains."""
        return tuple(name for name, ends in self.groups.items() if ends is not None)

    def why_disabled(self, first: str, second: str) -> str | None:
        """The file's reason for not checking a pair of links; None if it wants it checked."""
        pair = frozenset((first, second))
        if pair in self.disabled:
            return self.disabled[pair] or "no reason given"
        if pair not in self.enabled and self.disabled_links & pair:
            return "Default"
        return None

    def chain(self, group: str | None) -> tuple[str, str, str] | None:
        """(base, tip, group) of a group; of the only one that is a chain, if none is asked for and there is just one."""
        if group is None:
            if len(self.chains) != 1:
                return None
            group = self.chains[0]
        if group not in self.groups:
            raise unknown_name("group", group, self.groups, place=str(self.path))
        ends = self.groups[group]
        if ends is None:
            raise InputError(
                f"group {group!r} is not one chain of links",
                place=str(self.path),
                choices=self.chains,
                remedy="give `base` and `tip`",
            )
        return (*ends, group)


def read_srdf(path: Path, urdf: Urdf) -> Srdf:
    """Read an SRDF file and check it against the URDF. Raises InputError if it names links or joints that the URDF has not."""
    root = parse_xml(path, "an SRDF")
    srdf = Srdf(path, root.get("name") or "")
    _compare(root, srdf, urdf)
    raw = {item.get("name"): item for item in root.iterfind("group") if len(item)}
    for name in raw:
        srdf.groups[name] = _ends(raw, name, urdf)
    for item in root.iterfind("end_effector"):
        srdf.end_effectors.append(
            EndEffector(item.get("name") or "", item.get("group") or "", item.get("parent_link") or "")
        )
    for item in root.iterfind("disable_collisions"):
        srdf.disabled[_pair(item, path)] = item.get("reason") or ""
    for item in root.iterfind("enable_collisions"):
        srdf.enabled.add(_pair(item, path))
    srdf.disabled_links = {item.get("link") for item in root.iterfind("disable_default_collisions")}
    for item in root.iterfind("group_state"):
        srdf.states[item.get("name") or ""] = {
            joint.get("name"): _number(joint, path) for joint in item.iterfind("joint") if joint.get("value")
        }
    return srdf


def _compare(root: Any, srdf: Srdf, urdf: Urdf) -> None:
    """Every link and joint that the SRDF names must be the robot's."""
    links, joints = set(urdf.links), {joint.name for joint in urdf.joints.values()}
    virtual = {item.get("name") for item in root.iterfind("virtual_joint")}
    missing: dict[str, int] = {}
    named = 0
    for element in root.iter():
        names = [(element.get(key), links, "link") for key in _LINKS.get(element.tag, ())]
        if element.tag in ("joint", "passive_joint"):
            names.append((element.get("name"), joints | virtual, "joint"))
        for name, known, what in names:
            if name is None:
                raise InputError(
                    f"<{element.tag}> without the name of a {what}", place=f"{srdf.path}:{element.sourceline}"
                )
            named += 1
            if name not in known:
                missing.setdefault(f"{what} {name!r}", element.sourceline)
    if not missing:
        return
    some = ", ".join(f"{name} (line {line})" for name, line in list(missing.items())[:6])
    some += f" and {len(missing) - 6} more" if len(missing) > 6 else ""
    name = f" it is for a robot {srdf.robot!r}, the URDF is {urdf.name!r};" if srdf.robot != urdf.name else ""
    raise InputError(
        f"this SRDF is not for this URDF:{name} not in {urdf.path}: {some}",
        place=f"{srdf.path}:{min(missing.values())}",
        remedy="give the SRDF of this robot, made for this version of its URDF",
    )


_LINKS = {
    "chain": ("base_link", "tip_link"),
    "link": ("name",),
    "link_sphere_approximation": ("link",),
    "disable_collisions": ("link1", "link2"),
    "enable_collisions": ("link1", "link2"),
    "disable_default_collisions": ("link",),
    "end_effector": ("parent_link",),
    "virtual_joint": ("child_link",),
}


def _pair(item: Any, path: Path) -> frozenset[str]:
    pair = frozenset((item.get("link1"), item.get("link2")))
    if len(pair) != 2:
        raise InputError(f"a pair of the link {item.get('link1')!r} with itself", place=f"{path}:{item.sourceline}")
    return pair


def _number(joint: Any, path: Path) -> float:
    try:
        return float(joint.get("value").split()[0])
    except ValueError:
        raise InputError(
            f"joint {joint.get('name')!r}: expected a number, got {joint.get('value')!r}",
            place=f"{path}:{joint.sourceline}",
        ) from None


def _ends(raw: dict[str, Any], name: str, urdf: Urdf) -> tuple[str, str] | None:
    """Base and tip of the one chain that a group's chains, joints, links and inner groups make; None if they make none."""
    joints = _joints(raw, name, urdf, ())
    if not any(joint.type != "fixed" for joint in joints.values()):
        return None
    bases = {joint.parent for joint in joints.values()} - set(joints)
    tips = set(joints) - {joint.parent for joint in joints.values()}
    if len(bases) != 1 or len(tips) != 1:
        return None
    base, tip = bases.pop(), tips.pop()
    return (base, tip) if _between(urdf, base, tip) is not None else None


def _joints(raw: dict[str, Any], name: str, urdf: Urdf, seen: tuple[str, ...]) -> dict[str, Joint]:
    """The joints of a group by the link that each carries."""
    by_name = {joint.name: joint for joint in urdf.joints.values()}
    found: dict[str, Joint] = {}
    for item in raw[name]:
        key = item.get("name")
        if item.tag == "chain":
            found |= _between(urdf, item.get("base_link"), item.get("tip_link")) or {}
        elif item.tag == "joint" and key in by_name:
            found[by_name[key].child] = by_name[key]
        elif item.tag == "link" and key in urdf.joints:
            found[key] = urdf.joints[key]
        elif item.tag == "group" and key in raw and key not in (*seen, name):
            found |= _joints(raw, key, urdf, (*seen, name))
    return found


def _between(urdf: Urdf, base: str, tip: str) -> dict[str, Joint] | None:
    """The joints from base to tip; None if the tip does not hang on the base."""
    found: dict[str, Joint] = {}
    while tip != base:
        if tip not in urdf.joints:
            return None
        found[tip] = urdf.joints[tip]
        tip = urdf.joints[tip].parent
    return found
