"""A robot among obstacles as the tree planner's compiled code sees it: one packet."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..robots import Robot
from ._packet_kernels import (
    ALLOWED_AT,
    CHUNK,
    FINISH,
    PACK,
    PAUSED,
    RESUME,
    SAMPLES_AT,
    WORLD_AT,
    PlainPacket,
    packet_of,
    words_of,
)
from ._tree_model import Balls, Frames, body_pairs, cover, moving_frames, position_error, spans
from ._tree_room import Room, room_of
from ._world import allowed_rows

if TYPE_CHECKING:
    from ._tree import Search

Floats = NDArray[np.float64]
RUNGS = (1 / 512, 1 / 1024, 0.0)
"""Margins the trees are grown with beyond the clearance asked for, in shares of the robot's reach (about 2, 1, 0 mm an arm)."""
COVER = 1 / 1024, 1 / 16384
"""How far the balls over a capsule may stand out, in shares of the reach; the second where the first leaves no way."""
NEVER = 2**62
"""Nanoseconds: no end to the time of `plan`."""
NONE_ALLOWED = np.zeros((0, 0), np.uint8)


@dataclass(frozen=True, eq=False)
class Model:
    """A robot packed for one fineness of its ball cover."""

    frames: Frames
    balls: Balls
    arrays: tuple[Any, ...]
    weight: Floats
    reach: float
    most: int
    """Balls in one group."""
    rungs: Floats
    """Of `plan`: the ladder of margins with this cover."""
    is_bounded: bool
    """Every joint has limits: there is but one region to search."""
    regions: list[Region] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class Region:
    """What the region of a search, from `lower` to `upper` (n,), means for a model.

    `low`, `high`: the same as compiled code counts. `root` (3,), `span` (C,): see `spans`. `slack`: twice the rounding error (m) of a
    ball's centre. `size`: how far from the origin any body comes (m).
    """

    lower: Floats
    upper: Floats
    low: NDArray[np.float32]
    high: NDArray[np.float32]
    root: Floats
    span: Floats
    slack: float
    size: float


class Space:
    """Robot, obstacles and working memory for compiled code, at one fineness of the ball cover.

    The scene is packed by the first `run`, or by `pack`. The arrays of the room serve all spaces of a thread: `run` fills them.
    """

    def __init__(self, search: Search, fineness: float) -> None:
        self.search, self.fineness = search, fineness
        self.model = model = model_of(search.robot, fineness)
        self.region = region = _region_of(search.robot, model, search.start, search.goals)
        self.low, self.high = region.low, region.high
        self.room = room = room_of(search.robot.n_joints)
        self.slack = 0.0
        solids, bodies = len(search.rows), len(model.balls.bodies)
        room.reserve(solids, len(search.goals))
        self.scratch = room.scratch(len(model.frames.joints), bodies, model.most)
        template = _template(room, model, region, self.scratch, search.seed)
        lists, reach, allowed = np.empty(56 * solids, np.float32), np.empty((bodies, 10), np.int64), NONE_ALLOWED
        if any(model.balls.allowed):
            allowed = allowed_rows(model.balls.allowed, search.shapes)
        self.memory = (
            lists,
            reach,
            allowed,
            room.samples(search.seed),
            room.rows,
            room.ends,
        )  # the packet points at them
        if isinstance(template, PlainPacket):
            cuts = np.split(lists, np.array([8, 24, 32, 40]) * solids)
            world = *(cut.reshape(solids, w) for cut, w in zip(cuts, (8, 16, 8, 8, 16))), reach
            self.packet = template.with_scene(world, allowed)
            return
        self.packet = template.copy()
        at = lists.__array_interface__["data"][0]
        self.packet[WORLD_AT : WORLD_AT + 18] = (
            at, solids, 8, at + 32 * solids, solids, 16, at + 96 * solids, solids, 8, at + 128 * solids, solids, 8,
            at + 160 * solids, solids, 16, reach.__array_interface__["data"][0], bodies, 10,
        )  # fmt: skip
        if len(allowed):
            self.packet[ALLOWED_AT : ALLOWED_AT + 3] = words_of((allowed,))

    def scaled(self, q: Floats) -> NDArray[np.float32]:
        """Coordinates in which one unit of any joint moves the robot about as far."""
        return np.ascontiguousarray(q * self.model.weight, np.float32)

    @property
    def uncertainty(self) -> float:
        """By how much (m) a body may seem nearer than it is."""
        return self.slack + self.model.balls.inflation

    def margins(self, clearance: float, self_clearance: float) -> tuple[float, float]:
        """With what rounding may hide; of two moving balls twice that."""
        return clearance + self.slack, self_clearance + 2.0 * self.slack

    def use_samples(self, seed: int) -> None:
        """Trees of another seed."""
        samples = self.room.samples(seed)
        self.memory = *self.memory[:3], samples, *self.memory[4:]
        if isinstance(self.packet, PlainPacket):
            self.packet = self.packet.with_samples(samples)
        else:
            self.packet[SAMPLES_AT : SAMPLES_AT + 3] = words_of((samples,))

    def pack(self) -> Space:
        """The scene for compiled code, and nothing else."""
        self.run(PACK, np.zeros((0, 4)))
        return self

    def run(
        self,
        stage: int,
        rungs: Any,
        *,
        goals: Floats | None = None,
        points: int = 0,
        first: int = 0,
        shorten: bool = False,
        deadline: float = math.inf,
    ) -> int:
        """What `plan` says from `stage` on; what it tells beside is in `room.progress`.

        `rungs`: rows (k, 4) of `plan`. `goals` (k, n), `deadline` (`perf_counter_ns`): of trees. `points`, `first`: of a path
        in `room.path`.
        """
        from ._plan_kernels import plan

        room, search, model, region = self.room, self.search, self.model, self.region
        solids, ends = 0, 0
        if stage == PACK:
            solids = len(search.rows)
            room.rows[:solids] = search.rows
        if stage < FINISH and goals is not None:
            ends = len(goals)
            room.ends[0] = search.start * model.weight
            room.ends[1 : ends + 1] = goals * model.weight
        margin = max(search.clearance, 0.0) + RUNGS[0] * model.reach + 1e-3
        room.settings[:] = search.clearance, search.self_clearance, margin, region.slack, region.size, self.slack
        room.rungs[: len(rungs)] = rungs
        until = int(min(deadline, NEVER))
        room.progress[:] = solids, ends, len(rungs), 0, points, shorten, first, 0, 0, until, 0, 0, 0, 0
        outcome = plan(self.packet, stage)
        while outcome == PAUSED:
            outcome = plan(self.packet, RESUME)
        if stage == PACK:
            self.slack = float(room.settings[5])
        return int(outcome)


