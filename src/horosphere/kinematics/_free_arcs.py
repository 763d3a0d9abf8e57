"""The part of a redundancy on which a branch keeps its joints inside the limits and its bodies clear, decided between samples too.

Pieces of a branch are enclosed in tubes of joint space (`_tube_kernels`) and judged whole (`_arc_kernels`); those that are
neither free nor blocked are halved. What cannot be decided above the resolution counts as not free.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..distance import allowance, pack_obstacles, pack_robot, rounding_slack, table
from ..errors import InputError
from ..numeric import float_array
from ._arcs import Arcs
from ._redundant import Redundancy, redundancy

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Integers = NDArray[np.int64]
_POSE = 1e-9  # metres: how far closed forms may have the tool from its pose
_FIRST = 4  # pieces of an interval to begin with
_EDGE = 1e-5  # of theta: how near to the end of an interval its first piece begins
_SHORTEST = np.array([1e-4, 1e-7])  # of theta: pieces with an end where the branch does not exist, and all others


def free_arcs(
    robot: Any,
    target: Any,
    obstacles: Any = (),
    clearance: float = 0.0,
    *,
    self_clearance: float | None = None,
    limits: bool = True,
    resolution: float = 1e-3,
) -> tuple[Arcs, ...]:
    """For every branch the values of its redundancy (psi, q7, q1 or phi) at which it exists, keeps inside the joint limits and
    its bodies at least `clearance` metres from the obstacles.

    target: one pose, or one GripperOnPlane of the 5-DOF humanoid arm. obstacles: what `shapes.as_shapes` takes, all kinds; as in
    `certify`, bodies that no joint moves meet none, and contacts that the robot allows are not looked at. self_clearance: the
    metres wanted between its own links (`robot.self_pairs`); None leaves these out. Rows in the order of `inverse(...).branch`.

    Where branches begin and end to exist is in closed form; the rest is sampled and proved between the samples, in float64 with
    a rounding slack: all of a returned arc is free. Parts that cannot be decided in pieces of `resolution` radians of joint motion
    (at least 1e-6) count as not free: an arc may end that much early, and one shorter than that may be missed. A tenth of it
    costs three to four halvings more at each end of an arc, a few per cent of the time.
    Our derivation, docs/inverse-kinematics.md. Raises InputError for a robot without redundancy and a batch of targets.
    """
    if not resolution >= 1e-6:
        raise InputError(f"expected a resolution of at least 1e-6 radians, got {resolution}", place="resolution")
    return proved_arcs(redundancy(robot, target), obstacles, clearance, self_clearance, limits, resolution)


def proved_arcs(
    one: Redundancy,
    obstacles: Any,
    clearance: float,
    self_clearance: float | None,
    limits: bool = True,
    resolution: float = 1e-3,
) -> tuple[Arcs, ...]:
    """`free_arcs` of a redundancy."""
    room = _Room.of(one, obstacles, clearance, self_clearance, limits)
    words = (
        "no value keeps this branch " + ", ".join(room.wishes[:-1]) + " and " * (len(room.wishes) > 1) + room.wishes[-1]
    )
    q, exists = one.rows(0.5 * (one.ends[1:] + one.ends[:-1]))
    if exists.any():
        contact = room.contact_of_the_tool(q[exists][0])
        if contact:
            return (Arcs(np.zeros((0, 2)), contact, one.parameter),) * one.branches
    pieces = _Pieces.first(one, exists)
    free = []
    while len(pieces.low):
        centre = 0.5 * (pieces.low + pieces.high)
        between, exists = _postures(one, pieces, centre)
        state, chord = room.judged(pieces, between, exists)
        found = state == _FREE
        free.append(np.array([x[found] for x in (pieces.branch, pieces.interval, pieces.low, pieces.high)]))
        width, whole = pieces.high - pieces.low, pieces.starts & pieces.ends & exists
        split = (state < _OUTSIDE) & ((chord > resolution) | (width > 0.05)) & (width > _SHORTEST[whole.astype(int)])
        pieces = pieces.halved(split, centre, between, exists)
    branch, interval, low, high = np.concatenate([np.zeros((4, 0)), *free], axis=1)
    low, high = (_value(one, interval.astype(np.int64), theta) for theta in (low, high))
    return tuple(_joined(low[branch == j], high[branch == j], words, one.parameter) for j in range(one.branches))


_INSIDE, _OUTSIDE, _FREE, _BLOCKED = 1, 3, 4, 5  # states of pieces, see `_tube_kernels` and `_arc_kernels`


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """Pieces of branches: postures a, b (m, n) at theta = low and high, whether the branch exists there.

    An interval in which a branch exists is run through by theta in [0, pi], value = middle - half cos(theta): finite speed
    where branches merge. theta beyond pi goes on in the next interval, for the piece that joins both.
    """

    interval: Integers
    branch: Integers
    low: Floats
    high: Floats
    a: Floats
    b: Floats
    starts: Bools
    ends: Bools

    @staticmethod
    def first(one: Redundancy, exists: Bools) -> _Pieces:
        """All pieces to begin with; exists (intervals, branches)."""
        nodes = np.linspace(_EDGE, np.pi - _EDGE, _FIRST + 1)
        nodes = np.array([[*nodes[:-1], np.pi - _EDGE], [*nodes[1:], np.pi + _EDGE]])
        interval, branch = np.nonzero(exists)
        joined = (exists & np.roll(exists, -1, axis=0))[interval, branch]
        keep = np.ones((len(interval), _FIRST + 1), bool)
        keep[:, -1] = joined
        keep = keep.ravel()
        low, high = (np.tile(part, len(interval))[keep] for part in nodes)
        interval, branch = (np.repeat(x, _FIRST + 1)[keep] for x in (interval, branch))
        nothing = np.zeros((len(low), 0)), np.zeros(len(low), bool)
        bare = _Pieces(interval, branch, low, high, nothing[0], nothing[0], nothing[1], nothing[1])
        (a, starts), (b, ends) = _postures(one, bare, low), _postures(one, bare, high)
        return _Pieces(interval, branch, low, high, a, b, starts, ends)

    def halved(self, which: Bools, centre: Floats, between: Floats, exists: Bools) -> _Pieces:
        """Both halves of the pieces that are picked."""
        theta, q, there = centre[which], between[which], exists[which]
        both = lambda x, y: np.concatenate([x, y])
        return _Pieces(
            np.tile(self.interval[which], 2), np.tile(self.branch[which], 2), both(self.low[which], theta),
            both(theta, self.high[which]), both(self.a[which], q), both(q, self.b[which]),
            both(self.starts[which], there), both(there, self.ends[which]),
        )  # fmt: skip


def _value(one: Redundancy, interval: Any, theta: Floats) -> Floats:
    """The redundancy at theta of an interval; beyond the last one it goes on past pi."""
    over = theta > np.pi
    k = interval + over
    turn = k == len(one.ends) - 1
    k = np.where(turn, 0, k)
    low, high = one.ends[k], one.ends[k + 1]
    return 0.5 * (low + high) - 0.5 * (high - low) * np.cos(theta - np.pi * over) + 2.0 * np.pi * turn


def _postures(one: Redundancy, pieces: _Pieces, theta: Floats) -> tuple[Floats, Bools]:
    """The posture (m, n) of each piece's branch at theta (m,), and whether it exists."""
    q, exists = one.rows(_value(one, pieces.interval, theta))
    pick = np.arange(len(theta))
    return q[pick, pieces.branch], exists[pick, pieces.branch]


