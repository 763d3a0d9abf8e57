"""The search for a cover: the loops that numpy calls.

An axis is a row (x, y, z of one end, then of the other). `field` holds the depth in a solid at the points `origin + cell * index` of
a grid, negative outside. A point is a column (x, y, z, margin): to be held with that much to spare. Random numbers come from a
table that the caller fills, read in turn: `at` is where it stands.
"""

from __future__ import annotations

import math

import numpy as np

from ..kernels import inner, jit

OUTSIDE = -1e3
STARTS = 12


@inner
def _depth(field, origin, cell, x, y, z):
    """Depth at a point, between those at the eight corners of its cell."""
    u, v, w = (x - origin[0]) / cell, (y - origin[1]) / cell, (z - origin[2]) / cell
    i, j, k = int(math.floor(u)), int(math.floor(v)), int(math.floor(w))
    if i < 0 or j < 0 or k < 0 or i + 1 >= field.shape[0] or j + 1 >= field.shape[1] or k + 1 >= field.shape[2]:
        return OUTSIDE
    u, v, w = u - i, v - j, w - k
    p = (1.0 - w) * field[i, j, k] + w * field[i, j, k + 1]
    q = (1.0 - w) * field[i, j + 1, k] + w * field[i, j + 1, k + 1]
    r = (1.0 - w) * field[i + 1, j, k] + w * field[i + 1, j, k + 1]
    s = (1.0 - w) * field[i + 1, j + 1, k] + w * field[i + 1, j + 1, k + 1]
    return (1.0 - u) * ((1.0 - v) * p + v * q) + u * ((1.0 - v) * r + v * s)


@inner
def _axis_depth(field, origin, cell, axis, least):
    """Least depth along an axis, half a cell apart; less than `least` says no more than that."""
    dx, dy, dz = axis[3] - axis[0], axis[4] - axis[1], axis[5] - axis[2]
    steps = int(math.sqrt(dx * dx + dy * dy + dz * dz) / (0.5 * cell)) + 1
    depth = min(
        _depth(field, origin, cell, axis[0], axis[1], axis[2]), _depth(field, origin, cell, axis[3], axis[4], axis[5])
    )
    for s in range(1, steps):
        if depth < least:
            return depth
        t = s / steps
        depth = min(depth, _depth(field, origin, cell, axis[0] + t * dx, axis[1] + t * dy, axis[2] + t * dz))
    return depth


@inner
def _held(points, first, count, axis, radius):
    """How many of the points (4, p) from `first` up to `count` lie within a capsule."""
    ax, ay, az = np.float32(axis[0]), np.float32(axis[1]), np.float32(axis[2])
    ux, uy, uz = np.float32(axis[3]) - ax, np.float32(axis[4]) - ay, np.float32(axis[5]) - az
    square = ux * ux + uy * uy + uz * uz
    scale = np.float32(1.0) / square if square > np.float32(1e-12) else np.float32(0.0)
    reach = np.float32(radius)
    total = 0
    for i in range(first, count):
        x, y, z = points[0, i] - ax, points[1, i] - ay, points[2, i] - az
        t = min(max((x * ux + y * uy + z * uz) * scale, np.float32(0.0)), np.float32(1.0))
        x, y, z = x - t * ux, y - t * uy, z - t * uz
        most = max(reach - points[3, i], np.float32(0.0))
        total += 1 if x * x + y * y + z * z <= most * most else 0
    return total


@jit(_nrt=True)
def grow(field, origin, cell, points, slack, capsules, scale, noise, axes, tries, climbs):
    """Axes (k, 6) of bodies that stand out by `slack`, one after the other, each to hold much of what is bare: the best of some
    starts between bare points, moved as long as it gains. Points (4, p) are reordered: what stays bare
    comes first. Returns how many axes were needed, and how many points stay bare."""
    count, n, at, size = points.shape[1], 0, 0, noise.shape[0]
    best, here, trial = np.empty(6), np.empty(6), np.empty(6)
    while count > 0 and n < axes.shape[0]:
        top = -1
        for _ in range(tries):
            # first the best of a few axes between points near bare ones, then steps from there
            own, width = -1, 0.5 * scale
            for step in range(STARTS + climbs):
                which = int(abs(noise[at % size]) * 1e6) % 3 if capsules else 2
                i = int(abs(noise[(at + 1) % size]) * 1e6) % count
                j = int(abs(noise[(at + 2) % size]) * 1e6) % count if capsules else i
                push = scale * noise[(at + 3) % size]
                for c in range(3):
                    if step < STARTS:
                        trial[c] = points[c, i] + push * noise[(at + 4 + c) % size]
                        trial[3 + c] = points[c, j] + push * noise[(at + (7 if capsules else 4) + c) % size]
                    else:
                        shift = width * noise[(at + 4 + c) % size]
                        trial[c] = here[c] + (shift if which != 1 else 0.0)
                        trial[3 + c] = here[3 + c] + (shift if which != 0 else 0.0)
                at += 11
                radius = _axis_depth(field, origin, cell, trial, 0.0 - slack) + slack
                value = _held(points, 0, count, trial, radius) if radius > 0.0 else 0
                if value >= own:
                    width *= 1.6 if value > own and step >= STARTS else 1.0
                    own = value
                    here[:] = trial
                else:
                    width *= 0.93 if step >= STARTS else 1.0
                width = min(max(width, 0.02 * scale), 2.0 * scale)
            if own > top:
                top = own
                best[:] = here
        if top <= 0:
            break
        axes[n] = best
        n += 1
        # what it holds goes to the end
        radius = _axis_depth(field, origin, cell, best, -1e9) + slack
        k = 0
        while k < count:
            if _held(points, k, k + 1, best, radius) > 0:
                count -= 1
                for c in range(4):
                    points[c, k], points[c, count] = points[c, count], points[c, k]
            else:
                k += 1
    return n, count


