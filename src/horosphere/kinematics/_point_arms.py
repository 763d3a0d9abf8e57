"""A position alone, for the arms of kind us5 (NAO, Pepper): the elbow's angle on its circle and the last joint stay free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..entities import Point
from ..errors import InputError
from ..numeric import float_array
from ._arcs import Arcs
from ._classify import classify
from ._screws import axis_rotation
from ._solutions import IkSolutions, branch_table
from ._structured import _turns, psi_reference
from ._targets import common_shape

Floats = NDArray[np.float64]
BITS = ("shoulder", "wrist")
_SLACK = 1e-12  # metres beyond the reach that are taken for rounding
_POLISHED = 1e-10  # metres: what a row must reach where the structure is not exact
_SAMPLES = 32


@dataclass(frozen=True, slots=True, eq=False)
class PointArm:
    """A chain whose first five joints are of kind us5 and whose further ones leave the tool point where it is.

    arm (8, 3) as `_point_kernels.py` says; limits (2, 5) of the five; idle: how many further joints; gap: metres by which the
    structure is missed; reach: least and largest distance of the tool point from the shoulder.
    """

    arm: Floats
    limits: Floats
    idle: int
    gap: float
    reach: tuple[float, float]

    @property
    def slack(self) -> float:
        return max(_SLACK, 10.0 * self.gap)


def point_arm(robot: Any) -> PointArm | None:
    """The closed form of a robot for a position alone, or None; kept with the robot after the first call."""
    if "point arm" not in robot.memo:
        robot.memo["point arm"] = _point_arm(robot)
    return robot.memo["point arm"]


def _point_arm(robot: Any) -> PointArm | None:
    form = classify(robot).position
    if form is None:
        return None
    assert form.special is not None and form.screws is not None
    (S, E), n, tool = form.special, form.screws.axes, form.screws.home[:3, 3]
    arm = np.ascontiguousarray(np.concatenate([n[:5], [S, E - S, tool - E]]))
    r, h = float(np.linalg.norm(E - S)), float(np.linalg.norm(tool - E))
    limits = np.array([robot.limits.lower[:5], robot.limits.upper[:5]])
    return PointArm(arm, limits, len(n) - 5, form.gap, (abs(r - h), r + h))


def point_inverse(
    robot: Any,
    target: Point,
    *,
    psi: ArrayLike | None = None,
    q5: ArrayLike | None = None,
    seed: ArrayLike | None = None,
) -> IkSolutions:
    """All branches (shoulder, wrist) that bring the tool point to `target`, orientation free. Radians, metres, base frame.

    psi (...): the elbow's angle on the circle that the spheres about the shoulder and the target have in common, from the side
    of axis 1; q5 (...): the angle of joint 5. Left out, each is that of `seed` (..., n), and without a seed the value with the
    largest distance to the joint limits, for every branch its own: `.q[..., 4]`, and psi in `.free`. Joints behind the fifth,
    which only turn about the tool point, are those of the seed or the middle of their limits. A target out of reach is a value:
    `.reason` and the rows are at the nearest point in reach. Our derivation, docs/inverse-kinematics.md.
    """
    from ._point_kernels import best_point5, point5

    made = point_arm(robot)
    assert made is not None
    points, n = target_points(target), robot.n_joints
    seeds = None if seed is None else float_array(seed, "seed", last=n)
    given = [None if x is None else float_array(x, name) for x, name in ((psi, "psi"), (q5, "q5"))]
    shapes = [points.shape[:-1], () if seeds is None else seeds.shape[:-1], *(x.shape for x in given if x is not None)]
    batch = common_shape(*shapes)
    rows = lambda x, width: np.array(np.broadcast_to(x, (*batch, width)), order="C").reshape(-1, width)
    p, kept = rows(points, 3), rows(np.zeros(n) if seeds is None else seeds, n)
    count = len(p)
    values = [None if x is None else _wrapped(np.broadcast_to(x, batch)).reshape(-1) for x in given]
    if seeds is not None:
        own = psi_of(made, kept), _wrapped(kept[:, 4])
        values = [x if x is not None else y for x, y in zip(values, own)]
    at, last = values
    q, free, gap = np.empty((count, 4, 5)), np.empty((count, 4), bool), np.empty(count)
    valid, angle = np.empty((count, 4), bool), np.empty((2, count, 4))
    if at is not None and last is not None:
        point5(made.arm, made.limits, p, at, last, kept, made.slack, q, valid, np.empty_like(valid), gap, free)
        angle[0] = at[:, None]
    else:
        ranges = np.empty((count, 4))
        for k, x, ends in ((0, at, (-np.pi, np.pi)), (2, last, last_range(*made.limits[:, 4]))):
            ranges[:, k], ranges[:, k + 1] = ends if x is None else (x, x)
        best_point5(made.arm, made.limits, p, ranges, _SAMPLES, kept, made.slack, q, valid, gap, free, angle)
    q = _with_idle(robot, made, q, None if seeds is None else kept)
    if made.gap > 1e-11:
        valid &= _polished(robot, p, q) < _POLISHED
    q, valid, free = q.reshape(*batch, 4, n), valid.reshape(*batch, 4), free.reshape(*batch, 4)
    return IkSolutions(
        q, valid, branch_table(2), lambda: _miss(robot, q, points), True, lambda: _reasons(made, points, valid, gap.reshape(batch)),
        bits=BITS, flags={"angle_kept": free}, free=angle[0].reshape(*batch, 4),
    )  # fmt: skip


def target_points(target: Point) -> Floats:
    """(..., 3) of a Point; InputError where it is not finite."""
    points = np.asarray(target.as_euclidean(), dtype=np.float64)
    if not np.isfinite(points).all():
        raise InputError("the target is not finite", place="target", remedy="give a point with finite coordinates")
    return points


def last_range(lower: float, upper: float) -> tuple[float, float]:
    """The angles of joint 5 to look at: what its limits leave, moved by turns so that the middle lies in [-pi, pi]; all at most."""
    if not upper - lower < 2.0 * np.pi:
        return -np.pi, np.pi
    away = 2.0 * np.pi * np.round(0.25 * (lower + upper) / np.pi)
    return float(lower - away), float(upper - away)


def psi_of(made: PointArm, q: Floats) -> Floats:
    """(m,) elbow angles psi of postures (m, n) on the circles of their own tool points."""
    n, v, hand = made.arm[:5], made.arm[6], made.arm[7]
    R = [_turns(axis, angle) for axis, angle in zip(n, q.T)]
    e = R[0] @ R[1] @ v
    d = e + (R[0] @ R[1] @ R[2] @ R[3] @ R[4]) @ hand
    size = np.linalg.norm(d, axis=-1, keepdims=True)
    u = np.where(size > 0.0, d / np.where(size > 0.0, size, 1.0), n[0])
    r = psi_reference(n[0], u)
    return np.arctan2((e * np.cross(u, r)).sum(axis=-1), (e * r).sum(axis=-1))


def point_arcs(robot: Any, target: Point, psi: float | None = None, tolerance: float = 1e-9) -> tuple[Arcs, ...]:
    """For every branch the psi at which joints 1 and 2, or for one psi the q5 at which all joints keep their limits; one target.

    Closed form. q1 = m and q2 = m each put the elbow in a plane, which cuts its circle in at most two points. With x the tool
    point seen from link 2 and w(q5) from link 4: q4 = m is n3 . turn(n4, m) w = n3 . x, q3 = m is n4 . w = n4 . turn(n3, -m) x,
    both of first degree in q5; q4 exists between n4 . w = |x| cos(a +- b), a and b the angles of x and of n4 to n3.
    """
    made = point_arm(robot)
    assert made is not None
    p = target_points(target)
    if p.ndim != 1:
        raise InputError(f"expected one point, got a batch of shape {p.shape[:-1]}", place="target")
    axes, (S, v, hand) = made.arm[:5], made.arm[5:]
    if psi is None:
        joints, equations = (0, 1), _psi_equations(made, p - S, axes, v)
    else:
        psi = float(float_array(psi, "psi", ndim=0))
        joints, equations = range(5), _q5_equations(made, p, psi, axes, hand)
    found = [-np.pi, np.pi]
    for c0, c1, c2 in equations:
        size = float(np.hypot(c1, c2))
        if abs(c0) <= size and size > 0.0:
            middle, half = np.arctan2(c2, c1), np.arctan2(np.sqrt((size - c0) * (size + c0)), -c0)
            found += [middle - half, middle + half]
    if psi is not None:
        found += [m for m in made.limits[:, 4] if np.isfinite(m)]
    ends = np.unique(_wrapped(np.array(found)))
    ends = np.concatenate([[-np.pi], ends[ends > -np.pi]])
    middle = 0.5 * (ends[:-1] + ends[1:])
    rows = _Rows.at(
        made, p, middle if psi is None else np.full(len(middle), psi), 0.0 * middle if psi is None else middle
    )
    inside = (rows.q >= made.limits[0] - tolerance) & (rows.q <= made.limits[1] + tolerance)
    good = (rows.stands if psi is None else rows.valid) & inside[..., list(joints)].all(axis=-1)
    parameter = "psi" if psi is None else "q5"
    words = "no psi keeps joints 1 and 2" if psi is None else "no value of joint 5 keeps the joints"
    if rows.gap > made.slack:
        words = f"the point is out of reach by {rows.gap:.4g} m: nothing keeps the joints"
    return tuple(_joined(ends[:-1][k], ends[1:][k], parameter, f"{words} inside their limits") for k in good.T)


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """Branches of one point at values (m,): q (m, 4, 5), valid and the shoulder's part of it (m, 4), metres out of reach."""

    q: Floats
    valid: NDArray[np.bool_]
    stands: NDArray[np.bool_]
    gap: float

    @staticmethod
    def at(made: PointArm, p: Floats, psi: Floats, last: Floats) -> _Rows:
        from ._point_kernels import point5

        count = len(psi)
        q, flags, gap = np.empty((count, 4, 5)), np.empty((3, count, 4), bool), np.empty(count)
        points = np.array(np.broadcast_to(p, (count, 3)))
        point5(
            made.arm, made.limits, points, np.ascontiguousarray(psi), np.ascontiguousarray(last), np.zeros((count, 5)),
            made.slack, q, flags[0], flags[1], gap, flags[2],
        )  # fmt: skip
        return _Rows(q, flags[0], flags[1], float(gap[0]))


