"""Random problems that are known to have a solution, for any robot: obstacles are put beside a way that is known."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..robots import Robot, load
from ..robots._placement import link_frames, move_points
from ..shapes import Ball, Box, Capsule, Cylinder, Shape
from ._sampled import clearances, densely

Floats = NDArray[np.float64]
ROBOTS = ("panda", "ur5", "iiwa14", "nao-left-arm", "humanoid-arm", "srs-arm", "planar-3r")
LINK_RADIUS = 1 / 25
"""Radius of the links of a robot that comes without bodies, as a share of how far it reaches."""
SOLIDS, TRIALS, WAYS = 12, 200, 100
"""Obstacles of a problem, how many are tried for them, and how many ways between any configurations; then ever shorter ones."""
AT_ONCE, DRAWS = 100, 100
"""Configurations that are drawn together, and how often."""
SHORTEST = 0.1
"""Share of a way between any configurations that is tried last: wide ranges leave few long ways free."""
ROOM = 1 / 50
"""The known way keeps so much more (share of the reach) than the clearance that is asked for."""
PER_RADIAN = 8.0


def with_bodies(robot: Robot | str | Path, **loading: Any) -> Robot:
    """A robot by name or file, read as `load` is told; links without bodies become capsules."""
    arm = robot if isinstance(robot, Robot) else load(robot, **loading)
    if len(arm.capsules):
        return arm
    if isinstance(robot, Robot):
        raise InputError(
            "the robot has no bodies, so nothing can touch it", place=robot.name, remedy="give it capsules"
        )
    return load(robot, **{**loading, "link_radius": float(round(LINK_RADIUS * size(arm), 3))})


def size(robot: Robot) -> float:
    """About how far (m) the tip gets from the base's first axis, over random configurations."""
    from ..kinematics import frames

    q = np.random.default_rng(0).uniform(*region(robot), (256, robot.n_joints))
    points = frames(robot, q).as_matrix()[..., :3, 3]
    return float(np.linalg.norm(points - points[:, :1], axis=-1).max())


def region(robot: Robot) -> tuple[Floats, Floats]:
    """Limits, at most half a turn (or a metre of sliding) from zero where there are none."""
    low, high = robot.limits.lower.copy(), robot.limits.upper.copy()
    turns = np.array([next(x.kind for x in robot.links if x.coordinate == j) == "revolute" for j in range(len(low))])
    most = np.where(turns, np.pi, 1.0)
    low = np.where(np.isfinite(low), low, -most)
    high = np.where(np.isfinite(high), high, most)
    return low, high


def random_problem(robot: Robot, seed: int, clearance: float = 0.01) -> tuple[Floats, Floats, tuple[Shape, ...]]:
    """(start (n,), goal (n,), obstacles): solvable, since a way over a via point is kept free, and not in a straight line.

    The way, straight in joint space from the start to a random configuration and on to the goal, keeps at least `clearance` and
    1/50 of the robot's size from everything in 8 configurations a radian; it is shorter where no long one is free of contact between
    links. An obstacle stands in the straight motion from start to goal, unless links touch each other on it. Plain numpy only;
    the same seed gives the same problem. Raises InputError if no such way is found.
    """
    rng = np.random.default_rng([seed, robot.n_joints])
    low, high = region(robot)
    reach = size(robot)
    for way, gap in _ways(robot, rng.spawn(1)[0], low, high, reach):
        path, direct = densely(way, PER_RADIAN), densely(way[[0, -1]], PER_RADIAN)
        if not (_apart(robot, path[::16], gap) and _apart(robot, path, gap)):
            continue
        blocked = not _apart(robot, direct, 1e-9)
        kept, barred = _Balls(robot, path), _Balls(robot, direct)
        obstacles: list[Shape] = []
        for trial in range(TRIALS):
            needed = not (blocked or obstacles)  # the first has to stand in the straight way
            if len(obstacles) == SOLIDS or (needed and trial == TRIALS // 4):
                break
            q = direct[rng.integers(len(direct))] if needed else rng.uniform(low, high)
            solid = _solid(robot, q, rng, reach)
            if kept.gap(solid) >= clearance + ROOM * reach and not (needed and barred.gap(solid) >= 0.0):
                obstacles.append(solid)
        if obstacles:
            return way[0], way[-1], tuple(obstacles)
    raise InputError(
        "no random motion is free of contact between the robot's own links",
        place=robot.name,
        remedy="its notes name the links whose bodies often overlap: an SRDF, a smaller tolerance or a capsule file helps",
    )


def _ways(
    robot: Robot, rng: np.random.Generator, low: Floats, high: Floats, reach: float
) -> Iterator[tuple[Floats, float]]:
    """Start, via point and goal (3, n) between which the robot's own links shall keep apart by the metres that come with it.

    The three are free of contact before a way is made shorter: where few postures are, hardly three drawn at once would be. Two
    links may be nearer than 1/500 of the reach in every posture; so less is asked for where none has that.
    """
    shares = iter(np.minimum(WAYS / np.arange(1, round(WAYS / SHORTEST) + 1), 1.0))
    gap = 2e-3 * reach
    for _ in range(DRAWS):
        q = rng.uniform(low, high, (AT_ONCE, robot.n_joints))
        free = q[clearances(robot, q, (), most=gap)[1] >= gap]
        if not len(free):
            gap = max(0.25 * gap, 2e-5 * reach)
        for k in range(len(free)):
            share = next(shares, None)
            if share is None:
                return
            way = free[[k, *rng.integers(len(free), size=2)]]
            yield way[0] + share * (way - way[0]), float(share * gap)


def _apart(robot: Robot, q: Floats, gap: float) -> bool:
    """Whether the robot's own links keep `gap` metres apart in all configurations q (k, n)."""
    return bool(clearances(robot, q, (), most=gap)[1].min() >= gap)


class _Balls:
    """The robot's bodies at many configurations, as balls along their segments."""

    def __init__(self, robot: Robot, q: Floats) -> None:
        bodies = robot.capsules
        poses = link_frames(robot.links, q)[:, bodies.link]
        a, b = move_points(poses, bodies.a), move_points(poses, bodies.b)
        shares = np.linspace(0.0, 1.0, 9 if (bodies.a != bodies.b).any() else 1)[:, None, None, None]
        self.points, self.radii = a + shares * (b - a), bodies.radius

    def gap(self, solid: Any) -> float:
        return float((solid.signed_distance(self.points) - self.radii).min())


def _solid(robot: Robot, q: Floats, rng: np.random.Generator, reach: float) -> Any:
    """A solid of some kind about where a body of the robot is at q."""
    bodies = robot.capsules
    k = int(rng.integers(len(bodies)))
    pose = link_frames(robot.links, q)[bodies.link[k]]
    a, b = move_points(pose, bodies.a[k]), move_points(pose, bodies.b[k])
    centre = a + rng.uniform() * (b - a) + 0.05 * reach * rng.normal(size=3)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    r = reach * rng.uniform(0.02, 0.08)
    half = 2.0 * r * turn[:, 0]
    return (
        lambda: Ball(centre, 1.5 * r),
        lambda: Box(centre, r * rng.uniform(0.5, 2.0, 3), turn),
        lambda: Cylinder(centre - half, centre + half, r),
        lambda: Capsule(centre - half, centre + half, r),
    )[int(rng.integers(4))]()
