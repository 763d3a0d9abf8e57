"""The redundancy that keeps the joints of a seven-joint arm farthest from their limits, for every branch its own: compiled code.

Branch and bound over samples of the redundancy t, all branches side by side. On the circle of a joint's angle the distance to its
limits changes no faster than the angle, so between two samples at which it is m and m' it is at most (m + m' + l) / 2, l the length
of the way that the angle goes; the least of the joints' bounds bounds the room in the cell. l is at least the difference of the two
angles and not much more where cells are narrow: STRETCH times it, and what the change of the slope from and to the neighbouring
cells adds. This one figure is estimated, the rest is exact. `good`, negative where a branch does not exist, counts as one more joint
that has to be positive; the angles go on continuously where it is.
"""

import math

import numpy as np

from ..kernels import EIGHT, inner, jit, load_lanes, spread, store_lanes, store_records
from ._polish_kernels import polish_row
from ._screw_kernels import load_pose, seeded
from ._seven_kernels import rows7

CELLS = 64  # to begin with
SCATTER = 24  # has no divisor in common with their number of ends
NODES = 256  # samples of a branch, at most
CLOSE = 1e-3  # radians: cells that promise no more than this beyond the best are left
LOOSE = 0.05  # the same where no value is inside the limits
STRETCH, BEND = 1.1, 2.0  # twice what a bend of one sign adds
ROUGH = 100.0  # so much wider are the finest cells where Newton got nowhere from both ends
STEPS = 12  # of Newton, at most, for a sample


@inner
def room_of(q, limits):
    """The least distance of a joint to its limits."""
    room = math.inf
    for j in range(7):
        room = min(room, min(q[j] - limits[0, j], limits[1, j] - q[j]))
    return room


@inner
def way(a, b, round_):
    """b - a, the short way round where it is an angle."""
    d = b - a
    return d - 2.0 * math.pi * math.floor(d / (2.0 * math.pi) + 0.5) if round_ else d


@inner
def cell_bound(T, A, limits, before, a, b, after):
    """What the room in the cell from node a to node b is at most; -inf where the branch does not exist in it.

    T (nodes,), A (kinds, nodes, 8): t, and by kind of row the angles and `good`. The larger bound of all kinds counts.
    """
    h, most = T[b] - T[a], -math.inf
    for kind in range(A.shape[0]):
        Q, bound = A[kind], math.inf
        for j in range(7, -1, -1):
            here = way(Q[a, j], Q[b, j], j < 7)
            bend = 0.0
            if before >= 0:
                d = T[a] - T[before]
                bend = abs(here / h - way(Q[before, j], Q[a, j], j < 7) / d) / (h + d)
            if after >= 0:
                d = T[after] - T[b]
                bend = max(bend, abs(here / h - way(Q[b, j], Q[after, j], j < 7) / d) / (h + d))
            length = STRETCH * abs(here) + BEND * h * h * bend
            if j == 7:
                if Q[a, 7] + Q[b, 7] + length < 0.0:
                    bound = -math.inf
                    break
            else:
                x, y, lower, upper = Q[a, j], Q[b, j], limits[0, j], limits[1, j]
                bound = min(bound, 0.5 * (min(x - lower, upper - x) + min(y - lower, upper - y) + length))
        most = max(most, bound)
    return most


@inner
def widest(U, T, A, after, active, count, best, spare, narrow):
    """(left node of the open cell that promises most or -1, number of open cells); closed ones leave `active`."""
    level = best + (CLOSE if best >= 0.0 else LOOSE)
    top, pick, c = -math.inf, -1, 0
    while c < count:
        a = active[c]
        b, u = after[a], U[a]
        h, nowhere = T[b] - T[a], spare > 0.0 and A[0, a, 7] < 0.0 and A[0, b, 7] < 0.0
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


