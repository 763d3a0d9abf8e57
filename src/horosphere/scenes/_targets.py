"""What a robot starts from and what it shall reach: one record per kind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array

Floats = NDArray[np.float64]


def frozen_array(value: ArrayLike, name: str, last: int | None = None) -> Floats:
    """A private read-only vector of finite numbers."""
    array = np.array(float_array(value, name, last=last, ndim=1))
    array.setflags(write=False)
    return array


def unit(value: ArrayLike, name: str, last: int | None = None) -> Floats:
    """A private read-only vector of length one; a zero vector is refused."""
    array = np.array(float_array(value, name, last=last, ndim=1))
    length = float(np.linalg.norm(array))
    if length < 1e-12:
        raise InputError("expected a direction, got the zero vector", place=name)
    array /= length
    array.setflags(write=False)
    return array


@dataclass(frozen=True, slots=True, eq=False)
class JointTarget:
    """One configuration: `q` (n,), radians or metres."""

    q: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", frozen_array(self.q, "joints"))


@dataclass(frozen=True, slots=True, eq=False)
class PositionTarget:
    """The tool point (or the ball) at `position` (d,), metres; orientation free."""

    position: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", frozen_array(self.position, "position"))


@dataclass(frozen=True, slots=True, eq=False)
class GripperPlaneTarget:
    """The gripper point at `position` (3,), its direction parallel to the plane with `normal` (3,) through it."""

    position: Floats
    normal: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", frozen_array(self.position, "position", 3))
        object.__setattr__(self, "normal", unit(self.normal, "plane_normal", 3))


@dataclass(frozen=True, slots=True, eq=False)
class PoseTarget:
    """The tool frame at `position` (3,) with orientation `quaternion` (4,) in the order w, x, y, z."""

    position: Floats
    quaternion: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", frozen_array(self.position, "position", 3))
        object.__setattr__(self, "quaternion", unit(self.quaternion, "quaternion_wxyz", 4))

    def as_matrix(self) -> Floats:
        """The pose as a homogeneous (4, 4) matrix."""
        matrix = np.eye(4)
        matrix[:3, :3] = quaternion_matrix(self.quaternion)
        matrix[:3, 3] = self.position
        return matrix

    def motor(self):
        """The pose as a `Motor`."""
        from ..versors import Motor

        return Motor.from_matrix(self.as_matrix())


@dataclass(frozen=True, slots=True, eq=False)
class LineTarget:
    """The tool point anywhere on the line through `point` (3,) along `direction` (3,)."""

    point: Floats
    direction: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", frozen_array(self.point, "point", 3))
        object.__setattr__(self, "direction", unit(self.direction, "direction", 3))


@dataclass(frozen=True, slots=True, eq=False)
class PlaneTarget:
    """The tool point anywhere in the plane n.x = `distance`."""

    normal: Floats
    distance: float

    def __post_init__(self) -> None:
        length = float(np.linalg.norm(frozen_array(self.normal, "normal", 3)))
        object.__setattr__(self, "normal", unit(self.normal, "normal", 3))
        object.__setattr__(self, "distance", float(self.distance) / length)


@dataclass(frozen=True, slots=True, eq=False)
class HeadingTarget:
    """A unicycle at `position` (2,), looking along `heading` (radians, None: any)."""

    position: Floats
    heading: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", frozen_array(self.position, "position", 2))


@dataclass(frozen=True, slots=True, eq=False)
class PostureTarget:
    """A snake's configuration `q` = (x, y, theta, Phi_1 .. Phi_N): metres, radians."""

    q: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", frozen_array(self.q, "posture"))


Target = (
    JointTarget
    | PositionTarget
    | GripperPlaneTarget
    | PoseTarget
    | LineTarget
    | PlaneTarget
    | HeadingTarget
    | PostureTarget
)


def quaternion_matrix(quaternion: ArrayLike) -> Floats:
    """The (3, 3) rotation of a unit quaternion (w, x, y, z)."""
    w, x, y, z = float_array(quaternion, "quaternion", last=4, ndim=1)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def matrix_quaternion(matrix: ArrayLike) -> Floats:
    """The unit quaternion (w, x, y, z), w >= 0, of a (3, 3) rotation."""
    R = float_array(matrix, "matrix", last=3, ndim=2)
    if len(R) != 3:
        raise InputError(f"expected shape (3, 3), got {R.shape}", place="matrix")
    # The eigenvector of the largest eigenvalue is accurate for every angle, pi included.
    K = np.array(
        [
            [R[0, 0] + R[1, 1] + R[2, 2], 0.0, 0.0, 0.0],
            [R[2, 1] - R[1, 2], R[0, 0] - R[1, 1] - R[2, 2], 0.0, 0.0],
            [R[0, 2] - R[2, 0], R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], 0.0],
            [R[1, 0] - R[0, 1], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1]],
        ]
    )
    quaternion = np.linalg.eigh(K)[1][:, -1]
    return quaternion if quaternion[0] >= 0 else -quaternion


def rpy_quaternion(rpy: ArrayLike) -> Floats:
    """The unit quaternion (w, x, y, z) of rotations about the fixed axes x, then y, then z, in radians."""
    half = 0.5 * np.asarray(rpy, dtype=np.float64)
    (cr, cp, cy), (sr, sp, sy) = np.cos(half), np.sin(half)
    return np.array(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )
