"""Five- and six-joint arms without redundancy: all branches of a pose, one a lane (arguments as in `_seven_kernels.py`)."""

import math

from ..kernels import (
    EIGHT,
    jit,
    lane_max,
    lane_min,
    lane_sqrt,
    lane_where_lt,
    load_lanes,
    min_lane,
    store_records,
)
from ._screw_kernels import (
    ALIGNED,
    FREE,
    SIGNS,
    add,
    any_normal,
    blend,
    cross,
    decompose,
    dot,
    elbow_root,
    load_pose,
    missing,
    product,
    ratio,
    reach_gap,
    root,
    row,
    scale,
    seeded,
    settled,
    simple_root,
    store_flags,
    sub,
    times,
    times_t,
    transposed,
    turn,
    turn_matrix,
)

FOUR = (0,) * 4


@jit
def angles6(s, c, limits, turned):
    """The six angles of sines and cosines, in the robot's order and near its limits."""
    if turned:
        s, c = (-s[5], -s[4], -s[3], -s[2], -s[1], -s[0]), (c[5], c[4], c[3], c[2], c[1], c[0])
    return (
        settled(s[0], c[0], limits[0, 0], limits[1, 0]),
        settled(s[1], c[1], limits[0, 1], limits[1, 1]),
        settled(s[2], c[2], limits[0, 2], limits[1, 2]),
        settled(s[3], c[3], limits[0, 3], limits[1, 3]),
        settled(s[4], c[4], limits[0, 4], limits[1, 4]),
        settled(s[5], c[5], limits[0, 5], limits[1, 5]),
    )


@jit
def us5(arm, limits, motors, seeds, Q, valid, gap, free):
    """Axes 1, 2 meet in S, axes 3, 4, 5 in E: rows (shoulder, wrist) of Q (m, 4, 5). Points: S, E; number: slack.

    The pose is reachable where E keeps its distance to S: gap (m,) is by how many metres it does not; slack is
    what is forgiven.
    """
    n1, n2, n3, n4, n5 = row(arm, 0), row(arm, 1), row(arm, 2), row(arm, 3), row(arm, 4)
    shoulder, wrist = load_lanes(SIGNS, 8, FOUR), load_lanes(SIGNS, 16, FOUR)
    S, E = row(arm, 15), row(arm, 16)
    v = sub(E, S)
    radius = lane_sqrt(dot(v, v))
    along = dot(v, n2)
    b = blend(1.0, v, -along, n2)
    c1, c2 = dot(n1, b), dot(n1, cross(n2, b))
    slack, turned, soft = arm[14, 1], arm[14, 0] > 0.5, arm[14, 2]
    flat = Q.reshape(-1)
    for i in range(motors.shape[0]):
        R, t = load_pose(motors, i, arm, 5)
        e = sub(add(times(R, E), t), S)
        length = lane_sqrt(dot(e, e))
        gap[i] = abs(length - radius)
        e = scale(radius / max(length, 1e-300), e)
        w = cross(n1, e)
        s_2, c_2, good = simple_root(along * dot(n1, n2), c1, c2, dot(n1, e), shoulder, soft)
        s_1, c_1, kept = ratio(n1, turn(n2, s_2, c_2, v), e)
        kept = lane_where_lt(dot(w, w), ALIGNED * ALIGNED * radius * radius, 1.0, kept)
        before = seeded(seeds, i, 0, arm, 5)
        s_1, c_1 = lane_where_lt(0.5, kept, before[0], s_1), lane_where_lt(0.5, kept, before[1], c_1)
        R35 = product(transposed(product(turn_matrix(n1, s_1, c_1), turn_matrix(n2, s_2, c_2))), R)
        (s3, c3, s4, c4, s5, c5), fits, free3 = decompose(n3, n4, n5, R35, wrist, seeded(seeds, i, 2, arm, 5), soft)
        s, c = (s_1, s_2, s3, s4, s5), (c_1, c_2, c3, c4, c5)
        if turned:
            s, c = (-s5, -s4, -s3, -s_2, -s_1), (c5, c4, c3, c_2, c_1)
        q = (
            settled(s[0], c[0], limits[0, 0], limits[1, 0]),
            settled(s[1], c[1], limits[0, 1], limits[1, 1]),
            settled(s[2], c[2], limits[0, 2], limits[1, 2]),
            settled(s[3], c[3], limits[0, 3], limits[1, 3]),
            settled(s[4], c[4], limits[0, 4], limits[1, 4]),
        )
        store_records(flat, 4 * i, q)
        good = lane_min(lane_min(good, fits), slack - gap[i])
        store_flags(good, lane_max(kept, free3), i, valid, free)


