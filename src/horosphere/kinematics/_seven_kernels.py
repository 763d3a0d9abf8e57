"""Seven-joint arms with spherical shoulder: all 8 branches at a given redundancy, and the best redundancy of each.

`arm` as in `_screw_kernels.py`; the 8 branches of a pose are the lanes of one vector. `motors` (m, 8) are poses of the tip in
the base frame; `limits` (2, n) move an angle by a turn where only that is inside. Results are in the robot's order of joints,
also where the chain is solved from its tip.
"""

import math

from ..kernels import (
    EIGHT,
    jit,
    lane_mask_lt,
    lane_max,
    lane_min,
    lane_sqrt,
    lane_where_lt,
    load_lanes,
    min_lane,
    spread,
    store_records,
)
from ._screw_kernels import (
    FREE,
    SIGNS,
    TINY,
    TOUCH,
    add,
    any_normal,
    blend,
    cross,
    decompose,
    dot,
    either,
    elbow_root,
    frame,
    inside,
    load_pose,
    missing,
    normalised,
    product,
    ratio,
    reach_gap,
    row,
    seeded,
    settled,
    sine_cosine,
    store_flags,
    sub,
    times,
    times_t,
    transposed,
    turn,
    turn_matrix,
)

_sine_cosine = sine_cosine.inline
SEW7, SRS7 = None, 1  # numba prunes tests on None: only the form that is asked for is compiled
STEPS = 20  # of the search around the best sample: its step shrinks to 0.6^10 of a sample's width


@jit
def sew7_rows(arm, limits, pose, last, kept1, kept5):
    """Spherical shoulder S (axes 1-3), axes 5 and 6 meeting in W, angle 7 given: rows (elbow, wrist, shoulder).

    Points: S, W. pose: rotation and translation of link 7. last: (sine, cosine) lanes of angle 7, in the chain's sense. kept1,
    kept5: the same of angles 1 and 5, where they are free. Returns the angles, `good`, free, and the metres by which |S W|
    misses its range.
    """
    R, t = pose
    soft = arm[18, 2]
    n1, n2, n3, n4, n5, n6, n7 = (
        row(arm, 0), row(arm, 1), row(arm, 2), row(arm, 3), row(arm, 4), row(arm, 5), row(arm, 6),
    )  # fmt: skip
    p4, p7, S, W = row(arm, 10), row(arm, 13), row(arm, 19), row(arm, 20)
    elbow, wrist, shoulder = load_lanes(SIGNS, 0, EIGHT), load_lanes(SIGNS, 8, EIGHT), load_lanes(SIGNS, 16, EIGHT)
    c56 = dot(n5, n6)
    s7, c7 = last
    R6 = product(R, turn_matrix(n7, -s7, c7))  # link 6, before joint 7
    w = add(times(R, add(turn(n7, -s7, c7, sub(W, p7)), p7)), t)
    m6 = times(R6, n6)
    u = sub(S, w)
    length2, u6 = dot(u, u), dot(u, m6)
    v = cross(m6, u)
    across = dot(v, v)
    s4, c4, near = elbow_root(p4, n4, W, S, length2, elbow, soft)
    gap = min_lane(missing(near, reach_gap(p4, n4, W, S, lane_sqrt(length2))))
    u0 = sub(S, add(turn(n4, s4, c4, sub(W, p4)), p4))  # S seen from W, and axis 5, in the frame of link 3
    m5 = turn(n4, s4, c4, n5)
    z = dot(u0, m5)
    off = cross(m5, u0)
    # n5 with n5.u = z, n5.n6 = c56; the remainder from the distance of S to axis 5, not from |u|^2 - z^2
    away = dot(off, off)
    rest = (1.0 - c56 * c56) * away - (u6 - c56 * z) * (u6 - c56 * z)
    good = lane_where_lt(0.0, across, lane_min(near, rest + (TOUCH + soft) * length2), -1.0)
    inverse = 1.0 / lane_max(across, TINY)
    bend = wrist * lane_sqrt(lane_max(rest, lane_min(-rest, soft * length2))) * inverse
    base = blend((z - c56 * u6) * inverse, u, (c56 * length2 - z * u6) * inverse, m6)
    R3 = product(frame(u, blend(1.0, base, bend, v)), transposed(frame(u0, m5)))
    if lane_mask_lt(away, FREE * FREE) != 0:  # S on axis 5: the arm plane is free; keep q5
        fifth = turn(n4, s4, c4, turn(n5, kept5[0], kept5[1], n6))
        other = product(frame(u, m6), transposed(frame(u0, fifth)))
        first = either(away, FREE * FREE, other[:3], R3[:3])
        second = either(away, FREE * FREE, other[3:6], R3[3:6])
        R3 = first + second + either(away, FREE * FREE, other[6:], R3[6:])
    R4 = product(R3, turn_matrix(n4, s4, c4))
    s5, c5, _ = ratio(n5, n6, times_t(R4, m6))
    x6 = any_normal(n6)
    y6 = turn(n5, -s5, c5, times_t(R4, times(R6, x6)))
    (s1, c1, s2, c2, s3, c3), real, loose = decompose(n1, n2, n3, R3, shoulder, kept1, soft)
    good = lane_min(good, real)
    sines = s1, s2, s3, s4, s5, dot(cross(x6, y6), n6), s7
    q = angles7(sines, (c1, c2, c3, c4, c5, dot(x6, y6), c7), limits, arm[18, 0] > 0.5)
    return q, good, lane_where_lt(away, FREE * FREE, 1.0, loose), gap


