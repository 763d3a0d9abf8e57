"""`plan`: from a scene to a certified, timed motion, or to the reason why there is none."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import unknown_name
from ..scenes import Options, PointRobot, Scene, SnakeRobot, Trajectory, UnicycleRobot

if TYPE_CHECKING:
    from ..certify import Certificate
    from ._anytime import Improvement

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """What planning found.

    `solved`: the trajectory reaches the goal and its certificate holds; `reason` says "solved", or why not. `solved_by`
    names the method. `path` (k, d): the points that the tool (or the ball) follows, metres. `timings`: seconds by part.
    `notes`: what the planner did that its user should know. `improvement`: what the time after the first certified plan
    brought, None where it was not used.
    """

    scene: Scene
    solved: bool
    reason: str
    solved_by: str | None = None
    trajectory: Trajectory | None = None
    certificate: Certificate | None = None
    path: Floats | None = None
    timings: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    improvement: Improvement | None = None

    def __repr__(self) -> str:
        return f"Plan({self.scene.name!r}, {'solved by ' + str(self.solved_by) if self.solved else self.reason})"


class Progress:
    """Times of the parts of one planning run, and its notes."""

    def __init__(self) -> None:
        self.timings: dict[str, float] = {}
        self.notes: list[str] = []

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        started = time.perf_counter()
        try:
            yield
        finally:
            self.timings[name] = self.timings.get(name, 0.0) + time.perf_counter() - started

    def note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)


def plan(scene: Scene | str | Path, **options: Any) -> Plan:
    """Move the robot of `scene` (or of a scene file, or a built-in scene) from its start to its goal, touching nothing.

    `options` override fields of `scene.options` (clearance, path_step, method, seed, ...). A motion is returned only with
    a certificate that covers it at every instant; a problem that is not solved is a Plan with `solved` False and a reason.
    Raises InputError for an option that does not exist.
    """
    if not isinstance(scene, Scene):
        scene = Scene.load(scene)
    if options:
        names = [item.name for item in dataclasses.fields(Options)]
        for name in options:
            if name not in names:
                raise unknown_name("option", name, names)
        scene = scene.with_(options=dataclasses.replace(scene.options, **options))
    progress = Progress()
    started = time.perf_counter()
    with progress.part("loading"):
        if isinstance(scene.robot, PointRobot):
            from ._point import plan_point as solve
        elif isinstance(scene.robot, UnicycleRobot):
            from ._unicycle import plan_unicycle as solve
        elif isinstance(scene.robot, SnakeRobot):
            from ._snake import plan_snake as solve
        else:
            from ._arm import plan_arm as solve
    result = solve(scene, progress)
    progress.timings["total"] = time.perf_counter() - started
    return dataclasses.replace(result, timings=progress.timings, notes=tuple(progress.notes))