@jit
def spherical6(arm, limits, motors, seeds, Q, valid, gap, free):
    """Axes 4-6 meet in W: rows (shoulder, elbow, wrist) of Q (m, 8, 6). Points: W, and C that the number
    (mode) names.

    mode 0: axes 2, 3 parallel; 1: axes 1, 2 meet in C; 2: axes 1, 2 parallel; 3: axes 2, 3 meet in C.
    """
    n1, n2, n3 = row(arm, 0), row(arm, 1), row(arm, 2)
    n4, n5, n6 = row(arm, 3), row(arm, 4), row(arm, 5)
    shoulder, elbow, wrist = load_lanes(SIGNS, 0, EIGHT), load_lanes(SIGNS, 8, EIGHT), load_lanes(SIGNS, 16, EIGHT)
    W = row(arm, 17)
    mode, soft = int(arm[16, 1]), arm[16, 2]
    flat = Q.reshape(-1)
    for i in range(motors.shape[0]):
        R, t = load_pose(motors, i, arm, 6)
        w = add(times(R, W), t)
        kept1, kept2 = seeded(seeds, i, 0, arm, 6), seeded(seeds, i, 1, arm, 6)
        if mode == 0:
            first, miss, kept = arm3_parallel_23(arm, w, shoulder, elbow, kept1, kept2)
        elif mode == 1:
            first, miss, kept = arm3_meeting_12(arm, w, shoulder, elbow, kept1)
        elif mode == 2:
            first, miss, kept = arm3_parallel_12(arm, w, shoulder, elbow, kept1)
        else:
            first, miss, kept = arm3_meeting_23(arm, w, shoulder, elbow, kept1, kept2)
        s1, c1, s2, c2, s3, c3 = first
        R3 = product(product(turn_matrix(n1, s1, c1), turn_matrix(n2, s2, c2)), turn_matrix(n3, s3, c3))
        kept4 = seeded(seeds, i, 3, arm, 6)
        (s4, c4, s5, c5, s6, c6), fits, free4 = decompose(n4, n5, n6, product(transposed(R3), R), wrist, kept4, soft)
        q = angles6((s1, s2, s3, s4, s5, s6), (c1, c2, c3, c4, c5, c6), limits, arm[16, 0] > 0.5)
        store_records(flat, 8 * i, q)
        store_flags(lane_min(-miss, fits), lane_max(kept, free4), i, valid, free)
        gap[i] = min_lane(miss)


@jit
def keep(free, kept, s, c):
    """(sine, cosine), or those kept where the angle is free."""
    return lane_where_lt(0.5, free, kept[0], s), lane_where_lt(0.5, free, kept[1], c)


@jit
def arm3_parallel_23(arm, w, first, second, kept1, kept2):
    """Sines and cosines of q1, q2, q3 that bring W to w, the metres missing (0 if reached), and whether an angle was kept.

    q1 first: the height along axis 2 does not change with q2, q3. Then a planar arm of two links: q3 by the distance from axis
    2, q2 by the angle.
    """
    n1, n2, n3, p1, p2, p3, W = (
        row(arm, 0), row(arm, 1), row(arm, 2), row(arm, 6), row(arm, 7), row(arm, 8), row(arm, 17),
    )  # fmt: skip
    soft = arm[16, 2]
    v = sub(w, p1)
    h = dot(v, n1)
    b = blend(1.0, v, -h, n1)
    level = dot(n2, sub(W, p1))  # n2 . turn(n1, -q1, v)
    s1, c1, real = simple_root(h * dot(n1, n2), dot(n2, b), -dot(n2, cross(n1, b)), level, first, soft)
    free1 = lane_where_lt(dot(b, b), FREE * FREE, 1.0, 0.0)
    span = lane_sqrt(lane_max(dot(b, b) * (1.0 - dot(n1, n2) * dot(n1, n2)), 0.0))
    miss = lane_where_lt(0.5, free1, 0.0, missing(real, abs(level - h * dot(n1, n2)) - span))
    s1, c1 = keep(free1, kept1, s1, c1)
    g = sub(add(turn(n1, -s1, c1, v), p1), p2)
    g = blend(1.0, g, -dot(g, n2), n2)
    foot, far2 = add(p2, scale(dot(sub(W, p2), n2), n2)), dot(g, g)
    s3, c3, real = elbow_root(p3, n3, W, foot, far2, second, soft)
    miss = lane_max(miss, missing(real, reach_gap(p3, n3, W, foot, lane_sqrt(far2))))
    s2, c2, free2 = ratio(n2, sub(add(turn(n3, s3, c3, sub(W, p3)), p3), p2), g)
    s2, c2 = keep(free2, kept2, s2, c2)
    return (s1, c1, s2, c2, s3, c3), miss, lane_max(free1, free2)


