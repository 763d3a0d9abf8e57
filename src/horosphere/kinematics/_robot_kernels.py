"""Kernels for one robot: its constants folded in, compiled at first use, kept on disk by content."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..kernels import BIVECTOR, E0, EUCLIDEAN, MOTOR, MV, Kernel, apply_motor, output_array, scalars
from ..numeric import float_array
from ..robots import Robot
from ..robots._robot import require_robot
from ..versors import Motor
from . import _joint_kernels as joints
from ._tree import Tree, chain

Floats = NDArray[np.float64]
KINDS = ("fixed", "revolute", "prismatic")


def clean(values: Any) -> list[float]:
    """Constants without rounding dust: 6e-17 for the cosine of a right angle would cost a multiplication each time."""
    return [0.0 if abs(float(v)) < 1e-15 else float(v) for v in values]


def trace_chain(arrays: Tree, q: list[Any]) -> tuple[list[MV], MV]:
    """Frames of the moving joints and of the tool as expressions of the symbols q."""
    frames: list[MV] = []
    for i in range(len(arrays.parents)):
        pose = MV.of(MOTOR, clean(arrays.origins[i]))
        if frames:
            pose = frames[-1] * pose
        kind = KINDS[arrays.kinds[i]]
        if kind != "fixed":
            value = q[arrays.coords[i]] * float(arrays.mult[i]) + float(arrays.offs[i])
            pose = pose * joints.joint_motor(kind, clean(arrays.axes[i]), value)
        frames.append(pose)
    return frames[:-1], frames[-1]


def trace_jacobian(arrays: Tree, q: list[Any], n: int) -> tuple[MV, list[Any]]:
    """The tool frame and the 6 n entries of its Jacobian, row by row."""
    frames, tool = trace_chain(arrays, q)
    x = apply_motor(tool, E0, EUCLIDEAN).on(EUCLIDEAN)
    entries: list[Any] = [0.0] * (6 * n)
    for i, frame in enumerate(frames):
        generator = joints.axis_generator(KINDS[arrays.kinds[i]], clean(arrays.axes[i]))
        column = joints.tip_column(apply_motor(frame, generator, BIVECTOR), x)
        for r in range(6):
            at = r * n + int(arrays.coords[i])
            entries[at] = entries[at] + column[r] * float(arrays.mult[i])
    return tool, entries


def forward_kernel(robot: Robot) -> Kernel:
    """q (n,) -> motor (8,) of the tool frame."""
    arrays = chain(robot)

    def forward_of_robot(q):
        return trace_chain(arrays, q)[1].on(MOTOR)

    return Kernel("forward_of_robot", forward_of_robot, {"q": scalars(robot.n_joints)}, 8, finite=True)


def jacobian_kernel(robot: Robot) -> Kernel:
    """q (n,) -> Jacobian (6, n) at the tool frame."""
    arrays, n = chain(robot), robot.n_joints

    def jacobian_of_robot(q):
        return trace_jacobian(arrays, q, n)[1]

    return Kernel("jacobian_of_robot", jacobian_of_robot, {"q": scalars(n)}, 6 * n, axes=[(6, n)], finite=True)


def both_kernel(robot: Robot) -> Kernel:
    """q (n,) -> motor (8,) and Jacobian (6, n)."""
    arrays, n = chain(robot), robot.n_joints

    def forward_and_jacobian_of_robot(q):
        tool, entries = trace_jacobian(arrays, q, n)
        return [*tool.on(MOTOR), *entries]

    return Kernel(
        "forward_and_jacobian_of_robot", forward_and_jacobian_of_robot, {"q": scalars(n)}, 8 + 6 * n,
        axes=[(8,), (6, n)], finite=True,
    )  # fmt: skip


MAKERS: dict[str, tuple[Callable[[Robot], Kernel], list[type]]] = {
    "forward": (forward_kernel, [Motor]),
    "jacobian": (jacobian_kernel, [np.ndarray]),
    "forward and jacobian": (both_kernel, [Motor, np.ndarray]),
}
_KERNELS: dict[tuple[str, str], Kernel] = {}


def robot_kernel(robot: Robot, what: str) -> Kernel:
    """The kernel for one of MAKERS; robots that move alike share it."""
    key = (require_robot(robot).content, what)
    if key not in _KERNELS:
        _KERNELS[key] = MAKERS[what][0](robot)
    return _KERNELS[key]


def run(robot: Robot, what: str, q: ArrayLike, outs: Sequence[Any]) -> list[Floats]:
    """The general way to the outputs of a kernel: any q that numpy takes, outs given or None.

    Leaves the direct way in `robot.memo[what]`, where the public functions look first.
    """
    kernel = robot_kernel(robot, what)
    q = float_array(q, f"q of {robot.name!r}", last=robot.n_joints)
    results = [output_array(out, (*q.shape[:-1], *axes)) for out, axes in zip(outs, kernel.axes, strict=True)]
    kernel(q, out=results[0] if len(results) == 1 else results)
    if what not in robot.memo:
        robot.memo[what] = kernel.direct([np.ndarray], MAKERS[what][1]).call
    return results
