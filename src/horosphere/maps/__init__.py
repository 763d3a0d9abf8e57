"""Maps that carry shapes to circles and balls: stars with their radial functions, the shell map, the Joukowski maps."""

from ._function import FunctionStar as FunctionStar
from ._function import lobed as lobed
from ._function import star as star
from ._joukowski import Joukowski as Joukowski
from ._polytope import PolytopeStar as PolytopeStar
from ._polytope import convex_hull as convex_hull
from ._round import RoundHull as RoundHull
from ._round import ball_seen_from as ball_seen_from
from ._round import capsule as capsule
from ._shell import ShellMap as ShellMap
from ._star import NormStar as NormStar
from ._star import Star as Star
from ._star import ellipsoid as ellipsoid
from ._star import smooth_box as smooth_box
from ._star import smooth_cylinder as smooth_cylinder
from ._star import superquadric as superquadric
from ._union import UnionStar as UnionStar
from ._union import common_point as common_point
from ._union import union as union
