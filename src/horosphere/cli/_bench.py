"""`horosphere bench`: public problem sets, and random problems for any robot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from . import _output as out
from ._source import USUAL as USUAL_LOADING
from ._source import Loading
from ._values import Whole

if TYPE_CHECKING:
    from ..planning._bench_table import BenchTable

app = App(
    name="bench",
    help="Plans many problems and tables how it went: MotionBenchMaker, or random ones for any robot.\n\n"
    "Example: `horosphere bench mbm problems.tar.bz2`",
)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Runs:
    """How all problems are run, and what becomes of the table.

    Parameters
    ----------
    mode
        tree, reactive (no tree at all), or reactive-or-tree.
    repeats
        Runs of each problem.
    states_per_rad
        Look at every path in so many configurations per radian, independent of the planner (0: not, which is much faster).
    out_file
        Write all rows as .csv, .json or .parquet.
    json
        Print the result as JSON.
    """

    mode: Literal["tree", "reactive", "reactive-or-tree"] = "tree"
    repeats: Whole = 3
    states_per_rad: float = 300.0
    out_file: Annotated[Path | None, Parameter(name="--out")] = None
    json: bool = False

    @property
    def options(self) -> dict[str, Any]:
        """Those that the bench takes."""
        return {"mode": self.mode, "repeats": self.repeats, "states_per_rad": self.states_per_rad}


USUAL = Runs()


@app.command
def mbm(
    path: Path,
    /,
    *,
    robot: str | None = None,
    tip: str | None = None,
    only: str | None = None,
    clearance: float = 0.0,
    runs: Runs = USUAL,
) -> int:
    """MotionBenchMaker: `SET/sceneNNNN.yaml` and `SET/requestNNNN.yaml` in a folder or an archive; a table per set.

    Times are trees (or the reactive law), simplification and certificate, each problem run `repeats` times and its best taken.
    Certified: by the planner, and again by the certificate in double precision. Touching: seen by plain numpy.

    Example: `horosphere bench mbm mbm_panda_problems.tar.bz2 --only cage --out rows.parquet`

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
    """
    from ..planning import bench_mbm

    def run(progress: Any, _: Any) -> BenchTable:
        return bench_mbm(path, robot, tip=tip, only=only, clearance=clearance, progress=progress, **runs.options)

    return _report("reading the problems", run, runs)


@app.command(usage="Usage: horosphere bench random [OPTIONS] [ROBOTS...]")
def random(
    *robots: str,
    count: Whole = 50,
    seed: Whole = 0,
    clearance: float = 0.01,
    loading: Loading = USUAL_LOADING,
    runs: Runs = USUAL,
) -> int:
    """Random problems with a known solution: for each robot `count` scenes of balls, boxes, cylinders and capsules in its way.

    Examples: `horosphere bench random ur5 iiwa14 --count 20`, `horosphere bench random my_robot.urdf --tip tool0`

    Parameters
    ----------
    robots
        Built-in names or URDF files; by default one of every kind in the catalogue.
    count
        Problems a robot.
    seed
        Of the first problem; the next have the numbers after it.
    clearance
        Metres to keep from every obstacle.
    """
    from ..planning import bench_random

    def run(progress: Any, tell: Any) -> BenchTable:
        options = {"progress": progress, "loading": {**loading.given, "progress": tell}, **runs.options}
        return bench_random(robots, count=count, seed=seed, clearance=clearance, **options)

    return _report("making the problems", run, runs)


def _report(what: str, run: Any, runs: Runs) -> int:
    """Runs a bench under a line of progress, writes its rows, prints its table."""
    from ..planning._bench_table import check_format

    if runs.out_file is not None:
        check_format(runs.out_file)
    with out.working(what) as progress:
        out.announce_compiling(progress)
        said = ""

        def planning(name: str, number: int, of: int) -> None:
            nonlocal said
            if progress.is_terminal or name != said:  # in a log one line a set is enough
                said = name
                progress.update(f"planning {name}: {number} of {of}")

        table = run(planning, progress.update)
    if runs.out_file is not None:
        table.save(runs.out_file)
    lines = table.summary()
    solved = all(row.solved for row in table.rows)
    reasons = [(f"{row.set} {row.problem}", row.reason) for row in table.rows if not row.solved]
    if runs.json:
        named = [{"problem": problem, "reason": reason} for problem, reason in reasons]
        out.print_json({
            "robots": list(dict.fromkeys(row.robot for row in table.rows)), "states_per_rad": table.states_per_rad,
            "solved_by": table.solvers(), "sets": lines, "not_solved": named, "notes": table.notes,
        })  # fmt: skip
        return out.DONE if solved else out.FAILED
    from rich.table import Table

    counts = Table(box=None, padding=(0, 2, 0, 0))
    times = Table(box=None, padding=(0, 2, 0, 0), title="median / mean / p95 in microseconds", title_justify="left")
    for k, column in enumerate(("set", "problems", "solved", "certified", "touching", "length (rad)")):
        counts.add_column(column, justify="left" if k == 0 else "right")
    for k, column in enumerate(("set", "plan", "simplify", "certificate", "total", "whole call")):
        times.add_column(column, justify="left" if k == 0 else "right", no_wrap=True)
    for line in lines:
        touching = "-" if line["touching"] is None else line["touching"]
        counts.add_row(
            *(str(line[name]) for name in ("set", "problems", "solved", "certified")),
            str(touching),
            f"{line['length']:.2f}",
        )
        parts = ("plan_us", "simplify_us", "certificate_us", "total_us", "call_us")
        times.add_row(line["set"], *(" / ".join(f"{x:.0f}" for x in line[part]) for part in parts))
    out.print_table(counts)
    out.print_table(times, wide=True)
    rows = [("Solved by", ", ".join(f"{name}: {number}" for name, number in table.solvers().items()) or "nothing")]
    if table.states_per_rad:
        rows.append(("Touching", f"in {table.states_per_rad:g} configurations per radian, by plain numpy"))
    rows += [("File", str(runs.out_file))] if runs.out_file is not None else []
    out.print_rows(rows)
    if reasons:
        more = [("...", f"and {len(reasons) - 20} more; --json or --out names all")] if len(reasons) > 20 else []
        out.print_rows([*reasons[:20], *more], title="Not solved")
    out.print_notes(table.notes)
    return out.DONE if solved else out.FAILED
