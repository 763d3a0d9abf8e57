"""Why none of the postures at a start or a goal will do: what was looked at, what is in the way of how many, what helps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import kinematics
from ..distance import pack_obstacles, signed
from ..entities import Point
from ..robots import Robot
from ..scenes import JointTarget, LineTarget, PlaneTarget, Scene
from ._clearance import arm, touch
from ._goal_rounds import Round, pose_of

Floats = NDArray[np.float64]

_COUNTED = 512  # postures of which it is told what is in their way


class Seen:
    """The account of the postures that were looked at."""

    def __init__(self, scene: Scene, which: str) -> None:
        self.scene, self.which = scene, which
        self.is_late = False
        self._clear()

    def _clear(self) -> None:
        self.outside: list[Floats] = []
        self.blocked: list[Floats] = []
        self.places: list[Floats] = []
        self.best: tuple[float, Floats] | None = None

    def add(self, found: Round, inside: NDArray[np.bool_], spare: Floats) -> None:
        """One round: which of its postures are inside the limits, and the margins (m) of those."""
        if found.is_complete:  # a finer grid than that before
            self._clear()
        self.last = found
        self.outside.append(found.q[~inside])
        q = found.q[inside]
        self.blocked.append(q[spare < 0.0])
        self.places.append(found.places[inside])
        if len(q):
            k = int(np.argmax(spare))
            if self.best is None or spare[k] > self.best[0]:
                self.best = float(spare[k]), q[k]

    def reason(self) -> str:
        """In one sentence, where none is free."""
        robot, scene, outside = arm(self.scene), self.scene, np.concatenate(self.outside)
        if self.best is not None:
            near = touch(scene, self.best[1][None])
            what = "in collision" if near.contact.distance < 0.0 else "too close"
            blocked = np.concatenate(self.blocked)
            return (
                f"{self.which} {what}: {near}{self._scope(len(blocked), ' within the limits')}{self._remedy(blocked)}"
            )
        if len(outside):
            why = f"{limit_reason(robot, outside)}{self._scope(len(outside), '')}"
        else:
            why = self.last.reason
        return f"{self.which}: {_explained(scene, self.which, why)}"

    def _scope(self, count: int, kept: str) -> str:
        """Of which postures a refusal speaks: of the one that is given, of all there are, or of those that were looked at."""
        target, how = getattr(self.scene, self.which), self.last.how
        if isinstance(target, JointTarget):
            return ""
        at, comma = "", "" if how.startswith("that") else ":"
        if isinstance(target, (LineTarget, PlaneTarget)):
            places = len(np.unique(np.concatenate(self.places), axis=0))
            at = (
                f" at {places} place{'s'[: places != 1]} of the {'line' if isinstance(target, LineTarget) else 'plane'}"
            )
        postures = f"the only posture{kept}{at}" if count == 1 else f"the best of {count} postures{kept}{at}"
        return f", in {postures}{comma} {how}"

    def _remedy(self, blocked: Floats) -> str:
        target, names = getattr(self.scene, self.which), self._in_the_way(blocked[:_COUNTED])
        if isinstance(target, JointTarget):
            return ""
        counts = ", ".join(f"{name} in the way of {count}" for name, count in names[:4])
        few = f"of {_COUNTED} of them: " if len(blocked) > _COUNTED else ""
        moves = [name for name, _ in names if name.startswith("'")][:1]
        text = f"; {few}{counts}; move the {' or '.join([self.which, *moves])}"
        if self.last.is_complete:
            return text
        if self.is_late:
            return f"{text}; the time for this search was over (a fifth of options.time_limit)"
        return f"{text}, or let another options.seed look at other postures"

    def _in_the_way(self, q: Floats) -> list[tuple[str, int]]:
        """What each posture of q (m, n) is deepest in, or nearest to, beyond what is asked for: names with counts, most first."""
        scene, robot, options = self.scene, arm(self.scene), self.scene.options
        own = signed(robot, q, (), self_collision=True) - options.self_clearance
        gaps = [signed(robot, q, (shape,), static=False) - options.clearance for shape in scene.obstacles]
        names = [*(f"{name!r}" for name in pack_obstacles(scene.obstacles).names), "the robot itself"]
        worst = np.argmin(np.stack([*gaps, own]), axis=0)
        counts = np.bincount(worst, minlength=len(names))
        return [(names[k], int(counts[k])) for k in np.argsort(-counts, kind="stable") if counts[k]]


def _explained(scene: Scene, which: str, reason: str) -> str:
    """Why a target is not reached inside the limits: how far out of reach or which joint, and what is nearest to it."""
    from ..kinematics._explain import nearest_pose

    robot, target = arm(scene), pose_of(getattr(scene, which))
    if target is None:
        return reason
    structure = kinematics.classify(robot)
    alone = structure.position is not None and isinstance(target, Point)
    if alone or (structure.is_closed_form and structure.parameter is None and not isinstance(target, Point)):
        return kinematics.inverse(robot, target).explain(robot, target) or reason
    return f"{reason}; {nearest_pose(robot, target)}"


def limit_reason(robot: Robot, q: Floats) -> str:
    """Which joint leaves its limits, and by how much, in the configuration (of m) that is nearest to keeping them."""
    excess = np.maximum(robot.limits.lower - q, q - robot.limits.upper)
    best = excess[np.argmin(excess.max(axis=-1))]
    j = int(np.argmax(best))
    slides = any(link.coordinate == j and link.kind == "prismatic" for link in robot.links)
    beyond = f"{1e3 * best[j]:.3g} mm" if slides else f"{np.degrees(best[j]):.3g} degrees"
    return f"joint {robot.joint_names[j]!r} would be {beyond} beyond its limits in the nearest posture"