def _psi_equations(made: PointArm, d: Floats, n: Floats, v: Floats) -> list[tuple[float, float, float]]:
    """c0 + c1 cos psi + c2 sin psi = 0 where joint 1 or 2 stands at a limit or a shoulder branch ends."""
    r, h = np.linalg.norm(v), np.linalg.norm(made.arm[7])
    distance = float(np.linalg.norm(d))
    reach = min(max(distance, made.reach[0]), made.reach[1])
    u = d / distance if distance > 0.0 else n[0]
    along = (reach * reach + (r - h) * (r + h)) / (2.0 * reach) if reach > 0.0 else 0.0
    across = np.sqrt(max((r - along) * (r + along), 0.0))
    x = psi_reference(n[0], u)
    y = np.cross(u, x)
    planes = []
    for m in made.limits[:, 0]:
        if np.isfinite(m):
            planes.append((axis_rotation(n[0], m) @ n[1], v @ n[1]))
    for m in made.limits[:, 1]:
        if np.isfinite(m):
            planes.append((n[0], n[0] @ axis_rotation(n[1], m) @ v))
    flat = (v @ n[1]) * (n[0] @ n[1])
    size = np.linalg.norm(np.cross(n[0], n[1])) * np.linalg.norm(np.cross(n[1], v))
    planes += [(n[0], flat + size), (n[0], flat - size)]
    return [(float(along * (a @ u) - k), float(across * (a @ x)), float(across * (a @ y))) for a, k in planes]


