"""Which pairs of entities meet in an entity of one type, and by which kernel.

Orientation: `a & b` is a positive multiple of a.as_ipns() ^ b.as_ipns(), so spheres and planes anticommute.
Two lines, two circles, a line and a circle meet in nothing of one type: use a plane or sphere of one of them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from . import _kernels as k
from ._build import check_shapes
from ._circle import Circle
from ._entity import MEETS, Entity
from ._line import Line
from ._pair import PointPair
from ._plane import Plane
from ._point import Point
from ._sphere import Sphere

_TURN = {Circle: np.array([1.0, 1, 1, -1, -1, -1, 1]), Line: -np.ones(6)}


def _register(first: type, second: type, kernel: Callable, result: type[Entity], swap: float = 1.0) -> None:
    """`swap`: the sign of b ^ a against a ^ b."""

    def meet(a: Entity, b: Entity) -> Entity:
        try:
            return result._wrap(kernel(a.array, b.array))
        except ValueError:
            check_shapes(a, b)
            raise

    def turned(b: Entity, a: Entity) -> Entity:
        out = meet(a, b).array
        return result._wrap(out * _TURN[result] if swap < 0 else out)

    MEETS[first, second] = meet
    if first is not second:
        MEETS[second, first] = turned


_register(Sphere, Sphere, k.sphere_sphere, Circle)
_register(Sphere, Plane, k.sphere_plane, Circle, swap=-1.0)
_register(Plane, Plane, k.plane_plane, Line)
_register(Line, Plane, k.line_plane, Point)
_register(Circle, Plane, k.circle_plane, PointPair)
_register(Circle, Sphere, k.circle_sphere, PointPair)
_register(Line, Sphere, k.line_sphere, PointPair)
