"""Branch and bound on the clearance of a joint path: compiled code."""

from __future__ import annotations

import numpy as np

from ..distance._body_kernels import probe
from ..kernels import jit

DEPTH = 64


@jit
def bound_path(J, C, L, K, S, P, W, margin, slack, blur, tolerance, resolution, budget, first, gaps, out, F):
    """Bounds of the least clearance while the joints run straight through the waypoints W (k, n).

    An interval is settled when its lower bound reaches `need`: within the tolerance (absolute, relative) of the smallest
    clearance seen, and the margin, unless a sample already breaks that. It is given up as a gap when nothing moves by more than
    `resolution` on it, or after `budget` probes. With `first`, `need` is the margin alone, and the search goes left once a
    sample breaks it: what it ends with is the first violation in time.
    `slack` is taken off bounds for rounding, `blur` added to the distances of points from axes.
    out: 0 lower bound, 1 smallest clearance seen, 2-5 its segment, fraction, item, other, 6 probes, 7 gaps, 8 worst bound of a
    gap. gaps (g, 4): segment, from, to (fractions), lower bound; later ones widen the last row.
    """
    T, X = np.empty((J.shape[0], 12)), np.empty((L.shape[0], 8))
    for i in range(X.shape[0]):
        X[i, 7] = blur
    n = W.shape[1]
    q, h, nothing = np.empty(n), np.empty(n), np.empty(0)
    middle, half, known = np.empty(DEPTH), np.empty(DEPTH), np.empty(DEPTH)
    upper, lower, probes, count, worst_gap = np.inf, np.inf, 0, 0, np.inf
    seg_at, s_at, item_at, other_at = -1, 0.0, -1, -1
    points = W.shape[0]
    segments = points - 1
    for job in range(2 * points - 1):  # the waypoints, then the segments between them
        waypoint, segment = job < points, job - points
        if waypoint and job > segments:  # a violation at an earlier one
            continue
        if not waypoint and segment >= segments:
            break
        if job == points and first and upper + slack >= margin:
            upper = np.inf
        top = 0
        middle[0], half[0], known[0] = 0.5, 0.5, -np.inf
        while top >= 0:
            s, r, bound = middle[top], half[top], known[top]
            top -= 1
            need, span = margin, h
            if waypoint:
                need, span = upper, nothing
            elif not first:
                need = upper - max(tolerance[0], tolerance[1] * abs(upper))
                if upper + slack >= margin:
                    need = max(need, margin)
            settled, still = bound >= need and not waypoint, False
            if waypoint or (not settled and probes < budget):
                for c in range(n):
                    if waypoint:
                        q[c] = W[job, c]
                    else:
                        step = W[segment + 1, c] - W[segment, c]
                        q[c] = W[segment, c] + s * step
                        h[c] = abs(step) * r * (1.0 + 1e-12)
                clearance, fresh, item, other = probe(J, C, L, K, S, P, q, span, need, T, X, F)
                probes += 1
                broken = clearance + slack < margin
                if (clearance < upper and (waypoint or not first)) or (first and broken):
                    upper, seg_at, s_at, item_at, other_at = clearance, segment, s, item, other
                    if waypoint:
                        seg_at, s_at = max(job - 1, 0), 1.0 if job > 0 else 0.0
                if first and broken:
                    if waypoint:
                        segments = job  # nothing later matters
                    elif r > 1e-12:
                        top = 0
                        middle[0], half[0], known[0] = s - 0.5 * r, 0.5 * r, bound
                    else:
                        top = -1
                if waypoint or (first and broken):
                    continue
                bound = max(bound, fresh - slack)
                settled = bound >= need
                moved = 0.0
                for i in range(X.shape[0]):
                    moved = max(moved, X[i, 6])
                still = moved <= resolution or r < 1e-15 or top + 2 >= DEPTH
            if settled or still or probes >= budget:
                lower = min(lower, bound)
                if bound < margin and not settled:
                    worst_gap = min(worst_gap, bound)
                    at = min(count, gaps.shape[0]) - 1
                    if at >= 0 and gaps[at, 0] == segment and gaps[at, 2] >= s - r * (1.0 + 1e-9):
                        gaps[at, 2] = s + r
                        gaps[at, 3] = min(gaps[at, 3], bound)
                    else:
                        if count < gaps.shape[0]:
                            gaps[count, 0], gaps[count, 1], gaps[count, 2], gaps[count, 3] = (
                                segment,
                                s - r,
                                s + r,
                                bound,
                            )
                        count += 1
                continue
            for side in range(2):  # the earlier half on top
                top += 1
                middle[top], half[top], known[top] = s + (0.5 - side) * r, 0.5 * r, bound
        if first and not waypoint and upper < np.inf and seg_at == segment:
            break
    if points == 1:
        lower = upper - slack
    out[0], out[1], out[2], out[3], out[4], out[5] = lower, upper, seg_at, s_at, item_at, other_at
    out[6], out[7], out[8] = probes, count, worst_gap
