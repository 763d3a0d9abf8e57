from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array
from ._directions import directions, unit
from ._star import Star

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FunctionStar(Star):
    """The star with a radial function of the user's: `function`(u (m, n)) -> r (m,) metres, for unit directions u.

    `slope`(u) -> (m, n), the gradient on the sphere, is taken by central differences when absent. Construction tries the function on
    well-spread directions and raises InputError for a wrong shape, NaN, radii not above 0 or a jump.
    """

    function: Callable[[Array], Array]
    slope: Callable[[Array], Array] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        u = directions(self.dimension)
        r = self._radii(u)
        # a continuous function changes little over 1e-6 rad; a jump shows as a huge slope between close directions
        v, _ = unit(u + 1e-6 * np.roll(u, 1, axis=-1))
        step = np.abs(self._radii(v) - r) / (1e-6 * r.max())
        if step.max() > 1e4:
            raise InputError(f"the radial function jumps near direction {u[step.argmax()].round(4)}", place="function")

    def _radii(self, u: Array) -> Array:
        try:
            r = np.asarray(self.function(u), dtype=np.float64)
        except InputError:
            raise
        except Exception as error:
            raise InputError(
                f"the radial function failed on unit directions of shape {u.shape}: {error}", place="function"
            ) from error
        if r.shape != u.shape[:-1]:
            raise InputError(
                f"expected radii of shape {u.shape[:-1]} for directions {u.shape}, got {r.shape}", place="function"
            )
        if not np.isfinite(r).all() or (r <= 0.0).any():
            k = int(np.argmax(~np.isfinite(r) | (r <= 0.0)))
            raise InputError(
                f"expected radii above 0, got {r.flat[k]:g} in direction {u.reshape(-1, u.shape[-1])[k]}",
                place="function",
            )
        return r

    def radial(self, u: Array) -> tuple[Array, Array]:
        flat = np.asarray(u, dtype=np.float64).reshape(-1, self.dimension)
        r = self._radii(flat)
        if self.slope is not None:
            g = np.asarray(self.slope(flat), dtype=np.float64)
        else:
            h = 1e-5
            g = np.empty_like(flat)
            for k in range(self.dimension):
                e = np.zeros(self.dimension)
                e[k] = h
                g[:, k] = (self._radii(unit(flat + e)[0]) - self._radii(unit(flat - e)[0])) / (2.0 * h)
        g = g - (g * flat).sum(axis=-1, keepdims=True) * flat
        return r.reshape(u.shape[:-1]), g.reshape(u.shape)

    def support(self, w: Array) -> Array:
        u = directions(self.dimension)
        return 1.02 * ((np.asarray(w) @ u.T) * self._radii(u)).max(axis=-1)

    @property
    def exact_support(self) -> bool:
        return False

    @property
    def convex(self) -> bool:
        return False

    def grown(self, margin: float) -> FunctionStar:
        """Scaled by 1 + margin / k, k the (sampled) radius of the ball about the centre from which all of the star is seen."""
        if margin == 0.0:
            return self
        factor = 1.0 + margin / self.seen_radius()
        function, slope = self.function, self.slope
        slack = self.slack * factor + (factor - 1.0) * self.outer - margin
        return FunctionStar(
            self.center,
            lambda v: factor * np.asarray(function(v)),
            None if slope is None else lambda v: factor * np.asarray(slope(v)),
            name=self.name,
            slack=slack,
        )


def star(
    center, function: Callable[[Array], Array], slope: Callable[[Array], Array] | None = None, *, name: str = ""
) -> FunctionStar:
    """The star-shaped body center + r u, r <= function(u), in any R^n; see `FunctionStar`."""
    return FunctionStar(float_array(center, "center", ndim=1), function, slope, name=name)


def lobed(center, radius: float, depth: float, lobes: int, phase: float = 0.0, *, name: str = "") -> FunctionStar:
    """The planar star r = radius (1 + depth cos(lobes angle + phase)), 0 <= depth < 1."""
    if not 0.0 <= depth < 1.0 or not radius > 0.0:
        raise InputError(f"expected radius > 0 and 0 <= depth < 1, got {radius:g} and {depth:g}", place="lobed")

    def function(u: Array) -> Array:
        return radius * (1.0 + depth * np.cos(lobes * np.arctan2(u[..., 1], u[..., 0]) + phase))

    def slope(u: Array) -> Array:
        across = -radius * depth * lobes * np.sin(lobes * np.arctan2(u[..., 1], u[..., 0]) + phase)
        return across[..., None] * np.stack([-u[..., 1], u[..., 0]], axis=-1)

    return FunctionStar(float_array(center, "center", ndim=1, last=2), function, slope, name=name)
