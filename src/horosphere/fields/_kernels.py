"""The compiled loop over balls in R^n: the field at many points, or the sampled-data motion from one.

Coordinates are relative to the goal. A world is: table (n + 5 + k, m), one row a quantity, so that the distance loop runs
along memory: the centers, radius, charge, exponent, distance of the centre
to the goal, then the gap of each ball to each of the k walls and to the sensor range; walls
(k, n + 2) = (unit normal, offset, 0) of a half-space normal.x >= offset that is free, or (centre, 0, radius) of a ball not to be
left. Entries are numbered balls, walls, sensor range. Formulas: docs/fields.md.

It is compiled on the way to a first plan, and what that costs is the compiler's front end, so much a statement: hence one
function for both uses, few arrays, no slices, comparisons for min and max.
"""

from __future__ import annotations

import math

import numpy as np

from ..kernels import jit

REACHED, STALLED, STEP_LIMIT, RAY = 0, 1, 2, 3
# places in `settings`; from DIRECTION on the direction of a given step
BOUNDARY, RANGE, BLEND, REACH, STEP, TOLERANCE, KEEP, PATIENCE, GAIN = range(9)
CODE, CLOSEST, LENGTH, BEST, SINCE, GIVEN, NEAR, DIRECTION = range(9, 17)


