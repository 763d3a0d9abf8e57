from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra import Multivector
from ..algebra._format import number, vector
from ..errors import InputError
from ..numeric import float_array
from . import _kernels as k
from ._build import EPS, blade_of, cross, length, non_negative, null_coefficients, refuse, together, vectors
from ._entity import Entity


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Sphere(Entity):
    """Sphere P(center) - radius^2/2 ei [Humanoid, eq 4]; `array` (..., 4) = (center, radius^2), negative: imaginary."""

    SIZE: ClassVar[int] = 4

    @classmethod
    def from_center_radius(cls, center: ArrayLike, radius: ArrayLike) -> Self:
        """From center (..., 3) and radius (...), metres. Raises InputError for a negative radius."""
        return cls.from_center_radius_squared(center, non_negative(radius, "radius") ** 2)

    @classmethod
    def from_center_radius_squared(cls, center: ArrayLike, radius_squared: ArrayLike) -> Self:
        """From center (..., 3) and squared radius (...); a negative one gives an imaginary sphere."""
        (c,) = vectors((center, "center"))
        c, r2 = together([c, float_array(radius_squared, "radius_squared")[..., None]], ["center", "radius"])
        return cls._wrap(np.concatenate([c, r2], axis=-1))

    @classmethod
    def from_points(cls, a: ArrayLike, b: ArrayLike, c: ArrayLike, d: ArrayLike) -> Self:
        """Through four points (..., 3). Raises InputError when they lie in one plane to rounding of coordinates."""
        p = vectors((a, "a"), (b, "b"), (c, "c"), (d, "d"))
        edges = [x - p[0] for x in p[1:]]
        volume = np.abs(np.sum(edges[0] * cross(edges[1], edges[2]), axis=-1))
        sizes = np.sort(np.stack([length(e) for e in edges]), axis=0)
        scale = np.maximum(np.max(np.abs(np.stack(p)), axis=(0, -1)), sizes[2])
        flat = volume <= 8.0 * EPS * scale * sizes[1] * sizes[2]
        refuse(flat, "a Sphere needs four points that are not in one plane", "points",
               "use Circle or Plane for coplanar points")  # fmt: skip
        return cls._wrap(k.sphere_of_points(*p))

    @property
    def center(self) -> NDArray[np.float64]:
        """(..., 3), metres."""
        return self.array[..., :3].copy()

    @property
    def radius_squared(self) -> NDArray[np.float64]:
        """(...), square metres; negative where imaginary."""
        return self.array[..., 3].copy()

    @property
    def radius(self) -> NDArray[np.float64]:
        """(...), metres; NaN where not real."""
        return real_root(self.array[..., 3])

    @property
    def is_real(self) -> NDArray[np.bool_]:
        return self.array[..., 3] >= 0.0

    def as_ipns(self) -> Multivector:
        c, r2 = self.array[..., :3], self.array[..., 3]
        return Multivector.from_null(
            e1=c[..., 0], e2=c[..., 1], e3=c[..., 2], e0=1.0, ei=0.5 * (np.sum(c * c, axis=-1) - r2)
        )

    @classmethod
    def from_ipns(cls, blade: Multivector) -> Self:
        x = null_coefficients(blade_of(blade, 1, "Sphere"), "e1", "e2", "e3", "e0", "ei")
        if np.any(np.abs(x[..., 3]) <= 1e-14 * np.abs(x).max(-1)):
            raise InputError("this vector has no e0 part: no Sphere", place="blade", remedy="use Plane.from_ipns")
        x = x / x[..., 3:4]
        c = x[..., :3]
        return cls.from_center_radius_squared(c, np.sum(c * c, axis=-1) - 2.0 * x[..., 4])

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points (..., 3) lie inside or on it."""
        x, c = vectors((points, "points"), (self.array[..., :3], "center"))
        return length(x - c) <= np.sqrt(np.maximum(self.array[..., 3], 0.0))

    def _text(self) -> str:
        return f"center={vector(self.array[:3])}, {radius_text(self.array[3])}"


def real_root(square: NDArray[np.float64]) -> NDArray[np.float64]:
    """sqrt where >= 0, NaN where negative, without a warning."""
    return np.where(square >= 0.0, np.sqrt(np.maximum(square, 0.0)), np.nan)[()]


def radius_text(square: float) -> str:
    """`radius=2` or, imaginary, `radius_squared=-4`."""
    return f"radius={number(np.sqrt(square))}" if square >= 0.0 else f"radius_squared={number(square)}, imaginary"
