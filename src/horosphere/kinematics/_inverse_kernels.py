"""Closed-form inverse kinematics of arms known by their screw axes: compiled loops, one class of arm each.

An arm is one array (k, 3), rows: n unit axes and n points on them at q = 0 in the base frame; rotation (3) and
translation of the inverse home pose; (1 if the chain is solved from its tip, a number, 0); points fixed in links, as
each solver says. `motors` (m, 8) are poses of the tip in the base frame, `limits` (2, n) move an angle by a turn
where only that is inside. Results are in the robot's order of joints, also where the chain is solved reversed.
Vectors are tuples of three numbers. Everything reduces to three steps: the roots of A + B cos q + C sin q = l, the
angle about an axis that takes one vector to another (the ratio formula), and the decomposition of a rotation about
three axes. Our derivation; docs/inverse-kinematics.md.
"""

import math

import numpy as np

from ..kernels import jit

_FREE = 1e-10  # sine below which an angle is free and kept from the seed
_TOUCH = 3e-11  # relative overshoot of a double root that is taken for rounding (axes of URDF files are off by 3e-12)
_ALIGNED = (
    2e-11  # sine between the outer axes of three below which the first angle is kept; it costs as much in the pose
)


@jit
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@jit
def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@jit
def add(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@jit
def sub(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@jit
def scale(s, a):
    return s * a[0], s * a[1], s * a[2]


@jit
def blend(s, a, t, b):
    """s a + t b."""
    return s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]


@jit
def row(x, i):
    return x[i, 0], x[i, 1], x[i, 2]


@jit
def times(R, x):
    """R x of a matrix as nine numbers, rows first."""
    return (
        R[0] * x[0] + R[1] * x[1] + R[2] * x[2],
        R[3] * x[0] + R[4] * x[1] + R[5] * x[2],
        R[6] * x[0] + R[7] * x[1] + R[8] * x[2],
    )


@jit
def times_t(R, x):
    """R^T x."""
    return (
        R[0] * x[0] + R[3] * x[1] + R[6] * x[2],
        R[1] * x[0] + R[4] * x[1] + R[7] * x[2],
        R[2] * x[0] + R[5] * x[1] + R[8] * x[2],
    )


@jit
def product(A, B):
    """A B of matrices as nine numbers."""
    x, y, z = times(A, (B[0], B[3], B[6])), times(A, (B[1], B[4], B[7])), times(A, (B[2], B[5], B[8]))
    return x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]


@jit
def transposed(A):
    return A[0], A[3], A[6], A[1], A[4], A[7], A[2], A[5], A[8]


@jit
def turn_matrix(n, s, c):
    """Rotation about the unit vector n by the angle with sine s and cosine c."""
    x, y, z = n
    k = 1.0 - c
    return (
        c + k * x * x, k * x * y - s * z, k * x * z + s * y,
        k * x * y + s * z, c + k * y * y, k * y * z - s * x,
        k * x * z - s * y, k * y * z + s * x, c + k * z * z,
    )  # fmt: skip


@jit
def turn(n, s, c, x):
    """x turned about the unit vector n by the angle with sine s and cosine c."""
    k = (1.0 - c) * dot(n, x)
    w = cross(n, x)
    return c * x[0] + s * w[0] + k * n[0], c * x[1] + s * w[1] + k * n[1], c * x[2] + s * w[2] + k * n[2]


