from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array
from ._cells import extreme_radii
from ._directions import unit
from ._star import Star, _power

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SeenFrom(Star):
    """A star `part` seen from another point of its inside; of its kernel where it is not convex."""

    part: Star

    def radial(self, u: Array) -> tuple[Array, Array]:
        shift = self.center - self.part.center
        low = np.zeros(u.shape[:-1])
        high = np.full(u.shape[:-1], self.part.outer + float(np.linalg.norm(shift)))
        for _ in range(60):
            middle = 0.5 * (low + high)
            v, r = unit(shift + middle[..., None] * u)
            out = r > self.part.radial(v)[0]
            low, high = np.where(out, low, middle), np.where(out, middle, high)
        t = 0.5 * (low + high)
        v, r = unit(shift + t[..., None] * u)
        size, slope = self.part.radial(v)
        normal = v / size[..., None] - slope / (size**2)[..., None]
        along = (normal * u).sum(axis=-1, keepdims=True)
        return t, -t[..., None] * (normal - along * u) / along

    def support(self, w: Array) -> Array:
        return self.part.support(w) - np.asarray(w) @ (self.center - self.part.center)

    @property
    def kernel(self) -> float:
        if not self.part.convex:
            return self.part.kernel - float(np.linalg.norm(self.center - self.part.center))
        u, r = unit(self.center - self.part.center)
        return (1.0 - float(r / self.part.radial(u[None])[0][0])) * self.part.inner

    @cached_property
    def inner(self) -> float:
        return max(extreme_radii(self)[0], self.kernel)

    @property
    def outer(self) -> float:
        return self.part.outer + float(np.linalg.norm(self.center - self.part.center))

    @property
    def convex(self) -> bool:
        return self.part.convex

    @property
    def proven(self) -> bool:
        return self.part.proven

    def grown(self, margin: float) -> Star:
        return SeenFrom(self.center, self.part.grown(margin), name=self.name, slack=self.part.grown(margin).slack)


@dataclass(frozen=True, eq=False)
class Scaled(Star):
    """A star `part` made larger about its centre by a factor."""

    part: Star
    factor: float

    def radial(self, u: Array) -> tuple[Array, Array]:
        r, slope = self.part.radial(u)
        return self.factor * r, self.factor * slope

    def support(self, w: Array) -> Array:
        return self.factor * self.part.support(w)

    @property
    def inner(self) -> float:
        return self.factor * self.part.inner

    @property
    def outer(self) -> float:
        return self.factor * self.part.outer

    @property
    def kernel(self) -> float:
        return self.factor * self.part.kernel

    def grown(self, margin: float) -> Scaled:
        return Scaled(self.center, self.part.grown(margin / self.factor), self.factor, name=self.name, slack=self.slack)

    @property
    def convex(self) -> bool:
        return self.part.convex

    @property
    def proven(self) -> bool:
        return self.part.proven


@dataclass(frozen=True, eq=False)
class UnionStar(Star):
    """The smoothed union of `parts` about one centre: r = (sum r_k^power)^(1/power), never below the largest r_k."""

    parts: tuple[Star, ...]
    power: float

    def radial(self, u: Array) -> tuple[Array, Array]:
        pairs = [part.radial(u) for part in self.parts]
        r = np.stack([p[0] for p in pairs])
        top = r.max(axis=0)
        share = (r / top) ** (self.power - 1.0)
        total = (share * r / top).sum(axis=0) ** (1.0 / self.power)
        slope = sum(w[..., None] * p[1] for w, p in zip(share, pairs))
        return top * total, slope * (total ** (1.0 - self.power))[..., None]

    @property
    def _fraction(self) -> float:
        return len(self.parts) ** (1.0 / self.power)

    def support(self, w: Array) -> Array:
        return self._fraction * np.max([part.support(w) for part in self.parts], axis=0)

    @property
    def inner(self) -> float:
        return max(part.inner for part in self.parts)

    @property
    def outer(self) -> float:
        return self._fraction * max(part.outer for part in self.parts)

    @property
    def pieces(self) -> tuple[Star, ...]:
        if not all(part.convex for part in self.parts):
            return ()
        return tuple(Scaled(self.center, part, self._fraction) for part in self.parts)

    @property
    def kernel(self) -> float:
        """A ball in all of the parts' kernels is one of their union's."""
        return min(part.kernel for part in self.parts)

    @property
    def steepness(self) -> float:
        """r is a power mean: its gradient is at most the sum of the parts' with weights (r_k / r)^(power - 1)."""
        return self._fraction * max(part.steepness for part in self.parts)

    @property
    def proven(self) -> bool:
        return all(part.proven for part in self.parts)

    @property
    def convex(self) -> bool:
        return False

    def grown(self, margin: float) -> UnionStar:
        return UnionStar(
            self.center, tuple(part.grown(margin) for part in self.parts), self.power, name=self.name, slack=self.slack
        )


