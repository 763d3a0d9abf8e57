"""Jacobians by the inner-product theorem: the derivative of what a link carries is its product with the joint axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..entities import Entity, Line, Plane, Point, Sphere
from ..errors import InputError
from ..kernels import output_array
from ..numeric import float_array
from ..robots import Robot, link_index
from ..versors import Motor
from . import _joint_kernels as joints
from ._forward import _writable, carry, check_finite, joint_array
from ._robot_kernels import run
from ._tree import Tree, tree

Floats = NDArray[np.float64]


def jacobian(
    robot: Robot, q: ArrayLike, out: Floats | None = None, *, link: str | None = None, point: ArrayLike | None = None
) -> Floats:
    """Twist of the tool frame by joint rates: (..., 6, n), rows angular (rad/s), then linear (m/s) at the tool point,
    base axes.

    Column j is (direction of L_j, Euclidean part of X . L_j): X the tool point as a conformal point, L_j the line of
    the joint's axis now (direction times e_inf for a prismatic joint). Coordinates that move several joints (mimic)
    have the sum, with the multipliers.
    q: (..., n); out: (..., 6, n). link, point: of another link, at a point (..., 3) of its frame (default its origin).
    Source: [Humanoid], [Snake]. Raises InputError for a wrong shape or numbers that are not finite.
    """
    if link is not None or point is not None:
        return _jacobian_of_link(robot, q, out, link, point)
    try:
        J = robot.memo["jacobian"](q, out)
    except (KeyError, AttributeError):  # not compiled yet
        J = None
    return run(robot, "jacobian", q, [out])[0] if J is None else J


def forward_and_jacobian(robot: Robot, q: ArrayLike, out: tuple[Floats, Floats] | None = None) -> tuple[Motor, Floats]:
    """`forward` and `jacobian` in one pass: q (..., n) -> Motor (...) and (..., 6, n).

    out: the arrays (..., 8) and (..., 6, n) to write into, as for either alone.
    """
    pose, J = (None, None) if out is None else out
    try:
        both = robot.memo["forward and jacobian"](q, pose, J)
    except (KeyError, AttributeError):  # not compiled yet
        both = None
    if both is not None:
        return both
    pose, J = run(robot, "forward and jacobian", q, [pose, J])
    return Motor._wrap(pose.view()), J


def _jacobian_of_link(robot: Robot, q: ArrayLike, out: Any, link: str | None, point: ArrayLike | None) -> Floats:
    from . import _kernels

    q = joint_array(robot, q)
    check_finite(robot, q)
    arrays, path = link_arrays(robot, link)
    at = float_array(np.zeros(3) if point is None else point, "point", last=3)
    batch = np.broadcast_shapes(q.shape[:-1], at.shape[:-1])
    result = output_array(out, (*batch, 6, robot.n_joints))
    flat = np.array(np.broadcast_to(q, (*batch, robot.n_joints)), order="C").reshape(-1, robot.n_joints)
    points = np.array(np.broadcast_to(at, (*batch, 3)), order="C").reshape(-1, 3)
    _kernels.jacobian_batch(*arrays, path, flat, points, result.reshape(-1, 6, robot.n_joints))
    return result


def link_arrays(robot: Robot, link: str | None) -> tuple[Tree, NDArray[np.int64]]:
    """The tree, and the indices from the base to a link; for None to the tool frame, as one more link at the end."""
    arrays = tree(robot)
    if link is None:
        count = len(robot.links)
        if "tree with tool" not in robot.memo:
            robot.memo["tree with tool"] = Tree(
                np.append(arrays.parents, robot.tip),
                np.vstack([arrays.origins, robot.tool]),
                np.append(arrays.kinds, 0),
                np.vstack([arrays.axes, [0.0, 0.0, 1.0]]),
                np.append(arrays.coords, -1),
                np.append(arrays.mult, 1.0),
                np.append(arrays.offs, 0.0),
            )
        return robot.memo["tree with tool"], np.array([*robot.chain, count], np.int64)
    path = [link_index(robot, link)]
    while path[-1]:
        path.append(robot.links[path[-1]].parent)
    return arrays, np.array(path[::-1], np.int64)


def joint_generators(robot: Robot, q: ArrayLike, link: str | None = None) -> Floats:
    """Generators G (..., n, 6) of unit joint rates in base axes, over (e12, e13, e23, e1i, e2i, e3i).

    The IPNS line of a revolute joint's axis, the direction times e_inf of a prismatic one; zero for joints that do
    not move `link`.
    """
    from . import _kernels

    q = joint_array(robot, q)
    check_finite(robot, q)
    arrays, path = link_arrays(robot, link)
    result = np.empty((*q.shape[:-1], robot.n_joints, 6))
    flat = _writable(q.reshape(-1, robot.n_joints))
    _kernels.generators_batch(*arrays, path, flat, result.reshape(-1, robot.n_joints, 6))
    return result


def entity_jacobian(robot: Robot, q: ArrayLike, entity: Any, link: str | None = None) -> Floats:
    """Derivative of `carry(robot, q, entity, link).array` by the joints: (..., K, n), K numbers of the entity's array.

    [X, G_j] / 2 with the generators G_j of the joints: X . G_j for a point (rows 0..2: its velocity) or plane, the
    commutator for a line (rows 0..2: e12, e13, e23 of the direction; 3..5 the moment); the inner-product theorem of
    [Snake] and [Humanoid]. Spheres, circles and point pairs: of the centre and of the direction, zero for the squared
    radius.
    """
    if not isinstance(entity, Entity):
        raise InputError(f"expected an entity (Point, Line, Plane, ...), got {type(entity).__name__}", place="entity")
    moved = carry(robot, q, entity, link)
    generators = joint_generators(robot, q, link)
    values = moved.array[..., None, :]
    if isinstance(entity, (Point, Line)):
        rate = (joints.vector_rate if isinstance(entity, Point) else joints.line_rate)(values, generators)
    elif isinstance(entity, Plane):
        vector = np.concatenate([values[..., :3], np.zeros_like(values[..., :1]), values[..., 3:]], axis=-1)
        rate = joints.vector_rate(vector, generators)[..., [0, 1, 2, 4]]
    else:
        rate = np.zeros(np.broadcast_shapes(values.shape[:-1], generators.shape[:-1]) + values.shape[-1:])
        rate[..., :3] = joints.vector_rate(Point.from_euclidean(values[..., :3]).array, generators)[..., :3]
        if not isinstance(entity, Sphere):
            line = Line.from_point_direction(values[..., :3], values[..., 3:6])
            rate[..., 3:6] = joints.line_rate(line.array, generators)[..., 2::-1] * [1.0, -1.0, 1.0]
    return np.ascontiguousarray(np.swapaxes(rate, -1, -2))
