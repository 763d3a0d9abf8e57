"""Ball, capsule and ellipsoid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..numeric import float_array
from ._base import Floats, Shape, number, points_of, private, rotation_matrix, set_fields


@dataclass(frozen=True, slots=True, eq=False)
class Ball(Shape):
    """All points within `radius` (m) of `center` (n,), in any dimension n >= 2."""

    center: Floats
    radius: float
    name: str = ""

    def __post_init__(self) -> None:
        set_fields(self, center=private(self.center, "Ball.center"), radius=number(self.radius, "Ball.radius"))
        if len(self.center) < 2:
            raise InputError(f"expected at least 2 coordinates, got {len(self.center)}", place="Ball.center")

    @property
    def dimension(self) -> int:
        """Number of coordinates of the centre."""
        return len(self.center)

    def signed_distance(self, points: ArrayLike) -> Floats:
        """|x - center| - radius."""
        return np.linalg.norm(points_of(points, self.dimension) - self.center, axis=-1) - self.radius

    def bounding_ball(self) -> tuple[Floats, float]:
        """Itself."""
        return self.center, self.radius


@dataclass(frozen=True, slots=True, eq=False)
class Capsule(Shape):
    """All points within `radius` (m) of the segment from `a` to `b` (3,)."""

    a: Floats
    b: Floats
    radius: float
    name: str = ""

    def __post_init__(self) -> None:
        set_fields(
            self,
            a=private(self.a, "Capsule.a", last=3),
            b=private(self.b, "Capsule.b", last=3),
            radius=number(self.radius, "Capsule.radius"),
        )

    def signed_distance(self, points: ArrayLike) -> Floats:
        """Distance to the segment minus the radius."""
        x, u = points_of(points, 3) - self.a, self.b - self.a
        square = u @ u
        t = np.clip(x @ u / square, 0.0, 1.0) if square > 0.0 else np.zeros(x.shape[:-1])
        return np.linalg.norm(x - t[..., None] * u, axis=-1) - self.radius

    def bounding_ball(self) -> tuple[Floats, float]:
        """About the middle."""
        return 0.5 * (self.a + self.b), self.radius + 0.5 * float(np.linalg.norm(self.b - self.a))


@dataclass(frozen=True, slots=True, eq=False)
class Ellipsoid(Shape):
    """The solid with semi-axes (3,) (m) along the columns of `rotation` (3, 3) about `center` (3,)."""

    center: Floats
    semi_axes: Floats
    rotation: Any = None
    name: str = ""

    def __post_init__(self) -> None:
        set_fields(
            self,
            center=private(self.center, "Ellipsoid.center", last=3),
            semi_axes=private(self.semi_axes, "Ellipsoid.semi_axes", last=3),
            rotation=rotation_matrix(self.rotation, "Ellipsoid.rotation"),
        )
        if (self.semi_axes <= 0.0).any():
            raise InputError(f"expected numbers > 0, got {self.semi_axes}", place="Ellipsoid.semi_axes")

    def signed_distance(self, points: ArrayLike) -> Floats:
        """See `ellipsoid_signed_distance`."""
        return ellipsoid_signed_distance((points_of(points, 3) - self.center) @ self.rotation, self.semi_axes)

    def bounding_ball(self) -> tuple[Floats, float]:
        """With the largest semi-axis."""
        return self.center, float(self.semi_axes.max())


def ellipsoid_signed_distance(points: Floats, semi_axes: Floats) -> Floats:
    """Signed distance (...,) of points (..., n), in the ellipsoid's own frame, to sum (p_i / e_i)^2 = 1.

    By the largest root tau of sum (e_i p_i / (tau + e_i^2))^2 = 1, bisected to rounding: the foot of p is
    e_i^2 p_i / (tau + e_i^2). What is returned is the distance to the tangent plane there, n . p - |e n|: for no unit n is that
    above the signed distance, so it errs to the safe side but for rounding. Our derivation, after Lagrange.
    """
    e = float_array(semi_axes, "semi_axes", ndim=1)
    if not (e > 0.0).all() or not len(e):
        raise InputError("expected numbers above 0", place="semi_axes")
    p, least = np.abs(float_array(points, "points", last=len(e))), float(e.min())
    gaps = (e - least) * (e + least)
    # mu = tau + least^2 keeps its digits where a point lies near the focal set
    low = np.maximum((e * p - gaps).max(axis=-1), 0.0)
    high = np.linalg.norm(e * p, axis=-1)
    for _ in range(100):
        mu = 0.5 * (low + high)
        below = np.maximum(mu[..., None] + gaps, 1e-300)
        outside = ((e * p / below) ** 2).sum(axis=-1) > 1.0
        low, high = np.where(outside, mu, low), np.where(outside, high, mu)
    ratio = p / np.maximum(high[..., None] + gaps, 1e-300)
    rest = np.maximum(1.0 - ((e * ratio) ** 2).sum(axis=-1), 0.0)
    # between the foci the feet leave the plane of symmetry across the least axis
    ratio[..., int(e.argmin())] += np.where(high < 1e-14 * least**2, np.sqrt(rest) / least, 0.0)
    normal = ratio / np.linalg.norm(ratio, axis=-1, keepdims=True)
    return (normal * p).sum(axis=-1) - np.linalg.norm(e * normal, axis=-1)
