"""`horosphere bench`: the planner on the problems of MotionBenchMaker, or on random ones for any robot."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..certify import clearance_bound
from ..errors import InputError, unknown_name
from ..numeric import file_path, number, whole_number
from ..robots import Robot
from ._bench_table import BenchRow, BenchTable
from ._sampled import sampled_clearance
from ._tree import TreeResult, connect

Floats = NDArray[np.float64]
MODES = ("tree", "reactive", "reactive-or-tree")
_NAMES = {"tree": "joint-space tree", "reactive": "reactive law"}
Progress = Callable[[str, int, int], None]


@dataclasses.dataclass(frozen=True, slots=True)
class _How:
    """How problems are planned and judged."""

    mode: str
    clearance: float
    repeats: int
    states_per_rad: float
    time_limit: float


def bench_mbm(
    path: str | Path,
    robot: Robot | str | Path | None = None,
    *,
    tip: str | None = None,
    mode: str = "tree",
    clearance: float = 0.0,
    repeats: int = 3,
    states_per_rad: float = 0.0,
    only: str | None = None,
    time_limit: float = 10.0,
    progress: Progress | None = None,
) -> BenchTable:
    """Plan every problem of a MotionBenchMaker set (folder or archive) and say how that went.

    `robot`: default `panda_spheres.urdf` beside the set, else the built-in Panda. `only`: sets whose names begin so.
    `mode`: see MODES. `states_per_rad`: check every path at so many configurations per radian with numpy, independent of
    the compiled code. `progress(set, number, of)` is called before each problem. Raises InputError for a set that cannot be read.
    """
    from ..scenes._moveit_files import ProblemSet, read_moveit_set

    how = _checked(mode, clearance, repeats, states_per_rad, time_limit)
    path = file_path(path, "path")
    sets = ProblemSet.read(path).sets
    if only and not any(name.startswith(only) for name in sets):
        raise InputError(f"no set begins with {only!r}", place="only", choices=sets)
    arm, notes = _robot(robot, path, tip)
    chosen = [(name, problem) for name, problem in read_moveit_set(path) if not only or name.startswith(only)]
    rows: list[BenchRow] = []
    for k, (name, problem) in enumerate(chosen):
        if progress:
            progress(name, k + 1, len(chosen))
        start, goal = problem.start_of(arm), problem.goal_of(arm)
        # where nothing is held, contacts that the set permits are checked all the same: the harder problem
        holding = problem.robot_of(arm) if problem.held else arm
        goals = getattr(goal, "q", None)
        if goals is None:
            raise InputError("the goal is a pose, expected joint values", place=problem.source)
        if not rows:
            _warm(holding, start, problem.world, how)
        rows.append(_run(name, problem.name, holding, start, goals, problem.world, how))
    return BenchTable(tuple(rows), states_per_rad, notes)


def bench_random(
    robots: Sequence[Robot | str | Path] | Robot | str | Path = (),
    *,
    count: int = 50,
    seed: int = 0,
    mode: str = "tree",
    clearance: float = 0.01,
    repeats: int = 3,
    states_per_rad: float = 0.0,
    time_limit: float = 10.0,
    loading: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> BenchTable:
    """Plan `count` random solvable problems (see `random_problem`) for each robot, all different for another `seed`.

    `robots`: names, URDF files or Robots; by default one of every kind in the catalogue. `loading`: how names and files are
    read, as `robots.load` takes it (tip, srdf, budget, ...). The rest as in `bench_mbm`.
    """
    from ._bench_random import ROBOTS, random_problem, with_bodies

    how = _checked(mode, clearance, repeats, states_per_rad, time_limit)
    count, seed = whole_number(count, "count", 1), whole_number(seed, "seed", 0)
    rows: list[BenchRow] = []
    for given in ((robots,) if isinstance(robots, (Robot, str, Path)) else robots) or ROBOTS:
        arm = with_bodies(given, **(loading or {}))
        for k in range(count):
            if progress:
                progress(arm.name, k + 1, count)
            start, goal, obstacles = random_problem(arm, seed + k, clearance)
            if k == 0:
                _warm(arm, start, obstacles, how)
            rows.append(_run(arm.name, f"seed {seed + k}", arm, start, goal, obstacles, how))
    return BenchTable(tuple(rows), states_per_rad)


def _checked(mode: str, clearance: float, repeats: int, states_per_rad: float, time_limit: float) -> _How:
    if mode not in MODES:
        raise unknown_name("mode", mode, MODES, place="mode")
    return _How(
        mode,
        number(clearance, "clearance", least=0.0, most=1e3),
        whole_number(repeats, "repeats", 1),
        number(states_per_rad, "states_per_rad", least=0.0, most=1e6),
        number(time_limit, "time_limit", least=0.0),
    )


def _solve(arm: Robot, start: Floats, goals: Floats, obstacles: Any, how: _How) -> tuple[TreeResult, str]:
    """The result and which solver it is from; only reactive-or-tree goes on to the tree."""
    name, result = "", None
    for name in how.mode.split("-or-"):
        if name == "reactive":
            from ._reactive import react

            result = react(arm, start, goals, obstacles, clearance=how.clearance, time_limit=how.time_limit)
        else:
            result = connect(arm, start, goals, obstacles, clearance=how.clearance, time_limit=how.time_limit)
        if result.solved:
            break
    assert result is not None
    return result, _NAMES[name]


def _warm(arm: Robot, start: Floats, obstacles: Any, how: _How) -> None:
    """Compile, or read compiled code, outside the clock."""
    _solve(arm, start, start, obstacles, dataclasses.replace(how, mode="tree", time_limit=1.0))
    _solve(arm, start, start, obstacles, dataclasses.replace(how, time_limit=1.0))


def _run(name: str, problem: str, arm: Robot, start: Floats, goals: Floats, obstacles: Any, how: _How) -> BenchRow:
    runs = []
    for _ in range(how.repeats):
        begin = perf_counter()
        result, solver = _solve(arm, start, goals, obstacles, how)
        runs.append((_parts(result)["total"], perf_counter() - begin, result, solver))
        if not result.solved:
            break
    total, call, result, solver = min(runs, key=lambda run: run[0])
    length = float(np.linalg.norm(np.diff(result.waypoints, axis=0), axis=1).sum()) if result.solved else 0.0
    row = BenchRow(
        name, problem, arm.name, solver, result.solved, result.reason, call=call, iterations=result.iterations, length=length,
        points=len(result.waypoints), margin=result.margin, rung=result.rung, **_parts(result),
    )  # fmt: skip
    if not row.solved:
        return row
    bounds = (
        clearance_bound(arm, result.waypoints, obstacles, how.clearance, static=False).lower - how.clearance,
        clearance_bound(arm, result.waypoints, (), 0.0, self_collision=True).lower,
    )
    row = dataclasses.replace(row, certified_again=min(bounds))
    if how.states_per_rad:
        outer, inner = sampled_clearance(arm, result.waypoints, obstacles, how.states_per_rad)
        row = dataclasses.replace(row, obstacle_clearance=outer, self_clearance=inner)
    return row


def _parts(result: TreeResult) -> dict[str, float]:
    times = result.timings
    plan, simplify, certificate = times.get("grow", 0.0) + times.get("follow", 0.0), times["simplify"], times["certify"]
    return {
        "pack": times["pack"], "plan": plan, "simplify": simplify, "certificate": certificate,
        "total": plan + simplify + certificate,
    }  # fmt: skip


def _robot(robot: Robot | str | Path | None, path: Path, tip: str | None) -> tuple[Robot, tuple[str, ...]]:
    """The robot, and what to know of it."""
    from ..robots import load

    if isinstance(robot, Robot):
        return robot, ()
    if robot is not None:
        return load(robot, tip=tip), ()
    beside = (path if path.is_dir() else path.parent) / "panda_spheres.urdf"
    if beside.is_file():
        return load(beside, tip=tip or "panda_hand"), ()
    note = f"no {beside.name} beside the set: planned for the built-in Panda, whose capsules touch obstacles in many of the goals"
    return load("panda", tip=tip), (f"{note}; --robot FILE takes another robot",)
