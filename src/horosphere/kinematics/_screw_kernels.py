"""The steps that every closed form is made of, for compiled loops: vectors as tuples of three numbers, rotations as nine.

A number is a float64 or a lane vector: the branches of one pose are computed side by side, one a lane, so whatever differs
between them (the sign of a root, a degenerate case) is data and not a branch in the code.

An arm is one array (k, 3), rows: n unit axes and n points on them at q = 0 in the base frame; rotation (3) and translation of
the inverse home pose; (1 if the chain is solved from its tip, a number, `soft`); points fixed in links, as each solver says.
`soft` is 0 for exact structures. Where the true axes miss the structure, roots that it puts out of reach by this relative
amount are kept, and pulled apart by as much, as starts for Newton steps on the true axes: else double roots would be lost.
Three steps carry everything: the roots of A + B cos q + C sin q = l, the angle about an axis that takes one vector to another
(the ratio formula), and the decomposition of a rotation about three axes. Our derivation; docs/inverse-kinematics.md.
Flags are numbers, 1 for yes; `good` is not negative where a root is real.
"""

import math

import numpy as np

from ..kernels import atan2, jit, kernel, lane_mask_lt, lane_max, lane_min, lane_sqrt, lane_where_lt, sincos

FREE = 1e-10  # sine below which an angle is free and kept from the seed
TOUCH = 3e-11  # relative overshoot of a double root that is taken for rounding (axes of URDF files are off by 3e-12)
# Sine between the outer axes of three below which the first angle is kept from the seed; it costs as much in the pose.
ALIGNED = 2e-11
TINY = 1e-300
# Signs of the three bits of rows 0..7, the first bit most significant: which root each lane takes.
SIGNS = np.array([[1.0, 1, 1, 1, -1, -1, -1, -1], [1, 1, -1, -1, 1, 1, -1, -1], [1, -1, 1, -1, 1, -1, 1, -1]])


@kernel(1, y=None, x=None)
def angle_of(y, x):
    """atan2(y, x)."""
    return [atan2(y, x)]


@kernel(2, x=None)
def sine_cosine(x):
    """(sin x, cos x)."""
    return list(sincos(x))


_angle = angle_of.inline


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
def settled(s, c, lower, upper):
    """The angle in (-pi, pi] with sine s and cosine c (of any common length), brought inside the limits."""
    (x,) = _angle(s, c)
    return inside(lane_where_lt(-math.pi, x, x, math.pi), lower, upper)


@jit
def inside(x, lower, upper):
    """The angle x, moved by a turn where only that is inside the limits."""
    moved = lane_where_lt(x, lower, x + 2.0 * math.pi, lane_where_lt(upper, x, x - 2.0 * math.pi, x))
    return lane_where_lt(moved, lower, x, lane_where_lt(upper, moved, x, moved))


@jit
def either(a, b, x, y):
    """Where a < b the numbers of x, else those of y (tuples of three)."""
    return (
        lane_where_lt(a, b, x[0], y[0]),
        lane_where_lt(a, b, x[1], y[1]),
        lane_where_lt(a, b, x[2], y[2]),
    )


@jit
def seeded(seeds, i, j, arm, n):
    """(sine, cosine) of the seed of the chain's angle j (of the reversed chain: minus the one from the other end)."""
    x = -seeds[i, n - 1 - j] if arm[2 * n + 4, 0] > 0.5 else seeds[i, j]
    return math.sin(x), math.cos(x)


@jit
def ratio(n, x, y):
    """(sine, cosine, free) of the angle about the unit vector n that takes x to y; free where x or y lies along n.

    Both from cross products: y.x - (n.x)(n.y) would lose the angle of nearly parallel vectors (error eps / sin^2).
    """
    p, r = cross(n, x), cross(n, y)
    s, c = dot(cross(p, r), n), dot(p, r)
    h = lane_sqrt(s * s + c * c)
    inverse = 1.0 / lane_max(h, TINY)
    some = ALIGNED * lane_max(lane_sqrt(dot(p, p)), lane_sqrt(dot(r, r)))
    free = lane_where_lt(some, h, 0.0, 1.0)
    gone = ALIGNED * ALIGNED
    return lane_where_lt(gone, h, s * inverse, 0.0), lane_where_lt(gone, h, c * inverse, 1.0), free


@jit
def root(offset, b, c, level, rest, sign, soft):
    """(sine, cosine) of a root of offset + b cos q + c sin q = level, and `good`; sign 1 or -1 chooses which.

    rest = b^2 + c^2 - (level - offset)^2, given by the caller in a form without cancellation.
    """
    h2 = b * b + c * c
    w = sign * lane_sqrt(lane_max(rest, lane_min(-rest, soft * h2)))
    g = level - offset
    k = 1.0 / lane_sqrt(lane_max(g * g + w * w, TINY) * lane_max(h2, TINY))  # equals 1 / h^2 where real
    return (c * g + b * w) * k, (b * g - c * w) * k, lane_where_lt(0.0, h2, rest + (TOUCH + soft) * h2, -1.0)


