"""Which configurations of an arm are at a start or a goal: joints as they are, everything else by inverse kinematics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import kinematics
from ..entities import Point
from ..kinematics._point_arms import last_range
from ..robots import Robot
from ..scenes import GripperPlaneTarget, JointTarget, LineTarget, PlaneTarget, PoseTarget, PositionTarget, Scene
from ._clearance import arm, margin, touch

Floats = NDArray[np.float64]

FREE_SAMPLES = 72  # of the redundancy circle: 5 degrees apart
_POINT_SAMPLES = 36, 20  # of the two freedoms that a position alone leaves an arm of kind us5: psi, q5
_SEEDS = 24  # of a numerical inverse


@dataclass(frozen=True, slots=True)
class Configurations:
    """`q` (m, n) usable configurations, or none and the reason."""

    q: Floats
    reason: str = ""


def configurations(scene: Scene, which: str) -> Configurations:
    """Configurations at the scene's "start" or "goal": reached, within limits and clear, most clear first."""
    robot = arm(scene)
    q, reason = _reaching(scene, which)
    if not len(q):
        return Configurations(q, f"{which}: {_explained(scene, which, reason)}")
    inside = within_limits(robot, q)
    if not inside.any():
        reason = f"{limit_reason(robot, q)}{_scope(scene, which, len(q))}"
        return Configurations(q[:0], f"{which}: {_explained(scene, which, reason)}")
    q = np.ascontiguousarray(q[inside])
    margins = margin(scene, q)
    if not (margins >= 0.0).any():
        near = touch(scene, q)
        what = "in collision" if near.contact.distance < 0.0 else "too close"
        return Configurations(q[:0], f"{which} {what}: {near}{_scope(scene, which, len(q), ' within the limits')}")
    order = np.argsort(-margins)
    return Configurations(np.ascontiguousarray(q[order[margins[order] >= 0.0]]))


def _scope(scene: Scene, which: str, count: int, kept: str = "") -> str:
    """Of which postures a refusal speaks: of the one that is given, of all there are, or of those that were looked at."""
    target = getattr(scene, which)
    if isinstance(target, JointTarget):
        return ""
    if count == 1:
        postures = f"the only posture{kept}"
    else:
        postures = f"the best of {count} postures{kept}"
    structure = kinematics.classify(arm(scene))
    if not isinstance(target, (GripperPlaneTarget, PoseTarget)) and structure.position is not None:
        return f", in {postures}: every branch, with {_POINT_SAMPLES[0]} values of psi by {_POINT_SAMPLES[1]} of q5"
    if not isinstance(target, (GripperPlaneTarget, PoseTarget)) or not structure.is_closed_form:
        return f", in {postures} that a numerical search found; others may exist"
    if structure.parameter is None:
        return f", in {postures}: every branch was looked at"
    return f", in {postures}: every branch, with {FREE_SAMPLES} values of the free angle {structure.parameter}"


def _explained(scene: Scene, which: str, reason: str) -> str:
    """Why a target is not reached inside the limits: how far out of reach or which joint, and what is nearest to it."""
    from ..kinematics._explain import nearest_pose

    robot, target = arm(scene), _target_of(getattr(scene, which))
    if target is None:
        return reason
    structure = kinematics.classify(robot)
    alone = structure.position is not None and isinstance(target, Point)
    if alone or (structure.is_closed_form and structure.parameter is None and not isinstance(target, Point)):
        return kinematics.inverse(robot, target).explain(robot, target) or reason
    return f"{reason}; {nearest_pose(robot, target)}"


def _target_of(target: Any) -> Any:
    """What inverse kinematics takes for a target of a scene; None where that is more than one pose or point, or joints."""
    if isinstance(target, GripperPlaneTarget):
        return kinematics.GripperOnPlane(target.position, target.normal)
    if isinstance(target, PoseTarget):
        return target.motor()
    return Point.from_euclidean(target.position) if isinstance(target, PositionTarget) else None


def within_limits(robot: Robot, q: Floats, tolerance: float = 1e-9) -> NDArray[np.bool_]:
    """(...) whether configurations (..., n) keep the joint limits."""
    return np.all((q >= robot.limits.lower - tolerance) & (q <= robot.limits.upper + tolerance), axis=-1)


def limit_reason(robot: Robot, q: Floats) -> str:
    """Which joint leaves its limits, and by how much, in the configuration (of m) that is nearest to keeping them."""
    excess = np.maximum(robot.limits.lower - q, q - robot.limits.upper)
    best = excess[np.argmin(excess.max(axis=-1))]
    j = int(np.argmax(best))
    slides = any(link.coordinate == j and link.kind == "prismatic" for link in robot.links)
    beyond = f"{1e3 * best[j]:.3g} mm" if slides else f"{np.degrees(best[j]):.3g} degrees"
    return f"joint {robot.joint_names[j]!r} would be {beyond} beyond its limits in the nearest posture"


def _reaching(scene: Scene, which: str) -> tuple[Floats, str]:
    robot, target = arm(scene), getattr(scene, which)
    if isinstance(target, JointTarget):
        return target.q[None].copy(), ""
    if isinstance(target, GripperPlaneTarget):
        return _valid_rows(inverse_over(robot, _target_of(target), free_grid(robot)[0]))
    if isinstance(target, PoseTarget):
        return inverse_of_pose(scene, target.motor())
    rng = np.random.default_rng(scene.options.seed)
    found, reason = [], ""
    for point in _points_of(scene, target, rng):
        rows, why = inverse_of_point(scene, point, rng)
        reason = reason or why
        found.append(rows)
        if len(rows):
            break
    return np.concatenate(found), reason


