from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array
from ._function import FunctionStar
from ._star import Star, ellipsoid

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Joukowski:
    """A conformal map of the plane outside an ellipse or aerofoil onto the plane outside a circle.

    q = q0 + e^(i angle) (P + k^2 / P): the shape's plane from the circle's, both read as complex numbers x + i y, metres. The circle
    is |P - mu| = radius. Of the two P of a point q the one further from mu is the outer one; the principal root that [Humanoid] (33)
    prints maps half of the outside into the circle (docs/errata.md). `margin` scales the circle that obstacle avoidance keeps out
    of: it keeps paths off a trailing edge, where the map has no inverse derivative.
    """

    k_squared: complex
    mu: complex
    radius: float
    q0: complex
    angle: float
    margin: float = 1.0
    name: str = field(default="", kw_only=True)

    @classmethod
    def ellipse(
        cls, a: float, b: float, center: ArrayLike = (0.0, 0.0), angle: float = 0.0, *, name: str = ""
    ) -> Joukowski:
        """The ellipse with semi-axis a along direction `angle` (radians) and b across, a < b allowed. [Humanoid] (33), (34)."""
        a, b = _number(a, "a"), _number(b, "b")
        if a < 0.0 or b < 0.0 or a + b == 0.0:
            raise InputError(f"expected semi-axes above 0, got {a:g} and {b:g}", place="a, b")
        return cls((a * a - b * b) / 4.0 + 0j, 0j, 0.5 * (a + b), _point(center), _number(angle, "angle"), name=name)

    @classmethod
    def aerofoil(
        cls,
        k: float,
        mu: complex | ArrayLike,
        center: ArrayLike = (0.0, 0.0),
        angle: float = 0.0,
        *,
        margin: float = 1.05,
        name: str = "",
    ) -> Joukowski:
        """The aerofoil from the circle about `mu` (complex or (2,), real part < 0) through the trailing edge P = k > 0.

        [Humanoid] section VII case (c): the chord is about 4 k long, the imaginary part of mu gives the camber.
        """
        k = _number(k, "k")
        m = complex(mu) if isinstance(mu, complex | float | int | np.number) else _point(mu, "mu")
        if not k > 0.0:
            raise InputError(f"expected k > 0, got {k:g}", place="k")
        if not (np.isfinite(m) and m.real <= 0.0 and m != 0.0):
            raise InputError(f"expected mu with a real part of at most 0 and mu != 0, got {m}", place="mu")
        margin = _number(margin, "margin")
        if margin < 1.0:
            raise InputError(f"expected a margin of at least 1, got {margin:g}", place="margin")
        return cls(k * k + 0j, m, abs(k - m), _point(center), _number(angle, "angle"), margin, name=name)

    @property
    def circle(self) -> tuple[Array, float]:
        """Centre (2,) and radius, margin included, of the circle that stands for the shape in the plane of `to_circle`."""
        return np.array([self.mu.real, self.mu.imag]), self.margin * self.radius

    def to_circle(self, q: ArrayLike) -> Array:
        """The images p (..., 2) of points q (..., 2); for points of the inside, the root further from the circle's centre."""
        return _pairs(self._to_circle(_complex(q, "q")))

    def from_circle(self, p: ArrayLike) -> Array:
        """The points q (..., 2) of the shape's plane whose images are p (..., 2)."""
        P = _complex(p, "p")
        return _pairs(self.q0 + np.exp(1j * self.angle) * (P + self.k_squared / P))

    def derivative(self, p: ArrayLike) -> Array:
        """dq/dp as a complex number (real, imaginary) (..., 2) at circle-plane points p; 0 at the images of foci and edges."""
        return _pairs(self._derivative(_complex(p, "p")))

    def contains(self, q: ArrayLike, margin: float = 1.0) -> NDArray[np.bool_]:
        """True (...) for points q (..., 2) inside the shape or on it; with `margin` for what is kept out of."""
        return np.abs(self._to_circle(_complex(q, "q")) - self.mu) <= margin * self.radius * (1.0 + 1e-14)

    def boundary(self, count: int = 400, margin: float = 1.0) -> Array:
        """Points (count, 2) of the shape's outline; with `margin` the outline that is kept out of."""
        P = self.mu + margin * self.radius * np.exp(2j * np.pi * np.arange(count) / count)
        return _pairs(self.q0 + np.exp(1j * self.angle) * (P + self.k_squared / P))

    def distance(self, x: ArrayLike, margin: float = 1.0) -> Array:
        """Distance (...) of points (..., 2) to the outline (a polygon of 1,000 corners), metres; negative inside."""
        q = _complex(x, "x")
        a = _complex(self.boundary(1000, margin), "outline")
        edge = np.roll(a, -1) - a
        flat = q.reshape(-1, 1)
        t = np.clip(((flat - a) * np.conj(edge)).real / np.abs(edge) ** 2, 0.0, 1.0)
        near = np.abs(flat - a - t * edge).min(axis=1).reshape(q.shape)
        return np.where(self.contains(_pairs(q), margin), -near, near)

    def grown(self, margin: float) -> Joukowski:
        """The same map with the circle scaled so far that its outline keeps `margin` metres from this shape's own."""
        if margin <= 0.0:
            return self
        low, high = self.margin, self.margin + 1.0
        while self.distance(self.boundary(400, high)).min() < margin:
            high = 2.0 * high
        while high - low > 1e-4:
            middle = 0.5 * (low + high)
            if self.distance(self.boundary(400, middle)).min() < margin:
                low = middle
            else:
                high = middle
        return replace(self, margin=1.001 * high)

    def as_star(self, margin: float = 0.0) -> Star:
        """What is kept out of, as a star-shaped body for the shell map. Raises InputError where it is no star."""
        if self.mu == 0.0 and self.margin == 1.0:
            focal = self.k_squared.real / self.radius
            half = np.array([self.radius + focal, self.radius - focal])
            c, s = np.cos(self.angle), np.sin(self.angle)
            return ellipsoid(_pairs(self.q0), half, [[c, -s], [s, c]], name=self.name).grown(margin)
        shape = self.grown(margin)
        outline = _complex(shape.boundary(2000, shape.margin), "outline")
        center = complex(outline.mean())
        turn = np.angle(np.roll(outline - center, -1) / (outline - center))
        if (turn <= 0.0).any():
            raise InputError(
                "the aerofoil is not star-shaped about its middle", place=self.name or "Joukowski", remedy="less camber"
            )
        reach, limit = float(np.abs(outline - center).max()), shape.margin * shape.radius

        def radial(u: Array) -> Array:
            way = u[..., 0] + 1j * u[..., 1]
            low, high = np.zeros(way.shape), np.full(way.shape, 1.01 * reach)
            for _ in range(55):
                middle = 0.5 * (low + high)
                out = np.abs(shape._to_circle(center + middle * way) - shape.mu) > limit
                low, high = np.where(out, low, middle), np.where(out, middle, high)
            return 0.5 * (low + high)

        return FunctionStar(_pairs(center), radial, name=self.name)

    def _to_circle(self, q: NDArray[np.complex128]) -> NDArray[np.complex128]:
        Q = np.exp(-1j * self.angle) * (q - self.q0)
        # the two roots of P^2 - Q P + k^2: the larger by the half-sum without cancellation, the other by their product
        root = np.sqrt(0.25 * Q * Q - self.k_squared)
        root = np.where((np.conj(Q) * root).real < 0.0, -root, root)
        large = 0.5 * Q + root
        small = np.divide(self.k_squared, large, out=np.zeros_like(large), where=large != 0.0)
        return np.where(np.abs(large - self.mu) >= np.abs(small - self.mu), large, small)

    def _derivative(self, P: NDArray[np.complex128]) -> NDArray[np.complex128]:
        return np.exp(1j * self.angle) * (1.0 - self.k_squared / (P * P))

    # what a field needs of a map, as for ShellMap
    def to_balls(self, x: ArrayLike) -> Array:
        return self.to_circle(x)

    def from_balls(self, z: ArrayLike) -> Array:
        return self.from_circle(z)

    def pull_velocity(self, x: Array, e: Array) -> Array:
        """dq/dp times e: the velocity at x whose image is e."""
        slope = self._derivative(self._to_circle(_complex(x, "x")))
        return _pairs(slope * _complex(e, "e"))

    def pull_gradient(self, x: Array, g: Array) -> Array:
        """The conjugate of dp/dq times g: the gradient at x of a function whose gradient at the image is g."""
        slope = self._derivative(self._to_circle(_complex(x, "x")))
        inverse = np.divide(1.0, slope, out=np.zeros_like(slope), where=slope != 0.0)
        return _pairs(np.conj(inverse) * _complex(g, "g"))


def _number(value, name: str) -> float:
    return float(float_array(value, name, ndim=0))


def _point(value, name: str = "center") -> complex:
    x = float_array(value, name, last=2, ndim=1)
    return complex(x[0], x[1])


def _complex(value, name: str) -> NDArray[np.complex128]:
    x = float_array(value, name, last=2)
    return x[..., 0] + 1j * x[..., 1]


def _pairs(z) -> Array:
    return np.stack([np.real(z), np.imag(z)], axis=-1)
