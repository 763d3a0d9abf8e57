"""What an arm is asked to reach."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array
from ..versors import Motor

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class GripperOnPlane:
    """Bring the gripper point to `point`, with the gripper's direction parallel to a plane ([Humanoid] section V).

    point: (..., 3) metres, in the base frame; normal: (..., 3) of the plane, of any length. Both may be given as
    entities that have `as_euclidean()` (Point) or `.normal` (Plane). Leading axes broadcast. The wrist is left free
    on a circle: `phi`. Raises InputError for wrong shapes, NaN, a normal of zero length.
    """

    point: Floats
    normal: Floats

    def __post_init__(self) -> None:
        point: Any = self.point.as_euclidean() if hasattr(self.point, "as_euclidean") else self.point
        normal: Any = self.normal.normal if hasattr(self.normal, "normal") else self.normal
        point, normal = float_array(point, "point", last=3), float_array(normal, "normal", last=3)
        length = np.sqrt((normal * normal).sum(axis=-1, keepdims=True))
        if (length < 1e-12).any():
            raise InputError(
                "the normal has zero length", place="normal", remedy="give the plane's normal as (x, y, z)"
            )
        unit = normal / length
        for name, value in (("point", np.array(point)), ("normal", unit)):
            value.setflags(write=False)
            object.__setattr__(self, name, value)


def pose_arrays(target: Any, place: str = "target") -> tuple[Floats, Floats]:
    """Rotations (..., 3, 3) and origins (..., 3) of a target pose: a Motor, or a (..., 4, 4) matrix."""
    if hasattr(target, "as_matrix"):
        matrix = np.asarray(target.as_matrix(), dtype=np.float64)
    elif isinstance(target, GripperOnPlane):
        raise InputError(
            "GripperOnPlane is a target of the 5-DOF humanoid arm only",
            place=place,
            remedy="give a Motor, the tip's pose",
        )
    else:
        try:
            matrix = float_array(target, place)
        except InputError:
            matrix = np.zeros(0)
        if matrix.shape[-2:] != (4, 4):
            raise InputError(f"expected a Motor or a (..., 4, 4) pose matrix, got {type(target).__name__}", place=place)
    if not np.isfinite(matrix).all():
        raise InputError("the pose is not finite", place=place)
    rotation = matrix[..., :3, :3]
    drift = np.abs(np.swapaxes(rotation, -1, -2) @ rotation - np.eye(3)).max(initial=0.0)
    if drift > 1e-6 or (np.linalg.det(rotation) < 0).any():
        raise InputError(f"the rotation is not proper orthonormal (off by {drift:.1e})", place=place)
    return np.ascontiguousarray(rotation), np.ascontiguousarray(matrix[..., :3, 3])


def pose_motor(target: Any, place: str = "target") -> Floats:
    """The target pose as a motor array (..., 8)."""
    if isinstance(target, Motor):
        return target.array
    rotation, origin = pose_arrays(target, place)
    matrix = np.zeros((*origin.shape[:-1], 4, 4))
    matrix[..., :3, :3], matrix[..., :3, 3], matrix[..., 3, 3] = rotation, origin, 1.0
    return np.asarray(Motor.from_matrix(matrix).array)


def broadcast_rows(batch: tuple[int, ...], *arrays: Floats) -> list[Floats]:
    """Each array (..., k) on the whole batch, as contiguous rows (m, k)."""
    if batch == ():
        return [a.reshape(1, -1) if a.flags.c_contiguous else np.ascontiguousarray(a).reshape(1, -1) for a in arrays]
    return [np.ascontiguousarray(np.broadcast_to(a, (*batch, a.shape[-1])).reshape(-1, a.shape[-1])) for a in arrays]


def batch_shape(*arrays: Floats) -> tuple[int, ...]:
    """The common leading shape of arrays (..., k). Raises InputError if there is none."""
    for a in arrays:
        if a.ndim != 1:
            return common_shape(*(a.shape[:-1] for a in arrays))
    return ()


def common_shape(*shapes: tuple[int, ...]) -> tuple[int, ...]:
    """What these leading shapes broadcast to. Raises InputError if they do not."""
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        different = ", ".join(map(str, dict.fromkeys(filter(None, shapes))))
        raise InputError(
            f"leading shapes {different} do not broadcast", place="inverse",
            remedy="target, seed and redundancy need the same leading axes, or none",
        ) from None  # fmt: skip


@cache
def interpreted() -> bool:
    """Whether numba's compiler is switched off."""
    from numba import config

    return bool(config.DISABLE_JIT)


def run(kernel: Any, single: tuple[bool, ...], *rows: Floats) -> Floats:
    """A traced kernel on rows (m, k); `single` marks the one-row arguments. One compiled pattern a kernel, for every
    call.
    """
    count = max(len(row) for row, alone in zip(rows, single) if not alone)
    if interpreted():
        return np.broadcast_to(kernel.reference(*rows), (count, kernel.width_out))
    out = np.empty((count, kernel.width_out))
    kernel.run(single, *rows, out)
    return out


def run_one(kernel: Any, single: tuple[bool, ...], *vectors: Floats) -> Floats:
    """`run` for one record: contiguous vectors (k,) in, the row (1, width) out."""
    if interpreted():
        return run(kernel, single, *(v[None] for v in vectors))
    out = np.empty(kernel.width_out)
    kernel.run(single, *vectors, out)
    return out.reshape(1, -1)


def angle_column(value: Any, name: str) -> Floats:
    """An angle (...), radians, as an array (..., 1); InputError if it is no finite number."""
    if type(value) is float and math.isfinite(value):
        return np.array([value])
    return float_array(value, name)[..., None]
