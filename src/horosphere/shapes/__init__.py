"""Obstacles: solids in world coordinates, metres."""

from ._base import Shape as Shape
from ._convert import as_shapes as as_shapes
from ._flat import Box as Box
from ._flat import Cylinder as Cylinder
from ._flat import HalfSpace as HalfSpace
from ._pack import Packed as Packed
from ._pack import pack as pack
from ._round import Ball as Ball
from ._round import Capsule as Capsule
from ._round import Ellipsoid as Ellipsoid
from ._round import ellipsoid_signed_distance as ellipsoid_signed_distance
from ._sampled import Mesh as Mesh
from ._sampled import PointCloud as PointCloud
