"""A position alone for the arms of kind us5: all branches at a given elbow angle and last joint, and the roomiest posture of each.

`arm` (8, 3): five unit axes, S (axes 1, 2), and seen from the joints' centres at q = 0: E - S, the tool point - E (axes 3 to 5
meet in E). The four branches of a target are the lanes of one vector; everything else as in `_seven_kernels.py`.
"""

import math

from ..kernels import (
    jit,
    lane_max,
    lane_min,
    lane_sqrt,
    lane_where_lt,
    load_lanes,
    max_lane,
    spread,
    store_lanes,
    store_records,
)
from ._screw_kernels import (
    SIGNS,
    angle_of,
    any_normal,
    blend,
    cross,
    dot,
    inside,
    margin5,
    normalised,
    product,
    ratio,
    root,
    row,
    scale,
    settled,
    sine_cosine,
    store_flags,
    sub,
    times_t,
    turn,
    turn_matrix,
)

FOUR = (0,) * 4
CLOSE = 1e-12  # of a length, missing: taken for rounding
STEPS = 24  # of each of the two searches around the best sample: a step shrinks to 0.6^12 of a sample's width
_sine_cosine, _angle = sine_cosine.inline, angle_of.inline


@jit
def point_rows(arm, limits, p, psi, last, kept, fit):
    """Rows (shoulder, wrist) at lanes of psi and of the last angle: the angles, good (shoulder), good (wrist), free, metres missing.

    The elbow E stands on the circle that the spheres of radius |E - S| about S and |tool - E| about p have in common, at psi
    from the side of axis 1 (of any fixed normal of it, where S-p is parallel to it). A point out of reach is replaced by the
    nearest one on its line from S. kept: (sine, cosine) of angles 1, 3 where they are free.
    fit: 1 to move the last angle to the nearest at which a wrist exists (`wrist_fit`).
    """
    n1, n2, n3, n4, n5 = row(arm, 0), row(arm, 1), row(arm, 2), row(arm, 3), row(arm, 4)
    S, v, hand = row(arm, 5), row(arm, 6), row(arm, 7)
    shoulder, wrist = load_lanes(SIGNS, 8, FOUR), load_lanes(SIGNS, 16, FOUR)
    r2, h2 = dot(v, v), dot(hand, hand)
    r, h = math.sqrt(r2), math.sqrt(h2)
    d = sub(p, S)
    distance = math.sqrt(dot(d, d))
    reach = min(max(distance, abs(r - h)), r + h)
    gap = abs(distance - reach)
    u = scale(1.0 / distance, d) if distance > 0.0 else n1
    along = (reach * reach + (r - h) * (r + h)) / (2.0 * reach) if reach > 0.0 else 0.0
    rest = (r + h - reach) * (r + h + reach) * (reach - (r - h)) * (reach + (r - h))
    across = math.sqrt(max(rest, 0.0)) / (2.0 * reach) if reach > 0.0 else r
    side = cross(n1, u)
    side = normalised(side if dot(side, side) > 1e-18 else cross(any_normal(n1), u))
    s, c = _sine_cosine(psi)
    out = cross(u, side)
    e = blend(along, u, across, blend(c, out, s, cross(u, out)))
    # q2 by the height of E along axis 1, q1 by the angle.
    s2, c2, good = cone_root(n1, n2, v, e, shoulder)
    s1, c1, free1 = ratio(n1, turn(n2, s2, c2, v), e)
    s1, c1 = lane_where_lt(0.5, free1, kept[0], s1), lane_where_lt(0.5, free1, kept[1], c1)
    # The same of the tool point about axis 3, seen from link 2.
    x = times_t(product(turn_matrix(n1, s1, c1), turn_matrix(n2, s2, c2)), sub(scale(reach, u), e))
    if fit:
        last = wrist_fit(n3, n4, n5, hand, x, last)
    s5, c5 = _sine_cosine(last)
    w = turn(n5, s5, c5, hand)
    s4, c4, fits = cone_root(n3, n4, w, x, wrist)
    s3, c3, free3 = ratio(n3, turn(n4, s4, c4, w), x)
    s3, c3 = lane_where_lt(0.5, free3, kept[2], s3), lane_where_lt(0.5, free3, kept[3], c3)
    q = (
        settled(s1, c1, limits[0, 0], limits[1, 0]),
        settled(s2, c2, limits[0, 1], limits[1, 1]),
        settled(s3, c3, limits[0, 2], limits[1, 2]),
        settled(s4, c4, limits[0, 3], limits[1, 3]),
        inside(last, limits[0, 4], limits[1, 4]),
    )
    return q, good, fits, lane_max(free1, free3), gap


@jit
def cone_root(n1, n2, v, x, sign):
    """(sine, cosine) of the angle about n2 that brings v to the height n1 . x, |v| = |x|, and `good`.

    The two cones about n1 and n2 meet where |n1 x x| |n1 x n2| is at least |n2 . v - (n1 . n2)(n1 . x)|. From this difference come
    the remainder and `good`, not from squares: it is a length, of which a position may miss no more than it.
    """
    alpha, height, level = dot(n1, n2), dot(n2, v), dot(n1, x)
    y, z = cross(n1, x), cross(n1, n2)
    wide, off = lane_sqrt(dot(y, y) * dot(z, z)), height - alpha * level
    off = lane_max(off, -off)
    b = blend(1.0, v, -height, n2)
    s, c, _ = root(height * alpha, dot(n1, b), dot(n1, cross(n2, b)), level, (wide - off) * (wide + off), sign, 0.0)
    return s, c, wide - off + CLOSE * lane_sqrt(dot(v, v))