@jit
def arm3_meeting_23(arm, w, first, second, kept1, kept2):
    """The same where axes 2, 3 meet in C: q1 by the distance from C, q3 by the height along axis 2, q2 by the angle."""
    n1, n2, n3, p1, W, C = row(arm, 0), row(arm, 1), row(arm, 2), row(arm, 6), row(arm, 17), row(arm, 18)
    soft = arm[16, 2]
    v, r = sub(w, p1), sub(W, C)
    s1, c1, real = elbow_root(p1, n1, w, C, dot(r, r), first, soft)
    s1 = -s1  # w turned backwards
    b = cross(n1, v)
    free1 = lane_where_lt(dot(b, b), FREE * FREE, 1.0, 0.0)
    miss = lane_where_lt(0.5, free1, 0.0, missing(real, reach_gap(p1, n1, w, C, lane_sqrt(dot(r, r)))))
    s1, c1 = keep(free1, kept1, s1, c1)
    g = sub(add(turn(n1, -s1, c1, v), p1), C)
    h = dot(r, n3)
    b = blend(1.0, r, -h, n3)
    level = dot(n2, g)
    s3, c3, real = simple_root(h * dot(n2, n3), dot(n2, b), dot(n2, cross(n3, b)), level, second, soft)
    miss = lane_max(
        miss, missing(real, lane_max(level - h * dot(n2, n3), h * dot(n2, n3) - level) - lane_sqrt(dot(b, b)))
    )
    s2, c2, free2 = ratio(n2, turn(n3, s3, c3, r), g)
    s2, c2 = keep(free2, kept2, s2, c2)
    return (s1, c1, s2, c2, s3, c3), miss, lane_max(free1, free2)


@jit
def arm3_meeting_12(arm, w, first, second, kept1):
    """The same where axes 1, 2 meet in C: q3 by the distance from C, q2 by the height along axis 1, q1 by the angle."""
    n1, n2, n3, p3, W, C = row(arm, 0), row(arm, 1), row(arm, 2), row(arm, 8), row(arm, 17), row(arm, 18)
    soft = arm[16, 2]
    g = sub(w, C)
    s3, c3, real = elbow_root(p3, n3, W, C, dot(g, g), second, soft)
    miss = missing(real, reach_gap(p3, n3, W, C, lane_sqrt(dot(g, g))))
    y = sub(add(turn(n3, s3, c3, sub(W, p3)), p3), C)
    h = dot(y, n2)
    b = blend(1.0, y, -h, n2)
    level, middle = dot(n1, g), h * dot(n1, n2)
    s2, c2, real = simple_root(middle, dot(n1, b), dot(n1, cross(n2, b)), level, first, soft)
    miss = lane_max(miss, missing(real, lane_max(level - middle, middle - level) - lane_sqrt(dot(b, b))))
    s1, c1, free1 = ratio(n1, turn(n2, s2, c2, y), g)
    s1, c1 = keep(free1, kept1, s1, c1)
    return (s1, c1, s2, c2, s3, c3), miss, free1


@jit
def arm3_parallel_12(arm, w, first, second, kept1):
    """The same where axes 1, 2 are parallel: q3 by the height along them, q2 by the distance from axis 1, q1 by the angle."""
    n1, n2, n3, p1, p2, p3, W = (
        row(arm, 0), row(arm, 1), row(arm, 2), row(arm, 6), row(arm, 7), row(arm, 8), row(arm, 17),
    )  # fmt: skip
    soft = arm[16, 2]
    v = sub(W, p3)
    h = dot(v, n3)
    b = blend(1.0, v, -h, n3)
    level = dot(n1, sub(w, p3))
    s3, c3, real = simple_root(h * dot(n1, n3), dot(n1, b), dot(n1, cross(n3, b)), level, second, soft)
    miss = missing(real, abs(level - h * dot(n1, n3)) - lane_sqrt(dot(b, b)))
    y = add(turn(n3, s3, c3, v), p3)
    g = sub(w, p1)
    g = blend(1.0, g, -dot(g, n1), n1)
    foot = add(p1, scale(dot(sub(y, p1), n1), n1))
    s2, c2, real = elbow_root(p2, n2, y, foot, dot(g, g), first, soft)
    miss = lane_max(miss, missing(real, reach_gap(p2, n2, y, foot, lane_sqrt(dot(g, g)))))
    s1, c1, free1 = ratio(n1, sub(add(turn(n2, s2, c2, sub(y, p2)), p2), p1), g)
    s1, c1 = keep(free1, kept1, s1, c1)
    return (s1, c1, s2, c2, s3, c3), miss, free1


