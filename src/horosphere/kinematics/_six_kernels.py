"""Five- and six-joint arms without redundancy: all branches of a pose (arguments as in `_seven_kernels.py`)."""

import math

from ..kernels import jit
from ._screw_kernels import (
    ALIGNED,
    FREE,
    add,
    any_normal,
    blend,
    cross,
    decompose,
    dot,
    elbow_roots,
    load_pose,
    product,
    ratio,
    reach_gap,
    roots,
    row,
    scale,
    seeded,
    settle,
    simple_roots,
    sub,
    times,
    times_t,
    transposed,
    turn,
    turn_matrix,
)


@jit
def us5(arm, limits, motors, seeds, Q, valid, gap, free):
    """Axes 1, 2 meet in S, axes 3, 4, 5 in E: rows (shoulder, wrist) of Q (m, 4, 5). Points: S, E; number: slack.

    The pose is reachable where E keeps its distance to S: gap (m,) is by how many metres it does not; slack is
    what is forgiven.
    """
    n1, n2, n3, n4, n5 = row(arm, 0), row(arm, 1), row(arm, 2), row(arm, 3), row(arm, 4)
    S, E = row(arm, 15), row(arm, 16)
    v = sub(E, S)
    radius = math.sqrt(dot(v, v))
    along = dot(v, n2)
    b = blend(1.0, v, -along, n2)
    slack = arm[14, 1]
    turned = arm[14, 0] > 0.5
    for i in range(motors.shape[0]):
        R, t = load_pose(motors, i, arm, 5)
        e = sub(add(times(R, E), t), S)
        length = math.sqrt(dot(e, e))
        gap[i] = abs(length - radius)
        e = scale(radius / max(length, 1e-300), e)
        w = cross(n1, e)
        sa, ca, sb, cb, real = simple_roots(along * dot(n1, n2), dot(n1, b), dot(n1, cross(n2, b)), dot(n1, e))
        for shoulder in range(2):
            s2, c2 = (sa, ca) if shoulder == 0 else (sb, cb)
            s1, c1, kept = ratio(n1, turn(n2, s2, c2, v), e)
            if kept or dot(w, w) < ALIGNED * ALIGNED * radius * radius:
                s1, c1, kept = math.sin(seeded(seeds, i, 0, arm, 5)), math.cos(seeded(seeds, i, 0, arm, 5)), True
            R2 = product(turn_matrix(n1, s1, c1), turn_matrix(n2, s2, c2))
            R35 = product(transposed(R2), R)
            for wrist in range(2):
                k = 2 * shoulder + wrist
                out = Q[i, k]
                out[0], out[1] = math.atan2(s1, c1), math.atan2(s2, c2)
                fits, free3 = decompose(n3, n4, n5, R35, wrist, seeded(seeds, i, 2, arm, 5), out, 2)
                settle(out, limits, turned)
                valid[i, k] = real and fits and gap[i] <= slack
                free[i, k] = kept or free3


@jit
def spherical6(arm, limits, motors, seeds, Q, valid, gap, free):
    """Axes 4-6 meet in W: rows (shoulder, elbow, wrist) of Q (m, 8, 6). Points: W, and C that the number
    (mode) names.

    mode 0: axes 2, 3 parallel; 1: axes 1, 2 meet in C; 2: axes 1, 2 parallel; 3: axes 2, 3 meet in C.
    """
    n1, n2, n3 = row(arm, 0), row(arm, 1), row(arm, 2)
    n4, n5, n6 = row(arm, 3), row(arm, 4), row(arm, 5)
    p1, p2, p3, W, C = row(arm, 6), row(arm, 7), row(arm, 8), row(arm, 17), row(arm, 18)
    mode = int(arm[16, 1])
    turned = arm[16, 0] > 0.5
    for i in range(motors.shape[0]):
        R, t = load_pose(motors, i, arm, 6)
        w = add(times(R, W), t)
        gap[i] = math.inf
        for shoulder in range(2):
            for elbow in range(2):
                s1, c1, s2, c2, s3, c3, miss, kept = arm3(
                    n1,
                    n2,
                    n3,
                    p1,
                    p2,
                    p3,
                    W,
                    C,
                    mode,
                    w,
                    shoulder,
                    elbow,
                    seeded(seeds, i, 0, arm, 6),
                    seeded(seeds, i, 1, arm, 6),
                )
                gap[i] = min(gap[i], miss)
                R3 = product(product(turn_matrix(n1, s1, c1), turn_matrix(n2, s2, c2)), turn_matrix(n3, s3, c3))
                R46 = product(transposed(R3), R)
                for wrist in range(2):
                    k = 4 * shoulder + 2 * elbow + wrist
                    out = Q[i, k]
                    out[0], out[1], out[2] = math.atan2(s1, c1), math.atan2(s2, c2), math.atan2(s3, c3)
                    fits, free4 = decompose(n4, n5, n6, R46, wrist, seeded(seeds, i, 3, arm, 6), out, 3)
                    settle(out, limits, turned)
                    valid[i, k] = miss <= 0.0 and fits
                    free[i, k] = kept or free4


