"""What moves in a scene: solids with one pose per moment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scenes import PointRobot, Scene, SnakeRobot, UnicycleRobot
from ._solids import Solid, capsule, prism, solid_of

Floats = NDArray[np.float64]

BLUES = np.array([[52, 92, 140], [58, 110, 165], [96, 160, 210], [150, 200, 225]], dtype=np.float64)

MOST_DRAWN = 60_000
"""Points of one cloud that are drawn: a report stays under 5 MB and turns smoothly."""


def stride(cloud: Any) -> int:
    """Every how many points of a cloud one is drawn."""
    return -(-len(cloud.points) // MOST_DRAWN)


@dataclass(frozen=True, slots=True)
class Part:
    """A rigid piece: its solids in its own frame, a colour (r, g, b), and its pose (k, 4, 4) at each moment."""

    name: str
    solids: tuple[Solid, ...]
    color: tuple[int, int, int]
    poses: Floats


def shade(k: int, count: int) -> tuple[int, int, int]:
    """The k-th of `count` blues, dark at the base and light at the tip."""
    x = (len(BLUES) - 1) * k / max(count - 1, 1)
    i = min(int(x), len(BLUES) - 2)
    red, green, blue = ((1 - (x - i)) * BLUES[i] + (x - i) * BLUES[i + 1]).round().astype(int)
    return int(red), int(green), int(blue)


def parts(scene: Scene, q: Floats) -> tuple[Part, ...]:
    """The moving pieces of the scene's robot for configurations `q` (k, n)."""
    robot = scene.robot
    if isinstance(robot, PointRobot):
        return (_ball(robot.radius or 0.01 * extent_of(scene)[1], q),)
    if isinstance(robot, UnicycleRobot):
        return (_unicycle(robot, q),)
    if isinstance(robot, SnakeRobot):
        return _snake(robot, q)
    return _links(robot, q)


def link_poses(robot: Any, q: Floats) -> Floats:
    """Poses (k, links, 4, 4) of all link frames."""
    from ..kinematics import frames

    return frames(robot, q).as_matrix()


def tool_points(scene: Scene, q: Floats) -> Floats:
    """Where the tool (the ball, the unicycle, the snake's head) is: (k, 3); of R^n the first three coordinates."""
    robot = scene.robot
    if isinstance(robot, (PointRobot, UnicycleRobot, SnakeRobot)):
        wanted = q[:, : 2 if not isinstance(robot, PointRobot) else 3]
        return np.column_stack([wanted, np.zeros((len(q), 3 - wanted.shape[1]))])
    from ..kinematics import forward

    return forward(robot, q).as_matrix()[:, :3, 3]


def _links(robot: Any, q: Floats) -> tuple[Part, ...]:
    poses = link_poses(robot, q)
    capsules = robot.capsules
    used = [i for i in range(len(robot.links)) if (capsules.link == i).any()]
    result = []
    for k, i in enumerate(used):
        mine = np.flatnonzero(capsules.link == i)
        fine = 28 if len(mine) < 4 else 16
        solids = tuple(capsule(capsules.a[m], capsules.b[m], float(capsules.radius[m]), fine) for m in mine)
        result.append(Part(robot.links[i].name, solids, shade(k, len(used)), poses[:, i]))
    return tuple(result) or (_skeleton(robot, poses),)


def _skeleton(robot: Any, poses: Floats) -> Part:
    """A robot without collision bodies, still seen: a small ball at its tip."""
    return Part("tip", (capsule(np.zeros(3), np.zeros(3), 0.02),), (96, 160, 210), poses[:, robot.tip])


def planar_poses(x: Floats, y: Floats, angle: Floats) -> Floats:
    """Poses (k, 4, 4) in the plane z = 0."""
    poses = np.tile(np.eye(4), (len(x), 1, 1))
    c, s = np.cos(angle), np.sin(angle)
    poses[:, 0, 0], poses[:, 0, 1], poses[:, 1, 0], poses[:, 1, 1] = c, -s, s, c
    poses[:, 0, 3], poses[:, 1, 3] = x, y
    return poses


