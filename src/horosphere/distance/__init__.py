"""Signed distances between a robot and obstacles, exact, with gradients; metres."""

from ._pack import ROUNDING as ROUNDING
from ._pack import pack_robot as pack_robot
from ._pack import rounding_slack as rounding_slack
from ._signed import allowance as allowance
from ._signed import clearance as clearance
from ._signed import pack_obstacles as pack_obstacles
from ._signed import signed as signed
from ._table import Contact as Contact
from ._table import DistanceTable as DistanceTable
from ._table import table as table
