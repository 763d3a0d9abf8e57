"""Seven-joint arms with spherical shoulder: all 8 branches at a given redundancy, and the best redundancy of each.

`arm` as in `_screw_kernels.py`. `motors` (m, 8) are poses of the tip in the base frame; `limits` (2, n) move an angle by a turn
where only that is inside. Results are in the robot's order of joints, also where the chain is solved from its tip.
"""

import math

import numpy as np

from ..kernels import jit
from ._screw_kernels import (
    FREE,
    TOUCH,
    add,
    any_normal,
    blend,
    cross,
    decompose,
    dot,
    elbow_roots,
    frame,
    load_pose,
    normalised,
    other_root,
    product,
    ratio,
    reach_gap,
    right_angles,
    row,
    seeded,
    settle,
    sub,
    times,
    times_t,
    transposed,
    turn,
    turn_matrix,
)


@jit
def sew7(arm, limits, motors, q7, seeds, Q, valid, gap, free):
    """Spherical shoulder S (axes 1-3), axes 5 and 6 meeting in W, q7 given: rows (elbow, wrist, shoulder) of Q (m, 8,
    7).

    Points: S, W. q7: of the robot's last joint (first, if solved reversed). gap (m,): metres by which |S W| misses
    its range. free (m, 8): an angle was kept from the seed.
    """
    n1, n2, n3, n4, n5, n6, n7 = (
        row(arm, 0), row(arm, 1), row(arm, 2), row(arm, 3), row(arm, 4), row(arm, 5), row(arm, 6),
    )  # fmt: skip
    p4, p7, S, W = row(arm, 10), row(arm, 13), row(arm, 19), row(arm, 20)
    c56 = dot(n5, n6)
    x6 = any_normal(n6)
    square, twice = right_angles(n1, n2, n3)
    turned = arm[18, 0] > 0.5
    for i in range(motors.shape[0]):
        R, t = load_pose(motors, i, arm, 7)
        last = -q7[i] if turned else q7[i]
        s7, c7 = math.sin(last), math.cos(last)
        R6 = product(R, turn_matrix(n7, -s7, c7))  # link 6, before joint 7
        w = add(times(R, add(turn(n7, -s7, c7, sub(W, p7)), p7)), t)
        m6 = times(R6, n6)
        u = sub(S, w)
        length2, u6 = dot(u, u), dot(u, m6)
        v = cross(m6, u)
        across = dot(v, v)
        sa, ca, sb, cb, near = elbow_roots(p4, n4, W, S, length2)
        gap[i] = 0.0 if near else reach_gap(p4, n4, W, S, math.sqrt(length2))
        for elbow in range(2):
            s4, c4 = (sa, ca) if elbow == 0 else (sb, cb)
            u0 = sub(S, add(turn(n4, s4, c4, sub(W, p4)), p4))  # S seen from W, and axis 5, in the frame of link 3
            q4 = math.atan2(s4, c4)
            m5 = turn(n4, s4, c4, n5)
            z = dot(u0, m5)
            off = cross(m5, u0)
            # n5 with n5.u = z, n5.n6 = c56; the remainder from the distance of S to axis 5, not from |u|^2 - z^2
            rest = (1.0 - c56 * c56) * dot(off, off) - (u6 - c56 * z) * (u6 - c56 * z)
            good = near and rest >= -TOUCH * length2 and across > 0.0
            inverse = 1.0 / max(across, 1e-300)
            base = blend((z - c56 * u6) * inverse, u, (c56 * length2 - z * u6) * inverse, m6)
            bend = math.sqrt(max(rest, 0.0)) * inverse
            on_axis = dot(off, off) < FREE * FREE
            F0, _ = frame(u0, m5)
            for wrist in range(2):
                d, _ = normalised(blend(1.0, base, bend if wrist == 0 else -bend, v))
                if on_axis:  # S on axis 5: the arm plane is free; keep q5
                    before = seeded(seeds, i, 4, arm, 7)
                    kept = turn(n4, s4, c4, turn(n5, math.sin(before), math.cos(before), n6))
                    F1, _ = frame(u, m6)
                    G0, _ = frame(u0, kept)
                    R3 = product(F1, transposed(G0))
                else:
                    F1, _ = frame(u, d)
                    R3 = product(F1, transposed(F0))
                R4 = product(R3, turn_matrix(n4, s4, c4))
                s5, c5, _ = ratio(n5, n6, times_t(R4, m6))
                s6, c6, _ = ratio(n6, x6, turn(n5, -s5, c5, times_t(R4, times(R6, x6))))
                q5, q6 = math.atan2(s5, c5), math.atan2(s6, c6)
                k = 4 * elbow + 2 * wrist
                first = seeded(seeds, i, 0, arm, 7)
                real, loose = decompose(n1, n2, n3, R3, 0, first, Q[i, k], 0)
                real2, loose2 = other_root(n1, n2, n3, R3, first, Q[i], k, k + 1, 0, square and not loose, twice)
                for shoulder in range(2):
                    out = Q[i, k + shoulder]
                    out[3], out[4], out[5], out[6] = q4, q5, q6, last
                    settle(out, limits, turned)
                    valid[i, k + shoulder] = good and (real2 if shoulder else real)
                    free[i, k + shoulder] = (loose2 if shoulder else loose) or on_axis


