"""`horosphere bench mbm PATH`: the tree planner on a set of MoveIt problems, a row a problem, a line a set."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..robots import Robot
from ._tree import TreeResult, connect

Floats = NDArray[np.float64]
FORMATS = (".csv", ".json", ".parquet")


@dataclass(frozen=True, slots=True)
class BenchRow:
    """One problem: seconds of the fastest of the repeats, path length (rad), certified margin (m), clearance found (m)."""

    set: str
    problem: str
    solved: bool
    reason: str
    total: float
    wall: float
    pack: float
    grow: float
    simplify: float
    certify: float
    iterations: int
    length: float
    points: int
    margin: float
    rung: float
    obstacle_clearance: float = float("nan")
    self_clearance: float = float("nan")


@dataclass(frozen=True, slots=True)
class BenchTable:
    """All rows of a run; `checked_at` configurations per radian were checked (0: none)."""

    rows: tuple[BenchRow, ...]
    robot: str
    checked_at: float = 0.0
    columns: tuple[str, ...] = field(
        default=("set", "problems", "solved", "median us", "mean us", "p95 us", "wall us", "length", "touching")
    )

    def summary(self) -> list[tuple[Any, ...]]:
        """A line (see `columns`) a set, and one for all; times are grow + simplify + certify, wall is the whole call."""
        names = list(dict.fromkeys(row.set for row in self.rows))
        lines = [self._line(name, [row for row in self.rows if row.set == name]) for name in names]
        return [*lines, self._line("all", list(self.rows))] if len(names) != 1 else lines

    def _line(self, name: str, rows: list[BenchRow]) -> tuple[Any, ...]:
        solved = [row for row in rows if row.solved]
        total = np.array([row.total for row in solved]) * 1e6
        if not solved:
            return name, len(rows), 0, *(float("nan"),) * 5, 0
        touching = sum(min(row.obstacle_clearance, row.self_clearance) < 0.0 for row in solved)
        return (
            name,
            len(rows),
            len(solved),
            float(np.median(total)),
            float(total.mean()),
            float(np.percentile(total, 95)),
            float(np.median([row.wall for row in solved])) * 1e6,
            float(np.median([row.length for row in solved])),
            touching if self.checked_at else "-",
        )

    def save(self, path: str | Path) -> Path:
        """Write all rows as .csv, .json, or .parquet (which needs pyarrow)."""
        target = Path(path)
        if target.suffix not in FORMATS:
            raise InputError(f"unknown kind of table {target.suffix!r}", place=str(path), choices=FORMATS)
        rows = [asdict(row) for row in self.rows]
        part = target.with_name(target.name + ".part")
        if target.suffix == ".parquet":
            try:
                import pyarrow  # pyright: ignore[reportMissingImports]
                import pyarrow.parquet  # pyright: ignore[reportMissingImports]
            except ImportError:
                raise InputError(
                    "Parquet needs pyarrow, which is not installed",
                    place=str(path),
                    remedy="pip install pyarrow, or write .csv",
                ) from None
            pyarrow.parquet.write_table(pyarrow.Table.from_pylist(rows), part)
        elif target.suffix == ".json":
            part.write_text(
                json.dumps({"robot": self.robot, "states_per_rad": self.checked_at, "rows": rows}, indent=1)
            )
        else:
            with part.open("w", newline="") as file:
                writer = csv.DictWriter(file, [item.name for item in fields(BenchRow)])
                writer.writeheader()
                writer.writerows(rows)
        part.replace(target)
        return target


def bench_mbm(
    path: str | Path,
    robot: Robot | str | Path | None = None,
    *,
    tip: str | None = None,
    clearance: float = 0.0,
    repeats: int = 3,
    states_per_rad: float = 0.0,
    only: str | None = None,
    time_limit: float = 10.0,
    progress: Callable[[str, int], None] | None = None,
) -> BenchTable:
    """Plan every problem of a MotionBenchMaker set (folder or archive) and say how that went.

    `robot`: default `panda_spheres.urdf` beside the set, else the built-in Panda. `only`: sets whose names begin so.
    `states_per_rad`: check every path at so many configurations per radian with numpy, independent of the compiled code.
    `progress(set, number)` is called before each problem. Raises InputError for a set that cannot be read.
    """
    from ..scenes._moveit import read_moveit_set

    arm = _robot(robot, Path(path), tip)
    rows: list[BenchRow] = []
    for k, (name, problem) in enumerate(read_moveit_set(path)):
        if only and not name.startswith(only):
            continue
        if progress:
            progress(name, k)
        start, goal = problem.start_of(arm), problem.goal_of(arm)
        goals = getattr(goal, "q", None)
        if goals is None:
            raise InputError("the goal is a pose, expected joint values", place=problem.source)
        if not rows:  # compile, or read compiled code, outside the clock
            connect(arm, start, start, problem.obstacles, time_limit=1.0)
        runs = []
        for _ in range(max(repeats, 1)):
            begin = perf_counter()
            result = connect(arm, start, goals, problem.obstacles, clearance=clearance, time_limit=time_limit)
            runs.append((_total(result), perf_counter() - begin, result))
            if not result.solved:
                break
        rows.append(_row(name, problem.name, *min(runs, key=lambda run: run[0])))
        if states_per_rad and rows[-1].solved:
            found = sampled_clearance(arm, runs[-1][2].waypoints, problem.obstacles, states_per_rad)
            changed = {"obstacle_clearance": found[0], "self_clearance": found[1]}
            rows[-1] = BenchRow(**{**asdict(rows[-1]), **changed})
    return BenchTable(tuple(rows), arm.name, states_per_rad)


def sampled_clearance(
    robot: Robot, waypoints: Floats, obstacles: Iterable[Any], states_per_rad: float
) -> tuple[float, float]:
    """Least distance (m) to obstacles and of self pairs on a path, configuration by configuration in numpy.

    Capsules that are no balls are taken as 33 balls along their segments.
    """
    from ..robots._pairs import segment_distance
    from ..robots._placement import link_frames, move_points

    steps = np.maximum(np.ceil(np.linalg.norm(np.diff(waypoints, axis=0), axis=1) * states_per_rad), 1).astype(int)
    path = np.concatenate(
        [waypoints[:1]]
        + [a + np.linspace(0.0, 1.0, k + 1)[1:, None] * (b - a) for a, b, k in zip(waypoints, waypoints[1:], steps)]
    )
    bodies, solids = robot.capsules, tuple(obstacles)
    outer = inner = np.inf
    shares = np.linspace(0.0, 1.0, 33 if (bodies.a != bodies.b).any() else 1)[:, None, None]
    for q in np.array_split(path, max(len(path) // 500, 1)):
        poses = link_frames(robot.links, q)[:, bodies.link]
        a, b = move_points(poses, bodies.a), move_points(poses, bodies.b)
        points = a[None] + shares[..., None] * (b - a)[None]
        for shape in solids:
            outer = min(outer, float((shape.signed_distance(points) - bodies.radius).min()))
        for i, j in robot.self_pairs:
            first, second = np.flatnonzero(bodies.link == i), np.flatnonzero(bodies.link == j)
            m, n = np.repeat(first, len(second)), np.tile(second, len(first))
            if len(m):
                gaps = segment_distance(a[:, m], b[:, m], a[:, n], b[:, n]) - bodies.radius[m] - bodies.radius[n]
                inner = min(inner, float(gaps.min()))
    return outer, inner


def _robot(robot: Robot | str | Path | None, path: Path, tip: str | None) -> Robot:
    from ..robots import load

    if isinstance(robot, Robot):
        return robot
    beside = (path if path.is_dir() else path.parent) / "panda_spheres.urdf"
    if robot is None and beside.is_file():
        return load(beside, tip=tip or "panda_hand")
    return load("panda" if robot is None else robot, tip=tip)


def _total(result: TreeResult) -> float:
    return sum(result.timings[part] for part in ("grow", "simplify", "certify"))


def _row(name: str, problem: str, total: float, wall: float, result: TreeResult) -> BenchRow:
    length = float(np.linalg.norm(np.diff(result.waypoints, axis=0), axis=1).sum()) if result.solved else 0.0
    parts = {part: result.timings[part] for part in ("pack", "grow", "simplify", "certify")}
    return BenchRow(
        name, problem, result.solved, result.reason, total, wall, iterations=result.iterations, length=length,
        points=len(result.waypoints), margin=result.margin, rung=result.rung, **parts,
    )  # fmt: skip
