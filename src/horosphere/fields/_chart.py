"""What stands between the robot's space and the space of balls: nothing, the shell map, or one Joukowski map."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..maps import Joukowski, ShellMap

Array = NDArray[np.float64]


class Chart(Protocol):
    """A diffeomorphism from the free space onto the outside of balls; x, z (b, n)."""

    def to_balls(self, x: Array) -> Array: ...

    def from_balls(self, z: Array) -> Array: ...

    def pull_velocity(self, x: Array, e: Array) -> Array: ...

    def pull_gradient(self, x: Array, g: Array) -> Array: ...

    def distance(self, x: Array) -> Array:
        """A lower bound (b,) of the distance to the mapped obstacles, metres."""
        ...


@dataclass(frozen=True, eq=False)
class Identity:
    """No obstacle but balls."""

    def to_balls(self, x: Array) -> Array:
        return x

    def from_balls(self, z: Array) -> Array:
        return z

    def pull_velocity(self, x: Array, e: Array) -> Array:
        return e

    def pull_gradient(self, x: Array, g: Array) -> Array:
        return g

    def distance(self, x: Array) -> Array:
        return np.full(len(x), np.inf)


@dataclass(frozen=True, eq=False)
class Shells(ShellMap):
    """The shell map with the distance to its stars."""

    def distance(self, x: Array) -> Array:
        return np.min([star.distance(x) for star in self.stars], axis=0)


@dataclass(frozen=True, eq=False)
class Conformal:
    """One Joukowski shape; its circle, margin included, is the only obstacle."""

    shape: Joukowski

    def to_balls(self, x: Array) -> Array:
        return self.shape.to_circle(x)

    def from_balls(self, z: Array) -> Array:
        return self.shape.from_circle(z)

    def pull_velocity(self, x: Array, e: Array) -> Array:
        return self.shape.pull_velocity(x, e)

    def pull_gradient(self, x: Array, g: Array) -> Array:
        return self.shape.pull_gradient(x, g)

    def distance(self, x: Array) -> Array:
        return self.shape.distance(x, self.shape.margin)
