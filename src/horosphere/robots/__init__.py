"""Robots as data: the record, URDF files, the built-in catalogue."""

from ._attach import allow as allow
from ._attach import attach as attach
from ._attach import detach as detach
from ._builtin import humanoid_arm as humanoid_arm
from ._builtin import six_axis_arm as six_axis_arm
from ._builtin import srs_arm as srs_arm
from ._describe import describe as describe
from ._load import link_index as link_index
from ._load import load as load
from ._load import names as names
from ._robot import Capsules as Capsules
from ._robot import Limits as Limits
from ._robot import Link as Link
from ._robot import LinkPair as LinkPair
from ._robot import Robot as Robot
from ._save import save as save
