"""The plain account of clearance, one configuration after the other in numpy: what the compiled planner is judged by."""

import numpy as np

from horosphere.robots._pairs import segment_distance
from horosphere.robots._placement import link_frames, move_points
from horosphere.shapes import Ball, PointCloud


def clearances(robot, q, obstacles):
    """(to obstacles, to itself) of configurations (k, n), each (k,); capsules are taken as rows of 17 balls against obstacles."""
    bodies = robot.capsules
    poses = link_frames(robot.links, q)[:, bodies.link]
    a, b = move_points(poses, bodies.a), move_points(poses, bodies.b)
    outer, inner = np.full(len(q), np.inf), np.full(len(q), np.inf)
    long = np.linalg.norm(bodies.b - bodies.a, axis=1) > 1e-9
    points = [a[:, ~long], *(a[:, long] + t * (b - a)[:, long] for t in np.linspace(0, 1, 17))] if long.any() else [a]
    radii = [bodies.radius[~long], *[bodies.radius[long]] * 17] if long.any() else [bodies.radius]
    singles = [
        Ball(x, r)
        for cloud in obstacles
        if isinstance(cloud, PointCloud)
        for x, r in zip(cloud.points, np.broadcast_to(cloud.radius, len(cloud.points)))
    ]
    for shape in [*singles, *(o for o in obstacles if not isinstance(o, PointCloud))]:
        for x, r in zip(points, radii):
            if x.shape[1]:
                outer = np.minimum(outer, (shape.signed_distance(x) - r).min(axis=1))
    for i, j in robot.self_pairs:
        first, second = np.flatnonzero(bodies.link == i), np.flatnonzero(bodies.link == j)
        m, n = np.repeat(first, len(second)), np.tile(second, len(first))
        if len(m):
            gap = segment_distance(a[:, m], b[:, m], a[:, n], b[:, n]) - bodies.radius[m] - bodies.radius[n]
            inner = np.minimum(inner, gap.min(axis=1))
    return outer, inner


def along(waypoints, per_unit):
    """Configurations on a path, `per_unit` for each unit of joint motion."""
    parts = [waypoints[:1]]
    for a, b in zip(waypoints, waypoints[1:]):
        count = max(int(np.ceil(np.linalg.norm(b - a) * per_unit)), 1)
        parts.append(a + np.linspace(0.0, 1.0, count + 1)[1:, None] * (b - a))
    return np.concatenate(parts)
