"""The part of the elbow circle of an S-R-S arm on which its links clear balls and half-spaces, in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..distance import pack_robot, table
from ..errors import InputError
from ..numeric import float_array
from ..robots._robot import require_robot
from ._targets import pose_arrays
from ._wrist_arms import _reference, arm_lengths

Floats = NDArray[np.float64]
_TURN = 2.0 * np.pi


@dataclass(frozen=True, slots=True, eq=False)
class Arcs:
    """Free intervals of an angle on a circle.

    free: (k, 2) sorted intervals [low, high] inside [-pi, pi], radians; an arc through pi is given as two intervals
    that end at pi and start at -pi; (1, 2) = [[-pi, pi]] is the whole circle, (0, 2) nothing. reason: what leaves
    nothing free, else "". parameter: the name of the angle (psi, q7, q1, phi) where it is known.
    """

    free: Floats
    reason: str = ""
    parameter: str = ""

    def __repr__(self) -> str:
        """The arcs in words, those through pi in one piece."""
        if not len(self.free):
            return f"Arcs(none: {self.reason})"
        arcs = [f"{low:.3f} to {high:.3f}" for low, high in self.joined()]
        last = f" and {arcs.pop()}" if len(arcs) > 1 else ""
        where = "everywhere" if self.width >= _TURN else f"from {', '.join(arcs)}{last} rad"
        return f"Arcs({self.parameter or 'angle'} free {where})"

    def contains(self, angle: ArrayLike, margin: float = 0.0) -> NDArray[np.bool_]:
        """(...) the angle (any turn) lies in a free arc, at least `margin` radians from its ends."""
        x = np.pi - np.mod(np.pi - float_array(angle, "angle"), _TURN)
        inside = np.zeros(np.shape(x), dtype=bool)
        for low, high in self.joined():
            inside |= np.mod(x - low - margin, _TURN) <= high - low - 2.0 * margin if high - low < _TURN else True
        return inside

    def joined(self) -> Floats:
        """(k, 2) the arcs with those that meet at pi joined: low in [-pi, pi), high up to low + 2 pi."""
        arcs = [list(arc) for arc in self.free]
        if len(arcs) > 1 and arcs[0][0] == -np.pi and arcs[-1][1] == np.pi:
            arcs[-1][1] = arcs.pop(0)[1] + _TURN
        return np.array(arcs).reshape(-1, 2)

    def nearest(self, angle: float) -> float | None:
        """The free angle nearest to `angle` on the circle, or None when nothing is free."""
        if bool(self.contains(angle)):
            return float(np.pi - np.mod(np.pi - angle, _TURN))
        if not len(self.free):
            return None
        ends = self.joined().ravel()
        distance = np.abs(np.mod(ends - angle + np.pi, _TURN) - np.pi)
        return float(np.pi - np.mod(np.pi - ends[np.argmin(distance)], _TURN))

    @property
    def width(self) -> float:
        """Total length of the free arcs, radians."""
        return float((self.free[:, 1] - self.free[:, 0]).sum())


def elbow_arcs(
    robot: Any, target: Any, obstacles: Any, clearance: float = 0.0, *, fixed_bodies: bool = True
) -> Arcs | tuple[Arcs, ...]:
    """The elbow angles psi of an S-R-S arm at which its links stay at least `clearance` metres from the obstacles.

    For the built-in S-R-S arm one Arcs in closed form, as follows; for any other arm with a redundancy (elbow offset, sew7,
    reversed chains, the 5-DOF humanoid arm over phi) one Arcs a branch: `free_arcs(..., limits=False)`, proved between samples.

    target: one pose of the tip. obstacles: what `shapes.as_shapes` takes, of balls, point clouds and half-spaces. The arcs are
    exact for the capsules of upper arm and forearm (all 8 branches share them). Bodies that do not move with psi (column, hand
    and what it holds) decide all or nothing; `fixed_bodies=False` leaves them out. The column may stand in a half-space. Contacts
    that the robot allows are not looked at. Joint limits are not part of it.
    One link is a segment from a fixed end P (shoulder or wrist) to the elbow on sphere(P, L); a ball grown by radius and
    clearance to rho forbids the side E.pi > 0 of the plane of its tangent cone (or of the radical plane of both spheres), a
    half-space that of its own plane moved out by as much, and that plane cuts the elbow circle in the point pair (z ^ pi)*. Our
    derivation. Raises InputError for a robot without redundancy, a batch of targets, other obstacles, capsules off the links' axes.
    """
    if not require_robot(robot).closed_form or robot.closed_form[0] != "srs_arm":
        from ._free_arcs import free_arcs

        return free_arcs(robot, target, obstacles, clearance, limits=False)
    dbs, dse, dew, dwf = arm_lengths(robot)
    rotation, origin = pose_arrays(target)
    if origin.ndim != 1:
        raise InputError(f"expected one pose, got a batch of shape {origin.shape[:-1]}", place="target")
    clearance = float(float_array(clearance, "clearance", ndim=0))
    shapes = _with_closed_form(obstacles)

    shoulder, wrist = np.array([0.0, 0.0, dbs]), origin - dwf * rotation[:, 2]
    links = {"upper arm": (shoulder, dse), "forearm": (wrist, dew)}
    items = _link_capsules(robot, dse, dew)
    span = wrist - shoulder
    distance = float(np.sqrt(span @ span))
    missing = max(distance - (dse + dew), abs(dse - dew) - distance)
    if missing > 1e-13 * (dse + dew) or distance < 1e-12:
        return _nothing(f"the pose is out of reach by {max(missing, 0.0):.4g} m")
    if fixed_bodies:
        blocked = _fixed_contact(robot, target, shapes, clearance)
        if blocked:
            return _nothing(blocked)
    u = span / distance
    r = _reference(u)
    along = (dse * dse - dew * dew + distance * distance) / (2.0 * distance)
    rho = np.sqrt(max(dse * dse - along * along, 0.0))
    circle = (shoulder + along * u, rho * r, rho * np.cross(u, r))  # centre, and the elbow at psi = 0 and pi/2 from it

    forbidden: list[tuple[float, float]] = []
    for item, name in items:
        own = robot.links[robot.capsules.link[item]].name
        for k, shape in enumerate(shapes):
            if shape.name and (own, shape.name) in robot.allowed_obstacles:
                continue
            end, length = links[name]
            for cut in _link_planes(end, length, shape, float(robot.capsules.radius[item]) + clearance):
                arc = (0.0, np.pi) if isinstance(cut, str) else _arc_beyond(circle, *cut)
                if arc is not None and arc[1] >= np.pi:
                    return _nothing(f"obstacle {k} is closer than {clearance:g} m to the {name} at every psi")
                forbidden += [] if arc is None else [arc]
    free = _complement(forbidden)
    return (
        Arcs(free, "", "psi") if len(free) else _nothing("the forbidden arcs of the obstacles cover the elbow circle")
    )


def _nothing(reason: str) -> Arcs:
    """No psi at all."""
    return Arcs(np.zeros((0, 2)), reason, "psi")


def _link_planes(end: Floats, length: float, shape: Any, grown: float) -> list[tuple[Floats, float] | str]:
    """As `_link_plane`, of all balls of a shape, or of a half-space; those that forbid something."""
    from ..shapes import Ball, HalfSpace

    if isinstance(shape, HalfSpace):
        level = float(shape.distance) + grown
        return ["all"] if float(shape.normal @ end) < level else [(-shape.normal, -level)]
    centers = np.atleast_2d(shape.center if isinstance(shape, Ball) else shape.points)
    rho = np.broadcast_to(shape.radius, len(centers)) + grown
    near = np.flatnonzero(((centers - end) ** 2).sum(axis=-1) < np.maximum(rho + length, 0.0) ** 2)
    cuts = (_link_plane(end, length, centers[k], float(rho[k])) for k in near)
    return [cut for cut in cuts if cut is not None]


def _link_plane(end: Floats, length: float, center: Floats, rho: float) -> tuple[Floats, float] | str | None:
    """(n, d) with n.e > d exactly when the segment from `end` to e, |e - end| = length, comes closer than rho to
    `center`.

    "all": always; None: never.
    """
    toward = center - end
    distance = float(np.sqrt(toward @ toward))
    if distance < rho or distance == 0.0:
        return "all"
    if rho <= 0.0 or distance >= rho + length:
        return None
    n = toward / distance
    tangent = float(np.sqrt((distance - rho) * (distance + rho)))
    if tangent <= length:  # the tangent cone, cut at the elbow's distance
        return n, float(n @ end) + length * tangent / distance
    # The radical plane of sphere(end, length) and sphere(center, rho).
    return n, float(n @ end) + (distance * distance + length * length - rho * rho) / (2.0 * distance)


def _arc_beyond(circle: tuple[Floats, Floats, Floats], n: Floats, d: float) -> tuple[float, float] | None:
    """(middle, half width) of the arc of c + a cos psi + b sin psi on the side n.e > d; half width pi: all; None:
    nothing.
    """
    center, a, b = circle
    x, y, offset = float(n @ a), float(n @ b), float(n @ center) - d
    size = float(np.hypot(x, y))
    if abs(offset) >= size:
        return (0.0, np.pi) if offset > 0.0 else None
    return float(np.arctan2(y, x)), float(np.arctan2(np.sqrt((size - offset) * (size + offset)), -offset))


def _complement(forbidden: list[tuple[float, float]]) -> Floats:
    """What the open arcs (middle, half width) leave of [-pi, pi]."""
    parts: list[tuple[float, float]] = []
    for middle, half in forbidden:
        low = np.mod(middle - half + np.pi, _TURN) - np.pi
        high = low + 2.0 * half
        parts += [(low, min(high, np.pi))] + ([(-np.pi, high - _TURN)] if high > np.pi else [])
    free, reached = [], -np.pi
    for low, high in sorted(parts):
        if low > reached:
            free.append((reached, low))
        reached = max(reached, high)
    if reached < np.pi:
        free.append((reached, np.pi))
    return np.array(free).reshape(-1, 2)


def _with_closed_form(obstacles: Any) -> tuple[Any, ...]:
    """The obstacles, if all are balls, clouds of balls, or half-spaces."""
    from ..shapes import Ball, HalfSpace, PointCloud, as_shapes

    shapes = as_shapes(() if obstacles is None else obstacles)
    for k, shape in enumerate(shapes):
        if not isinstance(shape, (Ball, PointCloud, HalfSpace)):
            raise InputError(
                f"there is no closed form for a {type(shape).__name__}", place=f"obstacles[{k}]",
                remedy="kinematics.free_arcs(robot, target, obstacles, clearance) takes all obstacles",
                choices=("Ball", "PointCloud", "HalfSpace"),
            )  # fmt: skip
    return shapes


def _link_capsules(robot: Any, dse: float, dew: float) -> list[tuple[int, str]]:
    """The capsules along S-E and E-W, by number, and the name of their link; those of column and hand are left out."""
    # By place in the chain: link 3 carries the upper arm from S, links 4 and 5 the forearm from E.
    spans = {3: ("upper arm", dse), 4: ("forearm", dew), 5: ("forearm", dew)}
    frames, found = pack_robot(robot).frames, []
    for item, link in enumerate(robot.capsules.link):
        if frames[item] in (0, 7):
            continue
        name, high = spans.get(robot.chain.index(link) if link in robot.chain else -1, ("", -1.0))
        a, b = robot.capsules.a[item], robot.capsules.b[item]
        ends = sorted((float(a[2]), float(b[2])))
        if not _on_axis(a, b) or abs(ends[0]) > 1e-9 or abs(ends[1] - high) > 1e-9:
            raise InputError(
                f"capsule {item} ({robot.capsules.note[item]}) is not the whole segment of its link", place="robot",
                remedy="kinematics.free_arcs takes all bodies, or use one capsule a segment",
            )  # fmt: skip
        found.append((item, name))
    return found


def _fixed_contact(robot: Any, target: Any, shapes: tuple[Any, ...], clearance: float) -> str:
    """The first body that does not move with psi and is closer than `clearance` to an obstacle, in words, or ""."""
    from ..shapes import HalfSpace
    from ._wrist_arms import srs_inverse

    if not shapes:
        return ""
    found, frames = table(robot, srs_inverse(robot, target, psi=0.0).q[0], shapes), pack_robot(robot).frames
    floor = np.array([isinstance(shape, HalfSpace) for shape in shapes])
    counts = (frames == 7)[:, None] | ((frames == 0)[:, None] & ~floor)
    gap = np.where(counts, found.distance, np.inf)
    if not gap.min(initial=np.inf) < clearance:
        return ""
    item, k = np.unravel_index(int(np.argmin(gap)), gap.shape)
    body = robot.capsules.note[item] or robot.links[robot.capsules.link[item]].name
    return f"obstacle {k} is {gap[item, k]:.4g} m from {body}, at every psi"


def _on_axis(a: Floats, b: Floats) -> bool:
    return bool(np.abs(np.r_[a[:2], b[:2]]).max() < 1e-9)
