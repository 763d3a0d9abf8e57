"""Distance of a segment to a box, a cylinder or an ellipsoid by planes between them: compiled code on scalars.

All is in the solid's own frame, see `_pair_kernels.py`. For every unit vector n, with h the largest n . y over the solid, the
signed distance of a point x is at least n . x - h; along a segment a + t u that is a straight line over t. So any two normals
prove a lower bound of the least distance on the segment, however they were found, and the bound is the result: the search
decides only how tight it is. Rounding: docs/certificate.md.
"""

from __future__ import annotations

import math

import numpy as np

from ..kernels import inner
from ..shapes._segment_kernels import clamp

BOX, CYLINDER, ELLIPSOID = 1, 2, 4
ENOUGH = 4e-16
"""Gap between the distance of a point of the segment and what is proved, in units of the coordinates' size, that ends the search."""
MOST = 60


@inner
def tangent(kind, x, y, z, size):
    """(h, nx, ny, nz): normal where the solid is nearest to a point, or nearest to letting it out, and the solid's extent along it."""
    if kind == ELLIPSOID:
        nx, ny, nz = ellipsoid_normal((x, y, z), size)
        fx, fy, fz = size[0] * nx, size[1] * ny, size[2] * nz
        return math.sqrt(fx * fx + fy * fy + fz * fz), nx, ny, nz
    if kind == CYLINDER:
        rho = math.sqrt(x * x + y * y)
        out, up = rho - size[0], abs(z) - size[1]
        if out <= 0.0 or up <= 0.0:  # over an end or over the side: one of the two alone
            out, up = (1.0, 0.0) if out >= up else (0.0, 1.0)
        length = math.sqrt(out * out + up * up)
        out, up = out / length, up / length
        x, y = (x / rho, y / rho) if rho > 0.0 else (1.0, 0.0)
        return size[0] * out + size[1] * up, out * x, out * y, math.copysign(up, z)
    ex, ey, ez = abs(x) - size[0], abs(y) - size[1], abs(z) - size[2]
    most = max(ex, ey, ez)
    if most <= 0.0:
        ex, ey, ez = (
            1.0 if ex == most else 0.0,
            1.0 if ey == most > ex else 0.0,
            1.0 if ez == most > max(ex, ey) else 0.0,
        )
    else:
        ex, ey, ez = max(ex, 0.0), max(ey, 0.0), max(ez, 0.0)
    length = math.sqrt(ex * ex + ey * ey + ez * ez)
    ex, ey, ez = ex / length, ey / length, ez / length
    h = size[0] * ex + size[1] * ey + size[2] * ez
    return h, math.copysign(ex, x), math.copysign(ey, y), math.copysign(ez, z)


@inner
def ellipsoid_normal(p, e):
    """Unit normal at the point of sum (x_i / e_i)^2 = 1 nearest to p.

    The nearest point is e_i^2 p_i / (tau + e_i^2) with tau the largest root of sum (e_i p_i / (tau + e_i^2))^2 = 1. Newton
    from below climbs to it without overshoot, since the sum is convex and falls there.
    """
    small = min(e[0], e[1], e[2])
    mu = 0.0  # tau + small^2
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
    square, rest = 0.0, 1.0
    g = (0.0, 0.0, 0.0)
    for i in range(3):
        below = mu + (e[i] - small) * (e[i] + small)
        ratio = p[i] / below if p[i] != 0.0 else 0.0
        square += ratio * ratio
        rest -= (e[i] * ratio) ** 2
        g = (g[1], g[2], ratio)  # direction x_i / e_i^2
    if mu == 0.0 and rest > 0.0:  # between the foci: the nearest points lie off the plane of symmetry, on either side
        h = math.sqrt(rest) / small
        square += h * h
        if e[0] == small:
            g = (h, g[1], g[2])
        elif e[1] == small:
            g = (g[0], h, g[2])
        else:
            g = (g[0], g[1], h)
    norm = math.sqrt(square)
    return g[0] / norm, g[1] / norm, g[2] / norm


