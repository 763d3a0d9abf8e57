"""`react`: a path without a search, by the reactive law from either end, over via poses where it gets stuck."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..robots import Robot
from ..shapes import as_shapes
from ._packet_kernels import FINISH
from ._tree import Search, TreeResult, checked_seconds
from ._tree_room import halton
from ._tree_space import COVER, RUNGS, Space
from ._world import nearest_contact

Floats = NDArray[np.float64]
STEP = 0.1
"""Longest step of the law: 0.1 rad, or a tenth of the reach of sliding."""
SIGHT = 1 / 16
"""How near something must be to be heeded, as a share of the robot's reach (7 cm an arm)."""
SELF_SIGHT = 1 / 40
GAIN, SWEEPS, MOST, ROWS = 0.8, 10, 150, 96
VIAS = 128
"""Via poses tried: the middle of the limits turned towards either end, then points of a Halton sequence."""


def react(
    robot: Robot,
    start: ArrayLike,
    goals: ArrayLike,
    obstacles: Any = (),
    *,
    clearance: float = 0.0,
    self_clearance: float = 0.0,
    vias: int = VIAS,
    time_limit: float = 10.0,
) -> TreeResult:
    """As `connect`, without a tree: towards the start from each goal, from the start, then both ends to via poses.

    The law goes straight to its aim as far as no body approaches anything faster than its gap allows (a hard barrier). What it
    finds is shortened only where it went over a via pose, and certified as the tree's paths are. `vias=0`: the law alone.
    """
    begin, time_limit = perf_counter(), checked_seconds(time_limit)
    search = Search(robot, start, goals, as_shapes(obstacles), clearance, self_clearance, 0)
    search.timings = dict.fromkeys(("pack", "follow", "simplify", "certify"), 0.0)
    inside = search.inside()
    if isinstance(inside, str):
        return search.failed(inside)
    space = Space(search, COVER[0]).pack()
    law = _Law(search, space)
    search.timings["pack"] = perf_counter() - begin
    deadline = perf_counter() + time_limit
    found = None
    for share in RUNGS[1:]:
        rung = share * space.model.reach
        margins = space.margins(search.clearance + rung, search.self_clearance + rung)
        found = law.run(inside, margins, vias, deadline, rung)
        if found is not None or perf_counter() > deadline:
            break
    return found or search.failed(_why(search, inside))


def _why(search: Search, inside: list[int]) -> str:
    """Why there is no path: an end that is not free, if there is one."""

    def contact(q: Floats) -> str | None:
        return nearest_contact(search.robot, q, search.shapes, search.clearance, search.self_clearance)

    blocked = [contact(search.goals[g]) for g in inside]
    if text := contact(search.start):
        return f"start: {text}"
    if all(blocked):
        return f"goal: {blocked[0]}"
    return "the reactive law got stuck from both ends and at every via pose"


class _Law:
    """The attempts of one call, in their order."""

    def __init__(self, search: Search, space: Space) -> None:
        self.search, self.space = search, space
        n, balls = search.robot.n_joints, -(-len(space.model.balls.balls) // 16) * 16
        single = np.float32
        points = np.zeros((4, balls), single)
        points[0] = 1e3  # the padding is far from everything
        groups = len(space.model.balls.groups)
        self.room = (
            points,
            np.zeros(balls, single),
            np.zeros((ROWS, n), single),
            np.zeros(ROWS),
            np.zeros(ROWS),
            np.zeros(ROWS),
            np.zeros(n, single),
            np.zeros(n, single),
            np.zeros(48, single),
            np.zeros((3, groups), single),
            np.zeros(groups, np.int64),
        )

    def run(
        self, inside: list[int], margins: tuple[float, float], vias: int, deadline: float, rung: float
    ) -> TreeResult | None:
        """A certified path, or None."""
        search, space = self.search, self.space
        start = space.scaled(search.start)
        path = space.room.path
        for g in inside:
            goal = space.scaled(search.goals[g])
            for back in (True, False):
                legs = (goal, start) if back else (start, goal)
                points = self._leg(*legs, margins)
                if points is not None:
                    path[: len(points)] = points[::-1] if back else points
                    found = self._finish(len(points), g, False, rung)
                    if found is not None:
                        return found
        for via_start, via_goal in self._vias(start, space.scaled(search.goals[inside[0]]), vias):
            if perf_counter() > deadline:
                return None
            for g in inside:
                goal = space.scaled(search.goals[g])
                into = self._leg(goal, via_goal, margins)
                out = None if into is None else self._leg(start, via_start, margins)
                if into is None or out is None:
                    continue
                between = self._leg(via_start, via_goal, margins) if (via_start != via_goal).any() else out[-1:]
                if between is None:
                    continue
                points = np.concatenate([out, between[1:], into[-2::-1]])
                if len(points) > len(path):
                    continue
                path[: len(points)] = points
                found = self._finish(len(points), g, True, rung)
                if found is not None:
                    return found
        return None

    def _finish(self, count: int, goal: int, shorten: bool, rung: float) -> TreeResult | None:
        """The path of `count` points, shortened and certified."""
        rungs = np.array([[rung, rung, 0, 0]])
        count = self.space.run(FINISH, rungs, points=count, shorten=shorten)
        self.search.count(self.space)
        return self.search.found(self.space, count, [goal]) if count > 0 else None

    def _leg(self, a: Any, b: Any, margins: tuple[float, float]) -> NDArray[np.float32] | None:
        from ._reactive_kernels import follow

        space = self.space
        path = space.room.path
        path[0] = a
        barrier = max(margins)
        sights = SIGHT * space.model.reach, SELF_SIGHT * space.model.reach
        begin = perf_counter()
        count = follow(
            space.packet, b, 1, MOST, STEP, *sights, GAIN, barrier, SWEEPS, space.low, space.high, path, *margins,
            space.room.work[0], self.room,
        )  # fmt: skip
        self.search.timings["follow"] += perf_counter() - begin
        self.search.iterations += abs(count)
        return path[:count].copy() if count > 0 else None

    def _vias(self, start: Any, goal: Any, count: int):
        """Pairs of via poses for the two ends; nothing here knows the robot."""
        low, high = self.space.low, self.space.high
        middle = 0.5 * (low + high)
        if count > 0:
            towards_start, towards_goal = middle.copy(), middle.copy()
            towards_start[0], towards_goal[0] = start[0], goal[0]
            yield towards_start, towards_goal
            yield towards_goal, towards_goal
            yield towards_start, towards_start
        for share in halton(max(count - 3, 0), len(low)):
            via = np.float32(low + share * (high - low))
            yield via, via
