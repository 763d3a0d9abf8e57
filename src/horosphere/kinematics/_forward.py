"""Forward kinematics: the tool frame, all link frames, anything a link carries."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..kernels import output_array
from ..numeric import float_array
from ..robots import Robot, link_index
from ..robots._robot import require_robot
from ..versors import Motor
from ._robot_kernels import run
from ._tree import tree

Floats = NDArray[np.float64]


def joint_array(robot: Robot, q: ArrayLike) -> Floats:
    """q as a C-contiguous float64 array (..., n); InputError if it has another last axis."""
    return float_array(q, f"q of {require_robot(robot).name!r}", last=robot.n_joints, finite=False)


def check_finite(robot: Robot, q: Floats) -> None:
    """InputError with the place of the first q that is not finite."""
    float_array(q, f"q of {robot.name!r}")


def forward(robot: Robot, q: ArrayLike, out: Floats | None = None) -> Motor:
    """Pose of the tool frame in the base frame.

    q: (..., n) radians or metres, not checked against the limits. out: (..., 8) array for the motor's coefficients,
    which the returned Motor then shares. M = M_1 ... M_n M_tool with M_i = origin_i exp(-q_i L_i / 2): [Humanoid] eq
    18. The kernel is the robot's own, its constants folded in: compiled at the first call (0.3 s), then kept on disk.
    Raises InputError for a wrong shape or numbers that are not finite.
    """
    try:
        motor = robot.memo["forward"](q, out)
    except (KeyError, AttributeError):  # not compiled yet
        motor = None
    if motor is not None:
        return motor
    return Motor._wrap(run(robot, "forward", q, [out])[0].view())


def frames(robot: Robot, q: ArrayLike, out: Floats | None = None) -> Motor:
    """Poses of all link frames in the base frame, a Motor with array (..., links, 8) in the order of `robot.links`.

    q: (..., n). out: (..., links, 8). Raises InputError as `forward` does.
    """
    from . import _kernels

    q = joint_array(robot, q)
    check_finite(robot, q)
    result = output_array(out, (*q.shape[:-1], len(robot.links), 8))
    flat = _writable(q.reshape(-1, robot.n_joints))
    _kernels.frames_batch(*tree(robot), flat, result.reshape(-1, len(robot.links), 8))
    return Motor._wrap(result.view())


def carry(robot: Robot, q: ArrayLike, entity: Any, link: str | None = None) -> Any:
    """An entity that a link carries, in the base frame: M(q) @ entity.

    entity: any of Point, Line, Plane, ..., fixed in the link's frame (default: the tool frame); batch axes broadcast
    against those of q.
    """
    return link_pose(robot, q, link) @ entity


def link_pose(robot: Robot, q: ArrayLike, link: str | None) -> Motor:
    """Pose of a link by name, of the tool frame for None."""
    if link is None:
        return forward(robot, q)
    return Motor._wrap(np.ascontiguousarray(frames(robot, q).array[..., link_index(robot, link), :]))


def _writable(array: Floats) -> Floats:
    """The array, or a copy if it is read-only: compiled loops know only writable ones."""
    return array if array.flags.writeable else array.copy()
