"""The reactive law: straight to the goal, but no body may approach what is near faster than its gap allows.

At q, the wish u = goal - q (shortened to one step) is projected on the cone of all a.u >= -gamma (gap - margin), one row for the
nearest ball of every body and every solid within sight, and of every pair of bodies; the projection is by Gauss and Seidel
with multipliers >= 0 (Hildreth's method). Every step is checked by `edge_clear` and shortened where it is not clear.

  room = (points (4, padded balls), gaps (padded balls), rows (K, n), limits (K,), weights (K,), multipliers (K,), u, v, best,
    middles (3, G), body_of (G,)): centres of balls and groups in the base, what was found, working memory
"""

import math

import numpy as np

from ..kernels import inner, jit, lane_sqrt, load_lanes, store_lanes
from ._edge_kernels import LANES, SAMPLED, WIDTH, place_frames, square_from
from ._packet_kernels import opened
from ._tree_kernels import motion_clear

PROBE = 1e-3  # metres between the points from which the direction away from a solid is read
FURTHER = 6  # steps without getting nearer before it gives up


@inner
def distance_to(kind, i, x, y, z, packet):
    """Distances of points on lanes from one solid, zero inside (of a capsule negative)."""
    model, world, scratch = opened(packet)
    square, more = square_from(kind, i, x, y, z, world)
    return lane_sqrt(square) - more


@inner
def add_slope(row, sign, x, y, z, nx, ny, nz, frame, stop, packet):
    """Add sign n . dx/dq of a point fixed to `frame`, seen from frame `stop`, to a row."""
    model, world, scratch = opened(packet)
    joints, joint_data, frames = model[0], model[1], scratch[0]
    f = frame
    while f != stop:
        k = 12 * WIDTH * f
        ax, ay, az = frames[k + 6 * WIDTH], frames[k + 7 * WIDTH], frames[k + 8 * WIDTH]
        dx, dy, dz = x - frames[k + 9 * WIDTH], y - frames[k + 10 * WIDTH], z - frames[k + 11 * WIDTH]
        turn = nx * (ay * dz - az * dy) + ny * (az * dx - ax * dz) + nz * (ax * dy - ay * dx)
        push = nx * ax + ny * ay + nz * az
        row[joints[f, 1]] += sign * (turn * joint_data[f, 12] + push * joint_data[f, 14])
        f = joints[f, 0]


@jit(_nrt=False)
def near_rows(q, sight, self_sight, room, packet):
    """Fills rows and limits (gaps) with everything within `sight` (m) of q; returns how many there are."""
    model, world, scratch = opened(packet)
    joints, joint_data, bodies, body_balls, groups, group_balls, balls, pairs, group_pairs = model
    frames, ramp = scratch[0], scratch[4]
    points, gaps, rows, limits, weights, multipliers, u, v, best, middles, body_of = room
    reach = world[5]
    n = q.shape[0]
    for j in range(n):
        v[j] = 0.0
    place_frames(q, v, load_lanes(ramp, 0, LANES), joints, joint_data, frames)
    for c in range(bodies.shape[0]):
        k = 12 * WIDTH * bodies[c, 0]
        for b in range(groups[bodies[c, 1], 0], groups[bodies[c, 2] - 1, 1]):
            for i in range(3):
                points[i, b] = (
                    frames[k + (9 + i) * WIDTH]
                    + frames[k + i * WIDTH] * balls[b, 0]
                    + frames[k + (3 + i) * WIDTH] * balls[b, 1]
                    + frames[k + (6 + i) * WIDTH] * balls[b, 2]
                )
            points[3, b] = balls[b, 3]
        for g in range(bodies[c, 1], bodies[c, 2]):
            body_of[g] = c
            for i in range(3):
                middles[i, g] = (
                    frames[k + (9 + i) * WIDTH]
                    + frames[k + i * WIDTH] * group_balls[g, 0]
                    + frames[k + (3 + i) * WIDTH] * group_balls[g, 1]
                    + frames[k + (6 + i) * WIDTH] * group_balls[g, 2]
                )
    width, count = points.shape[1], 0
    probes = load_lanes(best, 0, LANES)
    for kind in range(5):
        most = np.int64(0)
        for c in range(bodies.shape[0]):
            most = max(most, reach[c, kind])
        for i in range(most):
            for b in range(0, balls.shape[0], WIDTH):
                x, y, z = (
                    load_lanes(points, b, LANES),
                    load_lanes(points, width + b, LANES),
                    load_lanes(points, 2 * width + b, LANES),
                )
                store_lanes(gaps, b, distance_to(kind, i, x, y, z, packet) - load_lanes(points, 3 * width + b, LANES))
            for g in range(groups.shape[0]):
                c = body_of[g]
                touching = i < 63 and (reach[c, 5 + kind] >> i) & 1  # it may
                if bodies[c, 0] == 0 or i >= reach[c, kind] or touching or count == rows.shape[0]:
                    continue
                least, nearest = np.float32(sight), np.int64(-1)
                for b in range(groups[g, 0], groups[g, 1]):
                    if gaps[b] < least:
                        least, nearest = gaps[b], b
                if nearest < 0:
                    continue
                x, y, z = points[0, nearest], points[1, nearest], points[2, nearest]
                for axis in range(3):  # lanes 0, 1, 2: a little further along each axis; 3, 4, 5: a little back
                    for lane in range(WIDTH):
                        best[axis * WIDTH + lane] = points[axis, nearest]
                    best[axis * WIDTH + axis] += PROBE
                    best[axis * WIDTH + axis + 3] -= PROBE
                probes = distance_to(
                    kind,
                    i,
                    load_lanes(best, 0, LANES),
                    load_lanes(best, WIDTH, LANES),
                    load_lanes(best, 2 * WIDTH, LANES),
                    packet,
                )
                store_lanes(best, 0, probes)
                nx, ny, nz = best[0] - best[3], best[1] - best[4], best[2] - best[5]
                length = math.sqrt(nx * nx + ny * ny + nz * nz)
                if length == 0.0:
                    continue
                for j in range(n):
                    rows[count, j] = 0.0
                add_slope(
                    rows[count], 1.0, x, y, z, nx / length, ny / length, nz / length, bodies[c, 0], joints[0, 0], packet,
                )  # fmt: skip
                limits[count] = least
                count += 1
    for p in range(pairs.shape[0]):
        least, first, second = self_sight, np.int64(-1), np.int64(-1)
        ca, cb, stop = pairs[p, 0], pairs[p, 1], pairs[p, 2]
        for k in range(pairs[p, 3], pairs[p, 4]):
            ga, gb = group_pairs[k, 0], group_pairs[k, 1]
            dx, dy, dz = (
                middles[0, ga] - middles[0, gb],
                middles[1, ga] - middles[1, gb],
                middles[2, ga] - middles[2, gb],
            )
            r = group_balls[ga, 3] + group_balls[gb, 3] + least
            if dx * dx + dy * dy + dz * dz > r * r:
                continue
            for a in range(groups[ga, 0], groups[ga, 1]):
                for b in range(groups[gb, 0], groups[gb, 1]):
                    dx, dy, dz = points[0, a] - points[0, b], points[1, a] - points[1, b], points[2, a] - points[2, b]
                    r = points[3, a] + points[3, b] + least
                    square = dx * dx + dy * dy + dz * dz
                    if square < r * r:
                        least, first, second = math.sqrt(square) - (r - least), a, b
        if first < 0 or count == rows.shape[0]:
            continue
        dx, dy, dz = (
            points[0, first] - points[0, second],
            points[1, first] - points[1, second],
            points[2, first] - points[2, second],
        )
        length = math.sqrt(dx * dx + dy * dy + dz * dz) + 1e-12
        nx, ny, nz = dx / length, dy / length, dz / length
        for j in range(n):
            rows[count, j] = 0.0
        add_slope(
            rows[count], 1.0, points[0, first], points[1, first], points[2, first], nx, ny, nz, bodies[ca, 0], stop, packet,
        )  # fmt: skip
        add_slope(
            rows[count], -1.0, points[0, second], points[1, second], points[2, second], nx, ny, nz, bodies[cb, 0], stop, packet,
        )  # fmt: skip
        limits[count] = least
        count += 1
    return count