@jit
def arm3(n1, n2, n3, p1, p2, p3, W, C, mode, w, first, second, kept1, kept2):
    """Sines and cosines of q1, q2, q3 that bring W to w, the metres missing (0 if reached), and whether an angle was
    kept.
    """
    s1, c1, s2, c2, s3, c3, miss, kept = 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, False
    if mode == 0 or mode == 3:
        # q1 first: the height along axis 2, or the distance from C, does not change with q2, q3.
        v = sub(w, p1)
        if mode == 0:
            h = dot(v, n1)
            b = blend(1.0, v, -h, n1)
            # n2 . turn(n1, -q1, v) = const
            level = dot(n2, sub(W, p1))
            sa, ca, sb, cb, real = simple_roots(h * dot(n1, n2), dot(n2, b), -dot(n2, cross(n1, b)), level)
            flat = math.sqrt(max(dot(b, b) * (1.0 - dot(n1, n2) ** 2), 0.0))
            miss = 0.0 if real else max(abs(level - h * dot(n1, n2)) - flat, 1e-9)
            free1 = dot(b, b) < FREE * FREE
        else:
            r = sub(W, C)
            sa, ca, sb, cb, real = elbow_roots(p1, n1, w, C, dot(r, r))
            sa, sb = -sa, -sb  # w turned backwards
            miss = 0.0 if real else max(reach_gap(p1, n1, w, C, math.sqrt(dot(r, r))), 1e-9)
            b = cross(n1, v)
            free1 = dot(b, b) < FREE * FREE
        s1, c1 = (sa, ca) if first == 0 else (sb, cb)
        if free1:
            s1, c1, kept = math.sin(kept1), math.cos(kept1), True
            miss = 0.0
        x = add(turn(n1, -s1, c1, v), p1)
        if mode == 0:
            # Planar two-link arm: q3 by the distance from axis 2, q2 by the angle.
            g = sub(x, p2)
            g = blend(1.0, g, -dot(g, n2), n2)
            sa, ca, sb, cb, real = elbow_roots(p3, n3, W, add(p2, scale(dot(sub(W, p2), n2), n2)), dot(g, g))
            if not real:
                target = add(p2, scale(dot(sub(W, p2), n2), n2))
                miss = max(miss, max(reach_gap(p3, n3, W, target, math.sqrt(dot(g, g))), 1e-9))
            s3, c3 = (sa, ca) if second == 0 else (sb, cb)
            y = sub(add(turn(n3, s3, c3, sub(W, p3)), p3), p2)
            s2, c2, free2 = ratio(n2, y, g)
        else:
            # q3 by the height along axis 2, q2 by the angle.
            g, r = sub(x, C), sub(W, C)
            h = dot(r, n3)
            b = blend(1.0, r, -h, n3)
            sa, ca, sb, cb, real = simple_roots(h * dot(n2, n3), dot(n2, b), dot(n2, cross(n3, b)), dot(n2, g))
            if not real:
                miss = max(miss, max(abs(dot(n2, g) - h * dot(n2, n3)) - math.sqrt(dot(b, b)), 1e-9))
            s3, c3 = (sa, ca) if second == 0 else (sb, cb)
            s2, c2, free2 = ratio(n2, turn(n3, s3, c3, r), g)
        if free2:
            s2, c2, kept = math.sin(kept2), math.cos(kept2), True
        return s1, c1, s2, c2, s3, c3, miss, kept
    if mode == 1:
        # q3 by the distance from C, q2 by the height along axis 1, q1 by the angle.
        g = sub(w, C)
        sa, ca, sb, cb, real = elbow_roots(p3, n3, W, C, dot(g, g))
        miss = 0.0 if real else max(reach_gap(p3, n3, W, C, math.sqrt(dot(g, g))), 1e-9)
        s3, c3 = (sa, ca) if second == 0 else (sb, cb)
        y = sub(add(turn(n3, s3, c3, sub(W, p3)), p3), C)
        h = dot(y, n2)
        b = blend(1.0, y, -h, n2)
        sa, ca, sb, cb, real = simple_roots(h * dot(n1, n2), dot(n1, b), dot(n1, cross(n2, b)), dot(n1, g))
        if not real:
            miss = max(miss, max(abs(dot(n1, g) - h * dot(n1, n2)) - math.sqrt(dot(b, b)), 1e-9))
        s2, c2 = (sa, ca) if first == 0 else (sb, cb)
        s1, c1, free1 = ratio(n1, turn(n2, s2, c2, y), g)
    else:
        # Axes 1 and 2 parallel: q3 by the height along them, q2 by the distance from axis 1, q1 by the angle.
        v = sub(W, p3)
        h = dot(v, n3)
        b = blend(1.0, v, -h, n3)
        level = dot(n1, sub(w, p3))
        sa, ca, sb, cb, real = simple_roots(h * dot(n1, n3), dot(n1, b), dot(n1, cross(n3, b)), level)
        miss = 0.0 if real else max(abs(level - h * dot(n1, n3)) - math.sqrt(dot(b, b)), 1e-9)
        s3, c3 = (sa, ca) if second == 0 else (sb, cb)
        y = add(turn(n3, s3, c3, v), p3)
        g = sub(w, p1)
        g = blend(1.0, g, -dot(g, n1), n1)
        foot = add(p1, scale(dot(sub(y, p1), n1), n1))
        sa, ca, sb, cb, real = elbow_roots(p2, n2, y, foot, dot(g, g))
        if not real:
            miss = max(miss, max(reach_gap(p2, n2, y, foot, math.sqrt(dot(g, g))), 1e-9))
        s2, c2 = (sa, ca) if first == 0 else (sb, cb)
        s1, c1, free1 = ratio(n1, sub(add(turn(n2, s2, c2, sub(y, p2)), p2), p1), g)
    if free1:
        s1, c1, kept = math.sin(kept1), math.cos(kept1), True
    return s1, c1, s2, c2, s3, c3, miss, kept


