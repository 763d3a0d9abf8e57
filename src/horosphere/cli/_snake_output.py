"""What the snake commands say and write."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from . import _output as out

WRITTEN = ("trajectory.npz", "inputs.csv", "motion.png")


def said(result: Any, word: str | None) -> tuple[str, bool]:
    """The first line, and whether it is good news."""
    from ..snake import word_text

    if word is None:
        reason = result.reason or result.motion.reason
        return (
            f"Stopped early: {reason}" if reason else f"{len(result.displacement)} periods of {result.period:.3g} s",
            not reason,
        )
    legs, text = len(result.legs), word_text(result.word)
    return f"{text}, a bracket of degree {result.degree}, carried out in {legs} legs of {result.t:g} s", True


def print_coordinates(snake: Any, motion: Any, predicted: Any) -> None:
    """Start, end and change of every coordinate; beside it what the bracket predicts."""
    from rich.table import Table

    table = Table(box=None, padding=(0, 2, 0, 0))
    for name in ("coordinate", "unit", "start", "end", "change", *(["predicted"] if predicted is not None else [])):
        table.add_column(name, justify="left" if name in ("coordinate", "unit") else "right", header_style="dim")
    for k, name in enumerate(snake.names):
        places = [f"{round(float(x), 6) + 0.0:.5f}" for x in (motion.q[0, k], motion.end[k])]
        changes = [motion.displacement[k]] + ([] if predicted is None else [predicted[k]])
        table.add_row(name, "m" if k < 2 else "rad", *places, *(_change(float(x)) for x in changes))
    out.print_table(table)


def _change(x: float) -> str:
    """As places are written; three digits of what would vanish so, 0 where nothing is left but rounding."""
    return f"{x:.5f}" if abs(x) >= 1e-3 else "0" if abs(x) < 1e-14 else f"{x:.2e}"


def write(folder: Path, snake: Any, motion: Any, figure: Any, legs: Any = None, duration: float = 0.0) -> list[str]:
    """The motion as files, all of them or none; `legs` (m, 4): inputs that are constant over equal parts of `duration`."""
    import numpy as np

    from ..io import save_trajectory, writing, writing_set
    from ..scenes import Trajectory

    keep = np.concatenate([[True], np.diff(motion.time) > 0.0])
    rates = snake.angle_rates(snake.to_angles(motion.q[keep]), motion.inputs[keep])
    with writing_set(folder, WRITTEN) as stage:
        save_trajectory(Trajectory(motion.time[keep], motion.q[keep], rates, None, snake.names), stage / WRITTEN[0])
        if legs is not None:
            with writing(stage / "inputs.csv") as file:
                file.write("from,to,u1,u2,u3,u4\n")
                ends = np.linspace(0.0, duration, len(legs) + 1).tolist()
                for start, end, leg in zip(ends, ends[1:], np.asarray(legs).tolist()):
                    file.write(",".join(map(repr, (start, end, *leg))) + "\n")
        with writing(stage / "motion.png", "wb") as temporary:
            figure.savefig(temporary, dpi=110, format="png")
    return [str(folder / name) for name in WRITTEN if (folder / name).exists()]
