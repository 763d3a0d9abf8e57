"""A robot's moving frames and capsules as arrays for compiled code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numeric import nearest_rotation
from ..robots import Robot
from ..robots._placement import rotation_translation
from ..robots._robot import require_robot
from ..shapes import Packed

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
ROUNDING = 2.0**-53
KIND_NUMBER = {"fixed": 0, "revolute": 1, "prismatic": 2}


class Body(NamedTuple):
    """The arrays that `_body_kernels.py` explains, in the order of its arguments, without the obstacles."""

    joints: Integers
    constants: Floats
    frames: Integers
    capsules: Floats
    pairs: Integers


def pack_robot(robot: Robot, static: bool = True) -> Body:
    """The arrays of a robot, made once; fixed joints are folded into their parents, so their capsules hang on moving frames.

    Without `static`, the bodies that no joint moves (frame 0) are marked by frame -1: they meet the robot's own links, and no
    obstacle. A robot stands on something, and no motion changes how far its base is from it.
    """
    if "distance" not in require_robot(robot).memo:
        body = _pack(robot)
        robot.memo["distance"] = body
        robot.memo["distance of what moves"] = body._replace(frames=np.where(body.frames == 0, -1, body.frames))
    return robot.memo["distance" if static else "distance of what moves"]


def _pack(robot: Robot) -> Body:
    joints: list[tuple[int, int, int]] = [(-1, 0, 0)]
    constants = [np.concatenate((np.eye(3).ravel(), np.zeros(3), [0.0, 0.0]))]
    at: list[tuple[int, Floats, Floats]] = []  # of each link: moving frame, rotation and translation in it
    for link in robot.links:
        R, t = rotation_translation(link.origin)
        R = nearest_rotation(R)
        frame = 0
        if link.parent >= 0:
            frame, R0, t0 = at[link.parent]
            R, t = R0 @ R, t0 + R0 @ t
        if link.kind == "fixed":
            at.append((frame, R, t))
            continue
        turn = _z_to(link.axis)
        joints.append((frame, KIND_NUMBER[link.kind], link.coordinate))
        constants.append(np.concatenate(((R @ turn).ravel(), t, [link.multiplier, link.offset])))
        at.append((len(joints) - 1, turn.T, np.zeros(3)))
    c = robot.capsules
    frames = np.array([at[k][0] for k in c.link], np.int64)
    capsules = np.zeros((len(c), 8))
    for i, k in enumerate(c.link):
        _, R, t = at[k]
        capsules[i, :3], capsules[i, 3:6] = R @ c.a[i] + t, R @ c.b[i] + t
        capsules[i, 6] = c.radius[i]
        capsules[i, 7] = c.radius[i] + 0.5 * np.linalg.norm(c.b[i] - c.a[i])
    return Body(
        np.array(joints, np.int64),
        np.array(constants),
        frames,
        capsules,
        _self_pairs(robot, frames, [j[0] for j in joints]),
    )


def _z_to(axis: Floats) -> Floats:
    """A rotation that takes z to the unit vector `axis`."""
    z = axis / np.linalg.norm(axis)
    x = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z], dtype=np.float64).T


def _self_pairs(robot: Robot, frames: Integers, parents: list[int]) -> Integers:
    """Pairs of capsules of the robot's link pairs, with the last moving frame that carries both."""
    of_link: dict[int, list[int]] = {}
    for i, k in enumerate(robot.capsules.link):
        of_link.setdefault(int(k), []).append(i)
    rows = []
    for a, b in robot.self_pairs:
        for i in of_link.get(int(a), []):
            for j in of_link.get(int(b), []):
                up, down = int(frames[i]), int(frames[j])
                while up != down:  # parents have smaller numbers
                    up, down = (parents[up], down) if up > down else (up, parents[down])
                rows.append((i, j, up))
    return np.array(rows, np.int64).reshape(-1, 3)


def rounding_slack(body: Body, solids: Packed, waypoints: Floats) -> tuple[float, float]:
    """What float64 can lose in a bound, whatever the bodies, and in the distance of a point from a joint's axis (m).

    Derived term by term in docs/certificate.md.
    """
    C, kind, coordinate = body.constants, body.joints[:, 1], body.joints[:, 2]
    largest = np.abs(waypoints).max(axis=0, initial=0.0)
    value = np.abs(C[:, 12]) * np.append(largest, 0.0)[coordinate] + np.abs(C[:, 13])
    turns, slides = kind == KIND_NUMBER["revolute"], kind == KIND_NUMBER["prismatic"]
    n, A = len(C) - 1, float(value[turns].max(initial=0.0))
    ends = np.linalg.norm(body.capsules[:, :6].reshape(-1, 3), axis=1)
    D = float(np.linalg.norm(C[:, 9:12], axis=1).sum() + value[slides].sum() + ends.max(initial=0.0))
    rows = solids.rows
    size = np.linalg.norm(rows[:, 1:4], axis=1) + np.where(np.isfinite(rows[:, 4]), rows[:, 4], 0.0)
    both = D + float(size.max(initial=0.0)) + float(body.capsules[:, 6].max(initial=0.0))
    slack = 2.0 * (n + 1) * (27.0 + 7.0 * A) * D + (20.0 * n + 200.0) * both
    return ROUNDING * slack, ROUNDING * (n + 1) * (88.0 + 22.0 * A) * D
