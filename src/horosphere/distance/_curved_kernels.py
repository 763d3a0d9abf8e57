"""Signed distance of a segment to a cylinder and to an ellipsoid in its own frame: compiled code on scalars.

See `_pair_kernels.py` for what is returned.
"""

from __future__ import annotations

import math
from functools import partial

from ..kernels import jit

# called from compiled code alone, and nothing is allocated: compiles sooner
inner = partial(jit, _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True)


@inner
def _cylinder_slope(t, a, u, R, H):
    """Half the derivative of the squared distance to a cylinder along the segment, and its own derivative."""
    slope, curvature = 0.0, 0.0
    x, y, z = a[0] + t * u[0], a[1] + t * u[1], a[2] + t * u[2]
    rho = math.sqrt(x * x + y * y)
    if rho > R:
        outward, share = (x * u[0] + y * u[1]) / rho, R / rho
        slope = (rho - R) * outward
        curvature = (1.0 - share) * (u[0] * u[0] + u[1] * u[1]) + share * outward * outward
    if abs(z) > H:
        slope += (z - H if z > 0.0 else z + H) * u[2]
        curvature += u[2] * u[2]
    return slope, curvature


@inner
def to_cylinder(a, u, size):
    """Distance of a segment to the cylinder about z, radius size[0], half length size[1], with flat ends."""
    R, H = size[0], size[1]
    square = u[0] * u[0] + u[1] * u[1]
    lo, hi = 0.0, 1.0  # the part of the segment between the ends and within the radius
    if u[2] != 0.0:
        t0, t1 = (-H - a[2]) / u[2], (H - a[2]) / u[2]
        lo, hi = max(lo, min(t0, t1)), min(hi, max(t0, t1))
    elif abs(a[2]) > H:
        lo = 2.0
    # nearest to the axis at `middle`; the room there comes from the point, not from B^2 - A C
    middle = -(a[0] * u[0] + a[1] * u[1]) / square if square > 0.0 else 0.0
    x, y = a[0] + middle * u[0], a[1] + middle * u[1]
    room = R * R - x * x - y * y
    if room < 0.0:
        lo = 2.0
    elif square > 0.0:
        half = math.sqrt(room / square)
        lo, hi = max(lo, middle - half), min(hi, middle + half)
    if lo > hi:
        lo, hi = 0.0, 1.0
        t = min(max(middle, 0.0), 1.0)
        for step in range(82):  # the ends, then Newton on a rising function, kept in the bracket
            at = t if step > 1 else float(step)
            slope, curvature = _cylinder_slope(at, a, u, R, H)
            if step < 2:
                if (slope < 0.0) == (step == 1):  # falling still at the end, or rising from the start
                    t = at
                    break
                continue
            if slope < 0.0:
                lo = t
            else:
                hi = t
            if slope == 0.0:
                break
            t = t - slope / curvature if curvature > 0.0 else 2.0
            if not lo < t < hi:
                t = 0.5 * (lo + hi)
            if abs(t - at) <= 1e-16 or hi - lo <= 2e-16:
                break
        x, y, z = a[0] + t * u[0], a[1] + t * u[1], a[2] + t * u[2]
        rho = math.sqrt(x * x + y * y)
        radial, axial = max(rho - R, 0.0), max(abs(z) - H, 0.0)
        d = math.sqrt(radial * radial + axial * axial)
        if d > 0.0:
            k = radial / (rho * d) if radial > 0.0 else 0.0
            return d, t, k * x, k * y, (axial if z > 0.0 else -axial) / d
    return _out_of_cylinder(a, u, R, H)  # also where it touches within rounding


