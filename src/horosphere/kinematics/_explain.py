"""Why a target has no posture inside the joint limits, in one sentence."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import InputError
from ._solutions import IkSolutions


def explain(found: IkSolutions, robot: Any, target: Any) -> str:
    """`IkSolutions.explain`."""
    if found.valid.ndim != 1:
        raise InputError(
            f"expected the solutions of one target, got a batch of shape {found.valid.shape[:-1]}", place="explain"
        )
    if found.within_limits(robot).any():
        return ""
    elsewhere = _at_another_redundancy(found, robot, target)
    if elsewhere:
        return elsewhere
    if found.valid.any():
        return f"{_outside_limits(found, robot)}; {nearest_pose(robot, target)}"
    return f"{found.reason}; {nearest_pose(robot, target)}"


def _at_another_redundancy(found: IkSolutions, robot: Any, target: Any) -> str:
    """Where a 7-joint arm is inside its limits at other values of its redundancy (`limit_arcs`): the widest interval, or ""."""
    from ..entities import Point
    from ._classify import classify
    from ._redundancy import limit_arcs

    structure = classify(robot)
    if structure.parameter not in ("psi", "q7", "q1") or isinstance(target, Point):
        return ""
    arcs = [arc.joined() for arc in limit_arcs(robot, target)]
    row = int(np.argmax([(arc[:, 1] - arc[:, 0]).max(initial=0.0) for arc in arcs]))
    if not len(arcs[row]):
        return ""
    low, high = np.degrees(arcs[row][np.argmax(arcs[row][:, 1] - arcs[row][:, 0])])
    return (
        f"inside the joint limits at other values of {structure.parameter} only: the widest interval is {low:.6g} to {high:.6g} deg, "
        f"{found.name(row)}"
    )


def _outside_limits(found: IkSolutions, robot: Any) -> str:
    lower, upper = robot.limits.lower, robot.limits.upper
    over = np.maximum(np.maximum(lower - found.q, found.q - upper), 0.0)
    row = int(np.argmin(np.where(found.valid, over.max(axis=-1), np.inf)))
    joint = int(np.argmax(over[row]))
    count = int(found.valid.sum())
    kind = next(link.kind for link in robot.links if link.coordinate == joint)
    angle = (lambda x: f"{_shown(np.degrees(x))} deg") if kind == "revolute" else (lambda x: f"{_shown(x)} m")
    return (
        f"{count} of {len(found.valid)} branches reach the target, none inside the joint limits: the nearest, {found.name(row)}, "
        f"needs {robot.joint_names[joint]} at {angle(found.q[row, joint])}, and its limits are {angle(lower[joint])} to "
        f"{angle(upper[joint])}"
    )


def nearest_pose(robot: Any, target: Any) -> str:
    """The nearest pose (or point, for a `Point`) inside the limits that a numerical search finds, in words; obstacles aside."""
    from ..entities import Point
    from ..versors import Motor
    from ._forward import forward
    from ._numeric import numerical_inverse
    from ._targets import GripperOnPlane, pose_motor
    from ._wrist_arms import matrix_error

    if isinstance(target, GripperOnPlane):
        goal: Any = Point.from_euclidean(target.point)
    elif isinstance(target, Point):
        goal = target
    else:
        goal = Motor._wrap(pose_motor(target))
    best = numerical_inverse(robot, goal, attempts=30).q[0]
    reached = forward(robot, best).as_matrix()
    x, y, z = reached[:3, 3]
    wanted = goal.as_euclidean() if isinstance(goal, Point) else goal.as_matrix()[:3, 3]
    away = float(np.linalg.norm(wanted - [x, y, z]))
    words = f"the nearest found inside the limits has the tip at ({_shown(x)}, {_shown(y)}, {_shown(z)}), {_shown(away, 3)} m away"
    if isinstance(goal, Motor):
        both = goal.as_matrix()
        both[:3, 3] = reached[:3, 3]
        words += f" and turned by {_shown(np.degrees(matrix_error(reached, both)), 3)} degrees"
    return words


def _shown(value: Any, digits: int = 4) -> str:
    """So many digits, none of them below a millionth: -1.7e-13 is 0."""
    return f"{round(float(value), 6) + 0.0:.{digits}g}"
