"""The plane around a snake: discs and the walls of a rectangle, and the body's clearance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array

if TYPE_CHECKING:
    from ._motion import Motion
    from ._snake import Snake

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """Discs (`centers` (m, 2), `radii` (m,)) and, if not None, a rectangle (`lower`, `upper`) not to be left; metres."""

    centers: Array
    radii: Array
    lower: Array | None
    upper: Array | None
    notes: tuple[str, ...]

    @staticmethod
    def of(obstacles: Any, workspace: Any) -> Surroundings:
        """From (centers, radii), or a list of plane shapes (others than discs are enclosed in one); `workspace`: two corners."""
        notes: list[str] = []
        if isinstance(obstacles, tuple) and len(obstacles) == 2 and not hasattr(obstacles[0], "bounding_ball"):
            centers = float_array(obstacles[0], "obstacles", last=2).reshape(-1, 2)
            radii = float_array(obstacles[1], "obstacles").reshape(-1)
        else:
            rows = []
            for index, shape in enumerate(obstacles):
                if not hasattr(shape, "bounding_ball"):
                    raise InputError(
                        f"expected plane obstacles, got {type(shape).__name__}",
                        place=f"obstacles[{index}]",
                        remedy="give (centers (m, 2), radii (m,)) or Ball(center (2,), radius)",
                    )
                center, radius = shape.bounding_ball()
                if np.shape(center) != (2,) or not np.isfinite(radius):
                    raise InputError(
                        f"expected a bounded obstacle in the plane, got {type(shape).__name__}",
                        place=f"obstacles[{index}]",
                        remedy="walls are given as workspace=(lower corner, upper corner)",
                    )
                if type(shape).__name__ != "Ball":
                    notes.append(f"obstacle {index} ({type(shape).__name__}) is enclosed in a disc of {radius:.3g} m")
                rows.append((*center, radius))
            table = np.array(rows, dtype=np.float64).reshape(-1, 3)
            centers, radii = table[:, :2].copy(), table[:, 2].copy()
        if len(centers) != len(radii) or (radii.size and radii.min() < 0):
            raise InputError("expected one radius of at least 0 for each centre", place="obstacles")
        lower = upper = None
        if workspace is not None:
            lower, upper = (float_array(corner, "workspace", last=2, ndim=1) for corner in workspace)
            if not (lower < upper).all():
                raise InputError("expected (lower corner, upper corner)", place="workspace")
        return Surroundings(centers, radii, lower, upper, tuple(notes))

    def of_points(self, points: Array) -> Array:
        """Distance of points (..., 2) to the nearest disc or wall, metres, (...,)."""
        walls = self._walls(points)
        if len(self.radii) == 0:
            return walls
        dx = points[..., :1] - self.centers[:, 0]
        dy = points[..., 1:] - self.centers[:, 1]
        return np.minimum(walls, (np.sqrt(dx * dx + dy * dy) - self.radii).min(axis=-1))

    def _walls(self, points: Array) -> Array:
        if self.lower is None or self.upper is None:
            return np.full(points.shape[:-1], np.inf)
        return np.minimum(points - self.lower, self.upper - points).min(axis=-1)

    def of_body(self, joints: Array, half_width: float) -> Array:
        """Clearance of the body, capsules about the links, for joints (..., N+2, 2), metres, (...,)."""
        a, b = joints[..., :-1, :], joints[..., 1:, :]
        along = b - a
        square = (along * along).sum(axis=-1)
        free = self._walls(joints).min(axis=-1)
        for center, radius in zip(self.centers, self.radii):
            to = center - a
            t = np.clip((to * along).sum(axis=-1) / square, 0.0, 1.0)
            gap = to - t[..., None] * along
            free = np.minimum(free, np.sqrt((gap * gap).sum(axis=-1)).min(axis=-1) - radius)
        return free - half_width


def self_distance(joints: Array) -> Array:
    """Least distance between two links that do not share a joint, for joints (..., N+2, 2), metres, (...,): 0 where they cross."""
    links = joints.shape[-2] - 1
    first, second = np.triu_indices(links, 2)
    if not len(first):
        return np.full(joints.shape[:-2], np.inf)
    a, b, c, d = joints[..., first, :], joints[..., first + 1, :], joints[..., second, :], joints[..., second + 1, :]
    ends = ((a, c, d), (b, c, d), (c, a, b), (d, a, b))
    apart = np.min([_to_segment(p, tail, tip) for p, tail, tip in ends], axis=0)
    crosses = (_side(a, b, c) * _side(a, b, d) < 0) & (_side(c, d, a) * _side(c, d, b) < 0)
    return np.where(crosses, 0.0, apart).min(axis=-1)


def _side(a: Array, b: Array, p: Array) -> Array:
    along, to = b - a, p - a
    return along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0]


def _to_segment(p: Array, a: Array, b: Array) -> Array:
    along, to = b - a, p - a
    part = np.clip((to * along).sum(axis=-1) / (along * along).sum(axis=-1), 0.0, 1.0)
    gap = to - part[..., None] * along
    return np.sqrt((gap * gap).sum(axis=-1))


@dataclass(frozen=True, slots=True, eq=False)
class SnakeCertificate:
    """Clearance of the whole body over a motion, in continuous time.

    `clearance`: lower bound over all times and body points, metres; `certified`: it is at least what was asked for;
    `sampled`: least clearance at the sampled postures; `first_violation`: time of the first sample that is too close, or
    None; `unresolved`: time spans that no refinement settled; `samples`: postures looked at; `self_clearance`,
    `self_sampled`: likewise between links that share no joint (neighbours, which share one, are not looked at).

    The bound: joints 1 .. N of a snake move at most at the speed of joint 1 (exactly at it for midpoint wheels) and a
    link's points no faster than its ends, so between two samples the clearance is at least half of (sum of both clearances
    less the furthest that a body point travels). Our derivation.
    """

    certified: bool
    clearance: float
    sampled: float
    first_violation: float | None
    unresolved: tuple[tuple[float, float], ...]
    samples: int
    self_clearance: float = np.inf
    self_sampled: float = np.inf


def certify_motion(
    snake: Snake, motion: Motion, around: Surroundings, half_width: float, required: float
) -> SnakeCertificate:
    """The certificate of a motion under piecewise constant inputs; spans where the bound does not decide are integrated again."""
    free, apart = _distances(snake, motion.q, motion.error, around, half_width)
    travel = _fastest(snake, motion.inputs[:-1]) * np.diff(motion.time)
    return bounded(
        motion.time, free, apart, travel, required, lambda i: _refine(snake, motion, i, around, half_width, required)
    )


def _distances(snake: Snake, q: Array, error: float, around: Surroundings, half_width: float) -> tuple[Array, Array]:
    joints = snake.joints(q)
    reach = error * (1.0 + float(snake.lengths.sum()))
    return around.of_body(joints, half_width) - reach, self_distance(joints) - 2.0 * (half_width + reach)


def bounded(
    time: Array,
    free: Array,
    apart: Array,
    travel: Array,
    required: float,
    refine: Callable[[int], tuple[float, float, int]],
) -> SnakeCertificate:
    """The certificate from clearances at samples and the furthest that a body point travels between them.

    `refine(i)` gives finer bounds of span i (clearance, self-clearance) and the postures it looked at.
    """
    bound = 0.5 * (free[:-1] + free[1:] - travel)
    own = 0.5 * (apart[:-1] + apart[1:] - 2.0 * travel)  # both links may move
    samples, open_spans = len(free), []
    for i in (int(k) for k in np.flatnonzero((bound < required) | (own < 0.0))):
        if min(free[i], free[i + 1]) < required or min(apart[i], apart[i + 1]) < 0.0:
            continue
        bound[i], own[i], used = refine(i)
        samples += used
        if bound[i] < required or own[i] < 0.0:
            open_spans.append((float(time[i]), float(time[i + 1])))
    lowest, own_lowest = (
        float(b.min(initial=x.min() if len(x) == 1 else np.inf)) for b, x in ((bound, free), (own, apart))
    )
    bad = np.flatnonzero((free < required) | (apart < 0.0))
    first = float(time[bad[0]]) if bad.size else None
    return SnakeCertificate(
        lowest >= required and own_lowest >= 0.0,
        lowest,
        float(free.min()),
        first,
        tuple(open_spans),
        samples,
        own_lowest,
        float(apart.min()),
    )


def _fastest(snake: Snake, inputs: Array) -> Array:
    """Largest speed of any body point for inputs (..., 4)."""
    speed = np.hypot(inputs[..., 0], inputs[..., 1])
    growth = max(1.0, snake.wheel_ratio) ** (snake.links - 2)
    speed = speed * growth
    head = np.hypot(inputs[..., 0], inputs[..., 1]) + snake.lengths[0] * np.abs(inputs[..., 2])
    tail = speed + snake.lengths[-1] * (speed * snake.wheel_rates.max() + np.abs(inputs[..., 3]))
    return np.maximum(np.maximum(head, tail), speed)


def _refine(
    snake: Snake, motion: Motion, i: int, around: Surroundings, half_width: float, required: float
) -> tuple[float, float, int]:
    """Lower bounds on one span of constant input, by 16, then 256 finer samples."""
    span = float(motion.time[i + 1] - motion.time[i])
    used, bound, own = 0, -np.inf, -np.inf
    for pieces in (16, 256):
        part = snake.simulate(motion.q[i], np.repeat(motion.inputs[i][None], pieces, axis=0), span, tolerance=1e-9)
        free, apart = _distances(snake, part.q, motion.error + part.error, around, half_width)
        travel = _fastest(snake, part.inputs[:-1]) * np.diff(part.time)
        bound = float((0.5 * (free[:-1] + free[1:] - travel)).min())
        own = float((0.5 * (apart[:-1] + apart[1:]) - travel).min())
        used += len(free)
        if bound >= required and own >= 0.0:
            break
    return bound, own, used
