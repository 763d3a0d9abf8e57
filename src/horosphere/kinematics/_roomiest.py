"""The choice of a redundancy: for every branch the value with the most room to joint limits and obstacles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..distance import signed
from ..errors import InputError
from ..numeric import wrap_angle
from ._arcs import Arcs
from ._classify import classify
from ._free_arcs import proved_arcs
from ._inverse import inverse
from ._redundant import redundancy
from ._solutions import IkSolutions

Floats = NDArray[np.float64]
_NODES, _ROUNDS = 16, 12


def roomiest(
    robot: Any,
    target: Any,
    obstacles: Any = (),
    clearance: float = 0.0,
    *,
    self_clearance: float | None = None,
    metres_per_radian: float = 0.1,
) -> IkSolutions:
    """For every branch the value of its redundancy (psi, q7, q1 or phi) with the most room: one row a branch, the value in `.free`.

    The room is the smallest of the least distance of a joint to its limits, radians, and of the least clearance beyond
    `clearance` from the obstacles and beyond `self_clearance` between the robot's own links (None: not looked at), metres,
    divided by `metres_per_radian`; obstacles as in `free_arcs`. A row is valid where its branch exists. Flags: "free", its room is
    positive; "best", the free row with the most room; where no row is free, `.reason` says what the nearest one lacks.
    It is looked for at 16 Chebyshev nodes in each interval in which the branch exists and in each of its `free_arcs`, so that a
    branch with a free arc has a free row, then around the best. Without obstacles `inverse` does the same faster. Raises
    InputError as `free_arcs` does.
    """
    if not metres_per_radian > 0.0:
        raise InputError(f"expected a positive number, got {metres_per_radian}", place="metres_per_radian")
    one = redundancy(robot, target)
    arcs = proved_arcs(one, obstacles, clearance, self_clearance)
    pick = np.arange(one.branches)

    def margins(q: Floats) -> Floats:
        """(3, m) joint margins, and what the clearances are beyond the wanted ones."""
        joints = np.minimum(q - robot.limits.lower, robot.limits.upper - q).min(axis=-1)
        outer = signed(robot, q, obstacles, static=False) - clearance
        inner = np.full(len(q), np.inf)
        if self_clearance is not None:
            inner = signed(robot, q, (), self_collision=True) - self_clearance
        return np.stack([joints, outer / metres_per_radian, inner / metres_per_radian])

    def room(at: Floats) -> Floats:
        """(m, branches) of the values (m, branches)."""
        q, exists = one.rows(at.reshape(-1))
        own = np.tile(pick, len(at))
        q, exists = q[np.arange(at.size), own], exists[np.arange(at.size), own]
        found = np.full(at.size, -np.inf)
        found[exists] = margins(np.ascontiguousarray(q[exists])).min(axis=0)
        return found.reshape(at.shape)

    nodes, widths = _nodes(one.ends, arcs)
    rooms = room(nodes)
    best = np.argmax(rooms, axis=0)
    at, top, width = nodes[best, pick], rooms[best, pick], widths[best, pick]
    for _ in range(_ROUNDS):
        trial = at + width * np.linspace(-1.0, 1.0, 5)[:, None]
        rooms = room(trial)
        best = np.argmax(rooms, axis=0)
        better = rooms[best, pick] > top
        at, top = np.where(better, trial[best, pick], at), np.where(better, rooms[best, pick], top)
        width *= 0.5
    at = wrap_angle(at)
    given: dict[str, Any] = {one.parameter: at}
    found = inverse(robot, target, **given)
    q, free, first = found.q[pick, pick].copy(), top > 0.0, int(np.argmax(top))
    reason = ""
    if not (top > -np.inf).any():
        reason = str(found.reason[0])
    elif not free.any():
        joints, outer, inner = margins(q[first : first + 1])[:, 0]
        least = f"the nearest, {found.name(first)} at {one.parameter} = {at[first]:.4g}, "
        reason = "no branch is free: " + least + _lack(joints, outer * metres_per_radian, inner * metres_per_radian)
    return IkSolutions(
        q, found.valid[pick, pick], found.branch, lambda: found.residual[pick, pick], True, reason,
        bits=classify(robot).bits, flags={"free": free, "best": free & (pick == first)}, free=at,
    )  # fmt: skip


def _nodes(ends: Floats, arcs: tuple[Arcs, ...]) -> tuple[Floats, Floats]:
    """Values (m, branches) to begin with, and the distance to their neighbours."""
    theta = (np.arange(_NODES) + 0.5) * np.pi / _NODES
    most = max((len(a.free) for a in arcs), default=0)
    spans = np.zeros((len(ends) - 1 + most, len(arcs), 2))
    spans[: len(ends) - 1] = np.stack([ends[:-1], ends[1:]], axis=-1)[:, None]
    for k, arc in enumerate(arcs):
        spans[len(ends) - 1 :, k] = spans[0, k]  # twice does no harm
        spans[len(ends) - 1 : len(ends) - 1 + len(arc.free), k] = arc.free
    middle, half = 0.5 * spans.sum(axis=-1), 0.5 * (spans[..., 1] - spans[..., 0])
    nodes = middle[:, None] - half[:, None] * np.cos(theta)[:, None]
    widths = np.broadcast_to(half[:, None] * np.pi / _NODES, nodes.shape)
    return nodes.reshape(-1, len(arcs)), widths.reshape(-1, len(arcs)).copy()


def _lack(joints: float, outer: float, inner: float) -> str:
    """What a posture is short of, in words."""
    parts = [f"misses the joint limits by {-joints:.4g} rad"] if joints <= 0.0 else []
    for value, what in ((outer, "from the obstacles"), (inner, "between its links")):
        if value <= 0.0:
            parts.append(f"lacks {-value:.4g} m of the clearance wanted {what}")
    return " and ".join(parts)
