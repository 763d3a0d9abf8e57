"""Inverse kinematics of the S-R-S arm and of the six-axis arm: targets in, branches out (geometry:
`_wrist_geometry.py`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..numeric import float_array
from ._solutions import IkSolutions, branch_table
from ._targets import angle_column, batch_shape, broadcast_rows, pose_motor, run, run_one
from ._wrist_geometry import six_axis_branches, srs_branches

Floats = NDArray[np.float64]

SRS_BITS = ("theta2<0", "theta4<0", "theta6<0")
SIX_BITS = ("back", "elbow", "flip")
REACH_TOLERANCE = 1e-13  # of the squared half distance of the elbow pair, over the arm's length squared
_ARM_KEYS = {"srs_arm": ("dbs", "dse", "dew", "dwf"), "six_axis_arm": ("a1", "d1", "a2", "a3", "d4", "d6")}


def arm_lengths(robot: Any) -> Floats:
    """The lengths of a built-in arm, in the order of its constructor."""
    known = robot.memo.get("arm lengths")
    if known is None:
        name, parameters = robot.closed_form
        known = robot.memo["arm lengths"] = np.array([float(parameters[key]) for key in _ARM_KEYS[name]])
    return known


def srs_inverse(robot: Any, target: Any, *, psi: ArrayLike | None = None, seed: ArrayLike | None = None) -> IkSolutions:
    """The 8 branches (theta2 < 0, theta4 < 0, theta6 < 0) of the S-R-S arm for a pose of its tip. Radians, metres.

    psi: (...) elbow angle; default that of the seed, else for every branch its own, the value that keeps the joints farthest from
    their limits (then flags are by branch). The elbow is E = S + x u + rho (cos psi r + sin psi u x
    r) with u = unit(W - S), r = unit(z - (z.u) u), or from x where u is parallel to z (flag "reference"). Batch axes
    broadcast. Our derivation.
    """
    if psi is None and seed is None and np.isfinite([robot.limits.lower, robot.limits.upper]).any():
        return _srs_roomiest(robot, target)
    arm = arm_lengths(robot)
    motor = pose_motor(target)
    seeds = np.zeros(7) if seed is None else float_array(seed, "seed", last=7)
    if psi is not None:
        angle = angle_column(psi, "psi")
    else:
        angle = np.zeros(1) if seed is None else elbow_angle(arm, seeds)[..., None]
    batch = batch_shape(motor, angle, seeds)
    single = (False, False, False, True)
    if batch == ():
        table = run_one(srs_branches, single, motor, angle, seeds, arm)
    else:
        table = run(srs_branches, single, *broadcast_rows(batch, motor, angle, seeds), arm)
    q = np.ascontiguousarray(table[:, :56]).reshape(*batch, 8, 7)
    reach, gap = table[:, 56].reshape(batch), table[:, 57].reshape(batch)
    valid = np.empty((*batch, 8), bool)
    valid[...] = (reach > -REACH_TOLERANCE)[..., None]

    def flags() -> dict[str, NDArray[np.bool_]]:
        names = ("reference", "theta1_free", "theta3_free", "theta5_free")
        free = {name: (table[:, 58 + k] > 0.5).reshape(batch) for k, name in enumerate(names)}
        return {**free, "stretched": np.abs(reach) < 1e-12}

    def reason() -> Any:
        span = f"the arm spans {abs(arm[1] - arm[2]):.4g} to {arm[1] + arm[2]:.4g} m from shoulder to wrist"
        return reach_reasons(valid, gap, span)

    free = float(angle[0]) if batch == () else np.broadcast_to(angle, (*batch, 8))
    residual = lambda: pose_residual(robot, q, motor)
    return IkSolutions(q, valid, branch_table(3), residual, True, reason, bits=SRS_BITS, flags=flags, free=free)


def _srs_roomiest(robot: Any, target: Any) -> IkSolutions:
    """`srs_inverse` with psi chosen branch by branch: row k of the rows at the psi of branch k."""
    from ..versors import Motor
    from ._structured import roomiest_rows

    motor = pose_motor(target)
    q, valid, psi = roomiest_rows(robot, motor)
    every = lambda: srs_inverse(robot, Motor._wrap(motor[..., None, :]), psi=psi)
    return IkSolutions(
        q, valid, branch_table(3), lambda: pose_residual(robot, q, motor), True, lambda: _first(every().reason), bits=SRS_BITS,
        flags=lambda: every().flags, free=psi,
    )  # fmt: skip


def _first(reasons: NDArray[Any]) -> Any:
    """Of the reasons of every branch, which all say the same, the first."""
    return reasons[..., 0] if reasons.ndim > 1 else str(reasons[0])


def six_axis_inverse(robot: Any, target: Any, *, seed: ArrayLike | None = None) -> IkSolutions:
    """The 8 branches (back, elbow, flip) of the six-axis arm for a pose of its tip. Radians, metres.

    back: the arm plane turned by pi; elbow: the second elbow; flip: theta5 < 0. Batch axes broadcast. Our derivation.
    """
    arm = arm_lengths(robot)
    motor = pose_motor(target)
    seeds = np.zeros(6) if seed is None else float_array(seed, "seed", last=6)
    batch = batch_shape(motor, seeds)
    if batch == ():
        table = run_one(six_axis_branches, (False, False, True), motor, seeds, arm)
    else:
        table = run(six_axis_branches, (False, False, True), *broadcast_rows(batch, motor, seeds), arm)
    q = np.ascontiguousarray(table[:, :48]).reshape(*batch, 8, 6)
    reach, gap = table[:, 48:50].reshape(*batch, 2), table[:, 50:52].reshape(*batch, 2)
    valid = (reach > -REACH_TOLERANCE).repeat(4, axis=-1)

    def flags() -> dict[str, NDArray[np.bool_]]:
        return {
            "on_axis": (table[:, 52] > 0.5).reshape(batch),
            "straight_wrist": np.repeat((table[:, 53:57] > 0.5).reshape(*batch, 4), 2, axis=-1),
            "stretched": np.repeat(np.abs(reach) < 1e-12, 4, axis=-1),
        }

    def reason() -> Any:
        forearm = float(np.hypot(arm[3], arm[4]))
        span = f"the arm spans {abs(arm[2] - forearm):.4g} to {arm[2] + forearm:.4g} m from shoulder to wrist"
        return reach_reasons(valid, gap.min(axis=-1), span)

    residual = lambda: pose_residual(robot, q, motor)
    return IkSolutions(q, valid, branch_table(3), residual, True, reason, bits=SIX_BITS, flags=flags)


def elbow_angle(arm: Floats, q: Floats) -> Floats:
    """(...) the elbow angle psi of postures q (..., 7) of an S-R-S arm with lengths dbs, dse, dew, dwf."""
    dse, dew = arm[1], arm[2]
    c1, s1, c2, s2, c3, s3 = (f(q[..., k]) for k in range(3) for f in (np.cos, np.sin))
    upper = np.stack([c1 * s2, s1 * s2, c2], axis=-1)
    x2 = np.stack([c1 * c2, s1 * c2, -s2], axis=-1)
    y2 = np.stack([-s1, c1, np.zeros_like(c1)], axis=-1)
    ahead = c3[..., None] * x2 + s3[..., None] * y2  # x axis after joint 3
    # Joint 4 turns about -y: z goes to -x.
    fore = np.cos(q[..., 3])[..., None] * upper - np.sin(q[..., 3])[..., None] * ahead
    span = dse * upper + dew * fore
    u = span / np.maximum(np.sqrt((span * span).sum(axis=-1, keepdims=True)), 1e-300)
    r = _reference(u)
    return np.arctan2((upper * np.cross(u, r)).sum(axis=-1), (upper * r).sum(axis=-1))


def _reference(u: Floats) -> Floats:
    """The unit direction of psi = 0, perpendicular to unit vectors u (..., 3): from z, or from x where u is parallel
    to z.
    """
    z, x = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    parallel = np.sqrt(u[..., 0] ** 2 + u[..., 1] ** 2) < 1e-9
    axis = np.where(parallel[..., None], x, z)
    r = axis - (axis * u).sum(axis=-1, keepdims=True) * u
    return r / np.sqrt((r * r).sum(axis=-1, keepdims=True))


def reach_reasons(
    valid: NDArray[np.bool_], gap: Floats, span: str, otherwise: str = "no posture meets the pose"
) -> Any:
    """Why no branch is valid, with the metres missing: a str for one target, an object array for a batch."""
    failed = ~valid.any(axis=-1)
    text = np.full(failed.shape, "", dtype=object)
    for at in np.argwhere(failed):
        index = tuple(at)
        text[index] = f"out of reach by {gap[index]:.4g} m: {span}" if gap[index] > 0.0 else otherwise
    return text if failed.ndim else str(text[()])


def pose_residual(robot: Any, q: Floats, motor: Floats) -> Floats:
    """(..., branches) larger of position error (m) and rotation error (rad) of forward(robot, q) against target
    motors (..., 8).
    """
    from ..versors import Motor
    from ._forward import forward

    wanted = Motor(np.broadcast_to(motor[..., None, :], (*q.shape[:-1], 8))).as_matrix()
    reached = forward(robot, q).as_matrix()
    return matrix_error(reached, wanted)


def matrix_error(reached: Floats, wanted: Floats) -> Floats:
    """(...) larger of the distance of the origins (m) and the angle between the axes (rad) of (..., 4, 4) poses."""
    offset = reached[..., :3, 3] - wanted[..., :3, 3]
    position = np.sqrt((offset * offset).sum(axis=-1))
    change = np.swapaxes(wanted[..., :3, :3], -1, -2) @ reached[..., :3, :3]
    x, y, z = ((2, 1), (0, 2), (1, 0))
    skew = np.stack([change[..., i, j] - change[..., j, i] for i, j in (x, y, z)], axis=-1)
    angle = np.arctan2(np.sqrt((skew * skew).sum(axis=-1)), np.trace(change, axis1=-2, axis2=-1) - 1.0)
    return np.maximum(position, angle)
