"""Compiled loops over balls in R^n: one evaluation of the field, the batch, the sampled-data trace.

A world is: goal (n,); centers (n, m), one row a coordinate, so that the distance loop runs along memory;
balls (3, m) = radius, charge, exponent; walls (k, n + 2) = (unit normal, offset, 0) of a half-space normal.x >= offset
that is free, or (centre, 0, radius) of a ball not to be left; options (3,) = boundary width, sensor range (inf: none),
blend (0 nearest, 1 simplex, 2 smooth, 3 sum). Entries are numbered balls, walls, range.
Formulas: docs/fields.md. Few functions with plain loops: what is here is compiled on the way to a first plan.
"""

from __future__ import annotations

import math

import numpy as np

from ..kernels import jit

REACHED, STALLED, STEP_LIMIT = 0, 1, 2


@jit
def evaluate(x, goal, centers, balls, walls, options, d, mu, chosen, e):
    """e = |x - g|^2 E(x), E the blended field with unit goal strength; d, mu, chosen (entries,) are scratch; the least clearance."""
    n, m = centers.shape
    delta, blend = options[0], options[2]
    for i in range(m):
        d[i] = 0.0
    for k in range(n):
        for i in range(m):
            d[i] += (x[k] - centers[k, i]) * (x[k] - centers[k, i])
    for i in range(m):
        d[i] = math.sqrt(d[i]) - balls[0, i]
    entries = m
    for w in range(walls.shape[0]):
        s, t = -walls[w, n], 0.0
        for k in range(n):
            s += x[k] * walls[w, k]
            t += (x[k] - walls[w, k]) ** 2
        if walls[w, n + 1] > 0.0:
            s = walls[w, n + 1] - math.sqrt(t)
        d[entries] = s
        entries += 1
    if options[1] < np.inf:
        d[entries] = options[1]
        entries += 1
    least = np.inf
    for i in range(entries):
        least = min(least, d[i])
    reach = least
    if blend == 1.0:
        reach += delta
    elif blend == 2.0:
        reach += 2.0 * delta
    elif blend == 3.0:
        reach = np.inf
    used = 0
    for i in range(entries):
        if d[i] < reach or d[i] == least:
            chosen[used] = i
            used += 1
    if used == 1 or blend == 3.0:
        for a in range(used):
            mu[a] = 1.0
    elif blend == 2.0:
        total = 0.0
        for a in range(used):
            i = chosen[a]
            v = 1.0
            for b in range(used):
                j = chosen[b]
                t = d[j] - d[i]
                if j == i or t >= delta or v == 0.0:
                    continue
                lo, hi = min(i, j), max(i, j)
                gap = delta
                if hi < m:
                    s = 0.0
                    for k in range(n):
                        s += (centers[k, lo] - centers[k, hi]) ** 2
                    gap = math.sqrt(s) - balls[0, lo] - balls[0, hi]
                elif lo < m and hi < m + walls.shape[0]:
                    gap, s = -walls[hi - m, n], 0.0
                    for k in range(n):
                        gap += centers[k, lo] * walls[hi - m, k]
                        s += (centers[k, lo] - walls[hi - m, k]) ** 2
                    if walls[hi - m, n + 1] > 0.0:
                        gap = walls[hi - m, n + 1] - math.sqrt(s)
                    gap -= balls[0, lo]
                elif hi >= m + walls.shape[0]:
                    gap = options[1]
                t = 0.5 + 0.5 * t / max(min(delta, gap), 1e-300)
                t = min(max(t, 0.0), 1.0)
                v *= t * t * t * (10.0 + t * (6.0 * t - 15.0))
            mu[a] = v
            total += v
        for a in range(used):
            mu[a] /= total
    else:  # projection on the simplex: leave out what lies above the threshold until nothing does
        kept, tau = -1, 0.0
        while kept != used:
            kept = used
            tau = 1.0
            for a in range(kept):
                tau += (d[chosen[a]] - least) / max(delta, 1e-300)
            tau /= kept
            used = 0
            for a in range(kept):
                if (d[chosen[a]] - least) / max(delta, 1e-300) < tau:
                    chosen[used] = chosen[a]
                    used += 1
        for a in range(used):
            mu[a] = tau - (d[chosen[a]] - least) / max(delta, 1e-300)
    r2 = 0.0
    for k in range(n):
        e[k] = goal[k] - x[k]
        r2 += e[k] * e[k]
    for a in range(used):
        i = chosen[a]
        if i < m and d[i] + balls[0, i] > 0.0:
            y = d[i] + balls[0, i]
            ratio = r2 / (y * y)
            if balls[2, i] != 2.0:
                ratio = ratio ** (0.5 * balls[2, i])
            for k in range(n):
                e[k] += mu[a] * balls[1, i] * ratio * (x[k] - centers[k, i])
    return least


@jit
def evaluate_batch(points, goal, centers, balls, walls, options, work, chosen, out, clearance):
    """|x - g|^2 E and the least clearance at points (b, n); work (2, entries), chosen (entries,) are scratch."""
    for b in range(points.shape[0]):
        clearance[b] = evaluate(points[b], goal, centers, balls, walls, options, work[0], work[1], chosen, out[b])


