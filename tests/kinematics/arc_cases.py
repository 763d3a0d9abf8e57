"""Arms with a redundancy, targets, scenes with an obstacle of every kind, and dense sampling as a witness of free arcs."""

from dataclasses import replace

import numpy as np
import structured_arms as arms

from horosphere.distance import signed
from horosphere.kinematics import GripperOnPlane, forward, inverse
from horosphere.robots import Capsules, humanoid_arm, load
from horosphere.shapes import Ball, Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Mesh, PointCloud


def with_bodies(name, arm):
    """The arm with one capsule a link, from each joint to the next where that is within 0.6 m."""
    robot = arms.robot(name, arm, 2.6)
    points = np.array(arm[1], float)
    link, b = zip(
        *[(k + 1, points[k + 1] - points[k]) for k in range(6) if np.linalg.norm(points[k + 1] - points[k]) > 0.02]
    )
    zeros = np.zeros((len(link), 3))
    return replace(robot, capsules=Capsules(np.array(link), zeros, np.array(b), np.full(len(link), 0.04)))


CASES = {
    "panda": lambda: (load("panda"), "q7"),
    "iiwa": lambda: (load("iiwa14"), "psi"),
    "humanoid": lambda: (humanoid_arm(), "phi"),
    "elbow offset": lambda: (with_bodies("offset", arms.OFFSET_SRS), "psi"),
    "xarm7": lambda: (with_bodies("xarm7", arms.XARM7), "q7"),
    "reversed": lambda: (with_bodies("reversed", arms.XARM7_REVERSED), "q1"),
}


def target_of(robot, q, rng):
    pose = forward(robot, q)
    if robot.n_joints != 5:
        return pose
    T = pose.as_matrix()
    return GripperOnPlane(T[:3, 3], np.cross(T[:3, 1], rng.normal(size=3)))


def every_kind(rng):
    """A scene with an obstacle of every kind, some of them small, the floor below the arm."""
    at = lambda: rng.uniform([-0.7, -0.7, 0.0], [0.7, 0.7, 1.0])
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    a, b, corner = at(), at(), at()
    vertices = corner + 0.12 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    return [
        Ball(at(), rng.uniform(0.03, 0.1)),
        Capsule(a, a + rng.uniform(-0.2, 0.2, 3), 0.03),
        Cylinder(b, b + rng.uniform(-0.2, 0.2, 3), 0.05),
        Box(at(), rng.uniform(0.03, 0.12, 3), turn),
        Ellipsoid(at(), rng.uniform(0.03, 0.1, 3), turn),
        HalfSpace([0.05, 0.02, 1.0], -0.4),
        Mesh(vertices, faces),
        PointCloud(at() + rng.uniform(-0.1, 0.1, (20, 3)), 0.01),
        PointCloud(at() + rng.uniform(-0.1, 0.1, (90, 3)), 0.01),
    ]


def witnessed(robot, parameter, target, obstacles, arcs, values, clearance, own=None, margin=0.0):
    """Dense sampling with the distance layer: what is said to be free and is not; what is free with `margin`, and found."""
    rows = inverse(robot, target, **{parameter: values})
    inside, false, free, found = rows.within_limits(robot), 0, 0, 0
    for k, arc in enumerate(arcs):
        said = arc.contains(values)
        false += int((said & ~inside[:, k]).sum())
        look = np.flatnonzero(inside[:, k])
        if not len(look):
            continue
        q = rows.q[look, k]
        room = np.minimum(q - robot.limits.lower, robot.limits.upper - q).min(axis=-1)
        gap = signed(robot, q, obstacles, static=False) - clearance
        if own is not None:
            gap = np.minimum(gap, signed(robot, q, (), self_collision=True) - own)
        false += int((said[look] & (gap < 0.0)).sum())
        good = (room > margin) & (gap > margin)
        free, found = free + int(good.sum()), found + int((good & said[look]).sum())
    return false, free, found
