"""Frames in which the parts of a MoveIt problem are stated."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, unknown_name
from ._moveit_node import Floats, Node, inverse, pose_of

if TYPE_CHECKING:
    from ..robots import Robot

_WORLD = ("", "world")


class Frames:
    """Poses of named frames in the world: the world, fixed transforms of the scene; any other name is the robot's base.

    Whether it is, is known with the robot: `of_base` holds those names, each with the place where it stands first.
    """

    def __init__(self, base: Floats | None, scene: Node) -> None:
        self.base = np.eye(4) if base is None else base
        self.of_base: dict[str, str] = {}
        self._fixed = {name: np.eye(4) for name in _WORLD}
        for item in scene.items("fixed_frame_transforms"):
            name, pose = str(item.plain("child_frame_id") or ""), pose_of(item.get("transform"))
            if name not in self._fixed:
                self._fixed[name] = self.pose(item) @ pose

    def pose(self, stated: Node) -> Floats:
        """Of the frame (4, 4) that the header of a message names, in the world."""
        header = stated.get("header")
        name = "" if header is None else str(header.plain("frame_id") or "")
        if header is None or name in self._fixed:
            return self._fixed[name]
        self.of_base.setdefault(name, header.place)
        return self.base


def base_pose(state: Node | None) -> Floats | None:
    """Where the robot stands in the world: the first transform of its virtual joint; None if nothing is said."""
    joints = None if state is None else state.get("multi_dof_joint_state")
    transforms = [] if joints is None else joints.items("transforms")
    return pose_of(transforms[0]) if transforms else None


def check_frames(frames: Iterable[tuple[str, str]], robot: Robot) -> None:
    """Raises InputError for a frame that was taken for the robot's base and is not at it."""
    still = _relative(robot, 0)
    for name, place in frames:
        if name not in robot.link_names:
            raise unknown_name("frame", name, (*robot.link_names, "world"), place=place)
        pose = still.get(robot.link_names.index(name))
        if pose is None or np.abs(pose - np.eye(4)).max() > 1e-9:
            raise InputError(
                f"{name!r} is not at the robot's base {robot.link_names[0]!r}",
                place=place,
                remedy="state it in the world",
            )


def tool_on(robot: Robot, link: str, place: str) -> Floats:
    """The tool's frame (4, 4) in that of a link that is one rigid part with the tip; InputError at `place` otherwise."""
    if link not in robot.link_names:
        raise unknown_name("link", link, robot.link_names, place=place)
    tip = robot.link_names[robot.tip]
    pose = _relative(robot, robot.link_names.index(link)).get(robot.tip)
    if pose is None:
        raise InputError(
            f"the goal is a pose of {link!r}, which moves against the tip {tip!r}",
            place=place,
            remedy="give it as the tip (`tip`)",
        )
    return pose @ _matrix(robot.tool)


def _relative(robot: Robot, link: int) -> dict[int, Floats]:
    """Poses (4, 4) in the frame of `link` of all links that are one rigid part with it."""
    from ..robots._pairs import rigid_groups
    from ..robots._placement import link_frames

    group = rigid_groups(robot.links)
    frames = link_frames(robot.links, np.zeros(robot.n_joints))
    back = inverse(_matrix(frames[link]))
    return {int(k): back @ _matrix(frames[k]) for k in np.flatnonzero(group == group[link])}


def _matrix(motor: Any) -> Floats:
    from ..robots._placement import rotation_translation

    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation_translation(motor)
    return matrix