@jit
def srs7(arm, limits, motors, psi, seeds, Q, valid, gap, free):
    """Spherical shoulder S (axes 1-3) and wrist W (axes 5-7), elbow angle psi given: rows (shoulder, elbow, wrist).

    Points: S, W, E (the foot of S on axis 4). psi turns E about the line S-W from the side of axis 1 (of any fixed
    normal of it where S-W is parallel to axis 1).
    """
    n1, n2, n3, n4, n5, n6, n7 = (
        row(arm, 0), row(arm, 1), row(arm, 2), row(arm, 3), row(arm, 4), row(arm, 5), row(arm, 6),
    )  # fmt: skip
    p4, S, W, E = row(arm, 10), row(arm, 19), row(arm, 20), row(arm, 21)
    spare = any_normal(n1)
    square1, twice1 = right_angles(n1, n2, n3)
    square5, twice5 = right_angles(n5, n6, n7)
    turned = arm[18, 0] > 0.5
    for i in range(motors.shape[0]):
        R, t = load_pose(motors, i, arm, 7)
        w = sub(add(times(R, W), t), S)
        length2 = dot(w, w)
        sa, ca, sb, cb, near = elbow_roots(p4, n4, W, S, length2)
        gap[i] = 0.0 if near else reach_gap(p4, n4, W, S, math.sqrt(length2))
        u, _ = normalised(w)
        r = cross(n1, u)
        parallel = dot(r, r) < 1e-18
        side, _ = normalised(cross(spare if parallel else n1, u))
        r = cross(u, side)
        s, c = math.sin(psi[i]), math.cos(psi[i])
        F1, _ = frame(u, blend(c, r, s, cross(u, r)))
        for elbow in range(2):
            s4, c4 = (sa, ca) if elbow == 0 else (sb, cb)
            w0 = sub(add(turn(n4, s4, c4, sub(W, p4)), p4), S)
            e0 = sub(E, S)
            lever = cross(w0, e0)
            stretched = dot(lever, lever) < FREE * FREE * length2 * dot(e0, e0)
            F0, _ = frame(w0, cross(n4, w0) if stretched else e0)
            R3 = product(F1, transposed(F0))
            R57 = product(transposed(product(R3, turn_matrix(n4, s4, c4))), R)
            q4 = math.atan2(s4, c4)
            k, first, fifth = 2 * elbow, seeded(seeds, i, 0, arm, 7), seeded(seeds, i, 4, arm, 7)
            real1, free1 = decompose(n1, n2, n3, R3, 0, first, Q[i, k], 0)
            real1_, free1_ = other_root(n1, n2, n3, R3, first, Q[i], k, k + 4, 0, square1 and not free1, twice1)
            real5, free5 = decompose(n5, n6, n7, R57, 0, fifth, Q[i, k], 4)
            real5_, free5_ = other_root(n5, n6, n7, R57, fifth, Q[i], k, k + 1, 4, square5 and not free5, twice5)
            for j in range(3):
                Q[i, k + 1, j], Q[i, k + 5, j] = Q[i, k, j], Q[i, k + 4, j]
                Q[i, k + 4, 4 + j], Q[i, k + 5, 4 + j] = Q[i, k, 4 + j], Q[i, k + 1, 4 + j]
            for shoulder in range(2):
                for wrist in range(2):
                    out = Q[i, k + 4 * shoulder + wrist]
                    out[3] = q4
                    settle(out, limits, turned)
                    real = (real1_ if shoulder else real1) and (real5_ if wrist else real5)
                    valid[i, k + 4 * shoulder + wrist] = near and real
                    loose = (free1_ if shoulder else free1) or (free5_ if wrist else free5)
                    free[i, k + 4 * shoulder + wrist] = loose or stretched


