from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array, number
from ._cells import extreme_radii
from ._directions import directions, unit

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Star(ABC):
    """A body of R^n star-shaped about `center` (n,) metres: the points center + r u with r <= radial(u), u a unit vector.

    `slack` is the most by which the body may reach beyond what it encloses, metres. Final classes give `gauge` or `radial`.
    """

    center: Array
    name: str = field(default="", kw_only=True)
    slack: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        center = float_array(self.center, "center", ndim=1)
        if len(center) < 2:
            raise InputError(f"expected a centre in R^n with n >= 2, got {len(center)} coordinate", place="center")
        object.__setattr__(self, "center", center)

    @property
    def dimension(self) -> int:
        return len(self.center)

    @abstractmethod
    def radial(self, u: Array) -> tuple[Array, Array]:
        """r (...) and its gradient (..., n) on the unit sphere (a tangent vector) at unit directions u (..., n)."""

    @abstractmethod
    def support(self, w: Array) -> Array:
        """An upper bound of the largest w . (x - center) over the body, for directions w (..., n)."""

    @abstractmethod
    def grown(self, margin: float) -> Star:
        """A star that holds every point within `margin` metres of this one."""

    @property
    def convex(self) -> bool:
        return True

    @property
    def pieces(self) -> tuple[Star, ...]:
        """Convex stars that hold this one between them; empty where none are known."""
        return (self,) if self.convex else ()

    @property
    def proven(self) -> bool:
        """True where all bounds of this star are proven, False where one of them was sampled."""
        return True

    @cached_property
    def inner(self) -> float:
        """A radius whose ball about the centre lies inside."""
        return extreme_radii(self)[0]

    @cached_property
    def outer(self) -> float:
        """A radius whose ball about the centre holds the body."""
        return extreme_radii(self)[1]

    @property
    def kernel(self) -> float:
        """The radius of a ball about the centre from every point of which the star is seen whole."""
        return self.inner

    @property
    def steepness(self) -> float:
        """A bound of the gradient of r on the unit sphere, metres: no tangent plane comes nearer to the centre than `kernel`."""
        return self.outer * float(np.sqrt(max((self.outer / self.kernel) ** 2 - 1.0, 0.0)))

    def distance(self, x: Array) -> Array:
        """A lower bound (...) of the distance of points x (..., n), metres; negative inside.

        Convex: the tangent plane at the boundary point on the ray, exact to first order. Else (r / r_i - 1) times `kernel`: r / r_i
        changes by at most 1 / `kernel` a metre.
        """
        u, r = unit(np.asarray(x, dtype=np.float64) - self.center)
        edge, slope = self.radial(u)
        if self.convex:
            return (r - edge) / np.sqrt(1.0 + (slope**2).sum(axis=-1) / edge**2)
        return (r / edge - 1.0) * self.kernel

    def level(self, x: Array) -> Array:
        """Distance beyond the boundary along the ray from the centre, metres; negative inside."""
        u, r = unit(np.asarray(x) - self.center)
        return r - self.radial(u)[0]

    def contains(self, x: Array) -> NDArray[np.bool_]:
        return self.level(x) <= 0.0


