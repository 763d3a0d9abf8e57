"""A hierarchy of balls over many balls, in arrays that compiled code can walk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import whole_number
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
    if not isinstance(cloud, PointCloud):
        raise InputError(f"expected a PointCloud, got {type(cloud).__name__}", place="cloud")
    leaf = whole_number(leaf, "leaf", 2)
    from ._split_kernels import bound, halve

    m = len(cloud.points)
    order, x = np.arange(m), np.array(cloud.points)
    first = np.array([0, m])
    while np.diff(first).max() > leaf:
        halve(x, order, first)
        first = np.sort(np.concatenate([first, (first[:-1] + first[1:]) // 2]))
    r = np.array(np.broadcast_to(cloud.radius, m)[order])
    nodes: list[Floats] = []
    ends = first
    while True:
        nodes.append(np.empty((len(ends) - 1, 4)))
        bound(x, r, ends, nodes[-1])
        if len(ends) == 2:
            break
        ends = np.ascontiguousarray(ends[::2])
    balls = np.column_stack([x, r])
    arrays = [np.ascontiguousarray(np.concatenate(nodes[::-1])), first.astype(np.int64), balls, order.astype(np.int64)]
    for array in arrays:
        array.setflags(write=False)
    return BallTree(*arrays)
