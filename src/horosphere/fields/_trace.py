"""Following the field: the sampled-data motion, mapped back from the space of balls, and plain integrators for comparison."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ._chart import Identity
from ._path import Path
from ._world import COMPILED

if TYPE_CHECKING:
    from ._field import HarmonicField

Array = NDArray[np.float64]
METHODS = ("clipped", "euler", "rk4", "dop853")


def follow(
    field: HarmonicField, start: Array, step: float, tolerance: float, keep: float, max_steps: int, method: str
) -> Path:
    """The path from a free `start`; arguments as checked by `HarmonicField.trace`."""
    if method == "clipped" and field.world.blend in COMPILED:
        return _clipped(field, start, step, tolerance, keep, max_steps)
    if method == "euler" and field.world.blend in COMPILED and isinstance(field.chart, Identity):
        return _clipped(field, start, step, tolerance, keep, max_steps, clip=False)
    if method == "dop853":
        return _dop853(field, start, step, tolerance, max_steps)
    return _integrated(field, start, step, tolerance, max_steps, method)


def _reason(code: float, max_steps: int) -> str:
    return ("reached", "stalled", f"not reached within {max_steps} steps")[int(code)]


def _clipped(
    field, start: Array, step: float, tolerance: float, keep: float, max_steps: int, clip: bool = True
) -> Path:
    world, chart = field.world, field.chart
    z0 = chart.to_balls(start[None])[0]
    z, (code, closest, length, sideways) = world.trace(z0, step, tolerance, keep, clip, max_steps)
    reason = _reason(code, max_steps)
    notes = [f"{int(sideways)} step(s) turned sideways off the unstable ray"] if sideways else []
    if reason == "stalled":
        d = world.clearances(z[-1:])[0]
        near = np.argsort(d)[:2]
        names = [*field.names, "sensor range"]
        notes.append("stopped beside " + " and ".join(f"{names[k]} ({d[k]:.2g} m)" for k in near))
    if reason == "reached" and (z[-1] != world.goal).any():
        last = _straight_clearance(world, z[-1])
        if last > 0.0:
            length += float(np.linalg.norm(z[-1] - world.goal))
            closest = min(closest, last)
            z = np.concatenate([z, world.goal[None]])
    if isinstance(chart, Identity):
        return Path(z, reason, float(length), float(closest), tuple(notes))
    points, curved = _map_back(field, z, step)
    points[0] = start
    if (z[-1] == world.goal).all():
        points[-1] = field.goal
    if curved:
        notes.append("some straight pieces run so close to a zone that they could not be shown to be free")
    middles = 0.5 * (points[1:] + points[:-1])
    closest = float(field.clearance(np.concatenate([points, middles])).min())
    return Path(points, reason, _length(points), closest, tuple(notes))


def _straight_clearance(world, z: Array) -> float:
    """The least distance to a ball along the straight piece from z to the goal."""
    along = world.goal - z
    t = np.clip(((world.centers - z) @ along) / max(float(along @ along), 1e-300), 0.0, 1.0)
    return float((np.linalg.norm(z + t[:, None] * along - world.centers, axis=1) - world.radii).min(initial=np.inf))


def _map_back(field, z: Array, step: float) -> tuple[Array, bool]:
    """The points whose images are z, with as many between them as straight pieces need to stay free and below `step`.

    The guarantees hold for the curve whose image is the polygon z. A straight piece is shown to be free when it is no longer than the
    clearances at its ends together; longer ones are split on the curve. True as second value where that did not come to an end.
    """
    x = field.chart.from_balls(z)
    d = field.chart.distance(x)
    shortest = 1e-7 * (float(np.abs(x).max()) + 1.0)
    for _ in range(30):
        size = np.linalg.norm(np.diff(x, axis=0), axis=1)
        close = size > np.maximum(d[1:], 0.0) + np.maximum(d[:-1], 0.0)
        split = (size > 1.5 * step) | (close & (size > shortest))
        if not split.any():
            return x, bool(close.any())
        if len(x) > 1_000_000:
            break
        where = np.flatnonzero(split) + 1
        new_z = 0.5 * (z[1:] + z[:-1])[split]
        new_x = field.chart.from_balls(new_z)
        x, z = np.insert(x, where, new_x, axis=0), np.insert(z, where, new_z, axis=0)
        d = np.insert(d, where, field.chart.distance(new_x))
    return x, True


def _integrated(field, start: Array, step: float, tolerance: float, max_steps: int, method: str) -> Path:
    """Full Euler or fourth-order Runge-Kutta steps along the unit direction."""
    x, points = start, [start]
    best, since, patience = np.inf, 0, max(500, int(4.0 * np.linalg.norm(start - field.goal) / step))
    reason = _reason(2, max_steps)
    for _ in range(max_steps):
        away = float(np.linalg.norm(x - field.goal))
        best, since = (away, 0) if away < best - 1e-12 else (best, since + 1)
        if away <= tolerance:
            reason = "reached"
            break
        if since > patience:
            reason = "stalled"
            break
        h = min(step, away)
        k1 = field(x)
        if method == "rk4":
            k2 = field(x + 0.5 * h * k1)
            k3 = field(x + 0.5 * h * k2)
            x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + field(x + h * k3))
        else:
            x = x + h * k1
        points.append(x)
    return _measured(field, np.array(points), reason)


def _dop853(field, start: Array, step: float, tolerance: float, max_steps: int) -> Path:
    """scipy's DOP853 on the unit direction, to 1e-10, with points at most `step` apart."""
    from scipy.integrate import solve_ivp

    def near(_, x: Array) -> float:
        return float(np.linalg.norm(x - field.goal)) - max(tolerance, 1e-9)

    near.terminal = True
    longest = 3.0 * float(np.linalg.norm(start - field.goal)) + 10.0 * float(field.world.radii.sum())
    solution = solve_ivp(
        lambda _, x: field(x),
        (0.0, min(longest, max_steps * step)),
        start,
        "DOP853",
        events=near,
        rtol=1e-10,
        atol=1e-10,
        max_step=step,
    )
    reason = "reached" if solution.status == 1 else "stalled"
    return _measured(field, np.ascontiguousarray(solution.y.T), reason)


def _measured(field, points: Array, reason: str) -> Path:
    fractions = np.linspace(0.0, 1.0, 5)[:-1, None, None]
    dense = np.concatenate([*(points[:-1] + fractions * np.diff(points, axis=0)), points[-1:]])
    return Path(points, reason, _length(points), float(field.clearance(dense).min(initial=np.inf)))


def _length(points: Array) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
