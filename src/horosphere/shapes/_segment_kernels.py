"""Segments against points and segments: compiled code on scalars, the ground of all exact distances."""

from __future__ import annotations

import math

import numpy as np

from ..kernels import inner


@inner
def unit_normal_to(x, y, z):
    """Some unit vector at right angles to (x, y, z), which may be zero."""
    if abs(x) <= abs(y) and abs(x) <= abs(z):
        y, z, x = -z, y, 0.0
    elif abs(y) <= abs(z):
        x, z, y = -z, x, 0.0
    else:
        x, y, z = -y, x, 0.0
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return 0.0, 0.0, 1.0
    return x / length, y / length, z / length


@inner
def clamp(x):
    return min(max(x, 0.0), 1.0)


@inner
def closest_parameters(ux, uy, uz, vx, vy, vz, wx, wy, wz):
    """(s, t) in the unit square where |s u - t v - w| is least: closest points of a + s u and (a + w) + t v.

    The minimum of a convex quadratic over a square lies inside, or on one of its four sides. The inner point comes from
    cross products, which lose half as many digits as u.u v.v - (u.v)^2 where the segments are nearly parallel.
    """
    uu, vv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
    wu, wv, uv = wx * ux + wy * uy + wz * uz, wx * vx + wy * vy + wz * vz, ux * vx + uy * vy + uz * vz
    if uu == 0.0:
        return 0.0, clamp(-wv / vv) if vv > 0.0 else 0.0
    if vv == 0.0:
        return clamp(wu / uu), 0.0
    best, s, t = np.inf, 0.0, 0.0
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    nn = nx * nx + ny * ny + nz * nz
    if nn > 0.0:
        s = ((wy * vz - wz * vy) * nx + (wz * vx - wx * vz) * ny + (wx * vy - wy * vx) * nz) / nn
        t = (s * uv - wv) / vv  # the foot of that point: errors of s then cost only their share across the axes
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            if nn > 1e-10 * uu * vv:
                return s, t
            dx, dy, dz = s * ux - t * vx - wx, s * uy - t * vy - wy, s * uz - t * vz - wz
            best = dx * dx + dy * dy + dz * dz
    best_s, best_t = s, t
    for side in range(4):
        if side < 2:
            s = float(side)
            t = clamp((s * uv - wv) / vv)
        else:
            t = float(side - 2)
            s = clamp((t * uv + wu) / uu)
        dx, dy, dz = s * ux - t * vx - wx, s * uy - t * vy - wy, s * uz - t * vz - wz
        square = dx * dx + dy * dy + dz * dz
        if square < best:
            best, best_s, best_t = square, s, t
    return best_s, best_t


@inner
def to_segment(ax, ay, az, ux, uy, uz, bx, by, bz, vx, vy, vz):
    """Distance of two segments; zero where they cross (no translation out of a flat set is needed beyond the radii)."""
    s, t = closest_parameters(ux, uy, uz, vx, vy, vz, bx - ax, by - ay, bz - az)
    dx, dy, dz = ax + s * ux - bx - t * vx, ay + s * uy - by - t * vy, az + s * uz - bz - t * vz
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    if distance > 0.0:
        return distance, s, dx / distance, dy / distance, dz / distance
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    if length > 0.0:
        return 0.0, s, nx / length, ny / length, nz / length
    nx, ny, nz = unit_normal_to(ux + vx, uy + vy, uz + vz)
    return 0.0, s, nx, ny, nz
