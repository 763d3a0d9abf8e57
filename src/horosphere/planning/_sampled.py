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


def clearances(robot: Robot, q: Floats, obstacles: Iterable[Any], most: float = np.inf) -> tuple[Floats, Floats]:
    """Distances (k,), (k,) in metres of configurations (k, n) to obstacles, and between the robot's own pairs of links.

    Against obstacles a capsule is taken as balls along its segment. Bodies that no joint moves count too, pairs of
    `robot.allowed_obstacles` do not. Distances above `most` are given as `most`. What balls round bodies and links show to be
    further away than something else is not looked at.
    """
    bodies = robot.capsules
    frames = link_frames(robot.links, q)
    poses = frames[:, bodies.link]
    a, b = move_points(poses, bodies.a), move_points(poses, bodies.b)
    inner, outer = _between_links(robot, frames, a, b, most), np.full(len(q), most)
    if not len(bodies):
        return outer, inner
    middle, size = 0.5 * (a + b), 0.5 * np.linalg.norm(bodies.b - bodies.a, axis=1)
    shares = np.linspace(0.0, 1.0, ALONG)[:, None]
    names = [robot.link_names[link] for link in bodies.link]
    for shape in obstacles:
        gaps = shape.signed_distance(middle) - bodies.radius
        gaps[:, [(name, shape.name) in robot.allowed_obstacles for name in names]] = np.inf
        outer = np.minimum(outer, gaps.min(axis=1))
        c, m = np.nonzero(gaps - size < outer[:, None])  # no point of a segment is further from its middle
        points = a[c, m] + shares[..., None] * (b[c, m] - a[c, m])
        np.minimum.at(outer, c, shape.signed_distance(points).min(axis=0) - bodies.radius[m])
    return outer, inner


def _between_links(robot: Robot, frames: Floats, a: Floats, b: Floats, most: float) -> Floats:
    """Least distance (k,) of the checked pairs of links, whose bodies lie along segments a b (k, bodies, 3), at most `most`."""
    bodies, rounds = robot.capsules, robot.link_bounds
    middle, size = 0.5 * (a + b), 0.5 * np.linalg.norm(bodies.b - bodies.a, axis=1) + bodies.radius
    centre, radius = move_points(frames, rounds[:, :3]), rounds[:, 3]
    first, second = robot.self_pairs.T
    far = np.linalg.norm(centre[:, first] - centre[:, second], axis=2) - radius[first] - radius[second]
    far[:, (radius[first] < 0.0) | (radius[second] < 0.0)] = np.inf
    least = np.full(len(frames), most)

    def look(rows: Any, m: Any, n: Any) -> None:
        gaps = segment_distance(a[rows, m], b[rows, m], a[rows, n], b[rows, n]) - bodies.radius[m] - bodies.radius[n]
        np.minimum.at(least, rows, gaps)

    def near(rows: Any, m: Any, link: int) -> Any:
        """The bodies m that come near a link in one of the configurations."""
        gaps = np.linalg.norm(middle[rows][:, m] - centre[rows, link][:, None], axis=2) - size[m] - radius[link]
        return m[(gaps < least[rows, None]).any(axis=0)]

    for p in np.argsort(far.min(axis=0, initial=np.inf)):
        rows = np.flatnonzero(far[:, p] < least)
        i, j = robot.self_pairs[p]
        m, n = near(rows, np.flatnonzero(bodies.link == i), j), near(rows, np.flatnonzero(bodies.link == j), i)
        if not (len(rows) and len(m) and len(n)):
            continue
        gaps = np.linalg.norm(middle[rows][:, m, None] - middle[rows][:, None, n], axis=3) - size[m, None] - size[n]
        nearest = gaps.reshape(len(rows), -1).argmin(axis=1)
        look(rows, m[nearest // len(n)], n[nearest % len(n)])
        c, k, l = np.nonzero(gaps < least[rows, None, None])
        look(rows[c], m[k], n[l])
    return least


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
