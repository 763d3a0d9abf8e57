"""The picture of a planar field: equipotentials, gradient lines, zones, unstable points, the motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..maps import Joukowski
from ._chart import Conformal

if TYPE_CHECKING:
    from ._field import HarmonicField

Array = NDArray[np.float64]
INK, ZONE, MOTION, GOAL, SADDLE = "#1b2a41", "#c9ced6", "#d1495b", "#0b6e4f", "#e09f3e"


def plot_field(
    field: HarmonicField,
    path: Any = None,
    *,
    ax: Any = None,
    extent: tuple[float, float, float, float] | None = None,
    resolution: int = 240,
    lines: int = 48,
    title: str | None = None,
    unit: str = "m",
) -> Any:
    """Draw a field of the plane on matplotlib axes `ax` (new ones by default) and return them.

    `path`: a `Path`, points (k, 2), or a list of them; `extent` = (left, right, bottom, top) metres, by default what is there and a
    fifth more; `resolution` samples a side; `lines` how many gradient lines are drawn, from points spread evenly over the frame.
    Zones carry their margin.
    Raises InputError for a field that is not planar.
    """
    if field.dimension != 2:
        raise InputError(
            f"a picture shows a field of the plane, this one lies in R^{field.dimension}",
            place="plot",
            remedy="draw a section with your own plane, or its distances by `plot_distances`",
        )
    import matplotlib.pyplot as plt

    paths = [] if path is None else path if isinstance(path, (list, tuple)) else [path]
    tracks = [np.asarray(getattr(p, "points", p), dtype=np.float64) for p in paths]
    outlines = zone_outlines(field)
    left, right, bottom, top = extent or _extent(field, outlines, tracks)
    if ax is None:
        # the frame fills the width of the page, below it stands the legend
        width = 7.2 if top - bottom < 1.2 * (right - left) else 5.4
        _, ax = plt.subplots(
            figsize=(width, 0.92 * width * (top - bottom) / (right - left) + 1.3), layout="constrained"
        )
    x, y = np.meshgrid(np.linspace(left, right, resolution), np.linspace(bottom, top, resolution))
    points = np.stack([x, y], axis=-1)
    inside = _in_zones(field, points.reshape(-1, 2)).reshape(x.shape)
    if len(np.unique(field.world.exponents)) <= 1:
        with np.errstate(divide="ignore"):
            height_map = np.where(inside, np.nan, field.potential(points))
        low, high = np.nanpercentile(height_map[np.isfinite(height_map)], [3.0, 99.0])
        levels = np.linspace(low, high, 26)
        ax.contourf(x, y, height_map, levels, cmap="Blues", extend="both", alpha=0.75)
        ax.contour(x, y, height_map, levels, colors="white", linewidths=0.7, linestyles="solid")
    _draw_lines(field, ax, (left, right, bottom, top), lines)
    for k, outline in enumerate(outlines):
        name = "security zone" if k == 0 else None
        ax.fill(*outline.T, facecolor=ZONE, edgecolor=INK, linewidth=1.2, zorder=3, label=name)
    _draw_walls(field, ax, left, right, bottom, top)
    saddles = field.unstable_points()
    if len(saddles):
        ax.plot(*saddles.T, "o", color=SADDLE, markeredgecolor=INK, markersize=6, zorder=5, label="unstable point")
    for k, track in enumerate(tracks):
        ax.plot(*track.T, color=MOTION, linewidth=2.2, zorder=6, label="motion" if k == 0 else None)
        ax.plot(
            *track[0],
            "s",
            color=MOTION,
            markeredgecolor="white",
            markersize=7,
            zorder=7,
            label="start" if k == 0 else None,
        )
    ax.plot(*field.goal, "*", color=GOAL, markeredgecolor="white", markersize=16, zorder=8, label="goal")
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xlabel=f"x [{unit}]", ylabel=f"y [{unit}]")
    if title:
        ax.set_title(title)
    _add_legend(ax)
    return ax


def _add_legend(ax: Any) -> None:
    """Below the frame, where it covers nothing; the white lines on a patch of the background."""
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    from matplotlib.transforms import ScaledTranslation

    handles, names = ax.get_legend_handles_labels()
    drawn = dict(zip(names, handles))
    if ax.collections:
        drawn["equipotential"] = (Patch(facecolor="#6aa5d0"), Line2D([], [], color="white", linewidth=1.2))
    order = ("motion", "start", "goal", "unstable point", "gradient line", "equipotential", "security zone")
    shown = [name for name in order if name in drawn]
    ax.legend(
        [drawn[name] for name in shown],
        shown,
        handler_map={tuple: HandlerTuple(ndivide=1, pad=0.0)},
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=ax.transAxes + ScaledTranslation(0.0, -34.0 / 72.0, ax.figure.dpi_scale_trans),
        ncols=4,
        fontsize=8,
        frameon=False,
    )


def _draw_lines(field: HarmonicField, ax: Any, extent: tuple[float, float, float, float], count: int) -> None:
    left, right, bottom, top = extent
    width, height = right - left, top - bottom
    corners = np.array([[left, bottom], [right, bottom], [right, top], [left, top], [left, bottom]])
    at = (np.arange(count) + 0.5) * 2.0 * (width + height) / max(count, 1)
    ends = np.cumsum([0.0, width, height, width, height])
    name: str | None = "gradient line"
    for seed in np.stack([np.interp(at, ends, corners[:, k]) for k in (0, 1)], axis=-1):
        if field.obstructed(seed):
            continue
        line = field.trace(seed, step=max(width, height) / 150.0, max_steps=3000).points
        ax.plot(*line.T, color=INK, linewidth=0.6, zorder=2, label=name)
        name = None
        walked = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        for share in (0.25, 0.6):
            k = int(np.searchsorted(walked, share * walked[-1]))
            if 0 < k < len(line) and walked[-1] > 0.2 * height:
                ax.annotate(
                    "",
                    line[k],
                    line[k - 1],
                    arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 0.6, "mutation_scale": 7},
                    zorder=2,
                )


def zone_outlines(field: HarmonicField) -> list[Array]:
    """The outlines (k, 2) of the zones of a planar field, margin included."""
    if isinstance(field.chart, Conformal):
        shape: Joukowski = field.chart.shape
        return [shape.boundary(400, shape.margin)]
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    u = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    balls = len(field.world.radii) - len(field.stars)
    round_ = [c + r * u for c, r in zip(field.world.centers[:balls], field.world.radii[:balls])]
    return round_ + [star.center + star.radial(u)[0][:, None] * u for star in field.stars]


def _in_zones(field: HarmonicField, points: Array) -> NDArray[np.bool_]:
    z = field.chart.to_balls(points)
    m = len(field.world.radii)
    inside = np.asarray((field.world.clearances(z)[:, :m] < 0.0).any(axis=1))
    for star in field.stars:
        inside |= star.contains(points)
    return inside


def _extent(field: HarmonicField, outlines: list[Array], tracks: list[Array]) -> tuple[float, float, float, float]:
    everything = np.concatenate([field.goal[None], *outlines, *tracks])
    low, high = everything.min(axis=0), everything.max(axis=0)
    spare = 0.2 * max(float((high - low).max()), 0.1)
    middle, half = 0.5 * (low + high), np.maximum(0.5 * (high - low) + spare, 0.35 * float((high - low).max()) + spare)
    return (*(middle[0] + [-half[0], half[0]]), *(middle[1] + [-half[1], half[1]]))


def _draw_walls(field: HarmonicField, ax: Any, left: float, right: float, bottom: float, top: float) -> None:
    corners = np.array([[left, bottom], [right, bottom], [right, top], [left, top]])
    for wall in field.world.walls:
        if wall[-1] > 0.0:
            from matplotlib.patches import Circle

            ax.add_patch(Circle(tuple(wall[:2]), wall[-1], fill=False, edgecolor=INK, linewidth=2.0, zorder=4))
            continue
        d = corners @ wall[:2] - wall[2]
        solid = []
        for k in range(4):
            j = (k + 1) % 4
            if d[k] <= 0.0:
                solid.append(corners[k])
            if d[k] * d[j] < 0.0:
                solid.append(corners[k] + (corners[j] - corners[k]) * d[k] / (d[k] - d[j]))
        if len(solid) > 2:
            ax.fill(*np.array(solid).T, facecolor=ZONE, edgecolor=INK, linewidth=1.2, hatch="//", zorder=3)
