"""`horosphere bench`: public problem sets."""

from __future__ import annotations

from pathlib import Path

from cyclopts import App

from . import _output as out

app = App(
    name="bench",
    help="Run a public problem set and print how it went.\n\nExample: `horosphere bench mbm problems.tar.bz2`",
)


@app.command
def mbm(
    path: Path,
    *,
    robot: str | None = None,
    tip: str | None = None,
    only: str | None = None,
    clearance: float = 0.0,
    repeats: int = 3,
    states_per_rad: float = 0.0,
    out_file: Path | None = None,
    json: bool = False,
) -> int:
    """MotionBenchMaker: `SET/sceneNNNN.yaml` and `SET/requestNNNN.yaml` in a folder or an archive; a table per set.

    Times are trees, simplification and certificate, each problem run `repeats` times and its best taken.

    Example: `horosphere bench mbm mbm_panda_problems.tar.bz2 --only cage --states-per-rad 300`

    Parameters
    ----------
    path
        The folder or the archive.
    robot
        A URDF or a built-in name; default: panda_spheres.urdf beside the set, else the built-in Panda.
    tip
        The tip link of the URDF.
    only
        Sets whose names begin so.
    clearance
        Metres to keep from every obstacle.
    repeats
        Runs of each problem.
    states_per_rad
        Check every path at so many configurations per radian with plain numpy, independent of the planner (slow; 0: not).
    out_file
        Write all rows as .csv, .json or .parquet.
    json
        Print the result as JSON.
    """
    from ..planning import bench_mbm

    with out.working("reading the problems") as progress:
        out.announce_compiling(progress)
        table = bench_mbm(
            path,
            robot,
            tip=tip,
            only=only,
            clearance=clearance,
            repeats=repeats,
            states_per_rad=states_per_rad,
            progress=lambda name, k: progress.update(f"planning {name}"),
        )
    if out_file is not None:
        table.save(out_file)
    lines = table.summary()
    solved = all(row.solved for row in table.rows)
    if json:
        out.print_json({"robot": table.robot, "sets": [dict(zip(table.columns, line, strict=True)) for line in lines]})
        return out.DONE if solved else out.FAILED
    from rich.table import Table

    printed = Table(box=None, padding=(0, 2, 0, 0))
    for k, column in enumerate(table.columns):
        printed.add_column(column, justify="left" if k == 0 else "right")
    for line in lines:
        printed.add_row(*(f"{cell:.4g}" if isinstance(cell, float) else str(cell) for cell in line))
    out.print_table(printed)
    reasons = [(f"{row.set} {row.problem}", row.reason) for row in table.rows if not row.solved]
    if reasons:
        out.print_rows(reasons[:20], title="Not solved")
    if out_file is not None:
        out.print_rows([("File", str(out_file))])
    return out.DONE if solved else out.FAILED
