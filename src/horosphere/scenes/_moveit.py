"""What a MoveIt planning scene and its motion-plan request (YAML of the ROS messages) mean for a robot."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..robots._robot import require_robot
from ._moveit_contacts import Contacts, HeldObject, allow, hold, read_contacts, read_held
from ._moveit_frames import Frames, base_pose, check_frames, tool_on
from ._moveit_node import Node, inverse, pose_of
from ._moveit_objects import objects_of
from ._options import Options
from ._targets import JointTarget, PoseTarget, PositionTarget, Target, matrix_quaternion, quaternion_matrix
from ._yaml import Document

if TYPE_CHECKING:
    from ..robots import Robot
    from ..shapes import Shape
    from ._scene import Scene

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MoveItProblem:
    """Obstacles in the robot's base frame, a start, and goals any of which will do.

    `start`: joint values by name; each of `goals` likewise, or pose or place of link `goal_links[k]`. `notes`: what was enclosed
    or left out. `object_ids`: which collision object each obstacle is of. `held`: objects attached to links; `contacts`: the
    allowed collision matrix; `robot_of` gives a robot both. `base` (4, 4): the robot's base in the world; `frames`: which names
    of frames were taken for it, and where they stand. `request`: the file of the goals; `scales`: of velocities and accelerations.
    """

    name: str
    obstacles: tuple[Shape, ...]
    start: dict[str, float]
    goals: tuple[dict[str, float] | PoseTarget | PositionTarget, ...]
    goal_links: tuple[str, ...] = ()
    robot_name: str = ""
    group: str = ""
    source: str = ""
    notes: tuple[str, ...] = field(default=())
    object_ids: tuple[str, ...] = ()
    held: tuple[HeldObject, ...] = ()
    contacts: Contacts = field(default_factory=Contacts)
    base: Floats = field(default_factory=lambda: np.eye(4))
    frames: tuple[tuple[str, str], ...] = ()
    request: str = ""
    scales: tuple[float, float] = (1.0, 1.0)

    def start_of(self, robot: Robot) -> Floats:
        """The start (n,) of this robot's joints. Raises InputError if one is missing."""
        return self._joints(self.start, robot, "start_state")

    def goal_of(self, robot: Robot, index: int = 0) -> Target:
        """Goal `index` as a target for this robot: joints, or the pose (or place) of its tool that puts the goal's link there.

        Raises InputError if there is no goal, it is for other joints or for a link that moves against the tip, or it is the place of
        another point than the tool's.
        """
        self.need_goal()
        goal = self.goals[index]
        if isinstance(goal, dict):
            return JointTarget(self._joints(goal, robot, "goal_constraints"))
        link = self.goal_links[index] or robot.link_names[robot.tip]
        on = tool_on(robot, link, self.request)
        if isinstance(goal, PositionTarget):
            away = float(np.linalg.norm(on[:3, 3]))
            if away > 1e-6:
                raise InputError(
                    f"the goal is a place of {link!r} in any orientation, {away:.4g} m from the tool point",
                    place=self.request,
                    remedy=f"give {link!r} as the tip (`tip`), or an orientation constraint as well",
                )
            return goal
        wanted = np.eye(4)
        wanted[:3, :3], wanted[:3, 3] = quaternion_matrix(goal.quaternion), goal.position
        tool = wanted @ on
        return PoseTarget(tool[:3, 3], matrix_quaternion(tool[:3, :3]))

    def need_goal(self) -> None:
        """Raises InputError if there is no goal."""
        if not self.goals:
            raise InputError(
                "the request has no goal" if self.request else "the problem has no goal, since it has no request",
                place=self.request or self.source,
                remedy="goals are its `goal_constraints`"
                if self.request
                else "name the request's file (`request`); request0001.yaml beside scene0001.yaml is found by itself",
            )

    def scene(self, robot: Robot, **fields: Any) -> Scene:
        """As a `Scene` for this robot; `fields` as for the constructor (options, name ...).

        The first goal is taken; no clearance is asked for; the method is the tree. What was enclosed or left out stands in the
        robot's notes. Raises InputError at the file for what does not fit this robot.
        """
        from ._scene import Scene

        # a MoveIt problem asks for no contact, and for no more than that; its planners search in joint space, as the tree does
        options = Options(
            clearance=0.0, method="tree", velocity_scale=self.scales[0], acceleration_scale=self.scales[1]
        )
        fields = {"name": self.name, "source": self.source, "options": options, **fields}
        start, goal = JointTarget(self.start_of(robot)), self.goal_of(robot)
        notes = list(self.notes)
        if len(self.goals) > 1:
            notes.append(f"the request has {len(self.goals)} goals; this is the motion to the first")
        holding = self.robot_of(robot)
        holding = replace(holding, notes=(*holding.notes, *notes)) if notes else holding
        try:
            return Scene(holding, start, goal, self.world, **fields)
        except InputError as error:
            place = (error.place or "").removeprefix("Scene.").split(".")[0]
            place = f"{self.request if place in ('start', 'goal') and self.request else self.source}: {place}"
            raise InputError(error.message, place=place, remedy=error.remedy, choices=error.choices) from None

    @property
    def world(self) -> tuple[Shape, ...]:
        """The obstacles without those that the robot holds."""
        taken = {one.name for one in self.held}
        return tuple(shape for shape, name in zip(self.obstacles, self.object_ids) if name not in taken)

    def robot_of(self, robot: Robot) -> Robot:
        """The robot with the attached objects of the scene and the contacts that its allowed collision matrix permits.

        Its notes say which names are not known. An own entry of a pair counts before defaults, as in MoveIt 2. Raises
        InputError at the place of an object that hangs on no link of this robot, or is stated in the frame of one that moves.
        """
        check_frames(self.frames, robot)
        objects: dict[str, list[Shape]] = {}
        for shape, name in zip(self.obstacles, self.object_ids):
            objects.setdefault(name, []).append(shape)
        notes: list[str] = []
        if self.held:
            robot, notes = hold(robot, self.held, self.start_of(robot), self.base, objects)
        free, more = allow(robot, self.contacts, {k: v for k, v in objects.items() if k not in robot.link_names})
        return replace(free, notes=(*free.notes, *notes, *more)) if notes or more else free

    def _joints(self, values: dict[str, float], robot: Robot, what: str) -> Floats:
        missing = [name for name in require_robot(robot).joint_names if name not in values]
        if missing:
            raise InputError(
                f"{what} has no value for {', '.join(map(repr, missing))} of robot {robot.name!r}",
                place=self.request or self.source,
                remedy=f"the problem is for robot {self.robot_name!r}" if self.robot_name else None,
                choices=sorted(values),
            )
        return np.array([values[name] for name in robot.joint_names])


