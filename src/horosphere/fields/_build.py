"""From obstacles to the world of balls and the chart that leads there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..maps import Star
from ..numeric import float_array
from ._chart import Chart, Conformal, Identity, Shells
from ._merge import merge
from ._obstacles import Zones, read_zones
from ._shells import shell_widths
from ._world import wall_distances

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """Balls of the mapped space, walls, the chart, names by entry, remarks."""

    centers: Array
    radii: Array
    walls: Array
    names: tuple[str, ...]
    chart: Chart
    stars: tuple[Star, ...]
    notes: tuple[str, ...]


def lay_out(goal: Array, obstacles: Any, margin: float, workspace: Any) -> Layout:
    """Read, merge, map. Raises InputError for what cannot be used and for a goal in a zone or outside the workspace."""
    n = len(goal)
    zones = read_zones(obstacles, n, margin)
    _add_workspace(zones, workspace)
    walls = np.array(zones.walls).reshape(-1, n + 2)
    away = wall_distances(walls, goal[None])[0]
    if (away <= 0.0).any():
        k = int(np.argmin(away))
        raise InputError(
            f"the goal lies {-1e3 * away[k]:.4g} mm beyond {zones.wall_names[k]}",
            place="goal",
            remedy="move the goal or the wall",
        )
    if zones.ellipse is not None and len(zones.bodies) == 1 and not zones.conformal and not len(walls):
        zones.conformal.append(zones.ellipse)
        zones.bodies.clear()
        zones.notes.clear()
    if zones.conformal and (len(zones.conformal) > 1 or zones.bodies or len(walls)):
        for shape in zones.conformal:
            zones.bodies.append(shape.as_star(margin))
            zones.notes.append(
                f"{shape.name or 'Joukowski shape'}: not alone, so mapped by its shell instead of conformally"
            )
        zones.conformal.clear()
    if zones.conformal:
        shape = zones.conformal[0].grown(margin)
        center, radius = shape.circle
        if not np.linalg.norm(shape.to_circle(goal) - center) > radius:
            raise _goal_inside(shape.name or "obstacle 0", float(-shape.distance(goal[None], shape.margin)[0]))
        name = shape.name or "obstacle 0"
        return Layout(center[None], np.array([radius]), walls, (name,), Conformal(shape), (), tuple(zones.notes))
    for body in zones.bodies:
        depth = -float(body.level(goal)) if isinstance(body, Star) else body[1] - float(np.linalg.norm(body[0] - goal))
        if depth >= 0.0:
            raise _goal_inside(body.name if isinstance(body, Star) else body[2], depth)
    bodies, merged = merge(zones.bodies, goal)
    balls = [body for body in bodies if not isinstance(body, Star)]
    stars = [body for body in bodies if isinstance(body, Star)]
    centers = np.array([b[0] for b in balls]).reshape(-1, n)
    radii = np.array([b[1] for b in balls])
    notes = zones.notes + merged
    chart: Chart = Identity()
    if stars:
        widths, sampled = shell_widths(stars, centers, radii, walls)
        for star, width in zip(stars, widths):
            if not width > 0.0:
                raise InputError(
                    f"no room for a shell around {star.name}",
                    place="obstacles",
                    remedy="move it off its neighbour or the wall",
                )
        shells = chart = Shells.of(stars, list(widths))
        notes += sampled
        centers = np.concatenate([centers, [star.center for star in stars]])
        radii = np.concatenate([radii, shells.inner])
    names = (*(b[2] for b in balls), *(star.name for star in stars), *zones.wall_names)
    return Layout(centers, radii, walls, names, chart, tuple(stars), tuple(notes))


def _goal_inside(name: str, depth: float) -> InputError:
    return InputError(
        f"the goal lies {1e3 * depth:.4g} mm inside {name}",
        place="goal",
        remedy="move the goal or shrink the obstacle or the margin",
    )


def _add_workspace(zones: Zones, workspace: Any) -> None:
    if workspace is None:
        return
    n = zones.dimension
    if hasattr(workspace, "center") and hasattr(workspace, "radius"):
        center = float_array(workspace.center, "workspace center", last=n, ndim=1)
        radius = float(float_array(workspace.radius, "workspace radius", ndim=0)) - zones.margin
        if not radius > 0.0:
            raise InputError(f"expected a radius above the margin, got {radius + zones.margin:g}", place="workspace")
        zones.walls.append(np.r_[center, 0.0, radius])
        zones.wall_names.append("the workspace's wall")
        return
    if not isinstance(workspace, (tuple, list)) or len(workspace) != 2:
        raise InputError(
            "expected (lower, upper) corners of a box, or a ball with center and radius", place="workspace"
        )
    lower = float_array(workspace[0], "workspace lower corner", last=n, ndim=1, finite=False)
    upper = float_array(workspace[1], "workspace upper corner", last=n, ndim=1, finite=False)
    if not (lower < upper).all():
        raise InputError(f"expected lower < upper, got {lower} and {upper}", place="workspace")
    for k in range(n):
        for sign, bound in ((1.0, lower[k]), (-1.0, upper[k])):
            if np.isfinite(bound):
                normal = np.zeros(n)
                normal[k] = sign
                zones.add_halfspace(
                    normal, sign * float(bound), f"the workspace's {'lower' if sign > 0 else 'upper'} wall {k}"
                )
