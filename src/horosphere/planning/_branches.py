"""Closed-form arms: one configuration per path point, out of all branches and the whole redundancy circle at once.

The robust algorithm of [Humanoid] section VI-C, corrected: every candidate is checked against limits and obstacles, and the
chain is chosen for the whole path, never point by point (docs/errata.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import kinematics
from ..robots import Robot
from ..scenes import GripperPlaneTarget, JointTarget, PoseTarget, PositionTarget, Scene
from ._chain import ChainSearch
from ._clearance import Touch, arm, margin, touch
from ._free_angles import free_grid, inverse_over, inverse_over_point, point_grid
from ._postures import within_limits
from ._refusals import limit_reason

Floats = NDArray[np.float64]

_REFINED = 21, 9  # samples of one redundancy, of each of two, about the coarse choice, in the second pass
_COMFORT = 0.03  # metres above the clearance asked beyond which more clearance is worth nothing
_COMFORT_COST = 1.0  # of a waypoint at the clearance asked, in units of a largest joint step


@dataclass(frozen=True, slots=True)
class ArmPath:
    """Waypoints (k, n) along a tool path, or None and the reason.

    `jump`: where on the path (a share of its points) no posture goes over into another, and the joint step missing there
    (rad), which a finer path may mend; `touch`: what is in the way, where that is the reason.
    """

    waypoints: Floats | None
    reason: str = ""
    jump: tuple[float, float] | None = None
    touch: Touch | None = None


def supports(scene: Scene) -> bool:
    """Whether this method knows the robot and the kind of its start and goal."""
    structure = kinematics.classify(arm(scene))
    if _by_position(scene):
        return True
    fits = GripperPlaneTarget if structure.name == "humanoid_arm" else PoseTarget
    ends = scene.start, scene.goal
    if structure.name == "humanoid_arm" and all(isinstance(end, JointTarget) for end in ends):
        return False  # no plane is given
    # with fewer than six joints a pose between two reachable ones is in general out of reach
    enough = structure.name == "humanoid_arm" or arm(scene).n_joints >= 6
    return structure.is_closed_form and enough and all(isinstance(end, (fits, JointTarget)) for end in ends)


def _by_position(scene: Scene) -> bool:
    """Whether the robot's closed form is for a position alone, and the ends ask for no more."""
    ends = scene.start, scene.goal
    some = any(isinstance(end, PositionTarget) for end in ends)
    known = kinematics.classify(arm(scene)).position is not None
    return known and some and all(isinstance(end, (PositionTarget, JointTarget)) for end in ends)


def follow_branches(scene: Scene, points: Floats, *, whole: bool = True) -> ArmPath:
    """Waypoints for the tool points (k, 3): candidates at every point, then the cheapest continuous chain, then refined.

    Where the chain breaks, the points behind are still looked at, since one without any posture matters more: a break may
    mend on a finer path. Not so with `whole` False, which stops at the break.
    """
    family = _family(scene, points)
    layers, margins, chosen = [], [], []
    free, spacing = _grid(scene)
    limit = scene.options.max_joint_step
    coarse_limit = max(limit, 2.5 * float(spacing.max()))  # the grid itself moves joints by about its spacing
    chain, broken = ChainSearch(coarse_limit), None
    for k in range(len(points)):
        layer, spare, angle, reason = _usable(scene, *family(k, free))
        if not len(layer):
            where = f"at path point {k} of {len(points) - 1} {np.round(points[k], 3).tolist()}"
            return ArmPath(None, f"{where}: {reason}", touch=reason if isinstance(reason, Touch) else None)
        layers.append(layer)
        margins.append(spare)
        chosen.append(angle)
        if broken is None and not chain.extend(layer, _cost(spare)):
            broken = _jump(points, k, chain.gap(layer), coarse_limit)
        if broken is not None and not whole:
            break
    if broken is not None:
        return broken
    count = _REFINED[len(spacing) - 1] if spacing.any() else 1
    finer = np.linspace(-1.0, 1.0, count)[:, None] * spacing
    if len(spacing) == 2:
        finer = np.stack(np.meshgrid(*finer.T, indexing="ij"), axis=-1).reshape(-1, 2)
    layers2, fine = [], ChainSearch(limit)
    for k, index in enumerate(chain.indices()):
        layer, spare, _, _ = _usable(scene, *family(k, chosen[k][index] + finer))
        near = np.abs(layer - layers[k][index]).max(axis=1) <= coarse_limit
        layer = np.concatenate([layers[k][index][None], layer[near]])
        if not fine.extend(layer, _cost(np.concatenate([margins[k][index][None], spare[near]]))):
            return _jump(points, k, fine.gap(layer), limit)
        layers2.append(layer)
    return ArmPath(np.stack([layer[i] for layer, i in zip(layers2, fine.indices())]))