@inner
def lowest(kind, a, u, size):
    """Least signed distance of a point of a + t u, t in [0, 1], from below: (distance, t, nx, ny, nz).

    The distance is convex in t. Each plane gives a line l + s t below it; the falling one nearest to the minimum and the
    rising one enclose it, and w (l0 + s0 t) + (1 - w) (l1 + s1 t) with the slopes in balance is the bound. The next t is
    where the lines cross (right at a kink), where the slope would vanish if it were linear (right where it is smooth), or
    the middle.
    """
    enough = ENOUGH * (
        abs(a[0]) + abs(a[1]) + abs(a[2]) + abs(u[0]) + abs(u[1]) + abs(u[2]) + size[0] + size[1] + size[2]
    )
    square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2]
    t = clamp(-(a[0] * u[0] + a[1] * u[1] + a[2] * u[2]) / square) if square > 0.0 else 0.0
    lo, l0, s0, hi, l1, s1 = -1.0, 0.0, 0.0, 2.0, 0.0, 0.0  # -1 and 2: no such line yet
    low, least, at, bx, by, bz = -np.inf, np.inf, 0.0, 0.0, 0.0, 1.0
    for step in range(MOST):
        h, nx, ny, nz = tangent(kind, a[0] + t * u[0], a[1] + t * u[1], a[2] + t * u[2], size)
        line, slope = nx * a[0] + ny * a[1] + nz * a[2] - h, nx * u[0] + ny * u[1] + nz * u[2]
        if line + t * slope < least:
            least, at, bx, by, bz = line + t * slope, t, nx, ny, nz
            if least <= 0.0 and kind != ELLIPSOID:  # they meet: another way to measure takes over
                return least, at, bx, by, bz
        if slope < 0.0:
            lo, l0, s0 = t, line, slope
        else:
            hi, l1, s1 = t, line, slope
        share = s1 / (s1 - s0) if lo >= 0.0 and hi <= 1.0 else (1.0 if lo >= 0.0 else 0.0)
        proved = share * l0 + (1.0 - share) * l1 + min(share * s0 + (1.0 - share) * s1, 0.0)
        low = max(low, proved)
        if least - low <= enough:
            break
        if lo < 0.0 or hi > 1.0:
            end = 0.0 if lo < 0.0 else 1.0
            if end == t:
                break
            t = end
            continue
        t = 0.5 * (lo + hi)
        if not lo < t < hi:
            break
        if step % 3 < 2:
            guess = (l0 - l1) / (s1 - s0) if step % 3 == 1 else lo - s0 * (hi - lo) / (s1 - s0)
            t = guess if lo < guess < hi else t
    return low, at, bx, by, bz


@inner
def to_convex(kind, a, u, size):
    """Signed distance of a segment to a solid of the given kind and `size`.

    A box: half sizes; a cylinder about z: radius, half length; an ellipsoid: semi-axes. Where a segment meets a box or a
    cylinder: minus the shortest translation out; in an ellipsoid: minus the depth of its deepest point.
    """
    d, t, nx, ny, nz = lowest(kind, a, u, size)
    if d > 0.0 or kind == ELLIPSOID:
        return d, t, nx, ny, nz
    if kind == BOX:
        return _out_of_box(a, u, size)
    return _out_of_cylinder(a, u, size[0], size[1])


@inner
def _out_of_box(a, u, h):
    """Shortest translation of a segment out of a box it meets: over the face normals and the normals of edge x segment."""
    best, bt, bx, by, bz = np.inf, 0.0, 0.0, 0.0, 1.0
    for k in range(6):
        i = k % 3
        n = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        if k > 2:
            n = (n[1] * u[2] - n[2] * u[1], n[2] * u[0] - n[0] * u[2], n[0] * u[1] - n[1] * u[0])
        length = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
        # an edge nearly parallel to the segment gives no direction of its own: the faces cover it to 1e-12
        if length > 1e-12 * (abs(u[0]) + abs(u[1]) + abs(u[2])):
            n = (n[0] / length, n[1] / length, n[2] / length)
            reach = abs(n[0]) * h[0] + abs(n[1]) * h[1] + abs(n[2]) * h[2]
            at = n[0] * a[0] + n[1] * a[1] + n[2] * a[2]
            along = n[0] * u[0] + n[1] * u[1] + n[2] * u[2] if k < 3 else 0.0
            for sign in (1.0, -1.0):
                depth = reach - min(sign * at, sign * (at + along))
                if depth < best:
                    best, bx, by, bz = depth, sign * n[0], sign * n[1], sign * n[2]
                    bt = 0.5 if along == 0.0 else (1.0 if sign * along < 0.0 else 0.0)
                    if k > 2:  # the point of the segment that slides over the edge: a + t u + depth n lies on it
                        along_edge, square = 0.0, 0.0
                        for c in range(3):
                            if c != i:
                                edge = math.copysign(h[c], sign * n[c]) - depth * sign * n[c]
                                along_edge += u[c] * (edge - a[c])
                                square += u[c] * u[c]
                        bt = clamp(along_edge / square)
    return -best, bt, bx, by, bz


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
