"""Inverse kinematics of the 5-DOF humanoid arm: targets in, branches out. The geometry is in `_humanoid_geometry.py`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array
from ._humanoid_geometry import gripper_circle, humanoid_branches
from ._solutions import IkSolutions, branch_table
from ._targets import GripperOnPlane, angle_column, batch_shape, broadcast_rows, pose_arrays, run, run_one

Floats = NDArray[np.float64]

BITS = ("back", "elbow", "flip")
REACH_TOLERANCE = 1e-13  # of the squared half distance of the elbow pair, over (d1 + d2)^2: arm stretched or folded
POSE_TOLERANCE = 1e-9  # radians: how far the forearm may lie out of the plane that a wanted hinge allows
_NO_HINGE = np.zeros(3)


def humanoid_inverse(
    robot: Any, target: Any, *, phi: ArrayLike | None = None, seed: ArrayLike | None = None, strict: bool = False
) -> IkSolutions:
    """All 8 branches (back, elbow, flip) of the 5-DOF arm. Radians, metres, base frame.

    target: GripperOnPlane with `phi` (...), default 0: the wrist's angle on its circle, gripper outwards at 0; batch
    axes of the target, phi and seed (..., 5) broadcast. Or a pose of the tip, valid when the 5 joints can reach it.
    strict: the whole gripper parallel to the plane (axis of joint 5 too); phi is then a root of a closed form, returned in
    `.free`, and rows are one block of 8 per root.
    Source: [Humanoid] section V, corrected (docs/errata.md).
    """
    arm = robot.memo.get("arm lengths")
    if arm is None:
        arm = robot.memo["arm lengths"] = arm_parameters(robot.closed_form[1])
    seed_rows = np.zeros(5) if seed is None else float_array(seed, "seed", last=5)
    if not isinstance(target, GripperOnPlane):
        if phi is not None or strict:
            raise InputError("phi and strict belong to a GripperOnPlane target; a pose leaves no freedom", place="phi")
        return _of_pose(robot, arm, *pose_arrays(target), seed_rows)
    if strict:
        if phi is not None:
            raise InputError("the strict reading finds phi itself", place="phi", remedy="leave phi out")
        from ._strict import strict_inverse

        return strict_inverse(arm, target, seed_rows)
    angle = np.zeros(1) if phi is None else angle_column(phi, "phi")
    batch = batch_shape(target.point, target.normal, angle, seed_rows)
    if batch == ():
        circle = run_one(gripper_circle, (False, False, False, True), target.point, target.normal, angle, arm[4:])
        p2, single = circle[0, :3], (False, False, False, False, True)
        table = run_one(humanoid_branches, single, p2, target.point, seed_rows, _NO_HINGE, arm)
        one = _Branches(table, batch, gripper_spare=circle[0, 3] > 0.5)
        return one.solutions(arm, lambda q: plane_residual(arm, q, target.point, p2))
    pt, n, at, kept = broadcast_rows(batch, target.point, target.normal, angle, seed_rows)
    p2, spare = wrists(arm, pt, n, at)
    table = branches(arm, p2, pt, kept)
    result = _Branches(table, batch, gripper_spare=spare.reshape(batch))
    return result.solutions(arm, lambda q: plane_residual(arm, q, pt.reshape(*batch, 3), p2.reshape(*batch, 3)))


def arm_parameters(parameters: dict[str, float]) -> Floats:
    """(5,) a, h, d1, d2, d3 from the lengths d0, h, d1, d2, d3; a = sqrt(d0^2 - h^2)."""
    d0, h, d1, d2, d3 = (float(parameters[k]) for k in ("d0", "h", "d1", "d2", "d3"))
    return np.array([np.sqrt(max(d0 * d0 - h * h, 0.0)), h, d1, d2, d3])


def wrists(arm: Floats, pt: Floats, n: Floats, phi: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Wrist points (m, 3) on the gripper circle, and where phi = 0 needed a spare direction. Rows (m, 3), (m, 3), (m,
    1).
    """
    table = run(gripper_circle, (False, False, False, True), pt, n, phi, arm[4:])
    return np.ascontiguousarray(table[:, :3]), table[:, 3] > 0.5


def branches(arm: Floats, p2: Floats, pt: Floats, seed: Floats, hinge: Floats | None = None) -> Floats:
    """The raw table (m, 57) of `humanoid_branches`; all arguments are rows."""
    rows = len(pt)
    if len(seed) != rows:
        seed = np.ascontiguousarray(np.broadcast_to(seed, (rows, 5)))
    wanted = np.zeros((rows, 3)) if hinge is None else hinge
    return run(humanoid_branches, (False, False, False, False, True), p2, pt, seed, wanted, arm)


