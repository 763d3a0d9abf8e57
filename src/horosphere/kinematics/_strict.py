"""The strict reading of the 5-DOF humanoid arm: the whole gripper parallel to the plane, so that phi is a root. Every root is found.

All roots are among those of one trigonometric polynomial of degree 12 (`_existence.strict_candidates`), up to its rounding. They cut
the circle into cells in which no branch has a root; the values in the middle of the cells decide between which of them a root lies,
and where they do not change sign, the extremum beside the candidate tells a pair of near roots and a double root from none.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..numeric import wrap_angle
from ._existence import strict_candidates
from ._humanoid import BITS, POSE_TOLERANCE, REACH_TOLERANCE, branches, wrist_and_tip, wrists
from ._solutions import IkSolutions, branch_table
from ._targets import GripperOnPlane, batch_shape, broadcast_rows

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
_NEAR = 1e-4  # radians beside a candidate in which an extremum is looked for: candidates of double roots are good to about 1e-6
_SAME = 1e-7  # radians between roots of one branch that are one: |f| is below its rounding between them
_HALVINGS = 60
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


def strict_inverse(arm: Floats, target: GripperOnPlane, seed: Floats) -> IkSolutions:
    """One block of 8 rows (back, elbow, flip) per root index; see `humanoid_inverse`. arm: a, h, d1, d2, d3.

    The flag "phi_free" (...) marks targets at which every phi will do (gripper point on the torso axis, plane across it): phi is 0.
    """
    batch = batch_shape(target.point, target.normal, seed)
    pt, n, kept = broadcast_rows(batch, target.point, target.normal, seed)
    count = len(pt)

    def evaluate(rows: Indices, phi: Floats) -> tuple[Floats, NDArray[np.bool_], Floats]:
        """forearm . (n x g) (m, 4) of (back, elbow), where it is real, and the table of the branches."""
        at, normal = pt[rows], n[rows]
        p2, _ = wrists(arm, at, normal, phi[:, None])
        hinge = np.asarray(np.cross(normal, (at - p2) / arm[4]), dtype=np.float64)
        table = branches(arm, p2, at, kept[rows], np.ascontiguousarray(hinge))
        return table[:, 49:53], np.repeat(table[:, 40:42] > -REACH_TOLERANCE, 2, axis=1), table

    three, thrice = np.tile([0.0, 0.5 * np.pi, np.pi], count), np.repeat(np.arange(count), 3)
    circles, _ = wrists(arm, pt[thrice], n[thrice], three[:, None])
    across = np.asarray(np.cross(n[thrice], (pt[thrice] - circles) / arm[4]), dtype=np.float64).reshape(count, 3, 3)
    found = [strict_candidates(arm, *both) for both in zip(circles.reshape(count, 3, 3), across)]
    always = np.array([x is None for x in found], bool)
    cuts = [np.array([-np.pi]) if x is None else x[:-1] for x in found]  # on the circle: -pi stands for pi too
    where, kind, root = _roots(evaluate, cuts, ~always)
    some = np.repeat(np.flatnonzero(always), 4)
    where, kind, root = (
        np.concatenate(both)
        for both in ((where, some), (kind, np.tile(np.arange(4), always.sum())), (root, np.zeros(len(some))))
    )
    return _rows(arm, batch, pt, n, where, kind, root, evaluate, always)


def _roots(evaluate: Callable, cuts: list[Floats], wanted: NDArray[np.bool_]) -> tuple[Indices, Indices, Floats]:
    """Target, kind (back, elbow) and phi of every root, from the sorted candidates of each target on the circle."""
    targets = np.flatnonzero(wanted)
    if not len(targets):
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
    cell = np.concatenate([np.full(len(cuts[k]), k) for k in targets])
    cut = np.concatenate([cuts[k] for k in targets])
    after = np.concatenate([np.append(cuts[k][1:], cuts[k][0] + 2.0 * np.pi) for k in targets])
    before = np.concatenate([np.insert(cuts[k][:-1], 0, cuts[k][-1] - 2.0 * np.pi) for k in targets])
    low, high = 0.5 * (before + cut), 0.5 * (cut + after)
    (f_low, ok_low, _), (f_cut, ok_cut, _), (f_high, ok_high, _) = (evaluate(cell, x) for x in (low, cut, high))
    one = lambda w, k, x: _one(evaluate, w, k, x)
    found: list[tuple[Indices, Indices, Floats]] = []

    def bracket(c: Indices, k: Indices, a: Floats, b: Floats) -> None:
        found.append((cell[c], k, _bisected(lambda x: one(cell[c], k, x)[0], a, b)))

    both = ok_low & ok_high
    c, k = np.nonzero(both & (f_low * f_high < 0.0))
    bracket(c, k, low[c], high[c])
    # No change of sign: two near roots or a double one beside the candidate, or none.
    c, k = np.nonzero(both & (f_low * f_high >= 0.0) & (np.abs(f_cut) < 1e-3))
    a, b = np.maximum(low[c], cut[c] - _NEAR), np.minimum(high[c], cut[c] + _NEAR)
    way = np.where(f_low[c, k] + f_high[c, k] < 0.0, -1.0, 1.0)
    top = _lowest(lambda x: way * one(cell[c], k, x)[0], a, b)
    least = way * one(cell[c], k, top)[0]
    two, touch = least < 0.0, (least >= 0.0) & (least < POSE_TOLERANCE)
    bracket(c[two], k[two], a[two], top[two])
    bracket(c[two], k[two], top[two], b[two])
    found.append((cell[c[touch]], k[touch], top[touch]))
    # The reach ends here: a root between its last point and the middle of the cell.
    c, k = np.nonzero(ok_low != ok_high)
    inner = np.where(ok_low[c, k], low[c], high[c])
    last, beyond = inner.copy(), np.where(ok_low[c, k], high[c], low[c])
    for _ in range(_HALVINGS):
        middle = 0.5 * (last + beyond)
        good = one(cell[c], k, middle)[1]
        last, beyond = np.where(good, middle, last), np.where(good, beyond, middle)
    f_inner, f_last = one(cell[c], k, inner)[0], one(cell[c], k, last)[0]
    sign, at = f_inner * f_last < 0.0, np.abs(f_last) < POSE_TOLERANCE
    bracket(c[sign], k[sign], inner[sign], last[sign])
    found.append((cell[c[at & ~sign]], k[at & ~sign], last[at & ~sign]))
    c, k = np.nonzero(~ok_low & ~ok_high & ok_cut & (np.abs(f_cut) < POSE_TOLERANCE))  # reached at one phi only
    found.append((cell[c], k, cut[c]))
    where, kind, root = (np.concatenate(part) for part in zip(*found))
    value, real = one(where, kind, root)
    good = real & (np.abs(value) < POSE_TOLERANCE)
    where, kind, root, value = where[good], kind[good], wrap_angle(root[good]), np.abs(value[good])
    root = np.where(root < -np.pi + _SAME, root + 2.0 * np.pi, root)
    # Found twice, beside two candidates: the one with the smaller value stays.
    order = np.lexsort((root, kind, where))
    where, kind, root, value = where[order], kind[order], root[order], value[order]
    fresh = np.ones(len(root), bool)
    fresh[1:] = (np.diff(where) != 0) | (np.diff(kind) != 0) | (np.diff(root) > _SAME)
    best = np.lexsort((value, np.cumsum(fresh)))[np.flatnonzero(fresh)]
    return where[best], kind[best], wrap_angle(root[best])


def _one(evaluate: Callable, where: Indices, kind: Indices, phi: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """f and whether it is real, of one kind each."""
    if not len(phi):
        return np.zeros(0), np.zeros(0, bool)
    f, ok, _ = evaluate(where, phi)
    pick = np.arange(len(phi))
    return f[pick, kind], ok[pick, kind]


def _bisected(f: Callable, low: Floats, high: Floats) -> Floats:
    """The root between ends of different sign."""
    f_low = f(low)
    for _ in range(_HALVINGS if len(low) else 0):
        middle = 0.5 * (low + high)
        same = f(middle) * f_low > 0.0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return 0.5 * (low + high)


def _lowest(f: Callable, low: Floats, high: Floats) -> Floats:
    """Where f is least between the ends, by golden section."""
    x, y = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    fx, fy = f(x), f(y)
    for _ in range(30 if len(low) else 0):
        left = fx < fy
        low, high = np.where(left, low, x), np.where(left, y, high)
        new = np.where(left, high - _GOLDEN * (high - low), low + _GOLDEN * (high - low))
        f_new = f(new)
        x, y, fx, fy = (
            np.where(left, new, y),
            np.where(left, x, new),
            np.where(left, f_new, fy),
            np.where(left, fx, f_new),
        )
    return np.where(fx < fy, x, y)


def _rows(arm, batch, pt, n, where, kind, root, evaluate, always) -> IkSolutions:
    """One block of 8 rows per root index; the k-th root of each (back, elbow) fills the k-th block."""
    count = len(pt)
    order = np.lexsort((root, kind, where))
    where, kind, root = where[order], kind[order], root[order]
    group = where * 4 + kind
    first = np.r_[True, group[1:] != group[:-1]] if len(group) else np.zeros(0, bool)
    start = np.maximum.accumulate(np.where(first, np.arange(len(group)), 0)) if len(group) else np.zeros(0, np.int64)
    rank = np.arange(len(group)) - start
    blocks = int(rank.max()) + 1 if len(rank) else 1
    _, _, table = evaluate(np.arange(count), np.zeros(count))
    q = np.tile(table[:, None, :40].reshape(count, 1, 8, 5), (1, blocks, 1, 1))
    valid, free = np.zeros((count, blocks, 8), bool), np.zeros((count, blocks, 8))
    miss = np.full((count, blocks, 8), np.pi)
    if len(root):
        value, real, table = evaluate(where, root)
        pick = np.arange(len(root))
        found = table[:, :40].reshape(-1, 4, 2, 5)[pick, kind]
        good = real[pick, kind] & (np.abs(value[pick, kind]) < POSE_TOLERANCE)
        for flip in (0, 1):
            q[where, rank, 2 * kind + flip] = found[:, flip]
            valid[where, rank, 2 * kind + flip] = good
            free[where, rank, 2 * kind + flip] = root
            miss[where, rank, 2 * kind + flip] = np.abs(value[pick, kind])
    rows = blocks * 8
    q, valid = q.reshape(*batch, rows, 5), valid.reshape(*batch, rows)
    free, miss = free.reshape(*batch, rows), miss.reshape(*batch, rows)
    p, normal = pt.reshape(*batch, 3), n.reshape(*batch, 3)

    def residual() -> Floats:
        wrist, tip = wrist_and_tip(arm, q)
        position = np.sqrt(((tip - p[..., None, :]) ** 2).sum(axis=-1))
        slope = np.abs(((tip - wrist) * normal[..., None, :]).sum(axis=-1)) / arm[4]
        return np.maximum(np.maximum(position, slope), miss)

    def reason() -> Any:
        failed = ~valid.any(axis=-1)
        text = "no phi brings the whole gripper parallel to the plane: drop strict, or move the target"
        return np.where(failed, text, "").astype(object) if failed.ndim else (text if failed else "")

    branch = np.tile(branch_table(3), (blocks, 1))
    flags = {"phi_free": always.reshape(batch)}
    return IkSolutions(q, valid, branch, residual, True, reason, bits=BITS, flags=flags, free=free)
