from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array
from ._star import Star

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RoundHull(Star):
    """The convex hull of a ball about `center` and a second ball, seen from the centre; a capsule when `mirrored`.

    `tip` (n,) from the centre to the second ball's centre, radii `near` > 0 and `far` > 0, metres. With `mirrored` the second
    ball stands at both ends (near = far). The boundary is C^1.
    """

    tip: Array
    near: float
    far: float
    mirrored: bool = False

    def radial(self, u: Array) -> tuple[Array, Array]:
        length = float(np.linalg.norm(self.tip))
        if length == 0.0 or self.near >= length + self.far:
            r = np.full(u.shape[:-1], max(self.near, self.far))
            return r, np.zeros_like(u)
        a = np.broadcast_to(self.tip / length, u.shape)
        if self.mirrored:
            a = np.where((u @ self.tip < 0.0)[..., None], -a, a)
        c = np.clip((u * a).sum(axis=-1), -1.0, 1.0)
        s = np.sqrt((1.0 - c) * (1.0 + c))
        # cap: the far ball seen from the centre
        root = np.sqrt(np.maximum(self.far**2 - (length * s) ** 2, 0.0))
        r, slope = length * c + root, length + np.divide(length**2 * c, root, out=np.zeros_like(c), where=root > 0.0)
        sine = (self.near - self.far) / length
        if sine > -1.0:  # else the far ball holds the near one
            cosine = np.sqrt(1.0 - sine * sine)
            flank = np.maximum(sine * c + cosine * s, 1e-100)
            cone = self.near / flank
            # on the cone up to its circle of contact with the far ball
            with np.errstate(over="ignore"):
                on_cone = (c > sine) & (cone * c <= length + self.far * sine)
            on_ball = c <= sine
            bend = np.divide(c, s, out=np.zeros_like(c), where=s > 0.0)
            r = np.where(on_ball, self.near, np.where(on_cone, cone, r))
            with np.errstate(over="ignore"):
                slope = np.where(on_ball, 0.0, np.where(on_cone, -self.near / flank**2 * (sine - cosine * bend), slope))
        return r, slope[..., None] * (a - c[..., None] * u)

    def support(self, w: Array) -> Array:
        size, along = np.linalg.norm(w, axis=-1), np.asarray(w) @ self.tip
        if self.mirrored:
            along = np.abs(along)
        return np.maximum(self.near * size, along + self.far * size)

    @property
    def inner(self) -> float:
        length = float(np.linalg.norm(self.tip))
        return max(self.near, self.far - length)

    @property
    def outer(self) -> float:
        return max(self.near, float(np.linalg.norm(self.tip)) + self.far)

    def grown(self, margin: float) -> RoundHull:
        """Exact: both radii grow."""
        return RoundHull(
            self.center,
            self.tip,
            self.near + margin,
            self.far + margin,
            self.mirrored,
            name=self.name,
            slack=self.slack,
        )


def capsule(a, b, radius: float, *, name: str = "") -> RoundHull:
    """All points within `radius` of the segment from a to b, (n,) metres."""
    a = float_array(a, "a", ndim=1)
    b = float_array(b, "b", ndim=1, last=len(a))
    radius = float(float_array(radius, "radius", ndim=0))
    if not radius > 0.0:
        raise InputError(f"expected a radius above 0, got {radius:g}", place="radius")
    return RoundHull(0.5 * (a + b), 0.5 * (b - a), radius, radius, True, name=name)


def ball_seen_from(center, ball_center, radius: float, *, name: str = "") -> RoundHull:
    """The ball as a star about any point `center` strictly inside it."""
    center = float_array(center, "center", ndim=1)
    tip = float_array(ball_center, "ball_center", ndim=1, last=len(center)) - center
    away, radius = float(np.linalg.norm(tip)), float(float_array(radius, "radius", ndim=0))
    if not away < radius:
        raise InputError(f"the point lies {away - radius:.3g} m outside the ball", place="center")
    return RoundHull(center, tip, 0.5 * (radius - away), radius, name=name)
