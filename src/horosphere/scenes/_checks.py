"""What must fit together in a scene, whether it comes from a file or from Python."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ._bodies import Aerofoil, EllipsoidND, PointRobot, SnakeRobot, Star, UnicycleRobot, Workspace, kind_of
from ._options import FieldOptions
from ._targets import (
    GripperPlaneTarget,
    HeadingTarget,
    JointTarget,
    LineTarget,
    PlaneTarget,
    PoseTarget,
    PositionTarget,
    PostureTarget,
)
from ._yaml import Problem

AS_DEGREES = "angles are radians; as degrees all of them would fit: joints_deg in a scene file, numpy.radians in Python"
_ARM = (JointTarget, PositionTarget, GripperPlaneTarget, PoseTarget, LineTarget, PlaneTarget)
_WRITTEN = {
    JointTarget: "joints",
    PositionTarget: "position",
    GripperPlaneTarget: "position + plane_normal",
    PoseTarget: "position + quaternion_wxyz or rpy",
    LineTarget: "line",
    PlaneTarget: "plane",
    HeadingTarget: "position + heading",
    PostureTarget: "position + heading + joints",
}


def kinds(robot: Any) -> tuple[type, ...]:
    """The target kinds that make sense for `robot`."""
    if isinstance(robot, PointRobot):
        return (PositionTarget,)
    if isinstance(robot, UnicycleRobot):
        return (HeadingTarget,)
    return (PostureTarget,) if isinstance(robot, SnakeRobot) else _ARM


def dimension_of(obstacle: Any) -> int:
    """Dimension of the space an obstacle lives in."""
    if isinstance(obstacle, (Aerofoil, Star)):
        return 2
    return len(obstacle.center) if isinstance(obstacle, EllipsoidND) else obstacle.dimension


def problems(
    robot: Any,
    start: Any,
    goal: Any,
    obstacles: tuple[Any, ...],
    workspace: Workspace | None,
    field: FieldOptions,
    dimension: int | None = None,
) -> Iterator[Problem]:
    """All that does not fit; parts that are None (not readable) are left out. `dimension`: of the space, where there is no robot."""
    if robot is not None:
        dimension = robot.dimension if isinstance(robot, PointRobot) else 2 if len(kinds(robot)) == 1 else 3
        for name, target in (("start", start), ("goal", goal)):
            if target is not None:
                yield from _target(robot, target, name, dimension)
    seen: dict[str, int] = {}
    for i, obstacle in enumerate(obstacles):
        if obstacle is None:
            continue
        if dimension not in (None, dimension_of(obstacle)):
            what = f"a {kind_of(obstacle)} of dimension {dimension_of(obstacle)}"
            yield Problem(("obstacles", i), f"{what} in a scene of dimension {dimension}")
        label = getattr(obstacle, "name", "")
        if label and seen.setdefault(label, i) != i:
            yield Problem(("obstacles", i, "name"), f"obstacle {seen[label]} is named {label!r} already")
    if workspace is not None and dimension not in (None, len(workspace.center)):
        yield Problem(("workspace", "center"), f"expected {dimension} numbers, got {len(workspace.center)}")
    if isinstance(field.exponents, tuple) and len(field.exponents) != len(obstacles):
        yield Problem(
            ("field", "exponents"), f"expected one number per obstacle ({len(obstacles)}), got {len(field.exponents)}"
        )


def _target(robot: Any, target: Any, name: str, dimension: int) -> Iterator[Problem]:
    allowed = tuple(k for k in kinds(robot) if name == "goal" or k not in (LineTarget, PlaneTarget))
    if not isinstance(target, allowed):
        what = _WRITTEN.get(type(target), type(target).__name__)
        choices = [_WRITTEN[k] for k in allowed]
        yield Problem((name,), f"{what} is no {name} for the robot {robot.name!r}", None, tuple(choices))
    elif isinstance(target, PositionTarget) and len(target.position) != dimension:
        yield Problem((name, "position"), f"expected {dimension} numbers, got {len(target.position)}")
    elif isinstance(target, JointTarget):
        yield from _joints(robot, target.q, name)
    elif isinstance(target, PostureTarget) and len(target.q) != robot.links + 2:
        yield Problem((name, "joints"), f"expected {robot.links - 1} angles, got {len(target.q) - 3}")


def _joints(robot: Any, q: np.ndarray, name: str) -> Iterator[Problem]:
    if len(q) != robot.n_joints:
        names = ", ".join(robot.joint_names)
        yield Problem((name, "joints"), f"{robot.name!r} has {robot.n_joints} joints ({names}), got {len(q)} numbers")
        return
    lower, upper = robot.limits.lower, robot.limits.upper
    outside = np.flatnonzero(_outside(q, robot))
    for j in outside:
        yield Problem(
            (name, "joints"),
            f"joint {robot.joint_names[j]!r} is {q[j]:.6g}, outside its limits [{lower[j]:.6g}, {upper[j]:.6g}]",
            AS_DEGREES if j == outside[-1] and looks_like_degrees(robot, q) else None,
        )


def looks_like_degrees(robot: Any, q: np.ndarray) -> bool:
    """Whether configurations (..., n) are outside the limits, with angles of more than a turn, but all inside them as degrees."""
    slides = [link.coordinate for link in robot.links if link.kind == "prismatic"]
    turned = np.radians(q)
    turned[..., slides] = q[..., slides]
    more_than_a_turn = np.abs(np.delete(q, slides, axis=-1)).max(initial=0.0) > 2.0 * np.pi
    return bool(more_than_a_turn and _outside(q, robot).any() and not _outside(turned, robot).any())


def _outside(q: np.ndarray, robot: Any) -> np.ndarray:
    return (q < robot.limits.lower - 1e-9) | (q > robot.limits.upper + 1e-9)
