"""A scene: a robot among obstacles, where it starts and what it shall reach."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ._bodies import PointRobot, SnakeRobot, UnicycleRobot, Workspace
from ._checks import problems
from ._options import ControlOptions, FieldOptions, Options
from ._targets import JointTarget, PoseTarget, PositionTarget, Target, matrix_quaternion

if TYPE_CHECKING:
    from ..robots import Robot


@dataclass(frozen=True, slots=True)
class Origin:
    """How the robot, the obstacles, what the robot holds and what it may touch were written, with absolute paths: what `save`
    writes again."""

    robot: Any = None
    obstacles: tuple[Any, ...] | None = None
    attached: tuple[Any, ...] = ()
    allowed: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, eq=False)
class Scene:
    """A robot, its start and goal, obstacles and wishes; metres, radians, world frame = the robot's base frame.

    The constructor is kind: `robot` may be a name, `start` and `goal` an array (joints of an arm, or a position), a `Motor`
    (pose) or a `Point`; `obstacles` is whatever `shapes.as_shapes` takes. `notes`: what the reader of a file did
    that its user should know. Raises InputError naming the argument.
    """

    robot: Robot | PointRobot | UnicycleRobot | SnakeRobot
    start: Target
    goal: Target
    obstacles: tuple[Any, ...] = ()
    name: str = "scene"
    options: Options = dataclasses.field(default_factory=Options)
    field: FieldOptions = dataclasses.field(default_factory=FieldOptions)
    control: ControlOptions = dataclasses.field(default_factory=ControlOptions)
    workspace: Workspace | None = None
    description: str = ""
    source: str | None = None
    origin: Origin = dataclasses.field(default_factory=Origin, repr=False)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if isinstance(self.robot, str):
            from ..robots import load

            object.__setattr__(self, "origin", dataclasses.replace(self.origin, robot=self.robot))
            object.__setattr__(self, "robot", load(self.robot))
        object.__setattr__(self, "obstacles", _obstacles(self.obstacles))
        arm = not isinstance(self.robot, (PointRobot, UnicycleRobot, SnakeRobot))
        if arm:
            from ..robots._robot import require_robot

            require_robot(self.robot)
        for name in ("start", "goal"):
            object.__setattr__(self, name, _target(getattr(self, name), name, arm))
        for problem in problems(self.robot, self.start, self.goal, self.obstacles, self.workspace, self.field):
            raise InputError(
                problem.message,
                place="Scene." + ".".join(str(step) for step in problem.loc),
                remedy=problem.remedy,
                choices=problem.choices,
            )

    @property
    def dimension(self) -> int:
        """Of the space the obstacles live in."""
        if isinstance(self.robot, PointRobot):
            return self.robot.dimension
        return 2 if isinstance(self.robot, (UnicycleRobot, SnakeRobot)) else 3

    def with_(self, **changes: Any) -> Scene:
        """A copy with some fields changed."""
        unknown = set(changes) - {item.name for item in dataclasses.fields(self)}
        if unknown:
            from ..errors import unknown_name

            raise unknown_name("field", sorted(unknown)[0], (item.name for item in dataclasses.fields(self)))
        if "origin" not in changes:
            dropped = {name: None for name in ("robot", "obstacles") if name in changes}
            changes["origin"] = dataclasses.replace(self.origin, **dropped)
        if "obstacles" in changes:
            changes = {"notes": (), **changes}  # they are about files of the others
        return dataclasses.replace(self, **changes)

    @staticmethod
    def load(
        path: str | Path,
        *,
        robot: Robot | str | Path | None = None,
        tip: str | None = None,
        srdf: str | Path | None = None,
        request: str | Path | None = None,
    ) -> Scene:
        """The scene in a file, the built-in one of that name, or that of a MoveIt problem.

        A MoveIt planning scene is known by its content, as a file or as PATH:SET/NUMBER in an archive (.tar, .tar.gz, .tar.bz2,
        .tar.xz) or a folder. It needs a `robot` (a Robot, a URDF, a robot file, a built-in name); `tip` and `srdf` are for a URDF;
        `request` is its motion-plan request, by default request* beside scene*. Raises SceneError with every problem as
        file:line:column, InputError for MoveIt files.
        """
        from ._load import load_scene

        return load_scene(path, robot, tip, srdf, request)

    def save(self, path: str | Path) -> Path:
        """Writes the scene as YAML, paths relative to the file; returns the path.

        A robot that was made in Python, or holds what a MoveIt scene says, is written beside it as NAME.robot.yaml.
        """
        from ._save import save_scene

        return save_scene(self, path)


def _obstacles(value: Any) -> tuple[Any, ...]:
    from ._bodies import Aerofoil, EllipsoidND, Star

    own = (Aerofoil, EllipsoidND, Star)
    if isinstance(value, own):
        return (value,)
    if isinstance(value, (list, tuple)) and not value:
        return ()
    from ..shapes import as_shapes

    if isinstance(value, (list, tuple)) and any(isinstance(item, own) for item in value):
        return tuple(one for item in value for one in ((item,) if isinstance(item, own) else as_shapes(item)))
    return tuple(as_shapes(value))


def _target(value: Any, name: str, arm: bool) -> Target:
    if dataclasses.is_dataclass(value) and type(value).__name__.endswith("Target"):
        return value  # type: ignore[return-value]
    if hasattr(value, "as_matrix"):
        matrix = value.as_matrix()
        return PoseTarget(matrix[:3, 3], matrix_quaternion(matrix[:3, :3]))
    if hasattr(value, "as_euclidean"):
        return PositionTarget(value.as_euclidean())
    if isinstance(value, (list, tuple, np.ndarray)):
        return JointTarget(value) if arm else PositionTarget(value)  # type: ignore[arg-type]
    raise InputError(
        f"expected joints, a Motor, a Point or a target of horosphere.scenes, got {type(value).__name__}",
        place=f"Scene.{name}",
    )
