"""Shapes as rows of numbers for compiled code."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ._base import Floats, Shape
from ._flat import Box, Cylinder, HalfSpace
from ._forest import FEW, WIDTH, Forest, grow, join
from ._round import Ball, Capsule, Ellipsoid
from ._sampled import Mesh, PointCloud

SEGMENT, BOX, CYLINDER, HALF_SPACE, ELLIPSOID = 0.0, 1.0, 2.0, 3.0, 4.0


@dataclass(frozen=True, slots=True, eq=False)
class Packed:
    """Shapes in contiguous arrays.

    `rows` (m, 18): 0 kind, 1-3 centre and 4 radius of a bounding ball, 5 rounding radius, 6- numbers of the kind:
      0 segment (ball, capsule): 6-8 end a, 9-11 vector b - a
      1 box: 6-14 its axes (rows), 15-17 half sizes      4 ellipsoid: 6-14 its axes (rows), 15-17 semi-axes
      2 cylinder: 6-14 a frame (rows) with its axis last, 15 radius, 16 half length
      3 half-space: 6-8 outward unit normal, 9 distance
      5 point cloud of 64 or more balls, 6 one solid or surface of a mesh: see `_tree_kernels`
    `owner` (m,): which shape a row belongs to (a small point cloud has many rows, a mesh one for each of its parts). `names`:
    one a shape. `framed`: 1, or None where no row is a box, cylinder or ellipsoid: then compiled code need not know them.
    `forest`: the trees that rows of kind 5 and 6 point into, or None where there is no such row.
    """

    rows: Floats
    owner: NDArray[np.int64]
    names: tuple[str, ...]
    framed: int | None = 1
    forest: Forest | None = None

    @property
    def extra(self) -> tuple[int | None, Forest | None]:
        """What compiled code has to know beside the rows."""
        return self.framed, self.forest

    def __len__(self) -> int:
        return len(self.names)


def pack(shapes: tuple[Shape, ...], *, trees: bool = True) -> Packed:
    """Three-dimensional shapes as rows. Without `trees`, every ball of a cloud is a row, and every box of a mesh's `box_cover`.

    Raises InputError for a shape of another dimension.
    """
    for index, shape in enumerate(shapes if isinstance(shapes, tuple | list) else (shapes,)):
        if not isinstance(shape, Shape):
            raise InputError(f"expected a Shape, got {type(shape).__name__}", place=f"shapes[{index}]")
    rows: list[Floats] = []
    owner, names, grown, at = [], [], [], []
    for index, shape in enumerate(shapes):
        names.append(shape.name or f"{type(shape).__name__.lower()} {index}")
        if trees and (isinstance(shape, Mesh) or (isinstance(shape, PointCloud) and len(shape.points) >= FEW)):
            grown.append(grow(shape))
            at.append(index)
            rows.append(grown[-1][0])
        else:
            parts = _boxes(shape) if isinstance(shape, Mesh) else (shape,)
            rows.append(np.concatenate([_rows(part, names[-1]) for part in parts]))
        owner += [index] * len(rows[-1])
    moved, forest = join(grown)
    for index, block in zip(at, moved):
        rows[index] = block
    table = np.concatenate(rows) if rows else np.zeros((0, WIDTH))
    # one kind of compiled code more, not two, where there are trees
    framed = 1 if forest is not None or np.isin(table[:, 0], (BOX, CYLINDER, ELLIPSOID)).any() else None
    return Packed(np.ascontiguousarray(table), np.array(owner, dtype=np.int64), tuple(names), framed, forest)


def _boxes(mesh: Mesh) -> tuple[Shape, ...]:
    from ._box_cover import box_cover  # brings trimesh and scipy

    return box_cover(mesh).boxes


def _rows(shape: Shape, name: str) -> Floats:
    if shape.dimension != 3:
        raise InputError(f"{name} lives in dimension {shape.dimension}, expected 3", place="obstacles")
    if isinstance(shape, PointCloud):
        rows = np.zeros((len(shape.points), WIDTH))
        rows[:, 1:4] = rows[:, 6:9] = shape.points
        rows[:, 4] = rows[:, 5] = shape.radius
        return rows
    row = np.zeros((1, WIDTH))
    row[0, 1:4], row[0, 4] = shape.bounding_ball()
    numbers = row[0]
    if isinstance(shape, Ball):
        numbers[0], numbers[5], numbers[6:9] = SEGMENT, shape.radius, shape.center
    elif isinstance(shape, Capsule):
        numbers[0], numbers[5], numbers[6:9], numbers[9:12] = SEGMENT, shape.radius, shape.a, shape.b - shape.a
    elif isinstance(shape, (Box, Ellipsoid)):
        numbers[0] = BOX if isinstance(shape, Box) else ELLIPSOID
        numbers[6:15] = shape.rotation.T.ravel()
        numbers[15:18] = shape.half_sizes if isinstance(shape, Box) else shape.semi_axes
    elif isinstance(shape, Cylinder):
        u = shape.b - shape.a
        length = float(np.linalg.norm(u))
        numbers[0], numbers[6:15], numbers[15], numbers[16] = CYLINDER, _frame(u / length), shape.radius, 0.5 * length
    elif isinstance(shape, HalfSpace):
        numbers[0], numbers[6:9], numbers[9] = HALF_SPACE, shape.normal, shape.distance
    else:
        raise InputError(
            f"a {type(shape).__name__} ({name}) is not taken here",
            place="obstacles",
            choices=("Ball", "Capsule", "Cylinder", "Box", "HalfSpace", "Ellipsoid", "Mesh", "PointCloud"),
        )
    return row


def _frame(axis: Floats) -> Floats:
    """The rows of a rotation that takes the unit vector `axis` to z, flat."""
    x = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = x - (x @ axis) * axis
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(axis, x), axis], dtype=np.float64).ravel()
