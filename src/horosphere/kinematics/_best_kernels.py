"""The redundancy that keeps the joints of a seven-joint arm farthest from their limits, for every branch its own: compiled code.

Branch and bound over samples of the redundancy t, all branches side by side. `ranges` (2, 7) holds the middle of each joint's
limits and half their width (0 and inf without limits). On the circle of a joint's angle the distance to its limits, half the width
less the short way to the middle, changes no faster than the angle: not so the number q, which jumps by a turn. So between two
samples at which it is m and m' it is at most (m + m' + l) / 2, l the length of the way that the angle goes; the least of the
joints' bounds bounds the room in the cell. l is at least the difference of the two angles and not much more where cells are narrow:
STRETCH times it, and what the change of the slope from and to the neighbouring cells adds. This one figure is estimated, the rest
is exact. `good`, negative where a branch does not exist, counts as one more joint that has to be positive; the angles go on
continuously where it is.

The samples of a pose are one array A (kinds of rows, nodes, ENTRIES, 8), the branches last: the angles, `good`, the room (-inf where
the branch does not exist), whether an angle was kept, and the residual on the true axes, RAW where it was not asked for.
"""

import math

import numpy as np

from ..kernels import (
    EIGHT,
    inner,
    jit,
    kernel,
    lane_abs,
    lane_max,
    lane_min,
    lane_where_lt,
    load_columns,
    load_lanes,
    min_lane,
    round_even,
    spread,
    store_columns,
    store_lanes,
)
from ._polish_kernels import DONE, polish_lanes
from ._screw_kernels import load_pose, seeded
from ._seven_kernels import rows7

GOOD, ROOM, KEPT, LEFT, ENTRIES = 7, 8, 9, 10, 11
RAW = -1.0
CELLS = 64  # to begin with
NODES = 256  # samples of a branch, at most
CLOSE = 1e-3  # radians: cells that promise no more than this beyond the best are left
LOOSE = 0.05  # the same where no value is inside the limits
STRETCH, BEND = 1.1, 2.0  # twice what a bend of one sign adds
ROUGH = 100.0  # so much wider are the finest cells where Newton got nowhere from both ends
STEPS = 12  # of Newton, at most, for a sample
NEARLY = 1e-6  # residual (m, rad) at which its angles are good enough to compare


@kernel(1, d=None)
def short_way(d):
    """The angle d the short way round."""
    return [d - 2.0 * math.pi * round_even(d * (0.5 / math.pi))]


_short_way = short_way.inline


@inner
def margin(x, ranges, j):
    """The distance of joint j to its limits on the circle, negative outside."""
    (d,) = _short_way(x - ranges[0, j])
    return ranges[1, j] - lane_abs(d)


@inner
def cell_bound(A, before, a, b, after, h0, h, h1, ranges):
    """Lanes: what the room in the cells from node a to node b is at most; -inf where the branch does not exist in them.

    Nodes by the place of their entries in the flat array A. h: widths of the cells, h0 and h1 of the neighbouring ones, inf where
    there is none.
    """
    # BEND h^2 times the change of slope over the sum of the two widths
    here0, back0 = BEND * h / (h + h0), BEND * h / (h + h0) * (h / h0)
    here1, next1 = BEND * h / (h + h1), BEND * h / (h + h1) * (h / h1)
    bound = spread(math.inf, EIGHT)
    for j in range(GOOD):
        x, y = load_lanes(A, a + 8 * j, EIGHT), load_lanes(A, b + 8 * j, EIGHT)
        (here,) = _short_way(y - x)
        (back,) = _short_way(x - load_lanes(A, before + 8 * j, EIGHT))
        (ahead,) = _short_way(load_lanes(A, after + 8 * j, EIGHT) - y)
        bend = lane_max(lane_abs(here0 * here - back0 * back), lane_abs(here1 * here - next1 * ahead))
        margins = margin(x, ranges, j) + margin(y, ranges, j)
        bound = lane_min(bound, 0.5 * (margins + STRETCH * lane_abs(here) + bend))
    x, y = load_lanes(A, a + 8 * GOOD, EIGHT), load_lanes(A, b + 8 * GOOD, EIGHT)
    here, back, ahead = y - x, x - load_lanes(A, before + 8 * GOOD, EIGHT), load_lanes(A, after + 8 * GOOD, EIGHT) - y
    bend = lane_max(lane_abs(here0 * here - back0 * back), lane_abs(here1 * here - next1 * ahead))
    return lane_where_lt(x + y + STRETCH * lane_abs(here) + bend, 0.0, -math.inf, bound)


