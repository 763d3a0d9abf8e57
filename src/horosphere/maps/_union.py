from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array
from ._directions import unit
from ._star import Star, _power

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SeenFrom(Star):
    """A convex star `part` seen from another point of its inside."""

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

    def grown(self, margin: float) -> Star:
        return SeenFrom(self.center, self.part.grown(margin), name=self.name, slack=self.part.grown(margin).slack)


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
    def exact_support(self) -> bool:
        return all(part.exact_support for part in self.parts)

    @property
    def convex(self) -> bool:
        return False

    def grown(self, margin: float) -> UnionStar:
        return UnionStar(
            self.center, tuple(part.grown(margin) for part in self.parts), self.power, name=self.name, slack=self.slack
        )


def union(parts: Sequence[Star], center=None, *, slack: float = 0.05, name: str = "") -> Star:
    """One smooth star around overlapping convex `parts` that share an inner point (`center`, by default the deepest found).

    `slack` is the fraction by which the creases may be filled out. Raises InputError where no common point exists.
    """
    parts = list(parts)
    if not parts:
        raise InputError("a union needs at least one part", place="parts")
    c = common_point(parts) if center is None else float_array(center, "center", ndim=1, last=parts[0].dimension)
    if c is None or max(float(part.level(c)) for part in parts) >= 0.0:
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


def _seen(part: Star, center: Array) -> Star:
    if np.array_equal(part.center, center):
        return part
    return SeenFrom(center, part, name=part.name, slack=part.slack)


def common_point(parts: Sequence[Star]) -> Array | None:
    """A point deep inside all of the convex `parts`: least max_k of the gauges; None where there is none."""
    from scipy.optimize import minimize

    x0 = np.mean([part.center for part in parts], axis=0)

    def gauges(x: Array) -> Array:
        values = []
        for part in parts:
            u, r = unit(x - part.center)
            values.append(r / float(part.radial(u)[0]))
        return np.array(values)

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
