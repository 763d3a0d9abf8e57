"""Obstacles as the tree planner sees them, and the plain account of why a configuration is not free."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..robots import Robot
from ..shapes import (
    Ball,
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    PointCloud,
    Shape,
    box_cover,
    few_balls,
)

Floats = NDArray[np.float64]
_BOX, _CAPSULE, _CYLINDER, _ELLIPSOID, _HALF_SPACE = 0.0, 1.0, 2.0, 3.0, 4.0
ROW_BYTES = 16 * 8
MOST_BALLS = 4000
"""Points of one cloud beyond which near ones are taken together, in a ball that holds them."""
SUPPORTED = ("Ball", "Box", "Capsule", "Cylinder", "Ellipsoid", "HalfSpace", "Mesh", "PointCloud")


def solid_rows(obstacles: Iterable[Shape]) -> Floats:
    """Rows (m, 16) for `sort_solids`, read-only. Raises InputError for what the planner cannot take."""
    return np.frombuffer(b"".join([rows_of(shape) for shape in obstacles])).reshape(-1, 16)


def rows_of(shape: Shape) -> bytes:
    """The rows of one obstacle, which keeps them."""
    try:
        return shape.planner_rows
    except AttributeError:
        parts = box_cover(shape).boxes if isinstance(shape, Mesh) else (shape,)
        rows = b"".join(_rows(part) for part in parts)
        object.__setattr__(shape, "planner_rows", rows)
        return rows


def _rows(obstacle: Shape) -> bytes:
    kind, shape = type(obstacle), cast("Any", obstacle)
    if kind is Box or kind is Ellipsoid:
        code, sizes = (_BOX, shape.half_sizes) if kind is Box else (_ELLIPSOID, shape.semi_axes)
        row = (code, *shape.center, *shape.rotation.T.ravel(), *sizes)
    elif kind is Cylinder or kind is Capsule:
        row = _axial(_CYLINDER if kind is Cylinder else _CAPSULE, shape)
    elif kind is Ball and len(shape.center) == 3:
        row = (_CAPSULE, *shape.center, 0.0, 0.0, 1.0, *(0.0,) * 6, 0.0, shape.radius, 0.0)
    elif kind is HalfSpace:
        row = (_HALF_SPACE, 0.0, 0.0, 0.0, *shape.normal, *(0.0,) * 6, shape.distance, 0.0, 0.0)
    elif kind is PointCloud:
        points, radii = few_balls(shape, MOST_BALLS)
        row = np.zeros((len(points), 16))
        row[:, 0], row[:, 1:4], row[:, 6], row[:, 14] = _CAPSULE, points, 1.0, radii
    else:
        raise InputError(
            f"the tree planner cannot plan around a {kind.__name__}{' of dimension 2' if kind is Ball else ''}",
            place=f"obstacle {shape.name!r}" if getattr(shape, "name", "") else "obstacles",
            remedy="enclose it in boxes, capsules or cylinders",
            choices=SUPPORTED,
        )
    return np.asarray(row, np.float64).tobytes()


def allowed_rows(allowed: tuple[tuple[str, ...], ...], obstacles: tuple[Shape, ...]) -> NDArray[np.uint8]:
    """(C, m) which rows of `solid_rows` each body may touch, from the names it may touch."""
    names = [shape.name for shape in obstacles for _ in range(len(rows_of(shape)) // ROW_BYTES)]
    return np.array([[bool(name) and name in own for name in names] for own in allowed], np.uint8)


def _axial(kind: float, shape: Any) -> tuple[float, ...]:
    (ax, ay, az), (bx, by, bz) = shape.a.tolist(), shape.b.tolist()
    x, y, z = bx - ax, by - ay, bz - az
    length = (x * x + y * y + z * z) ** 0.5
    axis = (x / length, y / length, z / length) if length > 1e-12 else (0.0, 0.0, 1.0)
    middle = (0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * (az + bz))
    return (kind, *middle, *axis, *(0.0,) * 6, 0.5 * length, shape.radius, 0.0)


def nearest_contact(
    robot: Robot, q: Floats, obstacles: tuple[Shape, ...], clearance: float, self_clearance: float
) -> str | None:
    """What is nearer than it may be at q, in words, the worst first; None if nothing is. Exact bodies, balls along capsules."""
    from ..robots._pairs import segment_distance
    from ..robots._placement import link_frames, move_points

    bodies = robot.capsules
    poses = link_frames(robot.links, q)[bodies.link]
    a, b = move_points(poses, bodies.a), move_points(poses, bodies.b)
    worst, text = 0.0, None
    names = robot.link_names
    allowed = set(robot.allowed_obstacles)
    for number, shape in enumerate(obstacles):
        along = np.linspace(0.0, 1.0, 33)[:, None, None]
        gaps = shape.signed_distance(a + along * (b - a)) - bodies.radius
        gaps[:, [(names[link], shape.name) in allowed for link in bodies.link]] = np.inf
        k = int(np.argmin(gaps.min(axis=0)))
        gap = float(gaps[:, k].min())
        if gap - clearance < worst:
            name = shape.name or f"obstacle {number} ({type(shape).__name__})"
            worst, text = gap - clearance, f"{names[bodies.link[k]]!r} {_how_near(gap, clearance)} {name!r}"
    for i, j in robot.self_pairs:
        first, second = np.flatnonzero(bodies.link == i), np.flatnonzero(bodies.link == j)
        if len(first) and len(second):
            m, n = np.repeat(first, len(second)), np.tile(second, len(first))
            gap = float((segment_distance(a[m], b[m], a[n], b[n]) - bodies.radius[m] - bodies.radius[n]).min())
            if gap - self_clearance < worst:
                worst = gap - self_clearance
                text = f"{names[i]!r} {_how_near(gap, self_clearance)} {names[j]!r} of the robot itself"
    return text


def _how_near(gap: float, clearance: float) -> str:
    if gap < 0.0:
        return f"is {-gap * 1e3:.1f} mm inside"
    return f"is only {gap * 1e3:.1f} mm (less than {clearance * 1e3:g} mm) from"
