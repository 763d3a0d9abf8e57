"""Two trees of joint motions that grow towards each other (RRT-Connect), in single precision.

The published algorithm is Kuffner and LaValle's (2000), with the dynamic domain of Yershova et al. (2005): a node whose
extension failed takes samples only from a ball around it. Edges are checked by `edge_clear` through its address, in the packet.

Of the packet:
  search = (samples, low, high, ends, order, nodes, parents, radii, state, path)
    samples (S, n)       points of the unit cube; low, high (n,): the region that is searched
    ends (1 + k, n)      the start, the goals; order (k,): which of these are clear
    nodes (2 n, capacity), parents (2, capacity), radii (2, capacity): tree 0 hangs on the start, tree 1 on the goals
    state (6,)           iterations done, nodes of tree 0, nodes of tree 1, the tree that grows, edges checked, goals that are clear
    path (most, n)       what is found
"""

import math

import numpy as np

from ..kernels import inner, lane_min, lane_where_lt, load_lanes, min_lane, spread
from ._edge_kernels import CERTIFIED, LANES, SAMPLED, WIDTH
from ._packet_kernels import GOALS_BLOCKED, START_BLOCKED, TREES_FULL, called, check_edge, opened, opened_task

FREE = np.float32(1e30)  # the radius of a node whose extensions have all succeeded
FAR = np.float32(1e9)
RADIUS, LEAST_RADIUS, SHRINK = 4.0, 1.0, 1e-4
GOLDEN = 0.6180339887498949
STEP = 1.0
"""Longest edge: 1 rad, or a slide by the robot's reach."""
PER_UNIT, PIECES_PER_UNIT = 32.0, 16.0
"""Configurations checked, and pieces a certificate starts from, per unit of motion (1 rad, or a reach of sliding)."""


@inner
def motion_clear(packet, q, v, length, how, margin, self_margin):
    """Whether the motion q + t v of this length is clear, by samples or by a certificate (`how`)."""
    if how == CERTIFIED:
        count = min(max(int(math.ceil(length * PIECES_PER_UNIT / WIDTH)), 1) * WIDTH, 1024)
    else:
        count = max(int(math.ceil(length * PER_UNIT / WIDTH)), 1)
    return check_edge(packet, q, v, count, how, margin, self_margin) == 1


@inner
def nearest(nodes, tree, count, q, ramp):
    """Index and squared distance of the nearest of `count` nodes (padded with far ones to whole lanes)."""
    n, capacity = len(q), nodes.shape[1]
    first = tree * n * capacity
    best = spread(FREE, LANES)
    index = best
    here = load_lanes(ramp, WIDTH, LANES)
    for i in range(0, count, WIDTH):
        total = best * np.float32(0.0)
        for j in range(n):
            gap = load_lanes(nodes, first + j * capacity + i, LANES) - q[j]
            total = total + gap * gap
        index = lane_where_lt(total, best, here, index)
        best = lane_min(total, best)
        here = here + np.float32(WIDTH)
    least = min_lane(best)
    # the first lane that holds the least: lanes that hold more count as far
    return int(min_lane(lane_where_lt(least, best, spread(FREE, LANES), index))), least


@inner
def add_node(tree, which, count, q, parent):
    """Append a node; the lanes behind it stay far away."""
    nodes, parents, radii = tree
    n = len(q)
    for j in range(n):
        nodes[which * n + j, count] = q[j]
    parents[which, count], radii[which, count] = parent, FREE
    if count % WIDTH == WIDTH - 1:
        for j in range(n):
            for k in range(count + 1, count + 1 + WIDTH):
                nodes[which * n + j, k] = FAR


@inner
def write_path(tree, a, b, path):
    """The path start .. node a of tree 0, node b of tree 1 .. goal; returns its length, 0 if it does not fit."""
    nodes, parents, radii = tree
    n = path.shape[1]
    first = 0
    i = a
    while i >= 0:
        first += 1
        i = parents[0, i]
    k = first - 1
    i = a
    if first >= path.shape[0]:
        return 0
    while i >= 0:
        for j in range(n):
            path[k, j] = nodes[j, i]
        k -= 1
        i = parents[0, i]
    k = first
    i = b
    while i >= 0:
        if k >= path.shape[0]:
            return 0
        for j in range(n):
            path[k, j] = nodes[n + j, i]
        k += 1
        i = parents[1, i]
    return k


@inner
def stands_clear(packet, q, v, margin, self_margin):
    """Whether one configuration is clear; v is overwritten."""
    for j in range(len(q)):
        v[j] = 0.0
    return check_edge(packet, q, v, np.int64(1), np.int64(SAMPLED), margin, self_margin) == 1


