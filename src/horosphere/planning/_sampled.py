"""Clearance of joint paths in plain numpy, configuration by configuration: the judge that shares no code with the planner."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..robots import Robot
from ..robots._pairs import segment_distance
from ..robots._placement import link_frames, move_points

Floats = NDArray[np.float64]
ALONG = 33
"""Balls along a capsule's segment, against obstacles."""


def clearances(robot: Robot, q: Floats, obstacles: Iterable[Any]) -> tuple[Floats, Floats]:
    """Distances (k,), (k,) in metres of configurations (k, n) to obstacles, and between the robot's own pairs of links.

    Against obstacles a capsule is taken as balls along its segment. Bodies that no joint moves count too, pairs of
    `robot.allowed_obstacles` do not.
    """
    bodies = robot.capsules
    poses = link_frames(robot.links, q)[:, bodies.link]
    a, b = move_points(poses, bodies.a), move_points(poses, bodies.b)
    outer, inner = np.full(len(q), np.inf), np.full(len(q), np.inf)
    shares = np.linspace(0.0, 1.0, ALONG if (bodies.a != bodies.b).any() else 1)[:, None, None]
    points = a[None] + shares[..., None] * (b - a)[None]
    if len(bodies):
        names = [robot.link_names[link] for link in bodies.link]
        for shape in obstacles:
            gaps = (shape.signed_distance(points) - bodies.radius).min(axis=0)
            gaps[:, [(name, shape.name) in robot.allowed_obstacles for name in names]] = np.inf
            outer = np.minimum(outer, gaps.min(axis=1))
    for i, j in robot.self_pairs:
        first, second = np.flatnonzero(bodies.link == i), np.flatnonzero(bodies.link == j)
        m, n = np.repeat(first, len(second)), np.tile(second, len(first))
        if len(m):
            gaps = segment_distance(a[:, m], b[:, m], a[:, n], b[:, n]) - bodies.radius[m] - bodies.radius[n]
            inner = np.minimum(inner, gaps.min(axis=1))
    return outer, inner


def densely(waypoints: Floats, states_per_rad: float) -> Floats:
    """The path with so many configurations per unit of joint motion, the waypoints among them."""
    steps = np.maximum(np.ceil(np.linalg.norm(np.diff(waypoints, axis=0), axis=1) * states_per_rad), 1).astype(int)
    parts = [a + np.linspace(0.0, 1.0, k + 1)[1:, None] * (b - a) for a, b, k in zip(waypoints, waypoints[1:], steps)]
    return np.concatenate([waypoints[:1], *parts])


def sampled_clearance(
    robot: Robot, waypoints: Floats, obstacles: Iterable[Any], states_per_rad: float
) -> tuple[float, float]:
    """Least distance (m) to obstacles and of self pairs on a path, at so many configurations per radian."""
    path, solids, least = densely(waypoints, states_per_rad), tuple(obstacles), [np.inf, np.inf]
    for q in np.array_split(path, max(len(path) // 500, 1)):
        for k, gaps in enumerate(clearances(robot, q, solids)):
            least[k] = min(least[k], float(gaps.min()))
    return least[0], least[1]
