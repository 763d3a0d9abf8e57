"""Arms: the harmonic field with closed forms or the Jacobian first, the tree in joint space where that does not get there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import kinematics
from ..certify import certify
from ..errors import InputError
from ..scenes import JointTarget, Scene
from ._branches import follow_branches, supports
from ._clearance import arm
from ._configurations import Configurations, configurations
from ._follow import follow_jacobian
from ._plan import Plan, Progress
from ._timing import motion_limits, timed
from ._tool_path import tool_path

Floats = NDArray[np.float64]

_REFINEMENTS = 3  # times the waypoints are doubled for the sake of the certificate
_RETRIES = 10  # field paths tried from one start, finer ones or further from what the links meet
_WIDER = 0.01  # metres by which the tool keeps further than it just needs to
_STARTS_TRIED = 6  # configurations at the start from which the Jacobian follows


def plan_arm(scene: Scene, progress: Progress) -> Plan:
    """See `plan`; for every `Robot`."""
    progress.notes.extend(arm(scene).notes)
    progress.notes.extend(motion_limits(arm(scene), scene.options)[2])
    with progress.part("start and goal"):
        starts = configurations(scene, "start")
        goals = configurations(scene, "goal") if not starts.reason else starts
    for ends in (starts, goals):
        if ends.reason:
            return Plan(scene, False, ends.reason)
    reasons = []
    if scene.options.method != "tree":
        found = _along_field(scene, starts, goals, progress)
        if found.solved:
            return found
        reasons.append(found.reason)
    if scene.options.method != "field":
        found = _by_tree(scene, starts, goals, progress)
        if found.solved:
            for reason in reasons:
                progress.note(f"field: {reason}")
            return found
        reasons.append(found.reason)
    return Plan(scene, False, "; then ".join(reasons), path=found.path, certificate=found.certificate)


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
    step, wider, first = scene.options.path_step, {}, None
    for _ in range(_RETRIES):
        with progress.part("field path"):
            path = tool_path(scene, start, goal, step, wider)
        for note in path.notes:
            progress.note(note)
        if path.points is None:
            return first or Plan(scene, False, path.reason)
        with progress.part("joint motion"):
            motion = follow_branches(scene, path.points) if closed else follow_jacobian(scene, q_start, path.points)
        if motion.waypoints is not None:
            plan = certified(scene, motion.waypoints, by, progress, path.points)
            if plan.solved and wider:
                progress.note(f"the tool keeps further from {', '.join(map(repr, wider))} for the sake of the links")
            return plan
        first = first or Plan(scene, False, motion.reason, path=path.points)
        if motion.breaks and step > scene.options.path_step / 8.5:
            step /= 2.0
        elif motion.touch is not None and motion.touch.is_obstacle:
            name = motion.touch.contact.other
            wider[name] = wider.get(name, 0.0) + motion.touch.short + _WIDER
        else:
            break
    assert first is not None
    return first


def _by_tree(scene: Scene, starts: Configurations, goals: Configurations, progress: Progress) -> Plan:
    from ._tree import connect

    options = scene.options
    try:
        with progress.part("tree"):
            result = connect(
                arm(scene),
                starts.q[0],
                goals.q,
                scene.obstacles,
                clearance=options.clearance,
                self_clearance=options.self_clearance,
                seed=options.seed,
                time_limit=options.time_limit,
            )
    except InputError as error:  # an obstacle that the tree does not take
        return Plan(scene, False, f"joint-space tree: {error}")
    if not result.solved:
        return Plan(scene, False, f"joint-space tree: {result.reason}")
    points = kinematics.forward(arm(scene), result.waypoints).as_matrix()[:, :3, 3]
    return certified(scene, result.waypoints, "joint-space tree", progress, points)


def certified(scene: Scene, waypoints: Floats, by: str, progress: Progress, points: Floats | None) -> Plan:
    """Time the motion through `waypoints` and certify it; solved only if the certificate of the timed motion holds.

    The spline through the waypoints leaves their straight connections a little; where that costs the certificate, points
    are put between the waypoints, which draws it closer.
    """
    reason, certificate = "", None
    for _ in range(_REFINEMENTS + 1):
        with progress.part("timing"):
            trajectory = timed(arm(scene), waypoints, scene.options)
        with progress.part("certificate"):
            certificate = certify(scene, trajectory)
        if certificate.certified:
            return Plan(scene, True, "solved", by, trajectory, certificate, points)
        reason = f"the motion has no certificate: {certificate.first_violation or certificate.unresolved}"
        waypoints = np.insert(waypoints, np.arange(1, len(waypoints)), 0.5 * (waypoints[1:] + waypoints[:-1]), axis=0)
    return Plan(scene, False, reason, by, certificate=certificate, path=points)


def _tool(scene: Scene, which: str, q: Floats) -> Floats:
    target = getattr(scene, which)
    if isinstance(target, JointTarget) or not hasattr(target, "position"):
        return np.ascontiguousarray(kinematics.forward(arm(scene), q).as_matrix()[:3, 3])
    return target.position
