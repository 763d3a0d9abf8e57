"""Robots that are no arms, and obstacles that are no solids of space: data of the plane and of R^n."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..numeric import float_array, number, whole_number
from ._targets import frozen_array

Floats = NDArray[np.float64]


def _positive(record: object, *names: str) -> None:
    for name in names:
        place = f"{type(record).__name__}.{name}"
        value = float_array(getattr(record, name), place)
        if not (value > 0.0).all():
            raise InputError(f"expected finite numbers > 0, got {value}", place=place)


def _not_negative(record: object, name: str) -> None:
    place = f"{type(record).__name__}.{name}"
    value = float(float_array(getattr(record, name), place, ndim=0))
    if value < 0.0:
        raise InputError(f"expected a {name} >= 0, got {value:g}", place=place)


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
        whole_number(self.dimension, "PointRobot.dimension", 2)
        _not_negative(self, "radius")


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
        _not_negative(self, "radius")


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
        number(self.wheel_fraction, "SnakeRobot.wheel_fraction", least=0.0, most=1.0)
        _not_negative(self, "width")

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
        if n < 2:
            raise InputError(f"expected a centre in R^n with n >= 2, got {n} coordinates", place="EllipsoidND.center")
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
        if not isinstance(self.mu, complex | float | int) or not np.isfinite(self.mu):
            raise InputError(f"expected a finite complex number, got {self.mu!r:.60}", place="Aerofoil.mu")
        float_array(self.angle, "Aerofoil.angle", ndim=0)


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
        whole_number(self.lobes, "Star.lobes", 1)
        if number(self.amplitude, "Star.amplitude", least=0.0) >= 1.0:
            raise InputError(f"expected a number below 1, got {self.amplitude:g}", place="Star.amplitude")


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
