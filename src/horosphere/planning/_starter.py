"""A first scene for a robot: a free start, a goal and a table, which plans as it stands."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..robots import Robot
from ..robots._placement import link_frames, move_points
from ..robots._robot import require_robot
from ..scenes import JointTarget, Options, Scene
from ..scenes._scene import Origin
from ..shapes import Box
from ._plan import plan
from ._sampled import clearances

Floats = NDArray[np.float64]
_TRIES, _DRAWS = 30, 1000  # plans at most, and pairs of postures that are drawn for them
_ROOM = 0.05  # metres between the table and the lowest body at start and goal


def starter_scene(robot: Robot, written: Any, seed: int = 0, name: str = "first") -> Scene:
    """Start and goal drawn from the middle half of the joint ranges, a table under both; planned once, so it is known to plan.

    `written`: the robot as the scene file shall have it. Raises InputError where the robot has no body or nothing is found.
    """
    moving = ~require_robot(robot).static_bodies
    if not moving.any():
        raise InputError(
            f"robot {robot.name!r} has no collision body that moves",
            place="robot",
            remedy="give a capsule file or a link radius",
        )
    rng = np.random.default_rng(seed)
    lower, upper = (np.asarray(np.clip(x, -np.pi, np.pi), np.float64) for x in (robot.limits.lower, robot.limits.upper))
    quarter = 0.25 * (upper - lower)
    tried = 0
    for _ in range(_DRAWS):
        q = np.round(rng.uniform(lower + quarter, upper - quarter, (2, robot.n_joints)), 3)
        if clearances(robot, q, (), most=1e-9)[1].min() <= 0.0:  # links touch
            continue
        scene = Scene(
            robot, JointTarget(q[0]), JointTarget(q[1]), (_table(robot, q, moving),), name=name,
            description=f"A first scene for {robot.name}, made by `horosphere robot --scene`: change it to what you have.",
            options=Options(clearance=0.01), origin=Origin(robot=written),
        )  # fmt: skip
        if plan(scene, improvement_time=0.0, time_limit=2.0).solved:
            return scene
        tried += 1
        if tried == _TRIES:
            break
    found = f"no scene of {tried} could be planned" if tried else f"no two of {2 * _DRAWS} postures are free of contact"
    raise InputError(
        f"{found} for robot {robot.name!r}",
        place="robot",
        remedy="its notes name the links whose bodies often overlap; look at its collision model with --view",
    )


def _table(robot: Robot, q: Floats, moving: NDArray[np.bool_]) -> Box:
    """Its top lies below all that moves, at both ends; it is as wide as the bodies spread."""
    caps, ends = robot.capsules, []
    for one in q:
        frames = link_frames(robot.links, one)[caps.link[moving]]
        ends += [move_points(frames, caps.a[moving]), move_points(frames, caps.b[moving])]
    points, radius = np.concatenate(ends), float(caps.radius[moving].max())
    half = np.append(0.5 * np.ptp(points[:, :2], axis=0) + radius, 0.02)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    top = points[:, 2].min() - radius - _ROOM
    center: Floats = np.array([*middle[:2], top - half[2]], np.float64).round(3)
    sizes: Floats = np.array(half, np.float64).round(3)
    return Box(center, sizes, np.eye(3), name="table")
