"""The part of a redundancy on which a branch keeps its joints inside the limits and its links clear, decided between samples too.

Samples of a branch are points of a curve in joint space on which the task stays fixed. Between two of them the curve is bounded
by the smallest singular value of the task's Jacobian: see `_short`. What cannot be decided above the resolution counts as not free.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..versors import Motor
from ._arcs import Arcs, _balls
from ._existence import phi_candidates, q7_candidates
from ._forward import frames
from ._jacobian import jacobian
from ._targets import GripperOnPlane, pose_motor

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
_STRETCH = 1.0 / np.cos(np.pi / 6.0)  # arc over chord inside the ball of `_short`


@dataclass(frozen=True, slots=True, eq=False)
class Redundancy:
    """The branches of one target as functions of its redundancy, and what bounds them.

    rows(values (m,)) -> q (m, branches, n), exists (m, branches). ends: sorted angles between which every branch exists or
    does not. task(q (m, n)) -> (m, k, n) Jacobian of what stays fixed, with k = n - 1, lengths in units of the reach.
    bend: a Lipschitz constant of it. parameter: "psi", "q7", "q1" or "phi".
    """

    robot: Any
    parameter: str
    branches: int
    ends: Floats
    rows: Callable[[Floats], tuple[Floats, Bools]]
    task: Callable[[Floats], Floats]
    bend: float


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

    _, span, bend = _sizes(robot)

    def task(q: Floats) -> Floats:
        J = jacobian(robot, q).copy()
        J[..., 3:, :] /= span
        return J

    return Redundancy(robot, str(made.structure.parameter), 8, ends, rows, task, bend)


def _of_humanoid(robot: Any, target: Any) -> Redundancy:
    from ._humanoid import arm_parameters, humanoid_inverse, wrists

    if not isinstance(target, GripperOnPlane) or target.point.ndim != 1 or target.normal.ndim != 1:
        raise InputError(
            "expected one GripperOnPlane target", place="target", remedy="a whole pose leaves this arm no freedom"
        )
    arm, point, normal = arm_parameters(robot.closed_form[1]), target.point, target.normal
    three = np.array([[0.0], [0.5 * np.pi], [np.pi]])
    circle, _ = wrists(arm, np.tile(point, (3, 1)), np.tile(normal, (3, 1)), three)
    _, span, bend = _sizes(robot)

    def rows(values: Floats) -> tuple[Floats, Bools]:
        found = humanoid_inverse(robot, target, phi=values)
        return found.q, found.valid

    def task(q: Floats) -> Floats:
        J = jacobian(robot, q)
        from ._humanoid import wrist_and_tip

        wrist, tip = wrist_and_tip(arm, q)
        tilt = np.cross((tip - wrist) / arm[4], normal)  # of the gripper towards the plane, by a turn about each axis
        return np.concatenate(
            [J[..., 3:, :] / span, np.einsum("...i,...ij->...j", tilt, J[..., :3, :])[..., None, :]], -2
        )

    # The row of the tilt: |d (n . (w_j x g)) / d q_i| <= 1 for all joints.
    bend = float(np.hypot(bend, robot.n_joints))
    return Redundancy(robot, "phi", 8, phi_candidates(arm, point, circle), rows, task, bend)


def free_arcs(
    robot: Any,
    target: Any,
    obstacles: Any = (),
    clearance: float = 0.0,
    *,
    limits: bool = True,
    resolution: float = 1e-3,
) -> tuple[Arcs, ...]:
    """For every branch the values of its redundancy (psi, q7, q1 or phi) at which it exists, keeps inside the joint limits and
    its links at least `clearance` metres from sphere obstacles.

    target: one pose, or one GripperOnPlane of the 5-DOF humanoid arm. obstacles: spheres, as `shapes.as_shapes` takes them.
    Where branches begin and end to exist is in closed form; the rest is sampled, and proved between the samples: parts that
    cannot be proved at `resolution` radians (of joint motion between samples, at least 1e-6) count as not free. Rows in the
    order of `inverse(...).branch`. Self-collision is not part of it. Our derivation, docs/inverse-kinematics.md.
    Raises InputError for a robot without redundancy, a batch of targets, obstacles that are not spheres.
    """
    if not resolution >= 1e-6:
        raise InputError(f"expected a resolution of at least 1e-6 radians, got {resolution}", place="resolution")
    one = redundancy(robot, target)
    values = Constraints(robot, obstacles, clearance, limits)
    middle, half = 0.5 * (one.ends[1:] + one.ends[:-1]), 0.5 * np.diff(one.ends)
    _, exists = one.rows(middle)
    interval, branch = np.nonzero(exists)
    # An interval is run through by theta in [0, pi], value = middle - half cos(theta): finite speed where branches merge.
    first = np.linspace(0.0, np.pi, 17)
    low, high = np.tile(first[:-1], len(interval)), np.tile(first[1:], len(interval))
    interval, branch = np.repeat(interval, 16), np.repeat(branch, 16)
    at = lambda theta, k: middle[k] - half[k] * np.cos(theta)
    sample = lambda theta, k, b: _Samples.of(one, values, at(theta, k), at(theta + 1e-4, k), b)
    left, right = sample(low, interval, branch), sample(high, interval, branch)
    free: list[tuple[int, float, float]] = []
    while len(low):
        chord = np.sqrt(((right.q - left.q) ** 2).sum(axis=-1))
        short = _short(one, left, right, chord)
        drift = _STRETCH * chord[:, None] * values.speed
        clear = (
            short & (left.f + right.f > drift).all(axis=-1) & (left.f > 0.0).all(axis=-1) & (right.f > 0.0).all(axis=-1)
        )
        blocked = short & ((left.f < 0.0) & (right.f < 0.0) & (left.f + right.f < -drift)).any(axis=-1)
        for k in np.flatnonzero(clear):
            free.append((int(branch[k]), float(at(low[k], interval[k])), float(at(high[k], interval[k]))))
        split = ~clear & ~blocked & ((chord > resolution) | (high - low > 0.05))
        split &= high - low > 1e-9
        theta = 0.5 * (low[split] + high[split])
        centre = sample(theta, interval[split], branch[split])
        left, right = left.take(split).joined(centre), centre.joined(right.take(split))
        low, high = np.concatenate([low[split], theta]), np.concatenate([theta, high[split]])
        interval, branch = np.tile(interval[split], 2), np.tile(branch[split], 2)
    words = "no value keeps this branch " + ("inside the joint limits" if limits else "within reach")
    if len(values.radii):
        words += f" and {clearance:g} m from the obstacles"
    return tuple(_joined([(a, b) for k, a, b in free if k == j], words) for j in range(one.branches))


def _short(one: Redundancy, left: _Samples, right: _Samples, chord: Floats) -> Bools:
    """Where the curve between two samples is their chord, but for a factor 1 / cos 30.

    With J the task's Jacobian at the left sample, s its smallest singular value and H = one.bend, two points x, y of the level
    set within s / 2H of it have |J (y - x)| <= s |y - x| / 2: the set is there the graph of one curve over the tangent, at most
    30 degrees from it. The right sample lies on that curve if it is within the ball, and the piece between them is the branch's
    if that leaves in the direction of the right sample.
    """
    ahead = (left.ahead * (right.q - left.q)).sum(axis=-1) > 0.0
    return left.exists & right.exists & ahead & (2.0 * one.bend * chord <= left.sigma)


@dataclass(frozen=True, slots=True, eq=False)
class _Samples:
    """Postures q (m, n) of one branch each, constraints f (m, c), smallest singular value, direction of travel."""

    q: Floats
    exists: Bools
    f: Floats
    sigma: Floats
    ahead: Floats

    @staticmethod
    def of(one: Redundancy, values: Constraints, value: Floats, ahead: Floats, branch: NDArray[np.int64]) -> _Samples:
        pick = np.arange(len(value))
        q, exists = one.rows(value)
        q, exists = q[pick, branch], exists[pick, branch]
        forward, _ = one.rows(ahead)
        sigma = np.asarray(np.linalg.svd(one.task(q), compute_uv=False)[..., -1], dtype=np.float64)
        return _Samples(q, exists, values(q), sigma, forward[pick, branch] - q)

    def take(self, which: Bools) -> _Samples:
        return _Samples(self.q[which], self.exists[which], self.f[which], self.sigma[which], self.ahead[which])

    def joined(self, other: _Samples) -> _Samples:
        pairs = ((getattr(self, k), getattr(other, k)) for k in ("q", "exists", "f", "sigma", "ahead"))
        return _Samples(*(np.concatenate(pair) for pair in pairs))


class Constraints:
    """Joint margins (radians) and clearances beyond the wanted one (metres) of postures, and how fast each can change."""

    def __init__(self, robot: Any, obstacles: Any, clearance: float, limits: bool) -> None:
        self.robot, self.clearance = robot, clearance
        centers, sizes = (
            _balls(obstacles) if obstacles is not None and len(obstacles) else (np.zeros((0, 3)), np.zeros(0))
        )
        self.lower = robot.limits.lower if limits else np.full(robot.n_joints, -np.inf)
        self.upper = robot.limits.upper if limits else np.full(robot.n_joints, np.inf)
        levers, _, _ = _sizes(robot)
        speed = np.sqrt((levers**2).sum(axis=-1))
        moving = np.flatnonzero(speed > 0.0) if len(sizes) else np.zeros(0, int)
        self.bodies, self.centers, self.radii = moving, centers, sizes
        self.speed = np.concatenate([np.ones(2 * robot.n_joints), np.repeat(speed[moving], len(sizes))])

    def __call__(self, q: Floats) -> Floats:
        parts = [np.minimum(q - self.lower, 1e9), np.minimum(self.upper - q, 1e9)]
        if len(self.bodies):
            parts.append(self.clearances(q) - self.clearance)
        return np.concatenate(parts, axis=-1)

    def clearances(self, q: Floats) -> Floats:
        """(m, bodies x obstacles) metres from each moving body to each obstacle."""
        capsules, robot = self.robot.capsules, self.robot
        link = capsules.link[self.bodies]
        M = Motor._wrap(np.ascontiguousarray(frames(robot, q).array[:, link]))
        T = M.as_matrix()
        a = np.einsum("...ij,...j->...i", T[..., :3, :3], capsules.a[self.bodies]) + T[..., :3, 3]
        side = np.einsum("...ij,...j->...i", T[..., :3, :3], (capsules.b - capsules.a)[self.bodies])
        away = self.centers - a[..., None, :]
        size = np.maximum((side**2).sum(axis=-1), 1e-300)[..., None]
        t = np.clip(np.einsum("...oj,...j->...o", away, side) / size, 0.0, 1.0)
        gap = np.sqrt(((away - t[..., None] * side[..., None, :]) ** 2).sum(axis=-1))
        return (gap - self.radii - capsules.radius[self.bodies][:, None]).reshape(
            len(q), len(self.bodies) * len(self.radii)
        )


def _sizes(robot: Any) -> tuple[Floats, float, float]:
    """Levers (capsules, n): the farthest a point of a capsule can be from each joint that moves it, metres, 0 for the others;
    the reach; and a Lipschitz constant of the Jacobian with lengths in units of the reach.
    """
    known = robot.memo.get("arc sizes")
    if known is not None:
        return known
    n, count = robot.n_joints, len(robot.links)
    far = np.zeros((count + 1, n))  # from each joint to the frame of each link; the last row to the tool point
    moved = np.zeros((count + 1, n), bool)
    for i, link in enumerate(robot.links):
        step = 2.0 * float(np.linalg.norm(link.origin[4:])) if link.parent >= 0 else 0.0
        if link.parent >= 0:
            far[i], moved[i] = far[link.parent] + step * moved[link.parent], moved[link.parent]
        if link.kind == "revolute":
            moved[i, link.coordinate] = True
    far[count], moved[count] = (
        far[robot.tip] + 2.0 * float(np.linalg.norm(robot.tool[4:])) * moved[robot.tip],
        moved[robot.tip],
    )
    capsules = robot.capsules
    size = np.maximum(np.linalg.norm(capsules.a, axis=-1), np.linalg.norm(capsules.b, axis=-1))
    levers = np.where(moved[capsules.link], far[capsules.link] + size[:, None], 0.0)
    r = far[count]
    span = max(float(r.max(initial=0.0)), 1e-9)
    i, j = np.indices((n, n))
    # |d w_j / d q_i| <= 1 for i < j, and |d v_j / d q_i| <= the lever of the joint farther out.
    bend = float(np.sqrt((i < j).sum() + (np.minimum(r[i], r[j]) ** 2).sum() / span**2))
    robot.memo["arc sizes"] = levers, span, bend
    return robot.memo["arc sizes"]


def _joined(parts: list[tuple[float, float]], words: str) -> Arcs:
    arcs: list[list[float]] = []
    for a, b in sorted(parts):
        if arcs and a <= arcs[-1][1] + 1e-12:
            arcs[-1][1] = max(arcs[-1][1], b)
        else:
            arcs.append([a, b])
    return Arcs(np.array(arcs, float).reshape(-1, 2), "" if arcs else words)
