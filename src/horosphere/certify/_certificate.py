"""What a certificate says."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Violation:
    """One thing that a motion breaks, at its first moment.

    `kind`: obstacle, self, model (no body to check), limit, velocity, workspace, start or goal; `time` s (None where the
    motion has no times); `segment`, `fraction`: between waypoints `segment` and `segment + 1`; `subject`: link, joint or
    robot; `other`: obstacle, link or limit; `value` against `limit` in SI units.
    """

    kind: str
    subject: str
    other: str
    value: float
    limit: float
    segment: int
    fraction: float
    time: float | None = None

    def __str__(self) -> str:
        when = f"at {self.time:.4f} s" if self.time is not None else f"at waypoint {self.segment + self.fraction:.4f}"
        if self.kind in ("obstacle", "self"):
            return f"{self.subject} comes nearer to {self.other} than the required {1e3 * self.limit:g} mm {when}"
        if self.kind == "model":
            return f"{self.subject} has no collision body that moves: nothing was checked against the obstacles"
        if self.kind in ("start", "goal"):
            return f"{self.kind} missed: {self.other} {self.value:.3g} (allowed: {self.limit:g})"
        has = f"moves at {self.value:.6g} per second" if self.kind == "velocity" else f"is at {self.value:.6g}"
        return f"{self.subject} {has}, beyond its {self.other} {self.limit:.6g}, {when}"


@dataclass(frozen=True, slots=True)
class Unresolved:
    """A stretch of the motion that could be neither cleared nor shown to violate: waypoint numbers with fractions, s, m."""

    kind: str
    start: float
    stop: float
    bound: float
    start_time: float | None = None
    stop_time: float | None = None


@dataclass(frozen=True, slots=True)
class Certificate:
    """The verdict on a motion that runs straight in joint space between its waypoints, for all times.

    Attributes
    ----------
    certified: clearance, self clearance, limits, velocities, start and goal all hold.
    clearance: lower bound (m) of the distance to the obstacles over the whole motion; `clearance_seen`: the smallest met, so
        the truth lies between; `margin`: what was required. `self_clearance`, `self_clearance_seen`, `self_margin` likewise.
    nearest: the closest pair of bodies, in words.
    first_violation, violations: what breaks, in order of time. unresolved: see `Unresolved`. reasons: the verdict in words.
    goal_error, start_error: metres at the tool (joint targets: largest joint difference, rad or m);
        goal_angle_error, start_angle_error: rad.
    evaluations: configurations looked at; slack: metres taken off for rounding. allowed: contacts that were not looked at
        because somebody allowed them, in words.
    """

    certified: bool
    clearance: float
    clearance_seen: float
    margin: float
    self_clearance: float
    self_clearance_seen: float
    self_margin: float
    nearest: str
    first_violation: Violation | None
    violations: tuple[Violation, ...]
    unresolved: tuple[Unresolved, ...]
    reasons: tuple[str, ...]
    goal_error: float
    goal_angle_error: float
    start_error: float
    start_angle_error: float
    limits_ok: bool
    velocities_ok: bool
    evaluations: int
    slack: float
    allowed: tuple[str, ...] = ()

    @property
    def collision_free(self) -> bool:
        """Whether nothing touches, whatever the margin."""
        return self.clearance > 0.0 and self.self_clearance > 0.0

    @property
    def reason(self) -> str:
        """The verdict in one line."""
        return "; ".join(self.reasons)

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON: infinite values become None."""
        return _plain({**asdict(self), "collision_free": self.collision_free})


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
