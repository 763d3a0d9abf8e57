"""The certificate of a trajectory in a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..distance import pack_robot
from ..errors import InputError
from ..numeric import at_least, float_array
from ..robots import Robot
from ._arrival import arm_error
from ._certificate import Certificate, Unresolved, Violation
from ._clearance import ClearanceBound, clearance_bound

if TYPE_CHECKING:
    from ..scenes import Scene, Trajectory

Floats = NDArray[np.float64]
LIMIT_TOLERANCE = 1e-9
SPEED_TOLERANCE = 1e-6
_ROUGH = {"tolerance": 5e-4, "relative": 0.05}  # of a clearance (m, share), where time matters more
_CONTACTS = ("obstacle", "self", "model")


def certify(
    scene: Scene,
    trajectory: Trajectory | Any,
    *,
    tolerance: float = 1e-5,
    relative: float = 2e-3,
    max_evaluations: int = 200_000,
) -> Certificate:
    """Certifies a motion for all times: clearance, limits, velocities, start and goal.

    `trajectory`: a `Trajectory`, or waypoints (k, n) without times; between them every coordinate moves linearly. The margins
    are `scene.options.clearance` and `.self_clearance`; start and goal may be missed by `.goal_tolerance` (m, or joint units)
    and `.angle_tolerance` (rad). An arm, a point robot (its ball) or a unicycle (its disc); of an arm the least clearance is
    found out to `tolerance` (m) or the `relative` share of it; where that takes more than half of `max_evaluations`, to 0.5 mm or
    5 %. Raises InputError.
    """
    robot = getattr(scene, "robot", None)
    if robot is None:
        raise InputError(
            f"expected a Scene, got {type(scene).__name__}", place="scene", remedy="Scene.load(name_or_path)"
        )
    positions, times, speeds = _read(scene, trajectory)
    if isinstance(robot, Robot):
        return _Arm(scene, positions, times, speeds).certificate(max_evaluations, tolerance, relative)
    from ._moving_ball import certify_ball

    return certify_ball(scene, positions, times)


def _read(scene: Scene, trajectory: Any) -> tuple[Floats, Floats | None, Floats | None]:
    """Positions in the robot's own order of joints, times, velocities."""
    if not hasattr(trajectory, "positions"):
        return float_array(trajectory, "waypoints", ndim=2), None, None
    positions, times, speeds = trajectory.positions, trajectory.time, trajectory.velocities
    robot = scene.robot
    if isinstance(robot, Robot) and trajectory.names and tuple(trajectory.names) != robot.joint_names:
        if sorted(trajectory.names) != sorted(robot.joint_names):
            raise InputError(
                f"the trajectory moves {', '.join(trajectory.names)}", place="trajectory", choices=robot.joint_names
            )
        order = [trajectory.names.index(name) for name in robot.joint_names]
        positions, speeds = positions[:, order], None if speeds is None else speeds[:, order]
    if not getattr(trajectory, "is_timed", True):
        times = None
    return positions, times, speeds


