"""Random kinematic trees and scenes for the tests of distance and certify."""

import numpy as np

from horosphere.robots import Capsules, Limits, Link, Robot
from horosphere.robots._placement import from_quaternion_translation, link_frames, move_points
from horosphere.shapes import Ball, Box, Capsule, Cylinder, Ellipsoid, HalfSpace, PointCloud


def unit(rng, n=3):
    v = rng.normal(size=n)
    return v / np.linalg.norm(v)


def rotation(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    if np.linalg.det(q) < 0:
        q[:, 0] *= -1
    return q


def random_robot(rng, links=7, self_pairs=True):
    """A tree of revolute, prismatic, fixed and mimicking joints, with capsules and spheres on it."""
    made, coordinates = [], 0
    for i in range(links):
        origin = from_quaternion_translation(unit(rng, 4), 0.25 * rng.normal(size=3))
        parent = -1 if i == 0 else max(0, i - 1 - int(rng.random() < 0.2))
        kind = "fixed" if i == 0 else str(rng.choice(["fixed", "revolute", "revolute", "revolute", "prismatic"]))
        coordinate, multiplier, offset = -1, 1.0, 0.0
        if kind != "fixed":
            if coordinates and rng.random() < 0.2:  # mimic
                coordinate, multiplier, offset = (
                    int(rng.integers(coordinates)),
                    float(rng.normal()),
                    float(rng.normal()),
                )
            else:
                coordinate, coordinates = coordinates, coordinates + 1
        made.append(Link(f"link{i}", parent, origin, kind, unit(rng), coordinate, multiplier, offset))
    m = links + 2
    a = 0.15 * rng.normal(size=(m, 3))
    b = a + 0.2 * rng.normal(size=(m, 3)) * (np.arange(m) % 3 > 0)[:, None]
    capsules = Capsules(rng.integers(0, links, m), a, b, rng.uniform(0.01, 0.05, m))
    pairs = [(i, j) for i in range(links) for j in range(i + 2, links)] if self_pairs else []
    names = tuple(f"q{i}" for i in range(coordinates))
    return Robot(
        "random", tuple(made), links - 1, names, Limits.unlimited(coordinates), capsules=capsules, self_pairs=pairs
    )


def random_solid(rng, kind, spread=0.8):
    c = spread * rng.normal(size=3)
    if kind == "ball":
        return Ball(c, rng.uniform(0.02, 0.3))
    if kind == "capsule":
        return Capsule(c, c + 0.5 * rng.normal(size=3), rng.uniform(0.02, 0.2))
    if kind == "cylinder":
        return Cylinder(c, c + 0.5 * rng.normal(size=3), rng.uniform(0.02, 0.4))
    if kind == "box":
        return Box(c, rng.uniform(0.02, 0.4, 3), rotation(rng))
    if kind == "half-space":
        return HalfSpace(unit(rng), -2.0 + 0.3 * rng.normal())
    if kind == "ellipsoid":
        return Ellipsoid(c, rng.uniform(0.05, 0.5, 3), rotation(rng))
    return PointCloud(c + 0.2 * rng.normal(size=(20, 3)), 0.02)


def world_capsules(robot, q):
    """Ends of all capsules at q by the reference kinematics in plain numpy: two (m, 3) arrays."""
    frames = link_frames(robot.links, q)
    c = robot.capsules
    return (
        np.array([move_points(frames[k], p) for k, p in zip(c.link, c.a)]),
        np.array([move_points(frames[k], p) for k, p in zip(c.link, c.b)]),
    )
