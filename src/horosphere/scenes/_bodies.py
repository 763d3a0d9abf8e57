"""Robots that are no arms, and obstacles that are no solids of space: data of the plane and of R^n."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array
from ._targets import frozen_array

Floats = NDArray[np.float64]


def _positive(record: object, *names: str) -> None:
    for name in names:
        value = getattr(record, name)
        if not (np.all(np.isfinite(value)) and np.all(np.asarray(value) > 0.0)):
            raise InputError(f"expected finite numbers > 0, got {value}", place=f"{type(record).__name__}.{name}")


@dataclass(frozen=True, slots=True)
class PointRobot:
    """A ball of `radius` (m) that moves freely in R^`dimension`, with bounded speed (m/s) and acceleration (m/s^2).

    `unit` of its coordinates: "rad" for a configuration space; then every length is meant in radians.
    """

    dimension: int = 2
    radius: float = 0.0
    max_speed: float = 1.0
    max_acceleration: float = 4.0
    name: str = "point"
    unit: str = "m"

    def __post_init__(self) -> None:
        _positive(self, "max_speed", "max_acceleration")
        if self.dimension < 2 or not 0.0 <= self.radius < np.inf:
            raise InputError(
                f"dimension {self.dimension} (at least 2), radius {self.radius} (at least 0)", place="PointRobot"
            )


@dataclass(frozen=True, slots=True)
class UnicycleRobot:
    """A disc of `radius` (m) that drives along its heading: speed, turn rate (rad/s), acceleration bounded."""

    radius: float = 0.1
    max_speed: float = 1.0
    max_turn_rate: float = 2.0
    max_acceleration: float = 4.0
    name: str = "unicycle"

    def __post_init__(self) -> None:
        _positive(self, "max_speed", "max_turn_rate", "max_acceleration")
        if not 0.0 <= self.radius < np.inf:
            raise InputError(f"expected a radius >= 0, got {self.radius}", place="UnicycleRobot")


@dataclass(frozen=True, slots=True, eq=False)
class SnakeRobot:
    """A chain of links (m) in the plane, each with a wheel pair at `wheel_fraction` of its length; `width` (m) of the body."""

    lengths: Floats = field(default_factory=lambda: np.full(6, 2.0))
    wheel_fraction: float = 0.5
    width: float = 0.0
    name: str = "snake"

    def __post_init__(self) -> None:
        object.__setattr__(self, "lengths", frozen_array(self.lengths, "lengths"))
        _positive(self, "lengths")
        if len(self.lengths) < 3:
            raise InputError(f"expected at least 3 links, got {len(self.lengths)}", place="SnakeRobot.lengths")
        if not 0.0 <= self.wheel_fraction <= 1.0:
            raise InputError(
                f"expected a number in [0, 1], got {self.wheel_fraction}", place="SnakeRobot.wheel_fraction"
            )
        if not 0.0 <= self.width < np.inf:
            raise InputError(f"expected a width >= 0, got {self.width}", place="SnakeRobot.width")

    @property
    def links(self) -> int:
        """Number of links; the posture has one relative angle fewer."""
        return len(self.lengths)


@dataclass(frozen=True, slots=True, eq=False)
class EllipsoidND:
    """The solid |diag(1/semi_axes) rotation^T (x - center)| <= 1 in R^n (n other than 3 has no shape of its own)."""

    center: Floats
    semi_axes: Floats
    rotation: Floats | None = None
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", frozen_array(self.center, "center"))
        n = len(self.center)
        object.__setattr__(self, "semi_axes", frozen_array(self.semi_axes, "semi_axes", n))
        _positive(self, "semi_axes")
        rotation = np.array(np.eye(n) if self.rotation is None else float_array(self.rotation, "rotation", n, 2))
        if rotation.shape != (n, n) or np.abs(rotation @ rotation.T - np.eye(n)).max() > 1e-9:
            raise InputError(f"expected an orthogonal ({n}, {n}) matrix", place="EllipsoidND.rotation")
        rotation.setflags(write=False)
        object.__setattr__(self, "rotation", rotation)

    @property
    def angle(self) -> float:
        """In the plane: the direction of the first semi-axis, radians."""
        assert self.rotation is not None
        return float(np.arctan2(self.rotation[1, 0], self.rotation[0, 0]))


@dataclass(frozen=True, slots=True, eq=False)
class Aerofoil:
    """A Joukowski aerofoil of the plane: image of the circle |P - mu| = |k - mu| under P + k^2/P, turned and moved."""

    center: Floats
    k: float
    mu: complex
    angle: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", frozen_array(self.center, "center", 2))
        _positive(self, "k")
        if not np.isfinite([self.mu.real, self.mu.imag, self.angle]).all():
            raise InputError("expected finite numbers", place="Aerofoil")


@dataclass(frozen=True, slots=True, eq=False)
class Star:
    """A lobed disc of the plane: r(phi) <= radius (1 + amplitude cos(lobes (phi - angle))) about `center`."""

    center: Floats
    radius: float
    lobes: int = 5
    amplitude: float = 0.3
    angle: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", frozen_array(self.center, "center", 2))
        _positive(self, "radius")
        if not 0.0 <= self.amplitude < 1.0 or self.lobes < 1:
            raise InputError(
                f"expected 0 <= amplitude < 1 and lobes >= 1, got {self.amplitude}, {self.lobes}", place="Star"
            )


def kind_of(obstacle: Any) -> str:
    """What an obstacle is, in a word."""
    if isinstance(obstacle, EllipsoidND):
        return "ellipse" if len(obstacle.center) == 2 else "ellipsoid"
    name = type(obstacle).__name__
    return {"HalfSpace": "half-space", "PointCloud": "point cloud"}.get(name, name.lower())


@dataclass(frozen=True, slots=True, eq=False)
class Workspace:
    """The wall of a ball-shaped workspace in R^n: the robot stays inside."""

    center: Floats
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", frozen_array(self.center, "workspace center"))
        _positive(self, "radius")