@jit(_nrt=False)
def project(u, count, gain, margin, sweeps, room):
    """The u nearest to the wish with rows . u >= -gain (gap - margin), approached by `sweeps` sweeps."""
    points, gaps, rows, limits, weights, multipliers, wish, v, best, middles, body_of = room
    n = u.shape[0]
    for k in range(count):
        total = 1e-9
        for j in range(n):
            total += rows[k, j] * rows[k, j]
        weights[k], multipliers[k] = total, 0.0
    for _ in range(sweeps):
        largest = 0.0
        for k in range(count):
            room_left = limits[k] - margin
            bound = -gain * room_left if room_left > 0.0 else -room_left
            speed = 0.0
            for j in range(n):
                speed += rows[k, j] * u[j]
            before = multipliers[k]
            after = max(before + (bound - speed) / weights[k], 0.0)
            if after != before:
                multipliers[k] = after
                for j in range(n):
                    u[j] += (after - before) * rows[k, j]
                largest = max(largest, abs(after - before) * math.sqrt(weights[k]))
        if largest < 1e-4:
            break


@jit(_nrt=False)
def follow(packet, goal, first, most, step, sight, self_sight, gain, barrier, sweeps, low, high, path, margin, self_margin,
           q, room):  # fmt: skip
    """Follow the law from path[first - 1] to `goal`; appends to the path. Points now, or minus that where it got stuck."""
    u, v = room[6], room[7]
    n = goal.shape[0]
    for j in range(n):
        q[j] = path[first - 1, j]
    count, nearest, since = first, 1e9, 0
    for turn in range(most):
        distance = 0.0
        for j in range(n):
            u[j] = goal[j] - q[j]
            v[j] = u[j]
            distance += u[j] * u[j]
        distance = math.sqrt(distance)
        if count + 1 >= path.shape[0]:
            return -count
        if turn % 4 == 0 and motion_clear(packet, q, v, distance, np.int64(SAMPLED), margin, self_margin):
            for j in range(n):
                path[count, j] = goal[j]
            return count + 1
        if distance < nearest - 0.1 * step:
            nearest, since = distance, turn
        elif turn - since > FURTHER:
            return -count
        rows = near_rows(q, sight, self_sight, room, packet)
        for j in range(n):
            u[j] = (goal[j] - q[j]) * np.float32(min(1.0, step / max(distance, 1e-9)))
        project(u, rows, gain, barrier, sweeps, room)
        for j in range(n):
            u[j] = min(max(u[j], low[j] - q[j]), high[j] - q[j])
        moved = False
        for _ in range(4):
            length = 0.0
            for j in range(n):
                v[j] = u[j]
                length += u[j] * u[j]
            length = math.sqrt(length)
            if length < 0.02 * step:
                break
            if motion_clear(packet, q, v, length, np.int64(SAMPLED), margin, self_margin):
                moved = True
                break
            for j in range(n):
                u[j] *= 0.4
        if not moved:
            return -count
        for j in range(n):
            q[j] += v[j]
            path[count, j] = q[j]
        count += 1
    return -count
