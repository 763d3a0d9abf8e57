"""`connect`: a certified path from one configuration to any of several goals, for any robot."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..numeric import float_array
from ..robots import Robot
from ..shapes import as_shapes
from ._packet_kernels import packet_of
from ._tree_model import Balls, Frames, body_pairs, cover, moving_frames, position_error, spans
from ._tree_room import Room, room_of
from ._world import allowed_rows, nearest_contact, solid_rows

Floats = NDArray[np.float64]
STEP = 1.0
"""Longest edge of a tree: 1 rad, or a slide by the robot's reach."""
RUNGS = (1 / 512, 1 / 1024, 0.0)
"""Margins the trees are grown with beyond the clearance asked for, in shares of the robot's reach (about 2, 1, 0 mm an arm)."""
COVER = 1 / 1024, 1 / 16384
"""How far the balls over a capsule may stand out, in shares of the reach; the second where the first leaves no way."""
CHUNK = 2000
START_BLOCKED, GOALS_BLOCKED = -2, -3
ROUNDS, TRIES, LEAST_GAIN = 3, 3, 0.03


@dataclass(frozen=True, slots=True, eq=False)
class TreeResult:
    """A path of joint motions that are straight between `waypoints` (m, n), or why there is none.

    `margin`: every body is certified to keep at least this distance (m) from obstacles all along the path: the clearance
    asked for, mostly more (and from the robot's other bodies by as much more than was asked for there).
    `iterations`: of the trees. `timings`: seconds for pack, grow, simplify, certify. `rung`: the extra margin (m) the path
    was found with.
    """

    solved: bool
    waypoints: Floats
    goal_index: int
    reason: str
    margin: float
    iterations: int
    timings: dict[str, float] = field(default_factory=dict)
    rung: float = 0.0


@dataclass(frozen=True, eq=False)
class _Model:
    """A robot packed for one fineness of its ball cover."""

    frames: Frames
    balls: Balls
    arrays: tuple[Any, ...]
    weight: Floats
    reach: float
    regions: dict[bytes, Any]


def connect(
    robot: Robot,
    start: ArrayLike,
    goals: ArrayLike,
    obstacles: Any = (),
    *,
    clearance: float = 0.0,
    self_clearance: float = 0.0,
    seed: int = 0,
    time_limit: float = 10.0,
    simplify: bool = True,
) -> TreeResult:
    """A path from `start` (n,) to one of `goals` (k, n) on which no body comes nearer than `clearance` (m) to an obstacle.

    Two trees of joint motions grow towards each other; the path is shortened, then certified between its points too (motion
    bounds, see docs/planner.md). Joints without limits are searched within half a turn of start and goals. The result is a
    value: `.solved`, `.reason`. Raises InputError for wrong shapes, limits violated at the start, or obstacles of a kind the
    trees cannot take. Source: RRT-Connect (Kuffner and LaValle 2000) with our certificate.
    """
    begin = perf_counter()
    n = robot.n_joints
    first = float_array(start, "start", last=n, ndim=1)
    ends = float_array(np.atleast_2d(np.asarray(goals, np.float64)), "goals", last=n, ndim=2)
    shapes = as_shapes(obstacles)
    return _Search(robot, first, ends, shapes, clearance, self_clearance, seed).run(simplify, begin, time_limit)