def _jump(points: Floats, k: int, gap: float, limit: float) -> ArmPath:
    """Between two points of the path no posture goes over into another one."""
    reason = (
        f"the arm cannot follow the tool's path without a jump: at point {k} of {len(points) - 1}, "
        f"{np.round(points[k], 3).tolist()}, a joint would move {np.degrees(gap):.3g} degrees at once, "
        f"more than {np.degrees(limit):.3g}"
    )
    return ArmPath(None, reason, jump=(k / (len(points) - 1), gap))


def _grid(scene: Scene) -> tuple[Floats, Floats]:
    """Values (m, d) of the d freedoms to look at, and their spacing (d,)."""
    if _by_position(scene):
        return point_grid(arm(scene))
    free, spacing = free_grid(arm(scene))
    return free[:, None], np.array([spacing])


def _usable(scene: Scene, q: Floats, valid: NDArray[np.bool_], free: Floats):
    """The candidates (m, n) that are reached, within limits and clear, their margins and redundancy angles; or why none."""
    robot = arm(scene)
    if not valid.any():
        return q[:0], np.zeros(0), free[:0], "out of reach"
    q, free = q[valid], free[valid]
    inside = within_limits(robot, q)
    if not inside.any():
        return q[:0], np.zeros(0), free[:0], limit_reason(robot, q)
    q, free = np.ascontiguousarray(q[inside]), free[inside]
    margins = margin(scene, q)
    clear = margins >= 0.0
    if not clear.any():
        return q[:0], margins[:0], free[:0], touch(scene, q)
    return np.ascontiguousarray(q[clear]), margins[clear], free[clear], ""


def _cost(spare: Floats) -> Floats:
    """What a posture costs: nothing with ample clearance, up to one largest joint step at the clearance asked."""
    return _COMFORT_COST * np.maximum(0.0, 1.0 - spare / _COMFORT) ** 2


def _family(scene: Scene, points: Floats):
    """A function (k, free angles (m, d)) -> (configurations, valid, free angles) at path point k, each row one candidate."""
    robot, last = arm(scene), len(points) - 1
    fraction = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    fraction /= max(fraction[-1], 1e-300)
    alone = _by_position(scene)
    humanoid = kinematics.classify(robot).name == "humanoid_arm"
    normals = _normals(robot, scene.start, scene.goal, fraction) if humanoid else None
    motors: Any = None if humanoid or alone else _poses(robot, scene.start, scene.goal, points, fraction)

    def family(k: int, free: Floats):
        target = scene.start if k == 0 else scene.goal if k == last else None
        if isinstance(target, JointTarget):
            return target.q[None].copy(), np.ones(1, bool), np.zeros((1, free.shape[1]))
        if alone:
            found = inverse_over_point(robot, points[k], free)
        else:
            goal: Any = motors[k] if normals is None else kinematics.GripperOnPlane(points[k], normals[k])
            found = inverse_over(robot, goal, free[:, 0])
        rows = found.q.reshape(-1, robot.n_joints)
        return rows, found.valid.reshape(-1), np.repeat(free, len(rows) // len(free), axis=0)

    return family


def _normals(robot: Robot, start, goal, fraction: Floats) -> Floats:
    """Plane normals (k, 3) along the path, turning evenly from the start's to the goal's."""
    ends: list = [target.normal if isinstance(target, GripperPlaneTarget) else None for target in (start, goal)]
    for i, target in enumerate((start, goal)):
        if ends[i] is None:  # a joint posture: the plane nearest to the other end's that holds its gripper direction
            pose = kinematics.forward(robot, target.q).as_matrix()
            gripper = pose[:3, :3] @ [0.0, 1.0, 0.0]
            normal = ends[1 - i] - (ends[1 - i] @ gripper) * gripper
            length = np.linalg.norm(normal)
            ends[i] = normal / length if length > 1e-6 else np.cross(gripper, np.eye(3)[np.argmin(np.abs(gripper))])
            ends[i] /= np.linalg.norm(ends[i])
    a, b = ends
    if a @ b < 0.0:
        b = -b  # a plane has two normals
    angle = np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)
    if angle < 1e-12:
        return np.broadcast_to(a, (len(fraction), 3))
    weights = np.sin(np.stack([(1.0 - fraction) * angle, fraction * angle], axis=1)) / np.sin(angle)
    return weights[:, :1] * a + weights[:, 1:] * b


def _poses(robot: Robot, start, goal, points: Floats, fraction: Floats):
    """Tool poses along the path: positions on it, orientation turning evenly about one axis."""
    from ..versors import Motor

    first, final = (
        kinematics.forward(robot, target.q) if isinstance(target, JointTarget) else target.motor()
        for target in (start, goal)
    )
    turn = (~first @ final).log().copy()
    turn[3:] = 0.0
    rotations = (first @ Motor.exp(fraction[:, None] * turn)).as_matrix()
    rotations[:, :3, 3] = points
    return Motor.from_matrix(rotations)
