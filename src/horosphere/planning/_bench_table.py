"""What a run of many problems says: a row a problem, a line a set, files."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError

FORMATS = (".csv", ".json", ".parquet")
PARTS = ("plan", "simplify", "certificate", "total", "call")
"""Times of a row: the search, shortening, the certificate, all three, and the whole Python call with packing."""


@dataclass(frozen=True, slots=True)
class BenchRow:
    """One problem: seconds of the fastest of the repeats, path length (rad), margin certified by the planner (m).

    `certified_again`: lower bound of the clearance beyond what is asked for (m), by the double-precision certificate;
    `obstacle_clearance`, `self_clearance`: seen by the independent check; NaN where they were not looked for.
    """

    set: str
    problem: str
    robot: str
    solver: str
    solved: bool
    reason: str
    total: float
    call: float
    pack: float
    plan: float
    simplify: float
    certificate: float
    iterations: int
    length: float
    points: int
    margin: float
    rung: float
    certified_again: float = float("nan")
    obstacle_clearance: float = float("nan")
    self_clearance: float = float("nan")

    @property
    def is_certified(self) -> bool:
        """Solved, and the double-precision certificate agrees."""
        return self.solved and self.certified_again >= 0.0

    @property
    def touches(self) -> bool:
        """Whether the independent check saw contact."""
        return min(self.obstacle_clearance, self.self_clearance) < 0.0


@dataclass(frozen=True, slots=True)
class BenchTable:
    """All rows of a run; paths were looked at in `states_per_rad` configurations per radian (0: not). `notes`: what to know."""

    rows: tuple[BenchRow, ...]
    states_per_rad: float = 0.0
    notes: tuple[str, ...] = ()

    def summary(self) -> list[dict[str, Any]]:
        """A line a set, and one for all: counts, length (median, rad), and (median, mean, p95) in microseconds of PARTS."""
        names = list(dict.fromkeys(row.set for row in self.rows))
        lines = [self._line(name, [row for row in self.rows if row.set == name]) for name in names]
        return [*lines, self._line("all", self.rows)] if len(names) != 1 else lines

    def _line(self, name: str, rows: Iterable[BenchRow]) -> dict[str, Any]:
        rows = list(rows)
        solved = [row for row in rows if row.solved]
        line: dict[str, Any] = {
            "set": name,
            "problems": len(rows),
            "solved": len(solved),
            "certified": sum(row.is_certified for row in solved),
            "touching": sum(row.touches for row in solved) if self.states_per_rad else None,
        }
        for part in PARTS:
            values = np.array([getattr(row, part) for row in solved]) * 1e6
            three = (np.median(values), values.mean(), np.percentile(values, 95)) if solved else (np.nan,) * 3
            line[f"{part}_us"] = tuple(float(x) for x in three)
        line["length"] = float(np.median([row.length for row in solved])) if solved else float("nan")
        return line

    def solvers(self) -> dict[str, int]:
        """How many problems each solver solved."""
        found: dict[str, int] = {}
        for row in self.rows:
            if row.solved:
                found[row.solver] = found.get(row.solver, 0) + 1
        return found

    def save(self, path: str | Path) -> Path:
        """Write all rows as .csv, .json, or .parquet (with the extra `parquet`); `check_format` says beforehand if it can."""
        target = check_format(path)
        rows = [asdict(row) for row in self.rows]
        part = target.with_name(target.name + ".part")
        if target.suffix == ".parquet":
            import pyarrow.parquet  # pyright: ignore[reportMissingImports]

            pyarrow.parquet.write_table(pyarrow.Table.from_pylist(rows), part)
        elif target.suffix == ".json":
            part.write_text(json.dumps({"states_per_rad": self.states_per_rad, "rows": rows}, indent=1))
        else:
            with part.open("w", newline="") as file:
                writer = csv.DictWriter(file, [item.name for item in fields(BenchRow)])
                writer.writeheader()
                writer.writerows(rows)
        part.replace(target)
        return target


def check_format(path: str | Path) -> Path:
    """The path, if a table can be written there as what its ending says; InputError otherwise. Call it before the work."""
    target = Path(path)
    if target.suffix not in FORMATS:
        raise InputError(f"unknown kind of table {target.suffix!r}", place=str(path), choices=FORMATS)
    if target.suffix == ".parquet":
        from importlib.util import find_spec

        if find_spec("pyarrow") is None:
            raise InputError(
                "Parquet needs pyarrow, which is not installed",
                place=str(path),
                remedy="pip install 'horosphere[parquet]', or write .csv or .json",
            )
    if not target.absolute().parent.is_dir():
        raise InputError("the folder does not exist", place=str(path), remedy="make it first, or choose another place")
    return target