def _q5_equations(made: PointArm, p: Floats, psi: float, n: Floats, hand: Floats) -> list[tuple[float, float, float]]:
    """c0 + c1 cos q5 + c2 sin q5 = 0 where joint 3 or 4 stands at a limit or a wrist branch ends, of both shoulders."""
    rows = _Rows.at(made, p, np.array([psi]), np.zeros(1))
    fixed = (n[4] @ hand) * n[4]
    turning = hand - fixed, np.cross(n[4], hand)
    equations = []
    for k in (0, 2):
        if not rows.stands[0, k]:
            continue
        # Where the tool point is, seen from E in link 2: the same for both wrists.
        q = rows.q[0, k]
        R = axis_rotation(n[0], q[0]) @ axis_rotation(n[1], q[1])
        d = p - made.arm[5]
        distance = float(np.linalg.norm(d))
        x = (
            R.T @ (d * (min(max(distance, made.reach[0]), made.reach[1]) / distance if distance > 0.0 else 0.0))
            - made.arm[6]
        )
        planes = [(axis_rotation(n[3], -m) @ n[2], n[2] @ x) for m in made.limits[:, 3] if np.isfinite(m)]
        planes += [(n[3], n[3] @ axis_rotation(n[2], -m) @ x) for m in made.limits[:, 2] if np.isfinite(m)]
        flat, size = (
            (n[2] @ x) * (n[2] @ n[3]),
            np.linalg.norm(np.cross(n[2], x)) * np.linalg.norm(np.cross(n[2], n[3])),
        )
        planes += [(n[3], flat + size), (n[3], flat - size)]
        equations += [(float(a @ fixed - k), float(a @ turning[0]), float(a @ turning[1])) for a, k in planes]
    return equations