@jit
def load_pose(motors, i, arm, n):
    """Rotation (nine numbers) and translation of exp(S1 q1) ... exp(Sn qn): motor row times inverse home pose, or its
    inverse.
    """
    w, x, y, z = motors[i, 0], -motors[i, 3], motors[i, 2], -motors[i, 1]
    a, b = (motors[i, 4], motors[i, 5], motors[i, 6]), motors[i, 7]
    u = cross((x, y, z), a)
    t = (
        2.0 * (b * x - w * a[0] - u[0]),
        2.0 * (b * y - w * a[1] - u[1]),
        2.0 * (b * z - w * a[2] - u[2]),
    )
    R = (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip
    t = add(times(R, row(arm, 2 * n + 3)), t)
    r1, r2, r3 = row(arm, 2 * n), row(arm, 2 * n + 1), row(arm, 2 * n + 2)
    R = product(R, (r1[0], r1[1], r1[2], r2[0], r2[1], r2[2], r3[0], r3[1], r3[2]))
    if arm[2 * n + 4, 0] > 0.5:
        R = transposed(R)
        t = scale(-1.0, times(R, t))
    return R, t


@jit
def settle(q, limits, turned):
    """Angles of one row brought into the robot's order, (-pi, pi], and moved by a turn where only that is inside the
    limits.
    """
    n = q.shape[0]
    if turned:
        for j in range(n // 2):
            q[j], q[n - 1 - j] = q[n - 1 - j], q[j]
        for j in range(n):
            q[j] = -q[j]
    for j in range(n):
        x = q[j]
        if x > math.pi or x <= -math.pi:
            x -= 2.0 * math.pi * math.ceil((x - math.pi) / (2.0 * math.pi))
        if x < limits[0, j] and limits[0, j] <= x + 2.0 * math.pi <= limits[1, j]:
            x += 2.0 * math.pi
        elif x > limits[1, j] and limits[0, j] <= x - 2.0 * math.pi <= limits[1, j]:
            x -= 2.0 * math.pi
        q[j] = x


@jit
def seeded(seeds, i, j, arm, n):
    """The seed of the chain's angle j (of the reversed chain: minus the one from the other end)."""
    return -seeds[i, n - 1 - j] if arm[2 * n + 4, 0] > 0.5 else seeds[i, j]


@jit
def ratio(n, x, y):
    """(sine, cosine, free) of the angle about the unit vector n that takes x to y; free where x or y lies along n.

    Both from cross products: y.x - (n.x)(n.y) would lose the angle of nearly parallel vectors (error eps / sin^2).
    """
    p, r = cross(n, x), cross(n, y)
    s, c = dot(cross(p, r), n), dot(p, r)
    h = math.sqrt(s * s + c * c)
    if h <= _ALIGNED * _ALIGNED:
        return 0.0, 1.0, True
    return s / h, c / h, h <= _ALIGNED * math.sqrt(dot(p, p)) or h <= _ALIGNED * math.sqrt(dot(r, r))


@jit
def roots(offset, b, c, level, rest):
    """(sine, cosine) of both roots of offset + b cos q + c sin q = level, and whether they are real.

    rest = b^2 + c^2 - (level - offset)^2, given by the caller in a form without cancellation.
    """
    h2 = b * b + c * c
    real = rest >= -_TOUCH * h2 and h2 > 0.0
    w = math.sqrt(max(rest, 0.0))
    g = level - offset
    k = 1.0 / math.sqrt(max(g * g + w * w, 1e-300) * max(h2, 1e-300))  # equals 1 / h^2 where real
    return (c * g + b * w) * k, (b * g - c * w) * k, (c * g - b * w) * k, (b * g + c * w) * k, real


@jit
def simple_roots(offset, b, c, level):
    """`roots` with the plain factorised remainder."""
    h, g = math.sqrt(b * b + c * c), level - offset
    return roots(offset, b, c, level, (h - g) * (h + g))


@jit
def any_normal(n):
    """A unit vector perpendicular to the unit vector n."""
    x = cross(n, (1.0, 0.0, 0.0)) if abs(n[0]) < 0.7 else cross(n, (0.0, 1.0, 0.0))
    return scale(1.0 / math.sqrt(dot(x, x)), x)


@jit
def normalised(x):
    """x / |x|, and |x|."""
    h = math.sqrt(dot(x, x))
    return scale(1.0 / max(h, 1e-300), x), h


@jit
def decompose(n1, n2, n3, R, which, kept, q, j):
    """Angles q[j..j+2] with turn(n1) turn(n2) turn(n3) = R; `which` 0 or 1 chooses the middle root. Returns (real,
    free).

    kept: the first angle to keep where the outer axes coincide; the third is then taken relative to it.
    """
    alpha, gamma = dot(n1, n2), dot(n2, n3)
    r3 = times(R, n3)
    level = dot(n1, r3)
    w = cross(n1, r3)
    offset = alpha * gamma
    # (1 - alpha^2)(1 - gamma^2) - (level - offset)^2 with 1 - level^2 = |n1 x r3|^2: exact where n1, n2, n3 are at
    # right angles
    rest = dot(w, w) - alpha * alpha - gamma * gamma + 2.0 * offset * level
    s2, c2, s2_, c2_, real = roots(offset, dot(n1, n3) - offset, dot(n1, cross(n2, n3)), level, rest)
    if which == 1:
        s2, c2 = s2_, c2_
    s1, c1, free = ratio(n1, turn(n2, s2, c2, n3), r3)
    if free or dot(w, w) < _ALIGNED * _ALIGNED:
        s1, c1, free = math.sin(kept), math.cos(kept), True
    x = any_normal(n3)
    y = turn(n2, -s2, c2, turn(n1, -s1, c1, times(R, x)))
    s3, c3, _ = ratio(n3, x, y)
    q[j], q[j + 1], q[j + 2] = math.atan2(s1, c1), math.atan2(s2, c2), math.atan2(s3, c3)
    return real, free


@jit
def other_root(n1, n2, n3, R, kept, q, k, other, j, square, twice):
    """The second root of `decompose` into row `other` of q, where row k holds the first.

    Axes at right angles (`square`): the outer angles turn by pi, the middle one to `twice` minus itself. Returns (real, free).
    """
    if square:
        q[other, j], q[other, j + 1], q[other, j + 2] = q[k, j] + math.pi, twice - q[k, j + 1], q[k, j + 2] + math.pi
        return True, False
    return decompose(n1, n2, n3, R, 1, kept, q[other], j)


@jit
def right_angles(n1, n2, n3):
    """Whether n1, n2 and n2, n3 are at right angles (to 1e-11), and the sum of both middle roots of `decompose`."""
    square = abs(dot(n1, n2)) < 1e-11 and abs(dot(n2, n3)) < 1e-11
    return square, 2.0 * math.atan2(dot(n1, cross(n2, n3)), dot(n1, n3))


@jit
def frame(a, b):
    """Columns unit a, the part of b across it, and their cross product, as nine numbers; and the sine between a and b."""
    x, _ = normalised(a)
    z, h = normalised(cross(x, b))
    y = cross(z, x)
    return (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]), h


@jit
def elbow_roots(p, n, x, fixed, r2):
    """Both angles (sine, cosine) about the axis (p, n) that bring x to the distance sqrt(r2) from `fixed`, and real."""
    v = sub(x, p)
    along = dot(v, n)
    b = blend(1.0, v, -along, n)
    centre = add(sub(p, fixed), scale(along, n))
    c = cross(n, b)
    return simple_roots(dot(centre, centre) + dot(b, b), 2.0 * dot(centre, b), 2.0 * dot(centre, c), r2)


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
            good = near and rest >= -_TOUCH * length2 and across > 0.0
            inverse = 1.0 / max(across, 1e-300)
            base = blend((z - c56 * u6) * inverse, u, (c56 * length2 - z * u6) * inverse, m6)
            bend = math.sqrt(max(rest, 0.0)) * inverse
            on_axis = dot(off, off) < _FREE * _FREE
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
def reach_gap(p, n, x, fixed, distance):
    """Metres by which `distance` misses the range of |x - fixed| while x turns about the axis (p, n)."""
    v = sub(x, p)
    along = dot(v, n)
    b = blend(1.0, v, -along, n)
    centre = add(sub(p, fixed), scale(along, n))
    height = dot(centre, n)
    flat = blend(1.0, centre, -height, n)
    f, r = math.sqrt(dot(flat, flat)), math.sqrt(dot(b, b))
    high = math.sqrt(height * height + (f + r) * (f + r))
    low = math.sqrt(height * height + (f - r) * (f - r))
    return max(distance - high, low - distance)


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
        F1, _ = frame(u, blend(c, r, s, side_of(u, r)))
        for elbow in range(2):
            s4, c4 = (sa, ca) if elbow == 0 else (sb, cb)
            w0 = sub(add(turn(n4, s4, c4, sub(W, p4)), p4), S)
            e0 = sub(E, S)
            lever = cross(w0, e0)
            stretched = dot(lever, lever) < _FREE * _FREE * length2 * dot(e0, e0)
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
def side_of(u, r):
    return cross(u, r)


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
            if kept or dot(w, w) < _ALIGNED * _ALIGNED * radius * radius:
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
            free1 = dot(b, b) < _FREE * _FREE
        else:
            r = sub(W, C)
            sa, ca, sb, cb, real = elbow_roots(p1, n1, w, C, dot(r, r))
            sa, sb = -sa, -sb  # w turned backwards
            miss = 0.0 if real else max(reach_gap(p1, n1, w, C, math.sqrt(dot(r, r))), 1e-9)
            b = cross(n1, v)
            free1 = dot(b, b) < _FREE * _FREE
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
                if kept or dot(across, across) < _ALIGNED * _ALIGNED:
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


@jit
def polish(arm, limits, motors, Q, valid, locked, steps, residual):
    """Newton steps on the true axes for rows (m, branches, n) that a nearly exact structure gave; residual (m,
    branches).

    locked: index of a joint to leave alone, or -1."""
    n = Q.shape[2]
    J, e = np.empty((6, n)), np.empty(6)
    H = np.empty((6, 7))
    for i in range(motors.shape[0]):
        R, t = load_pose(motors, i, arm, n)
        for k in range(Q.shape[1]):
            if not valid[i, k]:
                continue
            q = Q[i, k]
            for step in range(steps + 1):
                M, x = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
                for j in range(n):
                    a, p = row(arm, j), row(arm, n + j)
                    m = cross(times(M, a), sub(t, add(times(M, p), x)))
                    g = times(M, a)
                    for r in range(3):
                        J[r, j], J[3 + r, j] = (0.0, 0.0) if j == locked else (g[r], m[r])
                    T = turn_matrix(a, math.sin(q[j]), math.cos(q[j]))
                    x = add(x, times(M, sub(p, times(T, p))))
                    M = product(M, T)
                D = product(R, transposed(M))
                e[0], e[1], e[2] = 0.5 * (D[7] - D[5]), 0.5 * (D[2] - D[6]), 0.5 * (D[3] - D[1])
                e[3], e[4], e[5] = t[0] - x[0], t[1] - x[1], t[2] - x[2]
                size = 0.0
                for r in range(6):
                    size = max(size, abs(e[r]))
                residual[i, k] = size
                if size < 1e-13 or step == steps:
                    break
                # Least-norm step: (J J^T + tiny) y = e, dq = J^T y.
                for r in range(6):
                    for c in range(6):
                        s = 1e-12 if r == c else 0.0
                        for j in range(n):
                            s += J[r, j] * J[c, j]
                        H[r, c] = s
                    H[r, 6] = e[r]
                for r in range(6):
                    for r2 in range(r + 1, 6):
                        f = H[r2, r] / H[r, r]
                        for c in range(r, 7):
                            H[r2, c] -= f * H[r, c]
                for r in range(5, -1, -1):
                    for c in range(r + 1, 6):
                        H[r, 6] -= H[r, c] * H[c, 6]
                    H[r, 6] /= H[r, r]
                for j in range(n):
                    for r in range(6):
                        q[j] += J[r, j] * H[r, 6]
            settle(q, limits, False)


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