@inner
def _needs(points, axis, out):
    """Distances out (p,) of points (4, p) to an axis."""
    ax, ay, az = np.float32(axis[0]), np.float32(axis[1]), np.float32(axis[2])
    ux, uy, uz = np.float32(axis[3]) - ax, np.float32(axis[4]) - ay, np.float32(axis[5]) - az
    square = ux * ux + uy * uy + uz * uz
    scale = np.float32(1.0) / square if square > np.float32(1e-12) else np.float32(0.0)
    for i in range(points.shape[1]):
        x, y, z = points[0, i] - ax, points[1, i] - ay, points[2, i] - az
        t = min(max((x * ux + y * uy + z * uz) * scale, np.float32(0.0)), np.float32(1.0))
        x, y, z = x - t * ux, y - t * uy, z - t * uz
        out[i] = math.sqrt(x * x + y * y + z * z) + points[3, i]


@jit(_nrt=False)
def lacks_of(field, origin, cell, points, axes, out):
    """Slack out (k, p) with which a body about each axis holds each of points (4, p)."""
    for k in range(axes.shape[0]):
        _needs(points, axes[k], out[k])
        depth = np.float32(_axis_depth(field, origin, cell, axes[k], -1e9))
        for i in range(points.shape[1]):
            out[k, i] -= depth


@jit(_nrt=False)
def corners_within(pieces, axes, out):
    """The largest distance out (k, m) of the corners of each piece (m, c, 3) to each axis, in double precision."""
    for k in range(axes.shape[0]):
        ax, ay, az = axes[k, 0], axes[k, 1], axes[k, 2]
        ux, uy, uz = axes[k, 3] - ax, axes[k, 4] - ay, axes[k, 5] - az
        square = ux * ux + uy * uy + uz * uz
        scale = 1.0 / square if square > 1e-18 else 0.0
        for i in range(pieces.shape[0]):
            most = 0.0
            for c in range(pieces.shape[1]):
                x, y, z = pieces[i, c, 0] - ax, pieces[i, c, 1] - ay, pieces[i, c, 2] - az
                t = min(max((x * ux + y * uy + z * uz) * scale, 0.0), 1.0)
                x, y, z = x - t * ux, y - t * uy, z - t * uz
                most = max(most, x * x + y * y + z * z)
            out[k, i] = math.sqrt(most)


@inner
def _two_least(out, first, second, owner):
    """Of columns out (k, p), the least value, who has it, and the next."""
    for i in range(out.shape[1]):
        a, b, who = np.float32(1e9), np.float32(1e9), 0
        for k in range(out.shape[0]):
            value = out[k, i]
            if value < a:
                a, b, who = value, a, k
            elif value < b:
                b = value
        first[i], second[i], owner[i] = a, b, who


@jit(_nrt=True)
def polish(field, origin, cell, points, slack, capsules, scale, noise, axes, rounds):
    """Move axes (k, 6) until the bodies about them hold all points (4, p) with a slack of `slack`, or as nearly as can be: the
    penalty is the sum of the squares of what is missing. Returns the largest slack of a point."""
    n, m, size, at = axes.shape[0], points.shape[1], noise.shape[0], 7
    out, own = np.empty((n, m), np.float32), np.empty(m, np.float32)
    first, second, owner = np.empty(m, np.float32), np.empty(m, np.float32), np.empty(m, np.int64)
    trial, width = np.empty(6), np.full(n, 0.3 * scale)
    lacks_of(field, origin, cell, points, axes, out)
    _two_least(out, first, second, owner)
    limit = np.float32(slack)
    penalty, bad = 0.0, 0
    for i in range(m):
        miss = max(first[i] - limit, np.float32(0.0))
        penalty += miss * miss
        bad += miss > 0.0
    for _ in range(rounds):
        if penalty <= 0.0:
            break
        # the owner of a bare point, or anyone
        k = int(abs(noise[at % size]) * 1e6) % n
        start = int(abs(noise[(at + 1) % size]) * 1e6) % m
        if noise[(at + 2) % size] > -0.8:
            for i in range(m):
                j = (start + i) % m
                if first[j] > limit:
                    k = owner[j]
                    if noise[(at + 3) % size] > 0.5:
                        near = np.float32(1e9)
                        for c in range(n):
                            if c != owner[j] and out[c, j] < near:
                                near = out[c, j]
                                k = c
                    break
        which = int(abs(noise[(at + 4) % size]) * 1e6) % 3
        for c in range(3):
            step = width[k] * noise[(at + 5 + c) % size]
            trial[c] = axes[k, c] + (step if which != 1 or not capsules else 0.0)
            trial[3 + c] = axes[k, 3 + c] + (step if which != 0 or not capsules else 0.0)
        at += 9
        depth = np.float32(_axis_depth(field, origin, cell, trial, -1e9))
        value = 1e30
        if depth > -limit:
            _needs(points, trial, own)
            value = 0.0
            for i in range(m):
                rest = second[i] if owner[i] == k else first[i]
                miss = max(min(rest, own[i] - depth) - limit, np.float32(0.0))
                value += miss * miss
        if value < penalty:
            penalty = value
            axes[k] = trial
            for i in range(m):
                out[k, i] = own[i] - depth
            _two_least(out, first, second, owner)
            width[k] = min(1.5 * width[k], scale)
        else:
            width[k] = max(0.95 * width[k], 0.01 * scale)
    most = 0.0
    for i in range(m):
        most = max(most, first[i])
    return most