@jit
def parallel6(arm, limits, motors, seeds, Q, valid, gap, free):
    """Axes 2, 3, 4 parallel and axes 5, 6 meeting in W (the UR family): rows (shoulder, wrist, elbow) of Q (m, 8, 6).
    Point: W.
    """
    n1, n, n5, n6 = row(arm, 0), row(arm, 1), row(arm, 4), row(arm, 5)
    p1, p2, p3, p4, W = row(arm, 6), row(arm, 7), row(arm, 8), row(arm, 9), row(arm, 17)
    shoulder, wrist, elbow = load_lanes(SIGNS, 0, EIGHT), load_lanes(SIGNS, 8, EIGHT), load_lanes(SIGNS, 16, EIGHT)
    # Axes 3 and 4 may point against axis 2.
    way3, way4 = math.copysign(1.0, dot(n, row(arm, 2))), math.copysign(1.0, dot(n, row(arm, 3)))
    soft = arm[16, 2]
    x = any_normal(n)
    foot = add(p2, scale(dot(sub(p4, p2), n), n))
    level, middle = dot(n, sub(W, p1)), dot(n, n5) * dot(n5, n6)
    flat = Q.reshape(-1)
    for i in range(motors.shape[0]):
        R, t = load_pose(motors, i, arm, 6)
        v = sub(add(times(R, W), t), p1)
        h = dot(v, n1)
        b = blend(1.0, v, -h, n1)
        s1, c1, near = simple_root(h * dot(n1, n), dot(n, b), -dot(n, cross(n1, b)), level, shoulder, soft)
        miss = missing(near, abs(level) - lane_sqrt(dot(b, b)))
        R1 = product(turn_matrix(n1, -s1, c1), R)  # rotation of joints 2 to 6
        m = times_t(R1, n)  # the parallel axes, seen from the tool
        across = cross(n6, m)
        rest = dot(across, across) - dot(n, n5) * dot(n, n5) - dot(n5, n6) * dot(n5, n6) + 2.0 * middle * dot(m, n6)
        s5, c5, bends = root(middle, dot(n, n6) - middle, dot(n, cross(n5, n6)), dot(m, n6), rest, wrist, soft)
        # R1^T n = turn(n6, -q6) turn(n5, -q5) n
        s6, c6, kept = ratio(n6, m, turn(n5, -s5, c5, n))
        kept = lane_where_lt(dot(across, across), ALIGNED * ALIGNED, 1.0, kept)
        s6, c6 = keep(kept, seeded(seeds, i, 5, arm, 6), s6, c6)
        R24 = product(R1, transposed(product(turn_matrix(n5, s5, c5), turn_matrix(n6, s6, c6))))
        s, c, _ = ratio(n, x, times(R24, x))  # q2 + q3 + q4
        # Where joint 4 has to be, in the plane across the parallel axes.
        goal = sub(add(add(turn(n1, -s1, c1, v), p1), turn(n, s, c, sub(p4, W))), p2)
        goal = blend(1.0, goal, -dot(goal, n), n)
        s3, c3, real = elbow_root(p3, n, p4, foot, dot(goal, goal), elbow, soft)
        miss = lane_max(miss, missing(real, reach_gap(p3, n, p4, foot, lane_sqrt(dot(goal, goal)))))
        s2, c2, kept2 = ratio(n, sub(add(turn(n, s3, c3, sub(p4, p3)), p3), p2), goal)
        s2, c2 = keep(kept2, seeded(seeds, i, 1, arm, 6), s2, c2)
        sp, cp = s2 * c3 + c2 * s3, c2 * c3 - s2 * s3
        s4, c4 = s * cp - c * sp, c * cp + s * sp
        q = angles6((s1, s2, way3 * s3, way4 * s4, s5, s6), (c1, c2, c3, c4, c5, c6), limits, arm[16, 0] > 0.5)
        store_records(flat, 8 * i, q)
        store_flags(lane_min(lane_min(near, bends), real), lane_max(kept, kept2), i, valid, free)
        gap[i] = min_lane(miss)