@jit
def trace(x0, goal, centers, balls, walls, options, motion, points, work, chosen, result):
    """The sampled-data motion from x0 into `points`; returns the number of points.

    motion = (step, tolerance, gamma, clip); work (2, entries), chosen (entries,) are scratch; result (4 + 2 n) = code, least
    clearance, length, sideways steps, then scratch. With clip = 0 every step has the full length (the papers' rule) and nothing
    is guaranteed.
    """
    n, m = centers.shape
    step, tolerance, gamma = motion[0], motion[1], motion[2]
    x, u, d = result[4 : 4 + n], result[4 + n :], work[0]
    start = 0.0
    for k in range(n):
        x[k] = x0[k]
        points[0, k] = x0[k]
        start += (x0[k] - goal[k]) ** 2
    start = math.sqrt(start)
    patience = max(500.0, 4.0 * start / step)
    count, since, code = 1, 0, STEP_LIMIT
    closest, length, sideways, best = np.inf, 0.0, 0.0, start
    while True:
        closest = min(closest, evaluate(x, goal, centers, balls, walls, options, d, work[1], chosen, u))
        r, s = 0.0, 0.0
        for k in range(n):
            r += (x[k] - goal[k]) ** 2
            s += u[k] * u[k]
        r, s = math.sqrt(r), math.sqrt(s)
        since += 1
        if r < best - 1e-12 * start:
            best, since = r, 0
        if r <= tolerance:
            code = REACHED
        elif since > patience:
            code = STALLED
        if r <= tolerance or since > patience or count == points.shape[0]:
            break
        # the unstable ray: the nearest ball hides the goal exactly and the field points along the ray, or is zero
        i, side, axis = 0, 1.0, 0
        if m > 0:
            for j in range(m):
                if d[j] < d[i]:
                    i = j
            side, turned, inward, flat = 0.0, 0.0, 0.0, 2.0
            for k in range(n):
                u[k] /= max(s, 1e-300)
                ray = (x[k] - goal[k]) / r
                normal = (x[k] - centers[k, i]) / (d[i] + balls[0, i])
                side += (normal - ray) ** 2
                turned += (u[k] + ray) ** 2
                inward -= u[k] * normal
                if abs(ray) < flat:
                    flat, axis = abs(ray), k
            if (turned > 1e-8 and inward > 0.0) or d[i] + balls[0, i] > r:
                side = 1.0
        else:
            for k in range(n):
                u[k] /= s
        lean = 0.05
        if side < 1e-8:
            sideways += 1.0
            if (
                d[i] < 1e-9 * balls[0, i]
            ):  # at the unstable point itself: along the surface, the one step that gains nothing
                lean = 0.0
            flat = (x[axis] - goal[axis]) / r
            for k in range(n):
                ray = (x[k] - goal[k]) / r
                t = -flat * ray
                if k == axis:
                    t += 1.0
                t /= math.sqrt(1.0 - flat * flat)
                u[k] = (lean * t - ray) / math.sqrt(1.0 + lean * lean) if lean > 0.0 else t
        s = min(step, r)
        if lean == 0.0:
            s = min(s, 0.001 * balls[0, i])
        if motion[3] != 0.0:  # the clip: keep (1 - gamma) of every clearance, do not pass the goal
            t = 0.0
            for k in range(n):
                t -= u[k] * (x[k] - goal[k])
            if lean > 0.0:
                s = min(s, max(t, 0.0))
            for i in range(m + walls.shape[0]):
                room = gamma * max(d[i], 0.0)
                if room < s:
                    t = 0.0
                    if i < m:
                        for k in range(n):
                            t -= u[k] * (x[k] - centers[k, i]) / (d[i] + balls[0, i])
                    elif walls[i - m, n + 1] == 0.0:
                        for k in range(n):
                            t -= u[k] * walls[i - m, k]
                    else:  # gamma times the chord ahead: b + sqrt(b^2 + c) with c = radius^2 - |y|^2, b = -u.y
                        radius = walls[i - m, n + 1]
                        for k in range(n):
                            t -= u[k] * (x[k] - walls[i - m, k])
                        y = d[i] * (2.0 * radius - d[i])
                        root = math.sqrt(t * t + max(y, 0.0))
                        s = min(s, gamma * (max(y, 0.0) / (root - t) if t < 0.0 else root + t))
                        t = 0.0
                    if room < s * t:
                        s = room / t
        for i in range(m):  # exact least distance along the segment
            if d[i] - s < closest:
                t = 0.0
                for k in range(n):
                    t -= u[k] * (x[k] - centers[k, i])
                t = min(max(t, 0.0), s)
                y = 0.0
                for k in range(n):
                    y += (x[k] + t * u[k] - centers[k, i]) ** 2
                closest = min(closest, math.sqrt(y) - balls[0, i])
        for k in range(n):
            x[k] += s * u[k]
            points[count, k] = x[k]
        length += s
        count += 1
    result[0], result[1], result[2], result[3] = code, closest, length, sideways
    return count


@jit
def evaluate_indexed(points, goal, grid, starts, blocks, walls, options, work, chosen, out, clearance):
    """As `evaluate_batch`, with the balls that can matter looked up in a grid of cells.

    grid (3, n) = lowest corner, cells per metre, cells on each axis; the balls of cell c are packed in blocks[starts[c] :
    starts[c + 1]] as n + 3 rows of centers and balls; the last cell holds all balls and serves the points outside.
    """
    n = goal.shape[0]
    for b in range(points.shape[0]):
        cell = 0
        for k in range(n):
            at = math.floor((points[b, k] - grid[0, k]) * grid[1, k])
            if at < 0 or at >= grid[2, k] or cell < 0:
                cell = -1
            else:
                cell = cell * int(grid[2, k]) + int(at)
        if cell < 0:
            cell = starts.shape[0] - 2
        first, last = starts[cell], starts[cell + 1]
        m = (last - first) // (n + 3)
        centers = blocks[first : first + n * m].reshape((n, m))
        balls = blocks[first + n * m : last].reshape((3, m))
        clearance[b] = evaluate(points[b], goal, centers, balls, walls, options, work[0], work[1], chosen, out[b])
