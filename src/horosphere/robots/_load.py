"""`load`: a robot by name or file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, unknown_name
from . import _builtin, _chain, _pairs, _placement
from ._bodies import Body
from ._document import load_document, pack
from ._meshes import link_bodies
from ._robot import Robot
from ._sidecar import joint_segments, read_capsules
from ._urdf import read_urdf

CATALOGUE = Path(__file__).parent / "catalogue"
_MADE: dict[str, Callable[[], Robot]] = {"humanoid-arm": _builtin.humanoid_arm, "srs-arm": _builtin.srs_arm}


def names() -> tuple[str, ...]:
    """Names of the built-in robots."""
    return tuple(sorted({*_MADE, *(path.stem for path in CATALOGUE.glob("*.yaml"))}))


def load(
    name_or_path: str | Path,
    base: str | None = None,
    tip: str | None = None,
    *,
    capsules: str | Path | Mapping[str, Any] | None = None,
    link_radius: float | None = None,
    locked: Mapping[str, float] | None = None,
) -> Robot:
    """A built-in robot by name, or a robot from a URDF or YAML file.

    base, tip: links of a URDF between which the joints move (default: the root, and the only leaf). Joints beside
    that chain are locked at zero, or at the limit nearest to it; a joint that mimics one of the chain moves with it.
    `locked`: joints of the chain to lock, with their values (rad, m).
    capsules: a capsule file, or a mapping like its `links`; it replaces the bodies of the links it names. link_radius
    (m): capsules of this radius along the joint-to-joint segments of those links of the chain that have no collision
    body otherwise.
    Limits: the tighter of <limit> and the soft limits of <safety_controller>. Collision geometry becomes capsules
    that contain it; `notes` say with what slack, what was missing, locked or left out. Nothing is ever downloaded.
    Raises InputError (file:line) for what cannot be read, unknown links, contradictory limits, closed loops.
    """
    if link_radius is not None and not (np.isfinite(link_radius) and link_radius > 0):
        raise InputError(f"expected a positive radius in metres, got {link_radius!r}", place="link_radius")
    text = str(name_or_path)
    path = Path(name_or_path)
    if text in names():
        robot = _MADE[text]() if text in _MADE else load_document(CATALOGUE / f"{text}.yaml")
    elif path.suffix.lower() in (".yaml", ".yml"):
        if not path.is_file():
            raise InputError("no such file", place=text)
        robot = load_document(path)
    elif path.suffix.lower() in (".urdf", ".xml") or path.is_file():
        return _from_urdf(path, base, tip, capsules, link_radius, locked or {})
    elif path.suffix or "/" in text:
        raise InputError(
            "no such file", place=text, remedy="give a URDF, a robot YAML, or a built-in name", choices=names()
        )
    else:
        raise unknown_name("robot", text, names(), place="name_or_path")
    if base is not None or tip is not None or locked:
        raise InputError("base, tip and locked are for URDF files", place=text)
    return robot if capsules is None and link_radius is None else _with_bodies(robot, capsules, link_radius)


def _from_urdf(
    path: Path,
    base: str | None,
    tip: str | None,
    capsules: str | Path | Mapping[str, Any] | None,
    link_radius: float | None,
    locked: Mapping[str, float],
) -> Robot:
    urdf = read_urdf(path)
    chain = _chain.build_chain(urdf, base, tip, locked)
    notes = list(chain.notes)
    bodies: dict[str, list[Body]] = {}
    given = {} if capsules is None else read_capsules(capsules, chain.links, chain.tip, _placement.IDENTITY)
    problems: dict[str, list[str]] = {}
    for link in chain.links:
        if link.name in given:
            continue
        bodies[link.name], trouble = link_bodies(urdf, link.name)
        if trouble:
            problems[link.name] = trouble
    if problems:
        first = next(iter(problems.values()))[0]
        count = sum(map(len, problems.values()))
        notes.append(f"{count} collision mesh(es) of {len(problems)} link(s) could not be used, for example: {first}")
    robot = Robot(
        name=urdf.name,
        links=tuple(chain.links),
        tip=chain.tip,
        joint_names=tuple(chain.joint_names),
        limits=chain.limits(),
        source=str(path),
    )
    return _finish(robot, bodies, given, link_radius, notes, set(problems))


def _with_bodies(robot: Robot, capsules: str | Path | Mapping[str, Any] | None, link_radius: float | None) -> Robot:
    bodies: dict[str, list[Body]] = {name: [] for name in robot.link_names}
    caps = robot.capsules
    for k in range(len(caps)):
        body = Body(caps.a[k], caps.b[k], float(caps.radius[k]), caps.note[k])
        bodies[robot.link_names[caps.link[k]]].append(body)
    given = {} if capsules is None else read_capsules(capsules, robot.links, robot.tip, robot.tool)
    notes = [note for note in robot.notes if "not checked against each other" not in note]
    return _finish(robot, bodies, given, link_radius, notes, set())


def _finish(
    robot: Robot,
    bodies: dict[str, list[Body]],
    given: dict[str, list[Body]],
    link_radius: float | None,
    notes: list[str],
    troubled: set[str],
) -> Robot:
    """Put the collision model together, choose the self-collision pairs, and say what was done."""
    bodies = bodies | given
    by_radius: list[str] = []
    if link_radius is not None:
        for index in robot.chain:
            name = robot.links[index].name
            if name not in given and not bodies.get(name):
                bodies[name] = joint_segments(robot.links, index, robot.tip, robot.tool, link_radius)
                if bodies[name]:
                    by_radius.append(name)
    packed = pack(bodies, list(robot.link_names))
    pairs, dropped = _pairs.choose_pairs(robot.links, robot.limits, packed)
    bare = sorted(troubled - {name for name, found in bodies.items() if found})
    if given:
        count = sum(map(len, given.values()))
        notes.append(f"collision model: {count} capsules from the capsule file for {', '.join(sorted(given))}")
    if by_radius:
        notes.append(f"collision model: joint-to-joint segments of radius {link_radius:g} m for {', '.join(by_radius)}")
    if bare:
        some = ", ".join(bare[:6]) + (f" and {len(bare) - 6} more" if len(bare) > 6 else "")
        notes.append(f"WITHOUT collision body: {some}; give capsules= (a capsule file) or link_radius=")
    elif not len(packed):
        notes.append("NO collision body at all; give capsules= (a capsule file) or link_radius=")
    return Robot(
        robot.name,
        robot.links,
        robot.tip,
        robot.joint_names,
        robot.limits,
        robot.tool,
        robot.closed_form,
        packed,
        pairs,
        robot.source,
        (*notes, *dropped),
    )


def link_index(robot: Robot, name: str) -> int:
    """Index of a link by name; InputError with the names if there is none."""
    for k, link in enumerate(robot.links):
        if link.name == name:
            return k
    raise unknown_name("link", name, robot.link_names)