@jit
def srs7_rows(arm, limits, pose, psi, kept1, kept5):
    """Spherical shoulder S (axes 1-3) and wrist W (axes 5-7), elbow angle psi given: rows (shoulder, elbow, wrist).

    Points: S, W, E (the foot of S on axis 4). psi (sine, cosine) turns E about the line S-W from the side of axis 1 (of any
    fixed normal of it where S-W is parallel to axis 1). Otherwise as `sew7_rows`.
    """
    R, t = pose
    soft = arm[18, 2]
    n1, n2, n3, n4, n5, n6, n7 = (
        row(arm, 0), row(arm, 1), row(arm, 2), row(arm, 3), row(arm, 4), row(arm, 5), row(arm, 6),
    )  # fmt: skip
    p4, S, W, E = row(arm, 10), row(arm, 19), row(arm, 20), row(arm, 21)
    shoulder, elbow, wrist = load_lanes(SIGNS, 0, EIGHT), load_lanes(SIGNS, 8, EIGHT), load_lanes(SIGNS, 16, EIGHT)
    w = sub(add(times(R, W), t), S)
    length2 = dot(w, w)
    s4, c4, good = elbow_root(p4, n4, W, S, length2, elbow, soft)
    gap = missing(good, reach_gap(p4, n4, W, S, lane_sqrt(length2)))
    u = normalised(w)
    r = cross(n1, u)
    side = normalised(cross(either(dot(r, r), 1e-18, any_normal(n1), n1), u))
    r = cross(u, side)
    s, c = psi
    w0 = sub(add(turn(n4, s4, c4, sub(W, p4)), p4), S)
    e0 = sub(E, S)
    lever, enough = cross(w0, e0), FREE * FREE * length2 * dot(e0, e0)
    flat = dot(lever, lever)
    F0 = frame(w0, either(flat, enough, cross(n4, w0), e0))
    R3 = product(frame(u, blend(c, r, s, cross(u, r))), transposed(F0))
    R57 = product(transposed(product(R3, turn_matrix(n4, s4, c4))), R)
    (s1, c1, s2, c2, s3, c3), real1, free1 = decompose(n1, n2, n3, R3, shoulder, kept1, soft)
    (s5, c5, s6, c6, s7, c7), real5, free5 = decompose(n5, n6, n7, R57, wrist, kept5, soft)
    good = lane_min(lane_min(real1, real5), good)
    q = angles7((s1, s2, s3, s4, s5, s6, s7), (c1, c2, c3, c4, c5, c6, c7), limits, arm[18, 0] > 0.5)
    return q, good, lane_where_lt(flat, enough, 1.0, lane_max(free1, free5)), gap


@jit
def angles7(s, c, limits, turned):
    """The seven angles of sines and cosines, in the robot's order and near its limits."""
    if turned:
        s, c = (-s[6], -s[5], -s[4], -s[3], -s[2], -s[1], -s[0]), (c[6], c[5], c[4], c[3], c[2], c[1], c[0])
    return (
        settled(s[0], c[0], limits[0, 0], limits[1, 0]),
        settled(s[1], c[1], limits[0, 1], limits[1, 1]),
        settled(s[2], c[2], limits[0, 2], limits[1, 2]),
        settled(s[3], c[3], limits[0, 3], limits[1, 3]),
        settled(s[4], c[4], limits[0, 4], limits[1, 4]),
        settled(s[5], c[5], limits[0, 5], limits[1, 5]),
        settled(s[6], c[6], limits[0, 6], limits[1, 6]),
    )


@jit
def rows7(kind, arm, limits, pose, value, kept1, kept5):
    """All rows at lanes of the redundancy `value`: q7 (q1 of a chain solved from its tip) or psi."""
    s, c = _sine_cosine(value)
    if kind is not None:
        return srs7_rows(arm, limits, pose, (s, c), kept1, kept5)
    turned = arm[18, 0] > 0.5
    q, good, free, gap = sew7_rows(arm, limits, pose, (-s if turned else s, c), kept1, kept5)
    if turned:  # the given angle to its last bit
        return (inside(value, limits[0, 0], limits[1, 0]),) + q[1:], good, free, gap
    return q[:6] + (inside(value, limits[0, 6], limits[1, 6]),), good, free, gap


@jit
def seven(kind, arm, limits, motors, value, seeds, Q, valid, gap, free):
    """Rows Q (m, 8, 7) at the redundancies value (m,). gap (m,): metres by which the wrist is out of reach. free (m, 8): an
    angle was kept from the seed.
    """
    flat = Q.reshape(-1)
    for i in range(motors.shape[0]):
        x = value[i] - 2.0 * math.pi * math.floor(value[i] / (2.0 * math.pi) + 0.5)
        at = spread(value[i] if abs(value[i]) <= math.pi else x, EIGHT)
        kept1, kept5 = seeded(seeds, i, 0, arm, 7), seeded(seeds, i, 4, arm, 7)
        q, good, loose, gap[i] = rows7(kind, arm, limits, load_pose(motors, i, arm, 7), at, kept1, kept5)
        store_records(flat, 8 * i, q)
        store_flags(good, loose, i, valid, free)
