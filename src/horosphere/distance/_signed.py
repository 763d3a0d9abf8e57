"""Signed distance between a robot and obstacles."""

from __future__ import annotations

import math
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..numeric import float_array
from ..robots import Robot
from ..robots._robot import require_robot
from ..shapes import Packed, as_shapes, pack
from ._pack import Body, pack_robot

Floats = NDArray[np.float64]
_NO_PAIRS = np.zeros((0, 3), np.int64)
_recent: list[tuple[tuple[Any, ...], Packed]] = []


def pack_obstacles(obstacles: Any, *, trees: bool = True) -> Packed:
    """Any obstacles as arrays; the last few sets are kept, since a loop asks for the same one again and again.

    Without `trees`, every ball of a cloud is a row, and every box that a mesh is enclosed in.
    """
    if isinstance(obstacles, Packed):
        return obstacles
    shapes = as_shapes(obstacles)
    if not trees:
        return pack(shapes, trees=False)
    for known, packed in _recent:
        if len(known) == len(shapes) and all(a is b for a, b in zip(known, shapes)):
            return packed
    packed = pack(shapes)
    _recent.insert(0, (shapes, packed))
    del _recent[8:]
    return packed


def allowance(robot: Robot, solids: Packed) -> NDArray[np.bool_] | None:
    """Which capsules (m) may touch which rows of the obstacles: those of `robot.allowed_obstacles`; None if there are none."""
    pairs = [(link, name) for link, name in require_robot(robot).allowed_obstacles if name in solids.names]
    if not pairs:
        return None
    allowed = np.zeros((len(robot.capsules), len(solids.rows)), np.bool_)
    for link, name in pairs:
        own = robot.capsules.link == robot.link_names.index(link)
        allowed |= own[:, None] & (solids.owner == solids.names.index(name))
    return allowed


def configurations(robot: Robot, q: ArrayLike) -> Floats:
    """q (..., n) checked and writable (a read-only array would be compiled for again)."""
    require_robot(robot)
    array = float_array(q, "q", last=robot.n_joints)
    return array if array.flags.writeable else array.copy()


@overload
def signed(
    robot: Robot,
    q: ArrayLike,
    obstacles: Any,
    gradient: Literal[False] = False,
    *,
    self_collision: bool = False,
    static: bool = True,
) -> Floats: ...
@overload
def signed(
    robot: Robot,
    q: ArrayLike,
    obstacles: Any,
    gradient: Literal[True],
    *,
    self_collision: bool = False,
    static: bool = True,
) -> tuple[Floats, Floats]: ...


def signed(
    robot: Robot,
    q: ArrayLike,
    obstacles: Any,
    gradient: bool = False,
    *,
    self_collision: bool = False,
    static: bool = True,
) -> Floats | tuple[Floats, Floats]:
    """Least signed distance (...,) in metres between the robot's capsules and the obstacles, and its gradient (..., n) if asked.

    q (..., n) rad or m; obstacles as in `shapes.as_shapes`. Exact: apart, the Euclidean distance of the bodies; penetrating,
    minus the length of the shortest translation that parts the nearest pair (an ellipsoid met by the axis of a capsule: minus the
    greatest depth of a point of the axis, minus the radius). Infinite where there is nothing to touch. `self_collision` takes
    the pairs `robot.self_pairs` in as well. Without `static`, bodies that no joint moves meet no obstacle. Pairs of
    `robot.allowed_obstacles` are not looked at. A mesh is as exact as a box where it is convex; an axis within another
    closed one counts minus the depth of its deepest point, and an open one is a surface.
    The gradient is n . (axis x (x - p)) at the witness x, per unit of q; where two
    pairs or two witnesses tie, it is that of one of them. Raises InputError. Our derivation, docs/distance.md.
    """
    Q = configurations(robot, q)
    body, solids = pack_robot(robot, static), pack_obstacles(obstacles)
    flat = Q.reshape(math.prod(Q.shape[:-1]), robot.n_joints)
    distance = np.empty(len(flat))
    slope = np.empty_like(flat) if gradient else np.empty((0, robot.n_joints))
    _run(body, solids, allowance(robot, solids), self_collision, flat, distance, slope)
    shape = Q.shape[:-1]
    result = distance.reshape(shape)
    return (result, slope.reshape(Q.shape)) if gradient else result


def clearance(robot: Robot, q: ArrayLike, obstacles: Any) -> Floats:
    """Least signed distance (...,) to the obstacles and between the robot's own links (`robot.self_pairs`), metres."""
    return signed(robot, q, obstacles, self_collision=True)


def _run(
    body: Body,
    solids: Packed,
    allowed: NDArray[np.bool_] | None,
    self_collision: bool,
    Q: Floats,
    D: Floats,
    G: Floats,
) -> None:
    from ._body_kernels import signed_batch

    pairs = body.pairs if self_collision else _NO_PAIRS
    signed_batch(
        body.joints, body.constants, body.frames, body.capsules, solids.rows, pairs, Q, D, G, (*solids.extra, allowed)
    )