def free_grid(robot: Robot) -> tuple[Floats, float]:
    """Values of the redundancy of the robot's closed form to look at, and their spacing: a circle, or a joint's range."""
    parameter = kinematics.classify(robot).parameter
    if parameter is None:
        return np.zeros(1), 0.0
    if parameter in ("phi", "psi"):
        return np.linspace(-np.pi, np.pi, FREE_SAMPLES, endpoint=False), 2.0 * np.pi / FREE_SAMPLES
    joint = int(parameter[1:]) - 1
    lower, upper = np.clip([robot.limits.lower[joint], robot.limits.upper[joint]], -np.pi, np.pi)
    return np.linspace(lower, upper, FREE_SAMPLES), (upper - lower) / (FREE_SAMPLES - 1)


def inverse_of_pose(scene: Scene, motor) -> tuple[Floats, str]:
    """Configurations (m, n) at a pose of the tool, over all branches and the whole redundancy where there is a formula."""
    robot = arm(scene)
    if not kinematics.classify(robot).is_closed_form:
        return _from_seeds(scene, motor, np.random.default_rng(scene.options.seed))
    return _valid_rows(inverse_over(robot, motor, free_grid(robot)[0]))


def inverse_over(robot: Robot, target, free: Floats) -> kinematics.IkSolutions:
    """All branches of a closed form at every value of the redundancy, if the robot has one."""
    given: dict[str, Any] = {}
    parameter = kinematics.classify(robot).parameter
    if parameter:
        given[parameter] = free
    return kinematics.inverse(robot, target, **given)


def inverse_of_point(scene: Scene, point: Floats, rng: np.random.Generator) -> tuple[Floats, str]:
    """Configurations (m, n) with the tool at a point, any orientation: over the freedoms of a closed form, or from many seeds."""
    robot = arm(scene)
    if kinematics.classify(robot).position is None:
        return _from_seeds(scene, Point.from_euclidean(point), rng)
    q, reason = _valid_rows(inverse_over_point(robot, point, point_grid(robot)[0]))
    best = kinematics.inverse(robot, Point.from_euclidean(point))
    q = np.concatenate([best.q[best.valid], q])
    inside = within_limits(robot, q)
    return (q[inside], "") if inside.any() or not len(q) else (q[:0], limit_reason(robot, q))


def point_grid(robot: Robot) -> tuple[Floats, Floats]:
    """Values (m, 2) of psi and q5 to look at for a position alone, and their spacing (2,)."""
    turns, rolls = _POINT_SAMPLES
    lower, upper = last_range(robot.limits.lower[4], robot.limits.upper[4])
    psi, last = np.linspace(-np.pi, np.pi, turns, endpoint=False), np.linspace(lower, upper, rolls)
    values = np.stack(np.meshgrid(psi, last, indexing="ij"), axis=-1).reshape(-1, 2)
    return values, np.array([2.0 * np.pi / turns, (upper - lower) / (rolls - 1)])


def inverse_over_point(robot: Robot, point: Floats, free: Floats) -> kinematics.IkSolutions:
    """All branches of the closed form for a position alone, at values (m, 2) of psi and q5."""
    return kinematics.inverse(robot, Point.from_euclidean(point), psi=free[:, 0], q5=free[:, 1])


def _from_seeds(scene: Scene, target, rng: np.random.Generator) -> tuple[Floats, str]:
    robot = arm(scene)
    lower = np.where(np.isfinite(robot.limits.lower), robot.limits.lower, -np.pi)
    upper = np.where(np.isfinite(robot.limits.upper), robot.limits.upper, np.pi)
    seeds = [0.5 * (lower + upper), *rng.uniform(lower, upper, (_SEEDS - 1, robot.n_joints))]
    if isinstance(scene.start, JointTarget):
        seeds.insert(0, scene.start.q)
    rows, reason = [], ""
    for seed in seeds:
        q, why = _valid_rows(kinematics.numerical_inverse(robot, target, seed=seed))
        rows.append(q)
        reason = reason or why
    return np.concatenate(rows), reason


def _points_of(scene: Scene, target, rng: np.random.Generator) -> list[Floats]:
    """Points of a goal, those nearest to where the tool starts first."""
    if isinstance(target, PositionTarget):
        return [target.position]
    start = _tool_start(scene)
    spread = np.array([0.0, *(s * d for d in (0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0) for s in (1, -1))])
    if isinstance(target, LineTarget):
        foot = target.point + ((start - target.point) @ target.direction) * target.direction
        return [foot + s * target.direction for s in spread]
    if isinstance(target, PlaneTarget):
        foot = start + (target.distance - start @ target.normal) * target.normal
        sides = rng.normal(size=(len(spread), 3))
        sides -= (sides @ target.normal)[:, None] * target.normal
        sides /= np.linalg.norm(sides, axis=1, keepdims=True)
        return [foot + abs(s) * side for s, side in zip(spread, sides)]
    raise TypeError(f"an arm has no target of kind {type(target).__name__}")


def _tool_start(scene: Scene) -> Floats:
    if isinstance(scene.start, JointTarget):
        return kinematics.forward(arm(scene), scene.start.q).as_matrix()[:3, 3]
    return scene.start.position


def _valid_rows(solutions) -> tuple[Floats, str]:
    q = solutions.q.reshape(-1, solutions.q.shape[-1])[solutions.valid.reshape(-1)]
    if len(q):
        return q, ""
    reason = solutions.reason
    if not isinstance(reason, str):  # one for each value of the free angle: that of the nearest
        texts = np.asarray(reason).reshape(-1)
        errors = solutions.residual.reshape(len(texts), -1).min(axis=-1)
        reason = f"{texts[np.argmin(errors)]} (the nearest of {len(texts)} values of the free angle)"
    return q, reason or "no configuration found"
