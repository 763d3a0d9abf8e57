"""Damped least squares on motors, within joint limits, with restarts: one compilation serves all robots and kinds of
goal.

A goal is (14,): motor (8), point (3), direction (3); `_goal_kernels.goal_error` says which rule reads what.
"""

from __future__ import annotations

import numpy as np

from ..kernels import ONE, inner, jit, load_records, store_records
from . import _goal_kernels as goals_of
from . import _joint_kernels as joints
from ._kernels import FIXED, REVOLUTE, frames_into

_turn_column, _slide_column = joints.turn_column.inline, joints.slide_column.inline
_goal_error, _restricted = goals_of.goal_error.inline, goals_of.restricted_column.inline
_add_outer, _add_scaled = goals_of.add_outer.inline, goals_of.add_scaled.inline
_damped_solve, _dot6 = goals_of.damped_solve.inline, goals_of.dot6.inline


EXTRA, FINE = 2, 1e-2  # the last steps of what is within the tolerance


@inner
def error_of(M, row, goal, axis, rules, e):
    """`goal_error` of the tool pose M[row] -> e (14,)."""
    m, t = load_records(M, row, 8, ONE), load_records(goal, 0, 8, ONE)
    x, d = (goal[8], goal[9], goal[10]), (goal[11], goal[12], goal[13])
    store_records(e, 0, _goal_error(*m, *t, *x, *d, *load_records(axis, 0, 3, ONE), *load_records(rules, 0, 3, ONE)))


@inner
def columns_into(kinds, axes, coords, mult, M, goal, rules, weight, e, G):
    """Columns G (n, 6) of the Jacobian of the weighted error at the frames M of a chain."""
    for c in range(G.shape[0]):
        for r in range(6):
            G[c, r] = 0.0
    p, a = (e[6], e[7], e[8]), (e[9], e[10], e[11])
    d = (goal[11], goal[12], goal[13])
    for i in range(kinds.shape[0]):
        if kinds[i] != FIXED:
            m, u = load_records(M, i, 8, ONE), load_records(axes, i, 3, ONE)
            if kinds[i] == REVOLUTE:
                column = _turn_column(*m, *u, *p)
            else:
                column = _slide_column(*m, *u, *p)
            column = _restricted(*column, *a, *d, *load_records(rules, 0, 3, ONE), weight)
            g = load_records(G, coords[i], 6, ONE)
            store_records(G, coords[i], _add_scaled(*g, *column, mult[i]))


@inner
def damped_step(G, e, weight, damping, q, lower, upper, step):
    """Step of least |J step - e|^2 + damping |step|^2 that keeps q + step in the limits: joints that would leave stop
    there, in turn.

    step = J^T (J J^T + damping)^-1 e over the joints that are free; a joint with step[c] != 0 at the limit counts
    with its part.
    """
    n = q.shape[0]
    held = 0  # the joints that stand at a limit, as bits
    for _ in range(n + 1):
        total = (0.0,) * 21
        y = (e[0] * weight, e[1] * weight, e[2] * weight, e[3], e[4], e[5])
        for c in range(n):
            g = load_records(G, c, 6, ONE)
            if held >> c & 1:
                y = _add_scaled(*y, *g, -step[c])
            else:
                total = _add_outer(*total, *g)
        x = _damped_solve(*total, *y, damping)
        before = held
        for c in range(n):
            if not before >> c & 1:
                move = _dot6(*load_records(G, c, 6, ONE), *x)[0]
                if q[c] + move < lower[c]:
                    move = lower[c] - q[c]
                    held |= 1 << c
                elif q[c] + move > upper[c]:
                    move = upper[c] - q[c]
                    held |= 1 << c
                step[c] = move
        if held == before:
            return


