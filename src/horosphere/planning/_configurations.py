"""Which configurations of an arm are at a start or a goal: joints as they are, everything else by inverse kinematics."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from ..scenes import JointTarget, Scene
from ._clearance import arm, margin
from ._goal_rounds import rounds
from ._postures import turned_near, within_limits
from ._refusals import Seen

Floats = NDArray[np.float64]

MOST = 64
"""Free postures that are kept of a goal that leaves the tool a place or an orientation."""
_FEW = 6  # rounds after which few free postures will do
_SHARE = 0.2  # of `options.time_limit` that the rounds after the first take at most
_COMFORT = 0.03  # metres above the clearance asked
_COMFORT_COST = 2.0  # radians that a goal without them counts as further away


@dataclass(frozen=True, slots=True)
class Configurations:
    """`q` (m, n) usable configurations, or none and the reason."""

    q: Floats
    reason: str = ""


def configurations(scene: Scene, which: str, near: Floats | None = None) -> Configurations:
    """Configurations at the scene's "start" or "goal": reached, within limits and clear.

    near: (n,) the posture at the start, for a goal: what is near it and has room comes first. Without it, the most clear come
    first. Where the target leaves the tool a place or an orientation, rounds of postures go on until enough of them are free.
    """
    robot, seen = arm(scene), Seen(scene, which)
    free, margins, deadline = np.zeros((0, robot.n_joints)), np.zeros(0), np.inf
    for number, found in enumerate(rounds(scene, which, near)):
        inside = within_limits(robot, found.q)
        q = np.ascontiguousarray(found.q[inside])
        spare = margin(scene, q) if len(q) else np.zeros(0)
        seen.add(found, inside, spare)
        free = np.concatenate([free, q[spare >= 0.0]])
        margins = np.concatenate([margins, spare[spare >= 0.0]])
        if len(free) >= found.enough or (len(free) and number >= _FEW):
            break
        if number == 0:  # compiling does not count
            deadline = perf_counter() + _SHARE * scene.options.time_limit
        elif perf_counter() > deadline:
            seen.is_late = True
            break
    if not len(free):
        return Configurations(free, seen.reason())
    if near is None or isinstance(getattr(scene, which), JointTarget):
        order = np.argsort(-margins)
        return Configurations(np.ascontiguousarray(free[order]))
    free = turned_near(robot, free, near)
    lack = np.maximum(0.0, 1.0 - margins / _COMFORT)
    order = np.argsort(np.linalg.norm(free - near, axis=1) + _COMFORT_COST * lack**2)
    if found.enough > 1 and len(order) > MOST:  # the first half, and every so many-th of the others
        half = MOST // 2
        order = np.concatenate([order[:half], order[half:][:: -(-(len(order) - half) // half)]])
    return Configurations(np.ascontiguousarray(free[order]))
