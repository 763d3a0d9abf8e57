"""A robot as data: links in a tree, limits, collision capsules. No algorithm lives here."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, unknown_name
from ..numeric import float_array

Floats = NDArray[np.float64]
Kind = Literal["fixed", "revolute", "prismatic"]
KINDS: tuple[Kind, ...] = ("fixed", "revolute", "prismatic")


def frozen(value: Any, dtype: type = np.float64) -> NDArray[Any]:
    """A private, contiguous, read-only copy, without negative zeros (they would tell equal robots apart)."""
    array = np.array(value, dtype=dtype, order="C")
    array += 0
    array.setflags(write=False)
    return array


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A rigid body and the joint that carries it.

    Pose in the base frame: `M = M_parent @ origin @ exp(joint motion of multiplier * q[coordinate] + offset
    about/along axis)`. A link that mimics another joint shares its coordinate; a continuous joint is revolute with
    infinite limits.

    Attributes: `origin` (8,) motor from the parent's frame to the joint's frame at zero; `axis` (3,) unit vector in
    the joint's frame; `coordinate` index into q, -1 if fixed; radians and metres.
    """

    name: str
    parent: int
    origin: Floats
    kind: Kind = "fixed"
    axis: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    coordinate: int = -1
    multiplier: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(f"unknown joint kind {self.kind!r}", place=f"link {self.name!r}", choices=KINDS)
        object.__setattr__(
            self, "origin", frozen(float_array(self.origin, f"origin of link {self.name!r}", last=8, ndim=1))
        )
        object.__setattr__(self, "axis", frozen(float_array(self.axis, f"axis of link {self.name!r}", last=3, ndim=1)))


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """Limits of the joint coordinates, each (n,): rad or m, per s, per s^2, N m or N; infinite where there is none."""

    lower: Floats
    upper: Floats
    velocity: Floats
    acceleration: Floats
    effort: Floats

    def __post_init__(self) -> None:
        for item in fields(self):
            array = float_array(getattr(self, item.name), f"{item.name} limits", ndim=1, finite=False)
            if np.isnan(array).any():
                raise InputError(f"joint {int(np.argmax(np.isnan(array)))} is NaN", place=f"{item.name} limits")
            object.__setattr__(self, item.name, frozen(array))
        if len({len(getattr(self, item.name)) for item in fields(self)}) != 1:
            raise InputError("the limit arrays differ in length", place="limits")
        if (self.lower > self.upper).any():
            j = int(np.argmax(self.lower > self.upper))
            raise InputError(f"joint {j}: lower {self.lower[j]:g} > upper {self.upper[j]:g}", place="limits")

    @property
    def middle(self) -> Floats:
        """The middle of each range (n,); where an end is missing, the value nearest to 0."""
        bounded = np.isfinite(self.lower) & np.isfinite(self.upper)
        ends = np.where(bounded, [self.lower, self.upper], 0.0)
        return np.where(bounded, 0.5 * (ends[0] + ends[1]), np.clip(0.0, self.lower, self.upper))

    @staticmethod
    def unlimited(n: int) -> Limits:
        """No limit on any of n coordinates."""
        inf = np.full(n, np.inf)
        return Limits(-inf, inf, inf, inf, inf)