@dataclass(frozen=True, eq=False)
class NormStar(Star):
    """The unit ball of a norm: |x| = (sum over groups of (sum over rows of |w . x|^inner_power)^(outer/inner))^(1/outer).

    `rows` (n, n) invertible, row k belongs to the group `groups[k]`; `inner_powers` one a group. Balls, ellipsoids, superquadrics,
    smoothed boxes and cylinders in any dimension. Powers of at least 2 (the field needs a continuous second derivative).
    """

    rows: Array
    groups: tuple[int, ...]
    inner_powers: tuple[float, ...]
    outer_power: float

    def __post_init__(self) -> None:
        super().__post_init__()
        powers = (*self.inner_powers, self.outer_power)
        if min(powers) < 1.25:
            raise InputError(f"expected powers of at least 1.25, got {min(powers):g}", place="power")

    def _norm(self, x: Array, rows: Array, inner: tuple[float, ...], outer: float) -> tuple[Array, Array]:
        """The norm of x and its gradient; scaled by the largest entry, so that high powers neither overflow nor vanish."""
        a = x @ rows.T
        top = np.abs(a).max(axis=-1, keepdims=True)
        a = a / np.where(top > 0.0, top, 1.0)
        total = np.zeros(a.shape[:-1])
        slope = np.zeros_like(a)
        for g, p in enumerate(inner):
            of = [k for k, h in enumerate(self.groups) if h == g]
            b = np.abs(a[..., of])
            v = (b**p).sum(axis=-1) ** (1.0 / p)
            total += v**outer
            safe = np.where(v > 0.0, v, 1.0)[..., None]
            slope[..., of] = np.sign(a[..., of]) * (b / safe) ** (p - 1.0) * safe ** (outer - 1.0)
        size = total ** (1.0 / outer)
        slope /= np.where(size > 0.0, size, 1.0)[..., None] ** (outer - 1.0)
        return size * top[..., 0], slope @ rows

    def radial(self, u: Array) -> tuple[Array, Array]:
        size, slope = self._norm(u, self.rows, self.inner_powers, self.outer_power)
        slope = slope - (slope * u).sum(axis=-1, keepdims=True) * u
        return 1.0 / size, -slope / size[..., None] ** 2

    def support(self, w: Array) -> Array:
        dual = tuple(p / (p - 1.0) for p in self.inner_powers)
        rows = np.asarray(np.linalg.inv(self.rows).T, dtype=np.float64)
        return self._norm(np.asarray(w), rows, dual, self.outer_power / (self.outer_power - 1.0))[0]

    @property
    def _widths(self) -> tuple[float, float]:
        return tuple(1.0 / np.linalg.svd(self.rows, compute_uv=False)[[0, -1]])

    @property
    def _equivalence(self) -> float:
        """The most by which the norm can exceed, or fall below, the Euclidean norm of rows @ x."""
        n, powers = self.dimension, (*self.inner_powers, self.outer_power)
        return float(np.prod([max(1.0, n ** abs(1.0 / p - 0.5)) for p in powers if p != 2.0]))

    @property
    def inner(self) -> float:
        """The least radius: exact for ellipsoids and for powers of at least 2 (attained on an axis of `rows`), else a bound."""
        if min(*self.inner_powers, self.outer_power) >= 2.0:
            return self._widths[0]
        return self._widths[0] / self._equivalence

    @property
    def outer(self) -> float:
        return self._widths[1] * self._equivalence

    def grown(self, margin: float) -> NormStar:
        """The body of the same kind with semi-axes b in place of a that holds the sum of the body and a ball of radius m.

        Supports, q dual to p >= 2: |a w|_q + m |w|_2 <= |b w|_q for b^q = a^q / t^(q-1) + m^q / (1-t)^(q-1), any t in (0, 1), by
        convexity and |w|_2 <= |w|_q; t is the best of a grid. Exact for boxes (p = infinity).
        """
        if margin == 0.0:
            return self
        a = 1.0 / np.linalg.norm(self.rows, axis=1)
        best = a * (1.0 + margin / self.inner)
        q = self.outer_power / (self.outer_power - 1.0)
        inner = [self.inner_powers[g] / (self.inner_powers[g] - 1.0) for g in self.groups]
        uniform = all(np.ptp(a[[h == g for h in self.groups]]) < 1e-12 * a.max() for g in self.groups)
        if min(*self.inner_powers, self.outer_power) >= 2.0 and (uniform or all(q >= i for i in inner)):
            for t in np.linspace(0.02, 0.98, 97):
                alpha, beta = t ** (1.0 - q), (1.0 - t) ** (1.0 - q)
                i = np.full(len(a), q) if uniform else np.array(inner)
                b = (alpha ** (i / q) * a**i + beta ** (i / q) * margin**i) ** (1.0 / i)
                if (b - a).max() < (best - a).max():
                    best = b
        rows = self.rows * (a / best)[:, None]
        star = NormStar(self.center, rows, self.groups, self.inner_powers, self.outer_power, name=self.name)
        w = directions(self.dimension)
        slack = self.slack + float((star.support(w) - self.support(w)).max()) - margin
        object.__setattr__(star, "slack", slack)
        return star