@inner
def plant(packet, goals, margin, self_margin, ends, order, tree, state, v):
    """Empty trees with their roots; `order` says which of the goals are clear. Returns how many they are, or START_BLOCKED."""
    nodes, parents, radii = tree
    n = len(v)
    if not stands_clear(packet, ends[0], v, margin, self_margin):
        return START_BLOCKED
    count = 0
    for g in range(goals):
        if stands_clear(packet, ends[1 + g], v, margin, self_margin):
            order[count] = g
            count += 1
    for which in range(2):
        roots = count if which else 1
        for j in range(n):
            for k in range((roots // WIDTH + 1) * WIDTH):
                nodes[which * n + j, k] = FAR
        for g in range(roots):
            add_node(tree, which, g, ends[1 + order[g]] if which else ends[0], np.int64(-1))
    state[0], state[1], state[2], state[3], state[4], state[5] = 0, 1, count, 1, 0, count
    return count


@called
def grow(packet, goals, budget, how, margin, self_margin):
    """Points of a path found within `budget` more iterations; 0: none yet, or TREES_FULL, START_BLOCKED, GOALS_BLOCKED.

    A first call (state[0] < 0) plants the trees and tries the straight motions to the `goals`.
    """
    samples, low, high, ends, order, nodes, parents, radii, state, path = opened_task(packet)[0]
    scratch = opened(packet)[2]
    ramp, work = scratch[4], scratch[5]
    tree, n, capacity, step = (nodes, parents, radii), path.shape[1], nodes.shape[1], STEP
    a, v, q = work[0], work[1], work[2]
    if state[0] < 0:
        count = plant(packet, goals, margin, self_margin, ends, order, tree, state, v)
        if count <= 0:
            return GOALS_BLOCKED if count == 0 else count
        for g in range(count):
            length = 0.0
            for j in range(n):
                v[j] = ends[1 + order[g], j] - ends[0, j]
                length += v[j] * v[j]
            state[4] += 1
            if motion_clear(packet, ends[0], v, float(math.sqrt(length)), how, margin, self_margin):
                for j in range(n):
                    path[0, j], path[1, j] = ends[0, j], ends[1 + order[g], j]
                return 2
    for _ in range(budget):
        iteration = state[0]
        state[0] += 1
        ta = state[3]
        if state[1 + ta] > 0 and abs(state[1 + ta] - state[2 - ta]) < state[1 + ta]:
            ta = 1 - ta
        state[3] = ta
        tb = 1 - ta
        na, nb = state[1 + ta], state[1 + tb]
        row, lap = iteration % samples.shape[0], iteration // samples.shape[0]
        for j in range(n):
            share = samples[row, j] + lap * GOLDEN * (
                j + 1.0
            )  # each lap through the table is moved round by another amount
            q[j] = low[j] + (share - math.floor(share)) * (high[j] - low[j])
        i, square = nearest(nodes, ta, na, q, ramp)
        distance = math.sqrt(float(square))
        radius = radii[ta, i]
        if radius < distance:
            continue
        part = np.float32(min(1.0, step / max(distance, 1e-9)))
        for j in range(n):
            a[j] = nodes[ta * n + j, i]
            v[j] = (q[j] - a[j]) * part
        state[4] += 1
        if not motion_clear(packet, a, v, min(distance, step), how, margin, self_margin):
            radii[ta, i] = RADIUS if radius >= FREE else max(radius * (1.0 - SHRINK), LEAST_RADIUS)
            continue
        if radius < FREE:
            radii[ta, i] = radius * (1.0 + SHRINK)
        if na + 2 * WIDTH > capacity:
            return TREES_FULL
        for j in range(n):
            a[j] += v[j]
        add_node(tree, ta, na, a, i)
        here = na
        na += 1
        k, square = nearest(nodes, tb, nb, a, ramp)
        distance = math.sqrt(float(square))
        pieces = max(int(math.ceil(distance / step)), 1)
        if na + pieces + 2 * WIDTH > capacity:
            return TREES_FULL
        for j in range(n):
            v[j] = (nodes[tb * n + j, k] - a[j]) / np.float32(pieces)
        done = 0
        while done < pieces:
            if done == pieces - 1:  # ends exactly on the node of the other tree
                for j in range(n):
                    v[j] = nodes[tb * n + j, k] - a[j]
            state[4] += 1
            if not motion_clear(packet, a, v, distance / pieces, how, margin, self_margin):
                break
            done += 1
            if done < pieces:
                for j in range(n):
                    a[j] += v[j]
                add_node(tree, ta, na, a, here)
                here = na
                na += 1
        state[1 + ta] = na
        if done == pieces:
            return write_path(tree, here if ta == 0 else k, k if ta == 0 else here, path)
    return 0
