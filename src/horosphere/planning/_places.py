"""Where the tool may be at a goal that leaves it free: a point, the points of a line or of a plane within the arm's reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kinematics._numeric import reach
from ..kinematics._tree import chain
from ..robots import Robot
from ..scenes import LineTarget, PlaneTarget, PositionTarget
from ..versors import Motor

Floats = NDArray[np.float64]

_STEPS = {1: (0.6180339887498949,), 2: (0.7548776662466927, 0.5698402909980532)}
"""Of the evenly spread sequences in one dimension (golden ratio) and in two (Roberts' R2)."""


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """The part of a goal that the arm spans: a point, a segment or a disc, about `center` (3,) along `axes` (d, 3), in metres.

    `first` (k, 3): places that are looked at before others: the nearest to the tool at the start, the goal's own point, the
    nearest to the first joint. `is_beyond`: the goal is further away than the arm spans.
    """

    first: Floats
    center: Floats
    axes: Floats
    radius: float
    is_beyond: bool = False
    noun: str = "the point"

    def spread(self, begin: int, count: int, share: float, shift: Floats) -> Floats:
        """Points (count, 3), evenly over the part of the goal that a `share` of its size about its first place leaves.

        They are number `begin` and on of a sequence without end, moved by `shift` (2,) in its unit square.
        """
        d = len(self.axes)
        if d == 0:
            return np.repeat(self.first[:1], count, axis=0)
        numbers = np.arange(begin, begin + count)[:, None]
        u = (shift[:d] + numbers * _STEPS[d]) % 1.0
        at: Floats = 2.0 * u - 1.0
        if d == 2:  # equal areas of the disc
            turn = 2.0 * np.pi * u[:, 1]
            at = np.sqrt(u[:, :1]) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        points: Floats = self.center + self.radius * at @ self.axes
        return self.first[0] + share * (points - self.first[0])


def places_of(robot: Robot, target: PositionTarget | LineTarget | PlaneTarget, tool: Floats | None) -> Places:
    """The places of a goal; `tool` (3,): where the tool is at the start, if that is known."""
    if isinstance(target, PositionTarget):
        return Places(target.position[None], target.position, np.zeros((0, 3)), 0.0)
    base = Motor._wrap(chain(robot).origins[0].copy()).as_matrix()[:3, 3]
    own: list[Floats] = []
    if isinstance(target, LineTarget):
        axes, noun = target.direction[None], "the line"
        center = target.point + (base - target.point) @ target.direction * target.direction
        own = [target.point]
    else:
        axes, noun = _across(target.normal), "the plane"
        center = base + (target.distance - base @ target.normal) * target.normal
    away, span = float(np.linalg.norm(center - base)), reach(robot)
    radius = float(np.sqrt(max(span**2 - away**2, 0.0)))
    found = []
    for point in ([] if tool is None else [tool]) + own:
        along = (point - center) @ axes.T
        far = float(np.linalg.norm(along))
        if far <= radius or point is tool:
            found.append(center + along * min(1.0, radius / max(far, 1e-300)) @ axes)
    return Places(np.array([*found, center]), center, axes, radius, away > span, noun)


def _across(normal: Floats) -> Floats:
    """Two unit vectors (2, 3) square to each other and to a normal."""
    axes = np.zeros((2, 3))
    axes[0] = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    axes[0] /= np.linalg.norm(axes[0])
    axes[1] = np.cross(normal, axes[0])
    return axes
