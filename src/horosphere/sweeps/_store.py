"""A sweep on disk: a manifest of the problems, shards of rows as they were finished, and the table of all of them."""

from __future__ import annotations

import csv
import json
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..io import output_folder, to_json, writing
from ._problems import Problem

COLUMNS: dict[str, str] = {
    "problem": "string", "status": "string", "solved_by": "string", "certified": "bool", "clearance": "double",
    "required": "double", "duration": "double", "waypoints": "int64", "seconds": "double", "seed": "int64",
    "scene": "string", "reason": "string",
}  # fmt: skip
"""Of the table, with their types in the Parquet file. Metres, seconds; `seconds` is what planning took."""
FLUSH_SECONDS, FLUSH_ROWS = 1.0, 1000
MANIFEST, SHARDS = "manifest.json", "shards"


class Store:
    """The folder of one sweep. Rows wait until they make a second of work, then they are written as one shard."""

    def __init__(self, folder: str | Path, problems: Sequence[Problem]) -> None:
        """Raises InputError for a folder that cannot be written, and for shards that are none of ours."""
        self.folder = output_folder(folder)
        self.problems = problems
        self._shards = output_folder(self.folder / SHARDS)
        wanted = {problem.key for problem in problems}
        self.rows = {key: row for key, row in self._read() if key in wanted}
        self._fresh: list[dict[str, Any]] = []
        self._flushed = time.monotonic()
        from .. import __version__

        with writing(self.folder / MANIFEST) as file:
            file.write(to_json({"horosphere/sweep": 1, "version": __version__, "problems": problems}) + "\n")

    def _read(self) -> Iterable[tuple[str, dict[str, Any]]]:
        for path in sorted(self._shards.glob("*.jsonl")):
            try:
                rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
                yield from ((row["key"], row) for row in rows)
            except (OSError, ValueError, KeyError, TypeError) as error:
                raise InputError(f"not a shard of a sweep ({error})", place=str(path), remedy="delete it") from None

    def forget(self, statuses: Iterable[str] | None = None) -> None:
        """Leaves out what was found earlier: rows with these statuses, or all of them."""
        chosen = None if statuses is None else set(statuses)
        self.rows = {key: row for key, row in self.rows.items() if chosen is not None and row["status"] not in chosen}

    def open_problems(self) -> list[Problem]:
        """What has no row yet."""
        return [problem for problem in self.problems if problem.key not in self.rows]

    def add(self, row: dict[str, Any]) -> None:
        """Takes one finished row."""
        self.rows[row["key"]] = row
        self._fresh.append(row)
        if time.monotonic() - self._flushed > FLUSH_SECONDS or len(self._fresh) >= FLUSH_ROWS:
            self.flush()

    def flush(self) -> None:
        """Writes the rows that wait."""
        if self._fresh:
            number = 1 + max((int(p.stem) for p in self._shards.glob("*.jsonl") if p.stem.isdigit()), default=-1)
            with writing(self._shards / f"{number:05d}.jsonl") as file:
                file.writelines(json.dumps(row) + "\n" for row in self._fresh)
            self._fresh = []
        self._flushed = time.monotonic()

    def table(self) -> list[dict[str, Any]]:
        """The rows there are, in the order of the problems, with all columns."""
        found = [self.rows[p.key] | {"problem": p.name} for p in self.problems if p.key in self.rows]
        return [{name: row.get(name) for name in COLUMNS} for row in found]

    def write_tables(self) -> list[Path]:
        """sweep.csv, and sweep.parquet where pyarrow is installed."""
        rows, written = self.table(), [self.folder / "sweep.csv"]
        with writing(written[0]) as file:
            writer = csv.DictWriter(file, list(COLUMNS), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        parquet = self.folder / "sweep.parquet"
        try:
            import pyarrow as pa  # pyright: ignore[reportMissingImports]
            import pyarrow.parquet as pq  # pyright: ignore[reportMissingImports]
        except ImportError:
            parquet.unlink(missing_ok=True)  # of an earlier run, and no longer true
            return written
        types = {"string": pa.string(), "bool": pa.bool_(), "double": pa.float64(), "int64": pa.int64()}
        schema = pa.schema([(name, types[kind]) for name, kind in COLUMNS.items()])
        with writing(parquet, "wb") as file:
            pq.write_table(pa.Table.from_pylist(rows, schema=schema), file)
        return [*written, parquet]
