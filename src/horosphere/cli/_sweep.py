"""`horosphere sweep`: many problems, with a table of what became of each."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from . import _output as out
from ._values import Whole

SHOWN = 30
LINE_SECONDS = 5.0
"""Between lines of progress where no line can be written over."""


def sweep(
    *scenes: str,
    out_folder: Annotated[Path, Parameter(name="--out")] = Path("out/sweep"),
    seeds: Whole | None = None,
    workers: Whole | None = None,
    scheduler: str | None = None,
    timeout: float = 300.0,
    clearance: float | None = None,
    method: Literal["auto", "field", "tree", "reactive", "reactive-or-tree"] | None = None,
    time_limit: float | None = None,
    trajectories: bool = False,
    retry: bool = False,
    fresh: bool = False,
    json: bool = False,
) -> int:
    """Plans many scenes and tables what became of each; stopped with Ctrl-C, the same command goes on where it was.

    Example: `horosphere sweep humanoid-reach panda-table --seeds 2`

    Writes manifest.json, shards/, sweep.csv and (with the extra `parquet`) sweep.parquet. A problem that crashes or hangs is
    named in the table and disturbs no other. Exit code 0: all solved and certified, 1: not all, 2: bad input.

    Parameters
    ----------
    scenes
        Scene files, built-in scenes, folders with scene files.
    out_folder
        Folder of the sweep; one that was begun there is continued.
    seeds
        Plan each scene with so many seeds, 0 first.
    workers
        Processes on this machine; one a processor by default.
    scheduler
        Address of a running Dask cluster, tcp://HOST:PORT (needs the extra `cluster`), instead of processes here.
    timeout
        Seconds after which a problem is given up.
    clearance
        Metres to keep between robot and obstacles, instead of the scenes'.
    method
        As of `horosphere plan`.
    time_limit
        Seconds that planning may search.
    trajectories
        Keep every motion as trajectories/KEY.npz.
    retry
        Try again what crashed or timed out earlier.
    fresh
        Forget what was found earlier.
    json
        Print the result as JSON.
    """
    from ..sweeps import sweep as run
    from ._plan import checked_options

    asked = {"clearance": clearance, "method": method, "time_limit": time_limit}
    options = checked_options({name: value for name, value in asked.items() if value is not None})
    with out.working("starting") as working:
        told = 0.0

        def progress(done: int, count: int, counts: dict[str, int]) -> None:
            nonlocal told
            if not working.is_terminal and done < count and time.monotonic() - told < LINE_SECONDS:
                return
            told = time.monotonic()
            said = ", ".join(f"{n} {status}" for status, n in sorted(counts.items(), key=lambda item: -item[1]))
            working.update(f"{done} of {count} problems: {said}")

        try:
            found = run(
                scenes, out_folder, seeds=seeds, options=options, workers=workers, scheduler=scheduler, timeout=timeout,
                trajectories=trajectories, retry=retry, fresh=fresh, progress=progress,
            )  # fmt: skip
        except KeyboardInterrupt:
            out.print_notes([f"stopped; the same command goes on from what is in {out_folder}"], stderr=True)
            raise
    hints = []
    if not any(path.suffix == ".parquet" for path in found.files):
        hints.append("no Parquet file: it needs the extra `parquet` (pip install 'horosphere[parquet]')")
    if json:
        data = {"counts": found.counts, "resumed": found.resumed, "rows": found.rows}
        out.print_json({**data, "files": [str(path) for path in found.files], "hints": hints})
    else:
        _print(found)
        out.print_notes(hints)
    return out.DONE if found.all_solved else out.FAILED


def _print(found: Any) -> None:
    from rich.table import Table

    from ..viewer import bound

    counts = found.counts
    rows = sorted(found.rows, key=lambda row: row["status"] == "solved")  # what went wrong first
    verdict = ", ".join(f"{n} {status}" for status, n in sorted(counts.items(), key=lambda item: -item[1]))
    known = f" ({found.resumed} known from before)" if found.resumed else ""
    out.print_verdict(f"{len(rows)} problems: {verdict}{known}", found.all_solved)
    table = Table(box=None, padding=(0, 2, 0, 0))
    for name in ("problem", "status", "solved by", "clearance", "motion", "planned in"):
        numeric = name in ("clearance", "motion", "planned in")
        table.add_column(name, justify="right" if numeric else "left", header_style="dim", overflow="fold")
    for row in rows[:SHOWN]:
        by = row["solved_by"] if row["status"] == "solved" else row["reason"]
        gap = "" if row["clearance"] is None else bound(row["clearance"], 1)
        motion = "" if row["duration"] is None else f"{row['duration']:.2f} s"
        took = "" if row["seconds"] is None else f"{row['seconds']:.2f} s"
        table.add_row(out.plain_text(row["problem"]), row["status"], out.plain_text(by or ""), gap, motion, took)
    out.print_table(table)
    if len(rows) > SHOWN:
        out.print_notes([f"{len(rows) - SHOWN} more in the table"])
    out.print_rows([("Files", ", ".join(str(path) for path in found.files))])
