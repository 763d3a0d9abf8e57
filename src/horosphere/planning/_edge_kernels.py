"""Is a straight joint motion free of contact? Sixteen configurations at a time, float32, one in each lane.

Data (made by `_tree_model` and `_world_kernels`, passed as a packet, see `_packet_kernels`):
  model = (joints, joint_data, bodies, body_balls, groups, group_balls, balls, pairs, group_pairs)
    joints (F, 2)        parent frame, coordinate; frame 0 is the base, its row is not read
    joint_data (F, 16)   axes x, y, z and origin of the joint frame in its parent; turn and its offset, slide and its offset
    bodies (C, 3)        all that is fixed to one frame: the frame, first group, last group + 1
    groups (G, 2)        compact parts of bodies: first ball, last ball + 1
    body_balls (C, 4), group_balls (G, 4), balls (B, 4): centre in the frame, radius; a ball round it all, but for balls
    pairs (P, 5)         two bodies, the last common ancestor of their frames, first and last + 1 of
    group_pairs (K, 2)   the groups of theirs that are checked against each other, those of one group together
  world = (upright, boxes, cylinders, capsules, ellipsoids, reach): solids by kind, nearest to the root first;
    reach (C, 10): how many of each kind body c can come near to; bits: those of the first 63 of each kind that it may touch
  scratch = (frames, centres, near, stack, ramp, work): lanes of the frames (12 each), of ball centres; solids (8 index + kind);
    pieces of a motion still to be certified; (1, 2, .. 16) / 16 and 0, 1, .. 15; three configurations, for the callers

Motions are q + t v, t in [0, 1]. Distances are compared as squares: no root in the inner loops.
"""

import numpy as np

from ..kernels import inner, lane_mask_lt, load_columns, load_lanes, load_records, store_columns
from ._edge_frames_kernels import LANES, WIDTH, motion_bound, place_frames
from ._edge_frames_kernels import carried_inline as _carried
from ._packet_kernels import called, opened
from ._world_kernels import box_square, cylinder_square, ellipsoid_square, segment_square, upright_square

CONTACT, UNDECIDED, CLEAR = -1, 0, 1
SAMPLED, CERTIFIED, WHOLE = 0, 1, 2
STACK = 4096
SMALLEST = 1e-5  # share of a motion below which it is not halved again
WIDEN = 3e-7  # added to half widths of pieces: covers the rounding of their middles

_upright, _box, _cylinder = upright_square.inline, box_square.inline, cylinder_square.inline
_segment, _ellipsoid = segment_square.inline, ellipsoid_square.inline


@inner(forceinline=True)
def square_from(kind, i, x, y, z, world):
    """Squared distances of points on lanes from one solid (of a capsule, from its axis), and its radius (of a capsule)."""
    upright, boxes, cylinders, capsules, ellipsoids, reach = world
    if kind == 0:
        return _upright(x, y, z, *load_records(upright, i, 8, (0,)))[0], np.float32(0.0)
    if kind == 1:
        return _box(x, y, z, *load_records(boxes, i, 16, (0,)))[0], np.float32(0.0)
    if kind == 2:
        return _cylinder(x, y, z, *load_records(cylinders, i, 8, (0,)))[0], np.float32(0.0)
    if kind == 3:
        return _segment(x, y, z, *load_records(capsules, i, 8, (0,)))[0], capsules[i, 7]
    return _ellipsoid(x, y, z, *load_records(ellipsoids, i, 16, (0,)))[0], np.float32(0.0)


@inner
def come_near(c, x, y, z, r, packet):
    """Fills `near` with the solids that balls of radius r round points of body c meet in some lane: 8 index + kind each."""
    model, world, scratch = opened(packet)
    reach, near = world[5], scratch[2]
    count = 0
    for kind in range(5):
        for i in range(reach[c, kind]):
            if i < 63 and (reach[c, 5 + kind] >> i) & 1:  # it may touch this one
                continue
            square, more = square_from(kind, i, x, y, z, world)
            R = r + more
            if lane_mask_lt(square, R * R):
                near[count] = 8 * i + kind
                count += 1
    return count


@inner(forceinline=True)
def ball_unclear(count, x, y, z, r, r0, packet):
    """Lanes (bits) where a ball of radius r meets one of the `count` solids in `near`; -1 if one of radius r0 does."""
    model, world, scratch = opened(packet)
    near = scratch[2]
    unclear = 0
    for k in range(count):
        square, more = square_from(near[k] & 7, near[k] >> 3, x, y, z, world)
        R = r + more
        hit = lane_mask_lt(square, R * R)
        if hit:
            unclear |= hit
            R0 = r0 + more
            if lane_mask_lt(square, R0 * R0):
                return -1
    return unclear