@inner
def _out_of_cylinder(a, u, R, H):
    """Shortest translation of a segment out of a cylinder it meets.

    The Minkowski sum of the two is bounded by flat ends (normal z), a stadium (normals across z), and the two rims swept
    along the segment (normals across u, elliptic arcs in the shadow along u); an inner ball touches only these.
    """
    square = u[0] * u[0] + u[1] * u[1]
    length = math.sqrt(square + u[2] * u[2])
    sign = 1.0 if a[2] + 0.5 * u[2] >= 0.0 else -1.0
    depth, nx, ny, nz, t = H - sign * (a[2] + 0.5 * u[2]) + 0.5 * abs(u[2]), 0.0, 0.0, sign, 0.5
    if u[2] != 0.0:
        t = 1.0 if sign * u[2] < 0.0 else 0.0
    s = -(a[0] * u[0] + a[1] * u[1]) / square if square > 0.0 else 0.5
    s = min(max(s, 0.0), 1.0)
    x, y = a[0] + s * u[0], a[1] + s * u[1]
    rho = math.sqrt(x * x + y * y)
    if R - rho < depth:
        depth, t, nx, ny, nz = R - rho, s, 1.0, 0.0, 0.0
        if rho > 0.0:
            nx, ny = x / rho, y / rho
        elif square > 0.0:
            nx, ny = -u[1] / math.sqrt(square), u[0] / math.sqrt(square)
    ca, sa = u[2] / length if length > 0.0 else 0.0, math.sqrt(square) / length if length > 0.0 else 0.0
    if sa > 1e-12 and abs(ca) > 1e-12 and R > 0.0:
        # the shadow along u: across e = z x u the disc has radius R, along f = z - ca u / |u| it has R |ca|
        ex, ey = -u[1] / math.sqrt(square), u[0] / math.sqrt(square)
        fx, fy = -ca * ey, ca * ex
        b = R * abs(ca)
        x, y = a[0] * ex + a[1] * ey, a[0] * fx + a[1] * fy + a[2] * sa
        X, Y = abs(x), abs(y) - H * sa
        # distance to the arc (R cos, b sin) is stationary where (R^2 - b^2) - R X / cos + b Y / sin = 0; the falling branch
        lo, hi = 0.0, 0.5 * math.pi
        if Y < 0.0:
            lo = math.atan(math.pow(-b * Y / (R * X), 1.0 / 3.0)) if X > 0.0 else 1.5
        for _ in range(60):
            angle = 0.5 * (lo + hi)
            c, q = math.cos(angle), math.sin(angle)
            if (R * R - b * b) * q * c - R * X * q + b * Y * c > 0.0:
                lo = angle
            else:
                hi = angle
        # the support value of any normal of the arc bounds the depth, so a missing root does no harm
        c, q = math.cos(lo), math.sin(lo)
        scale = math.sqrt(b * b * c * c + R * R * q * q)
        mx, my = b * c / scale, R * q / scale
        arc = mx * (R * c - X) + my * (b * q - Y)
        if arc < depth:
            depth = arc
            c, mx = (c, mx) if x >= 0.0 else (-c, -mx)
            q, my, top = (q, my, H) if y >= 0.0 else (-q, -my, -H)
            nx, ny, nz = mx * ex + my * fx, mx * ey + my * fy, my * sa
            # the rim point under the arc, and where the segment passes it; z x e has the shadow ca f
            turn = R * q if ca > 0.0 else -R * q
            px, py = R * c * ex - turn * ey, R * c * ey + turn * ex
            t = ((px - a[0]) * u[0] + (py - a[1]) * u[1] + (top - a[2]) * u[2]) / (length * length)
            t = min(max(t, 0.0), 1.0)
    return -depth, t, nx, ny, nz


@inner
def to_ellipsoid_point(p, e):
    """Signed distance of a point to the solid sum (x_i / e_i)^2 <= 1, in its frame, and the unit gradient.

    The closest point is e_i^2 p_i / (tau + e_i^2) with tau the largest root of sum (e_i p_i / (tau + e_i^2))^2 = 1. Newton
    from below climbs to it without overshoot, since the sum is convex and falls there.
    """
    small = min(e[0], e[1], e[2])
    least = small * small
    mu = 0.0  # tau + least
    for i in range(3):
        if e[i] == small:
            mu = max(mu, small * abs(p[i]))
        else:
            mu = max(mu, e[i] * abs(p[i]) - (e[i] - small) * (e[i] + small))
    for _ in range(200):
        value, slope = -1.0, 0.0
        for i in range(3):
            if p[i] != 0.0:
                below = mu + (e[i] - small) * (e[i] + small)
                term = (e[i] * p[i] / below) ** 2
                value += term
                slope -= 2.0 * term / below
        if not value > 0.0 or slope == 0.0:
            break
        step = -value / slope
        if step <= 4e-16 * mu:
            break
        mu += step
    tau = mu - least
    norm, square, rest = 0.0, 0.0, 1.0
    g = (0.0, 0.0, 0.0)
    for i in range(3):
        below = mu + (e[i] - small) * (e[i] + small)
        ratio = p[i] / below if p[i] != 0.0 else 0.0
        square += ratio * ratio
        rest -= (e[i] * ratio) ** 2
        g = (g[1], g[2], ratio)  # gradient direction x_i / e_i^2
    if mu == 0.0 and rest > 0.0:  # between the foci: the closest points lie off the plane of symmetry, on either side
        h = math.sqrt(rest) / small
        square += h * h
        if e[0] == small:
            g = (h, g[1], g[2])
        elif e[1] == small:
            g = (g[0], h, g[2])
        else:
            g = (g[0], g[1], h)
    norm = math.sqrt(square)
    if norm == 0.0:
        return -small, 0.0, 0.0, 1.0
    return tau * norm, g[0] / norm, g[1] / norm, g[2] / norm


@inner
def to_ellipsoid(a, u, e):
    """Distance of a segment to an ellipsoid in its frame; inside, minus the greatest depth of a point of the segment.

    The signed distance to a convex solid is convex along the segment: bisection on its slope.
    """
    lo, hi, t = 0.0, 1.0, 0.0
    d, nx, ny, nz = 0.0, 0.0, 0.0, 0.0
    for step in range(54):  # the two ends, then bisection
        t = float(step) if step < 2 else 0.5 * (lo + hi)
        d, nx, ny, nz = to_ellipsoid_point((a[0] + t * u[0], a[1] + t * u[1], a[2] + t * u[2]), e)
        slope = nx * u[0] + ny * u[1] + nz * u[2]
        if step < 2:
            if (slope < 0.0) == (step == 1) or slope == 0.0:
                break
        elif slope < 0.0:
            lo = t
        else:
            hi = t
    return d, t, nx, ny, nz