@jit
def simple_root(offset, b, c, level, sign, soft):
    """`root` with the plain factorised remainder."""
    h, g = lane_sqrt(b * b + c * c), level - offset
    return root(offset, b, c, level, (h - g) * (h + g), sign, soft)


@jit
def any_normal(n):
    """A unit vector perpendicular to the unit vector n."""
    x = cross(n, (1.0, 0.0, 0.0)) if abs(n[0]) < 0.7 else cross(n, (0.0, 1.0, 0.0))
    return scale(1.0 / math.sqrt(dot(x, x)), x)


@jit
def normalised(x):
    """x / |x|."""
    return scale(1.0 / lane_sqrt(lane_max(dot(x, x), TINY)), x)


@jit
def decompose(n1, n2, n3, R, sign, kept, soft):
    """Sines and cosines (s1, c1, s2, c2, s3, c3) of turn(n1) turn(n2) turn(n3) = R, then (good, free).

    sign: the middle root. kept: (sine, cosine) of the first angle where the outer axes coincide; the third is then relative to it.
    """
    alpha, gamma = dot(n1, n2), dot(n2, n3)
    r3 = times(R, n3)
    level = dot(n1, r3)
    w = cross(n1, r3)
    w2 = dot(w, w)
    offset = alpha * gamma
    # (1 - alpha^2)(1 - gamma^2) - (level - offset)^2 with 1 - level^2 = |n1 x r3|^2: exact where n1, n2, n3 are at
    # right angles
    rest = w2 - alpha * alpha - gamma * gamma + 2.0 * offset * level
    s2, c2, good = root(offset, dot(n1, n3) - offset, dot(n1, cross(n2, n3)), level, rest, sign, soft)
    s1, c1, free = ratio(n1, turn(n2, s2, c2, n3), r3)
    free = lane_where_lt(w2, ALIGNED * ALIGNED, 1.0, free)
    s1, c1 = lane_where_lt(0.5, free, kept[0], s1), lane_where_lt(0.5, free, kept[1], c1)
    x = any_normal(n3)
    y = turn(n2, -s2, c2, turn(n1, -s1, c1, times(R, x)))
    # y is across n3 already, so the ratio needs no projection.
    return (s1, c1, s2, c2, dot(cross(x, y), n3), dot(x, y)), good, free


@jit
def frame(a, b):
    """Columns unit a, the part of b across it, and their cross product, as nine numbers."""
    x = normalised(a)
    z = normalised(cross(x, b))
    y = cross(z, x)
    return x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]


@jit
def elbow_root(p, n, x, fixed, r2, sign, soft):
    """The angle (sine, cosine) about the axis (p, n) that brings x to the distance sqrt(r2) from `fixed`, and `good`."""
    v = sub(x, p)
    along = dot(v, n)
    b = blend(1.0, v, -along, n)
    centre = add(sub(p, fixed), scale(along, n))
    c = cross(n, b)
    return simple_root(dot(centre, centre) + dot(b, b), 2.0 * dot(centre, b), 2.0 * dot(centre, c), r2, sign, soft)


@jit
def reach_gap(p, n, x, fixed, distance):
    """Metres by which `distance` misses the range of |x - fixed| while x turns about the axis (p, n), at least 0."""
    v = sub(x, p)
    along = dot(v, n)
    b = blend(1.0, v, -along, n)
    centre = add(sub(p, fixed), scale(along, n))
    height = dot(centre, n)
    flat = blend(1.0, centre, -height, n)
    f, r = lane_sqrt(dot(flat, flat)), lane_sqrt(dot(b, b))
    high = lane_sqrt(height * height + (f + r) * (f + r))
    low = lane_sqrt(height * height + (f - r) * (f - r))
    return lane_max(lane_max(distance - high, low - distance), 0.0)


@jit
def missing(good, gap):
    """Metres missing: 0 where a root is real, else at least a nanometre."""
    return lane_where_lt(good, 0.0, lane_max(gap, 1e-9), 0.0)


@jit
def store_flags(good, free, i, valid, loose):
    """Row i of `valid` and `loose` (m, branches) from lanes."""
    bad, held = lane_mask_lt(good, 0.0), lane_mask_lt(0.5, free)
    for k in range(valid.shape[1]):
        valid[i, k] = (bad >> k) & 1 == 0
        loose[i, k] = (held >> k) & 1 == 1


@jit
def margin5(q, limits):
    """Lanes: the least distance of one of the first five joints to its limits."""
    margin = lane_min(q[0] - limits[0, 0], limits[1, 0] - q[0])
    margin = lane_min(margin, lane_min(q[1] - limits[0, 1], limits[1, 1] - q[1]))
    margin = lane_min(margin, lane_min(q[2] - limits[0, 2], limits[1, 2] - q[2]))
    margin = lane_min(margin, lane_min(q[3] - limits[0, 3], limits[1, 3] - q[3]))
    return lane_min(margin, lane_min(q[4] - limits[0, 4], limits[1, 4] - q[4]))
