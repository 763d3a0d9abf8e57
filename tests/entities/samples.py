"""Random entities for the tests, with coordinates of order one."""

import numpy as np

import horosphere as hs

KINDS = {
    "Point": lambda g, s: hs.Point.from_euclidean(g.normal(size=(*s, 3))),
    "Sphere": lambda g, s: hs.Sphere.from_center_radius(g.normal(size=(*s, 3)), g.uniform(0.5, 2, size=s)),
    "Plane": lambda g, s: hs.Plane.from_normal_distance(g.normal(size=(*s, 3)), g.normal(size=s)),
    "Line": lambda g, s: hs.Line.from_point_direction(g.normal(size=(*s, 3)), g.normal(size=(*s, 3))),
    "Circle": lambda g, s: hs.Circle.from_center_normal_radius(
        g.normal(size=(*s, 3)), g.normal(size=(*s, 3)), g.uniform(0.5, 2, size=s)
    ),
    "PointPair": lambda g, s: hs.PointPair.from_points(g.normal(size=(*s, 3)), g.normal(size=(*s, 3))),
}


def random(kind, rng, shape=()):
    """A batch of random entities of a kind."""
    return KINDS[kind](rng, shape)


def points_on(x, rng, count=9):
    """Points (count, 3) of a single real entity, by plain vector geometry."""
    name = type(x).__name__
    if name == "Point":
        return np.repeat(x.as_euclidean()[None], count, 0)
    if name == "PointPair":
        return x.points[rng.integers(0, 2, count)]
    if name == "Sphere":
        u = rng.normal(size=(count, 3))
        return x.center + x.radius * u / np.linalg.norm(u, axis=-1, keepdims=True)
    direction = x.direction if name == "Line" else x.normal
    u = np.linalg.svd(direction[None])[2][1:]  # two unit vectors at right angles to it
    if name == "Line":
        return np.cross(x.direction, x.moment) + rng.normal(size=(count, 1)) * direction
    if name == "Plane":
        return x.normal * x.distance + rng.normal(size=(count, 2)) @ u
    angle = rng.uniform(0, 2 * np.pi, count)[:, None]
    return x.center + x.radius * (np.cos(angle) * u[0] + np.sin(angle) * u[1])