def problem_of(name: str, scene: Document, request: Document | None = None) -> MoveItProblem:
    """One problem from the YAML of its scene and its request. Raises InputError at file:line:column."""
    document, wanted = Node.root(scene), None if request is None else Node.root(request)
    state, asked = document.get("robot_state"), None if wanted is None else wanted.get("start_state")
    frames = Frames(base_pose(asked) if base_pose(asked) is not None else base_pose(state), document)
    goals: list[dict[str, float] | PoseTarget | PositionTarget] = []
    links: list[str] = []
    for constraints in [] if wanted is None else wanted.items("goal_constraints"):
        goal, link = _goal(constraints, frames)
        goals.append(goal)
        links.append(link)
    if wanted is not None:
        _refuse_constraints(wanted)
    notes = _padding(document)
    world = document.get("world")
    if world is None:
        raise document.error(
            "no field 'world': what stands round the robot is not said",
            "where there is nothing, `world: {collision_objects: []}`",
        )
    octomap = world.get("octomap")
    if octomap is not None and octomap.get("octomap") is not None and octomap.get("octomap").items("data"):
        raise octomap.error("octomaps are not read", "give the occupied cells as a point cloud or boxes")
    obstacles: list[Shape] = []
    ids: list[str] = []
    for item in world.items("collision_objects"):
        obstacles += objects_of(item, inverse(frames.base) @ frames.pose(item), notes)
        ids += [str(item.plain("id") or "")] * (len(obstacles) - len(ids))
    return MoveItProblem(
        name=name,
        obstacles=tuple(obstacles),
        start=_joint_state(state) | _joint_state(asked),
        goals=tuple(goals),
        goal_links=tuple(links),
        robot_name=str(document.plain("robot_model_name") or ""),
        group="" if wanted is None else str(wanted.plain("group_name") or ""),
        source=scene.path,
        notes=tuple(notes),
        object_ids=tuple(ids),
        held=read_held([state, asked], notes),
        contacts=read_contacts(document.get("allowed_collision_matrix")),
        base=frames.base,
        frames=tuple(frames.of_base.items()),
        request="" if request is None else request.path,
        scales=(_scale(wanted, "max_velocity_scaling_factor"), _scale(wanted, "max_acceleration_scaling_factor")),
    )


