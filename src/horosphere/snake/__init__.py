"""Snake robots in the plane: kinematics, exact controllability, motion, steering and navigation."""

from typing import TYPE_CHECKING, Any

from ._bracket_control import BracketControl as BracketControl
from ._bracket_control import bracket_control as bracket_control
from ._brackets import BracketMotion as BracketMotion
from ._brackets import input_word as input_word
from ._gaits import Gait as Gait
from ._gaits import serpenoid as serpenoid
from ._gaits import shape_gait as shape_gait
from ._growth import Growth as Growth
from ._inverse import ClosedChains as ClosedChains
from ._motion import Motion as Motion
from ._navigate import NavigateOptions as NavigateOptions
from ._navigate import Navigation as Navigation
from ._plots import bracket_figure as bracket_figure
from ._plots import motion_figure as motion_figure
from ._snake import Snake as Snake
from ._steer import Steering as Steering
from ._steer import SteerOptions as SteerOptions
from ._word import read_word as read_word
from ._word import word_text as word_text
from ._world import SnakeCertificate as SnakeCertificate
from ._world import Surroundings as Surroundings

if TYPE_CHECKING:
    from ._certify import certify_trajectory as certify_trajectory
    from ._scene import certificate_of as certificate_of
    from ._scene import navigate_scene as navigate_scene
    from ._scene import snake_of as snake_of
    from ._scene import trajectory_of as trajectory_of


def __getattr__(name: str) -> Any:
    if name in (
        "navigate_scene",
        "snake_of",
        "trajectory_of",
        "certificate_of",
        "certify_trajectory",
    ):  # what reads scenes is imported when asked for
        from . import _certify, _scene

        return getattr(_certify if name == "certify_trajectory" else _scene, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
