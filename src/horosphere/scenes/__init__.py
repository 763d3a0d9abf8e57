"""Scenes: a robot among obstacles, its start and its goal, read from YAML with every problem named; trajectories as data."""

from typing import Any

from ._bodies import Aerofoil as Aerofoil
from ._bodies import EllipsoidND as EllipsoidND
from ._bodies import PointRobot as PointRobot
from ._bodies import SnakeRobot as SnakeRobot
from ._bodies import Star as Star
from ._bodies import UnicycleRobot as UnicycleRobot
from ._bodies import Workspace as Workspace
from ._bodies import kind_of as kind_of
from ._library import library_path as library_path
from ._library import names as names
from ._options import ControlOptions as ControlOptions
from ._options import FieldOptions as FieldOptions
from ._options import Options as Options
from ._problems import SceneError as SceneError
from ._scene import Scene as Scene
from ._targets import GripperPlaneTarget as GripperPlaneTarget
from ._targets import HeadingTarget as HeadingTarget
from ._targets import JointTarget as JointTarget
from ._targets import LineTarget as LineTarget
from ._targets import PlaneTarget as PlaneTarget
from ._targets import PoseTarget as PoseTarget
from ._targets import PositionTarget as PositionTarget
from ._targets import PostureTarget as PostureTarget
from ._targets import Target as Target
from ._targets import matrix_quaternion as matrix_quaternion
from ._targets import quaternion_matrix as quaternion_matrix
from ._trajectory import Trajectory as Trajectory


def __getattr__(name: str) -> Any:
    if name in ("MoveItProblem", "read_moveit", "read_moveit_set"):  # read only where such files are
        from . import _moveit_files

        return getattr(_moveit_files, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
