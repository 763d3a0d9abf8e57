"""Curves over time as SVG."""

from __future__ import annotations

import io
import re
from typing import Any

import numpy as np

from ..scenes import Scene
from ._measure import Measures

INK, GRID = "#333333", "#dddddd"
COLORS = ("#1f5a99", "#d6663a", "#2e9f52", "#8a4fb0", "#b8962e", "#2aa3a8", "#c0507f", "#6b6b6b")


def plots(scene: Scene, measures: Measures) -> dict[str, str]:
    """SVG texts by title: clearance, distance to the goal, joints (or coordinates); what cannot be measured is left out."""
    result = {}
    required, unit = scene.options.clearance, getattr(scene.robot, "unit", "m")
    if measures.clearance is not None:
        result["Clearance"] = _clearance(measures, required, unit)
    if measures.to_goal is not None:
        result["Distance to the goal"] = _to_goal(measures, unit)
    result[_coordinates(scene)[0]] = _joints(scene, measures)
    if measures.singularity is not None:
        result["Singularity measure"] = _singularity(measures)
    if measures.slip is not None:
        result["Constraint residual"] = _slip(measures.slip)
    return result


def _figure(salt: str) -> tuple[Any, Any]:
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 2.9), layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    axes.grid(color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(INK)
    axes.set_xlabel("time [s]")
    figure._horosphere_salt = salt  # type: ignore[attr-defined]
    return figure, axes


def _svg(figure: Any) -> str:
    import matplotlib

    buffer = io.StringIO()
    settings: Any = {"svg.hashsalt": figure._horosphere_salt, "svg.fonttype": "none", "font.family": "sans-serif"}
    with matplotlib.rc_context(settings):
        figure.savefig(
            buffer,
            format="svg",
            transparent=True,
            metadata={"Date": None, "Creator": None, "Format": None, "Type": None},
        )
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    # Several curves share one page: their ids must not meet.
    return re.sub(r'(\sid="|url\(#|href="#)', rf"\1{figure._horosphere_salt}-", text)


def _clearance(m: Measures, required: float, unit: str) -> str:
    figure, axes = _figure("clearance")
    assert m.clearance is not None
    axes.plot(m.time, 1e3 * m.clearance, color=COLORS[0], linewidth=1.8, label="robot to obstacles")
    axes.axhline(1e3 * required, color=COLORS[2], linewidth=1.2, linestyle="--", label="required")
    axes.axhline(0.0, color="#b03030", linewidth=1.2, label="contact")
    lowest = int(np.argmin(m.clearance))
    axes.plot(m.time[lowest], 1e3 * m.clearance[lowest], "o", color=COLORS[0], markersize=5)
    low, high = min(0.0, float(m.clearance.min())), max(required, float(m.clearance.max()))
    axes.set_ylim(1e3 * (low - 0.06 * (high - low)), 1e3 * (high + 0.06 * (high - low)))
    axes.set_ylabel(f"clearance [m{unit}]")
    axes.legend(frameon=False, fontsize=8, loc="best")
    return _svg(figure)


def _to_goal(m: Measures, unit: str) -> str:
    figure, axes = _figure("goal")
    assert m.to_goal is not None
    axes.plot(m.time, m.to_goal, color=COLORS[0], linewidth=1.8)
    axes.set_ylim(bottom=min(0.0, float(m.to_goal.min())))
    axes.set_ylabel(f"distance [{unit}]")
    return _svg(figure)


def _singularity(m: Measures) -> str:
    figure, axes = _figure("singularity")
    assert m.singularity is not None
    axes.plot(m.time, m.singularity, color=COLORS[3], linewidth=1.5)
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel("0: all wheel axes meet")
    return _svg(figure)


def _slip(slip: np.ndarray) -> str:
    figure, axes = _figure("slip")
    kept = slip[:, :: max(1, slip.shape[1] // 1200)]
    axes.semilogy(kept[0], np.maximum(kept[1], 1e-18), color=COLORS[5], linewidth=1.0)
    axes.set_ylabel("sideways speed of a wheel [m/s]")
    return _svg(figure)


def _coordinates(scene: Scene) -> tuple[str, list[str], list[bool]]:
    """Title, names, and which of them are angles."""
    robot: Any = scene.robot
    if not hasattr(robot, "joint_names"):
        kind = type(robot).__name__
        if kind == "PointRobot":
            names = [f"x{j + 1}" for j in range(robot.dimension)]
            return "Coordinates", names, [robot.unit == "rad"] * robot.dimension
        if kind == "UnicycleRobot":
            return "Coordinates", ["x", "y", "heading"], [False, False, True]
        names = ["x", "y", "theta", *(f"Phi{j + 1}" for j in range(robot.links - 1))]
        return "Coordinates", names, [False, False] + [True] * robot.links
    sliding = {link.coordinate for link in robot.links if link.kind == "prismatic"}
    return "Joints", list(robot.joint_names), [j not in sliding for j in range(robot.n_joints)]


def _joints(scene: Scene, m: Measures) -> str:
    _, names, angles = _coordinates(scene)
    figure, axes = _figure("joints")
    for j in range(m.q.shape[1]):
        factor = 180.0 / np.pi if j < len(angles) and angles[j] else 1.0
        name = names[j] if j < len(names) else f"q{j + 1}"
        axes.plot(m.time, factor * m.q[:, j], color=COLORS[j % len(COLORS)], linewidth=1.5, label=name)
    mixed = len(set(angles)) > 1
    axes.set_ylabel("degrees, metres" if mixed else "angle [deg]" if angles and angles[0] else "position [m]")
    axes.legend(frameon=False, fontsize=7.5, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return _svg(figure)
