"""Where a redundant arm may go: the values of its redundancy at which a branch exists and keeps inside the joint
limits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..entities import Point
from ..errors import InputError
from ._arcs import Arcs
from ._classify import classify
from ._structured import Solver, solver
from ._targets import pose_motor

Floats = NDArray[np.float64]
_NEARLY = 1e-8  # metres by which a structure may be missed: so good are the closed forms of its limits


def limit_arcs(robot: Any, target: Any, tolerance: float = 1e-9, *, psi: float | None = None) -> tuple[Arcs, ...]:
    """For every branch the values of psi (or q7, q1) at which it meets the pose inside the joint limits.

    One pose, closed form. S-R-S arms: every joint limit cuts the elbow circle in a plane, so a limit of a joint is at most two
    psi. sew7: a joint at a limit is a trigonometric polynomial in the last angle, of degree 1 (joint 4), 2 (joints 5, 6) or 8
    (joints 1, 2, 3); the ends are then halved to rounding. Where the structure is missed by more than 1e-8 m: `free_arcs`
    without obstacles, with limits proved between samples to 1e-4 rad. Rows in the order of `inverse(...).branch`. Our
    derivation, docs/inverse-kinematics.md.
    A Point of an arm of kind us5 has two freedoms, both in closed form: without `psi` the psi at which joints 1 and 2 keep
    their limits; with it the values of q5 at which all joints do.
    Raises InputError for a robot without redundancy and for a batch of poses.
    """
    if isinstance(target, Point) and classify(robot).position is not None:
        from ._point_arms import point_arcs

        return point_arcs(robot, target, psi, tolerance)
    if psi is not None:
        raise InputError("psi is given for a Point of an arm of kind us5 only", place="psi", remedy="leave it out")
    made = solver(robot)
    structure = made.structure
    if structure.name not in ("srs7", "sew7"):
        raise InputError(
            f"the inverse kinematics of {robot.name!r} ({structure.name}) has no redundancy in an angle",
            place="robot", remedy="limit_arcs is for 7-joint arms of the kinds srs7 and sew7",
        )  # fmt: skip
    motor = pose_motor(target)
    if motor.ndim != 1:
        raise InputError(f"expected one pose, got a batch of shape {motor.shape[:-1]}", place="target")
    if structure.name == "sew7" and structure.gap > _NEARLY:
        from ._free_arcs import free_arcs

        return free_arcs(robot, target, resolution=1e-4)
    if structure.name == "srs7":
        ends = _psi_candidates(made, motor)
    else:
        from ._q7_limits import q7_limit_candidates

        ends = q7_limit_candidates(made, motor)
    middles = 0.5 * (ends[:-1] + ends[1:])
    free = _allowed(made, motor, middles, tolerance)
    parameter = str(structure.parameter)
    if structure.name == "srs7":
        return tuple(_joined(ends[:-1][column], ends[1:][column], parameter) for column in free.T)
    exact = _halved(made, motor, middles, free, tolerance)
    return tuple(_joined(low, high, parameter) for low, high in exact)


def _halved(made: Solver, motor: Floats, middles: Floats, free: NDArray[np.bool_], tolerance: float):
    """For every branch the lows and highs of its free cells: candidates where both sides agree do not matter, and the other
    ends are halved between the middles of their cells."""
    strict = _allowed(made, motor, middles, 0.0)
    cell, branch = np.nonzero(free[1:] != free[:-1])
    rising = free[cell + 1, branch]
    inside, outside = (
        np.where(rising, middles[cell + 1], middles[cell]),
        np.where(rising, middles[cell], middles[cell + 1]),
    )
    spare = np.where(strict[cell + rising, branch], 0.0, tolerance)
    pick = np.arange(len(cell))
    for _ in range(60 if len(cell) else 0):
        middle = 0.5 * (inside + outside)
        good = _allowed(made, motor, middle, spare[:, None, None])[pick, branch]
        inside, outside = np.where(good, middle, inside), np.where(good, outside, middle)
    for k in range(made.branches):
        mine = branch == k
        low, high = inside[mine & rising], inside[mine & ~rising]
        yield (
            np.concatenate([[-np.pi], low]) if free[0, k] else low,
            np.concatenate([high, [np.pi]]) if free[-1, k] else high,
        )


def _allowed(made: Solver, motor: Floats, values: Floats, tolerance: Any) -> NDArray[np.bool_]:
    """(k, branches) the branch exists at each value and is inside the limits."""
    count = len(values)
    poses = np.array(np.broadcast_to(motor, (count, 8)))
    poses.setflags(write=False)
    q, valid, _, _, _ = made.rows(poses, np.ascontiguousarray(values), np.zeros((count, made.joints)))
    lower, upper = made.limits[0] - tolerance, made.limits[1] + tolerance
    return valid & ((q >= lower) & (q <= upper)).all(axis=-1)


def _joined(low: Floats, high: Floats, parameter: str) -> Arcs:
    """Neighbouring intervals made one."""
    arcs: list[list[float]] = []
    for a, b in zip(low, high):
        if arcs and arcs[-1][1] == a:
            arcs[-1][1] = b
        else:
            arcs.append([a, b])
    words = "" if arcs else "no value keeps this branch inside the joint limits"
    return Arcs(np.array(arcs, float).reshape(-1, 2), words, parameter)


def _psi_candidates(made: Solver, motor: Floats) -> Floats:
    """Sorted psi in [-pi, pi], ends included, between which no joint of any branch crosses a limit.

    The rotation of the upper arm is R(psi) = A + B cos psi + C sin psi; a joint at its limit m is an equation a.R b =
    k.
    """
    from ._screw_kernels import elbow_root, load_pose

    chain, special = made.structure.screws, made.structure.special
    assert chain is not None and special is not None
    n, (S, W, E) = chain.axes, special
    R, t = load_pose(motor[None].copy(), 0, made.arm, 7)
    R, w = np.array(R).reshape(3, 3), np.array(R).reshape(3, 3) @ W + np.array(t) - S
    found = [-np.pi, np.pi]
    for sign in (1.0, -1.0):
        sine, cosine, good = elbow_root(
            tuple(chain.points[3]), tuple(n[3]), tuple(W), tuple(S), float(w @ w), sign, 0.0
        )
        if good < 0.0:
            break
        R4 = _turn(n[3], sine, cosine)
        w0 = chain.points[3] + R4 @ (W - chain.points[3]) - S
        u, side = w / np.linalg.norm(w), E - S
        if np.linalg.norm(np.cross(w0, side)) < 1e-10 * np.linalg.norm(w0) * np.linalg.norm(side):
            side = np.cross(n[3], w0)
        from ._structured import psi_reference

        r = psi_reference(n[0], u)
        start = np.stack([u, r, np.cross(u, r)], axis=1) @ _frame(w0, side).T
        K = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
        A, C = np.outer(u, u) @ start, K @ start
        B = start - A
        equations = []
        for j in range(7):
            for m in (made.limits[0, j], made.limits[1, j]):
                if j != 3 and np.isfinite(m):
                    equations.append(_limit_equation(n, R, R4, j, m))
        # Where a branch of three axes that are not at right angles begins and ends to exist.
        for j, (first, second, third) in ((1, n[0:3]), (5, n[4:7])):
            alpha, gamma = first @ second, second @ third
            a, b, _ = _limit_equation(n, R, R4, j, 0.0)
            size = np.sqrt(max((1.0 - alpha**2) * (1.0 - gamma**2), 0.0))
            equations += [(a, b, float(alpha * gamma + size)), (a, b, float(alpha * gamma - size))]
        for a, b, k in equations:
            c0, c1, c2 = a @ A @ b - k, a @ B @ b, a @ C @ b
            h = np.hypot(c1, c2)
            if abs(c0) <= h and h > 0.0:
                middle, half = np.arctan2(c2, c1), np.arctan2(np.sqrt((h - c0) * (h + c0)), -c0)
                found += [middle - half, middle + half]
    psi = np.array(found)
    return np.unique(np.where((psi >= -np.pi) & (psi <= np.pi), psi, np.pi - np.mod(np.pi - psi, 2.0 * np.pi)))


def _limit_equation(n: Floats, R: Floats, R4: Floats, j: int, m: float) -> tuple[Floats, Floats, float]:
    """a, b, k with a . R3 b = k where joint j (0..2 shoulder, 4..6 wrist) stands at m; R the wanted rotation."""
    first, second, third = n[0:3] if j < 3 else n[4:7]
    part = j if j < 3 else j - 4
    if part == 0:
        x, y, k = _rotate(first, m, second), third, second @ third
    elif part == 1:
        x, y, k = first, third, first @ _rotate(second, m, third)
    else:
        x, y, k = first, _rotate(third, -m, second), first @ second
    # Shoulder: x . R3 y = k. Wrist: x . (R3 R4)^T R y = k, so (R y) . R3 (R4 x) = k.
    return (x, y, float(k)) if j < 3 else (R @ y, R4 @ x, float(k))


def _turn(axis: Floats, sine: float, cosine: float) -> Floats:
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + sine * K + (1.0 - cosine) * (K @ K)


def _rotate(axis: Floats, angle: float, x: Floats) -> Floats:
    return _turn(axis, float(np.sin(angle)), float(np.cos(angle))) @ x


def _frame(a: Floats, b: Floats) -> Floats:
    x = a / np.linalg.norm(a)
    z = np.cross(x, b)
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=1)