@dataclass(frozen=True, slots=True, eq=False)
class Capsules:
    """Collision bodies in link frames (metres): all points within `radius` of the segment a-b; a sphere has a == b.

    Attributes: `link` (m,) index into `Robot.links`; `a`, `b` (m, 3); `radius` (m,); `note` (m,) where each came from.
    """

    link: NDArray[np.int64]
    a: Floats
    b: Floats
    radius: Floats
    note: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        radius = float_array(self.radius, "capsule radii", ndim=1)
        m = len(radius)
        for name, shape in (("link", (m,)), ("a", (m, 3)), ("b", (m, 3))):
            array = float_array(getattr(self, name), f"capsule {name}")
            if array.size != math.prod(shape):
                raise InputError(
                    f"expected shape {shape}, as there are {m} radii, got {array.shape}", place=f"capsule {name}"
                )
            object.__setattr__(self, name, frozen(array.reshape(shape), np.int64 if name == "link" else np.float64))
        object.__setattr__(self, "radius", frozen(radius))
        object.__setattr__(self, "note", tuple(self.note) or ("",) * m)
        if (self.radius < 0).any():
            k = int(np.argmin(self.radius))
            raise InputError(f"capsule {k} has the negative radius {self.radius[k]:g}", place="capsules")

    def __len__(self) -> int:
        return len(self.radius)

    @staticmethod
    def none() -> Capsules:
        """No collision bodies."""
        return Capsules(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


@dataclass(frozen=True, slots=True)
class LinkPair:
    """Two links with collision bodies: whether they are checked against each other, and why (not).

    `touching`: in which share of the sampled configurations their bodies overlapped; None if that was not looked at.
    """

    first: str
    second: str
    checked: bool
    reason: str
    touching: float | None = None


@dataclass(frozen=True, eq=False)
class Robot:
    """A kinematic tree with one tip, its limits and its collision model; data only, in SI units.

    Attributes
    ----------
    links: parents come before children, `links[0]` is the base. Links beside the chain to the tip stay, for their
    collision bodies.
    tip: index of the tip link; `tool`: (8,) motor from the tip link's frame to the tool frame, whose pose `forward`
    returns.
    joint_names, limits: one entry per coordinate of q.
    closed_form: name and parameters of the closed-form inverse kinematics that applies, or None.
    self_pairs: (k, 2) pairs of links whose bodies are checked against each other.
    source, notes: where the robot came from, and what the loader did that its user should know.
    pair_table: one entry for every two links with bodies, checked or not, and why; empty if nobody said.
    allowed_obstacles: (link name, obstacle name) pairs that may touch.
    """

    name: str
    links: tuple[Link, ...]
    tip: int
    joint_names: tuple[str, ...]
    limits: Limits
    tool: Floats = field(default_factory=lambda: np.array([1.0, 0, 0, 0, 0, 0, 0, 0]))
    closed_form: tuple[str, dict[str, float]] | None = None
    capsules: Capsules = field(default_factory=Capsules.none)
    self_pairs: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    source: str = ""
    notes: tuple[str, ...] = ()
    pair_table: tuple[LinkPair, ...] = ()
    allowed_obstacles: tuple[tuple[str, str], ...] = ()
    memo: dict[str, Any] = field(default_factory=dict, init=False, repr=False)
    """What upper layers derived from this robot (packed arrays, compiled kernels), by name; never part of its value."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "links", tuple(self.links))
        object.__setattr__(self, "joint_names", tuple(self.joint_names))
        object.__setattr__(self, "notes", tuple(self.notes))
        object.__setattr__(self, "pair_table", tuple(self.pair_table))
        object.__setattr__(self, "allowed_obstacles", tuple((str(a), str(b)) for a, b in self.allowed_obstacles))
        object.__setattr__(self, "tool", frozen(float_array(self.tool, "tool", last=8, ndim=1)))
        object.__setattr__(self, "self_pairs", frozen(np.reshape(self.self_pairs, (-1, 2)), np.int64))
        place, n = f"robot {self.name!r}", len(self.joint_names)
        if not self.links or self.links[0].parent != -1:
            raise InputError("links[0] must be the base, with parent -1", place=place)
        if len(self.limits.lower) != n:
            raise InputError(f"{n} joints but {len(self.limits.lower)} limits", place=place)
        for i, link in enumerate(self.links):
            if i and not 0 <= link.parent < i:
                raise InputError(f"link {link.name!r}: parent {link.parent} does not come before it", place=place)
            if (link.kind != "fixed") != (0 <= link.coordinate < n):
                raise InputError(
                    f"link {link.name!r}: {link.kind} with coordinate {link.coordinate} of {n}", place=place
                )
        for what, index in (
            ("tip", np.array([self.tip])),
            ("capsules", self.capsules.link),
            ("self_pairs", self.self_pairs),
        ):
            if index.size and (index.min() < 0 or index.max() >= len(self.links)):
                raise InputError(f"{what} names link {index.max()} of {len(self.links)}", place=place)
        for name, _ in self.allowed_obstacles:
            if name not in self.link_names:
                raise unknown_name("link", name, self.link_names, place=f"{place}: allowed_obstacles")

    def __reduce__(self):
        return Robot, tuple(getattr(self, item.name) for item in fields(self) if item.init)

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, {self.n_joints} joints, {len(self.links)} links, {len(self.capsules)} capsules)"

    @property
    def n_joints(self) -> int:
        """Number of coordinates of q."""
        return len(self.joint_names)

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of `links`, in order."""
        return tuple(link.name for link in self.links)

    @cached_property
    def chain(self) -> tuple[int, ...]:
        """Indices of the links from the base to the tip."""
        path = [self.tip]
        while path[-1]:
            path.append(self.links[path[-1]].parent)
        return tuple(reversed(path))

    @cached_property
    def static_bodies(self) -> NDArray[np.bool_]:
        """Which capsules (m,) no joint moves: they stand still in the base frame, whatever q."""
        moves = np.zeros(len(self.links), bool)
        for i, link in enumerate(self.links):
            moves[i] = link.kind != "fixed" or (link.parent >= 0 and moves[link.parent])
        static = ~moves[self.capsules.link]
        static.setflags(write=False)
        return static

    @cached_property
    def link_bounds(self) -> Floats:
        """A ball (links, 4) round the bodies of each link, in its frame: centre, radius; the radius is -1 if it has none."""
        from ._bodies import enclosing_ball

        bodies, balls = self.capsules, np.tile([0.0, 0.0, 0.0, -1.0], (len(self.links), 1))
        for k in np.unique(bodies.link):
            own = bodies.link == k
            balls[k] = enclosing_ball(np.concatenate([bodies.a[own], bodies.b[own]]), np.tile(bodies.radius[own], 2))
        return frozen(balls)

    def with_attached(self, bodies: Any, **options: Any) -> Robot:
        """The robot with an object that it holds: see `robots.attach`."""
        from ._attach import attach

        return attach(self, bodies, **options)

    def with_allowed(self, *pairs: tuple[str, str], reason: str = "allowed by the caller") -> Robot:
        """The robot with contacts that are allowed: two link names, or a link's and an obstacle's. See `robots.allow`."""
        from ._attach import allow

        return allow(self, pairs, reason)

    @cached_property
    def content(self) -> str:
        """Fingerprint of the kinematics (links, tip, tool): robots that move alike have the same."""
        digest = hashlib.sha256()
        for link in self.links:
            digest.update(repr((link.parent, link.kind, link.coordinate, link.multiplier, link.offset)).encode())
            digest.update(link.origin.tobytes() + link.axis.tobytes())
        digest.update(repr((self.tip, self.n_joints)).encode() + self.tool.tobytes())
        return digest.hexdigest()[:16]


def require_robot(value: Any) -> Robot:
    """The argument `robot` of a function; InputError where it is none, a name or a file for instance."""
    if not isinstance(value, Robot):
        raise InputError(
            f"expected a Robot, got {type(value).__name__}", place="robot", remedy="robots.load(name_or_urdf)"
        )
    return value