def union(parts: Sequence[Star], center=None, *, slack: float = 0.05, name: str = "") -> Star:
    """One smooth star around overlapping `parts` that share an inner point (`center`, by default the deepest found).

    Where a part is not convex the point must lie in its kernel, the ball about its centre from which it is seen whole. `slack` is the
    fraction by which the creases may be filled out. Raises InputError where no common point exists.
    """
    parts = _stars(parts)
    c = common_point(parts) if center is None else float_array(center, "center", ndim=1, last=parts[0].dimension)
    if c is None or _gauges(parts, c).max() >= 1.0:
        raise InputError(
            f"the {len(parts)} parts have no common inner point",
            place="parts",
            remedy="leave out parts or use convex_hull",
        )
    seen = tuple(_seen(part, c) for part in parts)
    if len(seen) == 1:
        return seen[0]
    fraction = slack * max(part.outer for part in seen)
    return UnionStar(c, seen, _power(len(seen), slack), name=name, slack=fraction + max(part.slack for part in parts))


def _stars(parts: Any) -> list[Star]:
    """At least one star, all in the same space."""
    found = list(parts) if isinstance(parts, Iterable) else [parts]
    if not found:
        raise InputError("a union needs at least one part", place="parts")
    for k, part in enumerate(found):
        if not isinstance(part, Star):
            raise InputError(f"expected a star, got {type(part).__name__}", place=f"parts[{k}]")
        if part.dimension != found[0].dimension:
            raise InputError(
                f"expected R^{found[0].dimension} as the first, got R^{part.dimension}", place=f"parts[{k}]"
            )
    return found


def _seen(part: Star, center: Array) -> Star:
    if np.array_equal(part.center, center):
        return part
    return SeenFrom(center, part, name=part.name, slack=part.slack)


def common_point(parts: Sequence[Star]) -> Array | None:
    """A point deep inside all of the `parts`, of their kernels where they are not convex; None where none was found."""
    from scipy.optimize import minimize

    parts = _stars(parts)
    x0 = np.mean([part.center for part in parts], axis=0)

    def gauges(x: Array) -> Array:
        return _gauges(parts, x)

    n = len(x0)
    result = minimize(
        lambda z: z[n],
        np.r_[x0, gauges(x0).max()],
        jac=lambda z: np.r_[np.zeros(n), 1.0],
        constraints={"type": "ineq", "fun": lambda z: z[n] - gauges(z[:n])},
        method="SLSQP",
        options={"maxiter": 200, "ftol": 1e-10},
    )
    best = min((x0, result.x[:n]), key=lambda x: gauges(x).max())
    return best if gauges(best).max() < 1.0 - 1e-6 else None


def _gauges(parts: Sequence[Star], x: Array) -> Array:
    """For every part how far out x is: 1 on the boundary, of the kernel where the part is not convex."""
    values = []
    for part in parts:
        u, r = unit(x - part.center)
        values.append(r / (float(part.radial(u[None])[0][0]) if part.convex else part.kernel))
    return np.array(values)
