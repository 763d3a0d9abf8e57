"""Meshes and large point clouds as trees in arrays that compiled code walks."""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ._ball_tree import BallTree, ball_tree
from ._base import Floats
from ._sampled import Mesh, PointCloud
from ._shells import Shell, shells, unit_normals

CLOUD, MESH = 5.0, 6.0
WIDTH, TRIANGLE = 18, 34
FEW = 64
"""Clouds of fewer balls are rows of their own; more go into a tree."""
LEAF = 4
CROSSING = 1e-13
"""Parts of a closed surface nearer than this share of its coordinates count as crossing: rounding cannot tell them apart."""


class Forest(NamedTuple):
    """Trees over the balls and triangles of any number of shapes, one behind the other; see `_tree_kernels`.

    `nodes` (n, 4), `ends` (m,) where the items of each leaf begin, and where the last one ends, `balls` (b, 4), `triangles` (t, 34).
    """

    nodes: Floats
    ends: NDArray[np.int64]
    balls: Floats
    triangles: Floats


_known: WeakKeyDictionary[Mesh | PointCloud, tuple[Floats, Forest]] = WeakKeyDictionary()


def grow(shape: Mesh | PointCloud) -> tuple[Floats, Forest]:
    """Rows (k, 18) of a shape, one for each of its solids, and the forest they point into; made once a shape."""
    if shape not in _known:
        _known[shape] = _cloud(shape) if isinstance(shape, PointCloud) else _mesh(shape)
    return _known[shape]


def join(parts: list[tuple[Floats, Forest]]) -> tuple[list[Floats], Forest | None]:
    """Rows of several forests as rows of the one they make together."""
    if not parts:
        return [], None
    if len(parts) == 1:
        return [parts[0][0]], parts[0][1]
    rows, starts = [], np.zeros(4, np.int64)
    ends = []
    for own, forest in parts:
        moved, kind = own.copy(), 2 if own[0, 0] == CLOUD else 3
        moved[:, 6] += starts[0]
        moved[:, 8] += starts[1]
        moved[:, 10:12] += starts[kind]
        rows.append(moved)
        ends.append(forest.ends + starts[kind])
        starts += [len(array) for array in forest]
    forests = [forest for _, forest in parts]
    nodes, balls = np.concatenate([f.nodes for f in forests]), np.concatenate([f.balls for f in forests])
    triangles = np.concatenate([f.triangles for f in forests])
    return rows, Forest(nodes, np.concatenate(ends), balls, triangles)


def _cloud(cloud: PointCloud) -> tuple[Floats, Forest]:
    tree = ball_tree(cloud)
    row = np.zeros((1, WIDTH))
    row[0, 0], row[0, 1:5] = CLOUD, tree.nodes[0]
    row[0, 7], row[0, 11] = tree.leaves, len(tree.balls)
    low, high = tree.balls[:, :3] - tree.balls[:, 3:], tree.balls[:, :3] + tree.balls[:, 3:]
    row[0, 12:15], row[0, 15:18] = low.min(axis=0), high.max(axis=0)
    return row, Forest(_writable(tree.nodes), _writable(tree.first), _writable(tree.balls), np.zeros((0, TRIANGLE)))


def _mesh(mesh: Mesh) -> tuple[Floats, Forest]:
    rows: list[Floats] = []
    nodes: list[Floats] = []
    ends: list[NDArray[np.int64]] = []
    items: list[Floats] = []
    counts = np.zeros(3, np.int64)
    for shell in shells(mesh.vertices, mesh.faces):
        corners = shell.triangles
        middle = 0.5 * (corners.min(axis=1) + corners.max(axis=1))
        radius = np.linalg.norm(corners - middle[:, None], axis=-1).max(axis=1) * (1.0 + 1e-12)
        tree = ball_tree(PointCloud(middle, radius), LEAF)
        m = len(corners)
        parts = (corners, unit_normals(corners), shell.edges, shell.corners)
        table = np.column_stack([*(part.reshape(m, -1) for part in parts), middle, radius])[tree.order]
        row = np.zeros((1, WIDTH))
        row[0, 0], row[0, 1:5] = MESH, tree.nodes[0]
        row[0, 6:12] = counts[0], tree.leaves, counts[1], _kind(shell, tree, table), counts[2], counts[2] + m
        row[0, 12:15], row[0, 15:18] = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        rows.append(row)
        nodes.append(tree.nodes)
        ends.append(tree.first + counts[2])
        items.append(table)
        counts += len(tree.nodes), len(tree.first), m
    if not rows:  # every triangle has two corners in one place
        empty = Forest(np.zeros((0, 4)), np.zeros(0, np.int64), np.zeros((0, 4)), np.zeros((0, TRIANGLE)))
        return np.zeros((0, WIDTH)), empty
    table = np.concatenate(items)
    return np.concatenate(rows), Forest(np.concatenate(nodes), np.concatenate(ends), np.zeros((0, 4)), table)


def _kind(shell: Shell, tree: BallTree, table: Floats) -> int:
    """0 a surface, 1 a solid, 2 a convex one, 3 one whose surface may cross itself."""
    if not shell.closed or shell.convex:
        return 2 * shell.closed
    from ._crossing_kernels import crosses_itself

    nearness = CROSSING * float(np.abs(shell.triangles).max())
    return 3 if shell.pinched or crosses_itself(_writable(tree.nodes), _writable(tree.first), table, nearness) else 1


def _writable(array: NDArray) -> NDArray:
    """Compiled code is made for writable arrays; a read-only one would be compiled for again."""
    return array if array.flags.writeable else array.copy()