@inner(forceinline=True)
def body_clear(c, half, v, how, margin, packet):
    """As `block_clear`, of one body against the solids; the frames are placed already."""
    model, world, scratch = opened(packet)
    joints, joint_data, bodies, body_balls, groups, group_balls, balls, pairs, group_pairs = model
    frames, centres = scratch[0], scratch[1]
    unclear, moving, base = 0, how == CERTIFIED, joints[0, 0]
    f = bodies[c, 0]
    frame = load_columns(frames, 12 * WIDTH * f, 12, LANES)
    x, y, z = _carried(*frame, *load_records(body_balls, c, 4, (0,)))
    store_columns(centres, 3 * WIDTH * c, (x, y, z))
    if f == 0:  # what no joint moves stands where it stands
        return unclear
    nothing = half * 0.0
    r = nothing + (body_balls[c, 3] + margin)
    if moving:
        r = r + motion_bound(f, base, x, y, z, half, v, packet)
    count = come_near(c, x, y, z, r, packet)
    if count == 0:
        return unclear
    for g in range(bodies[c, 1], bodies[c, 2]):
        if bodies[c, 2] - bodies[c, 1] > 1:
            x, y, z = _carried(*frame, *load_records(group_balls, g, 4, (0,)))
            r = nothing + (group_balls[g, 3] + margin)
            if moving:
                r = r + motion_bound(f, base, x, y, z, half, v, packet)
            if not ball_unclear(count, x, y, z, r, r, packet):
                continue
        for b in range(groups[g, 0], groups[g, 1]):
            x, y, z = _carried(*frame, *load_records(balls, b, 4, (0,)))
            r0 = nothing + (balls[b, 3] + margin)
            r = r0
            if moving:
                r = r + motion_bound(f, base, x, y, z, half, v, packet)
            found = ball_unclear(count, x, y, z, r, r0, packet)
            if found < 0:
                return -1
            unclear |= found
    return unclear


@inner(forceinline=True)
def pair_clear(p, half, v, how, margin, packet):
    """As `block_clear`, of two bodies against each other; the centres of the bodies are placed already."""
    model, world, scratch = opened(packet)
    joints, joint_data, bodies, body_balls, groups, group_balls, balls, pairs, group_pairs = model
    frames, centres, near, stack, ramp, work = scratch
    unclear, moving = 0, how == CERTIFIED
    nothing = half * 0.0
    ca, cb, stop = pairs[p, 0], pairs[p, 1], pairs[p, 2]
    fa, fb = bodies[ca, 0], bodies[cb, 0]
    ax, ay, az = load_columns(centres, 3 * WIDTH * ca, 3, LANES)
    cx, cy, cz = load_columns(centres, 3 * WIDTH * cb, 3, LANES)
    rc = nothing + (body_balls[cb, 3] + margin)
    if moving:
        rc = rc + motion_bound(fb, stop, cx, cy, cz, half, v, packet)
    r = rc + body_balls[ca, 3]
    if moving:
        r = r + motion_bound(fa, stop, ax, ay, az, half, v, packet)
    dx, dy, dz = ax - cx, ay - cy, az - cz
    if not lane_mask_lt(dx * dx + dy * dy + dz * dz, r * r):
        return unclear
    frame_a = load_columns(frames, 12 * WIDTH * fa, 12, LANES)
    frame_b = load_columns(frames, 12 * WIDTH * fb, 12, LANES)
    last = (
        3 * WIDTH * bodies.shape[0]
    )  # behind the centres of the bodies: balls of a that are near b, with radius and motion
    before, apart = -1, False
    gx, gy, gz, rg = ax, ay, az, r
    for k in range(pairs[p, 3], pairs[p, 4]):
        ga, gb = group_pairs[k, 0], group_pairs[k, 1]
        if ga != before:
            before = ga
            gx, gy, gz = _carried(*frame_a, *load_records(group_balls, ga, 4, (0,)))
            rg = nothing + group_balls[ga, 3]
            if moving:
                rg = rg + motion_bound(fa, stop, gx, gy, gz, half, v, packet)
            dx, dy, dz, r = gx - cx, gy - cy, gz - cz, rg + rc
            apart = lane_mask_lt(dx * dx + dy * dy + dz * dz, r * r) == 0
        if apart:
            continue
        bx, by, bz = _carried(*frame_b, *load_records(group_balls, gb, 4, (0,)))
        rb = nothing + (group_balls[gb, 3] + margin)
        if moving:
            rb = rb + motion_bound(fb, stop, bx, by, bz, half, v, packet)
        dx, dy, dz, r = gx - bx, gy - by, gz - bz, rg + rb
        if not lane_mask_lt(dx * dx + dy * dy + dz * dz, r * r):
            continue
        found = 0
        for a in range(groups[ga, 0], groups[ga, 1]):
            ax, ay, az = _carried(*frame_a, *load_records(balls, a, 4, (0,)))
            ra = nothing + balls[a, 3]
            if moving:
                ra = ra + motion_bound(fa, stop, ax, ay, az, half, v, packet)
            dx, dy, dz, r = ax - bx, ay - by, az - bz, ra + rb
            if lane_mask_lt(dx * dx + dy * dy + dz * dz, r * r):
                store_columns(centres, last + 4 * WIDTH * found, (ax, ay, az, ra))
                near[found] = a
                found += 1
        if found == 0:
            continue
        for b in range(groups[gb, 0], groups[gb, 1]):
            bx, by, bz = _carried(*frame_b, *load_records(balls, b, 4, (0,)))
            rb = nothing + (balls[b, 3] + margin)
            if moving:
                rb = rb + motion_bound(fb, stop, bx, by, bz, half, v, packet)
            for i in range(found):
                ax, ay, az, ra = load_columns(centres, last + 4 * WIDTH * i, 4, LANES)
                dx, dy, dz, r = ax - bx, ay - by, az - bz, ra + rb
                square = dx * dx + dy * dy + dz * dz
                hit = lane_mask_lt(square, r * r)
                if hit:
                    unclear |= hit
                    r0 = balls[near[i], 3] + balls[b, 3] + margin
                    if lane_mask_lt(square, r0 * r0):
                        return -1
    return unclear