@dataclass(frozen=True, slots=True, eq=False)
class _Room:
    """What pieces are judged by: the arrays of the compiled loops, made once for a call."""

    one: Redundancy
    obstacles: Any
    body: Any
    solids: Any
    pairs: Integers
    decided: Bools  # (capsules, rows) pairs that may touch, or that no motion of the redundancy changes
    free_to_touch: Bools
    lower: Floats
    upper: Floats
    need: float
    own: float
    wishes: tuple[str, ...]

    @staticmethod
    def of(one: Redundancy, obstacles: Any, clearance: float, self_clearance: float | None, limits: bool) -> _Room:
        robot = one.robot
        clearance = float(float_array(clearance, "clearance", ndim=0))
        own = 0.0 if self_clearance is None else float(float_array(self_clearance, "self_clearance", ndim=0))
        body, solids = pack_robot(robot, static=False), pack_obstacles(() if obstacles is None else obstacles)
        touch = allowance(robot, solids)
        if touch is None:
            touch = np.zeros((len(body.capsules), len(solids.rows)), bool)
        held = body.frames == (one.path[-1] if one.holds_tool else -2)
        slack = rounding_slack(body, solids, np.full((1, robot.n_joints), 2.0 * np.pi))[0] + _POSE
        unlimited = np.full(robot.n_joints, np.inf)
        wishes = ["inside the joint limits" if limits else "within reach"]
        if len(solids.rows):
            wishes.append(f"{clearance:g} m from the obstacles" if clearance else "clear of the obstacles")
        if self_clearance is not None:
            wishes.append(f"with its links {own:g} m apart" if own else "with its links clear of each other")
        return _Room(
            one, obstacles, body, solids, body.pairs if self_clearance is not None else body.pairs[:0],
            np.ascontiguousarray(touch | held[:, None]), touch | ~held[:, None],
            robot.limits.lower.copy() if limits else -unlimited, robot.limits.upper.copy() if limits else unlimited,
            clearance + slack, own + slack, tuple(wishes),
        )  # fmt: skip

    def contact_of_the_tool(self, q: Floats) -> str:
        """What stands still with the tool and is too near to an obstacle at every value, in words, or ""."""
        if self.free_to_touch.all():
            return ""
        state = np.array([_INSIDE])
        self._judge(self.free_to_touch, self.pairs[:0], q[None].copy(), np.zeros((1, len(q))), np.zeros(1), state)
        if state[0] != _BLOCKED:
            return ""
        robot = self.one.robot
        found = table(robot, q, self.obstacles)
        gap = np.where((self.body.frames == self.one.path[-1])[:, None], found.distance, np.inf)
        i, j = np.unravel_index(np.argmin(gap), gap.shape)
        return f"{found.links[i]} is {gap[i, j]:.4g} m from {found.obstacles[j]} in this pose, at every value"

    def judged(self, pieces: _Pieces, between: Floats, exists: Bools) -> tuple[Integers, Floats]:
        """The state (m,) of each piece and the length of its chord."""
        from ._tube_kernels import enclose

        one, count = self.one, len(between)
        middle, half, reach = np.empty_like(between), np.empty_like(between), np.zeros(count)
        state = np.where(exists & pieces.starts & pieces.ends, _INSIDE, 0)
        enclose(
            *self.body[:4], one.path, one.tool, one.normal, one.span, one.levers, self.lower, self.upper,
            pieces.a, pieces.b, between, middle, half, reach, state,
        )  # fmt: skip
        self._judge(self.decided, self.pairs, middle, half, reach, state)
        return state, 2.0 * np.sqrt((half * half).sum(axis=-1))

    def _judge(self, decided: Bools, pairs: Integers, middle: Floats, half: Floats, reach: Floats, state: Integers):
        from ._arc_kernels import judge

        extra = (*self.solids.extra, decided)
        judge(*self.body[:4], self.solids.rows, pairs, extra, self.need, self.own, middle, half, reach, state)


def _joined(low: Floats, high: Floats, words: str, parameter: str) -> Arcs:
    """Touching pieces made one; those through pi are cut there."""
    over = high > np.pi
    low, high = np.append(low, np.maximum(low[over], np.pi) - 2.0 * np.pi), np.append(high, high[over] - 2.0 * np.pi)
    low, high = low[low < np.pi], np.minimum(high, np.pi)[low < np.pi]
    order = np.argsort(low)
    low, high = low[order], np.maximum.accumulate(high[order])
    apart = low[1:] > high[:-1] + 1e-14
    free = np.stack([low[np.append(True, apart)[: len(low)]], high[np.append(apart, True)[: len(low)]]], axis=1)
    return Arcs(free, "" if len(free) else words, parameter)
