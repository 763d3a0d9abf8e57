"""The live view: a scene in the browser whose goal and balls can be dragged; the motion follows."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import InputError
from ..scenes import Scene, Trajectory
from ._recording import draw, moments, new_server, pose, rest, silent

PERIOD = 0.04


class LiveView:
    """A viser server with one scene. `planner(scene)` returns a Plan; it is asked again whenever something was dragged."""

    def __init__(
        self,
        scene: Scene,
        planner: Callable[[Scene], Any],
        trajectory: Trajectory | None = None,
        port: int | None = None,
    ) -> None:
        self._scene, self._planner = scene, planner
        self._changed = threading.Event()
        self._lock = threading.Lock()
        self._wanted = scene
        self._server = new_server(port)
        gui = self._server.gui
        self._verdict = gui.add_markdown("")
        self._playing = gui.add_checkbox("play", True)
        self._slider = gui.add_slider("time", 0.0, 1.0, 0.001, 0.0)
        self._gizmos: list[Any] = []
        if trajectory is None:
            self._changed.set()
            self._show(None, "planning ...")
        else:
            self._show(trajectory, "")

    @property
    def address(self) -> str:
        """Where the browser finds it; only this machine does."""
        return f"http://127.0.0.1:{self._server.get_port()}"

    @property
    def scene(self) -> Scene:
        """The scene as it was last planned."""
        return self._scene

    def run(self, seconds: float | None = None) -> None:
        """Plays, and plans what was dragged, until interrupted (or for some seconds)."""
        stop = None if seconds is None else time.monotonic() + seconds
        while stop is None or time.monotonic() < stop:
            if self._changed.is_set():
                self._changed.clear()
                with self._lock:
                    scene = self._wanted
                self.replan(scene)
            self._advance()
            time.sleep(PERIOD)

    def close(self) -> None:
        """Stops the server."""
        with silent():
            self._server.stop()

    def replan(self, scene: Scene) -> None:
        """Plans `scene` and shows the motion, or the reason why there is none."""
        self._verdict.content = "planning ..."
        try:
            plan = self._planner(scene)
        except InputError as error:
            self._verdict.content = f"**refused**: {error}"
            return
        self._scene = scene
        self._show(
            plan.trajectory,
            f"**{'solved' if plan.solved else 'not solved'}**: {plan.solved_by or plan.reason}",
            plan.path,
        )

    def move(self, name: str, position: Any) -> None:
        """Puts the goal (`goal`) or an obstacle (its index as text) somewhere else, as dragging does."""
        with self._lock:
            scene = self._wanted
            if name == "goal":
                goal: Any = scene.goal
                moved = dataclasses.replace(goal, position=np.asarray(position)[: len(goal.position)])
                scene = scene.with_(goal=moved)
            else:
                k = int(name)
                ball: Any = scene.obstacles[k]
                moved = dataclasses.replace(ball, center=np.asarray(position)[: len(ball.center)])
                scene = scene.with_(obstacles=(*scene.obstacles[:k], moved, *scene.obstacles[k + 1 :]))
            self._wanted = scene
        self._changed.set()

    def _show(self, trajectory: Trajectory | None, verdict: str, path: Any = None) -> None:
        time_, q = moments(trajectory) if trajectory is not None else (np.zeros(1), rest(self._scene))
        with self._server.atomic():
            self._server.scene.reset()
            self._moving = draw(self._server, self._scene, q, path)
            self._add_gizmos()
        self._time, self._now = time_, 0.0
        self._slider.max = max(float(time_[-1]), 1e-3)
        self._verdict.content = verdict

    def _add_gizmos(self) -> None:
        self._gizmos = []
        targets = {"goal": getattr(self._scene.goal, "position", None)}
        for k, obstacle in enumerate(self._scene.obstacles):
            if type(obstacle).__name__ == "Ball":
                targets[str(k)] = obstacle.center
        for name, position in targets.items():
            if position is None or len(position) > 3:
                continue
            place = np.concatenate([position, np.zeros(3 - len(position))])
            flat = len(position) == 2
            gizmo = self._server.scene.add_transform_controls(
                f"/drag/{name}",
                scale=0.15,
                position=tuple(place),
                disable_rotations=True,
                active_axes=(True, True, not flat),
            )
            gizmo.on_update(lambda event, name=name, gizmo=gizmo: self._dragged(event, name, gizmo))
            self._gizmos.append(gizmo)

    def _dragged(self, event: Any, name: str, gizmo: Any) -> None:
        if event.phase == "end":
            self.move(name, gizmo.position)

    def _advance(self) -> None:
        end = float(self._time[-1])
        if self._playing.value:
            self._now = 0.0 if self._now > end + 0.8 else self._now + PERIOD
            self._slider.value = min(self._now, end)
        else:
            self._now = float(self._slider.value)
        pose(self._server, self._moving, int(np.searchsorted(self._time, min(self._now, end))))
