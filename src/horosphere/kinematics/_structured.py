"""Closed-form inverse kinematics of a classified chain: poses in, all branches out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array
from ..robots._robot import require_robot
from ._classify import Structure, chain_structure, classify
from ._solutions import IkSolutions, branch_table
from ._targets import common_shape, pose_motor
from ._wrist_arms import pose_residual, reach_reasons

Floats = NDArray[np.float64]
_EXACT = 1e-11  # metres: structures missed by more are polished on the true axes
_NARROW = 1e-6  # radians of the redundancy, to which ends of existence are looked for: nearer to singular ones rows lose digits
_POLISHED = 1e-10  # residual (m, rad) that a polished row must reach
_STEPS = 40  # of Newton, at most: from double roots it converges only by halves
_SPARE = (
    100.0  # radians a metre of the gap by which rows of a nearly exact structure may be off before they are polished
)
_SOFT = 60.0  # 1/m, the most that such roots may miss, relative to the gap, where its best value is looked for
_WORDS = {
    "sew7": "the distance from the shoulder to the wrist is out of range for this q7",
    "srs7": "the distance from the shoulder to the wrist is out of range",
    "us5": "5 joints reach a 5-dimensional set of poses, and this one moves the elbow off its sphere",
    "spherical6": "the first three joints cannot bring the wrist there",
    "parallel6": "the parallel joints cannot bring the wrist there",
}


@dataclass(frozen=True, slots=True, eq=False)
class Solver:
    """What the compiled loops of one robot take: made once, kept with the robot."""

    structure: Structure
    arm: Floats
    true_arm: Floats
    limits: Floats
    ranges: Floats  # (2, n) middle of the limits and half their width; 0 and inf without
    table: NDArray[np.int64]
    joints: int
    branches: int
    kind: int | None
    loop: Any
    rest: Floats  # (1, n) zeros: no seed

    def rows(self, motors: Floats, value: Floats | None, seeds: Floats):
        """q (m, branches, n), valid, gap (m,), free, residual or None; motors C-contiguous and read-only, the others writable."""
        count = len(motors)
        q = np.empty((count, self.branches, self.joints))
        valid, free = np.empty((count, self.branches), bool), np.empty((count, self.branches), bool)
        gap = np.empty(count)
        if value is None:
            self.loop(self.arm, self.limits, motors, seeds, q, valid, gap, free)
        else:
            self.loop(self.kind, self.arm, self.limits, motors, value, seeds, q, valid, gap, free)
        return q, valid, gap, free, self.polished(motors, q, valid)

    def polished(self, motors: Floats, q: Floats, valid: NDArray[np.bool_]) -> Floats | None:
        """Newton steps on the true axes where the structure is not exact: residual (m, branches), else None."""
        gap = self.structure.gap
        if gap <= _EXACT:
            return None
        from ._polish_kernels import polish

        residual = np.full(valid.shape, np.inf)
        locked = {"q7": 6, "q1": 0}.get(self.structure.parameter or "", -1)
        polish(self.true_arm, self.limits, motors, q, valid, locked, _STEPS, residual)
        valid &= residual < _POLISHED
        return residual


def solver(robot: Any) -> Solver:
    """The compiled solver of a robot that `classify` found a structure for."""
    known = require_robot(robot).memo.get("ik solver")
    if known is not None:
        return known
    from . import _seven_kernels, _six_kernels

    structure = classify(robot)
    if structure.screws is None:  # a built-in arm, asked for by its axes
        structure = chain_structure(robot)
    chain, special = structure.screws, structure.special
    assert chain is not None and special is not None
    n = len(chain.axes)
    number = float(structure.mode) if structure.name == "spherical6" else max(1e-9, 10.0 * structure.gap)
    soft = min(2000.0 * structure.gap, 0.05) if structure.gap > _EXACT else 0.0
    home = np.linalg.inv(np.linalg.inv(chain.home) if structure.is_reversed else chain.home)
    tail = [home[:3, :3], home[None, :3, 3], [[float(structure.is_reversed), number, soft]]]
    arm = np.concatenate([chain.axes, chain.points, *tail, special])
    true = chain.reversed() if structure.is_reversed else chain
    true_arm = np.concatenate([true.axes, true.points, *tail[:2], [[0.0, 0.0, 0.0]]])
    lower, upper = robot.limits.lower, robot.limits.upper
    bounded = np.isfinite(lower) & np.isfinite(upper)
    ends = np.where(bounded, [lower, upper], 0.0)
    ranges = np.array([0.5 * (ends[0] + ends[1]), np.where(bounded, 0.5 * (ends[1] - ends[0]), np.inf)])
    made = Solver(
        structure, np.ascontiguousarray(arm), np.ascontiguousarray(true_arm), np.array([lower, upper]), ranges,
        branch_table(len(structure.bits)), n, structure.branches,
        _seven_kernels.SRS7 if structure.name == "srs7" else _seven_kernels.SEW7,
        _seven_kernels.seven if n == 7 else getattr(_six_kernels, structure.name),
        np.zeros((1, n)),
    )  # fmt: skip
    robot.memo["ik solver"] = made
    return made


def structured_inverse(
    robot: Any, target: Any, *, parameter: ArrayLike | None = None, seed: ArrayLike | None = None
) -> IkSolutions:
    """All branches of a classified chain for a pose of its tip. Radians, metres, base frame.

    parameter: (...) value of the redundancy (q7, q1 or psi); default: that of `seed` (..., n), and without a seed the
    value with the largest distance to the joint limits, for every branch its own (in `.free`); 0 for a robot without limits.
    """
    made = robot.memo.get("ik solver") or solver(robot)
    structure, n = made.structure, made.joints
    motor = pose_motor(target)
    if motor.ndim == 1 and seed is None:  # one pose, the quick way
        if structure.parameter is None:
            return _package(robot, made, (), motor, *made.rows(motor.reshape(1, 8), None, made.rest))
        if type(parameter) is float and math.isfinite(parameter):
            value = np.empty(1)
            value[0] = parameter
            return _package(robot, made, (), motor, *made.rows(motor.reshape(1, 8), value, made.rest), shown=parameter)
    seeds = np.zeros(n) if seed is None else float_array(seed, "seed", last=n)
    redundant = structure.parameter is not None
    given = None if parameter is None else float_array(parameter, str(structure.parameter))
    batch = motor.shape[:-1]
    if seeds.ndim > 1 or (given is not None and given.ndim):
        batch = common_shape(batch, seeds.shape[:-1], () if given is None else given.shape)
    motors, kept = _rows(motor, batch, 8), _rows(seeds, batch, n)
    motors.setflags(write=False)  # as a Motor's own array: one compilation serves both
    value = None
    if redundant and given is not None:
        value = np.array(np.broadcast_to(given, batch)).reshape(-1)
    elif redundant and seed is not None:
        value = psi_of(made, kept) if structure.name == "srs7" else kept[:, 0 if structure.is_reversed else 6].copy()
    if redundant and value is None and not np.isfinite(made.limits).any():
        value = np.zeros(len(motors))
    if redundant and value is None:
        q, valid, gap, free, residual, values = _best(made, motors, kept)
        shown = values.reshape(*batch, made.branches)
    else:
        q, valid, gap, free, residual = made.rows(motors, value, kept)
        shown = None if value is None else np.broadcast_to(value.reshape(*batch, 1), (*batch, made.branches))
    return _package(robot, made, batch, motor, q, valid, gap, free, residual, shown)


def _package(robot, made: Solver, batch, motor, q, valid, gap, free, residual, shown=None) -> IkSolutions:
    """The rows of the compiled loop as a result on the batch."""
    if batch == ():
        q, valid, free = q[0], valid[0], free[0]
    else:
        shape = (*batch, made.branches)
        q, valid, free = q.reshape(*shape, made.joints), valid.reshape(shape), free.reshape(shape)

    def error() -> Floats:
        return pose_residual(robot, q, motor) if residual is None else residual.reshape(valid.shape)

    def reason() -> Any:
        return reach_reasons(
            valid, gap.reshape(batch), _WORDS[made.structure.name], "the wrist cannot take this orientation"
        )

    return IkSolutions(
        q, valid, made.table, error, True, reason, bits=made.structure.bits, flags={"angle_kept": free}, free=shown
    )


def _rows(array: Floats, batch: tuple[int, ...], width: int) -> Floats:
    """(m, width) writable contiguous rows on the whole batch."""
    if array.shape == (width,) and batch == ():
        return array.copy().reshape(1, width)
    return np.array(np.broadcast_to(array, (*batch, width)), order="C").reshape(-1, width)


def _best(made: Solver, motors: Floats, seeds: Floats):
    """As `Solver.rows`, at the redundancy that keeps the joints farthest from their limits, and that, (m, branches)."""
    from ._best_kernels import best

    low, high, locked = -np.pi, np.pi, -1
    if made.structure.name == "sew7":
        locked = 0 if made.structure.is_reversed else 6
        ends = made.limits[:, locked]
        if ends[1] - ends[0] < 2.0 * np.pi:
            low, high = ends
    gap, shape = made.structure.gap, (len(motors), 8)
    q, value, residual = np.empty((*shape, 7)), np.empty(shape), np.empty(shape)
    valid, free, missing = np.empty(shape, bool), np.empty(shape, bool), np.empty(len(motors))
    spare, arms, true_arm = 0.0, made.arm[None], None
    if gap > _EXACT:
        spare, true_arm = _SPARE * gap, made.true_arm
        arms = np.stack([made.arm, made.arm])
        arms[:, 2 * made.joints + 4, 2] = 0.0, min(_SOFT * gap, made.arm[2 * made.joints + 4, 2])
    best(
        made.kind, arms, true_arm, made.limits, made.ranges, float(low), float(high), locked, spare, max(_NARROW, 0.1 * gap),
        _POLISHED, _STEPS, motors, seeds, value, q, valid, missing, free, residual,
    )  # fmt: skip
    return q, valid, missing, free, residual if spare > 0.0 else None, value


def roomiest_rows(robot: Any, motor: Floats) -> tuple[Floats, NDArray[np.bool_], Floats]:
    """Of every branch the row (..., branches, n) that keeps the joints farthest from their limits, whether it is valid, and its
    redundancy, for poses (..., 8).
    """
    made, batch = solver(robot), motor.shape[:-1]
    motors = np.ascontiguousarray(motor.reshape(-1, 8))
    motors.setflags(write=False)
    q, valid, *_, value = _best(made, motors, np.zeros((len(motors), made.joints)))
    shape = (*batch, made.branches)
    return q.reshape(*shape, made.joints), valid.reshape(shape), value.reshape(shape)


def psi_of(made: Solver, q: Floats) -> Floats:
    """(m,) elbow angle psi of postures (m, 7) of an srs7 chain."""
    chain, special = made.structure.screws, made.structure.special
    assert chain is not None and special is not None
    S, W, E = special
    R = np.broadcast_to(np.eye(3), (len(q), 3, 3))
    for axis, angle in zip(chain.axes[:3], q.T):
        R = R @ _turns(axis, angle)
    elbow, axis4 = R @ (E - S), R @ chain.axes[3]
    p4 = chain.points[3]
    w = (R @ (p4 - S)[:, None] + R @ _turns(chain.axes[3], q[:, 3]) @ (W - p4)[:, None])[..., 0]
    u = w / np.linalg.norm(w, axis=-1, keepdims=True)
    flat = np.linalg.norm(np.cross(elbow, u), axis=-1, keepdims=True) < 1e-10
    lever = np.where(flat, np.cross(axis4, w), elbow)
    r = psi_reference(chain.axes[0], u)
    return np.arctan2((lever * np.cross(u, r)).sum(axis=-1), (lever * r).sum(axis=-1))


def _turns(axis: Floats, angle: Floats) -> Floats:
    """(m, 3, 3) turns about a unit axis."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle)[:, None, None] * K + (1.0 - np.cos(angle))[:, None, None] * (K @ K)


def psi_reference(axis1: Floats, u: Floats) -> Floats:
    """The unit direction of psi = 0 across unit vectors u (..., 3): the side of axis 1, or of its fixed normal if
    parallel.
    """
    spare = np.cross(axis1, [1.0, 0.0, 0.0] if abs(axis1[0]) < 0.7 else [0.0, 1.0, 0.0])
    spare /= np.linalg.norm(spare)
    parallel = (np.cross(axis1, u) ** 2).sum(axis=-1, keepdims=True) < 1e-18
    side = np.cross(np.where(parallel, spare, axis1), u)
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    return np.asarray(np.cross(u, side), dtype=np.float64)


def parameter_value(structure: Structure, given: dict[str, Any], robot_name: str) -> Any:
    """The one redundancy parameter that was given, or None; InputError for one that the structure does not have."""
    value = None
    for name, candidate in given.items():
        if candidate is None:
            continue
        if name != structure.parameter:
            raise InputError(
                f"the inverse kinematics of {robot_name!r} ({structure.name}) has no {name!r}", place=name,
                choices=("seed",) + ((structure.parameter,) if structure.parameter else ()),
            )  # fmt: skip
        value = candidate
    return value