@inner
def block_clear(q, v, t, half, how, margin, self_margin, packet):
    """Lanes (bits) where contact is not excluded within `half` of q + t v; -1 if some middle is nearer than the margin.

    SAMPLED: half is 0, a lane is in contact or it is not.
    """
    model, world, scratch = opened(packet)
    joints, joint_data, bodies, pairs = model[0], model[1], model[2], model[7]
    place_frames(q, v, t, joints, joint_data, scratch[0])
    unclear = 0
    for c in range(bodies.shape[0] - 1, -1, -1):  # the far end first: it is what mostly hits
        found = body_clear(c, half, v, how, margin, packet)
        if found < 0:
            return found
        unclear |= found
    for p in range(pairs.shape[0]):
        found = pair_clear(p, half, v, how, self_margin, packet)
        if found < 0:
            return found
        unclear |= found
    return unclear


@called
def edge_clear(q, v, count, how, margin, self_margin, packet):
    """CLEAR, CONTACT or UNDECIDED for the motion q + t v, t in [0, 1].

    SAMPLED: `count` blocks of 16 evenly spaced configurations, the first one left out. CERTIFIED: from `count` pieces
    on, a piece is halved until contact is excluded between its ends too.
    WHOLE: every configuration between q and q + v joint by joint, a box, at once.
    """
    model, world, scratch = opened(packet)
    stack, ramp = scratch[3], scratch[4]
    certified = how != SAMPLED
    if certified:
        for i in range(count):
            stack[0, i], stack[1, i] = (i + 0.5) / count, 0.5 / count + WIDEN
    left = count
    t = load_lanes(ramp, 0, LANES)
    half = t * 0.0
    while left > 0:
        used, first = WIDTH, 0
        if certified:
            used = min(left, WIDTH)
            first = left - used
            for i in range(left, first + WIDTH):
                stack[0, i], stack[1, i] = stack[0, first], stack[1, first]
            t, half = load_lanes(stack, first, LANES), load_lanes(stack, STACK + first, LANES)
        else:
            t = load_lanes(ramp, 0, LANES) * (1.0 / count) + (count - left) / count
        unclear = block_clear(q, v, t, half, CERTIFIED if certified else how, margin, self_margin, packet)
        if unclear < 0:
            return CONTACT
        if not certified:
            left -= 1
            continue
        unclear &= (1 << used) - 1
        left = first
        if unclear:
            if how == WHOLE or first + 3 * WIDTH > STACK:
                return UNDECIDED
            kept = 0
            for i in range(used):  # to the far end first: the halves overwrite their parents
                if (unclear >> i) & 1:
                    stack[0, STACK - WIDTH + kept], stack[1, STACK - WIDTH + kept] = (
                        stack[0, first + i],
                        stack[1, first + i],
                    )
                    kept += 1
            for i in range(kept):
                middle, width = stack[0, STACK - WIDTH + i], 0.5 * stack[1, STACK - WIDTH + i]
                if width < SMALLEST:
                    return UNDECIDED
                stack[0, left], stack[1, left] = middle - width, width + WIDEN
                stack[0, left + 1], stack[1, left + 1] = middle + width, width + WIDEN
                left += 2
    return CLEAR