def _joint_state(state: Node | None) -> dict[str, float]:
    joints = None if state is None else state.get("joint_state")
    if joints is None or joints.get("name") is None:
        return {}
    names, positions = joints.items("name"), joints.need("position").numbers()
    if len(names) != len(positions):
        raise joints.error(f"{len(names)} names but {len(positions)} positions")
    return {str(name.value): float(x) for name, x in zip(names, positions)}


def _scale(request: Node | None, name: str) -> float:
    """A factor of the joints' limits; as in MoveIt, what is not in (0, 1] is no factor."""
    node = None if request is None else request.get(name)
    if node is None:
        return 1.0
    factor = node.number()
    return factor if 0.0 < factor <= 1.0 else 1.0


def _refuse_constraints(request: Node) -> None:
    """A motion that is certified must not break a wish that was not read."""
    kinds = ("joint_constraints", "position_constraints", "orientation_constraints", "visibility_constraints")
    wishes = [request.get("path_constraints")]
    wishes += (
        []
        if request.get("trajectory_constraints") is None
        else request.get("trajectory_constraints").items("constraints")
    )
    for wish in wishes:
        if wish is not None and any(wish.items(kind) for kind in kinds):
            raise wish.error("constraints on the way are not kept by this planner", "take them out of the request")


def _padding(scene: Node) -> list[str]:
    """A note if the scene wants links thicker than they are."""
    usual = {"link_padding": ("padding", 0.0), "link_scale": ("scale", 1.0)}
    return [
        f"{name} is not applied ({', '.join(links)}); ask for a clearance instead"
        for name, (key, value) in usual.items()
        if (links := [str(x.plain("link_name")) for x in scene.items(name) if x.plain(key) not in (None, value)])
    ]


def _goal(constraints: Node, frames: Frames) -> tuple[dict[str, float] | PoseTarget | PositionTarget, str]:
    joints = {
        str(item.need("joint_name").value): item.need("position").number()
        for item in constraints.items("joint_constraints")
    }
    if joints:
        return joints, ""
    positions, turns = constraints.items("position_constraints"), constraints.items("orientation_constraints")
    if len(positions) != 1 or len(turns) > 1:
        raise constraints.error(
            "expected joint constraints, or one position and at most one orientation constraint",
            choices=("joint_constraints", "position_constraints", "position_constraints + orientation_constraints"),
        )
    regions = positions[0].need("constraint_region").items("primitive_poses")
    if len(regions) != 1:
        raise positions[0].error(f"expected one primitive pose, got {len(regions)}")
    pose, link = pose_of(regions[0]), str(positions[0].plain("link_name") or "")
    place = frames.pose(positions[0])
    pose[:3, 3] = place[:3, :3] @ pose[:3, 3] + place[:3, 3]
    offset = positions[0].get("target_point_offset")
    shift = np.zeros(3) if offset is None else offset.numbers(3, ("x", "y", "z"))
    if not turns:
        if offset is not None and shift.any():
            raise offset.error("a goal in any orientation is read for the origin of its link", "leave the offset out")
        return PositionTarget((inverse(frames.base) @ pose)[:3, 3]), link
    pose[:3, :3] = frames.pose(turns[0])[:3, :3] @ pose_of(turns[0])[:3, :3]
    pose[:3, 3] -= pose[:3, :3] @ shift
    pose = inverse(frames.base) @ pose
    return PoseTarget(pose[:3, 3], matrix_quaternion(pose[:3, :3])), link