def _axes(rotation, n: int) -> Array:
    """Rows = body axes in the world, from a rotation matrix whose columns are the body axes."""
    if rotation is None:
        return np.eye(n)
    matrix = float_array(rotation, "rotation", last=n, ndim=2)
    if matrix.shape != (n, n) or not np.allclose(matrix @ matrix.T, np.eye(n), atol=1e-8):
        raise InputError(f"expected an orthogonal {n} x {n} matrix", place="rotation")
    return matrix.T


def _lengths(value, name: str, n: int | None = None) -> Array:
    lengths = float_array(value, name, ndim=1, last=n)
    if (lengths <= 0.0).any():
        raise InputError(f"expected lengths above 0, got {lengths.min():g}", place=name)
    return lengths


def ellipsoid(center, semi_axes, rotation=None, *, name: str = "") -> NormStar:
    """The ellipsoid (ellipse in the plane) with `semi_axes` (n,) metres along the columns of `rotation` (n, n)."""
    a = _lengths(semi_axes, "semi_axes")
    rows = _axes(rotation, len(a)) / a[:, None]
    return NormStar(float_array(center, "center", last=len(a)), rows, (0,) * len(a), (2.0,), 2.0, name=name)


def superquadric(center, semi_axes, power: float = 4.0, rotation=None, *, name: str = "") -> NormStar:
    """The body sum |x_k / a_k|^power <= 1 in R^n; power 2 is the ellipsoid, high powers approach the box."""
    a = _lengths(semi_axes, "semi_axes")
    rows = _axes(rotation, len(a)) / a[:, None]
    return NormStar(
        float_array(center, "center", last=len(a)),
        rows,
        tuple(range(len(a))),
        (2.0,) * len(a),
        number(power, "power"),
        name=name,
    )


def smooth_box(center, half_sizes, rotation=None, *, slack: float = 0.05, name: str = "") -> NormStar:
    """A superquadric around the box: its corners lie on it, its faces stand out by the fraction `slack` of the half sizes."""
    a = _lengths(half_sizes, "half_sizes")
    power = _power(len(a), slack)
    star = superquadric(center, a * (1.0 + slack), power, rotation, name=name)
    return NormStar(
        star.center, star.rows, star.groups, star.inner_powers, power, name=name, slack=slack * float(a.max())
    )


def smooth_cylinder(a, b, radius: float, *, slack: float = 0.05, name: str = "") -> NormStar:
    """A body around the cylinder with axis from a to b (3,): its rims lie on it, side and caps stand out by the fraction `slack`."""
    a, b = float_array(a, "a", last=3, ndim=1), float_array(b, "b", last=3, ndim=1)
    half = 0.5 * float(np.linalg.norm(b - a))
    radius = float(_lengths([radius], "radius")[0])
    if half == 0.0:
        raise InputError("the two ends of the axis coincide", place="a, b")
    axis = (b - a) / (2.0 * half)
    across = np.linalg.svd(axis[None])[2][1:]
    rows = np.vstack([across / radius, axis / half]) / (1.0 + slack)
    return NormStar(
        0.5 * (a + b), rows, (0, 0, 1), (2.0, 2.0), _power(2, slack), name=name, slack=slack * max(half, radius)
    )


def _power(count: int, slack: float) -> float:
    """The power p with count^(1/p) = 1 + slack."""
    if not 0.0 < slack <= 0.4:
        raise InputError(f"expected a fraction in (0, 0.4], got {slack:g}", place="slack")
    return max(2.0, float(np.log(count) / np.log1p(slack)))
