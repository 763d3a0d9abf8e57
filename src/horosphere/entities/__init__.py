"""The six entities of Table I [Humanoid] as typed, batched values: point, point pair, line, circle, plane, sphere."""

from . import _angle, _distance, _meet  # they fill the tables of the pairs  # noqa: F401
from ._circle import Circle as Circle
from ._entity import Entity as Entity
from ._line import Line as Line
from ._pair import PointPair as PointPair
from ._plane import Plane as Plane
from ._point import Point as Point
from ._sphere import Sphere as Sphere
