"""A robot's chain as screw axes at q = 0: what the structural classifier and the closed forms read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Screws:
    """axes (n, 3) unit, points (n, 3) on them, home (4, 4) pose of the tip, all at q = 0 in the base frame.

    Pose of the tip = exp(S1 q1) ... exp(Sn qn) home, right-handed about the axes.
    """

    axes: Floats
    points: Floats
    home: Floats

    def reversed(self) -> Screws:
        """The chain from the tip to the base: axes in reverse order; its pose is the inverse, its angles are -q
        reversed.
        """
        return Screws(
            np.ascontiguousarray(self.axes[::-1]),
            np.ascontiguousarray(self.points[::-1]),
            np.asarray(np.linalg.inv(self.home), dtype=np.float64),
        )

    def freedoms(self, held: int = -1, smallest: float = 1e-4) -> int:
        """In how many dimensions the joints move the tip at postures in general, the joint `held` left alone: the largest rank of
        the Jacobian in some random ones (always the same), of singular values above `smallest` times the chain's extent.
        """
        size = max(float(np.ptp(self.points, axis=0).max()), 1e-6)
        rank = 0
        for q in np.random.default_rng(0).uniform(-3.0, 3.0, (4, len(self.axes))):
            M, columns = np.eye(4), []
            for k, (axis, point, angle) in enumerate(zip(self.axes, self.points, q)):
                turn = np.eye(4)
                turn[:3, :3] = axis_rotation(axis, angle)
                turn[:3, 3] = point - turn[:3, :3] @ point
                if k != held:
                    n, p = M[:3, :3] @ axis, M[:3, :3] @ point + M[:3, 3]
                    columns.append([*n, *(np.cross(p - self.points[0], n) / size)])
                M = M @ turn
            rank = max(rank, int((np.linalg.svd(np.array(columns), compute_uv=False) > smallest).sum()))
        return rank


def screws(robot: Any) -> Screws | str:
    """The chain of revolute joints of a robot, or why it has no such form (in words)."""
    M, axes, points, seen = np.eye(4), [], [], []
    for index in robot.chain:
        link = robot.links[index]
        M = M @ motor_matrix(link.origin)
        if link.kind == "fixed":
            continue
        if link.kind == "prismatic":
            return f"joint {robot.joint_names[link.coordinate]} is prismatic"
        if link.coordinate in seen or abs(abs(link.multiplier) - 1.0) > 1e-12:
            return f"joint {robot.joint_names[link.coordinate]} moves several links of the chain"
        seen.append(link.coordinate)
        axes.append(np.sign(link.multiplier) * (M[:3, :3] @ link.axis))
        points.append(M[:3, 3].copy())
        turn = np.eye(4)
        turn[:3, :3] = axis_rotation(link.axis, link.offset)
        M = M @ turn
    if seen != list(range(robot.n_joints)):
        return "the joints of the chain are not the robot's coordinates in order"
    return Screws(np.array(axes).reshape(-1, 3), np.array(points).reshape(-1, 3), M @ motor_matrix(robot.tool))


def axis_rotation(axis: Floats, angle: float) -> Floats:
    """(3, 3) rotation about a unit axis."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K)


def motor_matrix(motor: Floats) -> Floats:
    """(4, 4) of one unit motor array: t = 2 (b v - w a - v x a) with quaternion (w, v) and ideal part (a, b)."""
    w, v = motor[0], np.array([-motor[3], motor[2], -motor[1]])
    a, b = motor[4:7], motor[7]
    T = np.eye(4)
    K = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    T[:3, :3] = np.eye(3) + 2.0 * w * K + 2.0 * (K @ K)
    T[:3, 3] = 2.0 * (b * v - w * a - np.cross(v, a))
    return T
