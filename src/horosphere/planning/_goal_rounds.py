"""Postures at a start or a goal in rounds: the likeliest first, then more, for as long as somebody asks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import kinematics
from ..entities import Point
from ..robots import Robot
from ..scenes import GripperPlaneTarget, JointTarget, LineTarget, PlaneTarget, PoseTarget, PositionTarget, Scene
from ._clearance import arm
from ._free_angles import (
    FINE_SAMPLES,
    FREE_SAMPLES,
    POINT_SAMPLES,
    free_grid,
    inverse_over,
    inverse_over_point,
    point_grid,
)
from ._places import places_of
from ._postures import drawn, has_formula, random_postures, searched

Floats = NDArray[np.float64]

ENOUGH = 16
"""Free postures after which a goal that leaves the tool free needs no more of them."""
_ROWS, _LARGEST = 64, 2048  # postures of the first round, each doubles them up to a bound
_ROUNDS = 20  # 33,000 postures in all
_LOST = 3  # rounds after which a goal of which nothing was reached is taken for out of reach
_SEEDS = 24  # of a numerical inverse at a pose
_POSE_ROUNDS = 2, 6  # of a numerical inverse at a pose, without and with a redundancy


@dataclass(frozen=True, slots=True)
class Round:
    """Postures `q` (m, n), the places (m, 3) of the tool, why there are none; how all so far were found, in words.

    `enough`: free postures, in all, that are so many that no further round is needed. `is_complete`: there are no others, but
    for the spacing of a grid.
    """

    q: Floats
    places: Floats
    reason: str
    how: str
    enough: int = 1
    is_complete: bool = False


def rounds(scene: Scene, which: str, near: Floats | None) -> Iterator[Round]:
    """Postures at the scene's "start" or "goal"; `near` (n,): where a search starts, if something is known."""
    robot, target = arm(scene), getattr(scene, which)
    rng = np.random.default_rng(scene.options.seed)
    if isinstance(target, JointTarget):
        yield _round(target.q[None].copy(), "", "")
    elif isinstance(target, (GripperPlaneTarget, PoseTarget)):
        if kinematics.classify(robot).is_closed_form:
            yield from _over_redundancy(robot, pose_of(target))
        else:
            yield from _from_seeds(robot, pose_of(target), near, rng)
    elif isinstance(target, (PositionTarget, LineTarget, PlaneTarget)):
        yield from _over_places(robot, target, near, rng)
    else:
        raise TypeError(f"an arm has no target of kind {type(target).__name__}")


def pose_of(target: Any) -> Any:
    """What inverse kinematics takes for a target of a scene; None where that is more than one pose or point, or joints."""
    if isinstance(target, GripperPlaneTarget):
        return kinematics.GripperOnPlane(target.position, target.normal)
    if isinstance(target, PoseTarget):
        return target.motor()
    return Point.from_euclidean(target.position) if isinstance(target, PositionTarget) else None


def _over_redundancy(robot: Robot, pose: Any) -> Iterator[Round]:
    """Every branch, over the whole redundancy: on a grid, then on a finer one."""
    parameter = kinematics.classify(robot).parameter
    for count in (FREE_SAMPLES, FINE_SAMPLES) if parameter else (1,):
        how = f"every branch, with {count} values of the free angle {parameter}"
        rows, reason = _valid_rows(inverse_over(robot, pose, free_grid(robot, count)[0]))
        yield _round(rows, reason, how if parameter else "every branch was looked at", is_complete=True)


def _from_seeds(robot: Robot, pose: Any, near: Floats | None, rng: np.random.Generator) -> Iterator[Round]:
    """A numerical inverse from the posture at the start, the middle of the limits, and at random."""
    how = "that a numerical search found; others may exist"
    seeds = [robot.limits.middle, *random_postures(robot, _SEEDS - 1, rng)]
    seeds = np.array(seeds if near is None else [near, *seeds])
    first = kinematics.numerical_inverse(robot, pose, seed=seeds[0])
    rows, reason = _valid_rows(first)
    if len(rows):
        rows = np.concatenate([rows, searched(robot, pose, seeds[1:])[0]])
    yield _round(rows, reason, how)
    for k in range(_POSE_ROUNDS[robot.n_joints > 6]) if len(rows) else ():
        yield _round(searched(robot, pose, random_postures(robot, _ROWS << k, rng))[0], "", how)


