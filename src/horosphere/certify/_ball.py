"""Clearance of a ball whose centre runs along a polyline in R^n."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..scenes import Aerofoil, EllipsoidND, Star
from ..shapes import Ball
from ._outlines import aerofoil_distance, ellipsoid_distance, star_distance

Floats = NDArray[np.float64]
TOLERANCE, RELATIVE = 1e-6, 1e-3
MAX_POINTS = 400_000


@dataclass(frozen=True, slots=True)
class BallClearance:
    """Least clearance of the moving ball to one obstacle: bounds (m), where the upper one was seen, points looked at.

    `first`: segment and fraction of the first sample below the margin, with its clearance, or None.
    """

    lower: float
    upper: float
    segment: int
    fraction: float
    first: tuple[int, float, float] | None
    evaluations: int


def distance_function(obstacle: Any) -> Callable[[Floats], Floats]:
    """Signed distance of points (m, n), exact or a lower bound by a stated 1e-6 of the size; changes at most 1 m per metre."""
    if isinstance(obstacle, EllipsoidND):
        return ellipsoid_distance(obstacle)
    if isinstance(obstacle, Star):
        return star_distance(obstacle)
    if isinstance(obstacle, Aerofoil):
        return aerofoil_distance(obstacle)
    if not hasattr(obstacle, "signed_distance"):
        raise InputError(f"no distance to a {type(obstacle).__name__}", place="obstacles")
    return obstacle.signed_distance


def ball_clearance(path: Floats, radius: float, obstacle: Any, margin: float, slack: float) -> BallClearance:
    """Bounds by bisection: a distance falls by at most half the length of an interval from its middle.

    path (k, n). A Ball is exact in closed form. Our derivation.
    """
    start = path[:-1] if len(path) > 1 else path
    step = np.diff(path, axis=0) if len(path) > 1 else np.zeros_like(path)
    if isinstance(obstacle, Ball):
        return _to_ball(start, step, radius, obstacle, margin, slack)
    distance = distance_function(obstacle)
    length = np.linalg.norm(step, axis=1)
    segment, middle, half = np.arange(len(start)), np.full(len(start), 0.5), np.full(len(start), 0.5)
    ends = distance(path) - radius
    k = int(ends.argmin())
    upper, at = float(ends[k]), _moment(k)
    lower, used = np.inf, len(path)
    below = [_moment(i) for i, d in enumerate(ends.tolist()) if d + slack < margin]
    while len(segment):
        points = start[segment] + middle[:, None] * step[segment]
        d = distance(points) - radius
        used += len(d)
        k = int(d.argmin())
        if d[k] < upper:
            upper, at = float(d[k]), (int(segment[k]), float(middle[k]))
        below += [(int(segment[i]), float(middle[i])) for i in np.flatnonzero(d + slack < margin)[:1]]
        bound = d - length[segment] * half - slack
        need = upper - max(TOLERANCE, RELATIVE * abs(upper))
        if upper + slack >= margin:
            need = max(need, margin)
        open_ = (bound < need) & (length[segment] * half > 1e-9)
        if used > MAX_POINTS:
            open_[:] = False
        lower = min(lower, float(bound[~open_].min(initial=np.inf)))
        segment, middle, half = segment[open_], middle[open_], half[open_]
        segment = np.repeat(segment, 2)
        middle = (middle[:, None] + 0.5 * half[:, None] * np.array([-1.0, 1.0])).ravel()
        half = np.repeat(0.5 * half, 2)
    first = None
    if below:
        first = _refine(min(below), start, step, distance, radius, margin, slack)
    return BallClearance(lower, upper, *at, first, used)


def _moment(waypoint: int) -> tuple[int, float]:
    return (waypoint - 1, 1.0) if waypoint > 0 else (0, 0.0)


def _to_ball(start: Floats, step: Floats, radius: float, ball: Ball, margin: float, slack: float) -> BallClearance:
    to = ball.center - start
    square = (step**2).sum(axis=1)
    t = np.clip((to * step).sum(axis=1) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    d = np.linalg.norm(to - t[:, None] * step, axis=1) - ball.radius - radius
    k = int(d.argmin())
    first = None
    hit = np.flatnonzero(d + slack < margin)
    if len(hit):
        i = int(hit[0])

        def distance(points: Floats) -> Floats:
            return ball.signed_distance(points)

        first = _refine((i, float(t[i])), start, step, distance, radius, margin, slack)
    return BallClearance(float(d[k]) - slack, float(d[k]), k, float(t[k]), first, len(d))


def _refine(
    seen: tuple[int, float],
    start: Floats,
    step: Floats,
    distance: Callable[[Floats], Floats],
    radius: float,
    margin: float,
    slack: float,
) -> tuple[int, float, float]:
    """The first moment below the margin up to `seen`: a walk by what the clearance allows, at least 1e-5."""
    length = np.linalg.norm(step, axis=1)
    for i in range(seen[0] + 1):
        t, stop = 0.0, seen[1] if i == seen[0] else 1.0
        while t <= stop:
            d = float(distance((start[i] + t * step[i])[None])[0]) - radius
            if d + slack < margin:
                return i, t, d
            if length[i] == 0.0:
                break
            t += max((d - margin) / length[i], 1e-5)
    i, t = seen
    return i, t, float(distance((start[i] + t * step[i])[None])[0]) - radius
