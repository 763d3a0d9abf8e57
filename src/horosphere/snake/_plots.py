"""Pictures: bracket motions, and motions among obstacles. Figures of matplotlib, which the caller saves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._word import read_word, word_text

if TYPE_CHECKING:
    from ._motion import Motion
    from ._snake import Snake
    from ._world import Surroundings

Array = NDArray[np.float64]
_LETTERS = {1: "#1f5a99", 2: "#d6663a", 3: "#2e9f52", 4: "#8a4fb0"}


def _figure(width: float, height: float) -> Any:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def draw_snake(axes: Any, snake: Snake, q: Array, color: str, alpha: float = 1.0, label: str | None = None) -> None:
    """Links, joints, and a bar for each wheel pair."""
    joints, wheels = snake.joints(q), snake.centres(q)
    axes.plot(joints[:, 0], joints[:, 1], "-", color=color, alpha=alpha, linewidth=2.0, label=label)
    axes.plot(joints[1:-1, 0], joints[1:-1, 1], "o", color=color, alpha=alpha, markersize=3)
    axes.plot(joints[0, 0], joints[0, 1], "D", color=color, alpha=alpha, markersize=5)
    along = np.diff(joints, axis=0) / snake.lengths[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)[1:-1]
    for p, n in zip(wheels[1:-1], across):
        ends = np.stack([p - 0.18 * n, p + 0.18 * n])
        axes.plot(ends[:, 0], ends[:, 1], color=color, alpha=alpha, linewidth=3.0, solid_capstyle="butt")


def bracket_figure(snake: Snake, q: ArrayLike, word: Any, t: float = 0.3) -> Any:
    """One bracket motion: the input word in time, the snake before and after with the way of joint 1, and the orders."""
    parsed = read_word(word)
    result = snake.bracket_motion(q, parsed, t)
    figure = _figure(13.0, 4.2)
    left, middle, right = figure.subplots(1, 3)
    start = 0.0
    for letter, duration in result.legs:
        left.barh(f"g{letter}", abs(duration), left=start, color=_LETTERS[letter], alpha=1.0 if duration > 0 else 0.45)
        start += abs(duration)
    left.set_xlabel("time (s); pale: backwards")
    left.set_title(f"input word of {word_text(parsed)}, {len(result.legs)} legs")
    draw_snake(middle, snake, result.motion.q[0], "#888888", label="before")
    draw_snake(middle, snake, result.motion.q[-1], "#1f5a99", label="after")
    way = snake.joints(result.motion.q)[:, 1:-1]
    for j in range(way.shape[1]):
        middle.plot(
            way[:, j, 0], way[:, j, 1], color="#d6663a", linewidth=0.8, label="ways of the joints" if j == 0 else None
        )
    middle.set_aspect("equal")
    middle.legend(fontsize=8)
    middle.set_title("displacement")
    times = t * 2.0 ** -np.arange(6)
    sizes, rests = [], []
    for leg in times:
        run = snake.bracket_motion(q, parsed, float(leg))
        sizes.append(np.linalg.norm(run.measured))
        rests.append(np.linalg.norm(run.measured - run.predicted))
    right.loglog(times, sizes, "o-", color="#1f5a99", label="displacement")
    right.loglog(times, np.maximum(rests, 1e-17), "s--", color="#d6663a", label="displacement less prediction")
    for power in (result.degree, result.degree + 1):
        right.loglog(times, sizes[0] * (times / t) ** power, ":", color="#888888", linewidth=1.0, label=f"t^{power}")
    right.set_xlabel("leg time t (s)")
    right.legend(fontsize=8)
    right.set_title(f"measured order {result.order:.2f}, degree {result.degree}")
    return figure


def motion_figure(
    snake: Snake, motion: Motion, around: Surroundings | None = None, path: Array | None = None, snapshots: int = 7
) -> Any:
    """The motion from above with wheels and track; singularity measure, clearance and constraint residual in time."""
    joints = snake.joints(motion.q)
    # the sheet is as high as the picture needs at its width
    seen = [joints.reshape(-1, 2)]
    if around is not None:
        seen += [around.centers - around.radii[:, None], around.centers + around.radii[:, None]]
        seen += [] if around.lower is None or around.upper is None else [around.lower[None], around.upper[None]]
    low_corner, high_corner = (f([f(part, axis=0) for part in seen if len(part)], axis=0) for f in (np.min, np.max))
    wide, tall = high_corner - low_corner + 1.0
    top_height = float(np.clip(11.0 * tall / wide, 2.2, 8.0)) + 0.5
    figure = _figure(11.0, top_height + 2.6)
    grid = figure.add_gridspec(2, 3 if around is not None else 2, height_ratios=(top_height, 2.1))
    top = figure.add_subplot(grid[0, :])
    if around is not None:
        from matplotlib.patches import Circle, Rectangle

        for center, radius in zip(around.centers, around.radii):
            top.add_patch(Circle(tuple(center), float(radius), color="#bbbbbb"))
        if around.lower is not None and around.upper is not None:
            size = around.upper - around.lower
            top.add_patch(Rectangle(tuple(around.lower), *size, fill=False, color="#666666"))
    if path is not None and len(path):
        top.plot(path[:, 0], path[:, 1], "--", color="#2e9f52", linewidth=1.0, label="path of joint 1")
    top.plot(joints[:, -2, 0], joints[:, -2, 1], color="#d6663a", linewidth=0.8, label="way of the last joint")
    for k, index in enumerate(np.linspace(0, len(motion.time) - 1, snapshots).astype(int)):
        draw_snake(top, snake, motion.q[index], "#1f5a99", 0.25 + 0.75 * k / max(1, snapshots - 1))
    top.set_aspect("equal")
    top.set_xlim(low_corner[0] - 0.5, high_corner[0] + 0.5)
    top.set_ylim(low_corner[1] - 0.5, high_corner[1] + 0.5)
    top.legend(fontsize=8, loc="best", ncols=2)
    first, second, *third = (figure.add_subplot(grid[1, k]) for k in range(grid.ncols))
    first.plot(motion.time, snake.singularity(motion.q), color="#8a4fb0")
    first.set_title("singularity measure (0: wheel axes meet)", fontsize=9)
    rates = snake.angle_rates(snake.to_angles(motion.q), motion.inputs)
    slip = np.abs(np.einsum("kij,kj->ki", snake.pfaff(motion.q), rates)).max(axis=1)
    second.semilogy(motion.time, np.maximum(slip, 1e-18), color="#2aa3a8", linewidth=0.8)
    second.set_title("constraint residual (m/s)", fontsize=9)
    if around is not None:
        third[0].plot(motion.time, around.of_body(joints, 0.0), color="#1f5a99")
        third[0].set_ylim(bottom=0.0)
        third[0].set_title("distance of the centre line to the obstacles (m)", fontsize=9)
    for axes in (first, second, *third):
        axes.set_xlabel("time (s)")
    return figure
