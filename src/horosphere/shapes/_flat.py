"""Cylinder, box and half-space: solids with flat faces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ._base import Floats, Shape, number, points_of, private, rotation_matrix, set_fields


@dataclass(frozen=True, slots=True, eq=False)
class Cylinder(Shape):
    """The solid within `radius` (m) of the axis from `a` to `b` (3,), with flat ends at both."""

    a: Floats
    b: Floats
    radius: float
    name: str = ""

    def __post_init__(self) -> None:
        set_fields(
            self,
            a=private(self.a, "Cylinder.a", last=3),
            b=private(self.b, "Cylinder.b", last=3),
            radius=number(self.radius, "Cylinder.radius"),
        )
        if not np.linalg.norm(self.b - self.a) > 1e-12:
            raise InputError(
                "a and b coincide: the axis has no direction", place="Cylinder", remedy="use a Ball for a point"
            )

    def signed_distance(self, points: ArrayLike) -> Floats:
        """In the (radius, height) half plane: to a rectangle."""
        length = np.linalg.norm(self.b - self.a)
        axis = (self.b - self.a) / length
        x = points_of(points, 3) - 0.5 * (self.a + self.b)
        z = x @ axis
        excess = np.stack(
            (np.linalg.norm(x - z[..., None] * axis, axis=-1) - self.radius, np.abs(z) - 0.5 * length), axis=-1
        )
        return np.linalg.norm(np.maximum(excess, 0.0), axis=-1) + np.minimum(excess.max(axis=-1), 0.0)

    def bounding_ball(self) -> tuple[Floats, float]:
        """Through the rims."""
        return 0.5 * (self.a + self.b), float(np.hypot(self.radius, 0.5 * np.linalg.norm(self.b - self.a)))


@dataclass(frozen=True, slots=True, eq=False)
class Box(Shape):
    """The solid with half sizes (3,) (m) along the columns of `rotation` (3, 3) about `center` (3,)."""

    center: Floats
    half_sizes: Floats
    rotation: Any = None
    name: str = ""

    def __post_init__(self) -> None:
        set_fields(
            self,
            center=private(self.center, "Box.center", last=3),
            half_sizes=private(self.half_sizes, "Box.half_sizes", last=3),
            rotation=rotation_matrix(self.rotation, "Box.rotation"),
        )
        if (self.half_sizes < 0.0).any():
            raise InputError(f"expected numbers >= 0, got {self.half_sizes}", place="Box.half_sizes")

    def signed_distance(self, points: ArrayLike) -> Floats:
        """Beyond the faces: the length of the excesses; inside: the nearest face."""
        excess = np.abs((points_of(points, 3) - self.center) @ self.rotation) - self.half_sizes
        return np.linalg.norm(np.maximum(excess, 0.0), axis=-1) + np.minimum(excess.max(axis=-1), 0.0)

    def bounding_ball(self) -> tuple[Floats, float]:
        """Through the corners."""
        return self.center, float(np.linalg.norm(self.half_sizes))


@dataclass(frozen=True, slots=True, eq=False)
class HalfSpace(Shape):
    """All points with normal . x <= distance (m); `normal` (3,) is made a unit vector, and the distance scaled with it."""

    normal: Floats
    distance: float
    name: str = ""

    def __post_init__(self) -> None:
        normal = private(self.normal, "HalfSpace.normal", last=3)
        length = float(np.linalg.norm(normal))
        if not length > 1e-12:
            raise InputError("expected a direction, got the zero vector", place="HalfSpace.normal")
        distance = float(private(self.distance, "HalfSpace.distance", ndim=0))
        # dividing an exact unit vector by a length of 1 + 1e-16 would move the plane for nothing
        exact = abs(length - 1.0) < 1e-15
        set_fields(
            self,
            normal=normal if exact else private(normal / length, "HalfSpace.normal"),
            distance=distance if exact else distance / length,
        )

    def signed_distance(self, points: ArrayLike) -> Floats:
        """normal . x - distance."""
        return points_of(points, 3) @ self.normal - self.distance

    def bounding_ball(self) -> tuple[Floats, float]:
        """None is finite: radius infinity about a point of the plane."""
        return self.normal * self.distance, float("inf")