@jit
def best(kind, arm, limits, low, high, samples, motors, seeds, value, Q, valid, gap, free):
    """For every branch of every pose the redundancy, value (m, 8), that keeps the joints farthest from their limits.

    kind 0: sew7, 1: srs7. `samples` even values in [low, high], then shrinking steps around the best of each branch.
    """
    n = Q.shape[2]
    one, row_q, row_v = np.empty(1), np.empty((1, 8, n)), np.empty((1, 8), np.bool_)
    row_f, row_g = np.empty((1, 8), np.bool_), np.empty(1)
    top = np.empty(8)
    for i in range(motors.shape[0]):
        pose, seed = motors[i : i + 1], seeds[i : i + 1]
        gap[i] = math.inf
        for k in range(8):
            top[k], value[i, k], valid[i, k] = -math.inf, 0.5 * (low + high), False
        # -2: the scan; -1: a finer one where that found nothing inside the limits; 0..7: around the best of branch
        # `own`.
        for own in range(-2, 8):
            if own == -1 and np.max(top) >= 0.0:
                continue  # the fine scan is for poses with a narrow range only
            if own >= 0 and (top[own] == -math.inf or (own > 0 and value[i, own] == value[i, own - 1])):
                continue
            step = (high - low) / (samples if own == -2 else 16 * samples)
            trials = samples if own == -2 else 16 * samples if own == -1 else 12
            if own >= 0:
                step = (high - low) / samples
            width = 0.5 * step
            centre = 0.0 if own < 0 else value[i, own]
            for trial in range(trials):
                if own < 0:
                    one[0] = low + (trial + 0.5) * step
                else:
                    if trial > 0 and trial % 2 == 0:
                        centre = value[i, own]
                        width *= 0.5
                    one[0] = min(max(centre + (width if trial % 2 == 0 else -width), low), high)
                if kind == 0:
                    sew7(arm, limits, pose, one, seed, row_q, row_v, row_g, row_f)
                else:
                    srs7(arm, limits, pose, one, seed, row_q, row_v, row_g, row_f)
                gap[i] = min(gap[i], row_g[0])
                for k in range(8):
                    if not row_v[0, k]:
                        continue
                    margin = math.inf
                    for j in range(n):
                        margin = min(margin, min(row_q[0, k, j] - limits[0, j], limits[1, j] - row_q[0, k, j]))
                    if margin > top[k]:
                        top[k], value[i, k], valid[i, k], free[i, k] = margin, one[0], True, row_f[0, k]
                        for j in range(n):
                            Q[i, k, j] = row_q[0, k, j]
            if own < 0:
                for k in range(8):
                    if not valid[i, k]:
                        for j in range(n):
                            Q[i, k, j] = row_q[0, k, j]
