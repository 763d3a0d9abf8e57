"""`sweep`: solve many problems, keep what was found, go on where it stopped."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import InputError
from ._cluster import run_cluster
from ._pool import Crew
from ._problems import expand
from ._store import Store

LOST = ("crashed", "timed out")


@dataclass(frozen=True, slots=True)
class Sweep:
    """What came of it: `rows` with the columns of `COLUMNS`, one a problem; `resumed`: how many were known from an earlier run;
    `files`: the tables written. `counts`: problems by status."""

    rows: tuple[dict[str, Any], ...]
    resumed: int
    files: tuple[Path, ...]

    @property
    def counts(self) -> dict[str, int]:
        return dict(Counter(row["status"] for row in self.rows))

    @property
    def all_solved(self) -> bool:
        return all(row["status"] == "solved" for row in self.rows)


def sweep(
    scenes: Iterable[str | Path],
    folder: str | Path,
    *,
    seeds: int | None = None,
    options: Mapping[str, Any] | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    timeout: float = 300.0,
    trajectories: bool = False,
    retry: bool = False,
    fresh: bool = False,
    progress: Callable[[int, int, dict[str, int]], None] | None = None,
) -> Sweep:
    """Plans every scene (once per seed) and tables what became of it in `folder`; a run that was stopped goes on where it was.

    `scenes`: files, built-in names, folders. `options`: of `planning.plan`. `workers`: processes on this machine, one a
    processor by default; or a Dask cluster at the address `scheduler`. A problem that crashes its process or takes longer
    than `timeout` seconds is named in the table and disturbs no other. `trajectories`: keep the motions as .npz.
    `retry`: try what crashed or timed out again; `fresh`: everything. `progress(done, all, counts)` is called after each.
    Whatever ends the sweep, finished rows are on disk: call it again. A scene counts as known by its text; files that it names
    (URDF, meshes) are not looked at. Raises InputError.
    """
    if seeds is not None and seeds < 1:
        raise InputError(f"expected at least one seed, got {seeds}", place="seeds")
    if workers is not None and workers < 1:
        raise InputError(f"expected at least one worker, got {workers}", place="workers")
    if not timeout > 0.0:
        raise InputError(f"expected a timeout above 0 s, got {timeout:g}", place="timeout")
    problems = expand(scenes, seeds, options)
    store = Store(folder, problems)
    if fresh or retry:
        store.forget(None if fresh else LOST)
    left = store.open_problems()
    resumed = len(problems) - len(left)
    if trajectories:
        from ..io import output_folder

        kept = output_folder(store.folder / "trajectories").resolve()
        left = [replace(problem, save=str(kept / f"{problem.key}.npz")) for problem in left]
    tasks = [problem.as_task() for problem in left]
    crew = Crew(min(workers or os.cpu_count() or 1, max(len(tasks), 1)), timeout)
    rows = crew.run(tasks) if scheduler is None else run_cluster(tasks, scheduler, timeout)
    counts = Counter(row["status"] for row in store.rows.values())
    try:
        for row in rows:
            store.add(row)
            counts[row["status"]] += 1
            if progress is not None:
                progress(len(store.rows), len(problems), dict(counts))
    finally:
        crew.close()
        store.flush()
    return Sweep(tuple(store.table()), resumed, tuple(store.write_tables()))