class _Search:
    """One call of `connect`: everything packed, then a ladder of margins."""

    def __init__(
        self,
        robot: Robot,
        start: Floats,
        goals: Floats,
        shapes: tuple[Any, ...],
        clearance: float,
        self_clearance: float,
        seed: int,
    ) -> None:
        self.robot, self.start, self.goals, self.shapes = robot, start, goals, shapes
        self.clearance, self.self_clearance = float(clearance), float(self_clearance)
        self.seed, self.iterations, self.deadline = int(seed), 0, math.inf
        self.timings: dict[str, float] = dict.fromkeys(("pack", "grow", "simplify", "certify"), 0.0)
        self.low, self.high = _region(robot, start, goals)
        self.rows = solid_rows(shapes)

    def run(self, simplify: bool, begin: float, time_limit: float) -> TreeResult:
        """Down the ladder of margins until a path is certified."""
        outside = _outside(self.robot, self.start)
        if outside:
            return self._failed(f"start: {outside}")
        inside = [g for g, goal in enumerate(self.goals) if not _outside(self.robot, goal)]
        if not inside:
            return self._failed(f"goal: {_outside(self.robot, self.goals[0])}")
        coarse, fine = COVER
        ladder = [(coarse, share, False) for share in RUNGS] + [(fine, 0.0, False), (fine, 0.0, True)]
        space, reason = None, "no path found"
        self.timings["pack"] = perf_counter() - begin
        for fineness, share, certified in ladder:
            if space is None or space.fineness != fineness:
                with _timed(self.timings, "pack"):
                    coarser, space = space, _Packed(self, fineness)
                if coarser is None:  # compiling, or reading compiled code, does not count
                    self.deadline = perf_counter() + time_limit
                elif space.model.balls.inflation == 0.0:  # balls only: nothing is finer now
                    continue
            rung = share * space.model.reach
            margins = space.margins(self.clearance + rung, self.self_clearance + rung)
            path, able = self._grow(space, inside, margins, certified, math.inf if certified else 2 * CHUNK)
            if path == START_BLOCKED:
                reason = self._why("start", self.start, space)
                continue
            if path == GOALS_BLOCKED:
                reason = self._why("goal", self.goals[inside[0]], space)
                continue
            if path <= 0:
                reason = f"no path found in {self.iterations} iterations"
                if perf_counter() > self.deadline:
                    return self._failed(f"{reason}: the time limit is over")
                continue
            result = self._finish(space, path, able, margins, simplify and not certified, rung)
            if result is not None:
                return result
            reason = "a path was found, but contact between its points could not be excluded"
        return self._failed(reason)

    def _grow(self, space: _Packed, inside: list[int], margins, certified: bool, most: float) -> tuple[int, list[int]]:
        """What `grow` says at last, and the goals that are clear."""
        from ._edge_kernels import CERTIFIED, SAMPLED
        from ._tree_kernels import grow

        room = space.room
        start, goals = space.scaled(self.start), space.scaled(self.goals[inside])
        order = np.zeros(len(inside), np.int64)
        with _timed(self.timings, "grow"):
            room.state[0] = -1
            samples = room.samples(self.seed)
            done = 0
            while True:
                found = grow(
                    space.packet, CHUNK, STEP, CERTIFIED if certified else SAMPLED, *margins, samples, space.low, space.high,
                    start, goals, order, room.tree, room.state, room.path, room.ramp, room.work,
                )  # fmt: skip
                done += CHUNK
                if found or done >= most or perf_counter() > self.deadline:
                    break
            self.iterations += max(int(room.state[0]), 0)
        return int(found), [inside[g] for g in order[: room.state[5]]]

    def _finish(self, space: _Packed, count: int, able: list[int], margins, shorten: bool, rung: float):
        from ._simplify_kernels import certify, simplify

        room = space.room
        if shorten and count > 2:
            with _timed(self.timings, "simplify"):
                count = simplify(space.packet, room.path, count, ROUNDS, TRIES, LEAST_GAIN, *margins, room.work)
        with _timed(self.timings, "certify"):
            for share in (
                (0.5, 0.0) if rung else (0.0,)
            ):  # most paths keep half of the extra margin between their points too
                extra = share * rung
                margins = space.margins(self.clearance + extra, self.self_clearance + extra)
                bad = certify(space.packet, room.path, count, *margins, room.work[0])
                if bad < 0:
                    break
            else:
                return None
        points = room.path[:count].astype(np.float64) / space.model.weight
        ends = [float(np.abs(room.path[count - 1] - space.scaled(self.goals[g])).max()) for g in able]
        goal = able[int(np.argmin(ends))]
        points[0], points[-1] = self.start, self.goals[goal]
        return TreeResult(True, points, goal, "", self.clearance + extra, self.iterations, self.timings, rung)

    def _why(self, what: str, q: Floats, space: _Packed) -> str:
        text = nearest_contact(self.robot, q, self.shapes, self.clearance, self.self_clearance)
        if text is None:
            text = f"clear, but by less than the {space.uncertainty * 1e6:.0f} um that the planner is uncertain by"
        return f"{what}: {text}"

    def _failed(self, reason: str) -> TreeResult:
        return TreeResult(False, np.zeros((0, self.robot.n_joints)), -1, reason, 0.0, self.iterations, self.timings)


class _Packed:
    """Robot, obstacles and working memory for compiled code, at one fineness of the ball cover."""

    def __init__(self, search: _Search, fineness: float) -> None:
        from ._world_kernels import pack_world

        self.model = model = _model(search.robot, fineness)
        self.fineness = fineness
        root, span, centre_error = _limits_of(model, search.low, search.high)
        margin = max(search.clearance, 0.0) + RUNGS[0] * model.reach + 1e-3
        *world, extent = pack_world(search.rows, root, span, margin, allowed_rows(model.balls.allowed, search.shapes))
        self.world = tuple(world)
        size = extent + float(np.abs(root).max() + span.max(initial=0.0))
        self.slack = 2.0 * centre_error + 16.0 * 2.0**-24 * size
        self.uncertainty = self.slack + model.balls.inflation
        self.room = room_of(search.robot.n_joints)
        self.scratch = self.room.scratch(
            len(model.frames.joints), len(model.balls.bodies), model.balls.groups, len(search.rows)
        )
        self.low, self.high = self.scaled(search.low), self.scaled(search.high)
        self.packet = packet_of(_edge_address(self.room), (model.arrays, self.world, self.scratch))

    def scaled(self, q: Floats) -> NDArray[np.float32]:
        """Coordinates in which one unit of any joint moves the robot about as far."""
        return np.ascontiguousarray(q * self.model.weight, np.float32)

    def margins(self, clearance: float, self_clearance: float) -> tuple[float, float]:
        """With what rounding may hide; of two moving balls twice that."""
        return clearance + self.slack, self_clearance + 2.0 * self.slack


