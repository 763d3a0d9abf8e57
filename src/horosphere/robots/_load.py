"""`load`: a robot by name or file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from ..errors import InputError, unknown_name
from ..numeric import at_most, file_path, float_array
from . import _builtin, _chain, _pairs, _placement
from ._bodies import Body, as_balls
from ._closer import closer_covers
from ._cover import CoverOptions, LinkCover, cover_link
from ._document import load_document, pack
from ._robot import Robot, require_robot
from ._sidecar import joint_segments, read_capsules
from ._srdf import Srdf, read_srdf
from ._urdf import no_file, read_urdf

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
    srdf: str | Path | None = None,
    group: str | None = None,
    collision: Literal["capsules", "spheres"] = "capsules",
    budget: int | None = None,
    tolerance: float | None = None,
    geometry: Literal["auto", "collision", "visual"] = "auto",
    progress: Callable[[str], None] | None = None,
) -> Robot:
    """A built-in robot by name, or a robot from a URDF or YAML file.

    base, tip: links of a URDF between which the joints move (default: those of the SRDF's `group`, else the root and the only
    leaf). Joints beside that chain are locked at zero, or at the limit nearest to it; a joint that mimics one of the chain moves
    with it. `locked`: joints of the chain to lock, with their values (rad, m).
    srdf: a MoveIt SRDF; the pairs of links that it disables are not checked against each other.
    collision, budget, tolerance: geometry is covered by capsules (at most 40 round the meshes of a link, or `budget`) or by
    spheres (48), no more than a slack of `tolerance` (m; 1.5 cm, or a fifth of the size of small links) needs. It lies inside
    them. `geometry`: which of the URDF's is covered; "auto" is collision, and visual for links that have no collision geometry
    or whose collision meshes cannot be read.
    capsules: a capsule file, or a mapping like its `links`; it replaces the bodies of the links it names. link_radius
    (m): capsules of this radius along the joint-to-joint segments of those links of the chain that have no collision
    body otherwise.
    Limits: the tighter of <limit> and the soft limits of <safety_controller>. `notes` say what was covered and with what slack,
    what was missing, locked or left out. Nothing is ever downloaded. `progress` is told what is being done.
    Raises InputError (file:line) for what cannot be read, unknown links, contradictory limits, closed loops, an SRDF that is
    for another robot.
    """
    if link_radius is not None and float(float_array(link_radius, "link_radius", ndim=0)) <= 0.0:
        raise InputError(f"expected a positive radius in metres, got {link_radius!r}", place="link_radius")
    options = CoverOptions(collision, budget, tolerance, geometry)
    path = file_path(name_or_path, "name_or_path")
    text = str(name_or_path)
    if text in names():
        robot = _MADE[text]() if text in _MADE else load_document(CATALOGUE / f"{text}.yaml")
    elif path.suffix.lower() in (".yaml", ".yml"):
        if not path.is_file():
            raise no_file(path)
        robot = load_document(path)
    elif path.suffix.lower() in (".urdf", ".xml") or path.is_file():
        given = Given(base, tip, capsules, link_radius, locked or {}, srdf, group, progress)
        return _from_urdf(path, given, options)
    elif path.suffix or "/" in text or path.exists():
        raise no_file(path, "give a URDF, a robot YAML, or a built-in name", names())
    else:
        raise unknown_name("robot", text, names())
    if base is not None or tip is not None or locked or srdf is not None or group is not None:
        raise InputError("base, tip, locked, srdf and group are for URDF files", place=text)
    if capsules is None and link_radius is None and collision == "capsules":
        return robot
    return _with_bodies(robot, capsules, link_radius, options)


@dataclass(frozen=True, slots=True)
class Given:
    """What the caller of `load` says about a URDF."""

    base: str | None
    tip: str | None
    capsules: str | Path | Mapping[str, Any] | None
    link_radius: float | None
    locked: Mapping[str, float]
    srdf: str | Path | None
    group: str | None
    progress: Callable[[str], None] | None = None


def _from_urdf(path: Path, given: Given, options: CoverOptions) -> Robot:
    urdf = read_urdf(path)
    srdf = None if given.srdf is None else read_srdf(Path(given.srdf), urdf)
    if srdf is None and given.group is not None:
        raise InputError(
            "a group is named in an SRDF, and none is given", place="group", remedy="give the SRDF, too (`srdf`)"
        )
    base, tip, notes = given.base, given.tip, []
    if srdf is not None:
        notes.append(f"{len(srdf.disabled)} pairs of links are disabled by {srdf.path.name}")
        chosen = srdf.chain(given.group) if given.group is not None or (base is None and tip is None) else None
        if chosen is not None:
            base, tip = base or chosen[0], tip or chosen[1]
            notes.append(f"chain of the SRDF's group {chosen[2]!r}: {base} to {tip}")
        elif base is None and tip is None and srdf.chains:
            notes.append(f"no group of {srdf.path.name} is named (`group`); it has {', '.join(srdf.chains)}")
    try:
        chain = _chain.build_chain(urdf, base, tip, given.locked)
    except InputError as error:
        if tip is not None or srdf is None or not srdf.chains or error.choices is not None:
            raise
        remedy = f"name a group of the SRDF (`group`): {', '.join(srdf.chains)}; or a tip (`tip`)"
        raise InputError(error.message, place=error.place, remedy=remedy) from None
    notes += chain.notes
    sidecar = (
        {} if given.capsules is None else read_capsules(given.capsules, chain.links, chain.tip, _placement.IDENTITY)
    )
    files: dict[str, Any] = {}
    tell = given.progress or (lambda what: None)
    covers: dict[str, LinkCover] = {}
    shaped = [link.name for link in chain.links if urdf.collisions[link.name] or urdf.visuals[link.name]]
    for link in chain.links:
        if link.name not in sidecar:
            if link.name in shaped:
                tell(f"covering {link.name} ({shaped.index(link.name) + 1} of {len(shaped)})")
            covers[link.name] = cover_link(urdf, link.name, options, files)
    tell("choosing the pairs of links to check")
    robot = Robot(
        name=urdf.name,
        links=tuple(chain.links),
        tip=chain.tip,
        joint_names=tuple(chain.joint_names),
        limits=chain.limits(),
        source=str(path),
    )

    def closer(name: str) -> LinkCover:
        tell(f"covering {name} more closely")
        return cover_link(urdf, name, replace(options, share=0.5), files)

    bodies = {name: found.bodies for name, found in covers.items()}
    again = closer if options.tolerance is None else None
    return _finish(robot, bodies, sidecar, given.link_radius, notes, options, srdf, covers, again)


def _cover_notes(covers: Mapping[str, LinkCover], options: CoverOptions) -> list[str]:
    """What was covered by how much, and what could not be read."""
    notes: list[str] = []
    problems = {name: found.problems for name, found in covers.items() if found.problems}
    if problems:
        first = next(iter(problems.values()))[0]
        count = sum(map(len, problems.values()))
        notes.append(f"{count} mesh(es) of {len(problems)} link(s) could not be used, for example: {first}")
    fitted = {name: found for name, found in covers.items() if found.slack > 0.0}
    if fitted:
        worst = max(fitted, key=lambda name: fitted[name].slack)
        count = sum(map(len, (found.bodies for found in fitted.values())))
        triangles = sum(found.triangles for found in fitted.values())
        of = f" ({triangles} triangles)" if triangles else ""
        notes.append(
            f"collision model: {count} {options.kind} hold the geometry of {len(fitted)} links{of}; they stand out of it "
            f"by at most {at_most(fitted[worst].slack, decimals=4)} m ({worst})"
        )
    visual = [name for name, found in covers.items() if found.visual and found.bodies]
    if visual and options.geometry == "auto":
        notes.append(f"no usable collision geometry, so the visual one is covered: {', '.join(visual)}")
    return notes


def _with_bodies(
    robot: Robot,
    capsules: str | Path | Mapping[str, Any] | None,
    link_radius: float | None,
    options: CoverOptions,
) -> Robot:
    bodies: dict[str, list[Body]] = {name: [] for name in robot.link_names}
    caps = robot.capsules
    for k in range(len(caps)):
        body = Body(caps.a[k], caps.b[k], float(caps.radius[k]), caps.note[k])
        found = bodies[robot.link_names[caps.link[k]]]
        found += (
            [body]
            if options.kind == "capsules"
            else as_balls(body, options.most, options.tolerance_for(2.0 * body.radius))
        )
    given = {} if capsules is None else read_capsules(capsules, robot.links, robot.tip, robot.tool)
    notes = [note for note in robot.notes if "checked" not in note]
    if options.kind == "spheres":
        notes.append("collision model: balls along the capsules")
    return _finish(robot, bodies, given, link_radius, notes, options)


def _finish(
    robot: Robot,
    bodies: dict[str, list[Body]],
    given: dict[str, list[Body]],
    link_radius: float | None,
    notes: list[str],
    options: CoverOptions,
    srdf: Srdf | None = None,
    covers: Mapping[str, LinkCover] | None = None,
    closer: Callable[[str], LinkCover] | None = None,
) -> Robot:
    """Put the collision model together, choose the self-collision pairs, and say what was done.

    `covers`: where bodies come from; `closer` makes one again, where links would seem to touch often.
    """
    bodies, covers = bodies | given, dict(covers or {})
    troubled = {name for name, found in covers.items() if found.problems}
    surfaces = {name: found.surface for name, found in covers.items() if found.surface is not None}
    by_radius: list[str] = []
    if link_radius is not None:
        for index in robot.chain:
            name = robot.links[index].name
            if name not in given and not bodies.get(name):
                bodies[name] = joint_segments(robot.links, index, robot.tip, robot.tool, link_radius)
                if bodies[name]:
                    by_radius.append(name)
    packed = pack(bodies, list(robot.link_names))
    pairs, table, dropped = _pairs.choose_pairs(robot.links, robot.limits, packed, srdf, surfaces=surfaces)
    again = closer_covers(robot.links, robot.limits, covers, table, closer) if closer else {}
    if again:
        covers, bodies = covers | again, bodies | {name: found.bodies for name, found in again.items()}
        packed = pack(bodies, list(robot.link_names))
        pairs, table, dropped = _pairs.choose_pairs(robot.links, robot.limits, packed, srdf, surfaces=surfaces)
    notes += _cover_notes(covers, options)
    if again:
        notes.append(f"covered to half the usual tolerance, since their bodies overlapped often: {', '.join(again)}")
    bare = sorted(troubled - {name for name, found in bodies.items() if found})
    partly = sorted(troubled - set(bare) - set(given))
    if given:
        count = sum(map(len, given.values()))
        notes.append(f"collision model: {count} capsules from the capsule file for {', '.join(sorted(given))}")
    if by_radius:
        notes.append(f"collision model: joint-to-joint segments of radius {link_radius:g} m for {', '.join(by_radius)}")
    if bare:
        some = ", ".join(bare[:6]) + (f" and {len(bare) - 6} more" if len(bare) > 6 else "")
        notes.append(f"WITHOUT collision body: {some}; give a capsule file or a link radius (docs/robots.md)")
    elif not len(packed):
        notes.append("NO collision body at all; give a capsule file or a link radius (docs/robots.md)")
    if partly:
        notes.append(f"INCOMPLETE, since some of their meshes could not be read: {', '.join(partly)}")
    return replace(robot, capsules=packed, self_pairs=pairs, pair_table=table, notes=(*notes, *dropped))


def link_index(robot: Robot, name: str) -> int:
    """Index of a link by name; InputError with the names if there is none."""
    for k, link in enumerate(require_robot(robot).links):
        if isinstance(name, str) and link.name == name:
            return k
    raise unknown_name("link", name, robot.link_names, place="link")