def _wrapped(x: Floats) -> Floats:
    """Angles in (-pi, pi]; those in [-pi, pi] to their last bit."""
    return np.where(np.abs(x) <= np.pi, x, np.pi - np.mod(np.pi - x, 2.0 * np.pi))


def _with_idle(robot: Any, made: PointArm, q: Floats, seeds: Floats | None) -> Floats:
    """Rows (m, 4, 5) with the joints behind the fifth."""
    if not made.idle:
        return q
    more = np.broadcast_to(robot.limits.middle[5:], (len(q), made.idle)) if seeds is None else seeds[:, 5:]
    return np.concatenate([q, np.broadcast_to(more[:, None], (len(q), 4, made.idle))], axis=-1)


def _polished(robot: Any, p: Floats, q: Floats) -> Floats:
    """Newton steps of least size on the true axes, in place: metres left (m, 4)."""
    from ._jacobian import jacobian

    left = _miss(robot, q, p)
    for _ in range(12):
        if not (left > 1e-13).any():
            break
        J = np.asarray(jacobian(robot, q))[..., 3:, :]
        error = p[:, None] - _tips(robot, q)
        trial = q + (np.linalg.pinv(J, rcond=1e-6) @ error[..., None])[..., 0]
        rest = _miss(robot, trial, p)
        better = rest < left
        q[better], left = trial[better], np.where(better, rest, left)
    return left


def _tips(robot: Any, q: Floats) -> Floats:
    from ._forward import forward

    return forward(robot, q).as_matrix()[..., :3, 3]


def _miss(robot: Any, q: Floats, p: Floats) -> Floats:
    """(..., 4) metres from the tool point of rows (..., 4, n) to points (..., 3)."""
    return np.linalg.norm(_tips(robot, q) - p[..., None, :], axis=-1)


def _reasons(made: PointArm, points: Floats, valid: NDArray[np.bool_], gap: Floats) -> Any:
    """Why a target has no valid branch: a str, for a batch an object array."""
    batch = valid.shape[:-1]
    points, solved = np.broadcast_to(points, (*batch, 3)), valid.any(axis=-1)
    text = np.full(batch, "", dtype=object)
    for k in zip(*np.nonzero(~np.atleast_1d(solved))):
        at = k if batch else ()
        if gap[at] > made.slack:
            d = points[at] - made.arm[5]
            distance = float(np.linalg.norm(d))
            u = d / distance if distance > 0.0 else made.arm[0]
            x, y, z = made.arm[5] + min(max(distance, made.reach[0]), made.reach[1]) * u
            text[at] = (
                f"out of reach by {gap[at]:.4g} m: the tool point moves {made.reach[0]:.4g} to {made.reach[1]:.4g} m from the "
                f"shoulder; the nearest point in reach is ({x:.4g}, {y:.4g}, {z:.4g}), joint limits aside"
            )
        else:
            text[at] = "the point is in reach, but not at this psi and q5 (limit_arcs says at which)"
    return text if batch else str(text[()])


def _joined(low: Floats, high: Floats, parameter: str, words: str) -> Arcs:
    from ._redundancy import _joined as join

    found = join(low, high, parameter)
    return found if len(found.free) else Arcs(found.free, words, parameter)
