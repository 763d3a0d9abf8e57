"""What the robot of a MoveIt scene holds, and which contacts its allowed collision matrix permits."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, unknown_name
from ._moveit_node import Floats, Node, inverse
from ._moveit_objects import objects_of

if TYPE_CHECKING:
    from ..robots import Robot
    from ..shapes import Shape


_MATRIX = "allowed by the scene's allowed_collision_matrix"


@dataclass(frozen=True, eq=False)
class HeldObject:
    """An attached collision object: `shapes` in `frame` (a link; "" is `link` itself), fixed to `link`.

    `touch_links`: links that it may touch. No shapes: the object of that name in the world is picked up as it lies there.
    """

    name: str
    link: str
    frame: str
    shapes: tuple[Shape, ...]
    touch_links: tuple[str, ...] = ()
    place: str = ""


@dataclass(frozen=True, eq=False)
class Contacts:
    """An allowed collision matrix: pairs with a value of their own, and defaults of single names for all others."""

    entries: dict[frozenset[str], bool] = field(default_factory=dict)
    defaults: dict[str, bool] = field(default_factory=dict)

    @property
    def names(self) -> set[str]:
        """All names in it."""
        return {name for pair in self.entries for name in pair} | set(self.defaults)

    def allowed(self, first: str, second: str) -> bool:
        """Whether two bodies may touch: by their own entry, else if a default says so and none forbids it."""
        own = self.entries.get(frozenset((first, second)))
        if own is not None:
            return own
        defaults = [self.defaults[name] for name in (first, second) if name in self.defaults]
        return bool(defaults) and all(defaults)


def read_contacts(matrix: Node | None) -> Contacts:
    """`allowed_collision_matrix`: entry_names, entry_values (rows, bare or as `enabled`), default_entry_names and _values."""
    if matrix is None:
        return Contacts()
    names = _names(matrix, "entry_names")
    rows = [_row(row) for row in matrix.items("entry_values")]
    if len(rows) != len(names) or any(len(row) != len(names) for row in rows):
        sizes = sorted({len(row) for row in rows})
        raise matrix.error(
            f"{len(names)} entry_names, but entry_values has {len(rows)} rows of {' or '.join(map(str, sizes)) or 'no'} values"
        )
    entries = {}
    for i, first in enumerate(names):
        for j in range(i):
            if rows[i][j] != rows[j][i]:
                raise matrix.error(f"the entries of {first!r} and {names[j]!r} contradict each other")
            entries[frozenset((first, names[j]))] = rows[i][j]
    default_names = _names(matrix, "default_entry_names")
    node = matrix.get("default_entry_values")
    values = [] if node is None else _row(node)
    if len(default_names) != len(values):
        raise matrix.error(f"{len(default_names)} default_entry_names, but {len(values)} default_entry_values")
    return Contacts(entries, dict(zip(default_names, values)))


def _names(matrix: Node, field: str) -> list[str]:
    names = [str(item.value) for item in matrix.items(field)]
    if len(set(names)) != len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise matrix.need(field).error(f"{twice!r} stands in it twice")
    return names


def _row(row: Node) -> list[bool]:
    if isinstance(row.value, dict):
        row = row.need("enabled")
    if not isinstance(row.value, list) or not all(isinstance(x, bool) or x in (0, 1) for x in row.value):
        raise row.error(f"expected a list of true and false, got {row.value!r}")
    return [bool(x) for x in row.value]


def read_held(states: list[Node | None], notes: list[str]) -> tuple[HeldObject, ...]:
    """`attached_collision_objects` of robot states; of two with the same id the later counts."""
    held: dict[str, HeldObject] = {}
    for state in states:
        for item in [] if state is None else state.items("attached_collision_objects"):
            body = item.need("object") if item.get("object") is not None else item
            name = str(body.need("id").value)
            if body.plain("operation") in (1, "REMOVE"):
                held.pop(name, None)
                continue
            link, header = str(item.need("link_name").value), body.get("header")
            frame = "" if header is None else str(header.plain("frame_id") or "")
            links = tuple(str(x.value) for x in item.items("touch_links"))
            shapes = tuple(objects_of(body, np.eye(4), notes))
            held[name] = HeldObject(name, link, "" if frame == link else frame, shapes, links, body.place)
    return tuple(held.values())


def hold(
    robot: Robot, held: tuple[HeldObject, ...], q: Any, base: Floats, world: dict[str, list[Shape]]
) -> tuple[Robot, list[str]]:
    """The robot with what it holds, and notes.

    `q` (n,) gives the places of links for objects that are stated elsewhere than on their own link; `world`: shapes by object id,
    in the frame of the base; `base` (4, 4): where that stands in the world. Raises InputError at the place of an object.
    """
    from ..robots._placement import link_frames, rotation_translation

    notes = []
    for one in held:
        if one.link not in robot.link_names:
            raise unknown_name("link", one.link, robot.link_names, place=f"{one.place}: {one.name}")
        places = np.tile(np.eye(4), (len(robot.links), 1, 1))
        places[:, :3, :3], places[:, :3, 3] = rotation_translation(link_frames(robot.links, np.asarray(q, np.float64)))
        to_link = inverse(places[robot.link_names.index(one.link)])
        shapes: Any = one.shapes
        if not shapes:
            shapes, pose = world.get(one.name), to_link
            if not shapes:
                raise InputError(
                    f"the attached object {one.name!r} has no shape, and the world holds none of that name",
                    place=one.place,
                    choices=sorted(world),
                )
        elif not one.frame:
            pose = np.eye(4)
        elif one.frame in robot.link_names:
            pose = to_link @ places[robot.link_names.index(one.frame)]
        elif one.frame == "world":
            pose = to_link @ inverse(base)
        else:
            raise unknown_name("frame", one.frame, (*robot.link_names, "world"), place=f"{one.place}: {one.name}")
        unknown = [name for name in one.touch_links if name not in robot.link_names]
        if unknown:
            notes.append(f"{one.name}: touch_links names no link of {robot.name!r}: {', '.join(unknown)}")
        links = [name for name in one.touch_links if name not in unknown]
        try:
            robot = robot.with_attached(shapes, link=one.link, pose=_rigid(pose), name=one.name, allowed=links)
        except InputError as error:
            raise InputError(
                f"{one.name}: {error.message}", place=one.place, remedy=error.remedy, choices=error.choices
            ) from None
    return robot, notes


def _rigid(pose: Floats) -> Floats:
    """The rotation made orthogonal to the last bit: products of printed quaternions are so to 1e-8."""
    u, _, v = np.linalg.svd(pose[:3, :3])
    rigid = pose.copy()
    rigid[:3, :3] = u @ v
    return rigid


def allow(robot: Robot, contacts: Contacts, world: dict[str, list[Shape]]) -> tuple[Robot, list[str]]:
    """The robot with the contacts of the matrix: pairs of its links that are checked so far, and of links with objects; notes."""
    names = robot.link_names
    pairs = [(names[i], names[j]) for i, j in robot.self_pairs if contacts.allowed(names[i], names[j])]
    with_bodies = dict.fromkeys(names[k] for k in robot.capsules.link)
    for link in with_bodies:
        for name, shapes in world.items():
            if contacts.allowed(link, name):
                pairs += [(link, shape.name) for shape in shapes]
    notes = []
    unknown = sorted(contacts.names - set(names) - set(world))
    if unknown:
        more = f" and {len(unknown) - 8} more" if len(unknown) > 8 else ""
        notes.append(
            f"allowed_collision_matrix names neither links of {robot.name!r} nor objects: {', '.join(unknown[:8])}{more}"
        )
    return (robot.with_allowed(*pairs, reason=_MATRIX) if pairs else robot), notes
