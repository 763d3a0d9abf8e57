"""Certificates: what a motion provably keeps, for all times between its waypoints."""

from ._certificate import Certificate as Certificate
from ._certificate import Unresolved as Unresolved
from ._certificate import Violation as Violation
from ._certify import certify as certify
from ._clearance import ClearanceBound as ClearanceBound
from ._clearance import Gap as Gap
from ._clearance import PathPoint as PathPoint
from ._clearance import clearance_bound as clearance_bound