@jit
def walk(points, out, table, walls, general, settings, d, inward, mu, chosen):
    """With settings[STEP] = 0: out (b, n) = |x|^2 E(x) at every x of points (b, n), E the blended field of unit goal strength.

    Else the motion from points[0] into the rows of `points`: returns the number of rows, the rest in settings[CODE], [CLOSEST],
    [LENGTH]. The code RAY asks for a direction: on the unstable ray of ball settings[NEAR] the caller puts a length into
    settings[GIVEN] and a unit vector from settings[DIRECTION] on, and calls again from the last row. settings[KEEP] = 0: every step
    has full length (the papers' rule) and nothing is guaranteed. `d`, `inward`, `mu`, `chosen` (m + k + 1,) are scratch.
    """
    n, m, boundary, blend, step = points.shape[1], table.shape[1], settings[BOUNDARY], settings[BLEND], settings[STEP]
    keep = settings[KEEP]
    entries = m + table.shape[0] - n - 4
    for b in range(points.shape[0]):
        row = b
        if step > 0.0:
            row = 0
        for i in range(m):
            d[i] = 0.0
        for k in range(n):
            here = points[b, k]
            for i in range(m):
                d[i] += (here - table[k, i]) * (here - table[k, i])
        for i in range(m):
            d[i] = math.sqrt(d[i]) - table[n, i]
        d[entries - 1] = settings[RANGE]
        if walls is not None:
            for w in range(walls.shape[0]):
                flat, round2 = -walls[w, n], 0.0
                for k in range(n):
                    flat += points[b, k] * walls[w, k]
                    round2 += (points[b, k] - walls[w, k]) * (points[b, k] - walls[w, k])
                d[m + w] = flat
                if walls[w, n + 1] > 0.0:
                    d[m + w] = walls[w, n + 1] - math.sqrt(round2)
        near, least = 0, settings[RANGE]
        for i in range(entries):
            if d[i] < least:
                least = d[i]
            if i < m and d[i] < d[near]:
                near = i
        used, total = 0, 1.0
        for i in range(entries):
            if d[i] <= least + settings[REACH]:
                chosen[used] = i
                mu[used] = 1.0
                used += 1
        if used > 1 and blend == 2.0:
            total = 0.0
            for a in range(used):
                i = chosen[a]
                for c in range(used):
                    j = chosen[c]
                    lead = d[j] - d[i]
                    if c == a or lead >= boundary:
                        continue
                    lo, hi, gap = i, j, boundary
                    if c < a:
                        lo, hi = j, i
                    if hi < m:
                        apart2 = 0.0
                        for k in range(n):
                            apart2 += (table[k, lo] - table[k, hi]) * (table[k, lo] - table[k, hi])
                        gap = math.sqrt(apart2) - table[n, lo] - table[n, hi]
                    elif lo < m:
                        gap = table[n + 4 + hi - m, lo]
                    if gap > boundary:
                        gap = boundary
                    if lead <= -gap:
                        mu[a] = 0.0
                    elif lead < gap:
                        h = 0.5 + 0.5 * lead / gap
                        mu[a] *= h * h * h * (10.0 + h * (6.0 * h - 15.0))
                total += mu[a]
        # projection on the simplex: leave out what lies above the threshold
        if general is not None and used > 1 and blend < 2.0:
            kept, last, threshold = used + 1, 0, np.inf
            while kept != last:
                last = kept
                kept, excess = 0, 1.0
                for a in range(used):
                    mu[a] = 0.0
                    if d[chosen[a]] > least:
                        mu[a] = (d[chosen[a]] - least) / boundary
                    if mu[a] < threshold:
                        excess += mu[a]
                        kept += 1
                threshold = excess / kept
            for a in range(used):
                mu[a] = max(threshold - mu[a], 0.0)
        away2 = 0.0
        for k in range(n):
            out[row, k] = -points[b, k]
            away2 += points[b, k] * points[b, k]
        for a in range(used):
            i = chosen[a]
            if i < m and d[i] + table[n, i] > 0.0:
                ratio = away2 / ((d[i] + table[n, i]) * (d[i] + table[n, i]))
                if general is not None:
                    ratio = ratio ** (0.5 * table[n + 2, i])
                ratio *= mu[a] * table[n + 1, i] / total
                for k in range(n):
                    out[row, k] += ratio * (points[b, k] - table[k, i])
        if step == 0.0:
            continue
        # the motion: where does it stand?
        away = math.sqrt(away2)
        if least < settings[CLOSEST]:
            settings[CLOSEST] = least
        length = settings[GIVEN]
        if length > 0.0:
            for k in range(n):
                out[0, k] = settings[DIRECTION + k]
        size2, toward = 1e-300, 0.0
        for k in range(n):
            size2 += out[0, k] * out[0, k]
            toward -= out[0, k] * points[b, k]
        size = math.sqrt(size2)
        for i in range(m):
            inward[i] = 0.0
        for k in range(n):
            here, way = points[b, k], out[0, k] / size
            for i in range(m):
                inward[i] -= way * (here - table[k, i])
        if length == 0.0:
            settings[SINCE] += 1.0
            if away < settings[BEST] - settings[GAIN]:
                settings[BEST] = away
                settings[SINCE] = 0.0
            settings[CODE] = STEP_LIMIT
            if away <= settings[TOLERANCE]:
                settings[CODE] = REACHED
            elif settings[SINCE] > settings[PATIENCE]:
                settings[CODE] = STALLED
            elif m > 0:
                # the unstable ray: the nearest ball hides the goal exactly and the field points along the ray, or is zero
                middle, far = d[near] + table[n, near], table[n + 3, near]
                if (
                    (far - away + middle) * (far + away - middle) < 1e-8 * away * middle
                    and middle <= away
                    and (toward > (1.0 - 5e-9) * away * size or inward[near] <= 0.0)
                ):
                    settings[CODE], settings[NEAR] = RAY, near
            if settings[CODE] != STEP_LIMIT or b + 1 == points.shape[0]:
                return b + 1
            length = step
            if away < length:
                length = away
            if keep > 0.0 and toward < length * size:  # do not pass the goal
                length = toward / size
                if length < 0.0:
                    length = 0.0
        settings[GIVEN] = 0.0
        if keep > 0.0:  # the clip: leave (1 - keep) of every clearance
            for i in range(m):
                if keep * d[i] < length:
                    room = keep * d[i]
                    if room < 0.0:
                        room = 0.0
                    closing = inward[i] / (d[i] + table[n, i])
                    if room < length * closing:
                        length = room / closing
            if walls is not None:
                for w in range(walls.shape[0]):
                    if keep * d[m + w] < length:
                        normal, chord, radius = 0.0, 0.0, walls[w, n + 1]
                        for k in range(n):
                            normal -= out[0, k] / size * walls[w, k]
                            chord -= out[0, k] / size * (points[b, k] - walls[w, k])
                        if radius == 0.0:
                            if keep * d[m + w] < length * normal:
                                length = keep * d[m + w] / normal
                        else:  # keep times the chord ahead: c + sqrt(c^2 + e) with e = radius^2 - |y|^2, c = -u.y
                            inside = d[m + w] * (2.0 * radius - d[m + w])
                            root = math.sqrt(chord * chord + inside)
                            ahead = chord + root
                            if chord < 0.0:
                                ahead = inside / (root - chord)
                            if keep * ahead < length:
                                length = keep * ahead
        for i in range(m):  # the least distance where it lies inside the piece; its ends are looked at anyway
            if d[i] - length < settings[CLOSEST] and inward[i] > 0.0 and inward[i] < length:
                middle = d[i] + table[n, i]
                dip = math.sqrt((middle - inward[i]) * (middle + inward[i])) - table[n, i]
                if dip < settings[CLOSEST]:
                    settings[CLOSEST] = dip
        for k in range(n):
            points[b + 1, k] = points[b, k] + length / size * out[0, k]
        settings[LENGTH] += length
    return points.shape[0]


