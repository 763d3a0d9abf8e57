"""Kernels for one robot: its constants folded in, compiled at first use, kept on disk by content."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from types import FunctionType
from typing import Any

import numpy as np

from ..errors import InputError
from ..kernels import BIVECTOR, E0, EUCLIDEAN, MOTOR, MV, Kernel, apply_motor, scalars
from ..kernels._cache import OPTIONS, attach_cache
from ..robots import Robot
from . import _joint_kernels as joints
from ._tree import Tree, chain

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
    """q (n,) -> motor (8,) of the tool frame, and the sum of q."""
    arrays = chain(robot)

    def forward_of_robot(q):
        return [*trace_chain(arrays, q)[1].on(MOTOR), sum(q)]

    return Kernel("forward_of_robot", forward_of_robot, {"q": scalars(robot.n_joints)}, 9)


def jacobian_kernel(robot: Robot) -> Kernel:
    """q (n,) -> the 6 n entries of the Jacobian at the tool frame, row by row, and the sum of q."""
    arrays, n = chain(robot), robot.n_joints

    def jacobian_of_robot(q):
        return [*trace_jacobian(arrays, q, n)[1], sum(q)]

    return Kernel("jacobian_of_robot", jacobian_of_robot, {"q": scalars(n)}, 6 * n + 1)


def both_kernel(robot: Robot) -> Kernel:
    """q (n,) -> motor (8,), then the 6 n entries of the Jacobian, then the sum of q."""
    arrays, n = chain(robot), robot.n_joints

    def forward_and_jacobian_of_robot(q):
        tool, entries = trace_jacobian(arrays, q, n)
        return [*tool.on(MOTOR), *entries, sum(q)]

    return Kernel("forward_and_jacobian_of_robot", forward_and_jacobian_of_robot, {"q": scalars(n)}, 9 + 6 * n)


MAKERS: dict[str, Callable[[Robot], Kernel]] = {
    "forward": forward_kernel,
    "jacobian": jacobian_kernel,
    "both": both_kernel,
}
Runner = Callable[[Any, Any], bool]
_KERNELS: dict[tuple[str, str], Kernel] = {}
_RUNNERS: dict[tuple[str, str], Runner] = {}


def robot_kernel(robot: Robot, what: str) -> Kernel:
    """The kernel "forward", "jacobian" or "both" (its last output is the sum of q); robots that move alike share it."""
    key = (robot.content, what)
    if key not in _KERNELS:
        _KERNELS[key] = MAKERS[what](robot)
    return _KERNELS[key]


def runner(robot: Robot, what: str) -> Runner:
    """`run(q, out)` on flat float64 arrays for `what` of this robot.

    Fills out; returns whether the sizes fit and every q is finite. Kept in `robot.memo["run " + what]`, where the
    public functions look for it first.
    """
    name = f"run {what}"
    if name not in robot.memo:
        key = (robot.content, what)
        if key not in _RUNNERS:
            _RUNNERS[key] = _make_runner(robot_kernel(robot, what), robot.n_joints)
        robot.memo[name] = _RUNNERS[key]
    return robot.memo[name]


# The free names of `_run`, given to each copy of it by `_make_runner`.
load_records: Any
store_records: Any
spread: Any
sum_lanes: Any
inline: Any
EIGHT: Any
ONE: Any
n: Any
width: Any


# ruff: noqa: F821
def _run(q, out):
    """The body of every runner."""
    count = out.size // width
    if q.size != count * n or out.size != count * width:
        return False
    whole = count // 8 * 8
    bad, tail = spread(0.0, EIGHT), 0.0
    for i in range(0, whole, 8):
        values = inline(*load_records(q, i, n, EIGHT))
        store_records(out, i, values[:width])
        bad = bad + values[width] * 0.0  # stays zero unless a q is infinite or NaN
    for i in range(whole, count):
        single = inline(*load_records(q, i, n, ONE))
        store_records(out, i, single[:width])
        tail = tail + single[width] * 0.0
    return sum_lanes(bad) + tail == 0.0


def _make_runner(kernel: Kernel, n: int) -> Runner:
    from numba import config, njit
    from numba.core import types

    width = kernel.width_out - 1
    if config.DISABLE_JIT:

        def by_numpy(q, out):
            if out.size * n != q.size * width:
                return False
            result = kernel.reference(q.reshape(-1, n))
            out[:] = result[:, :width].reshape(-1)
            return bool(np.isfinite(result[:, width]).all())

        return by_numpy
    from .. import kernels

    # Not a closure: numba's cache files a closure under its cells, and the intrinsic among them differs from process to
    # process, so that it would never be found again.
    names = {name: getattr(kernels, name) for name in ("load_records", "store_records", "spread", "sum_lanes")}
    names |= {"EIGHT": kernels.EIGHT, "ONE": kernels.ONE, "inline": kernel.inline, "n": n, "width": width}
    names["__name__"] = __name__
    dispatcher = njit(**OPTIONS)(FunctionType(_run.__code__, names, kernel.name))
    attach_cache(dispatcher, sha256(f"checked {kernel.trace.fingerprint}".encode()).hexdigest())
    readable = types.Array(types.float64, 1, "C", readonly=True)
    dispatcher.compile((readable, types.Array(types.float64, 1, "C")))
    dispatcher.disable_compile()
    return dispatcher


def output_array(given: Any, shape: tuple[int, ...]) -> np.ndarray:
    """A new array, or the caller's if it fits."""
    if given is None:
        return np.empty(shape)
    array = given
    if not isinstance(array, np.ndarray):
        raise InputError(f"expected a numpy array of shape {shape}, got {type(given).__name__}", place="out")
    if array.shape != shape or array.dtype != np.float64 or not array.flags.c_contiguous or not array.flags.writeable:
        raise InputError(
            f"expected a writable C-contiguous float64 array of shape {shape}, got {array.dtype} {array.shape}",
            place="out",
        )
    return array