class _Arm:
    """One check of an arm: collects what holds and what does not."""

    def __init__(self, scene: Scene, positions: Floats, times: Floats | None, speeds: Floats | None) -> None:
        self.scene, self.robot = scene, scene.robot
        assert isinstance(self.robot, Robot)
        n = self.robot.n_joints
        if positions.shape[1] != n or len(positions) == 0:
            raise InputError(f"expected waypoints (k, {n}), got {positions.shape}", place="trajectory")
        self.q, self.times, self.speeds = np.ascontiguousarray(positions), times, speeds
        self.violations: list[Violation] = []
        self.unresolved: list[Unresolved] = []

    def certificate(self, budget: int, tolerance: float, relative: float) -> Certificate:
        options, robot = self.scene.options, self.robot
        assert isinstance(robot, Robot)
        effort = {"max_evaluations": budget, "tolerance": tolerance, "relative": relative}
        outer = self.clearance("obstacle", options.clearance, effort)
        inner = self.clearance("self", options.self_clearance, effort)
        limits_ok, velocities_ok = self.limits(), self.velocities()
        start = self.arrival("start", 0, options.goal_tolerance, options.angle_tolerance)
        goal = self.arrival("goal", -1, options.goal_tolerance, options.angle_tolerance)
        self.model()
        # contacts first: they matter most, whenever they happen
        violations = sorted(
            self.violations, key=lambda v: (v.kind not in _CONTACTS, v.segment + v.fraction, v.kind == "goal")
        )
        certified = not violations and not self.unresolved and outer.holds and inner.holds
        nearest = "nothing to touch"
        if outer.nearest is not None:
            nearest = f"{outer.nearest.link} to {outer.nearest.other}, {1e3 * outer.nearest.clearance:.2f} mm"
        return Certificate(
            certified=certified,
            clearance=outer.lower,
            clearance_seen=outer.upper,
            margin=outer.margin,
            self_clearance=inner.lower,
            self_clearance_seen=inner.upper,
            self_margin=inner.margin,
            nearest=nearest,
            first_violation=violations[0] if violations else None,
            violations=tuple(violations),
            unresolved=tuple(self.unresolved),
            reasons=reasons(violations, self.unresolved, certified, outer.lower, outer.margin),
            goal_error=goal[0],
            goal_angle_error=goal[1],
            start_error=start[0],
            start_angle_error=start[1],
            limits_ok=limits_ok,
            velocities_ok=velocities_ok,
            evaluations=outer.evaluations + inner.evaluations,
            slack=max(outer.slack, inner.slack),
            allowed=allowed_contacts(robot, self.scene.obstacles),
        )

    def model(self) -> None:
        """A robot without a body that moves clears everything; that proves nothing."""
        assert isinstance(self.robot, Robot)
        if self.scene.obstacles and not (pack_robot(self.robot).frames > 0).any():
            self.violations.append(
                Violation("model", self.robot.name, "obstacles", 0.0, 0.0, 0, 0.0, self.time(0, 0.0))
            )

    def clearance(self, kind: str, margin: float, effort: dict[str, Any]) -> ClearanceBound:
        assert isinstance(self.robot, Robot)
        own = kind == "self"
        obstacles = () if own else self.scene.obstacles
        what = {"self_collision": own, "static": False}
        half = {**effort, "max_evaluations": max(effort["max_evaluations"] // 2, 1)}
        bound = clearance_bound(self.robot, self.q, obstacles, margin, **what, **half)
        if bound.violation is None and bound.evaluations >= half["max_evaluations"]:
            rough = {name: max(effort[name], least) for name, least in _ROUGH.items()}
            bound = clearance_bound(self.robot, self.q, obstacles, margin, **what, **{**effort, **rough})
        if bound.violation is not None:
            v = bound.violation
            time = self.time(v.segment, v.fraction)
            self.violations.append(Violation(kind, v.link, v.other, v.clearance, margin, v.segment, v.fraction, time))
        for gap in bound.unresolved:
            self.unresolved.append(
                Unresolved(
                    kind,
                    gap.segment + gap.start,
                    gap.segment + gap.stop,
                    gap.bound,
                    self.time(gap.segment, gap.start),
                    self.time(gap.segment, gap.stop),
                )
            )
        return bound

    def time(self, segment: int, fraction: float) -> float | None:
        return moment(self.times, segment, fraction)

    def limits(self) -> bool:
        """At the waypoints, which is enough between them: a straight line between two points of a box stays in it."""
        assert isinstance(self.robot, Robot)
        limits = self.robot.limits
        beyond = np.maximum(limits.lower - self.q, self.q - limits.upper)
        for j in np.flatnonzero((beyond > LIMIT_TOLERANCE).any(axis=0)):
            k = int(np.argmax(beyond[:, j] > LIMIT_TOLERANCE))
            low = self.q[k, j] < limits.lower[j]
            limit = float(limits.lower[j] if low else limits.upper[j])
            side = f"{'lower' if low else 'upper'} limit"
            self._at_waypoint("limit", self.robot.joint_names[j], side, float(self.q[k, j]), limit, k)
        return not (beyond > LIMIT_TOLERANCE).any()

    def velocities(self) -> bool:
        """Mean velocities between waypoints, and the velocities the trajectory states."""
        assert isinstance(self.robot, Robot)
        rates = np.zeros((len(self.q) - 1, self.q.shape[1]))
        if self.times is not None:
            rates = np.abs(np.diff(self.q, axis=0)) / np.diff(self.times)[:, None]
        if self.speeds is not None:
            rates = np.concatenate((rates, np.abs(self.speeds)))
        allowed = self.robot.limits.velocity * (1.0 + SPEED_TOLERANCE)
        segments = len(self.q) - 1
        for j in np.flatnonzero((rates > allowed).any(axis=0)):
            k = int(np.argmax(rates[:, j] > allowed[j]))
            at = k if k < segments else k - segments
            limit = float(self.robot.limits.velocity[j])
            self._at_waypoint("velocity", self.robot.joint_names[j], "velocity limit", float(rates[k, j]), limit, at)
        return not (rates > allowed).any()

    def arrival(self, name: str, index: int, metres: float, radians: float) -> tuple[float, float]:
        assert isinstance(self.robot, Robot)
        error = arm_error(self.robot, self.q[index], getattr(self.scene, name))
        k = 0 if name == "start" else len(self.q) - 1
        for value, limit, what in ((error[0], metres, "position error"), (error[1], radians, "angle error")):
            if not value <= limit:
                self._at_waypoint(name, "tool", what, value, limit, k)
        return error

    def _at_waypoint(self, kind: str, subject: str, other: str, value: float, limit: float, k: int) -> None:
        segment, fraction = (k - 1, 1.0) if k > 0 else (0, 0.0)
        self.violations.append(
            Violation(kind, subject, other, value, limit, segment, fraction, self.time(segment, fraction))
        )


def allowed_contacts(robot: Robot, obstacles: tuple[Any, ...]) -> tuple[str, ...]:
    """Contacts that somebody allowed, in words: of links with obstacles that are there, and of links with each other."""
    there = {getattr(obstacle, "name", "") for obstacle in obstacles}
    found = [f"{link} may touch {name}" for link, name in robot.allowed_obstacles if name in there]
    said = ("allowed by", "disabled in the SRDF", "always touching", "not seen touching")
    pairs = [pair for pair in robot.pair_table if not pair.checked and pair.reason.startswith(said)]
    return (*found, *(f"{pair.first} may touch {pair.second}: {pair.reason}" for pair in pairs))


def moment(times: Floats | None, segment: int, fraction: float) -> float | None:
    """Seconds at a fraction of a segment, None without times."""
    if times is None:
        return None
    if len(times) == 1:
        return float(times[0])
    return float(times[segment] + fraction * (times[segment + 1] - times[segment]))


def reasons(
    violations: list[Violation], unresolved: list[Unresolved], certified: bool, clearance: float, margin: float
) -> tuple[str, ...]:
    """The verdict in words, one entry for each thing that does not hold."""
    if certified:
        return (f"certified: clearance at least {at_least(clearance, 6)} m for all times (required: {margin:g} m)",)
    lines = [str(v) for v in violations]
    for kind in ("obstacle", "self"):
        parts = [u for u in unresolved if u.kind == kind]
        if parts:
            worst = min(parts, key=lambda u: u.bound)
            lines.append(
                f"{kind} clearance unresolved on {len(parts)} stretches, first from waypoint {parts[0].start:.6f} to "
                f"{parts[0].stop:.6f}; at least {at_least(worst.bound, 6)} m there"
            )
    return tuple(lines)
