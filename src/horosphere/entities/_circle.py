from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra import Multivector
from ..algebra._format import vector
from ..numeric import float_array
from . import _kernels as k
from ._build import (
    EPS,
    blade_of,
    cross,
    length,
    non_negative,
    null_coefficients,
    refuse,
    same_blade,
    together,
    triangle,
    unit,
    vectors,
)
from ._entity import Entity
from ._plane import Plane
from ._sphere import Sphere, radius_text, real_root


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Circle(Entity):
    """Circle sphere ^ plane [Humanoid, Table I]; `array` (..., 7) = (center, unit normal, radius^2).

    A negative radius^2 is an imaginary circle; normal 0 with radius^2 -inf the meet of concentric spheres.
    """

    SIZE: ClassVar[int] = 7

    def _check(self) -> None:
        refuse(np.abs(length(self.array[..., 3:6]) - 1.0) > 8 * EPS, "expected a unit normal", "Circle.array",
               "use Circle.from_center_normal_radius")  # fmt: skip

    @classmethod
    def from_center_normal_radius(cls, center: ArrayLike, normal: ArrayLike, radius: ArrayLike) -> Self:
        """From center (..., 3), normal (..., 3; made unit), radius (...), metres. Raises InputError when negative."""
        c, n = vectors((center, "center"), (normal, "normal"))
        n = unit(n, "normal", "give a direction that is not zero")
        r2 = non_negative(radius, "radius")[..., None] ** 2
        return cls._wrap(np.concatenate(together([c, n, r2], ["center", "normal", "radius"]), axis=-1))

    @classmethod
    def from_points(cls, a: ArrayLike, b: ArrayLike, c: ArrayLike) -> Self:
        """Through three points (..., 3), a ^ b ^ c, normal along (b - a) x (c - a). InputError when collinear."""
        return cls._wrap(k.circle_of_points(*triangle(*vectors((a, "a"), (b, "b"), (c, "c")), what="a Circle")))

    @property
    def center(self) -> NDArray[np.float64]:
        """(..., 3), metres."""
        return self.array[..., :3].copy()

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normal (..., 3)."""
        return self.array[..., 3:6].copy()

    @property
    def radius_squared(self) -> NDArray[np.float64]:
        """(...), square metres; negative where imaginary."""
        return self.array[..., 6].copy()

    @property
    def radius(self) -> NDArray[np.float64]:
        """(...), metres; NaN where not real."""
        return real_root(self.array[..., 6])

    @property
    def is_real(self) -> NDArray[np.bool_]:
        return self.array[..., 6] >= 0.0

    @property
    def plane(self) -> Plane:
        """The plane it lies in, with its normal."""
        c, n = self.array[..., :3], self.array[..., 3:6]
        return Plane._wrap(np.concatenate([n, np.sum(n * c, axis=-1, keepdims=True)], axis=-1))

    @property
    def sphere(self) -> Sphere:
        """The sphere of which it is a great circle."""
        return Sphere._wrap(self.array[..., [0, 1, 2, 6]])

    def as_ipns(self) -> Multivector:
        """sphere ^ plane; the zero blade where there is no circle anywhere."""
        finite = self.array.copy()
        finite[np.isneginf(self.array[..., 6]), 6] = 0.0
        return Sphere._wrap(finite[..., [0, 1, 2, 6]]).as_ipns() ^ self.plane.as_ipns()

    @classmethod
    def from_ipns(cls, blade: Multivector) -> Self:
        return cls._wrap(round_parameters(blade_of(blade, 2, "Circle"), cls))

    def point_at(self, angle: ArrayLike) -> NDArray[np.float64]:
        """Points (..., 3) at an angle (...), radians, right-handed about the normal, from a direction of its choice."""
        n = self.array[..., 3:6]
        axis = np.eye(3)[np.argmin(np.abs(n), axis=-1)]
        u = unit(cross(n, axis), "normal", "an empty circle has no points")
        angle = float_array(angle, "angle")[..., None]
        around = np.cos(angle) * u + np.sin(angle) * cross(n, u)
        return self.array[..., :3] + np.asarray(self.radius)[..., None] * around

    def _text(self) -> str:
        return f"center={vector(self.array[:3])}, normal={vector(self.array[3:6])}, {radius_text(self.array[6])}"


def round_parameters(blade: Multivector, kind: type) -> NDArray[np.float64]:
    """Center, direction and radius squared (..., 7) of the blade of a Circle (IPNS) or a PointPair (OPNS), any weight.

    Both are w (c^u + e0^u + (c.u) e0^ei + ((c.u) c - u (c^2 + s r^2)/2) ^ ei), s = -1 for the circle, 1 for the pair.
    """
    e0 = -null_coefficients(blade, "e10", "e20", "e30")
    ei = null_coefficients(blade, "e1i", "e2i", "e3i")
    e23, e13, e12, e0i = (blade.null(n) for n in ("e23", "e13", "e12", "e0i"))
    weight = length(e0)
    refuse(weight <= 1e-14 * np.abs(blade.coefficients).max(-1), f"this blade has no direction: no {kind.__name__}",
           "blade", "flat entities have types of their own")  # fmt: skip
    u, w = e0 / weight[..., None], weight[..., None]
    along = e0i[..., None] / w
    moment = np.stack([e23, -e13, e12], axis=-1) / w  # c x u
    center = along * u + cross(u, moment)
    total = 2.0 * (along[..., 0] ** 2 - np.sum(ei * u, axis=-1) / weight)  # c^2 + s r^2
    square = total - np.sum(center * center, axis=-1)
    out = np.concatenate([center, u, (square if kind is not Circle else -square)[..., None]], axis=-1)
    value = kind._wrap(out)
    same_blade(blade, value.as_ipns() if kind is Circle else value.as_opns(), kind.__name__)
    return out
