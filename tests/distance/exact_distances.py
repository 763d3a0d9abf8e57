"""Distances of a segment to a solid in exact or 60-digit arithmetic, from the same numbers that the compiled code gets.

Written from the definition (a point of the segment, the nearest point of the solid), not from the code under test.
"""

from decimal import Decimal, getcontext, localcontext
from fractions import Fraction

import numpy as np

from horosphere.shapes import Box, Cylinder, Ellipsoid

getcontext().prec = 60
ZERO, ONE = Decimal(0), Decimal(1)


def exact(v):
    return [Decimal(float(x)) for x in np.ravel(v)]


def inverse(R):
    """Of a 3 x 3 matrix of Decimals, by cofactors: the rotation as it is stored need not be orthogonal to the last bit."""
    c = [
        [
            R[(j + 1) % 3][(i + 1) % 3] * R[(j + 2) % 3][(i + 2) % 3]
            - R[(j + 1) % 3][(i + 2) % 3] * R[(j + 2) % 3][(i + 1) % 3]
            for j in range(3)
        ]
        for i in range(3)
    ]
    det = sum(R[0][k] * c[k][0] for k in range(3))
    return [[c[i][j] / det for j in range(3)] for i in range(3)]


def times(R, v):
    return [sum(r * x for r, x in zip(row, v)) for row in R]


def norm(v):
    return sum(x * x for x in v).sqrt()


def to_box(y, h):
    over = [max(abs(x) - s, ZERO) for x, s in zip(y, h)]
    return norm(over) if any(over) else max(abs(x) - s for x, s in zip(y, h))


def to_cylinder(y, size):
    out, up = norm(y[:2]) - size[0], abs(y[2]) - size[1]
    return norm([max(out, ZERO), max(up, ZERO)]) if max(out, up) > 0 else max(out, up)


def to_ellipsoid(y, e):
    """By Lagrange's equation, bisected and then by Newton in its bracket."""
    p = [abs(x) for x in y]
    least = min(e)
    gaps = [(s - least) * (s + least) for s in e]

    def value(mu):
        return sum((s * x / (mu + g)) ** 2 for s, x, g in zip(e, p, gaps) if x) - 1

    low = max([ZERO] + [s * x - g for s, x, g in zip(e, p, gaps)])
    focal = low == 0 or (not any(x for x, g in zip(p, gaps) if g == 0) and value(Decimal("1e-50")) <= 0)
    if focal:  # no component across the least axis, and between the foci
        low = ZERO
    else:
        high = norm([s * x for s, x in zip(e, p)])
        while high - low > Decimal("1e-45") * high:
            v = value(low)
            slope = -2 * sum((s * x) ** 2 / (low + g) ** 3 for s, x, g in zip(e, p, gaps) if x)
            step = low - v / slope  # from below, without overshoot
            middle = (low + high) / 2
            if value(middle) > 0:
                low = max(middle, step)
            else:
                high, low = middle, max(low, step)
            if step - low > 0 or v <= Decimal("1e-55"):
                break
    foot = [s * s * x / (low + g) if x else ZERO for s, x, g in zip(e, p, gaps)]
    if focal:
        k = e.index(least)
        rest = 1 - sum((f / s) ** 2 for f, s in zip(foot, e))
        foot[k] = least * rest.sqrt()
    inside = sum((x / s) ** 2 for x, s in zip(p, e)) < 1
    d = norm([x - f for x, f in zip(p, foot)])
    return -d if inside else d


def frame_of(solid):
    """(point distance, R columns, centre, sizes) in Decimals, from the packed row."""
    from horosphere.shapes._pack import pack

    row = pack((solid,)).rows[0]
    kind = {Box: to_box, Cylinder: to_cylinder, Ellipsoid: to_ellipsoid}[type(solid)]
    rows = [exact(row[6 + 3 * k : 9 + 3 * k]) for k in range(3)]
    R = [[rows[j][i] for j in range(3)] for i in range(3)]
    return kind, R, exact(row[1:4]), exact(row[15 : 15 + (2 if kind is to_cylinder else 3)])