def _template(room: Room, model: Model, region: Region, scratch: tuple[Any, ...], seed: int) -> Any:
    """The packet for these without a scene; the last one is kept."""
    samples = room.samples(seed)
    key = model, region, scratch, samples, room.rows, room.ends
    if len(room.kept[0]) != len(key) or any(a is not b for a, b in zip(room.kept[0], key)):
        search = (
            samples,
            region.low,
            region.high,
            room.ends,
            room.order,
            room.nodes,
            room.parents,
            room.radii,
            room.state,
            room.path,
        )
        scene = room.rows, region.root, region.span, NONE_ALLOWED, room.near, room.kinds, room.ranks, room.number
        task = room.settings, room.rungs, room.progress
        world = (NONE_ALLOWED,) * 6
        room.kept = key, packet_of(_functions(), (model.arrays, world, scratch, search, scene, task))
    return room.kept[1]


def model_of(robot: Robot, fineness: float) -> Model:
    key = f"planning tree {fineness:g}"
    if key in robot.memo:
        return robot.memo[key]
    frames = moving_frames(robot)
    low, high = _limits(robot, np.zeros(robot.n_joints), np.zeros((1, robot.n_joints)))
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
    most = int((balls.groups[:, 1] - balls.groups[:, 0]).max(initial=0))
    rungs = np.array([[share * reach, share * reach, 2 * CHUNK, 0] for share in RUNGS])
    is_bounded = bool(np.isfinite([robot.limits.lower, robot.limits.upper]).all())
    model = Model(frames, balls, arrays, weight, reach, most, rungs, is_bounded)
    robot.memo[key] = model
    return model


def _limits(robot: Robot, start: Floats, goals: Floats) -> tuple[Floats, Floats]:
    """Where to search: the limits; half a turn (or half the reach) around start and goals where there is none."""
    low, high = robot.limits.lower.copy(), robot.limits.upper.copy()
    everything = np.vstack([start[None], goals])
    free = ~np.isfinite(low)
    low[free] = everything.min(axis=0)[free] - np.pi
    free = ~np.isfinite(high)
    high[free] = everything.max(axis=0)[free] + np.pi
    return low, high


def _region_of(robot: Robot, model: Model, start: Floats, goals: Floats) -> Region:
    """The last one is kept."""
    if model.regions and model.is_bounded:
        return model.regions[-1]
    low, high = _limits(robot, start, goals)
    for known in model.regions:
        if np.array_equal(known.lower, low) and np.array_equal(known.upper, high):
            return known
    root, span, lever = spans(model.frames, model.balls, low, high)
    low32, high32 = (np.ascontiguousarray(q * model.weight, np.float32) for q in (low, high))
    slack = 2.0 * position_error(model.frames, lever, span, root, low, high)
    region = Region(low, high, low32, high32, root, span, slack, float(np.abs(root).max() + span.max(initial=0.0)))
    model.regions[:] = [region]
    return region


_FUNCTIONS: list[tuple[Any, ...]] = []


def _functions() -> tuple[Any, ...]:
    """The addresses of a packet; at the first call everything is compiled, or read from the cache."""
    if not _FUNCTIONS:
        from ..kernels import address_of
        from ._edge_kernels import edge_clear
        from ._plan_kernels import pack_scene, plan
        from ._simplify_kernels import certify, simplify
        from ._tree_kernels import grow

        q, packet = np.zeros(1, np.float32), np.zeros(1, np.int64)
        functions = (
            address_of(edge_clear, q, q, 1, 0, 0.0, 0.0, packet),
            address_of(pack_scene, packet),
            address_of(grow, packet, 0, 0, 0, 0.0, 0.0),
            address_of(simplify, packet, 0, 0, 0, 0.0, 0.0, 0.0),
            address_of(certify, packet, 0, 0, 0.0, 0.0),
        )
        if isinstance(functions[0], int):
            from numba import typeof

            plan.compile((typeof(packet), typeof(0)))
        _FUNCTIONS.append(functions)
    return _FUNCTIONS[0]
