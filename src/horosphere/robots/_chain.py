"""From a URDF tree to a Robot: which links stay, which joints move, limits and notes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..errors import InputError, unknown_name
from . import _placement
from ._robot import Kind, Limits, Link
from ._urdf import MOVABLE, REFUSED, Joint, Urdf

_TOOLS = {"tool", "tool0", "gripper", "hand", "ee", "effector", "flange", "tcp", "wrist"}
_PARTS = {
    "finger",
    "fingertip",
    "tip",
    "thumb",
    "index",
    "middle",
    "ring",
    "little",
    "virtual",
    "camera",
    "optical",
    "led",
    "motor",
}
_PARTS |= {"accelerometer", "sensor", "imu", "mount", "safety", "range"}


@dataclass(slots=True)
class Chain:
    """Links and coordinates of the part of a URDF that is kept."""

    links: list[Link] = field(default_factory=list)
    tip: int = 0
    joint_names: list[str] = field(default_factory=list)
    rows: list[list[float]] = field(default_factory=list)
    """lower, upper, velocity, effort of each coordinate."""
    notes: list[str] = field(default_factory=list)

    def limits(self) -> Limits:
        """The rows as `Limits`; URDF has no acceleration limits."""
        lower, upper, velocity, effort = np.array(self.rows, float).reshape(-1, 4).T
        return Limits(lower, upper, velocity, np.full(len(lower), np.inf), effort)


def build_chain(urdf: Urdf, base: str | None, tip: str | None, locked: Mapping[str, float]) -> Chain:
    """Keep what hangs on `base`: joints from base to tip move, others are locked (`locked`, else zero or nearest limit)."""
    base, tip = choose_ends(urdf, base, tip)
    on_path = path_links(urdf, base, tip)
    movers = {urdf.joints[link].name: urdf.joints[link] for link in on_path[1:] if urdf.joints[link].type in MOVABLE}
    by_name = {joint.name: joint for joint in urdf.joints.values()}
    for name in locked:
        if name not in by_name:
            raise unknown_name("joint", name, by_name, place="locked")
        movers.pop(name, None)
    astray = [joint for joint in urdf.joints.values() if joint.mimic and joint.mimic[0] not in by_name]
    for joint in astray:
        what = f"mimics the unknown joint {joint.mimic[0]!r}" if joint.mimic else ""
        if joint.name in movers:
            raise InputError(what, place=urdf.place(joint), remedy="name one of the file, or drop its <mimic>")
    masters = {name: joint for name, joint in movers.items() if joint.mimic is None}
    chain = Chain(joint_names=list(masters))
    for joint in masters.values():
        chain.rows.append(_row(joint, chain.notes))
    values = {name: float(value) for name, value in locked.items()}
    below = _below(urdf, base)
    frozen: list[str] = []
    index: dict[str, int] = {}
    for link in below:
        index[link] = len(chain.links)
        if link == base:
            chain.links.append(Link(link, -1, _placement.IDENTITY))
            continue
        joint = urdf.joints[link]
        origin = joint.origin
        parent = index[joint.parent]
        kind: Kind = "fixed" if joint.type == "fixed" else "prismatic" if joint.type == "prismatic" else "revolute"
        axis = np.array([0.0, 0.0, 1.0]) if kind == "fixed" else joint.axis
        if kind == "fixed" or joint.type in REFUSED:
            if joint.type in REFUSED:
                if link in on_path:
                    raise InputError(
                        f"{joint.type} joints cannot be on the chain", place=urdf.place(joint), choices=MOVABLE
                    )
                frozen.append(f"{joint.name} (a {joint.type} joint)")
            chain.links.append(Link(link, parent, origin))
            continue
        master, multiplier, offset = _master(joint, by_name, locked)
        if master.name in masters:
            coordinate = chain.joint_names.index(master.name)
            if joint is not master:
                _tighten(urdf, chain, joint, coordinate, multiplier, offset)
            chain.links.append(Link(link, parent, origin, kind, axis, coordinate, multiplier, offset))
            continue
        value = multiplier * values.setdefault(master.name, float(np.clip(0.0, master.lower, master.upper))) + offset
        frozen.append(f"{joint.name} = {value:.6g}")
        motion = (
            _placement.from_axis_angle(axis, value) if kind == "revolute" else _placement.from_translation(value * axis)
        )
        chain.links.append(Link(link, parent, _placement.compose(origin, motion)))
    chain.tip = index[tip]
    lost = [f"{joint.name} ({joint.mimic[0]})" for joint in astray if joint.mimic and joint.child in index]
    if lost:
        chain.notes.append(f"locked, since they mimic joints that the file does not have: {', '.join(lost)}")
    if frozen:
        some = ", ".join(frozen[:8]) + (f" and {len(frozen) - 8} more" if len(frozen) > 8 else "")
        chain.notes.append(f"joints beside the chain {base} -> {tip} are locked: {some}")
    gone = [link for link in urdf.links if link not in index]
    if gone:
        some = ", ".join(gone[:6]) + (f" and {len(gone) - 6} more" if len(gone) > 6 else "")
        chain.notes.append(f"links that do not hang on the base {base!r} are left out: {some}")
    if not chain.joint_names:
        raise InputError(
            f"no joint moves between {base!r} and {tip!r}", place=str(urdf.path), remedy="give another base or tip"
        )
    return chain


def choose_ends(urdf: Urdf, base: str | None, tip: str | None) -> tuple[str, str]:
    """The base (the root if not given) and the tip (the only leaf below the base if not given)."""
    if not urdf.links:
        raise InputError("the URDF has no links", place=str(urdf.path))
    roots = [link for link in urdf.links if link not in urdf.joints]
    for what, name in (("base", base), ("tip", tip)):
        if name is not None and name not in urdf.links:
            raise unknown_name(f"link for the {what}", name, urdf.links, place=str(urdf.path))
    if base is None:
        if len(roots) > 1:
            raise InputError(
                f"{len(roots)} links have no parent",
                place=str(urdf.path),
                remedy="name the base: one of them",
                choices=roots,
            )
        base = roots[0]
    if tip is None:
        children = urdf.children()
        leaves = [link for link in _below(urdf, base) if not children[link]]
        if len(leaves) > 1:
            raise InputError(
                f"the tip is not given, and the tree has {len(leaves)} ends: {_ends(urdf, base, leaves)}",
                place=str(urdf.path),
                remedy="name one of them (`tip`); any other link will do too",
            )
        tip = leaves[0]
    return base, tip


def _ends(urdf: Urdf, base: str, leaves: list[str]) -> str:
    """The leaves with the number of joints that move them: first likely tools, moved by about as many joints as an arm has, then the
    most mobile; and links before them that are likely tools."""
    below = _below(urdf, base)
    moved = {link: sum(urdf.joints[k].type in MOVABLE for k in path_links(urdf, base, link)[1:]) for link in below}
    likely = {link for link in below if moved[link] >= 5 and _is_tool(link)}

    def listed(links: list[str], most: int) -> str:
        links = sorted(links, key=lambda link: (0, abs(moved[link] - 7)) if link in likely else (1, -moved[link]))
        rest = f" and {len(links) - most} more" if len(links) > most else ""
        return ", ".join(f"{x} ({moved[x]} joint{'s' * (moved[x] != 1)})" for x in links[:most]) + rest

    before = [link for link in below if link in likely and link not in leaves]
    return listed(leaves, 8) + (f"; likely tools before them: {listed(before, 6)}" if before else "")


def _is_tool(link: str) -> bool:
    """Whether the name of a link says tool, hand or wrist, and not finger or camera."""
    words = set(re.findall(r"[a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", link).lower()))
    return bool(words & _TOOLS) and not words & _PARTS


def path_links(urdf: Urdf, base: str, tip: str) -> list[str]:
    """Links from base to tip; raises if the tip does not hang on the base."""
    path = [tip]
    while path[-1] != base:
        if path[-1] not in urdf.joints:
            if tip in _above(urdf, base):
                raise InputError(
                    f"the tip {tip!r} lies above the base {base!r}: {' > '.join([*_above(urdf, base)[::-1], base])}",
                    place=str(urdf.path),
                    remedy="a chain runs from the base down to the tip: exchange them, or take another base",
                )
            raise InputError(
                f"the tip {tip!r} does not hang on the base {base!r}",
                place=str(urdf.path),
                choices=_below(urdf, base)[1:],
            )
        path.append(urdf.joints[path[-1]].parent)
    return path[::-1]


def _above(urdf: Urdf, link: str) -> list[str]:
    """The links that a link hangs on, the nearest first."""
    path = []
    while link in urdf.joints:
        link = urdf.joints[link].parent
        path.append(link)
    return path


def _below(urdf: Urdf, base: str) -> list[str]:
    """The base and all links that hang on it, parents first, in the order of the file."""
    children, found = urdf.children(), [base]
    for link in found:
        found.extend(children[link])
    return found


def _master(joint: Joint, by_name: Mapping[str, Joint], locked: Mapping[str, float]) -> tuple[Joint, float, float]:
    """The joint that moves this one: value = multiplier * master + offset. A locked mimic is its own master, one of nothing too."""
    multiplier, offset = 1.0, 0.0
    while joint.mimic is not None and joint.name not in locked and joint.mimic[0] in by_name:
        name, factor, shift = joint.mimic
        offset += multiplier * shift
        multiplier *= factor
        joint = by_name[name]
    return joint, multiplier, offset


def _row(joint: Joint, notes: list[str]) -> list[float]:
    if (joint.lower, joint.upper) != joint.hard:
        low, high = joint.hard
        notes.append(
            f"{joint.name}: soft limits [{joint.lower:.6g}, {joint.upper:.6g}] used instead of [{low:.6g}, {high:.6g}]"
        )
    return [joint.lower, joint.upper, joint.velocity, joint.effort]


def _tighten(urdf: Urdf, chain: Chain, joint: Joint, coordinate: int, multiplier: float, offset: float) -> None:
    """A mimic joint must stay within its own limits too."""
    if multiplier == 0.0:
        return
    lower, upper = sorted((np.array([joint.lower, joint.upper]) - offset) / multiplier)
    row, before = chain.rows[coordinate], list(chain.rows[coordinate])
    row[0], row[1] = max(row[0], lower), min(row[1], upper)
    if row[0] > row[1]:
        raise InputError("its limits leave its master no position", place=urdf.place(joint))
    row[2] = min(row[2], joint.velocity / abs(multiplier))
    if row != before:
        chain.notes.append(
            f"{chain.joint_names[coordinate]}: limits tightened to [{row[0]:.6g}, {row[1]:.6g}] "
            f"by {joint.name}, which mimics it"
        )
