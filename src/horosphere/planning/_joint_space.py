"""Plans found in joint space, by trees or by the reactive law, and made better while there is time."""

from __future__ import annotations

import dataclasses
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import kinematics
from ..certify import certify
from ..errors import InputError
from ..numeric import at_most
from ..scenes import Scene, Trajectory
from ..shapes import Mesh, box_cover
from ._certified import certified
from ._clearance import arm
from ._plan import Plan, Progress
from ._tree import TreeResult

if TYPE_CHECKING:
    from ._anytime import Improver

Floats = NDArray[np.float64]
TREE, REACTIVE = "joint-space tree", "reactive law"


def plan_in_joints(scene: Scene, start: Floats, goals: Floats, by: str, progress: Progress) -> Plan:
    """From `start` (n,) to one of `goals` (k, n) `by` TREE or REACTIVE; then better for `options.improvement_time`."""
    options = scene.options
    keep, keep_own, limit = options.clearance, options.self_clearance, options.time_limit
    try:
        with progress.part(by):
            if by == TREE:
                from ._tree import connect

                found = connect(
                    arm(scene), start, goals, scene.obstacles, clearance=keep, self_clearance=keep_own, seed=options.seed,
                    time_limit=limit,
                )  # fmt: skip
            else:
                from ._reactive import react

                found = react(
                    arm(scene), start, goals, scene.obstacles, clearance=keep, self_clearance=keep_own, time_limit=limit
                )
    except InputError as error:  # an obstacle that they do not take
        return Plan(scene, False, f"{by}: {error}")
    for number, shape in enumerate(scene.obstacles):
        if isinstance(shape, Mesh):
            cover = box_cover(shape)  # kept since it was made for the search
            progress.note(
                f"{by}: {shape.name or f'obstacle {number}'} was enclosed in {len(cover.boxes)} boxes, slack at most "
                f"{at_most(cover.slack, decimals=4)} m; the certificate looks at its triangles"
            )
    if not found.solved:
        return Plan(scene, False, f"{by}: {found.reason}")
    first = certified(scene, found.waypoints, by, progress, _tool_points(scene, found.waypoints))
    if not first.solved or options.improvement_time <= 0.0:
        return first
    return improved(scene, first, found, goals, progress)


def improved(scene: Scene, first: Plan, found: TreeResult, goals: Floats, progress: Progress) -> Plan:
    """The best plan that the time brings: never longer in joint space or in time, nor certified at less, than the first."""
    from ._anytime import Improvement, Improver

    options, robot = scene.options, arm(scene)
    assert first.certificate is not None
    with progress.part("improvement"):
        improver = Improver(
            robot, found, goals, scene.obstacles, clearance=options.clearance, self_clearance=options.self_clearance,
            seed=options.seed, seconds=options.improvement_time, kept=first.certificate.clearance,
        )  # fmt: skip
        begin, best, least = perf_counter(), first, 1.0
        for waypoints in improver.candidates():
            other = _again(scene, waypoints, first)
            if other is not None:
                value = _value(other, improver) / _value(first, improver)
                if value < least:
                    best, least = dataclasses.replace(other, path=_tool_points(scene, waypoints)), value
        seconds = perf_counter() - begin
    before, after = _facts(first, improver), _facts(best, improver)
    improvement = Improvement(
        before[0], after[0], before[1], after[1], before[2], after[2], before[3], after[3],
        improver.rounds, seconds, not improver.is_over,
    )  # fmt: skip
    progress.note(str(improvement))
    return dataclasses.replace(best, improvement=improvement)


def _again(scene: Scene, waypoints: Floats, first: Plan) -> Plan | None:
    """The timed and certified motion through better waypoints, if in no respect worse than the first plan."""
    plan = certified(scene, waypoints, first.solved_by or "", Progress(), None)
    motion, proof, old_motion, old = plan.trajectory, plan.certificate, first.trajectory, first.certificate
    if not plan.solved or motion is None or proof is None or old_motion is None or old is None:
        return None
    if motion.duration > old_motion.duration or _length(scene, motion) > _length(scene, old_motion):
        return None
    if proof.clearance < old.clearance or proof.self_clearance < old.self_clearance:
        if proof.clearance_seen < old.clearance or proof.self_clearance_seen < old.self_clearance:
            return None
        proof = certify(scene, motion)  # the bounds have play: where they decide, a finer certificate does
        if not proof.certified or proof.clearance < old.clearance or proof.self_clearance < old.self_clearance:
            return None
    return dataclasses.replace(plan, certificate=proof)


def _value(plan: Plan, improver: Improver) -> float:
    """What a plan costs: its way, dearer near obstacles, and its time in equal measure."""
    assert plan.trajectory is not None
    return improver.cost(improver.scaled(plan.trajectory.positions)) * plan.trajectory.duration


def _length(scene: Scene, motion: Trajectory) -> float:
    from ._anytime import path_length

    return path_length(arm(scene), motion.positions)


def _facts(plan: Plan, improver: Improver) -> tuple[float, float, float, float]:
    """Length, certified clearance, mean clearance, duration."""
    assert plan.trajectory is not None and plan.certificate is not None
    motion = plan.trajectory
    return (
        _length(plan.scene, motion),
        plan.certificate.clearance,
        improver.mean_room(motion.positions),
        motion.duration,
    )


def _tool_points(scene: Scene, waypoints: Floats) -> Floats:
    return kinematics.forward(arm(scene), waypoints).as_matrix()[:, :3, 3]
