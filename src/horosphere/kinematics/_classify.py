"""Which closed-form inverse kinematics a chain has, from its structure alone.

Only relations of consecutive joint axes are read: they are the ones that the motion of the joints does not change. Two
consecutive axes are parallel, or meet, or miss each other by a gap; three that meet in one point are a spherical joint.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..robots._robot import require_robot
from ._screws import Screws, screws

Floats = NDArray[np.float64]

PARALLEL = 1e-5  # sine between axes below which they count as parallel
GAP = 1e-5  # metres between axes below which they count as meeting
NEAR = 2e-3  # metres: a structure missed by less is used as a start and polished on the true axes


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """What the classifier found.

    name: "sew7", "srs7", "us5", "spherical6", "parallel6", a built-in arm, or "numerical". is_reversed: solved from
    the tip to the base. parameter: the redundancy ("q7", "q1", "psi", "phi") or None. bits: what tells the branches
    apart. reasons: the relations that decide it, in words (joints counted from 1). near_misses: (i, j, metres) of
    consecutive axes that nearly meet. gap: metres by which the structure is missed; above 1e-11 solutions are
    polished on the true axes. screws, special, mode: what the compiled solver reads (of the reversed chain if
    is_reversed). position: the closed form for a position of the tool point alone, where there is one.
    """

    name: str
    bits: tuple[str, ...] = ()
    parameter: str | None = None
    is_reversed: bool = False
    reasons: tuple[str, ...] = ()
    near_misses: tuple[tuple[int, int, float], ...] = ()
    gap: float = 0.0
    screws: Screws | None = None
    special: Floats | None = None
    mode: int = 0
    position: Structure | None = None

    @property
    def branches(self) -> int:
        """How many rows an inverse has."""
        return 2 ** len(self.bits)

    @property
    def is_closed_form(self) -> bool:
        return self.name != "numerical"

    def __str__(self) -> str:
        position = "" if self.position is None else f"; a position alone: closed form, {self.position}"
        if not self.is_closed_form:
            return "numerical: " + "; ".join(self.reasons) + position
        text = (
            f"{self.name}{' (reversed)' if self.is_reversed else ''}: {self.branches} branches ({', '.join(self.bits)})"
        )
        if self.parameter:
            text += f", free {self.parameter}"
        if self.gap > GAP:
            text += f", structure missed by {1e3 * self.gap:.3g} mm: polished on the true axes"
        return text + (": " + "; ".join(self.reasons) if self.reasons else "") + position


@dataclass(frozen=True, slots=True, eq=False)
class _Relations:
    """Of consecutive axes i, i+1 (from 0): parallel, gap in metres, midpoint of the common perpendicular."""

    parallel: tuple[bool, ...]
    gap: tuple[float, ...]
    meet: tuple[Floats | None, ...]

    def meets(self, i: int, tolerance: float) -> bool:
        return not self.parallel[i] and self.gap[i] <= tolerance

    def spherical(self, i: int, tolerance: float) -> tuple[Floats, float] | None:
        """The common point of axes i, i+1, i+2 and by how much it is missed, or None."""
        a, b = self.meet[i], self.meet[i + 1]
        if a is None or b is None or not self.meets(i, tolerance) or not self.meets(i + 1, tolerance):
            return None
        apart = float(np.linalg.norm(a - b))
        return (0.5 * (a + b), max(self.gap[i], self.gap[i + 1], apart)) if apart <= tolerance else None


def classify(robot: Any) -> Structure:
    """Which inverse kinematics applies to a robot and why; kept with the robot after the first call.

    Built-in arms have their own closed form; any other chain of 5, 6 or 7 revolute joints is read from its axes,
    first exactly (1e-5 m, 1e-5 rad), then with gaps of up to 2 mm, then from the other end. Anything else is numerical.
    """
    known = require_robot(robot).memo.get("structure")
    if known is None:
        known = robot.memo["structure"] = _classify(robot)
    return known


_BUILT_IN = {
    "humanoid_arm": (("back", "elbow", "flip"), "phi"),
    "srs_arm": (("theta2<0", "theta4<0", "theta6<0"), "psi"),
    "six_axis_arm": (("back", "elbow", "flip"), None),
}


def _classify(robot: Any) -> Structure:
    if robot.closed_form and robot.closed_form[0] in _BUILT_IN:
        bits, parameter = _BUILT_IN[robot.closed_form[0]]
        return Structure(robot.closed_form[0], bits, parameter, reasons=("a built-in arm",))
    return replace(chain_structure(robot), position=_position(robot))


def _position(robot: Any) -> Structure | None:
    """The closed form for a position alone: five joints of kind us5, and behind them only joints that turn about the tool point."""
    chain = screws(robot)
    if isinstance(chain, str) or len(chain.axes) < 5:
        return None
    tool = chain.home[:3, 3]
    for axis, point in zip(chain.axes[5:], chain.points[5:]):
        if np.linalg.norm(np.cross(axis, tool - point)) > 1e-12:
            return None
    first = Screws(chain.axes[:5], chain.points[:5], chain.home)
    for tolerance in (GAP, NEAR):
        found = _five(first, _relations(first), tolerance)
        if found is not None and _stiff(found, first):
            continue
        if found is not None and found.special is not None and np.linalg.norm(tool - found.special[1]) > GAP:
            still = ", ".join(robot.joint_names[5:])
            reasons = ()
            if still:
                turns = "turns" if len(chain.axes) == 6 else "turn"
                reasons = (*found.reasons[:2], f"{still} only {turns} about the tool point")
            return replace(
                found, reasons=reasons, parameter="psi and q5", screws=chain, gap=max(found.gap, _skew(first))
            )
    return None


def chain_structure(robot: Any) -> Structure:
    """What the axes of the chain say, whether or not the robot is a built-in arm."""
    chain = screws(robot)
    if isinstance(chain, str):
        return Structure("numerical", reasons=(chain,))
    n = len(chain.axes)
    if n not in _READERS:
        reason = f"{n} revolute joints: closed forms are known here for 5, 6 and 7"
        return Structure("numerical", reasons=(reason, *_shorter(robot, chain), *_later(robot, chain)))
    forward, backward = chain, chain.reversed()
    near = tuple(
        (i + 1, i + 2, gap)
        for i, (gap, parallel) in enumerate(zip(_relations(chain).gap, _relations(chain).parallel))
        if not parallel and GAP < gap < NEAR
    )
    stiff = ""
    for tolerance in (GAP, NEAR):
        for is_reversed, screw in ((False, forward), (True, backward)):
            found = _READERS[n](screw, _relations(screw), tolerance)
            if found is None:
                continue
            missing = _stiff(found, screw)
            if not missing:
                return _finished(found, screw, is_reversed, near)
            stiff = stiff or f"{found.name} but for this: {missing}"
    why = stiff or _why_not(chain)
    return Structure("numerical", reasons=(why, *_shorter(robot, chain), *_later(robot, chain)), near_misses=near)


def _read(chain: Screws) -> Structure | None:
    """The exact structure of a chain from either end, where it has one that moves as it must."""
    for screw in (chain, chain.reversed()):
        found = _READERS[len(chain.axes)](screw, _relations(screw), GAP)
        if found is not None and not _stiff(found, screw):
            return found
    return None


def _stiff(found: Structure, chain: Screws) -> str:
    """Why the closed form of a structure does not hold, "" if it does.

    Its steps have roots one by one where the joints, the redundancy held, move the tip in six dimensions (a chain of five in five).
    Where they do not, as when the wrist's point lies on the axis before it, some step moves nothing, and what it sets is arbitrary.
    """
    n, free = len(chain.axes), found.parameter == "q7"
    freedoms = chain.freedoms(n - 1 if free else -1, max(1e-4, 10.0 * found.gap))
    held = ", the redundant one held," if free else ""
    return "" if freedoms >= min(n, 6) else f"{n} joints{held} move the tip in {freedoms} dimensions only"


def _shorter(robot: Any, chain: Screws) -> tuple[str, ...]:
    """What the chain would be without its last joint, often one of a gripper: a hint for whoever named the tip."""
    n = len(chain.axes) - 1
    if n not in _READERS:
        return ()
    found = _read(Screws(chain.axes[:-1], chain.points[:-1], chain.home))
    if found is None:
        return ()
    moved = next(link for link in reversed([robot.links[k] for k in robot.chain]) if link.kind != "fixed")
    tip = robot.links[moved.parent].name
    return (f"without {robot.joint_names[moved.coordinate]}, with the tip {tip}, it would be {found.name}",)


def _later(robot: Any, chain: Screws) -> tuple[str, ...]:
    """The longest chain to the tip with a closed form that starts at a later link, if there is one: a hint for the base."""
    moved = [robot.links[k] for k in robot.chain if robot.links[k].kind != "fixed"]
    if len(moved) != len(chain.axes):  # joints that mimic others
        return ()
    for first in range(1, len(chain.axes) - min(_READERS) + 1):
        n = len(chain.axes) - first
        if n not in _READERS:
            continue
        found = _read(Screws(chain.axes[first:], chain.points[first:], chain.home))
        if found is not None:
            return (f"with --base {robot.links[moved[first].parent].name} ({n} joints): {found.name}",)
    return ()


def _finished(found: Structure, chain: Screws, is_reversed: bool, near) -> Structure:
    reasons = found.reasons
    parameter = found.parameter
    if is_reversed:
        reasons = (*reasons, "joints counted from the tip")
        parameter = "q1" if parameter == "q7" else parameter
    gap = max(found.gap, _skew(chain))
    return replace(
        found, screws=chain, is_reversed=is_reversed, near_misses=near, reasons=reasons, parameter=parameter, gap=gap
    )


def _relations(chain: Screws) -> _Relations:
    parallel, gaps, meet = [], [], []
    for n1, n2, p1, p2 in zip(chain.axes, chain.axes[1:], chain.points, chain.points[1:]):
        common = np.cross(n1, n2)
        sine = float(np.linalg.norm(common))
        apart = p2 - p1
        if sine < PARALLEL:
            parallel.append(True)
            gaps.append(float(np.linalg.norm(apart - (apart @ n1) * n1)))
            meet.append(None)
            continue
        # The grade-4 part of the product of the lines is their mutual moment: distance times sine.
        parallel.append(False)
        gaps.append(abs(float(apart @ common)) / sine)
        system = np.array([[1.0, -(n1 @ n2)], [n1 @ n2, -1.0]])
        s, t = np.linalg.solve(system, [apart @ n1, apart @ n2])
        meet.append(0.5 * (p1 + s * n1 + p2 + t * n2))
    return _Relations(tuple(parallel), tuple(gaps), tuple(meet))


def _skew(chain: Screws) -> float:
    """Largest sine between consecutive axes that count as parallel but are not quite, times a metre."""
    sines = [float(np.linalg.norm(np.cross(a, b))) for a, b in zip(chain.axes, chain.axes[1:])]
    return max([s for s in sines if s < PARALLEL], default=0.0)


def _seven(chain: Screws, r: _Relations, tolerance: float) -> Structure | None:
    shoulder, wrist = r.spherical(0, tolerance), r.spherical(4, tolerance)
    if shoulder and wrist:
        S, W = shoulder[0], wrist[0]
        n4, p4 = chain.axes[3], chain.points[3]
        E = p4 + ((S - p4) @ n4) * n4
        offset = r.meet[2] is None or r.meet[3] is None or np.linalg.norm(r.meet[2] - r.meet[3]) > GAP
        if np.linalg.norm(np.cross(E - S, W - S)) < 1e-9 and np.linalg.norm(E - S) < 1e-9:
            return None
        return Structure(
            "srs7", ("shoulder", "elbow", "wrist"), "psi",
            reasons=(
                "axes 1, 2, 3 meet in the shoulder",
                "axes 5, 6, 7 meet in the wrist",
                "the elbow is offset" if offset else "axes 3, 4, 5 meet in the elbow",
            ),
            gap=max(shoulder[1], wrist[1]), special=np.array([S, W, E]),
        )  # fmt: skip
    if shoulder and r.meets(4, tolerance) and r.meet[4] is not None:
        return Structure(
            "sew7", ("elbow", "wrist", "shoulder"), "q7",
            reasons=("axes 1, 2, 3 meet in the shoulder", "axes 5, 6 meet"),
            gap=max(shoulder[1], r.gap[4]), special=np.array([shoulder[0], r.meet[4]]),
        )  # fmt: skip
    return None


def _six(chain: Screws, r: _Relations, tolerance: float) -> Structure | None:
    wrist = r.spherical(3, tolerance)
    if wrist:
        rules = (
            (r.parallel[1], 0, "axes 2, 3 are parallel", None),
            (r.meets(0, tolerance), 1, "axes 1, 2 meet", r.meet[0]),
            (r.parallel[0], 2, "axes 1, 2 are parallel", None),
            (r.meets(1, tolerance), 3, "axes 2, 3 meet", r.meet[1]),
        )
        for holds, mode, words, point in rules:
            if holds:
                gap = max(wrist[1], r.gap[0] if mode == 1 else r.gap[1] if mode == 3 else 0.0)
                return Structure(
                    "spherical6", ("shoulder", "elbow", "wrist"), reasons=("axes 4, 5, 6 meet in the wrist", words),
                    gap=gap, special=np.array([wrist[0], np.zeros(3) if point is None else point]), mode=mode,
                )  # fmt: skip
    if r.parallel[1] and r.parallel[2] and r.meets(4, tolerance) and r.meet[4] is not None:
        return Structure(
            "parallel6", ("shoulder", "wrist", "elbow"), reasons=("axes 2, 3, 4 are parallel", "axes 5, 6 meet"),
            gap=r.gap[4], special=np.array([r.meet[4]]),
        )  # fmt: skip
    return None


def _five(chain: Screws, r: _Relations, tolerance: float) -> Structure | None:
    elbow = r.spherical(2, tolerance)
    if elbow and r.meets(0, tolerance) and r.meet[0] is not None:
        return Structure(
            "us5", ("shoulder", "wrist"),
            reasons=("axes 1, 2 meet in the shoulder", "axes 3, 4, 5 meet in the elbow", "poses form a 5-dimensional set"),
            gap=max(elbow[1], r.gap[0]), special=np.array([r.meet[0], elbow[0]]),
        )  # fmt: skip
    return None


_READERS = {5: _five, 6: _six, 7: _seven}


def _why_not(chain: Screws) -> str:
    r = _relations(chain)
    words = []
    for i, (parallel, gap) in enumerate(zip(r.parallel, r.gap)):
        relation = "parallel" if parallel else "meet" if gap <= GAP else f"miss by {1e3 * gap:.4g} mm"
        words.append(f"{i + 1}-{i + 2} {relation}")
        before, here = (r.meet[i - 1] if i else None), r.meet[i]
        if before is not None and here is not None and max(r.gap[i - 1], gap) <= GAP:
            apart = float(np.linalg.norm(here - before))
            if apart > GAP:  # three axes that meet in pairs and not in one point: what a wrist lacks
                words[-1] += f" ({1e3 * apart:.4g} mm from where {i}-{i + 1} meet)"
    return "no structure with a closed form here (axes " + ", ".join(words) + ")"