@jit
def best(
    kind, arms, true_arm, limits, low, high, locked, spare, narrow, enough, steps, motors, seeds, value, Q, valid, gap, free,
    residual,
):  # fmt: skip
    """For every branch of every pose the redundancy, value (m, 8), that keeps the joints farthest from their limits.

    low, high: range of t. narrow: cells no wider are not halved. An exact structure: one arm, spare 0. Else arms (2, ...) are the
    near structure as it is and with roots kept that it misses by little; samples that are nearer than `spare` radians to the best
    are polished on the axes `true_arm` (the last ones with at most `steps` Newton steps; `locked` as in `polish_row`), and count if
    they come to `enough`. residual (m, 8) of these; rows as `seven`.
    """
    turns = arms.shape[0]
    T, A, U = np.empty((8, NODES)), np.empty((8, turns, NODES, 8)), np.empty((8, NODES))
    before, after = np.empty((8, NODES), np.int64), np.empty((8, NODES), np.int64)
    active, count = np.empty((8, NODES), np.int64), np.empty(8, np.int64)
    cell, top, nearest = np.empty(8, np.int64), np.empty(8), np.empty(8)
    at, rows, good, loose = np.empty(8), np.empty((16, 7)), np.empty(16), np.empty(8)
    raw = np.empty(8, np.bool_)
    work, flat = np.empty((13, 7)), rows.reshape(-1)
    arm, start = arms[0], 8 * (turns - 1)
    for i in range(motors.shape[0]):
        pose, true_pose = load_pose(motors, i, arm, 7), load_pose(motors, i, true_arm, 7)
        kept1, kept5 = seeded(seeds, i, 0, arm, 7), seeded(seeds, i, 4, arm, 7)
        gap[i] = math.inf
        for k in range(8):
            top[k], nearest[k], count[k], cell[k], raw[k] = -math.inf, -math.inf, 0, 0, False
            valid[i, k], residual[i, k], free[i, k] = False, math.inf, False
        for trial in range(NODES):
            node = trial
            if trial <= CELLS:
                node = SCATTER * trial % (CELLS + 1)  # good ones early: of the others fewer are polished
                here = spread(low + (high - low) * node / CELLS, EIGHT)
                store_lanes(at, 0, here)
            else:
                open_cells = 0
                for k in range(8):
                    cell[k], count[k] = widest(U[k], T[k], A[k], after[k], active[k], count[k], top[k], spare, narrow)
                    if cell[k] >= 0:
                        a = cell[k]
                        at[k] = 0.5 * (T[k, a] + T[k, after[k, a]])
                        open_cells += 1
                if open_cells == 0:
                    break
            for turn in range(turns):
                q, g, held, miss = rows7(kind, arms[turn], limits, pose, load_lanes(at, 0, EIGHT), kept1, kept5)
                store_records(flat, 8 * turn, q)
                store_lanes(good, 8 * turn, g)
                store_lanes(loose, 0, held)
                gap[i] = min(gap[i], miss)
            for k in range(8):
                if cell[k] < 0:
                    continue
                row, exists = rows[start + k], good[start + k] >= 0.0
                room, left, polished = room_of(row, limits), 0.0, False
                T[k, node] = at[k]
                for turn in range(turns):
                    A[k, turn, node, 7] = good[8 * turn + k]
                    for j in range(7):
                        A[k, turn, node, j] = rows[8 * turn + k, j]
                if spare > 0.0 and exists and room > max(top[k], 0.0) - spare:
                    left, polished = polish_row(true_arm, limits, true_pose, row, locked, STEPS, False, work), True
                    exists = left < enough
                    for turn in range(turns):
                        if exists:
                            A[k, turn, node, 7] = good[start + k]
                            for j in range(7):
                                A[k, turn, node, j] = row[j]
                        else:  # the angles of the near structure go on continuously
                            A[k, turn, node, 7] = min(A[k, turn, node, 7], -1e-12)
                    if exists:
                        room = room_of(row, limits)
                near = A[k, turns - 1, node, 7]
                if (exists and room > top[k]) or (not valid[i, k] and not exists and near > nearest[k]):
                    for j in range(7):
                        Q[i, k, j] = row[j]
                    value[i, k], valid[i, k], free[i, k] = at[k], exists, loose[k] > 0.5
                    if exists:
                        top[k], residual[i, k], raw[k] = room, left, spare > 0.0 and not polished
                    else:
                        nearest[k] = near
                if trial > CELLS:
                    a = cell[k]
                    b = after[k, a]
                    before[k, node], after[k, node] = a, b
                    before[k, b], after[k, a] = node, node
                    c = after[k, b] if b != CELLS else -1
                    U[k, a] = cell_bound(T[k], A[k], limits, before[k, a], a, node, b)
                    U[k, node] = cell_bound(T[k], A[k], limits, a, node, b, c)
                    active[k, count[k]] = node
                    count[k] += 1
                elif trial == CELLS:
                    for a in range(CELLS + 1):
                        before[k, a], after[k, a] = a - 1, a + 1
                    for a in range(CELLS):
                        U[k, a] = cell_bound(T[k], A[k], limits, a - 1, a, a + 1, a + 2 if a + 2 <= CELLS else -1)
                        active[k, a] = a
                    count[k] = CELLS
        for k in range(8):
            if raw[k]:
                left = polish_row(true_arm, limits, true_pose, Q[i, k], locked, steps, True, work)
                residual[i, k], valid[i, k] = left, left < enough
