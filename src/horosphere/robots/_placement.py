"""Motors of constant frames, in plain numpy: what loading a robot needs, without a compiled kernel.

A motor is eight numbers over (1, e12, e13, e23, e1i, e2i, e3i, e123i): M = (1 - t e_inf / 2) R with
R = cos(angle/2) - sin(angle/2) (n3 e12 - n2 e13 + n1 e23), so the first four are the quaternion (w, -z, y, -x).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
IDENTITY: Floats = np.array([1.0, 0, 0, 0, 0, 0, 0, 0])
IDENTITY.setflags(write=False)


def from_quaternion_translation(wxyz: ArrayLike, xyz: ArrayLike) -> Floats:
    """Motor (..., 8) that turns by the unit quaternion (w, x, y, z), then moves by xyz."""
    w, x, y, z = np.moveaxis(np.asarray(wxyz, float), -1, 0)
    t1, t2, t3 = np.moveaxis(np.asarray(xyz, float), -1, 0)
    c, a, b, d = w, -z, y, -x
    translation = (
        t1 * c - a * t2 - b * t3,
        t2 * c + a * t1 - d * t3,
        t3 * c + b * t1 + d * t2,
        t1 * d - b * t2 + a * t3,
    )
    return np.stack(np.broadcast_arrays(c, a, b, d, *(-0.5 * v for v in translation)), axis=-1)


def from_rpy(xyz: ArrayLike, rpy: ArrayLike) -> Floats:
    """Motor of a URDF origin: fixed-axis roll, pitch, yaw (radians), then the translation (metres)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(np.asarray(rpy, float) / 2), np.sin(np.asarray(rpy, float) / 2)
    wxyz = (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )
    return from_quaternion_translation(np.array(wxyz), xyz)


def from_translation(xyz: ArrayLike) -> Floats:
    """Motor of a pure translation."""
    return from_quaternion_translation([1.0, 0.0, 0.0, 0.0], xyz)


def from_matrix(matrix: ArrayLike) -> Floats:
    """Motor of a rigid motion (4, 4): the quaternion by its largest component."""
    T = np.asarray(matrix, float)
    R = T[:3, :3]
    K = np.array(
        [
            [R[0, 0] + R[1, 1] + R[2, 2], R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]],
            [0.0, R[0, 0] - R[1, 1] - R[2, 2], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0]],
            [0.0, 0.0, R[1, 1] - R[0, 0] - R[2, 2], R[1, 2] + R[2, 1]],
            [0.0, 0.0, 0.0, R[2, 2] - R[0, 0] - R[1, 1]],
        ]
    )
    K = np.triu(K) + np.triu(K, 1).T + np.eye(4)  # 4 q q^T
    k = int(np.argmax(np.diag(K)))
    return from_quaternion_translation(K[k] / np.linalg.norm(K[k]), T[:3, 3])


def from_axis_angle(axis: ArrayLike, angle: Any) -> Floats:
    """Motor (..., 8) of a turn about a unit axis through the origin."""
    half = 0.5 * np.asarray(angle, float)[..., None]
    turn = np.concatenate([np.cos(half), np.sin(half) * np.asarray(axis, float)], axis=-1)
    return from_quaternion_translation(turn, np.zeros(turn.shape[:-1] + (3,)))


def rotation_translation(motor: ArrayLike) -> tuple[Floats, Floats]:
    """Rotation matrix (..., 3, 3) and translation (..., 3) of a unit motor."""
    c, a, b, d, m1, m2, m3, m7 = np.moveaxis(np.asarray(motor, float), -1, 0)
    w, x, y, z = c, -d, b, -a
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    rotation = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    t = (m1 * c + m2 * a + m3 * b + m7 * d, m2 * c - m1 * a + m3 * d - m7 * b, m3 * c - m1 * b - m2 * d + m7 * a)
    return rotation, -2.0 * np.stack(t, axis=-1)


def compose(first: ArrayLike, second: ArrayLike) -> Floats:
    """Motor product first @ second (the second acts first), leading axes broadcast."""
    p, q = np.moveaxis(np.asarray(first, float), -1, 0), np.moveaxis(np.asarray(second, float), -1, 0)
    # quaternion of the product; the translation is t1 + R1 t2
    w1, x1, y1, z1 = p[0], -p[3], p[2], -p[1]
    w2, x2, y2, z2 = q[0], -q[3], q[2], -q[1]
    wxyz = (
        w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
        w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
        w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
        w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
    )
    rotation, moved = rotation_translation(first)
    inner = rotation_translation(second)[1]
    return from_quaternion_translation(np.stack(wxyz, axis=-1), moved + np.einsum("...ij,...j->...i", rotation, inner))


def move_points(motor: ArrayLike, points: ArrayLike) -> Floats:
    """Images (..., 3) of Euclidean points under a motor, leading axes broadcast."""
    rotation, translation = rotation_translation(motor)
    return np.einsum("...ij,...j->...i", rotation, np.asarray(points, float)) + translation


def link_frames(links: Any, q: ArrayLike) -> Floats:
    """Motors (..., links, 8) of all link frames in the base frame, one numpy operation at a time (the reference)."""
    q = np.asarray(q, float)
    frames: list[Floats] = []
    for link in links:
        frame = np.broadcast_to(link.origin, q.shape[:-1] + (8,))
        if link.parent >= 0:
            frame = compose(frames[link.parent], frame)
        if link.kind != "fixed":
            value = link.multiplier * q[..., link.coordinate] + link.offset
            step = (
                from_axis_angle(link.axis, value)
                if link.kind == "revolute"
                else from_translation(value[..., None] * link.axis)
            )
            frame = compose(frame, step)
        frames.append(frame)
    return np.stack(frames, axis=-2)
