"""The report: one HTML file with the verdict, the moving scene and the curves, which opens from disk without a network."""

from __future__ import annotations

import html
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scenes import Scene, Trajectory
from ._measure import measure
from ._plots import plots
from ._recording import REST, record
from ._summary import Summary, summarise

_STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0; font: 15px/1.5 system-ui, -apple-system, "Segoe UI", sans-serif; color: #222; background: #f4f4f1; }
main { max-width: 1180px; margin: 0 auto; padding: 20px 24px 40px; }
h1 { font-size: 21px; margin: 0 0 4px; } h2 { font-size: 15px; margin: 0 0 6px; }
.about { color: #666; margin: 0 0 14px; white-space: pre-line; }
.verdict { padding: 12px 16px; border-radius: 8px; font-size: 17px; font-weight: 600; color: #fff; margin: 0 0 16px; }
.good { background: #2e7d46; } .bad { background: #a83232; }
.scene { height: 62vh; min-height: 420px; border-radius: 8px; overflow: hidden; background: #fff; border: 1px solid #ddd; }
iframe { width: 100%; height: 100%; border: 0; display: block; }
.legend { color: #666; font-size: 13px; margin: 6px 0 18px; }
.key { display: inline-block; width: 10px; height: 10px; border-radius: 5px; margin: 0 4px 0 12px; }
.cards { columns: 2 420px; column-gap: 16px; }
.card { break-inside: avoid; margin-bottom: 16px; background: #fff; border: 1px solid #ddd;
  border-radius: 8px; padding: 14px 16px; overflow: hidden; }
.card svg { width: 100%; height: auto; display: block; }
table { border-collapse: collapse; width: 100%; } td { padding: 4px 0; vertical-align: top; border-top: 1px solid #eee; }
tr:first-child td { border-top: 0; } td:first-child { color: #666; padding-right: 16px; white-space: nowrap; width: 1%; }
ul { margin: 0; padding-left: 18px; } footer { color: #888; font-size: 12.5px; margin-top: 18px; }
"""


def report_html(
    scene: Scene,
    trajectory: Trajectory | None,
    *,
    certificate: Any = None,
    solved: bool | None = None,
    reason: str = "",
    solved_by: str | None = None,
    timings: dict[str, float] | None = None,
    notes: tuple[str, ...] = (),
    path: NDArray[np.float64] | None = None,
) -> str:
    """The whole page. Everything is inside it: the animation (an `iframe srcdoc`), curves (SVG), style.

    `solved` None: the motion was checked, not planned. Raises InputError if viser (the extra `view`) is not there.
    """
    measures = None if trajectory is None else measure(scene, trajectory)
    summary = summarise(
        scene,
        trajectory,
        measures,
        certificate=certificate,
        solved=solved,
        reason=reason,
        solved_by=solved_by,
        timings=timings,
        notes=notes,
    )
    player = record(scene, trajectory, path)
    moves = trajectory is not None and len(trajectory) > 1
    curves = {} if measures is None or trajectory is None or len(trajectory) < 2 else plots(scene, measures)
    return page(scene, summary, player, curves, moves=moves)


def legend(scene: Scene, *, moves: bool) -> str:
    """How to look round, and a key for each thing that is drawn, as HTML. `moves`: there is a motion to see."""
    posed = moves or hasattr(scene.start, "q") or not hasattr(scene.robot, "limits")
    robot = "robot" if posed else "robot (amid its joint limits, not at the start)"
    keys = [("#1f5a99", robot), ("#9a9a9a", "start (its posture faint)" if moves else "start"), ("#2ea043", "goal")]
    keys += [("#d66e46", "obstacles")] * bool(scene.obstacles) + [("#1e1e1e", "path of the tool")] * moves
    shown = "".join(f'<span class="key" style="background:{color}"></span>{name}' for color, name in keys)
    time = f"; the slider moves time, and for its last {REST:g} s the robot rests at the end" if moves else ""
    return f'<p class="legend">Drag to turn, scroll to zoom{time}.{shown}</p>'


def document(title: str, body: str) -> str:
    """A page with our style and its footer; title and body are HTML already."""
    from importlib.metadata import version

    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">'
        f"<style>{_STYLE}</style></head><body><main><h1>{title}</h1>{body}"
        f"<footer>horosphere {version('horosphere')}. Lengths in metres unless they say otherwise. "
        "This file needs no network.</footer></main></body></html>\n"
    )


def scene_frame(player: str) -> str:
    """The recording inside a page."""
    return f'<div class="scene"><iframe title="animation" srcdoc="{html.escape(player, quote=True)}"></iframe></div>'


def page(scene: Scene, summary: Summary, player: str, curves: dict[str, str], *, moves: bool = True) -> str:
    """The parts put together."""
    e = html.escape
    rows = "".join(f"<tr><td>{e(label)}</td><td>{e(value)}</td></tr>" for label, value in summary.rows)
    cards = [f'<section class="card"><h2>Result</h2><table>{rows}</table></section>']
    cards += [f'<section class="card"><h2>{e(title)}</h2>{svg}</section>' for title, svg in curves.items()]
    if summary.notes:
        items = "".join(f"<li>{e(note)}</li>" for note in summary.notes)
        cards.append(f'<section class="card"><h2>Notes</h2><ul>{items}</ul></section>')
    about = f'<p class="about">{e(scene.description)}</p>' if scene.description else ""
    verdict = f'<p class="verdict {"good" if summary.good else "bad"}" id="verdict">{e(summary.verdict)}</p>'
    shown = scene_frame(player) + legend(scene, moves=moves)
    return document(e(scene.name), f'{about}{verdict}{shown}<div class="cards">{"".join(cards)}</div>')
