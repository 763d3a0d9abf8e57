"""Numbers over time that a report shows: clearance, distance to the goal, joints."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scenes import PointRobot, Scene, SnakeRobot, Trajectory, UnicycleRobot
from ._parts import tool_points
from ._solids import outline_of

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Measures:
    """Along a trajectory: `time` (k,) s; `q` (k, n); `clearance` (k,) m or None; `to_goal` (k,) m or None; tool points (k, 3).

    Of snakes also `singularity` (k,), 0 where all wheel axes meet, and at the waypoints `slip` (2, m): time and m/s sideways.
    """

    time: Floats
    q: Floats
    tool: Floats
    clearance: Floats | None
    to_goal: Floats | None
    singularity: Floats | None = None
    slip: Floats | None = None


def measure(scene: Scene, trajectory: Trajectory, most: int = 600) -> Measures:
    """The numbers at up to `most` moments, all waypoints among them where they are fewer."""
    if len(trajectory) <= most // 2:
        fine = np.linspace(trajectory.time[0], trajectory.time[-1], most - len(trajectory))
        time = np.unique(np.concatenate([trajectory.time, fine]))
    else:
        time = np.linspace(trajectory.time[0], trajectory.time[-1], most)
    q = trajectory.at(time)
    tool = tool_points(scene, q)
    result = Measures(time - time[0], q, tool, clearance(scene, q), distance_to_goal(scene, q, tool))
    return _of_snake(scene, trajectory, result) if isinstance(scene.robot, SnakeRobot) else result


def _of_snake(scene: Scene, trajectory: Trajectory, result: Measures) -> Measures:
    from ..snake import snake_of

    snake = snake_of(scene)
    slip = None
    if trajectory.velocities is not None:
        across = np.abs(np.einsum("kij,kj->ki", snake.pfaff(trajectory.positions), trajectory.velocities))
        slip = np.stack([trajectory.time - trajectory.time[0], across.max(axis=1, initial=0.0)])
    return replace(result, singularity=snake.singularity(result.q), slip=slip)


def clearance(scene: Scene, q: Floats) -> Floats | None:
    """Least distance (k,) from the robot to the obstacles; None where there is nothing to keep clear of, or no measure of it."""
    if not scene.obstacles:
        return None
    if isinstance(scene.robot, SnakeRobot):
        from ..snake import Surroundings, snake_of

        around = Surroundings.of(list(scene.obstacles), None)
        return around.of_body(snake_of(scene).joints(q), 0.5 * scene.robot.width)
    if isinstance(scene.robot, (PointRobot, UnicycleRobot)):
        x = q[:, : scene.dimension]
        return np.min([_outside(o, x) for o in scene.obstacles], axis=0) - scene.robot.radius
    if not len(scene.robot.capsules):
        return None
    from ..distance import signed

    return np.asarray(signed(scene.robot, q, scene.obstacles, static=False))


def _outside(obstacle: Any, x: Floats) -> Floats:
    """Distance of points (k, n) to one obstacle; to a plane figure, to its outline of 720 pieces (negative inside)."""
    if hasattr(obstacle, "signed_distance"):
        return obstacle.signed_distance(x)
    outline = outline_of(obstacle, 720)
    if outline is None:  # an ellipsoid of R^n: a lower bound of the distance by scaling
        local = (x - obstacle.center) @ obstacle.rotation
        return (np.linalg.norm(local / obstacle.semi_axes, axis=1) - 1.0) * float(np.min(obstacle.semi_axes))
    a, b = outline, np.roll(outline, -1, axis=0)
    u = b - a
    v = x[:, None] - a[None]
    s = np.clip((v * u).sum(-1) / (u * u).sum(-1), 0.0, 1.0)
    distance = np.linalg.norm(v - s[..., None] * u, axis=-1).min(axis=1)
    crosses = (a[:, 1] > x[:, None, 1]) != (b[:, 1] > x[:, None, 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        at = a[:, 0] + (x[:, None, 1] - a[:, 1]) * u[:, 0] / u[:, 1]
    inside = (crosses & (x[:, None, 0] < at)).sum(axis=1) % 2 == 1
    return np.where(inside, -distance, distance)


def distance_to_goal(scene: Scene, q: Floats, tool: Floats) -> Floats | None:
    """Distance (k,) of the tool point from what it shall reach: a point, a line, a plane, or where the goal's joints put it."""
    goal: Any = scene.goal
    kind = type(goal).__name__
    if kind == "JointTarget":
        return np.linalg.norm(tool - tool_points(scene, goal.q[None])[0], axis=1)
    if kind == "LineTarget":
        v = tool - goal.point
        return np.linalg.norm(v - (v @ goal.direction)[:, None] * goal.direction, axis=1)
    if kind == "PlaneTarget":
        return np.abs(tool @ goal.normal - goal.distance)
    if kind == "PostureTarget":
        return np.linalg.norm(q[:, :2] - goal.q[:2], axis=1)
    position = goal.position
    if isinstance(scene.robot, PointRobot):
        return np.linalg.norm(q - position, axis=1)
    return np.linalg.norm(tool[:, : len(position)] - position, axis=1)
