"""A robot as the arrays that one step of the live loop works on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..distance import pack_robot
from ..robots import Robot
from ..robots._placement import compose, link_frames, rotation_translation

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Arm(NamedTuple):
    """Arrays of a robot, named as in `_reactive_kernels.py`; `tool`: tip in its moving frame.

    `link`: names, one a capsule; `order`: which of the robot's capsules it is.
    """

    J: Integers
    C: Floats
    L: Integers
    K: Floats
    F: Integers
    B: Floats
    G: Integers
    P: Integers
    tip: int
    tool: Floats
    link: tuple[str, ...]
    order: Integers


def pack_arm(robot: Robot) -> Arm:
    """The arrays of `pack_robot`, capsules sorted by frame, pairs by the frames they join."""
    body = pack_robot(robot)
    J, C = body.joints.copy(), body.constants.copy()
    order = np.argsort(body.frames, kind="stable")
    place_of = np.argsort(order)
    L, K = body.frames[order].copy(), body.capsules[order].copy()
    frames = len(J)
    F = np.stack([np.searchsorted(L, np.arange(frames), side) for side in ("left", "right")], axis=1).astype(np.int64)
    B = np.zeros((frames, 4))
    for k in range(frames):
        B[k] = _ball(K[F[k, 0] : F[k, 1]])
    P, common = place_of[body.pairs[:, :2]].reshape(-1, 2), body.pairs[:, 2]
    keys = np.column_stack([L[P].reshape(-1, 2), common]) if len(P) else np.zeros((0, 3), np.int64)
    sort = np.lexsort(keys.T[::-1])
    P, keys = np.ascontiguousarray(P[sort]), keys[sort]
    starts = np.flatnonzero(np.any(np.diff(keys, axis=0, prepend=-1), axis=1)) if len(P) else np.zeros(0, np.int64)
    stops = np.append(starts[1:], len(P))[: len(starts)]
    G = np.column_stack([keys[starts], starts, stops]).astype(np.int64).reshape(-1, 5)
    tip, tool = _tip(robot, J, C)
    links = tuple(robot.links[robot.capsules.link[i]].name for i in order)
    return Arm(J, C, L, K, F, B, np.ascontiguousarray(G), P.astype(np.int64), tip, tool, links, order)


def _ball(capsules: Floats) -> Floats:
    """Centre and radius of a ball that holds the capsules: about the middle of their box."""
    if not len(capsules):
        return np.zeros(4)
    ends, radii = capsules[:, :6].reshape(-1, 2, 3), capsules[:, 6]
    low = (ends.min(axis=1) - radii[:, None]).min(axis=0)
    high = (ends.max(axis=1) + radii[:, None]).max(axis=0)
    centre = 0.5 * (low + high)
    far = np.linalg.norm(ends - centre, axis=2).max(axis=1) + radii
    return np.append(centre, far.max() * (1.0 + 1e-12))


def _tip(robot: Robot, J: Integers, C: Floats) -> tuple[int, Floats]:
    """The moving frame that carries the tip, and the tool in it: rotation by rows, position."""
    moving = [link for link in range(len(robot.links)) if robot.links[link].kind != "fixed"]
    carrier = robot.tip
    while carrier and robot.links[carrier].kind == "fixed":
        carrier = robot.links[carrier].parent
    tip = moving.index(carrier) + 1 if carrier in moving else 0
    q = np.zeros(robot.n_joints)
    frame = np.eye(4)
    for k in _chain(J, tip):
        R, p, value = C[k, :9].reshape(3, 3), C[k, 9:12], C[k, 12] * q[J[k, 2]] + C[k, 13] if J[k, 1] else 0.0
        turn = np.eye(4)
        turn[:3, :3], turn[:3, 3] = R, p
        motion = np.eye(4)
        if J[k, 1] == 1:
            c, s = np.cos(value), np.sin(value)
            motion[:2, :2] = [[c, -s], [s, c]]
        elif J[k, 1] == 2:
            motion[2, 3] = value
        frame = frame @ turn @ motion
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation_translation(compose(link_frames(robot.links, q)[robot.tip], robot.tool))
    tool = np.linalg.inv(frame) @ pose
    return tip, np.append(tool[:3, :3].ravel(), tool[:3, 3])


def _chain(J: Integers, k: int) -> list[int]:
    path = []
    while k >= 0:
        path.append(k)
        k = int(J[k, 0])
    return path[::-1]


def workspace(arm: Arm, solids: int, n: int) -> tuple[tuple[Floats, ...], Integers]:
    """Room for one step: T, X, W, N, A, b, H, Jt, U, lam, and the integers of N. More pairs than N holds count as not proved."""
    m, frames = len(arm.L), len(arm.J)
    pairs = min(m * solids + len(arm.P), 8192)
    rows = min(frames * solids + len(arm.G), 256)
    shapes = ((frames, 12), (m, 9), (frames, 6), (pairs, 9), (rows, n), (rows, 7), (12, 9), (6, n), (8, n), (rows, 3))
    return tuple(np.zeros(shape) for shape in shapes), np.zeros((pairs, 5), np.int64)
