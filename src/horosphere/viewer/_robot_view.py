"""A robot without a scene: its collision model as a page to keep, and live with a slider for each joint."""

from __future__ import annotations

import html
import math
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..robots import Robot
from ..robots._robot import require_robot
from ..scenes import JointTarget, Scene
from ._parts import link_poses
from ._recording import draw, new_server, pose, record, silent
from ._report import document, scene_frame

Floats = NDArray[np.float64]

PERIOD = 0.04


def joint_ranges(robot: Robot) -> tuple[Floats, Floats]:
    """The limits (n,) as they are shown: half a turn (3.14 m) where there is none or one beyond two turns."""
    lower, upper = require_robot(robot).limits.lower, robot.limits.upper
    most = 4.0 * math.pi
    return np.where(lower >= -most, lower, -math.pi), np.where(upper <= most, upper, math.pi)


def rest_posture(robot: Robot) -> Floats:
    """The posture (n,) nearest to the middle of the limits, of 200, in which its checked links touch least."""
    from ..distance import signed

    low, high = joint_ranges(robot)
    share = np.random.default_rng(0).uniform(0.0, 1.0, (200, robot.n_joints))
    share[0] = 0.5
    tries = low + (0.5 + (share - 0.5) * np.linspace(0.0, 1.0, 200)[:, None]) * (high - low)
    tries = np.concatenate([np.clip(np.zeros((1, robot.n_joints)), low, high), tries])
    gaps = signed(robot, tries, (), self_collision=True)
    return tries[int(np.argmax(gaps > 0.0)) if (gaps > 0.0).any() else int(np.argmax(gaps))]


def _alone(robot: Robot) -> Scene:
    q = rest_posture(robot)
    return Scene(robot, JointTarget(q), JointTarget(q), name=robot.name)


def robot_html(robot: Robot) -> str:
    """The collision model in a free posture as one offline HTML page. Raises InputError without the extra `view`."""
    links = {robot.links[k].name for k in require_robot(robot).capsules.link}
    caption = (
        f"{robot.n_joints} joints; {len(robot.capsules)} collision bodies on {len(links)} links, one colour a link, in a "
        "posture in which they touch least; a ball marks the tool. Drag to turn, scroll to zoom."
    )
    title = html.escape(robot.name)
    return document(title, f'{scene_frame(record(_alone(robot), None))}<p class="legend">{caption}</p>')


class RobotView:
    """A viser server with the collision model of a robot, and a slider for each joint (degrees or metres)."""

    def __init__(self, robot: Robot, port: int | None = None) -> None:
        self._robot, scene = robot, _alone(robot)
        self._server = new_server(port)
        self._q = np.array(scene.start.q)  # type: ignore[union-attr]
        self._moving = draw(self._server, scene, self._q[None], None)
        self._used = [k for k in range(len(robot.links)) if (robot.capsules.link == k).any()] or [robot.tip]
        sliding = {link.coordinate for link in robot.links if link.kind == "prismatic"}
        self._text = self._server.gui.add_markdown("")
        self._sliders: list[tuple[Any, float]] = []
        lowest, highest = joint_ranges(robot)
        for j, name in enumerate(robot.joint_names):
            unit = 1.0 if j in sliding else 180.0 / math.pi
            low, high = lowest[j] * unit, highest[j] * unit
            step = max((high - low) / 500.0, 1e-6)
            slider = self._server.gui.add_slider(name, float(low), float(high), float(step), float(self._q[j] * unit))
            self._sliders.append((slider, unit))
        self.update()

    @property
    def address(self) -> str:
        """Where the browser finds it; only this machine does."""
        return f"http://127.0.0.1:{self._server.get_port()}"

    def update(self) -> None:
        """Moves the bodies to what the sliders say, and says which checked links touch."""
        from ..distance import table

        self._q = np.array([slider.value / unit for slider, unit in self._sliders])
        poses = link_poses(self._robot, self._q[None])
        moved = [(handle, poses[:, k]) for (handle, _), k in zip(self._moving, self._used)]
        pose(self._server, moved, 0)
        near = table(self._robot, self._q, ()).nearest()
        self._text.content = f"nearest checked links: {near}" if near else "no links are checked against each other"

    def run(self, seconds: float | None = None) -> None:
        """Follows the sliders until interrupted (or for some seconds)."""
        stop = None if seconds is None else time.monotonic() + seconds
        while stop is None or time.monotonic() < stop:
            values = np.array([slider.value / unit for slider, unit in self._sliders])
            if not np.array_equal(values, self._q):
                self.update()
            time.sleep(PERIOD)

    def close(self) -> None:
        """Stops the server."""
        with silent():
            self._server.stop()
