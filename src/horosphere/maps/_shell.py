from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ._directions import unit
from ._star import Star

Array = NDArray[np.float64]


def fade(t: Array) -> tuple[Array, Array]:
    """The quintic that falls from 1 at t <= 0 to 0 at t >= 1 with two continuous derivatives, and its slope."""
    s = np.clip(t, 0.0, 1.0)
    return 1.0 - s**3 * (10.0 + s * (6.0 * s - 15.0)), -30.0 * s**2 * (1.0 - s) ** 2


@dataclass(frozen=True, eq=False)
class ShellMap:
    """The diffeomorphism of R^n that carries every star to the ball of its `inner` radius and moves nothing outside the shells.

    Within the shell r < r_i(u) + m_i of star i, h(x) = x - (r_i(u) - rho_i) b((r - r_i(u)) / m_i) u, with x = c_i + r u, b the
    quintic `fade`, rho_i <= min r_i, `widths` m_i > 0. Its radial derivative is at least 1, whatever the widths are, as long as
    the shells are disjoint. Our derivation (docs/fields.md).
    """

    stars: tuple[Star, ...]
    widths: tuple[float, ...]
    inner: tuple[float, ...]

    @classmethod
    def of(cls, stars: Sequence[Star], widths: Sequence[float]) -> Self:
        """The map with the stars' own inner radii; `widths` in metres, one a star."""
        if len(stars) != len(widths) or not all(w > 0.0 for w in widths):
            raise InputError(f"expected {len(stars)} shell widths above 0, got {list(widths)}", place="widths")
        return cls(tuple(stars), tuple(float(w) for w in widths), tuple(star.inner for star in stars))

    @cached_property
    def _bounds(self) -> tuple[Array, Array]:
        """Centres (m, n) and squared radii (m,) of balls around the shells."""
        centers = np.array([star.center for star in self.stars])
        return centers, np.array([star.outer + width for star, width in zip(self.stars, self.widths)]) ** 2

    def _shells(self, x: Array):
        """For every shell: the rows of x (b, n) in it, u, r, r_i, grad r_i."""
        centers, reach2 = self._bounds
        within_reach = ((x[:, None] - centers) ** 2).sum(axis=-1) < reach2
        for k in np.flatnonzero(within_reach.any(axis=0)):
            star, width, inner = self.stars[k], self.widths[k], self.inner[k]
            near = np.flatnonzero(within_reach[:, k])
            u, r = unit(x[near] - star.center)
            edge, slope = star.radial(u)
            within = r < edge + width
            if within.any():
                yield near[within], u[within], r[within], edge[within], slope[within], width, inner

    def to_balls(self, x: ArrayLike) -> Array:
        """h(x), points (..., n) metres."""
        array = np.asarray(x, dtype=np.float64)
        flat = array.reshape(-1, array.shape[-1])
        z = flat.copy()
        for rows, u, r, edge, _, width, inner in self._shells(flat):
            z[rows] -= ((edge - inner) * fade((r - edge) / width)[0])[:, None] * u
        return z.reshape(array.shape)

    def from_balls(self, z: ArrayLike) -> Array:
        """The x (..., n) with h(x) = z, for z outside the balls: one monotone equation on the ray, Newton within a bracket."""
        array = np.asarray(z, dtype=np.float64)
        flat = array.reshape(-1, array.shape[-1])
        x = flat.copy()
        for rows, u, r, edge, _, width, inner in self._shells(flat):
            k = (edge - inner) / width
            aim = np.maximum(r - inner, 0.0) / width
            low, high = np.zeros_like(aim), np.ones_like(aim)
            t = np.clip(aim / (1.0 + k), 0.0, 1.0)
            for _ in range(60):
                b, slope = fade(t)
                error = t + k * (1.0 - b) - aim
                low, high = np.where(error < 0.0, t, low), np.where(error < 0.0, high, t)
                trial = t - error / (1.0 - k * slope)
                trial = np.where((trial > low) & (trial < high), trial, 0.5 * (low + high))
                if np.abs(trial - t).max() < 1e-15:
                    break
                t = trial
            x[rows] += (edge + width * t - r)[:, None] * u
        return x.reshape(array.shape)

    def _parts(self, x: Array):
        """alpha (b,), u and w (b, n) with the Jacobian alpha I + u w^T."""
        alpha, at, w = np.ones(len(x)), np.zeros_like(x), np.zeros_like(x)
        for rows, u, r, edge, slope, width, inner in self._shells(x):
            b, db = fade((r - edge) / width)
            pull = (edge - inner) * b
            turn = slope / r[:, None]  # gradient of r_i(u) in x
            grad = b[:, None] * turn + ((edge - inner) * db / width)[:, None] * (u - turn)
            alpha[rows] = 1.0 - pull / r
            at[rows] = u
            w[rows] = (pull / r)[:, None] * u - grad
        return alpha, at, w

    def jacobian(self, x: ArrayLike) -> Array:
        """dh/dx (..., n, n)."""
        array = np.asarray(x, dtype=np.float64)
        n = array.shape[-1]
        alpha, u, w = self._parts(array.reshape(-1, n))
        return (alpha[:, None, None] * np.eye(n) + u[:, :, None] * w[:, None, :]).reshape(*array.shape, n)

    def pull_velocity(self, x: Array, e: Array) -> Array:
        """J^-1 e: the velocity at x (b, n) whose image is e (b, n); Sherman-Morrison, no matrix is built."""
        alpha, u, w = self._parts(x)
        we, wu = (w * e).sum(axis=-1), (w * u).sum(axis=-1)
        return e / alpha[:, None] - u * (we / (alpha * (alpha + wu)))[:, None]

    def pull_gradient(self, x: Array, g: Array) -> Array:
        """J^T g: the gradient at x of a function whose gradient at h(x) is g."""
        alpha, u, w = self._parts(x)
        return alpha[:, None] * g + w * (u * g).sum(axis=-1, keepdims=True)
