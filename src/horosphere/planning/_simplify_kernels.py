"""Shorter paths: shortcuts between points, then cut corners; and the certificate of a whole path."""

import math

import numpy as np

from ..kernels import inner
from ._edge_kernels import CERTIFIED, SAMPLED
from ._packet_kernels import called, opened, opened_task
from ._tree_kernels import motion_clear


@inner
def segment_clear(packet, a, b, v, margin, self_margin):
    """Whether the straight motion between two configurations is clear at its samples; v is overwritten."""
    length = 0.0
    for j in range(len(a)):
        v[j] = b[j] - a[j]
        length += v[j] * v[j]
    return motion_clear(packet, a, v, math.sqrt(length), np.int64(SAMPLED), margin, self_margin)


@inner
def drop_points(path, first, count, dropped):
    """Remove `dropped` points from `first` on; returns how many are left."""
    for i in range(first, count - dropped):
        for j in range(path.shape[1]):
            path[i, j] = path[i + dropped, j]
    return count - dropped


@inner
def shortcut(packet, path, count, v, margin, self_margin):
    """From each point straight to the last point that can be reached so."""
    i = 0
    while i < count - 2:
        for k in range(count - 1, i + 1, -1):
            if segment_clear(packet, path[i], path[k], v, margin, self_margin):
                count = drop_points(path, i + 1, count, k - i - 1)
                break
        i += 1
    return count


@inner
def cut_corner(packet, path, i, count, tries, least_gain, work, margin, self_margin):
    """Replace corner i by a chord between its legs, if one is clear: (points now, next corner, whether it was cut).

    The chord is the only new motion: what is left of the legs is part of motions that are clear already.
    """
    n = path.shape[1]
    v, a, b = work[0], work[1], work[2]
    before, after, product = 0.0, 0.0, 0.0
    for j in range(n):
        x, y = path[i - 1, j] - path[i, j], path[i + 1, j] - path[i, j]
        before, after, product = before + x * x, after + y * y, product + x * y
    before, after = math.sqrt(before), math.sqrt(after)
    if before < 1e-6 or after < 1e-6:
        return count, i + 1, False
    cosine, share = product / (before * after), 1.0
    for _ in range(tries):
        s, t = before * share, after * share
        s, t = min(s, 2.0 * t), min(t, 2.0 * s)
        if s + t - math.sqrt(max(s * s + t * t - 2.0 * s * t * cosine, 0.0)) < least_gain:
            break
        for j in range(n):
            a[j] = path[i, j] + (path[i - 1, j] - path[i, j]) * np.float32(s / before)
            b[j] = path[i, j] + (path[i + 1, j] - path[i, j]) * np.float32(t / after)
        share *= 0.5
        if not segment_clear(packet, a, b, v, margin, self_margin):
            continue
        inner_a, inner_b = s < 0.999 * before, t < 0.999 * after
        if inner_a and inner_b:
            if count + 1 > path.shape[0]:
                return count, i + 1, False
            for k in range(count, i, -1):
                for j in range(n):
                    path[k, j] = path[k - 1, j]
            for j in range(n):
                path[i, j], path[i + 1, j] = a[j], b[j]
            return count + 1, i + 2, True
        if inner_a or inner_b:
            for j in range(n):
                path[i, j] = a[j] if inner_a else b[j]
            return count, i + 1, True
        return drop_points(path, i, count, np.int64(1)), max(i, 1), True
    return count, i + 1, False


@called
def simplify(packet, count, rounds, tries, least_gain, margin, self_margin):
    """Shorten a path of `count` points in place; returns how many points are left."""
    path, work = opened_task(packet)[0][9], opened(packet)[2][5]
    count = shortcut(packet, path, count, work[0], margin, self_margin)
    for _ in range(rounds):
        i, changed = np.int64(1), False
        while i < count - 1:
            count, i, cut = cut_corner(packet, path, i, count, tries, least_gain, work, margin, self_margin)
            changed = changed or cut
        if not changed:
            break
        count = shortcut(packet, path, count, work[0], margin, self_margin)
    return count


@called
def certify(packet, first, count, margin, self_margin):
    """The first motion of a path, from motion `first` on, that is not certified clear, or -1."""
    path, v = opened_task(packet)[0][9], opened(packet)[2][5][0]
    for i in range(first, count - 1):
        length = 0.0
        for j in range(path.shape[1]):
            v[j] = path[i + 1, j] - path[i, j]
            length += v[j] * v[j]
        if not motion_clear(packet, path[i], v, math.sqrt(length), np.int64(CERTIFIED), margin, self_margin):
            return np.int64(i)
    return np.int64(-1)
