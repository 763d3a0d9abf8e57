from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array, number, whole_number
from ._cells import grid
from ._directions import directions, unit
from ._star import Star

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FunctionStar(Star):
    """The star with a radial function of the user's: `function`(u (m, n)) -> r (m,) metres, for unit directions u.

    `slope`(u) -> (m, n), the gradient on the sphere, is taken by central differences when absent. `steepest` bounds its size, metres:
    what is said of the star's size and of gaps is proven with it; without it 1.25 times the steepest sample is taken. Construction
    tries the function on well-spread directions and raises InputError for a wrong shape, NaN, radii not above 0, a jump, or a
    function steeper than stated.
    """

    function: Callable[[Array], Array]
    slope: Callable[[Array], Array] | None = None
    steepest: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        u = directions(self.dimension)
        r = self._radii(u)
        # a continuous function changes little over 1e-6 rad; a jump shows as a huge slope between close directions
        v, _ = unit(u + 1e-6 * np.roll(u, 1, axis=-1))
        step = np.abs(self._radii(v) - r) / (1e-6 * r.max())
        if step.max() > 1e4:
            raise InputError(f"the radial function jumps near direction {u[step.argmax()].round(4)}", place="function")
        found = float(np.linalg.norm(self.radial(u)[1], axis=-1).max())
        if not np.isfinite(found):
            raise InputError("the slope of the radial function is not finite", place="slope")
        if found > 1e3 * r.max():
            k = int(np.linalg.norm(self.radial(u)[1], axis=-1).argmax())
            raise InputError(f"the radial function jumps near direction {u[k].round(4)}", place="function")
        if self.steepest is not None and not found <= self.steepest * (1.0 + 1e-6) + 1e-6 * r.max():
            raise InputError(
                f"the radial function is steeper than stated: {found:.3g} m in one direction", place="steepest"
            )
        object.__setattr__(self, "_steep", 1.25 * found if self.steepest is None else float(self.steepest))
        if not self.inner > 0.0:
            raise InputError(
                f"the radial function is too steep ({self.steepness:.3g} m) for radii from {r.min():.3g} m on to be bounded",
                place="steepest" if self.proven else "function",
            )

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
            if g.shape != flat.shape:
                raise InputError(f"expected slopes of shape {flat.shape}, got {g.shape}", place="slope")
        else:
            h = 1e-5
            g = np.empty_like(flat)
            for k in range(self.dimension):
                e = np.zeros(self.dimension)
                e[k] = h
                g[:, k] = (self._radii(unit(flat + e)[0]) - self._radii(unit(flat - e)[0])) / (2.0 * h)
        g = g - (g * flat).sum(axis=-1, keepdims=True) * flat
        return r.reshape(u.shape[:-1]), g.reshape(u.shape)

    @property
    def steepness(self) -> float:
        return self._steep  # pyright: ignore[reportAttributeAccessIssue]

    @property
    def kernel(self) -> float:
        """From the centre a tangent plane is r^2 / sqrt(r^2 + |grad r|^2) away, which grows with r."""
        return self.inner**2 / float(np.hypot(self.inner, self.steepness))

    @cached_property
    def _outline(self) -> tuple[Array, Array]:
        """Boundary points (k, n) relative to the centre, and how far any boundary point nearby may be from each (k,)."""
        u, angle = grid(self.dimension)
        r, steep = self._radii(u), self.steepness
        return r[:, None] * u, angle * np.hypot(r + steep * angle, steep)

    def support(self, w: Array) -> Array:
        points, reach = self._outline
        w = np.asarray(w, dtype=np.float64)
        return (w @ points.T + reach * np.linalg.norm(w, axis=-1)[..., None]).max(axis=-1)

    @property
    def proven(self) -> bool:
        return self.steepest is not None

    @property
    def convex(self) -> bool:
        return False

    def distance(self, x: Array) -> Array:
        """(r - r_i) / sqrt(1 + (steepness / r_i)^2), a lower bound: on the way to the star the radius is not below r_i."""
        u, r = unit(np.asarray(x, dtype=np.float64) - self.center)
        edge = self._radii(u.reshape(-1, self.dimension)).reshape(r.shape)
        return (r - edge) / np.hypot(1.0, self.steepness / edge)

    def grown(self, margin: float) -> FunctionStar:
        """r + margin sqrt(1 + (steepness / r)^2): what is within `margin` metres of the star is no further out on its ray."""
        if margin == 0.0:
            return self
        steep, function, slope = self.steepness, self.function, self.slope

        def radius(v: Array) -> Array:
            r = np.asarray(function(v), dtype=np.float64)
            return r + margin * np.hypot(1.0, steep / r)

        def gradient(v: Array) -> Array:
            r = np.asarray(function(v), dtype=np.float64)
            return np.asarray(slope(v)) * (1.0 - margin * steep**2 / (r**2 * np.hypot(r, steep)))[..., None]  # pyright: ignore[reportOptionalCall]

        turned = margin * steep**2 / (self.inner**2 * np.hypot(self.inner, steep)) - 1.0
        return FunctionStar(
            self.center,
            radius,
            None if slope is None else gradient,
            None if self.steepest is None else steep * max(1.0, float(turned)),
            name=self.name,
            slack=self.slack + margin * (float(np.hypot(1.0, steep / self.inner)) - 1.0),
        )


def star(
    center,
    function: Callable[[Array], Array],
    slope: Callable[[Array], Array] | None = None,
    *,
    steepest: float | None = None,
    name: str = "",
) -> FunctionStar:
    """The star-shaped body center + r u, r <= function(u), in any R^n; see `FunctionStar`."""
    if not callable(function):
        raise InputError(f"expected a function of directions u (m, n), got {type(function).__name__}", place="function")
    if steepest is not None and number(steepest, "steepest", least=0.0) == np.inf:
        raise InputError("expected a finite number, got inf", place="steepest")
    return FunctionStar(float_array(center, "center", ndim=1), function, slope, steepest, name=name)


def lobed(center, radius: float, depth: float, lobes: int, phase: float = 0.0, *, name: str = "") -> FunctionStar:
    """The planar star r = radius (1 + depth cos(lobes angle + phase)), 0 <= depth < 1."""
    radius, depth = number(radius, "radius", above=0.0), number(depth, "depth", least=0.0)
    lobes, phase = whole_number(lobes, "lobes", 1), number(phase, "phase")
    if not depth < 1.0 or not radius < np.inf:
        raise InputError(f"expected radius > 0 and 0 <= depth < 1, got {radius:g} and {depth:g}", place="lobed")

    def function(u: Array) -> Array:
        return radius * (1.0 + depth * np.cos(lobes * np.arctan2(u[..., 1], u[..., 0]) + phase))

    def slope(u: Array) -> Array:
        across = -radius * depth * lobes * np.sin(lobes * np.arctan2(u[..., 1], u[..., 0]) + phase)
        return across[..., None] * np.stack([-u[..., 1], u[..., 0]], axis=-1)

    return FunctionStar(
        float_array(center, "center", ndim=1, last=2), function, slope, radius * depth * lobes, name=name
    )
