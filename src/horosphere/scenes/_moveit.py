"""MoveIt planning scenes and motion-plan requests (YAML of the ROS messages), and sets of them as in MotionBenchMaker."""

from __future__ import annotations

import re
import tarfile
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ._moveit_contacts import Contacts, HeldObject, allow, hold, read_contacts, read_held
from ._moveit_node import Node, inverse, pose_of
from ._moveit_objects import objects_of
from ._targets import JointTarget, PoseTarget, Target, matrix_quaternion
from ._yaml import parse_yaml

if TYPE_CHECKING:
    from ..robots import Robot
    from ..shapes import Shape
    from ._scene import Scene

Floats = NDArray[np.float64]
_FILE = re.compile(r"scene(.*)\.ya?ml\Z")


@dataclass(frozen=True, eq=False)
class MoveItProblem:
    """Obstacles in the robot's base frame, a start, and goals any of which will do.

    `start`: joint values by name; each of `goals` likewise, or a pose of the link `goal_links[k]`. `notes`: what was enclosed
    or left out. `object_ids`: which collision object each obstacle is of. `held`: objects attached to links; `contacts`: the
    allowed collision matrix; `robot_of` gives a robot both. `base` (4, 4): the robot's base in the world.
    """

    name: str
    obstacles: tuple[Shape, ...]
    start: dict[str, float]
    goals: tuple[dict[str, float] | PoseTarget, ...]
    goal_links: tuple[str, ...] = ()
    robot_name: str = ""
    group: str = ""
    source: str = ""
    notes: tuple[str, ...] = field(default=())
    object_ids: tuple[str, ...] = ()
    held: tuple[HeldObject, ...] = ()
    contacts: Contacts = field(default_factory=Contacts)
    base: Floats = field(default_factory=lambda: np.eye(4))

    def start_of(self, robot: Robot) -> Floats:
        """The start (n,) of this robot's joints. Raises InputError if one is missing."""
        return self._joints(self.start, robot, "start_state")

    def goal_of(self, robot: Robot, index: int = 0) -> Target:
        """Goal `index` as a target for this robot."""
        if not self.goals:
            raise InputError(
                "the problem has no goal", place=self.source, remedy="read it together with its request file"
            )
        goal = self.goals[index]
        return goal if isinstance(goal, PoseTarget) else JointTarget(self._joints(goal, robot, "goal_constraints"))

    def scene(self, robot: Robot, **fields: Any) -> Scene:
        """As a `Scene` for this robot; `fields` as for the constructor (options, name ...)."""
        from ._scene import Scene

        fields = {"name": self.name, "source": self.source, **fields}
        start = JointTarget(self.start_of(robot))
        return Scene(self.robot_of(robot), start, self.goal_of(robot), self.world, **fields)

    @property
    def world(self) -> tuple[Shape, ...]:
        """The obstacles without those that the robot holds."""
        taken = {one.name for one in self.held}
        return tuple(shape for shape, name in zip(self.obstacles, self.object_ids) if name not in taken)

    def robot_of(self, robot: Robot) -> Robot:
        """The robot with the attached objects of the scene and the contacts that its allowed collision matrix permits.

        Its notes say which names are not known. An own entry of a pair counts before defaults, as in MoveIt 2. Raises
        InputError at the place of an object that hangs on no link of this robot.
        """
        objects: dict[str, list[Shape]] = {}
        for shape, name in zip(self.obstacles, self.object_ids):
            objects.setdefault(name, []).append(shape)
        notes: list[str] = []
        if self.held:
            robot, notes = hold(robot, self.held, self.start_of(robot), self.base, objects)
        free, more = allow(robot, self.contacts, {k: v for k, v in objects.items() if k not in robot.link_names})
        return replace(free, notes=(*free.notes, *notes, *more)) if notes or more else free

    def _joints(self, values: dict[str, float], robot: Robot, what: str) -> Floats:
        missing = [name for name in robot.joint_names if name not in values]
        if missing:
            raise InputError(
                f"{what} has no value for {', '.join(map(repr, missing))} of robot {robot.name!r}",
                place=self.source,
                remedy=f"the problem is for robot {self.robot_name!r}" if self.robot_name else None,
                choices=sorted(values),
            )
        return np.array([values[name] for name in robot.joint_names])


def read_moveit(scene: str | Path, request: str | Path | None = None) -> MoveItProblem:
    """One problem from a planning-scene file and its request file (default: `request*` beside `scene*`, if it is there)."""
    path = Path(scene)
    match = _FILE.match(path.name)
    if request is None and match:
        beside = path.with_name(path.name.replace("scene", "request", 1))
        request = beside if beside.is_file() else None
    texts = [_text(path), None if request is None else _text(Path(request))]
    return _problem(path.stem, str(path), texts[0] or "", None if request is None else str(request), texts[1])


