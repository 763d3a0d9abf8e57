"""Arms: the harmonic field with closed forms or the Jacobian first, the tree in joint space where that does not get there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import kinematics
from ..errors import unknown_name
from ..scenes import JointTarget, Scene
from ._branches import follow_branches, supports
from ._certified import certified, finely
from ._clearance import arm
from ._configurations import Configurations, configurations
from ._follow import follow_jacobian
from ._joint_space import REACTIVE, TREE, plan_in_joints
from ._plan import Plan, Progress
from ._timing import motion_limits
from ._tool_path import tool_path

Floats = NDArray[np.float64]

_RETRIES = 10  # field paths tried from one start, finer ones or further from what the links meet
_SHRINKS = 0.9  # of a jump: what is left of it on a path twice as fine, if it may mend
_WIDER = 0.01  # metres by which the tool keeps further than it just needs to
FIELD = "field"
_WAYS = {
    "auto": (FIELD, TREE),
    "field": (FIELD,),
    "tree": (TREE,),
    "reactive": (REACTIVE,),
    "reactive-or-tree": (REACTIVE, TREE),
}
_STARTS_TRIED = 6  # configurations at the start from which the Jacobian follows


def plan_arm(scene: Scene, progress: Progress) -> Plan:
    """See `plan`; for every `Robot`."""
    if scene.options.method not in _WAYS:
        raise unknown_name("method", scene.options.method, tuple(_WAYS), place="options.method")
    progress.notes.extend(arm(scene).notes)
    progress.notes.extend(motion_limits(arm(scene), scene.options)[2])
    with progress.part("start and goal"):
        starts = configurations(scene, "start")
        goals = configurations(scene, "goal", starts.q[0]) if not starts.reason else starts
    for ends in (starts, goals):
        if ends.reason:
            return Plan(scene, False, ends.reason)
    found, reasons = None, []
    for by in _WAYS[scene.options.method]:
        if by == FIELD:
            found = _along_field(scene, starts, goals, progress)
        else:
            found = plan_in_joints(scene, starts.q[0], goals.q, by, progress)
        if found.solved:
            for way, reason in reasons:
                progress.note(reason if reason.startswith(way) else f"{way}: {reason}")
            return finely(found, progress)
        reasons.append((by, found.reason))
    assert found is not None
    return Plan(
        scene, False, "; then ".join(reason for _, reason in reasons), path=found.path, certificate=found.certificate
    )


def _along_field(scene: Scene, starts: Configurations, goals: Configurations, progress: Progress) -> Plan:
    closed = supports(scene)
    by = "harmonic field, " + ("closed form" if closed else "Jacobian")
    first = None
    for q_start in starts.q[:1] if closed else starts.q[:_STARTS_TRIED]:
        found = _from_start(scene, q_start, goals.q[0], by, closed, progress)
        if found.solved:
            return found
        first = first or found
    assert first is not None
    return first


def _from_start(scene: Scene, q_start: Floats, q_goal: Floats, by: str, closed: bool, progress: Progress) -> Plan:
    """Follow the field from one start; where the links meet an obstacle on the way, keep the tool further from it."""
    start, goal = _tool(scene, "start", q_start), _tool(scene, "goal", q_goal)
    step, wider, first, jump = scene.options.path_step, {}, None, None
    for _ in range(_RETRIES):
        with progress.part("field path"):
            path = tool_path(scene, start, goal, step, wider)
        for note in path.notes:
            progress.note(note)
        if path.points is None:
            return first or Plan(scene, False, path.reason)
        with progress.part("joint motion"):
            if closed:
                motion = follow_branches(scene, path.points, whole=step == scene.options.path_step)
            else:
                motion = follow_jacobian(scene, q_start, path.points)
        if motion.waypoints is not None:
            plan = certified(scene, motion.waypoints, by, progress, path.points)
            if plan.solved and wider:
                progress.note(f"the tool keeps further from {', '.join(map(repr, wider))} for the sake of the links")
            return plan
        first = first or Plan(scene, False, motion.reason, path=path.points)
        if motion.jump is not None:
            if step <= scene.options.path_step / 8.5 or not _may_mend(motion.jump, jump):
                break
            step, jump = step / 2.0, motion.jump
        elif motion.touch is not None and motion.touch.is_obstacle:
            name = motion.touch.contact.other
            wider[name] = wider.get(name, 0.0) + motion.touch.short + _WIDER
        else:
            break
    assert first is not None
    return first


def _may_mend(jump: tuple[float, float], before: tuple[float, float] | None) -> bool:
    """Whether a path twice as fine helped: the jump lies further on, or became smaller. One to another branch stays as it is."""
    return before is None or jump[0] > before[0] or jump[1] < _SHRINKS * before[1]


def _tool(scene: Scene, which: str, q: Floats) -> Floats:
    target = getattr(scene, which)
    if isinstance(target, JointTarget) or not hasattr(target, "position"):
        return np.ascontiguousarray(kinematics.forward(arm(scene), q).as_matrix()[:3, 3])
    return target.position