@inner
def room_of(q, ranges):
    """The least distance of one of the seven joints to its limits."""
    room = lane_min(margin(q[0], ranges, 0), margin(q[1], ranges, 1))
    room = lane_min(room, lane_min(margin(q[2], ranges, 2), margin(q[3], ranges, 3)))
    return lane_min(room, lane_min(margin(q[4], ranges, 4), lane_min(margin(q[5], ranges, 5), margin(q[6], ranges, 6))))


@inner
def sample(kind, arms, limits, ranges, pose, kept1, kept5, at, A, node):
    """Writes the rows at lanes of the redundancy as the entries of a node; returns the metres by which the wrist is out of reach."""
    flat, gap, kinds = A.reshape(-1), math.inf, A.shape[0]
    for turn in range(kinds):
        q, good, held, miss = rows7(kind, arms[turn], limits, pose, at, kept1, kept5)
        room = lane_where_lt(good, 0.0, -math.inf, room_of(q, ranges))
        all_exist = min_lane(good) >= 0.0  # then no root is missed, and the other kind has the same rows
        for same in range(turn, kinds if all_exist else turn + 1):
            store_columns(flat, 8 * ENTRIES * (same * NODES + node), (*q, good, room, held, spread(RAW, EIGHT)))
        gap = min(gap, miss)
        if all_exist:
            break
    return gap


@inner
def settle(true_arm, limits, ranges, pose, A, nodes, locked, done, enough, steps, patient, memory):
    """Polishes a node of every branch, nodes (8,), on the true axes and keeps what comes of it; no node of a branch: -1."""
    if true_arm is None:
        return
    work, q, sizes = memory[:98], memory[98:105], memory[105:].reshape(-1)
    last = A.shape[0] - 1
    for k in range(8):
        sizes[k] = 0.0 if nodes[k] < 0 else 1.0
        for j in range(7):
            q[j, k] = A[last, max(nodes[k], 0), j, k]
    left = polish_lanes(true_arm, limits, pose, q, load_lanes(sizes, 0, EIGHT), locked, done, steps, patient, work)
    store_lanes(sizes, 0, left)
    store_lanes(sizes, 8, room_of(load_columns(q.reshape(-1), 0, 7, EIGHT), ranges))
    for k in range(8):
        node = nodes[k]
        if node < 0:
            continue
        exists = sizes[k] < enough
        for turn in range(A.shape[0]):
            A[turn, node, LEFT, k] = sizes[k]
            if exists:
                A[turn, node, GOOD, k] = A[last, node, GOOD, k]
                for j in range(7):
                    A[turn, node, j, k] = q[j, k]
                A[turn, node, ROOM, k] = sizes[8 + k]
            else:  # the angles of the near structure go on continuously
                A[turn, node, GOOD, k] = min(A[turn, node, GOOD, k], -1e-12)
                A[turn, node, ROOM, k] = -math.inf


@inner
def widest(U, T, A, k, after, active, count, best, spare, narrow):
    """(left node of the open cell that promises most or -1, number of open cells); closed ones leave `active`."""
    level = best + (CLOSE if best >= 0.0 else LOOSE)
    top, pick, c = -math.inf, -1, 0
    while c < count:
        a = active[c]
        b, u = after[a], U[a]
        h, nowhere = T[b] - T[a], spare > 0.0 and A[0, a, GOOD, k] < 0.0 and A[0, b, GOOD, k] < 0.0
        if (u > level or (best < 0.0 and u > -spare)) and h > (ROUGH * narrow if nowhere else narrow):
            if nowhere:  # last, and evenly
                u = h - 1e9
            if u > top:
                top, pick = u, a
            c += 1
        else:
            count -= 1
            active[c] = active[count]
    return pick, count


@inner
def leading(A, nodes, k, wary, spare):
    """Of branch k the node with most room among those whose room counts, and among the others, each with its room; -1 for none.

    While nothing is wary all count, else only the settled rows and those that are outside the limits whatever `spare` does.
    """
    last = A.shape[0] - 1
    sure, best, other, most = -1, -math.inf, -1, -math.inf
    for node in range(nodes):
        room = A[last, node, ROOM, k]
        if not wary or room <= -spare or A[last, node, LEFT, k] != RAW:
            if room > best:
                sure, best = node, room
        elif room > most:
            other, most = node, room
    return sure, best, other, most


