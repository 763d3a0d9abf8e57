"""Continuous-time clearance of a joint path, from arrays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..distance import allowance, pack_obstacles, pack_robot, rounding_slack
from ..errors import InputError
from ..numeric import float_array
from ..robots import Robot
from ..robots._robot import require_robot

Floats = NDArray[np.float64]
RESOLUTION = 1e-9
MAX_GAPS = 256


@dataclass(frozen=True, slots=True)
class PathPoint:
    """A moment of a path and the pair of bodies nearest to each other there.

    `segment`, `fraction`: between waypoints `segment` and `segment + 1`; `clearance` m; `link`, `other` names.
    """

    segment: int
    fraction: float
    clearance: float
    link: str
    other: str


@dataclass(frozen=True, slots=True)
class Gap:
    """A stretch of a segment whose clearance could not be bounded above the margin; `bound` is what could be shown (m)."""

    segment: int
    start: float
    stop: float
    bound: float


@dataclass(frozen=True, slots=True)
class ClearanceBound:
    """What is known of the least clearance of a path (m).

    `lower` <= least clearance <= `upper`; `nearest`: where `upper` was seen (None if there is nothing to touch);
    `violation`: first moment below the margin, to 1e-12 of its segment, or None; `unresolved`: see `Gap`; `slack`: what was
    taken off for rounding; `evaluations`: configurations looked at.
    """

    lower: float
    upper: float
    margin: float
    nearest: PathPoint | None
    violation: PathPoint | None
    unresolved: tuple[Gap, ...]
    slack: float
    evaluations: int

    @property
    def holds(self) -> bool:
        """Whether the whole path keeps at least the margin."""
        return self.lower >= self.margin


def clearance_bound(
    robot: Robot,
    waypoints: ArrayLike,
    obstacles: Any = (),
    margin: float = 0.0,
    *,
    self_collision: bool = False,
    static: bool = True,
    tolerance: float = 5e-4,
    relative: float = 0.05,
    max_evaluations: int = 200_000,
) -> ClearanceBound:
    """Bounds of the least clearance while the joints run straight through the waypoints (k, n), for all times between them.

    The gap between the bounds is at most max(`tolerance` metres, `relative` times the clearance), unless evaluations run out.
    For q within h of q_m, a point of a link moves at most sum_j h_j rho_j, rho_j its distance to axis j at q_m plus what the
    joints beyond j can move it; intervals are bisected until that is less than the clearance to spare. Float64 with a
    rounding slack. `self_collision` takes `robot.self_pairs` in; leave `obstacles` empty for these alone.
    Without `static`, bodies that no joint moves meet no obstacle; pairs of `robot.allowed_obstacles` are not looked at.
    Raises InputError. Our derivation, docs/certificate.md.
    """
    robot, margin = require_robot(robot), float(float_array(margin, "margin", ndim=0, finite=False))
    W = float_array(waypoints, "waypoints", last=robot.n_joints, ndim=2)
    if len(W) == 0:
        raise InputError("expected at least one waypoint", place="waypoints")
    if not (np.isfinite(margin) and tolerance > 0.0 and relative >= 0.0 and max_evaluations > 0):
        raise InputError(
            "expected a finite margin, a tolerance > 0, relative >= 0, evaluations > 0", place="clearance_bound"
        )
    W = W if W.flags.writeable else W.copy()
    body, solids = pack_robot(robot, static), pack_obstacles(obstacles)
    pairs = body.pairs if self_collision else body.pairs[:0]
    slack, blur = rounding_slack(body, solids, W)
    if not len(body.capsules) or not (len(solids.rows) or len(pairs)):
        return ClearanceBound(math.inf, math.inf, float(margin), None, None, (), slack, 0)
    kinds = np.array([tolerance, relative])
    out, gaps = np.zeros(9), np.zeros((MAX_GAPS, 4))
    from ._bound_kernels import bound_path

    def run(first: bool) -> None:
        bound_path(
            *body[:4],
            solids.rows,
            pairs,
            W,
            margin,
            slack,
            blur,
            kinds,
            RESOLUTION,
            max_evaluations,
            first,
            gaps,
            out,
            (*solids.extra, allowance(robot, solids)),
        )

    def point() -> PathPoint | None:
        if out[4] < 0:
            return None
        item, other = int(out[4]), int(out[5])
        if other < len(solids.rows):
            what = solids.names[solids.owner[other]]
        else:
            what = robot.links[robot.capsules.link[pairs[other - len(solids.rows), 1]]].name
        link = robot.links[robot.capsules.link[item]].name
        return PathPoint(int(out[2]), float(out[3]), float(out[1]), link, what)

    run(False)
    lower, upper, evaluations = float(out[0]), float(out[1]), int(out[6])
    unresolved = tuple(
        Gap(int(g[0]), float(g[1]), float(g[2]), float(g[3])) for g in gaps[: int(min(out[7], MAX_GAPS))]
    )
    if out[7] > MAX_GAPS:
        unresolved += (Gap(unresolved[-1].segment, unresolved[-1].stop, 1.0, float(out[8])),)
    nearest, violation = point(), None
    if upper + slack < margin:
        run(True)
        violation, evaluations = point(), evaluations + int(out[6])
        unresolved = ()
    return ClearanceBound(lower, upper, float(margin), nearest, violation, unresolved, slack, evaluations)
