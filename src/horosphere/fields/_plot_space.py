"""The picture of a field in space: zones, gradient lines, the motion; its distances, and which zones count along it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._plot import GOAL, INK, MOTION

if TYPE_CHECKING:
    from ._field import HarmonicField

Array = NDArray[np.float64]
BODY = "#8aa0b8"
COLORS = ("#33658a", "#0b6e4f", "#e09f3e", "#d1495b", "#7b5ea7", "#5c946e", "#a44a3f", "#3d5a80")


def plot_space(
    field: HarmonicField,
    path: Any = None,
    *,
    ax: Any = None,
    lines: int = 16,
    title: str | None = None,
    unit: str = "m",
) -> Any:
    """Draw a field of space on 3-D axes `ax` and return them; new ones stand beside the distances along the motion.

    `path`: a `Path` or points (k, 3); `lines` how many gradient lines are drawn, from points about the start (or the farthest zone).
    Zones carry their margin; a zone counts where its weight is not zero ([Rn] Fig. 5).
    """
    import matplotlib.pyplot as plt
    from matplotlib.ticker import MaxNLocator

    track = None if path is None else np.asarray(getattr(path, "points", path), dtype=np.float64)
    if ax is None:
        side_by_side = track is not None and len(field.names) > 0
        figure = plt.figure(figsize=(11.0, 5.0) if side_by_side else (6.4, 5.6), layout="constrained")
        grid = figure.add_gridspec(2, 2 if side_by_side else 1, height_ratios=[3, 1])
        ax = figure.add_subplot(grid[:, 0], projection="3d")
        if track is not None and side_by_side:
            plot_distances(field, track, figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1]), unit)
    for surface in zone_surfaces(field):
        ax.plot_surface(*np.moveaxis(surface, -1, 0), color=BODY, alpha=0.45, linewidth=0)
    for k, line in enumerate(_lines_about(field, track, lines)):
        ax.plot(*line.T, color=INK, linewidth=0.6, alpha=0.7, label="gradient lines" if k == 0 else None)
    saddles = field.unstable_points()
    if track is not None:
        ax.plot(*track.T, color=MOTION, linewidth=2.4, label="motion")
        ax.plot(*track[0][:, None], "s", color=MOTION, markersize=6, label="start")
    if len(saddles) and len(saddles) <= 12:
        ax.plot(*saddles.T, "o", color="#e09f3e", markeredgecolor=INK, markersize=5, label="unstable points")
    ax.plot(*field.goal[:, None], "*", color=GOAL, markersize=13, label="goal")
    names = "xyz" if unit == "m" else ("x1", "x2", "x3")
    ax.set(**{f"{axis}label": f"{name} [{unit}]" for axis, name in zip("xyz", names)})
    # one scale on all axes, room for the labels
    ax.set_box_aspect([np.ptp(limits) for limits in (ax.get_xlim(), ax.get_ylim(), ax.get_zlim())], zoom=0.87)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(MaxNLocator(4))
        axis.labelpad = 7.0  # clear of the numbers
    ax.legend(loc="upper left", frameon=False, fontsize=8)
    if title:
        ax.set_title(title)
    return ax


def plot_distances(field: HarmonicField, track: Array, upper: Any, lower: Any, unit: str = "m") -> None:
    """Distances to the zones along `track` (k, n) on axes `upper`, and on `lower` where each of them counts; any dimension."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(track, axis=0), axis=1))])
    m = len(field.world.radii)
    distances, weights = field.world.clearances(track), field.weights(track)
    for k, star in enumerate(field.stars, m - len(field.stars)):
        distances[:, k] = star.distance(track)
    counts = [k for k in range(len(field.names)) if (weights[:, k] > 0.0).any()]
    for k in range(len(field.names)):
        if k not in counts and len(field.names) <= 40:
            upper.plot(way, distances[:, k], color="#c9ced6", linewidth=0.7)
    for row, k in enumerate(counts):
        color = COLORS[row % len(COLORS)]
        upper.plot(way, distances[:, k], color=color, label=field.names[k])
        lower.plot(
            way, np.where(weights[:, k] > 0.0, row + 1.0, np.nan), color=color, linewidth=5, solid_capstyle="butt"
        )
    upper.set(ylabel=f"distance to the zone [{unit}]", title="distances, and which zones count", xlim=(0.0, way[-1]))
    upper.set_ylim(0.0, 1.05 * float(distances[:, counts].max(initial=0.1)))
    upper.legend(frameon=False, fontsize=8, ncols=1 + len(counts) // 9)
    small = {"fontsize": 8 if len(counts) <= 8 else 5}
    lower.set(xlabel=f"way [{unit}]", ylim=(0.4, len(counts) + 0.6), xlim=(0.0, way[-1]))
    lower.set_yticks(range(1, len(counts) + 1), [field.names[k] for k in counts], **small)


def zone_surfaces(field: HarmonicField) -> list[Array]:
    """Grids (40, 20, 3) on the surfaces of the zones, margin included."""
    u, v = np.mgrid[0 : 2 * np.pi : 40j, 0 : np.pi : 20j]
    ball = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    balls = len(field.world.radii) - len(field.stars)
    round_ = [c + r * ball for c, r in zip(field.world.centers[:balls], field.world.radii[:balls])]
    return round_ + [star.center + star.radial(ball)[0][..., None] * ball for star in field.stars]


def _lines_about(field: HarmonicField, track: Array | None, count: int) -> list[Array]:
    """Motions from a disc about the start, across the way to the goal."""
    if len(field.world.radii) == 0 or count == 0:
        return []
    start = track[0] if track is not None else 1.6 * (field.world.centers.mean(axis=0) - field.goal) + field.goal
    ahead = field.goal - start
    away = float(np.linalg.norm(ahead))
    across = np.linalg.svd(ahead[None])[2][1:]
    turn, size = np.pi * (3.0 - 5.0**0.5), min(1.2 * float(field.world.radii.mean()), 0.3 * away)
    seeds = [
        start + size * np.sqrt((k + 0.5) / count) * (np.cos(turn * k) * across[0] + np.sin(turn * k) * across[1])
        for k in range(count)
    ]
    return [field.trace(seed, step=away / 200.0).points for seed in seeds if field.obstructed(seed) is None]