@inner
def bound_grid(flat, kinds, even, ranges, U, bounds):
    """U (8, nodes): the bounds of the cells to begin with."""
    size = 8 * ENTRIES
    for a in range(CELLS):
        promise, first, behind = spread(-math.inf, EIGHT), max(a - 1, 0), min(a + 2, CELLS)
        h0, h1 = even if a > 0 else math.inf, even if a + 2 <= CELLS else math.inf
        for turn in range(kinds):
            u = size * turn * NODES
            of_kind = cell_bound(
                flat, u + size * first, u + size * a, u + size * (a + 1), u + size * behind,
                spread(h0, EIGHT), spread(even, EIGHT), spread(h1, EIGHT), ranges,
            )  # fmt: skip
            promise = lane_max(promise, of_kind)
        store_lanes(bounds, 0, promise)
        for k in range(8):
            U[k, a] = bounds[0, k]


@inner
def choose_cells(U, T, A, before, after, active, count, top, spare, narrow, low, node, cell, at, near, widths):
    """The cell (8,) of every branch that is to be halved, by its left node or -1, and how many there are.

    at (8,): the middles, to become the node `node`. near (8, 5): the nodes on both sides, widths (4, 8) between them.
    """
    number = 0
    for k in range(8):
        cell[k], count[k] = widest(U[k], T[k], A, k, after[k], active[k], count[k], top[k], spare, narrow)
        if cell[k] < 0:
            at[k], near[k], widths[:, k] = low, 0, 1.0
            continue
        number += 1
        a = cell[k]
        b = after[k, a]
        at[k] = 0.5 * (T[k, a] + T[k, b])
        first, behind = before[k, a], after[k, b]
        near[k, 0], near[k, 1], near[k, 2], near[k, 3] = max(first, 0), a, node, b
        near[k, 4] = behind if behind >= 0 else b
        widths[0, k] = T[k, a] - T[k, first] if first >= 0 else math.inf
        widths[1, k], widths[2, k] = at[k] - T[k, a], T[k, b] - at[k]
        widths[3, k] = T[k, behind] - T[k, b] if behind >= 0 else math.inf
    return number


@inner
def bound_halves(A, near, widths, ranges, around, bounds):
    """bounds (2, 8) of the left and right halves of the cells that are halved."""
    left, right = spread(-math.inf, EIGHT), spread(-math.inf, EIGHT)
    h0, h1, h2, h3 = load_columns(widths.reshape(-1), 0, 4, EIGHT)
    w = around.reshape(-1)
    for turn in range(A.shape[0]):
        for k in range(8):
            for n in range(5):
                for j in range(8):
                    around[n, j, k] = A[turn, near[k, n], j, k]
        left = lane_max(left, cell_bound(w, 0, 64, 128, 192, h0, h1, h2, ranges))
        right = lane_max(right, cell_bound(w, 64, 128, 192, 256, h1, h2, h3, ranges))
    store_lanes(bounds, 0, left)
    store_lanes(bounds, 8, right)


@inner
def nearest(A, nodes, k):
    """The node where branch k misses by least."""
    last, found, most = A.shape[0] - 1, 0, -math.inf
    for node in range(nodes):
        if A[last, node, GOOD, k] > most:
            found, most = node, A[last, node, GOOD, k]
    return found


