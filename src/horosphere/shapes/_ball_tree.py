"""A hierarchy of balls over many balls, in arrays that compiled code can walk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ._base import Floats
from ._sampled import PointCloud

LEAF = 8


@dataclass(frozen=True, slots=True, eq=False)
class BallTree:
    """A complete binary tree of bounding balls.

    `balls` (m, 4): centre and radius, in the order of the leaves; `order` (m,): which ball of the cloud each is.
    `nodes` (2 k - 1, 4), k a power of two: the ball of node i holds those of its children 2 i + 1 and 2 i + 2; the last k nodes
    are leaves, and leaf j holds `balls[first[j]:first[j + 1]]`. `first` (k + 1,).
    """

    nodes: Floats
    first: NDArray[np.int64]
    balls: Floats
    order: NDArray[np.int64]

    @property
    def leaves(self) -> int:
        """Number of leaves, k."""
        return len(self.first) - 1


def ball_tree(cloud: PointCloud, leaf: int = LEAF) -> BallTree:
    """The tree over a cloud, halved across the longest side of each node's box until no leaf has more than `leaf` balls."""
    if leaf < 2:
        raise InputError(f"expected at least two balls a leaf, got {leaf}", place="leaf")
    x, r = cloud.points, np.broadcast_to(cloud.radius, len(cloud.points))
    m = len(x)
    order = np.arange(m)
    first = np.array([0, m])
    while np.diff(first).max() > leaf:
        placed, node = x[order], np.repeat(np.arange(len(first) - 1), np.diff(first))
        low = np.minimum.reduceat(placed, first[:-1])
        size = np.maximum.reduceat(placed, first[:-1]) - low
        axis = size.argmax(axis=1)
        rows = np.arange(len(axis))
        scale = 0.99 / np.maximum(size[rows, axis], 1e-300)
        # one key sorts within every node at once
        along = (placed[np.arange(m), axis[node]] - low[rows, axis][node]) * scale[node]
        order = order[np.argsort(node + along, kind="stable")]
        first = np.sort(np.concatenate([first, (first[:-1] + first[1:]) // 2]))
    nodes: list[Floats] = []
    ends = first
    while True:
        nodes.append(_bounds(x[order], r[order], ends))
        if len(ends) == 2:
            break
        ends = ends[::2]
    balls = np.column_stack([x[order], r[order]])
    arrays = [np.ascontiguousarray(np.concatenate(nodes[::-1])), first.astype(np.int64), balls, order.astype(np.int64)]
    for array in arrays:
        array.setflags(write=False)
    return BallTree(*arrays)


def _bounds(x: Floats, r: Floats, ends: NDArray[np.int64]) -> Floats:
    """A ball (k, 4) round the balls of each stretch."""
    starts, counts = ends[:-1], np.diff(ends)
    low = np.minimum.reduceat(x - r[:, None], starts)
    high = np.maximum.reduceat(x + r[:, None], starts)
    centre = 0.5 * (low + high)
    reach = np.linalg.norm(x - np.repeat(centre, counts, axis=0), axis=1) + r
    return np.column_stack([centre, np.maximum.reduceat(reach, starts) * (1.0 + 1e-12)])