def read_moveit_set(path: str | Path) -> Iterator[tuple[str, MoveItProblem]]:
    """(set, problem) for all `scene*.yaml` with their `request*.yaml` under a folder or in a .tar(.gz, .bz2, .xz), in order.

    The set is the name of the folder that holds the files. Raises InputError (file:line:column) at the first bad one.
    """
    place = Path(path)
    if place.is_dir():
        files = {p.relative_to(place).as_posix(): p for p in place.rglob("*") if p.suffix in (".yaml", ".yml")}
        yield from _pairs(str(place), files, lambda p: _text(p))
        return
    if not place.is_file():
        raise InputError("no such file or folder", place=str(path))
    if place.suffix in (".yaml", ".yml"):
        yield place.parent.name, read_moveit(place)
        return
    try:
        with tarfile.open(place) as archive:
            members = {m.name: m for m in archive.getmembers() if m.isfile()}
            # read in the order of the archive: seeking back in a compressed one would unpack it again each time
            texts = {name: archive.extractfile(m).read() for name, m in members.items()}  # type: ignore[union-attr]
    except (tarfile.TarError, EOFError, OSError) as error:
        raise InputError(
            f"not a readable archive: {str(error).splitlines()[0]}",
            place=str(path),
            choices=(".tar", ".tar.gz", ".tar.bz2", ".tar.xz"),
        ) from None
    yield from _pairs(str(place), texts, lambda raw: raw.decode("utf-8"))


def _pairs(place: str, files: dict[str, Any], read: Any) -> Iterator[tuple[str, MoveItProblem]]:
    scenes = sorted(name for name in files if _FILE.match(name.rsplit("/", 1)[-1]))
    if not scenes:
        raise InputError(
            "no scene*.yaml in it", place=place, remedy="expected MoveIt planning scenes, as in MotionBenchMaker"
        )
    for name in scenes:
        folder, _, file = name.rpartition("/")
        request = f"{folder}/{file.replace('scene', 'request', 1)}".lstrip("/")
        text = read(files[request]) if request in files else None
        problem = _problem(file.rsplit(".", 1)[0], f"{place}/{name}", read(files[name]), f"{place}/{request}", text)
        yield folder.rsplit("/", 1)[-1], problem


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read: {getattr(error, 'strerror', None) or error}", place=str(path)) from None


def _problem(name: str, scene_place: str, scene: str, request_place: str | None, request: str | None) -> MoveItProblem:
    document = Node.root(parse_yaml(scene, scene_place))
    wanted = None if request is None else Node.root(parse_yaml(request, request_place or ""))
    notes: list[str] = []
    start = _joint_state(document.get("robot_state"))
    base = _base_pose(document.get("robot_state"))
    goals: list[dict[str, float] | PoseTarget] = []
    links: list[str] = []
    if wanted is not None:
        state = wanted.get("start_state")
        start |= _joint_state(state)
        base = _base_pose(state) if state is not None and state.get("multi_dof_joint_state") is not None else base
        for constraints in wanted.items("goal_constraints"):
            goal, link = _goal(constraints, base)
            goals.append(goal)
            links.append(link)
    states = [document.get("robot_state"), None if wanted is None else wanted.get("start_state")]
    held, contacts = read_held(states, notes), read_contacts(document.get("allowed_collision_matrix"))
    world = document.get("world")
    octomap = None if world is None else world.get("octomap")
    if octomap is not None and octomap.get("octomap") is not None and octomap.get("octomap").items("data"):
        raise octomap.error("octomaps are not read", "give the occupied cells as a point cloud or boxes")
    obstacles: list[Shape] = []
    ids: list[str] = []
    for item in world.items("collision_objects") if world is not None else ():
        obstacles += objects_of(item, inverse(base), notes)
        ids += [str(item.plain("id") or "")] * (len(obstacles) - len(ids))
    return MoveItProblem(
        name,
        tuple(obstacles),
        start,
        tuple(goals),
        tuple(links),
        str(document.plain("robot_model_name") or ""),
        str(wanted.plain("group_name") or "") if wanted is not None else "",
        scene_place,
        tuple(notes),
        tuple(ids),
        held,
        contacts,
        base,
    )


def _joint_state(state: Node | None) -> dict[str, float]:
    joints = None if state is None else state.get("joint_state")
    if joints is None or joints.get("name") is None:
        return {}
    names, positions = joints.need("name"), joints.need("position").numbers()
    if len(names.value) != len(positions):
        raise joints.error(f"{len(names.value)} names but {len(positions)} positions")
    return {str(name): float(x) for name, x in zip(names.value, positions)}


def _base_pose(state: Node | None) -> Floats:
    """Where the robot stands in the world: the first transform of its virtual joint."""
    joints = None if state is None else state.get("multi_dof_joint_state")
    transforms = [] if joints is None else joints.items("transforms")
    return pose_of(transforms[0]) if transforms else np.eye(4)


def _goal(constraints: Node, base: Floats) -> tuple[dict[str, float] | PoseTarget, str]:
    joints = {
        str(item.need("joint_name").value): float(item.need("position").value)
        for item in constraints.items("joint_constraints")
    }
    if joints:
        return joints, ""
    positions, turns = constraints.items("position_constraints"), constraints.items("orientation_constraints")
    if len(positions) != 1 or len(turns) != 1:
        raise constraints.error(
            "expected joint constraints, or one position and one orientation constraint",
            choices=("joint_constraints", "position_constraints + orientation_constraints"),
        )
    regions = positions[0].need("constraint_region").items("primitive_poses")
    if len(regions) != 1:
        raise positions[0].error(f"expected one primitive pose, got {len(regions)}")
    pose = pose_of(regions[0])
    pose[:3, :3] = pose_of(turns[0])[:3, :3]
    if positions[0].plain("target_point_offset") is not None:
        offset = positions[0].need("target_point_offset").numbers(3, ("x", "y", "z"))
        pose[:3, 3] -= pose[:3, :3] @ offset
    pose = inverse(base) @ pose
    return PoseTarget(pose[:3, 3], matrix_quaternion(pose[:3, :3])), str(positions[0].plain("link_name") or "")
