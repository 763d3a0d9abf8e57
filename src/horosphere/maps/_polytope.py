from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array
from ._directions import directions
from ._star import Star, _power

Array = NDArray[np.float64]
MOST_FACETS = 200


@dataclass(frozen=True, eq=False)
class PolytopeStar(Star):
    """A smooth convex body around the polytope normals . (x - center) <= offsets.

    |x| = (sum_k max(0, normals_k . x / offsets_k)^power)^(1/power) / (1 + fraction), with power such that the polytope lies
    inside. `vertices` (v, n) of the polytope, relative to the centre.
    """

    normals: Array
    offsets: Array
    vertices: Array
    power: float
    fraction: float

    def radial(self, u: Array) -> tuple[Array, Array]:
        rows = self.normals / self.offsets[:, None]
        a = np.maximum(u @ rows.T, 0.0)
        top = a.max(axis=-1, keepdims=True)
        b = (a / top) ** (self.power - 1.0)
        total = (b * a / top).sum(axis=-1)
        size = top[..., 0] * total ** (1.0 / self.power)
        slope = (b @ rows) * (total ** (1.0 / self.power - 1.0))[..., None]
        slope -= (slope * u).sum(axis=-1, keepdims=True) * u
        wide = 1.0 + self.fraction
        return wide / size, -slope * (wide / size**2)[..., None]

    def support(self, w: Array) -> Array:
        return (1.0 + self.fraction) * (np.asarray(w) @ self.vertices.T).max(axis=-1)

    @property
    def inner(self) -> float:
        return float(self.offsets.min())

    @property
    def outer(self) -> float:
        return (1.0 + self.fraction) * float(np.linalg.norm(self.vertices, axis=1).max())

    def grown(self, margin: float) -> PolytopeStar:
        if margin == 0.0:
            return self
        star = _from_halfspaces(self.center, self.normals, self.offsets + margin, self.name, self.fraction)
        object.__setattr__(star, "slack", star.slack + self.slack)
        return star


def convex_hull(
    points: ArrayLike, radius: float = 0.0, *, slack: float = 0.05, name: str = "", most_facets: int = MOST_FACETS
) -> PolytopeStar:
    """A smooth body around the convex hull of balls of `radius` about `points` (m, n), metres.

    More than `most_facets` facets, or flat points with a radius, are enclosed by as many half-spaces in well-spread directions.
    `slack` is the fraction by which the smoothing may stand out; the whole of it in metres is the star's `slack`.
    Raises InputError for too few or flat points without a radius.
    """
    x = float_array(points, "points", ndim=2)
    m, n = x.shape
    radius = float(float_array(radius, "radius", ndim=0))
    if m == 0:
        raise InputError("the point set is empty", place="points")
    if radius < 0.0:
        raise InputError(f"expected a radius of at least 0, got {radius:g}", place="radius")
    if n < 2:
        raise InputError(f"expected points in R^n with n >= 2, got n = {n}", place="points")
    from scipy.spatial import ConvexHull, QhullError

    normals = None
    try:
        hull = ConvexHull(x)
        facets = np.unique(np.round(hull.equations[:, :-1], 9), axis=0)
        x = x[hull.vertices]
        if len(facets) <= most_facets:
            normals = facets / np.linalg.norm(facets, axis=1, keepdims=True)
    except (QhullError, ValueError):
        if radius == 0.0:
            raise InputError(
                f"the {m} points are too few or lie flat in R^{n}: their hull has no inside",
                place="points",
                remedy="give a radius",
            ) from None
    if normals is None:
        spread = directions(n, most_facets - 2 * n)
        normals = spread if n > 3 else np.concatenate([spread, np.eye(n), -np.eye(n)])
    offsets = (x @ normals.T).max(axis=0) + radius
    center = _deepest_point(normals, offsets)
    star = _from_halfspaces(center, normals, offsets - normals @ center, name, slack)
    w = directions(n)
    true = ((x - center) @ w.T).max(axis=0) + radius
    object.__setattr__(star, "slack", float((star.support(w) - true).max()))
    return star


def _deepest_point(normals: Array, offsets: Array) -> Array:
    """The centre of the largest ball in normals . x <= offsets."""
    from scipy.optimize import linprog

    n = normals.shape[1]
    result = linprog(
        np.r_[np.zeros(n), -1.0],
        np.column_stack([normals, np.ones(len(normals))]),
        offsets,
        bounds=[(None, None)] * n + [(0, None)],
    )
    if result.x is None or result.x[-1] <= 0.0:
        raise InputError("the half-spaces have no common inside", place="points")
    return result.x[:n]


def _from_halfspaces(center: Array, normals: Array, offsets: Array, name: str, fraction: float) -> PolytopeStar:
    from scipy.spatial import HalfspaceIntersection

    corners = HalfspaceIntersection(np.column_stack([normals, -offsets]), np.zeros(len(center))).intersections
    corners = corners[np.isfinite(corners).all(axis=1)]
    star = PolytopeStar(center, normals, offsets, corners, 2.0, fraction, name=name)
    # few half-spaces meet at a corner: the sum there, not the number of half-spaces, decides the power
    a = np.maximum(corners @ (normals / offsets[:, None]).T, 0.0)
    power = _power(len(normals), fraction)
    low = 2.0
    while power - low > 0.01 * power:
        middle = 0.5 * (low + power)
        if ((a**middle).sum(axis=1) ** (1.0 / middle)).max() <= 1.0 + fraction:
            power = middle
        else:
            low = middle
    object.__setattr__(star, "power", power)
    object.__setattr__(star, "slack", fraction * float(np.linalg.norm(corners, axis=1).max()))
    return star