@jit
def best(
    kind, arms, true_arm, limits, ranges, low, high, locked, spare, narrow, enough, steps, motors, seeds, value, Q, valid, gap, free,
    residual,
):  # fmt: skip
    """For every branch of every pose the redundancy, value (m, 8), that keeps the joints farthest from their limits.

    low, high: range of t. narrow: cells no wider are not halved. An exact structure: one arm, spare 0, `true_arm` None (numba then
    leaves out what is for the others). Else arms (2, ...) are the near structure as it is and with roots kept that it misses by
    little; its joints may be off by `spare` radians. The best are polished on the axes `true_arm` (`locked` as in `polish_lanes`; at
    the end with at most `steps` Newton steps), and count if they come to `enough`: only at the end where `spare` is small; where it
    is not, or a branch is disappointed by that, all that may be the best. residual (m, 8) of these; rows as `seven`.
    """
    A = np.empty((arms.shape[0], NODES, ENTRIES, 8))
    flat, last = A.reshape(-1), arms.shape[0] - 1
    T, U = np.empty((8, NODES)), np.empty((8, NODES))
    before, after = np.empty((8, NODES), np.int64), np.empty((8, NODES), np.int64)
    active, count = np.empty((8, NODES), np.int64), np.empty(8, np.int64)  # cells that are open
    cell, top, at = np.empty(8, np.int64), np.empty(8), np.empty(8)
    around, widths, near = np.empty((5, 8, 8)), np.empty((4, 8)), np.empty((8, 5), np.int64)
    bounds, memory = np.empty((2, 8)), np.empty((107, 8))
    picks, wary, again = np.empty(8, np.int64), np.empty(8, np.bool_), np.empty(8, np.bool_)
    arm, even = arms[0], (high - low) / CELLS
    for i in range(motors.shape[0]):
        pose = load_pose(motors, i, arm, 7)
        true_pose = pose if true_arm is None else load_pose(motors, i, true_arm, 7)
        kept1, kept5 = seeded(seeds, i, 0, arm, 7), seeded(seeds, i, 4, arm, 7)
        gap[i], nodes = math.inf, CELLS + 1
        for node in range(nodes):
            t = low + even * node
            gap[i] = min(gap[i], sample(kind, arms, limits, ranges, pose, kept1, kept5, spread(t, EIGHT), A, node))
            for k in range(8):
                T[k, node], before[k, node], after[k, node] = t, node - 1, node + 1 if node < CELLS else -1
        for k in range(8):
            wary[k], again[k] = spare > CLOSE, True
        while True:
            for k in range(8):
                picks[k] = 0 if wary[k] and again[k] else -1
            while True:  # settle what may be the best
                for k in range(8):
                    if picks[k] >= 0:
                        _, room, other, most = leading(A, nodes, k, True, spare)
                        picks[k] = other if most > max(room, 0.0) - spare else -1
                if picks.max() < 0:
                    break
                settle(true_arm, limits, ranges, true_pose, A, picks, locked, NEARLY, NEARLY, STEPS, False, memory)
            if nodes == CELLS + 1:
                bound_grid(flat, last + 1, even, ranges, U, bounds)
            for k in range(8):
                if again[k]:
                    count[k] = 0
                    _, top[k], _, _ = leading(A, nodes, k, wary[k], spare)
                    for node in range(nodes):
                        if after[k, node] >= 0:
                            active[k, count[k]] = node
                            count[k] += 1
            while nodes < NODES and choose_cells(
                U, T, A, before, after, active, count, top, spare, narrow, low, nodes, cell, at, near, widths
            ):
                sample(kind, arms, limits, ranges, pose, kept1, kept5, load_lanes(at, 0, EIGHT), A, nodes)
                for k in range(8):
                    unsure = cell[k] >= 0 and wary[k] and A[last, nodes, ROOM, k] > max(top[k], 0.0) - spare
                    picks[k] = nodes if unsure else -1
                if picks.max() >= 0:
                    settle(true_arm, limits, ranges, true_pose, A, picks, locked, NEARLY, NEARLY, STEPS, False, memory)
                bound_halves(A, near, widths, ranges, around, bounds)
                for k in range(8):
                    a = cell[k]
                    if a < 0:  # not a node of this branch
                        after[k, nodes] = -1
                        A[last, nodes, ROOM, k] = A[last, nodes, GOOD, k] = -math.inf
                        continue
                    b = after[k, a]
                    T[k, nodes], before[k, nodes], after[k, nodes] = at[k], a, b
                    before[k, b], after[k, a] = nodes, nodes
                    U[k, a], U[k, nodes] = bounds[0, k], bounds[1, k]
                    top[k] = max(top[k], A[last, nodes, ROOM, k])
                    active[k, count[k]] = nodes
                    count[k] += 1
                nodes += 1
            for k in range(8):
                cell[k], at[k], _, _ = leading(A, nodes, k, wary[k], spare)
                left = A[last, max(cell[k], 0), LEFT, k]
                raw = spare > 0.0 and cell[k] >= 0 and (left == RAW or left > DONE)
                picks[k] = cell[k] if raw else -1
            if picks.max() < 0:
                break
            settle(true_arm, limits, ranges, true_pose, A, picks, locked, DONE, enough, steps, True, memory)
            for k in range(8):  # is a best row none, or, where that is news, outside the limits?
                room = A[last, max(picks[k], 0), ROOM, k]
                disappoints = room == -math.inf or (room < 0.0 and not wary[k])
                again[k] = picks[k] >= 0 and at[k] > -spare and disappoints
                wary[k] |= again[k]
            if not again.any():
                break
        for k in range(8):
            node = cell[k] if cell[k] >= 0 else nearest(A, nodes, k)
            valid[i, k] = A[last, node, ROOM, k] > -math.inf
            value[i, k], free[i, k] = T[k, node], A[last, node, KEPT, k] > 0.5
            residual[i, k] = A[last, node, LEFT, k] if valid[i, k] else math.inf
            for j in range(7):
                Q[i, k, j] = A[last, node, j, k]