def _region(robot: Robot, start: Floats, goals: Floats) -> tuple[Floats, Floats]:
    """Where to search: the limits; half a turn (or half the reach) around start and goals where there is none."""
    low, high = robot.limits.lower.copy(), robot.limits.upper.copy()
    everything = np.vstack([start[None], goals])
    free = ~np.isfinite(low)
    low[free] = everything.min(axis=0)[free] - np.pi
    free = ~np.isfinite(high)
    high[free] = everything.max(axis=0)[free] + np.pi
    return low, high


def _outside(robot: Robot, q: Floats) -> str | None:
    over = np.maximum(robot.limits.lower - q, q - robot.limits.upper)
    j = int(np.argmax(over)) if len(over) else 0
    if len(over) and over[j] > 1e-6:
        return f"joint {robot.joint_names[j]!r} is {over[j]:.3g} beyond its limits"
    return None


def _model(robot: Robot, fineness: float) -> _Model:
    key = f"planning tree {fineness:g}"
    if key in robot.memo:
        return robot.memo[key]
    frames = moving_frames(robot)
    low, high = _region(robot, np.zeros(robot.n_joints), np.zeros((1, robot.n_joints)))
    rough = cover(robot, frames, 1.0)
    reach = float(spans(frames, rough, low, high)[1].max(initial=0.0)) or 1.0
    balls = cover(robot, frames, fineness * reach)
    weight = np.ones(robot.n_joints)
    for (_, c), row in zip(frames.joints[1:], frames.data[1:]):
        if row[14]:  # a power of two: exact in binary
            weight[c] = 2.0 ** -round(math.log2(reach))
    data = frames.data.copy()
    data[1:, 12] /= weight[frames.joints[1:, 1]]
    data[1:, 14] /= weight[frames.joints[1:, 1]]
    pairs, group_pairs = body_pairs(robot, frames, balls)
    single = [np.ascontiguousarray(x, np.float32) for x in (data, balls.body_bounds, balls.bounds, balls.balls)]
    for array in single[1:]:
        array[:, 3] *= np.float32(1.0 + 1e-6)
    arrays = (frames.joints, single[0], balls.bodies, single[1], balls.groups, *single[2:], pairs, group_pairs)
    model = _Model(frames, balls, arrays, weight, reach, {})
    robot.memo[key] = model
    return model


def _limits_of(model: _Model, low: Floats, high: Floats) -> tuple[Floats, Floats, float]:
    """Root, spans and rounding error for a search region; the last one is kept."""
    key = low.tobytes() + high.tobytes()
    if key not in model.regions:
        root, span, lever = spans(model.frames, model.balls, low, high)
        model.regions.clear()
        model.regions[key] = root, span, position_error(model.frames, lever, span, root, low, high)
    return model.regions[key]


_ADDRESS: list[Any] = []


def _edge_address(room: Room) -> Any:
    """The compiled edge check; at the first call everything else is compiled, or read from the cache, too."""
    if not _ADDRESS:
        from ..kernels import address_of
        from ._edge_kernels import edge_clear
        from ._simplify_kernels import certify, simplify
        from ._tree_kernels import grow

        q, nothing = np.zeros(room.n, np.float32), np.zeros(1, np.int64)
        edge = address_of(edge_clear, q, q, 1, 0, 0.0, 0.0, nothing)
        packet = nothing if isinstance(edge, int) else packet_of(edge, ())
        room.state[0] = 1
        samples = np.zeros((1, room.n), np.float32)
        grow(
            packet, 0, STEP, 0, 0.0, 0.0, samples, q, q, q, q[None].copy(), room.state, room.tree, room.state, room.path,
            room.ramp, room.work,
        )  # fmt: skip
        simplify(packet, room.path, 0, 0, 0, 0.0, 0.0, 0.0, room.work)
        certify(packet, room.path, 0, 0.0, 0.0, room.work[0])
        _ADDRESS.append(edge)
    return _ADDRESS[0]


class _timed:
    """Adds the seconds of a block to an entry of a dict."""

    def __init__(self, timings: dict[str, float], name: str) -> None:
        self.timings, self.name = timings, name

    def __enter__(self) -> None:
        self.begin = perf_counter()

    def __exit__(self, *_: object) -> None:
        self.timings[self.name] += perf_counter() - self.begin