def segment_to_solid(solid, a, u):
    """Least signed distance of a point of a + t u: golden sections on a convex function."""
    kind, R, c, size = frame_of(solid)
    back = inverse(R)
    start, along = times(back, [x - y for x, y in zip(exact(a), c)]), times(back, exact(u))

    def at(t):
        return kind([x + t * y for x, y in zip(start, along)], size)

    if not any(along):
        return at(ZERO)
    golden = (Decimal(5).sqrt() - 1) / 2
    low, high = ZERO, ONE
    x, y = high - golden * (high - low), low + golden * (high - low)
    fx, fy = at(x), at(y)
    best = min(at(ZERO), at(ONE), fx, fy)
    while high - low > Decimal("1e-26"):
        if fx < fy:
            high, y, fy = y, x, fx
            x = high - golden * (high - low)
            fx = at(x)
        else:
            low, x, fx = x, y, fy
            y = low + golden * (high - low)
            fy = at(y)
        best = min(best, fx, fy)
    return best


def segment_to_segment(a, u, b, v, ends=False):
    """Exact: the least of a convex quadratic over the unit square, in rationals, then one square root to 60 digits.

    With `ends`, v is the other end of the second segment, not its vector.
    """
    a, u, b, v = ([x if isinstance(x, Fraction) else Fraction(float(x)) for x in w] for w in (a, u, b, v))
    v = [x - y for x, y in zip(v, b)] if ends else v
    w = [y - x for x, y in zip(a, b)]

    def dot(p, q):
        return sum(x * y for x, y in zip(p, q))

    def clamp(x):
        return min(max(x, Fraction(0)), Fraction(1))

    uu, vv, uv, wu, wv = dot(u, u), dot(v, v), dot(u, v), dot(w, u), dot(w, v)
    tries = [(s, clamp((s * uv - wv) / vv) if vv else Fraction(0)) for s in (Fraction(0), Fraction(1))]
    tries += [(clamp((t * uv + wu) / uu) if uu else Fraction(0), t) for t in (Fraction(0), Fraction(1))]
    det = uu * vv - uv * uv
    if det:
        s, t = (wu * vv - wv * uv) / det, (wu * uv - wv * uu) / det
        if 0 <= s <= 1 and 0 <= t <= 1:
            tries.append((s, t))
    least = min(dot(d, d) for d in ([s * x - t * y - z for x, y, z in zip(u, v, w)] for s, t in tries))
    with localcontext() as context:
        context.prec = 60
        return (Decimal(least.numerator) / Decimal(least.denominator)).sqrt()


def segment_to_triangle(a, u, corners):
    """Exact but for square roots: 0 if the segment crosses, else the nearest of three edges and the heights of its ends."""
    exactly = [[Fraction(float(x)) for x in p] for p in (a, u, *corners)]
    a_, u_, p, q, r = exactly

    def minus(x, y):
        return [i - j for i, j in zip(x, y)]

    def dot(x, y):
        return sum(i * j for i, j in zip(x, y))

    def cross(x, y):
        return [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]

    least = min(segment_to_segment(a, u, s, t, ends=True) for s, t in ((p, q), (q, r), (r, p)))
    n = cross(minus(q, p), minus(r, p))
    square = dot(n, n)
    if not square:
        return least

    def within(x):
        return all(dot(n, cross(minus(t, s), minus(x, s))) >= 0 for s, t in ((p, q), (q, r), (r, p)))

    end = [i + j for i, j in zip(a_, u_)]
    heights = [dot(n, minus(x, p)) for x in (a_, end)]
    if heights[0] * heights[1] <= 0 and heights[0] != heights[1]:
        share = heights[0] / (heights[0] - heights[1])
        if within([i + share * j for i, j in zip(a_, u_)]):
            return ZERO
    for x, h in zip((a_, end), heights):
        if within(x):
            least = min(least, (Decimal((h * h / square).numerator) / Decimal((h * h / square).denominator)).sqrt())
    return least
