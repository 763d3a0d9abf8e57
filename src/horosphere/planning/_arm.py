"""Arms: the harmonic field with closed forms or the Jacobian first, the tree in joint space where that does not get there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import kinematics
from ..certify import certify
from ..scenes import JointTarget, Scene
from ._branches import ArmPath, follow_branches, supports
from ._clearance import arm
from ._configurations import Configurations, configurations
from ._follow import follow_jacobian
from ._plan import Plan, Progress
from ._timing import motion_limits, timed
from ._tool_path import tool_path

Floats = NDArray[np.float64]

_REFINEMENTS = 3  # times the path step is halved when joint steps come out too large
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
    q_starts = starts.q[:1] if closed else starts.q[:_STARTS_TRIED]
    reason, points = "", None
    for q_start in q_starts:
        for step in scene.options.path_step / 2.0 ** np.arange(_REFINEMENTS + 1):
            with progress.part("field path"):
                path = tool_path(scene, _tool(scene, "start", q_start), _tool(scene, "goal", goals.q[0]), float(step))
            for note in path.notes:
                progress.note(note)
            if path.points is None:
                return Plan(scene, False, path.reason)
            points = path.points
            with progress.part("joint motion"):
                motion = follow_branches(scene, points) if closed else follow_jacobian(scene, q_start, points)
            if motion.waypoints is not None or not motion.breaks:
                break
        if motion.waypoints is not None:
            plan = certified(scene, motion.waypoints, by, progress, points)
            if plan.solved:
                return plan
            motion = ArmPath(None, plan.reason)
        reason = reason or motion.reason
    return Plan(scene, False, reason, path=points)


def _by_tree(scene: Scene, starts: Configurations, goals: Configurations, progress: Progress) -> Plan:
    from ._tree import connect

    options = scene.options
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
