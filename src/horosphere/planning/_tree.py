"""`connect`: a certified path from one configuration to any of several goals, for any robot."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import perf_counter_ns
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array, number, whole_number
from ..robots import Robot
from ..robots._robot import require_robot
from ..shapes import Shape, as_shapes
from ._packet_kernels import CHUNK, GOALS_BLOCKED, NOT_CERTIFIED, PACK, START_BLOCKED, TIME_OVER
from ._tree_space import COVER, Space
from ._world import nearest_contact, solid_rows

Floats = NDArray[np.float64]
LIMIT_SLACK = 1e-6
"""How far beyond its limits a joint may be (rad, m) at the start and at a goal."""
FINE = np.array([[0.0, 0.0, 2 * CHUNK, 0], [0.0, 0.0, math.inf, 1]])
"""Rungs for the fine cover: samples, then a certificate of every edge while the trees grow."""
PARTS = "pack", "grow", "simplify", "certify"


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
    bounds, see docs/planner.md). Joints without limits are searched within half a turn of start and goals. `time_limit`:
    seconds. The result is a value: `.solved`, `.reason`, also where an end is outside its limits or not clear. Raises
    InputError for wrong shapes, numbers that are not finite, or obstacles of a kind the trees cannot take. Source:
    RRT-Connect (Kuffner and LaValle 2000) with our certificate.
    """
    begin = perf_counter_ns()
    search = Search(robot, start, goals, as_shapes(obstacles), clearance, self_clearance, seed)
    return search.run(simplify, begin, checked_seconds(time_limit))


def checked_seconds(time_limit: float) -> float:
    """A time limit, where infinity is none. Raises InputError."""
    return number(time_limit, "time_limit")


class Search:
    """One call of `connect`: what is asked, and how what compiled code finds becomes a result."""

    def __init__(
        self,
        robot: Robot,
        start: ArrayLike,
        goals: ArrayLike,
        shapes: tuple[Shape, ...],
        clearance: float,
        self_clearance: float,
        seed: int,
    ) -> None:
        n = require_robot(robot).n_joints
        self.robot, self.start, self.shapes = robot, float_array(start, "start", last=n, ndim=1), shapes
        self.goals = np.atleast_2d(float_array(goals, "goals", last=n))
        if self.goals.ndim > 2 or not len(self.goals):
            raise InputError(f"expected one or more goals (k, {n}), got shape {self.goals.shape}", place="goals")
        self.clearance = float(float_array(clearance, "clearance", ndim=0))
        self.self_clearance = float(float_array(self_clearance, "self_clearance", ndim=0))
        self.seed, self.iterations = whole_number(seed, "seed", 0), 0
        self.timings: dict[str, float] = dict.fromkeys(PARTS, 0.0)
        self.rows = solid_rows(shapes)

    def run(self, simplify: bool, begin: int, time_limit: float) -> TreeResult:
        """Down the ladder of margins until a path is certified; what is beyond the coarse cover of the robot, in a second call."""
        inside = self.inside()
        if isinstance(inside, str):
            return self.failed(inside)
        goals = self.goals if len(inside) == len(self.goals) else self.goals[inside]
        space, outcome, deadline = None, 0, 0
        for fineness in COVER:
            coarser, space = space, Space(self, fineness)
            if coarser is None:  # compiling, or reading compiled code, does not count
                deadline = perf_counter_ns() + 1e9 * time_limit
                self.timings["pack"] = 1e-9 * (perf_counter_ns() - begin)
                rungs = space.model.rungs
            else:
                rungs = FINE if space.model.balls.inflation else FINE[1:]  # balls only: nothing is finer now
            outcome = space.run(PACK, rungs, goals=goals, shorten=simplify, deadline=deadline)
            self.count(space)
            if outcome > 0:
                return self.found(space, outcome, inside)
            if outcome == TIME_OVER:
                break
        assert space is not None
        return self.failed(self.reason(outcome, inside, space))

    def inside(self) -> list[int] | str:
        """The goals within the limits, or what is wrong."""
        limits, goals, memo = self.robot.limits, self.goals, self.robot.memo
        if "planning limits" not in memo:
            memo["planning limits"] = limits.lower - LIMIT_SLACK, limits.upper + LIMIT_SLACK
        low, high = memo["planning limits"]
        if ((self.start >= low) & (self.start <= high)).all() and ((goals >= low) & (goals <= high)).all():
            return list(range(len(goals)))
        outside = _outside(self.robot, self.start)
        if outside:
            return f"start: {outside}"
        reasons = [_outside(self.robot, goal) for goal in goals]
        inside = [g for g, reason in enumerate(reasons) if not reason]
        return inside or f"goal: {reasons[0]}"

    def count(self, space: Space) -> None:
        """Iterations and times of a run of `plan`."""
        *_, iterations, _, _, pack, grow, simplify, certify = space.room.progress.tolist()
        self.iterations += iterations
        for part, time in zip(PARTS, (pack, grow, simplify, certify)):
            self.timings[part] = self.timings.get(part, 0.0) + 1e-9 * time

    def found(self, space: Space, count: int, inside: list[int]) -> TreeResult:
        """The path of `count` points that `plan` has left."""
        room = space.room
        _, goals, _, rung, _, _, _, _, halves, *_ = room.progress.tolist()
        points = room.path[:count] / space.model.weight
        goal = inside[0]
        if len(inside) > 1 and goals:
            able = room.order[: room.state[5]]
            gaps = np.abs(room.path[count - 1] - room.ends[1 + able]).max(axis=1)
            goal = inside[int(able[np.argmin(gaps)])]
        points[0], points[-1] = self.start, self.goals[goal]
        extra = float(room.rungs[rung, 0])
        margin = self.clearance + 0.5 * halves * extra
        return TreeResult(True, points, goal, "", margin, self.iterations, self.timings, extra)

    def reason(self, outcome: int, inside: list[int], space: Space) -> str:
        """In words, what `plan` says."""
        if outcome == NOT_CERTIFIED:
            return "a path was found, but contact between its points could not be excluded"
        if outcome in (START_BLOCKED, GOALS_BLOCKED):
            what, q = ("start", self.start) if outcome == START_BLOCKED else ("goal", self.goals[inside[0]])
            text = nearest_contact(self.robot, q, self.shapes, self.clearance, self.self_clearance)
            if text is None:
                text = f"clear, but by less than the {space.uncertainty * 1e6:.0f} um that the planner is uncertain by"
            return f"{what}: {text}"
        late = ": the time limit is over" if outcome == TIME_OVER else ""
        return f"no path found in {self.iterations} iterations{late}"

    def failed(self, reason: str) -> TreeResult:
        """No path."""
        return TreeResult(False, np.zeros((0, self.robot.n_joints)), -1, reason, 0.0, self.iterations, self.timings)


def _outside(robot: Robot, q: Floats) -> str | None:
    over = np.maximum(robot.limits.lower - q, q - robot.limits.upper)
    j = int(np.argmax(over)) if len(over) else 0
    if len(over) and over[j] > LIMIT_SLACK:
        return f"joint {robot.joint_names[j]!r} is {over[j]:.3g} beyond its limits"
    return None