@jit
def wrist_fit(n3, n4, n5, hand, x, last):
    """The angle of joint 5 nearest to `last` in [-pi, pi] at which joints 3, 4 can bring the tool point to x.

    That is where n4 . w is at most |n3 x x| |n3 x n4| from (n3 . x)(n3 . n4), w the tool point before joint 5: two arcs about the
    angle phi at which n4 . w is largest. At the ends of the reach they are very short.
    """
    along = dot(n5, hand)
    f0 = along * dot(n4, n5)
    f1, f2 = dot(n4, hand) - f0, dot(n4, cross(n5, hand))
    size = math.hypot(f1, f2)
    if size * size <= 1e-24 * dot(hand, hand):
        return last
    phi = math.atan2(f2, f1)
    y, z = cross(n3, x), cross(n3, n4)
    middle, half = dot(n3, x) * dot(n3, n4), lane_sqrt(dot(y, y) * dot(z, z))
    high = lane_max(lane_min((middle + half - f0) / size, 1.0), -1.0)
    low = lane_max(lane_min((middle - half - f0) / size, 1.0), -1.0)
    (first,) = _angle(lane_sqrt((1.0 - high) * (1.0 + high)), high)
    (final,) = _angle(lane_sqrt((1.0 - low) * (1.0 + low)), low)
    d = _turned(last - phi)
    size5 = lane_min(lane_max(lane_max(d, -d), first), final)
    return _turned(phi + lane_where_lt(d, 0.0, -size5, size5))


@jit
def _turned(x):
    """Angles in [-2 pi, 2 pi] brought into [-pi, pi]."""
    return lane_where_lt(math.pi, x, x - 2.0 * math.pi, lane_where_lt(x, -math.pi, x + 2.0 * math.pi, x))


@jit
def kept13(seeds, i):
    """Sine and cosine of the seed's angles 1 and 3."""
    return math.sin(seeds[i, 0]), math.cos(seeds[i, 0]), math.sin(seeds[i, 2]), math.cos(seeds[i, 2])


@jit
def point5(arm, limits, points, psi, last, seeds, slack, Q, valid, stands, gap, free):
    """Rows Q (m, 4, 5) at psi, last (m,). stands (m, 4): the shoulder's part of `valid`. gap (m,): metres out of reach."""
    flat = Q.reshape(-1)
    for i in range(points.shape[0]):
        at, roll = spread(psi[i], FOUR), spread(last[i], FOUR)
        q, good, fits, loose, gap[i] = point_rows(arm, limits, row(points, i), at, roll, kept13(seeds, i), False)
        good = lane_min(good, slack - gap[i])
        store_records(flat, 4 * i, q)
        store_flags(good, loose, i, stands, free)
        store_flags(lane_min(good, fits), loose, i, valid, free)


@jit
def best_point5(arm, limits, points, ranges, samples, seeds, slack, Q, valid, gap, free, value):
    """For every branch of every target the psi and last angle, value (2, m, 4), that keep the joints farthest from their limits.

    ranges (m, 4): low and high of psi, of the last angle (in [-2 pi, 2 pi]); equal ends: given. For each psi the best last angle is
    searched, by even samples and shrinking steps around the best; psi likewise, twice as densely, and 16 times where nothing is
    inside the limits.
    """
    flat, psis, lasts = Q.reshape(-1), value[0].reshape(-1), value[1].reshape(-1)
    for i in range(points.shape[0]):
        low, high, low5, high5 = ranges[i, 0], ranges[i, 1], ranges[i, 2], ranges[i, 3]
        p, kept = row(points, i), kept13(seeds, i)
        rolls = samples if high5 > low5 else 1
        at, at5 = spread(0.5 * (low + high), FOUR), spread(0.5 * (low5 + high5), FOUR)
        top = spread(-math.inf, FOUR)
        for fine in range(2):
            if fine == 1 and (max_lane(top) >= 0.0 or high == low):
                break
            turns = 1 if high == low else 2 * samples if fine == 0 else 16 * samples
            width = (high - low) / turns
            step = width
            for trial in range(turns + (STEPS if high > low else 0) + 1):
                final = trial == turns + (STEPS if high > low else 0)
                if trial < turns:
                    here = spread(low + (trial + 0.5) * step, FOUR)
                elif final:
                    here = at
                else:
                    width *= 0.6 if (trial - turns) % 2 == 0 else -1.0
                    here = lane_min(lane_max(at + width, low), high)
                top5, best5 = spread(-math.inf, FOUR), at5
                width5 = (high5 - low5) / rolls
                step5 = width5
                for inner in range(1 if final else rolls + (STEPS if rolls > 1 else 0)):
                    if final:
                        here5 = at5
                    elif inner < rolls:
                        here5 = spread(low5 + (inner + 0.5) * step5, FOUR)
                    else:
                        width5 *= 0.6 if (inner - rolls) % 2 == 0 else -1.0
                        here5 = lane_min(lane_max(best5 + width5, low5), high5)
                    q, good, fits, loose, miss = point_rows(arm, limits, p, here, _turned(here5), kept, rolls > 1)
                    good = lane_min(good, fits)
                    if final:
                        gap[i] = miss
                        store_records(flat, 4 * i, q)
                        store_lanes(psis, 4 * i, at)
                        store_lanes(lasts, 4 * i, at5)
                        store_flags(lane_min(good, slack - miss), loose, i, valid, free)
                        break
                    margin = lane_where_lt(good, 0.0, -math.inf, margin5(q, limits))
                    best5, top5 = lane_where_lt(top5, margin, here5, best5), lane_max(top5, margin)
                at5, at = lane_where_lt(top, top5, best5, at5), lane_where_lt(top, top5, here, at)
                top = lane_max(top, top5)
