"""A robot as URDF: for other programs, and to look into."""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

import numpy as np

from . import _placement
from ._robot import Robot

FAR = 1e9
"""URDF knows no missing effort or velocity: written as this much (rad/s, N m, ...)."""


def as_urdf(robot: Robot) -> str:
    """The text of a URDF: links, joints, limits, collision bodies (a capsule is a cylinder between two spheres, exactly).

    A tool frame becomes a link `<tip>_tool`. URDF cannot hold accelerations, pairs of links, allowed contacts, notes.
    """
    lines = ['<?xml version="1.0"?>', f"<robot name={quoteattr(robot.name)}>"]
    lines.append(f"  <!-- written by horosphere from {robot.source.replace('--', '- -')} -->")
    for k, link in enumerate(robot.links):
        bodies = _bodies(robot, k)
        name = quoteattr(link.name)
        lines += [f"  <link name={name}>", *bodies, "  </link>"] if bodies else [f"  <link name={name}/>"]
    tool = f"{robot.links[robot.tip].name}_tool"
    while tool in robot.link_names:
        tool += "_"
    has_tool = not np.array_equal(robot.tool, _placement.IDENTITY)
    if has_tool:
        lines.append(f"  <link name={quoteattr(tool)}/>")
    masters: dict[int, str] = {}
    for link in robot.links[1:]:
        lines += _joint(robot, link, masters)
    if has_tool:
        ends = f"<parent link={quoteattr(robot.links[robot.tip].name)}/><child link={quoteattr(tool)}/>"
        lines.append(f'  <joint name={quoteattr(tool)} type="fixed">{ends}{_origin(robot.tool)}</joint>')
    return "\n".join([*lines, "</robot>", ""])


def _joint(robot: Robot, link, masters: dict[int, str]) -> list[str]:
    parent = robot.links[link.parent].name
    name, kind = f"{link.name}_fixed", link.kind
    inner: list[str] = []
    if link.kind != "fixed":
        limits, c = robot.limits, link.coordinate
        own = c not in masters and (link.multiplier, link.offset) == (1.0, 0.0)
        name = robot.joint_names[c] if own else f"{link.name}_joint"
        low, high = float(limits.lower[c]), float(limits.upper[c])
        speed, effort = (min(float(getattr(limits, key)[c]), FAR) for key in ("velocity", "effort"))
        if own:
            masters[c] = name
        else:
            inner.append(
                f"<mimic joint={quoteattr(robot.joint_names[c])} multiplier={_text(link.multiplier)} offset={_text(link.offset)}/>"
            )
            low, high = sorted((link.multiplier * low + link.offset, link.multiplier * high + link.offset))
            speed = min(speed * abs(link.multiplier), FAR)
        bounds = f"lower={_text(low)} upper={_text(high)} "
        if not np.isfinite([low, high]).all():
            kind, bounds = (
                ("continuous", "") if kind == "revolute" else (kind, f"lower={_text(-FAR)} upper={_text(FAR)} ")
            )
        inner.insert(0, f"<axis xyz={_text(*link.axis)}/>")
        inner.append(f"<limit {bounds}velocity={_text(speed)} effort={_text(effort)}/>")
    head = f"  <joint name={quoteattr(name)} type={quoteattr(kind)}>"
    ends = f"<parent link={quoteattr(parent)}/><child link={quoteattr(link.name)}/>"
    return [f"{head}{ends}{_origin(link.origin)}{''.join(inner)}</joint>"]


def _bodies(robot: Robot, link: int) -> list[str]:
    caps, lines = robot.capsules, []
    for k in np.flatnonzero(caps.link == link):
        a, b, r = caps.a[k], caps.b[k], float(caps.radius[k])
        length = float(np.linalg.norm(b - a))
        lines.append(_collision(f"<origin xyz={_text(*a)}/>", f"<sphere radius={_text(r)}/>"))
        if length == 0.0:
            continue
        lines.append(_collision(f"<origin xyz={_text(*b)}/>", f"<sphere radius={_text(r)}/>"))
        u = (b - a) / length
        # yaw about z after pitch about y takes z to u
        rpy = (0.0, float(np.arctan2(np.hypot(u[0], u[1]), u[2])), float(np.arctan2(u[1], u[0])))
        origin = f"<origin xyz={_text(*(0.5 * (a + b)))} rpy={_text(*rpy)}/>"
        lines.append(_collision(origin, f"<cylinder radius={_text(r)} length={_text(length)}/>"))
    return lines


def _collision(origin: str, shape: str) -> str:
    return f"    <collision>{origin}<geometry>{shape}</geometry></collision>"


def _origin(motor: _placement.Floats) -> str:
    rotation, translation = _placement.rotation_translation(motor)
    across = float(np.hypot(rotation[0, 0], rotation[1, 0]))
    pitch = float(np.arctan2(-rotation[2, 0], across))
    if across > 1e-9:
        roll = float(np.arctan2(rotation[2, 1], rotation[2, 2]))
        yaw = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
    else:  # roll and yaw turn about the same axis
        roll, yaw = 0.0, float(np.arctan2(-rotation[0, 1], rotation[1, 1]))
    return f"<origin xyz={_text(*translation)} rpy={_text(roll, pitch, yaw)}/>"


def _text(*values: float) -> str:
    return quoteattr(" ".join(repr(float(v)) for v in values))