@jit
def parallel6(arm, limits, motors, seeds, Q, valid, gap, free):
    """Axes 2, 3, 4 parallel and axes 5, 6 meeting in W (the UR family): rows (shoulder, wrist, elbow) of Q (m, 8, 6).
    Point: W.
    """
    n1, n, n5, n6 = row(arm, 0), row(arm, 1), row(arm, 4), row(arm, 5)
    p1, p2, p3, p4, W = row(arm, 6), row(arm, 7), row(arm, 8), row(arm, 9), row(arm, 17)
    x = any_normal(n)
    turned = arm[16, 0] > 0.5
    for i in range(motors.shape[0]):
        R, t = load_pose(motors, i, arm, 6)
        v = sub(add(times(R, W), t), p1)
        h = dot(v, n1)
        b = blend(1.0, v, -h, n1)
        level = dot(n, sub(W, p1))
        sa, ca, sb, cb, near = simple_roots(h * dot(n1, n), dot(n, b), -dot(n, cross(n1, b)), level)
        missing = 0.0 if near else max(abs(level) - math.sqrt(dot(b, b)), 1e-9)
        gap[i] = math.inf
        for shoulder in range(2):
            s1, c1 = (sa, ca) if shoulder == 0 else (sb, cb)
            R1 = product(turn_matrix(n1, -s1, c1), R)  # rotation of joints 2 to 6
            m = times_t(R1, n)  # the parallel axes, seen from the tool
            g = dot(n, n5) * dot(n5, n6)
            across = cross(n6, m)
            rest = dot(across, across) - dot(n, n5) ** 2 - dot(n5, n6) ** 2 + 2.0 * g * dot(m, n6)
            s5a, c5a, s5b, c5b, bends = roots(g, dot(n, n6) - g, dot(n, cross(n5, n6)), dot(m, n6), rest)
            for wrist in range(2):
                s5, c5 = (s5a, c5a) if wrist == 0 else (s5b, c5b)
                # R1^T n = turn(n6, -q6) turn(n5, -q5) n
                y = turn(n5, -s5, c5, n)
                s6, c6, kept = ratio(n6, m, y)
                if kept or dot(across, across) < ALIGNED * ALIGNED:
                    s6, c6, kept = math.sin(seeded(seeds, i, 5, arm, 6)), math.cos(seeded(seeds, i, 5, arm, 6)), True
                R56 = product(turn_matrix(n5, s5, c5), turn_matrix(n6, s6, c6))
                R24 = product(R1, transposed(R56))
                s, c, _ = ratio(n, x, times(R24, x))  # q2 + q3 + q4
                # Where joint 4 has to be, in the plane across the parallel axes.
                w = add(turn(n1, -s1, c1, v), p1)
                goal = sub(add(w, turn(n, s, c, sub(p4, W))), p2)
                goal = blend(1.0, goal, -dot(goal, n), n)
                foot = add(p2, scale(dot(sub(p4, p2), n), n))
                s3a, c3a, s3b, c3b, real = elbow_roots(p3, n, p4, foot, dot(goal, goal))
                miss = missing
                if not real:
                    miss = max(miss, max(reach_gap(p3, n, p4, foot, math.sqrt(dot(goal, goal))), 1e-9))
                gap[i] = min(gap[i], miss)
                for elbow in range(2):
                    s3, c3 = (s3a, c3a) if elbow == 0 else (s3b, c3b)
                    lever = sub(add(turn(n, s3, c3, sub(p4, p3)), p3), p2)
                    s2, c2, kept2 = ratio(n, lever, goal)
                    if kept2:
                        s2, c2 = math.sin(seeded(seeds, i, 1, arm, 6)), math.cos(seeded(seeds, i, 1, arm, 6))
                    sp, cp = s2 * c3 + c2 * s3, c2 * c3 - s2 * s3
                    k = 4 * shoulder + 2 * wrist + elbow
                    out = Q[i, k]
                    out[0], out[1], out[2] = math.atan2(s1, c1), math.atan2(s2, c2), math.atan2(s3, c3)
                    out[3] = math.atan2(s * cp - c * sp, c * cp + s * sp)
                    out[4], out[5] = math.atan2(s5, c5), math.atan2(s6, c6)
                    settle(out, limits, turned)
                    valid[i, k] = near and bends and real
                    free[i, k] = kept or kept2
