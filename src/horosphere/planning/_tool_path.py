"""The path of the tool point: along the harmonic field among the obstacles, grown by the tool's radius."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..distance import pack_obstacles
from ..errors import InputError
from ..fields import HarmonicField
from ..robots import Robot
from ..scenes import Scene
from ..shapes import Ball, HalfSpace
from ._clearance import arm

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ToolPath:
    """`points` (k, 3) from the start to the goal, or None and the reason; `notes` says which obstacles it ignores."""

    points: Floats | None
    reason: str = ""
    notes: tuple[str, ...] = ()


def tool_radius(robot: Robot) -> float:
    """The radius of a ball about the tool point that the tip link fills: the largest of its capsules that reach there."""
    from ..versors import Motor

    point = Motor._wrap(robot.tool).as_matrix()[:3, 3]
    bodies = robot.capsules
    radius = 0.0
    for k in np.flatnonzero(bodies.link == robot.tip):
        a, u = bodies.a[k], bodies.b[k] - bodies.a[k]
        t = np.clip((point - a) @ u / max(u @ u, 1e-300), 0.0, 1.0)
        if np.linalg.norm(point - a - t * u) <= bodies.radius[k] * (1.0 + 1e-9):
            radius = max(radius, float(bodies.radius[k]))
    return radius


def tool_path(scene: Scene, start: Floats, goal: Floats, step: float, wider: dict[str, float]) -> ToolPath:
    """Follow the field from `start` to `goal` (3,) in steps of at most `step` metres.

    Obstacles that are not balls enter as their bounding balls; one whose ball holds the start or the goal is left to the
    choice of the configurations, which looks at every obstacle as it is. `wider`: metres by which the path keeps further
    from the obstacles of these names, for the sake of the links behind the tool.
    """
    grown = tool_radius(arm(scene)) + scene.options.clearance
    centers, radii, unseen = [], [], {}
    touchable = _touchable(arm(scene))
    for k, shape in enumerate(scene.obstacles):
        name = pack_obstacles(scene.obstacles).names[k]
        if isinstance(shape, HalfSpace):
            unseen.setdefault("no balls hold half-spaces; the links see them", []).append(name)
            continue
        if name in touchable:
            unseen.setdefault("the tool may touch them", []).append(name)
            continue
        center, radius = shape.bounding_ball()
        nearest = min(np.linalg.norm(start - center), np.linalg.norm(goal - center))
        if not isinstance(shape, Ball) and nearest <= (radius + grown) * (1.0 + 1e-9):
            unseen.setdefault("the start or the goal lies in the bounding ball; the links see all of it", []).append(
                name
            )
            continue
        centers.append(center)
        radii.append(radius + wider.get(name, 0.0))
    notes = [f"not seen by the field: {', '.join(map(repr, names))}: {why}" for why, names in unseen.items()]
    options = scene.field
    try:
        field = HarmonicField(
            goal,
            (np.reshape(centers, (-1, 3)), np.array(radii)),
            boundary=options.boundary,
            sensor_range=options.sensor_range,
            margin=grown,
        )
    except InputError as error:
        return ToolPath(None, f"no field path: {error}", tuple(notes))
    path = field.trace(start, step=step)
    notes += [f"tool path: {note}" for note in path.notes]
    if not path.reached:
        return ToolPath(None, f"no field path: {path.reason}", tuple(notes))
    return ToolPath(evenly(path.points, step), "", tuple(notes))


def _touchable(robot: Robot) -> set[str]:
    """Names of the obstacles that the tip, or what hangs on it, may touch."""
    beyond = {robot.tip}
    for k, link in enumerate(robot.links):
        if link.parent in beyond and link.kind == "fixed":
            beyond.add(k)
    return {name for link, name in robot.allowed_obstacles if robot.link_names.index(link) in beyond}


def evenly(points: Floats, step: float) -> Floats:
    """Points (k, d) at equal distances of at most `step` along a polyline, its ends kept."""
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    if lengths[-1] == 0.0:
        return points[:1]
    count = max(1, int(np.ceil(lengths[-1] / step - 1e-9)))
    at = np.linspace(0.0, lengths[-1], count + 1)
    keep = np.concatenate([[True], np.diff(lengths) > 0.0])
    return np.stack([np.interp(at, lengths[keep], points[keep, c]) for c in range(points.shape[1])], axis=1)
