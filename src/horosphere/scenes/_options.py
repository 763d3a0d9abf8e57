"""What a scene may ask of the planner, the field and the tracking control; every value has a default."""

from __future__ import annotations

import math
from dataclasses import dataclass

METHODS = ("auto", "field", "tree", "reactive", "reactive-or-tree")
TIMINGS = ("smooth", "time-optimal")
# the names that `fields.HarmonicField` and `control.SlidingMode` know, which lie beside or above this layer; a test compares them
RULES = ("planar-log", "planar", "equilibrium", "safe", "monotone", "printed")
BLENDINGS = ("W1", "W2", "nearest", "simplex", "smooth", "sum", "printed", "printed-potential")
LAWS = ("implicit-unit-vector", "explicit", "boundary-layer", "super-twisting")


@dataclass(frozen=True, slots=True)
class Options:
    """For the planner: metres, radians, seconds.

    `clearance` is kept between every part of the robot and every obstacle; `max_joint_step` bounds the change of each joint
    between waypoints; `method` is auto, field (no tree search), tree, reactive (the field's law in joint space, no tree) or
    reactive-or-tree. `improvement_time` (s) is used after the first certified plan to shorten it and to widen its clearance;
    0: not at all. `timing` is smooth (a trapezoid of the speed along the path)
    or time-optimal, which also keeps a limit of every joint's `jerk` (rad or m, per s^3) where there is one.
    """

    clearance: float = 0.01
    self_clearance: float = 0.0
    path_step: float = 0.02
    max_joint_step: float = math.radians(5.0)
    method: str = "auto"
    seed: int = 0
    time_limit: float = 10.0
    improvement_time: float = 1.0
    goal_tolerance: float = 1e-6
    angle_tolerance: float = 1e-6
    velocity_scale: float = 1.0
    acceleration_scale: float = 1.0
    time_step: float = 0.01
    timing: str = "smooth"
    jerk: float | None = None


@dataclass(frozen=True, slots=True)
class FieldOptions:
    """For the harmonic field: the rule of the charges, the width of the blending shell (m), the blending, a sensor range (m)."""

    rule: str = "planar-log"
    boundary: float | None = None
    blending: str = "W2"
    exponents: tuple[float, ...] | float | None = None
    sensor_range: float | None = None


@dataclass(frozen=True, slots=True)
class ControlOptions:
    """For tracking in simulation: sampling period (s), control law, its gain, amplitude of the disturbance (m/s^2)."""

    period: float = 0.01
    law: str = "implicit-unit-vector"
    gain: float | None = None
    disturbance: float = 0.0
    slow_down: bool = False
    grow_radius: bool = False
