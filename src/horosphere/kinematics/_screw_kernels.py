"""The steps that every closed form is made of, for compiled loops: vectors as tuples of three numbers, rotations as nine.

An arm is one array (k, 3), rows: n unit axes and n points on them at q = 0 in the base frame; rotation (3) and translation of
the inverse home pose; (1 if the chain is solved from its tip, a number, 0); points fixed in links, as each solver says.
Three steps carry everything: the roots of A + B cos q + C sin q = l, the angle about an axis that takes one vector to another
(the ratio formula), and the decomposition of a rotation about three axes. Our derivation; docs/inverse-kinematics.md.
"""

import math

from ..kernels import jit

FREE = 1e-10  # sine below which an angle is free and kept from the seed
TOUCH = 3e-11  # relative overshoot of a double root that is taken for rounding (axes of URDF files are off by 3e-12)
# Sine between the outer axes of three below which the first angle is kept from the seed; it costs as much in the pose.
ALIGNED = 2e-11


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
    if h <= ALIGNED * ALIGNED:
        return 0.0, 1.0, True
    return s / h, c / h, h <= ALIGNED * math.sqrt(dot(p, p)) or h <= ALIGNED * math.sqrt(dot(r, r))


@jit
def roots(offset, b, c, level, rest):
    """(sine, cosine) of both roots of offset + b cos q + c sin q = level, and whether they are real.

    rest = b^2 + c^2 - (level - offset)^2, given by the caller in a form without cancellation.
    """
    h2 = b * b + c * c
    real = rest >= -TOUCH * h2 and h2 > 0.0
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
    if free or dot(w, w) < ALIGNED * ALIGNED:
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