def _over_places(robot: Robot, target: Any, near: Floats | None, rng: np.random.Generator) -> Iterator[Round]:
    """Places of a point, a line or a plane, nearest to the start first, the orientation drawn at random."""
    tool = None if near is None else kinematics.forward(robot, near).as_matrix()[:3, 3]
    places = places_of(robot, target, tool)
    if places.is_beyond:
        yield _lost(robot, places.center, f"{places.noun} is ")
        return
    alone = isinstance(target, PositionTarget) and kinematics.classify(robot).position is not None
    how = "drawn over orientations" if isinstance(target, PositionTarget) else "drawn over places and orientations"
    how = f"{how}{'' if has_formula(robot) else ' for a numerical search'}; others may exist"
    if alone:
        grid = f"every branch, with {POINT_SAMPLES[0]} values of psi by {POINT_SAMPLES[1]} of q5"
        how = f"{grid}, and others {how}"
        first = _at_point(robot, target.position, grid)
        yield first
        if not len(first.q):  # the closed form knows the reach
            return
    shift, total, reached = rng.uniform(size=2), 0, 0

    def some(count: int) -> Floats:
        """Half of them the first places in turn, half over the goal, further and further from the start."""
        nonlocal total
        ahead = np.resize(places.first, ((count + 1) // 2, 3))
        spread = places.spread(total, count // 2, share, shift)
        total += count // 2
        return np.concatenate([ahead, spread])[rng.permutation(count)]

    for k in range(_ROUNDS):
        share = min(1.0, 0.25 * 2.0**k)
        q, at = drawn(robot, some, min(_ROWS << k, _LARGEST), rng)
        if k == 0 and not alone:
            points = Point.from_euclidean(places.first)
            seeds = np.tile(robot.limits.middle if near is None else near, (len(places.first), 1))
            own, of = searched(robot, points, seeds)
            q, at = np.concatenate([own, q]), np.concatenate([places.first[of], at])
        reached += len(q)
        if k >= _LOST and not reached and not alone:  # (alone: the limits forbid what is in reach)
            yield _lost(robot, places.first[-1], "")
            return
        yield Round(np.ascontiguousarray(q), at, "out of reach", how, ENOUGH)


def _at_point(robot: Robot, point: Floats, how: str) -> Round:
    """A position alone by its closed form: the roomiest posture of every branch, and a grid over its two freedoms."""
    q, reason = _valid_rows(inverse_over_point(robot, point, point_grid(robot)[0]))
    best = kinematics.inverse(robot, Point.from_euclidean(point))
    return _round(np.concatenate([best.q[best.valid], q]), reason, how, is_complete=True)


def _lost(robot: Robot, point: Floats, why: str) -> Round:
    """One long search at the place that is most likely in reach."""
    rows, reason = _valid_rows(kinematics.numerical_inverse(robot, Point.from_euclidean(point)))
    return Round(rows, np.tile(point, (len(rows), 1)), why + reason, "that a numerical search found; others may exist")


def _round(q: Floats, reason: str, how: str, is_complete: bool = False) -> Round:
    """Of one place."""
    return Round(q, np.zeros((len(q), 3)), reason, how, is_complete=is_complete)


def _valid_rows(solutions: kinematics.IkSolutions) -> tuple[Floats, str]:
    q = solutions.q.reshape(-1, solutions.q.shape[-1])[solutions.valid.reshape(-1)]
    if len(q):
        return q, ""
    reason: Any = solutions.reason
    if not isinstance(reason, str):  # one for each value of the free angle: that of the nearest
        texts = np.asarray(reason).reshape(-1)
        errors = solutions.residual.reshape(len(texts), -1).min(axis=-1)
        reason = f"{texts[np.argmin(errors)]} (the nearest of {len(texts)} values of the free angle)"
    return q, reason or "no configuration found"