@jit
def walk_indexed(
    points, out, grid, starts, entries, unit, fuzz, records, table, few, walls, general, settings, d, inward, mu, chosen
):
    """out (b, n) as by `walk`, with the balls that can matter looked up in a grid of cells.

    grid (3, n) = lowest corner, cells per metre, cells on each axis; cell c holds entries[starts[c] : starts[c + 1]] = (ball,
    its distance from the middle of the cell in units), the nearest first; points outside take all balls. The search of a
    cell ends where no later ball can have a weight here. The table of those that may have one, from their records (m,
    rows) and in the order of their numbers, gives the same sum. `few` is scratch for the longest cell.
    """
    n, rows = points.shape[1], table.shape[0]
    for b in range(points.shape[0]):
        cell, off = 0, 0.0
        for k in range(n):
            scaled = (points[b, k] - grid[0, k]) * grid[1, k]
            at = math.floor(scaled)
            off += ((scaled - at - 0.5) / grid[1, k]) * ((scaled - at - 0.5) / grid[1, k])
            if at < 0 or at >= grid[2, k] or cell < 0:
                cell = -1
            else:
                cell = cell * int(grid[2, k]) + int(at)
        if cell < 0:
            walk(points[b : b + 1], out[b : b + 1], table, walls, general, settings, d, inward, mu, chosen)
            continue
        first, last, seen = starts[cell], starts[cell + 1], 0
        reach, least = settings[REACH] + fuzz, np.inf
        room = (reach + math.sqrt(off)) / unit
        for c in range(first, last):
            if entries[c, 1] > least / unit + room:
                break
            i, square = entries[c, 0], 0.0
            for k in range(n):
                square += (points[b, k] - records[i, k]) * (points[b, k] - records[i, k])
            d[seen] = math.sqrt(square) - records[i, n]
            if d[seen] < least:
                least = d[seen]
            seen += 1
        used = 0
        for c in range(seen):
            if d[c] <= least + reach:
                i, a = entries[first + c, 0], used
                while a > 0 and chosen[a - 1] > i:
                    chosen[a] = chosen[a - 1]
                    a -= 1
                chosen[a] = i
                used += 1
        for a in range(used):
            for r in range(rows):
                few[r * used + a] = records[chosen[a], r]
        near = few[: rows * used].reshape((rows, used))
        walk(points[b : b + 1], out[b : b + 1], near, walls, general, settings, d, inward, mu, chosen)


@jit
def sift(centers, radii, middle, half, parent, starts, balls, spare, first, kept, d):
    """Of every box (middle (b, n), half diagonal (b,)) the balls of its parent's list that can count anywhere in it.

    Numbers of balls (b + 1,) so far into `first`, and the balls into `kept` unless that is empty; `d` (m,) is scratch.
    """
    n = centers.shape[1]
    count = 0
    first[0] = 0
    for b in range(middle.shape[0]):
        low, high = starts[parent[b]], starts[parent[b] + 1]
        least = np.inf
        for c in range(low, high):
            i, square = balls[c], 0.0
            for k in range(n):
                square += (middle[b, k] - centers[i, k]) * (middle[b, k] - centers[i, k])
            d[c - low] = math.sqrt(square) - radii[i]
            least = min(least, d[c - low])
        least += 2.0 * half[b] + spare
        for c in range(low, high):
            if d[c - low] <= least:
                if kept.shape[0] > 0:
                    kept[count] = balls[c]
                count += 1
        first[b + 1] = count


@jit
def arrange(centers, radii, middle, order, starts, balls, unit, first, entries, d):
    """The list of every cell, in the order of the grid, as `walk_indexed` reads it: nearest to the middle first."""
    n = centers.shape[1]
    for cell in range(order.shape[0]):
        b = order[cell]
        base, low = first[cell], starts[b]
        for c in range(starts[b + 1] - low):
            i, square = balls[low + c], 0.0
            for k in range(n):
                square += (middle[b, k] - centers[i, k]) * (middle[b, k] - centers[i, k])
            away, at = math.sqrt(square) - radii[i], c
            while at > 0 and d[at - 1] > away:
                d[at] = d[at - 1]
                entries[base + at, 0], entries[base + at, 1] = entries[base + at - 1, 0], entries[base + at - 1, 1]
                at -= 1
            d[at] = away
            entries[base + at, 0], entries[base + at, 1] = i, math.floor(away / unit)
