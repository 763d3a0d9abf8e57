"""Compiled kinematics of any robot given as arrays: one compilation serves all robots.

For compiled code of other layers. A tree is the arrays of `pack.Tree`, parents before children:
    parents (L,) int64, -1 for the base      origins (L, 8) motors      kinds (L,) int64: 0 fixed, 1 revolute, 2
    prismatic axes (L, 3)      coords (L,) int64 index into q, -1 if fixed      mult, offs (L,): joint value = mult
    q[coord] + offs
All arrays C-contiguous, float64 where not said otherwise, writable (a read-only one would be compiled for again).
"""

from __future__ import annotations

import numpy as np

from ..kernels import EIGHT, ONE, jit, load_lanes, load_records, spread, store_lanes, store_records
from . import _joint_kernels as joints

_point = joints.move_point.inline
_compose, _turn, _slide = joints.compose.inline, joints.turn.inline, joints.slide.inline
_turn_column, _slide_column = joints.turn_column.inline, joints.slide_column.inline
_turn_generator, _slide_generator = joints.turn_generator.inline, joints.slide_generator.inline

FIXED, REVOLUTE, PRISMATIC = 0, 1, 2


@jit
def frames_into(parents, origins, kinds, axes, coords, mult, offs, q, M):
    """Motors of all link frames in the base frame: q (n,) -> M (L, 8)."""
    for i in range(parents.shape[0]):
        p = parents[i]
        k = load_records(origins, i, 8, ONE)
        m = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        if p >= 0:
            m = load_records(M, p, 8, ONE)
        if kinds[i] == FIXED:
            store_records(M, i, _compose(*m, *k))
        else:
            u, value = load_records(axes, i, 3, ONE), mult[i] * q[coords[i]] + offs[i]
            if kinds[i] == REVOLUTE:
                store_records(M, i, _turn(*m, *k, *u, value))
            else:
                store_records(M, i, _slide(*m, *k, *u, value))


@jit
def jacobian_into(chain, kinds, axes, coords, mult, M, x, J):
    """Twist Jacobian (angular, then linear at the point x (3,), base axes) of the last link of `chain`: J (6, n),
    from frames M (L, 8).

    `chain` (c,) int64: links from the base to that link. A coordinate that moves several of them has the sum of their
    columns.
    """
    for r in range(6):
        for c in range(J.shape[1]):
            J[r, c] = 0.0
    for i in chain:
        if kinds[i] != FIXED:
            m, u, p = load_records(M, i, 8, ONE), load_records(axes, i, 3, ONE), load_records(x, 0, 3, ONE)
            if kinds[i] == REVOLUTE:
                column = _turn_column(*m, *u, *p)
            else:
                column = _slide_column(*m, *u, *p)
            for r in range(6):
                J[r, coords[i]] += mult[i] * column[r]


@jit
def generators_into(chain, kinds, axes, coords, mult, M, G):
    """Generators (n, 6) over (e12, e13, e23, e1i, e2i, e3i) of unit rates of the coordinates, in base axes, from
    frames M (L, 8).

    For a revolute joint the IPNS line of its axis, for a prismatic one its direction times e_inf; only links of
    `chain` count. The derivative of anything that the last link carries is the commutator [X, G] / 2.
    """
    for c in range(G.shape[0]):
        for r in range(6):
            G[c, r] = 0.0
    for i in chain:
        if kinds[i] != FIXED:
            m, u = load_records(M, i, 8, ONE), load_records(axes, i, 3, ONE)
            if kinds[i] == REVOLUTE:
                generator = _turn_generator(*m, *u)
            else:
                generator = _slide_generator(*m, *u)
            for r in range(6):
                G[coords[i], r] += mult[i] * generator[r]


@jit
def frames_batch(parents, origins, kinds, axes, coords, mult, offs, Q, M):
    """`frames_into` for a batch: Q (b, n) -> M (b, L, 8), eight at a time on lanes."""
    links, n = parents.shape[0], Q.shape[1]
    whole = Q.shape[0] // 8 * 8
    value, work = np.empty(n * 8 + 1), np.empty(links * 64)
    for i in range(0, whole, 8):
        for lane in range(8):
            for j in range(n):
                value[j * 8 + lane] = Q[i + lane, j]
        for k in range(links):
            p, o = parents[k], load_records(origins, k, 8, ONE)
            zero, one = spread(0.0, EIGHT), spread(1.0, EIGHT)
            m = (one, zero, zero, zero, zero, zero, zero, zero)
            if p >= 0:
                m = (
                    load_lanes(work, p * 64, EIGHT),
                    load_lanes(work, p * 64 + 8, EIGHT),
                    load_lanes(work, p * 64 + 16, EIGHT),
                    load_lanes(work, p * 64 + 24, EIGHT),
                    load_lanes(work, p * 64 + 32, EIGHT),
                    load_lanes(work, p * 64 + 40, EIGHT),
                    load_lanes(work, p * 64 + 48, EIGHT),
                    load_lanes(work, p * 64 + 56, EIGHT),
                )
            if kinds[k] == FIXED:
                m = _compose(*m, *o)
            else:
                u = load_records(axes, k, 3, ONE)
                angle = load_lanes(value, coords[k] * 8, EIGHT) * mult[k] + offs[k]
                if kinds[k] == REVOLUTE:
                    m = _turn(*m, *o, *u, angle)
                else:
                    m = _slide(*m, *o, *u, angle)
            store_lanes(work, k * 64, m[0])
            store_lanes(work, k * 64 + 8, m[1])
            store_lanes(work, k * 64 + 16, m[2])
            store_lanes(work, k * 64 + 24, m[3])
            store_lanes(work, k * 64 + 32, m[4])
            store_lanes(work, k * 64 + 40, m[5])
            store_lanes(work, k * 64 + 48, m[6])
            store_lanes(work, k * 64 + 56, m[7])
        for lane in range(8):
            for k in range(links):
                for c in range(8):
                    M[i + lane, k, c] = work[k * 64 + c * 8 + lane]
    for i in range(whole, Q.shape[0]):
        frames_into(parents, origins, kinds, axes, coords, mult, offs, Q[i], M[i])


@jit
def generators_batch(parents, origins, kinds, axes, coords, mult, offs, chain, Q, G):
    """`generators_into` for a batch: Q (b, n) -> G (b, n, 6)."""
    M = np.empty((parents.shape[0], 8))
    for i in range(Q.shape[0]):
        frames_into(parents, origins, kinds, axes, coords, mult, offs, Q[i], M)
        generators_into(chain, kinds, axes, coords, mult, M, G[i])


@jit
def jacobian_batch(parents, origins, kinds, axes, coords, mult, offs, chain, Q, points, J):
    """Jacobians J (b, 6, n) at `points` (b, 3), given in the frame of the last link of `chain`, for Q (b, n)."""
    M = np.empty((parents.shape[0], 8))
    x = np.empty(3)
    last = chain[chain.shape[0] - 1]
    for i in range(Q.shape[0]):
        frames_into(parents, origins, kinds, axes, coords, mult, offs, Q[i], M)
        store_records(x, 0, _point(*load_records(M, last, 8, ONE), *load_records(points, i, 3, ONE)))
        jacobian_into(chain, kinds, axes, coords, mult, M, x, J[i])
