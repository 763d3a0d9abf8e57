"""The branches of one target as curves over its redundancy, and what bounds them between samples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..distance import pack_robot
from ..errors import InputError
from ._existence import phi_candidates, q7_candidates
from ._forward import forward
from ._targets import GripperOnPlane, pose_motor

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
_SPAN = 0.3  # metres of the tool point that count as a radian, over the reach: where tubes get longest, over some arms


@dataclass(frozen=True, slots=True, eq=False)
class Redundancy:
    """The branches of one target as functions of its redundancy, and what bounds them.

    rows(values (m,)) -> q (m, branches, n), exists (m, branches). ends: sorted angles in [-pi, pi], both included, between which
    every branch exists or does not. parameter: "psi", "q7", "q1" or "phi". The task is the tool's pose, or its point and the
    part of its direction along `normal` (zero for a pose). For `_tube_kernels`: path, the moving frames of `pack_robot` from the
    base to the tool; tool (6,), point and direction in the last of them; levers (n,), the farthest the point can be from each
    joint of the path; span, metres that count as a radian.
    """

    robot: Any
    parameter: str
    branches: int
    ends: Floats
    rows: Callable[[Floats], tuple[Floats, Bools]]
    normal: Floats
    path: NDArray[np.int64]
    tool: Floats
    levers: Floats
    span: float

    @property
    def holds_tool(self) -> bool:
        """Whether the last frame of the path stands still."""
        return not self.normal.any()


def redundancy(robot: Any, target: Any) -> Redundancy:
    """The redundancy of one target. InputError for a robot without one and for a batch of targets."""
    from ._classify import classify

    structure = classify(robot)
    if structure.name == "humanoid_arm":
        return _of_humanoid(robot, target)
    if structure.parameter is None:
        raise InputError(
            f"the inverse kinematics of {robot.name!r} ({structure.name}) has no redundancy in an angle",
            place="robot", remedy="this is for 7-joint arms of the kinds srs7 and sew7 and for the 5-DOF humanoid arm",
        )  # fmt: skip
    from ._redundancy import _psi_candidates
    from ._structured import solver

    made, motor = solver(robot), pose_motor(target)
    if motor.ndim != 1:
        raise InputError(f"expected one pose, got a batch of shape {motor.shape[:-1]}", place="target")
    ends = _psi_candidates(made, motor) if made.structure.name == "srs7" else q7_candidates(made, motor)

    def rows(values: Floats) -> tuple[Floats, Bools]:
        poses = np.array(np.broadcast_to(motor, (len(values), 8)))
        poses.setflags(write=False)
        q, valid, *_ = made.rows(poses, np.ascontiguousarray(values), np.zeros((len(values), 7)))
        return q, valid

    return Redundancy(robot, str(made.structure.parameter), 8, ends, rows, np.zeros(3), *_course(robot, whole=True))


def _of_humanoid(robot: Any, target: Any) -> Redundancy:
    from ._humanoid import arm_parameters, humanoid_inverse, wrists

    if not isinstance(target, GripperOnPlane) or target.point.ndim != 1 or target.normal.ndim != 1:
        raise InputError(
            "expected one GripperOnPlane target", place="target", remedy="a whole pose leaves this arm no freedom"
        )
    arm, point, normal = arm_parameters(robot.closed_form[1]), target.point, target.normal
    three = np.array([[0.0], [0.5 * np.pi], [np.pi]])
    circle, _ = wrists(arm, np.tile(point, (3, 1)), np.tile(normal, (3, 1)), three)

    def rows(values: Floats) -> tuple[Floats, Bools]:
        found = humanoid_inverse(robot, target, phi=values)
        return found.q, found.valid

    ends = phi_candidates(arm, circle)
    return Redundancy(robot, "phi", 8, ends, rows, normal.copy(), *_course(robot, whole=False))


def _course(robot: Any, whole: bool) -> tuple[NDArray[np.int64], Floats, Floats, float]:
    """path, tool, levers and span of a `Redundancy`, made once a robot.

    Where the whole pose stands still any point of the last frame will do: its origin lies on the last axis. Else it is the tool
    point, and the direction is the y axis of the tool, the humanoid arm's gripper.
    """
    known = robot.memo.get("course of the redundancy")
    if known is not None:
        return known
    body = pack_robot(robot, static=False)
    frame_of = np.cumsum([link.kind != "fixed" for link in robot.links])
    path = np.array([frame_of[k] for k in robot.chain if robot.links[k].kind != "fixed"], np.int64)
    tool = np.zeros(6)
    if not whole:
        T = np.eye(4)
        for k in path:
            T = T @ _step(body.constants[k])
        tip = np.linalg.solve(T, np.asarray(forward(robot, np.zeros(robot.n_joints)).as_matrix()))
        tool[:3], tool[3:] = tip[:3, 3], tip[:3, 1]
    lengths = np.linalg.norm(np.concatenate([body.constants[path[1:], 9:12], tool[None, :3]]), axis=1)
    levers = np.cumsum(lengths[::-1])[::-1].copy()
    robot.memo["course of the redundancy"] = path, tool, levers, max(_SPAN * float(levers[0]), 1e-9)
    return robot.memo["course of the redundancy"]


def _step(row: Floats) -> Floats:
    """(4, 4) of a moving frame in the one before it, where all coordinates are zero."""
    M, turn = np.eye(4), np.eye(4)
    M[:3, :3], M[:3, 3] = row[:9].reshape(3, 3), row[9:12]
    c, s = np.cos(row[13]), np.sin(row[13])
    turn[:2, :2] = [[c, -s], [s, c]]
    return M @ turn
