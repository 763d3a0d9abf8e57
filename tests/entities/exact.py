"""Vector geometry with 60 decimal digits: the witness where rounding is the question. Floats go in without rounding."""

from decimal import Decimal, getcontext

getcontext().prec = 60


def vec(x):
    """An exact vector of Decimals."""
    return [Decimal(float(v)) for v in x]


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def add(a, b):
    return [x + y for x, y in zip(a, b)]


def scale(a, s):
    return [x * s for x in a]


def dot(a, b):
    return sum((x * y for x, y in zip(a, b)), Decimal(0))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def norm(a):
    return dot(a, a).sqrt()


def unit(a):
    return scale(a, 1 / norm(a))


def circumcircle(a, b, c):
    """Center and radius of the circle through three points."""
    u, v = sub(b, a), sub(c, a)
    n = cross(u, v)
    rel = scale(add(scale(cross(v, n), dot(u, u)), scale(cross(n, u), dot(v, v))), 1 / (2 * dot(n, n)))
    return add(a, rel), norm(rel)


def sphere_circle(c1, r1, c2, r2):
    """Center and squared radius of the circle of two spheres."""
    d = sub(c2, c1)
    t = (dot(d, d) + r1 * r1 - r2 * r2) / (2 * dot(d, d))
    return add(c1, scale(d, t)), r1 * r1 - t * t * dot(d, d)
