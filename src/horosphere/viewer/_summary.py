"""What a result says, as words and rows: the same on the terminal, in JSON and on the report."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..numeric import at_least
from ..scenes import PointRobot, Scene, Trajectory, kind_of
from ._measure import Measures
from ._parts import stride

_UNASKED = "always touching", "not seen touching"
"""Reasons for which pairs of links are left out without anybody having asked for it."""


@dataclass(frozen=True, slots=True)
class Summary:
    """`good`: may the motion be run? `verdict`: one line. `rows`: label and value. `notes`: what else one should know."""

    good: bool
    verdict: str
    rows: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]


def summarise(
    scene: Scene,
    trajectory: Trajectory | None,
    measures: Measures | None = None,
    *,
    certificate: Any = None,
    solved: bool | None = None,
    reason: str = "",
    solved_by: str | None = None,
    timings: dict[str, float] | None = None,
    notes: tuple[str, ...] = (),
) -> Summary:
    """The verdict first, then the figures. `solved` None: the motion was only checked, not planned."""
    certified = bool(getattr(certificate, "certified", False))
    good = certified if solved is None else bool(solved) and (certificate is None or certified)
    rows: list[tuple[str, str]] = []
    unit = getattr(scene.robot, "unit", "m")
    if certificate is not None:
        rows.append(("Certified clearance", _clearance(certificate, scene, certified)))
        if getattr(certificate, "nearest", ""):
            rows.append(("Nearest", str(certificate.nearest)))
        contacts = getattr(certificate, "allowed", ())
        unasked = tuple(text for text in contacts if text.partition(": ")[2].startswith(_UNASKED))
        allowed = tuple(text for text in contacts if text not in unasked)
        if allowed:
            rows.append(("Allowed contacts", _contacts(allowed)))
        if unasked:
            rows.append(("Not checked", _contacts(unasked).replace(" may touch ", " / ")))
        if math.isfinite(getattr(certificate, "self_clearance", math.inf)):
            rows.append(("Self-clearance", f"at least {bound(certificate.self_clearance)}"))
    if measures is not None and measures.clearance is not None:
        lowest = int(np.argmin(measures.clearance))
        rows.append(
            (
                "Least clearance seen",
                f"{1e3 * measures.clearance[lowest]:.2f} m{unit} at {measures.time[lowest]:.2f} s, "
                f"of {len(measures.time)} moments",
            )
        )
    error = goal_error(measures)
    if error is not None:
        angle = getattr(certificate, "goal_angle_error", None)
        rows.append(("Goal error", length(error, unit) + (f", {math.degrees(angle):.1e} degrees" if angle else "")))
    if trajectory is not None:
        rows.append(("Largest step", _step(scene, trajectory)))
        rows.append(("Duration", f"{trajectory.duration:.2f} s, {len(trajectory)} waypoints"))
    if solved_by:
        rows.append(("Solved by", solved_by))
    if timings:
        rows.append(("Time spent", _spent(timings)))
    rows += [("Robot", _robot(scene)), ("Collision model", collision_model(scene)), ("Obstacles", _obstacles(scene))]
    every = dict.fromkeys((*notes, *scene.notes, *getattr(scene.robot, "notes", ())))  # in order, none twice
    return Summary(good, _verdict(scene, certificate, solved, reason, good), tuple(rows), tuple(every))


def _contacts(allowed: tuple[str, ...], most: int = 4) -> str:
    """Those with obstacles one by one, those between links by the reason; the certificate has them all."""
    one_by_one = [text for text in allowed if ": " not in text]
    found = one_by_one[:most] + [f"and {len(one_by_one) - most} more"] * (len(one_by_one) > most)
    by_reason: dict[str, list[str]] = {}
    for pair, _, reason in (text.partition(": ") for text in allowed if ": " in text):
        by_reason.setdefault(reason.split(":")[0].split(" in ")[0], []).append(pair)
    for reason, pairs in by_reason.items():
        found.append(f"{pairs[0]}: {reason}" if len(pairs) == 1 else f"{len(pairs)} pairs of links: {reason}")
    return "; ".join(found)


def goal_error(measures: Measures | None) -> float | None:
    """Distance from the goal at the end, metres."""
    return None if measures is None or measures.to_goal is None else float(measures.to_goal[-1])


def _verdict(scene: Scene, certificate: Any, solved: bool | None, reason: str, good: bool) -> str:
    if good and certificate is not None:
        word = "Certified" if solved is None else "Solved and certified"
        if not math.isfinite(certificate.clearance):
            return f"{word}; there is no obstacle to keep clear of"
        unit = getattr(scene.robot, "unit", "m")
        least = f"comes closer than {bound(certificate.clearance, unit=unit)} to any obstacle"
        touching = sum(" may touch " in text and ":" not in text for text in getattr(certificate, "allowed", ()))
        least += f", but for {touching} allowed contact{'s' * (touching > 1)}" if touching else ""
        if any(note.startswith("WITHOUT collision body") for note in getattr(scene.robot, "notes", ())):
            return f"{word}, as far as the robot has collision bodies (see the notes): none of them {least}"
        return f"{word}: no moving part of the robot {least}"
    if good:
        return "Solved"
    violation = first_violation(certificate)
    if solved is None:
        worst = float(getattr(certificate, "clearance_seen", math.inf))
        inside = f"; at worst {-1e3 * worst:.1f} m{getattr(scene.robot, 'unit', 'm')} inside" if worst < 0.0 else ""
        return f"Not certified: {violation or reason or 'no certificate'}{inside}"
    if solved:
        return f"Reached, but not certified: {violation or reason}"
    return f"Not solved: {reason or violation or 'no reason given'}"


def first_violation(certificate: Any) -> str:
    """The first thing that is wrong, in words; empty if nothing is."""
    violation = getattr(certificate, "first_violation", None)
    if violation is None:
        unresolved = getattr(certificate, "unresolved", None)
        return f"could not be decided in {unresolved}" if unresolved is not None and np.size(unresolved) else ""
    return str(violation)


def _clearance(certificate: Any, scene: Scene, certified: bool) -> str:
    value = float(certificate.clearance)
    if not math.isfinite(value):
        return "nothing to keep clear of" if value > 0 else "none"
    unit = getattr(scene.robot, "unit", "m")
    least = bound(value, unit=unit)
    asked = 1e3 * scene.options.clearance
    required = f"(required {asked:g} m{unit})"
    return f"at least {least} {required}" if certified else f"not certified; bound {least} {required}"


def bound(value: float, digits: int = 2, unit: str = "m") -> str:
    """A lower bound in thousandths of the unit, rounded down: what is promised must hold as it is written."""
    return f"{at_least(value, decimals=digits, power=3)} m{unit}"


def length(value: float, unit: str = "m") -> str:
    """A length (m, or rad in a configuration space) with a unit that suits it."""
    if value >= 1.0 or value == 0.0:
        return f"{value:.3f} {unit}" if value else f"0 {unit}"
    return f"{1e3 * value:.2f} m{unit}" if value >= 1e-5 else f"{value:.1e} {unit}"


def _seconds(value: float) -> str:
    if value >= 1.0:
        return f"{value:.2f} s"
    return (
        f"{1e3 * value:.0f} ms"
        if value >= 0.01
        else f"{1e3 * value:.1f} ms"
        if value >= 1e-4
        else f"{1e6 * value:.0f} us"
    )


def _spent(timings: dict[str, float]) -> str:
    """The whole, and parts that add up to it."""
    parts = {name: value for name, value in timings.items() if name != "total"}
    total = timings.get("total", sum(parts.values()))
    other = total - sum(parts.values())
    if other >= 0.005 * total:
        parts["other"] = other
    return ", ".join([f"{_seconds(total)} in all", *(f"{name} {_seconds(value)}" for name, value in parts.items())])


def _step(scene: Scene, trajectory: Trajectory) -> str:
    steps = np.abs(np.diff(trajectory.positions, axis=0)).max(axis=0, initial=0.0)
    j = int(np.argmax(steps))
    robot: Any = scene.robot
    if isinstance(robot, PointRobot):
        return f"{length(float(steps[j]), robot.unit)} between waypoints"
    if not hasattr(robot, "joint_names"):
        return f"{steps[j]:.4g} m or rad between waypoints"
    sliding = {link.coordinate for link in robot.links if link.kind == "prismatic"}
    amount = f"{1e3 * steps[j]:.2f} mm" if j in sliding else f"{math.degrees(steps[j]):.2f} degrees"
    return f"{amount} between waypoints ({robot.joint_names[j]})"


def _robot(scene: Scene) -> str:
    robot: Any = scene.robot
    if hasattr(robot, "joint_names"):
        form = f", closed form {robot.closed_form[0]}" if robot.closed_form else ""
        return f"{robot.name}, {robot.n_joints} joints{form}"
    if type(robot).__name__ == "SnakeRobot":
        return f"snake of {robot.links} links"
    if type(robot).__name__ == "PointRobot":
        space = f"R^{robot.dimension}" if robot.unit == "m" else f"a configuration space of {robot.dimension} angles"
        return f"ball of radius {robot.radius:g} {robot.unit} in {space}, {_rates(robot, robot.unit)}"
    return f"unicycle of radius {robot.radius:g} m, {_rates(robot, 'm')}, {robot.max_turn_rate:g} rad/s"


def _rates(robot: Any, unit: str) -> str:
    return f"at most {robot.max_speed:g} {unit}/s and {robot.max_acceleration:g} {unit}/s^2"


def collision_model(scene: Scene) -> str:
    """Which bodies stood for the robot, on which links; where they come from is in the robot's notes."""
    robot: Any = scene.robot
    if not hasattr(robot, "capsules"):
        return "exact"
    count = len(robot.capsules)
    if not count:
        return "NONE: nothing of this robot was checked against the obstacles"
    balls = int((np.linalg.norm(robot.capsules.a - robot.capsules.b, axis=1) == 0.0).sum())
    kinds = [f"{count - balls} capsules"] * (count > balls) + [f"{balls} balls"] * (balls > 0)
    links = [robot.links[i].name for i in range(len(robot.links)) if (robot.capsules.link == i).any()]
    named = ", ".join(links if len(links) <= 6 else [*links[:3], "...", *links[-2:]])
    return f"{' and '.join(kinds)} on {len(links)} link{'s' * (len(links) > 1)}: {named}"


def _obstacles(scene: Scene) -> str:
    if not scene.obstacles:
        return "none"
    counts: dict[str, int] = {}
    clouds: list[str] = []
    for obstacle in scene.obstacles:
        kind = kind_of(obstacle)
        counts[kind] = counts.get(kind, 0) + 1
        if kind == "point cloud":
            every = stride(obstacle)
            shown = f", one in {every} drawn in the report" if every > 1 else ""
            clouds.append(f"{len(obstacle.points):,} points{shown}")
    named = {
        kind: f"{n} {kind}{'' if n == 1 else 'es' if kind in ('box', 'mesh') else 's'}" for kind, n in counts.items()
    }
    if clouds:
        named["point cloud"] += f" ({'; '.join(clouds)})"
    return ", ".join(named.values())