def candidates(arm: Floats, pt: Floats, n: Floats, phi: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Fast path without checks: angles (m, 8, 5) and validity (m, 8) for rows pt, n (m, 3) and phi (m, 1)."""
    p2, _ = wrists(arm, pt, n, phi)
    table = branches(arm, p2, pt, np.zeros((1, 5)))
    return table[:, :40].reshape(-1, 8, 5), np.repeat(table[:, 40:42] > -REACH_TOLERANCE, 4, axis=1)


class _Branches:
    """The raw table as named arrays on the batch."""

    def __init__(self, table: Floats, batch: tuple[int, ...], **flags: NDArray[np.bool_]) -> None:
        self.table, self.batch, self.more = table, batch, flags
        self.q = np.ascontiguousarray(table[:, :40]).reshape(*batch, 8, 5)
        self.reach = table[:, 40:42].reshape(*batch, 2)
        self.gap = table[:, 42:44].reshape(*batch, 2)
        self.valid = (self.reach > -REACH_TOLERANCE).repeat(4, axis=-1)

    @property
    def miss(self) -> Floats:
        """(..., 8) how far the forearm lies out of the plane that a wanted hinge allows."""
        return np.repeat(np.abs(self.table[:, 49:53]).reshape(*self.batch, 4), 2, axis=-1)

    def flags(self) -> dict[str, NDArray[np.bool_]]:
        straight = (self.table[:, 45:49] > 0.5).reshape(*self.batch, 4)
        return {
            "on_axis": (self.table[:, 44] > 0.5).reshape(self.batch),  # wrist on the torso axis: theta1 kept
            "stretched": np.repeat(np.abs(self.reach) < 1e-12, 4, axis=-1),  # both elbows are one
            "straight_wrist": np.repeat(straight, 2, axis=-1),  # theta4 kept
            **self.more,
        }

    def solutions(self, arm: Floats, residual: Any) -> IkSolutions:
        q, valid, gap = self.q, self.valid, self.gap
        return IkSolutions(
            q, valid, branch_table(3), lambda: residual(q), True,
            lambda: _reasons(valid, gap, arm, self.more.get("pose")), bits=BITS, flags=self.flags,
        )  # fmt: skip


def _reasons(valid: NDArray[np.bool_], gap: Floats, arm: Floats, wrong_pose: NDArray[np.bool_] | None) -> Any:
    """Why no branch is valid: a str for one target, an object array for a batch."""
    nearest, failed = gap.min(axis=-1), ~valid.any(axis=-1)
    text = np.full(failed.shape, "", dtype=object)
    span = f"the arm spans {abs(arm[2] - arm[3]):.4g} to {arm[2] + arm[3]:.4g} m from shoulder to wrist"
    for at in np.argwhere(failed):
        index = tuple(at)
        if nearest[index] > 0.0:
            text[index] = f"out of reach by {nearest[index]:.4g} m: {span}"
        elif wrong_pose is not None:
            text[index] = (
                "the position is in reach but not with this orientation: 5 joints cannot choose the gripper's roll"
            )
        else:
            text[index] = "no posture of the arm meets the target"
    return text if failed.ndim else str(text[()])


def plane_residual(arm: Floats, q: Floats, pt: Floats, p2: Floats) -> Floats:
    """(..., branches) how far forward kinematics of q misses the gripper point and the wrist, metres (larger of the
    two).
    """
    wrist, tip = wrist_and_tip(arm, q)
    off = lambda x, y: np.sqrt(((x - y[..., None, :]) ** 2).sum(axis=-1))
    return np.maximum(off(tip, pt), off(wrist, p2))


def wrist_and_tip(arm: Floats, q: Floats) -> tuple[Floats, Floats]:
    """Wrist and gripper points (..., 3) by plane trigonometry in the arm plane: independent of the inverse's geometry."""
    a, h, d1, d2, d3 = arm
    t1, t2, t4, t5 = q[..., 0], q[..., 1], q[..., 3], q[..., 4]
    t23 = t2 + q[..., 2]
    zero = np.zeros_like(t1)
    u = np.stack([np.cos(t1), zero, -np.sin(t1)], axis=-1)  # the arm plane's radial direction
    m = np.stack([np.sin(t1), zero, np.cos(t1)], axis=-1)  # its normal
    up = np.array([0.0, 1.0, 0.0])
    forearm = np.sin(t23)[..., None] * u + np.cos(t23)[..., None] * up
    wrist = a * u + h * up + d1 * (np.sin(t2)[..., None] * u + np.cos(t2)[..., None] * up) + d2 * forearm
    across = np.cos(t23)[..., None] * u - np.sin(t23)[..., None] * up  # forearm turned by -pi/2 in the plane
    side = np.cos(t4)[..., None] * across - np.sin(t4)[..., None] * m
    return wrist, wrist + d3 * (np.cos(t5)[..., None] * forearm + np.sin(t5)[..., None] * side)


def _of_pose(robot: Any, arm: Floats, rotation: Floats, origin: Floats, seed: Floats) -> IkSolutions:
    """A whole pose of the tip: the hinge of the wrist is known, so of each flip pair one row can be valid."""
    batch = batch_shape(origin, seed)
    pt, gripper, hinge, kept = broadcast_rows(batch, origin, rotation[..., :, 1], rotation[..., :, 2], seed)
    p2 = pt - arm[4] * gripper
    result = _Branches(branches(arm, p2, pt, kept, hinge), batch)
    side, miss = result.table[:, 53:57].reshape(*batch, 4), result.miss
    flip = np.stack([side > 0.0, side < 0.0], axis=-1).reshape(*batch, 8)
    possible = miss < POSE_TOLERANCE
    possible &= flip
    result.more["pose"] = np.asarray(result.valid.any(axis=-1) & ~(result.valid & possible).any(axis=-1))
    result.valid = result.valid & possible

    def residual(q: Floats) -> Floats:
        points = plane_residual(arm, q, pt.reshape(*batch, 3), p2.reshape(*batch, 3))
        return np.maximum(points, np.where(flip, miss, np.maximum(miss, np.pi)))

    return result.solutions(arm, residual)