def _ball(radius: float, q: Floats) -> Part:
    poses = np.tile(np.eye(4), (len(q), 1, 1))
    poses[:, : min(q.shape[1], 3), 3] = q[:, :3]
    return Part("ball", (capsule(np.zeros(3), np.zeros(3), radius, 36),), (58, 110, 165), poses)


def _unicycle(robot: UnicycleRobot, q: Floats) -> Part:
    t = np.arange(48) * (2.0 * np.pi / 48)
    r = max(robot.radius, 1e-3)
    disc = prism(r * np.stack([np.cos(t), np.sin(t)], axis=1), 0.5 * r)
    nose = prism(r * np.array([[0.95, 0.0], [-0.4, 0.5], [-0.4, -0.5]]), 0.7 * r)
    return Part("unicycle", (disc, nose), (58, 110, 165), planar_poses(q[:, 0], q[:, 1], q[:, 2]))


def _snake(robot: SnakeRobot, q: Floats) -> tuple[Part, ...]:
    """Link i starts at joint i; frames M_i = M_{i-1} T(l_{i-1}) R(Phi_i)."""
    angle, x, y = q[:, 2], q[:, 0], q[:, 1]
    result = []
    for i, length in enumerate(robot.lengths):
        if i:
            x = x + robot.lengths[i - 1] * np.cos(angle)
            y = y + robot.lengths[i - 1] * np.sin(angle)
            angle = angle + q[:, 2 + i]
        width = robot.width or 0.12 * float(length)
        body = capsule([0.0, 0.0, 0.0], [length, 0.0, 0.0], 0.5 * width, 20)
        poses = planar_poses(x, y, angle)
        result.append(Part(f"link {i}", (body,), shade(i, robot.links), poses))
        if 0 < i < robot.links - 1:  # the first and the last link have no wheels
            wheels = _wheels(robot.wheel_fraction * length, 0.16 * length, max(0.7 * width, 0.06 * length))
            result.append(Part(f"wheels {i}", wheels, (60, 60, 60), poses))
    return tuple(result)


def _wheels(x: float, half_gauge: float, radius: float) -> tuple[Solid, ...]:
    """A pair of wheels and their axle at x, drawn large enough to be seen."""
    axle = capsule([x, -half_gauge, 0.0], [x, half_gauge, 0.0], 0.15 * radius, 8)
    rims = (
        capsule([x - radius, side * half_gauge, 0.0], [x + radius, side * half_gauge, 0.0], 0.35 * radius, 12)
        for side in (-1.0, 1.0)
    )
    return (axle, *rims)


def extent_of(scene: Scene, *points: Floats) -> tuple[Floats, float]:
    """Centre (3,) and half-width (m) of what is worth seeing: obstacles that are bounded, targets, `points` (k, 3)."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)

    def include(points: Any) -> None:
        nonlocal low, high
        block = np.atleast_2d(np.asarray(points, np.float64))[:, :3]
        block = np.column_stack([block, np.zeros((len(block), 3 - block.shape[1]))])
        low, high = np.minimum(low, block.min(axis=0)), np.maximum(high, block.max(axis=0))

    for obstacle in scene.obstacles:
        kind = type(obstacle).__name__
        if kind != "HalfSpace":
            include(obstacle.points if kind == "PointCloud" else solid_of(obstacle, np.zeros(3), 0.0)[0])
    for target in (scene.start, scene.goal):
        position = getattr(target, "position", None)
        if position is not None:
            include(position)
    for block in points:
        include(block)
    if scene.workspace is not None:
        wall = scene.workspace
        include(np.stack([wall.center - wall.radius, wall.center + wall.radius]))
    if not np.isfinite(low).all():
        return np.zeros(3), 1.0
    return 0.5 * (low + high), max(0.5 * float((high - low).max()), 1e-3)
