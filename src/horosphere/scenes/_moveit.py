"""MoveIt planning scenes and motion-plan requests (YAML of the ROS messages), and sets of them as in MotionBenchMaker."""

from __future__ import annotations

import re
import tarfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ._targets import JointTarget, PoseTarget, Target, matrix_quaternion, quaternion_matrix
from ._yaml import Document, Loc, parse_yaml

if TYPE_CHECKING:
    from ..robots import Robot
    from ..shapes import Shape
    from ._scene import Scene

Floats = NDArray[np.float64]
PRIMITIVES = {"box": 3, "sphere": 1, "cylinder": 2, "cone": 2}
_TYPES = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone"}  # shape_msgs/SolidPrimitive
_FILE = re.compile(r"scene(.*)\.ya?ml\Z")


@dataclass(frozen=True, eq=False)
class MoveItProblem:
    """Obstacles in the robot's base frame, a start, and goals any of which will do.

    `start`: joint values by name; each of `goals` likewise, or a pose of the link `goal_links[k]`. `notes`: what was enclosed
    or left out.
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
        return Scene(robot, JointTarget(self.start_of(robot)), self.goal_of(robot), self.obstacles, **fields)

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
    document = _Node.root(parse_yaml(scene, scene_place))
    wanted = None if request is None else _Node.root(parse_yaml(request, request_place or ""))
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
    for holder in (document.get("robot_state"), wanted.get("start_state") if wanted else None):
        attached = None if holder is None else holder.get("attached_collision_objects")
        if attached is not None and attached.value:
            raise attached.error(
                "objects attached to the robot are not read", "add their bodies to the robot's collision model"
            )
    world = document.get("world")
    octomap = None if world is None else world.get("octomap")
    if octomap is not None and octomap.get("octomap") is not None and octomap.get("octomap").items("data"):
        raise octomap.error("octomaps are not read", "give the occupied cells as a point cloud or boxes")
    obstacles = []
    for item in world.items("collision_objects") if world is not None else ():
        obstacles += _object(item, _inverse(base), notes)
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
    )


class _Node:
    """A value of a YAML document that knows its place."""

    def __init__(self, document: Document, loc: Loc, value: Any) -> None:
        self.document, self.loc, self.value = document, loc, value

    @staticmethod
    def root(document: Document) -> _Node:
        for problem in document.problems:
            raise InputError(problem.message, place=document.place(problem.loc), remedy=problem.remedy)
        node = _Node(document, (), document.data)
        if not isinstance(document.data, dict):
            raise node.error("expected the fields of a MoveIt message", "planning scene or motion-plan request as YAML")
        return node

    def error(self, message: str, remedy: str | None = None, choices: Any = None) -> InputError:
        return InputError(message, place=self.document.place(self.loc), remedy=remedy, choices=choices)

    def get(self, name: str) -> Any:
        if not isinstance(self.value, dict):
            raise self.error(f"expected fields, {name!r} among them, got {type(self.value).__name__}")
        value = self.value.get(name)
        return None if value is None else _Node(self.document, (*self.loc, name), value)

    def need(self, name: str) -> _Node:
        node = self.get(name)
        if node is None:
            raise self.error(f"missing field {name!r}")
        return node

    def plain(self, name: str) -> Any:
        node = self.get(name)
        return None if node is None else node.value

    def items(self, name: str) -> list[_Node]:
        node = self.get(name)
        if node is None:
            return []
        if not isinstance(node.value, list):
            raise node.error(f"expected a list, got {type(node.value).__name__}")
        return [_Node(self.document, (*node.loc, k), value) for k, value in enumerate(node.value)]

    def numbers(self, count: int | None = None, keys: tuple[str, ...] = ()) -> Floats:
        """A list of finite numbers, or fields x, y, z ..."""
        value = self.value
        if isinstance(value, dict) and keys and set(value) >= set(keys):
            value = [value[key] for key in keys]
        good = isinstance(value, list) and all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in value)
        array = np.array(value if good else [np.nan], np.float64)
        if (count is not None and len(array) != count) or not np.isfinite(array).all():
            raise self.error(
                f"expected {count if count is not None else ''} finite numbers, got {value!r}".replace("  ", " ")
            )
        return array


def _pose(node: _Node | None) -> Floats:
    """4x4 from position and orientation (x, y, z, w), or Euler angles about the fixed axes x, y, z in that order."""
    pose = np.eye(4)
    if node is None:
        return pose
    position = node.get("position") or node.get("translation")
    if position is not None:
        pose[:3, 3] = position.numbers(3, ("x", "y", "z"))
    turn = node.get("orientation") or node.get("rotation")
    if turn is not None:
        x, y, z, w = turn.numbers(4, ("x", "y", "z", "w"))
        length = float(np.sqrt(x * x + y * y + z * z + w * w))
        if abs(length - 1.0) > 1e-3:
            raise turn.error(f"expected a unit quaternion (x, y, z, w), its length is {length:.4g}")
        pose[:3, :3] = quaternion_matrix(np.array([w, x, y, z]) / length)
    euler = node.get("orientation_euler_xyz")
    if euler is not None:
        a, b, c = euler.numbers(3)
        (ca, cb, cc), (sa, sb, sc) = np.cos([a, b, c]), np.sin([a, b, c])
        x_turn = np.array([[1, 0, 0], [0, ca, -sa], [0, sa, ca]])
        y_turn = np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
        z_turn = np.array([[cc, -sc, 0], [sc, cc, 0], [0, 0, 1]])
        pose[:3, :3] = z_turn @ y_turn @ x_turn
    return pose


def _inverse(pose: Floats) -> Floats:
    inverse = np.eye(4)
    inverse[:3, :3] = pose[:3, :3].T
    inverse[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return inverse


def _joint_state(state: _Node | None) -> dict[str, float]:
    joints = None if state is None else state.get("joint_state")
    if joints is None or joints.get("name") is None:
        return {}
    names, positions = joints.need("name"), joints.need("position").numbers()
    if len(names.value) != len(positions):
        raise joints.error(f"{len(names.value)} names but {len(positions)} positions")
    return {str(name): float(x) for name, x in zip(names.value, positions)}


def _base_pose(state: _Node | None) -> Floats:
    """Where the robot stands in the world: the first transform of its virtual joint."""
    joints = None if state is None else state.get("multi_dof_joint_state")
    transforms = [] if joints is None else joints.items("transforms")
    return _pose(transforms[0]) if transforms else np.eye(4)


def _goal(constraints: _Node, base: Floats) -> tuple[dict[str, float] | PoseTarget, str]:
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
    pose = _pose(regions[0])
    pose[:3, :3] = _pose(turns[0])[:3, :3]
    if positions[0].plain("target_point_offset") is not None:
        offset = positions[0].need("target_point_offset").numbers(3, ("x", "y", "z"))
        pose[:3, 3] -= pose[:3, :3] @ offset
    pose = _inverse(base) @ pose
    return PoseTarget(pose[:3, 3], matrix_quaternion(pose[:3, :3])), str(positions[0].plain("link_name") or "")


def _object(item: _Node, to_base: Floats, notes: list[str]) -> list[Any]:
    if item.plain("operation") in (1, "REMOVE"):
        return []
    name = str(item.plain("id") or "")
    place = to_base @ _pose(item.get("pose"))
    shapes: list[Any] = []
    solids, poses = item.items("primitives"), item.items("primitive_poses")
    if len(solids) != len(poses) and not (item.get("pose") is not None and not poses):
        raise item.error(f"{len(solids)} primitives but {len(poses)} primitive_poses")
    for k, solid in enumerate(solids):
        own = name if len(solids) == 1 else f"{name}/{k}"
        shapes.append(_primitive(solid, place @ (_pose(poses[k]) if poses else np.eye(4)), own, notes))
    meshes, mesh_poses = item.items("meshes"), item.items("mesh_poses")
    for k, mesh in enumerate(meshes):
        from ..shapes import Mesh

        pose = place @ (_pose(mesh_poses[k]) if mesh_poses else np.eye(4))
        vertices = np.array([v.numbers(3, ("x", "y", "z")) for v in mesh.items("vertices")]).reshape(-1, 3)
        faces = [t.need("vertex_indices") if isinstance(t.value, dict) else t for t in mesh.items("triangles")]
        indices = np.array([t.numbers(3) for t in faces], np.int64).reshape(-1, 3)
        shapes.append(Mesh(vertices @ pose[:3, :3].T + pose[:3, 3], indices, name=name))
    for k, plane in enumerate(item.items("planes")):
        from ..shapes import HalfSpace

        # shape_msgs/Plane: a x + b y + c z + d = 0; the solid lies where that is not positive
        plane_poses = item.items("plane_poses")
        pose = place @ (_pose(plane_poses[k]) if plane_poses else np.eye(4))
        coefficients = plane.need("coef").numbers(4)
        normal = pose[:3, :3] @ coefficients[:3]
        shapes.append(HalfSpace(normal, float(normal @ pose[:3, 3] - coefficients[3]), name=name))
    return shapes


def _primitive(solid: _Node, pose: Floats, name: str, notes: list[str]) -> Any:
    from ..shapes import Ball, Box, Cylinder

    kind = solid.need("type").value
    kind = _TYPES.get(kind, kind)
    if kind not in PRIMITIVES:
        raise solid.need("type").error(f"unknown primitive {kind!r}", choices=sorted(PRIMITIVES))
    sizes = solid.need("dimensions").numbers(PRIMITIVES[kind])
    if (sizes <= 0).any():
        raise solid.need("dimensions").error(f"expected sizes > 0, got {sizes.tolist()}")
    centre = pose[:3, 3]
    if kind == "box":
        return Box(centre, 0.5 * sizes, pose[:3, :3], name=name)
    if kind == "sphere":
        return Ball(centre, float(sizes[0]), name=name)
    if kind == "cone":
        notes.append(f"{name}: the cone is enclosed in its cylinder")
    half = 0.5 * sizes[0] * pose[:3, 2]
    return Cylinder(centre - half, centre + half, float(sizes[1]), name=name)