@inner
def descend(
    parents, origins, kinds, axes, coords, mult, offs, lower, upper, goal, axis, rules, weight, iterations, tolerance, q,
    M, G, e, tried, trial, step,
):  # fmt: skip
    """Levenberg-Marquardt from `trial` to q; leaves the error in e (14,).

    Within the tolerance it takes EXTRA more steps at most, to FINE times it: the last ones gain many digits each.
    """
    last = parents.shape[0] - 1
    factor, cost, checked, k, refused, extra = 1e-2, np.inf, np.inf, 0, 0, 0
    # one loop, so that frames and error are compiled once: each turn judges `trial`, then makes the next one
    while True:
        frames_into(parents, origins, kinds, axes, coords, mult, offs, trial, M)
        error_of(M, last, goal, axis, rules, tried)
        new_cost = (weight * tried[12]) ** 2 + tried[13] ** 2
        if new_cost < cost:
            for c in range(q.shape[0]):
                q[c] = trial[c]
            store_records(e, 0, load_records(tried, 0, 14, ONE))
            cost = new_cost
            if e[12] <= tolerance and e[13] <= tolerance:
                if extra == EXTRA or (e[12] <= FINE * tolerance and e[13] <= FINE * tolerance):
                    return
                extra += 1
            elif k >= iterations:
                return
            if k % 8 == 7:
                if cost > 0.9 * checked:  # eight steps gained less than a twentieth of the error: a local minimum
                    return
                checked = cost
            columns_into(kinds, axes, coords, mult, M, goal, rules, weight, e, G)
            factor, refused = max(factor * 0.2, 1e-6), 0
            k += 1
        else:
            if extra > 0:
                return
            refused += 1
            if refused == 12 or not cost < np.inf:
                return
            factor = max(factor * 8.0, 1e-3)
        # damping in proportion to the squared error: quadratic convergence at the end, caution far away
        damped_step(G, e, weight, factor * cost + 1e-18, q, lower, upper, step)
        for c in range(q.shape[0]):
            trial[c] = min(max(q[c] + step[c], lower[c]), upper[c])


@jit(_nrt=False)
def solve_batch(
    parents, origins, kinds, axes, coords, mult, offs, lower, upper, goals, axis, rules, weight, first, starts, tips,
    attempts, iterations, tolerance, q, left, count, tries, M, G, e, tried, trial, step, at, rank,
):  # fmt: skip
    """For each goal (b, 14): up to q.shape[1] different solutions q (b, k, n), with (angle, distance) `left` (b, k, 2).

    Attempts start at first (b, n), then at `starts` (s, n) in the order of the error of their tool frames `tips` (s,
    8). count (b,): how many were solved; if none, row 0 is the best reached. tries (b,): attempts made.
    M (L, 8), G (n, 6), e, tried (14,), trial, step, at (n,), rank (s,) are working memory.
    """
    n = lower.shape[0]
    for b in range(goals.shape[0]):
        goal = goals[b]
        best, found = np.inf, 0
        tries[b] = 0
        for a in range(attempts):
            if a == 1:
                for s in range(starts.shape[0]):
                    error_of(tips, s, goal, axis, rules, e)
                    rank[s] = weight * e[12] + e[13]
            nearest = 0
            if a > 0:
                for s in range(starts.shape[0]):
                    if rank[s] < rank[nearest]:
                        nearest = s
                rank[nearest] = np.inf
            for c in range(n):
                trial[c] = starts[nearest, c] if a > 0 else first[b, c]
            tries[b] += 1
            descend(
                parents, origins, kinds, axes, coords, mult, offs, lower, upper, goal, axis, rules, weight, iterations,
                tolerance, at, M, G, e, tried, trial, step,
            )  # fmt: skip
            solved = e[12] <= tolerance and e[13] <= tolerance
            for k in range(found):
                gap = 0.0
                for c in range(n):
                    gap = max(gap, abs(at[c] - q[b, k, c]))
                solved = solved and gap > 0.02
            close = weight * e[12] + e[13]
            if solved or (found == 0 and close < best):
                best = close
                for c in range(n):
                    q[b, found, c] = at[c]
                left[b, found, 0], left[b, found, 1] = e[12], e[13]
                if solved:
                    found += 1
                    if found == q.shape[1]:
                        break
        count[b] = found
