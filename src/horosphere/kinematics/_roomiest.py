"""The choice of a redundancy: for every branch the value with the most room to joint limits and obstacles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ._classify import classify
from ._free_arcs import Constraints, redundancy
from ._inverse import inverse
from ._solutions import IkSolutions

Floats = NDArray[np.float64]
_NODES, _ROUNDS = 16, 12


def roomiest(
    robot: Any, target: Any, obstacles: Any = (), clearance: float = 0.0, *, metres_per_radian: float = 0.1
) -> IkSolutions:
    """For every branch the value of its redundancy (psi, q7, q1 or phi) with the most room: one row a branch, the value in `.free`.

    The room is the smaller of the least distance of a joint to its limits, radians, and of the least clearance beyond
    `clearance` from sphere obstacles, metres, divided by `metres_per_radian`. A row is valid where its branch exists; the flag
    "free" says that its room is positive. 16 Chebyshev nodes in each interval in which the branch exists, then a search around
    the best. Without obstacles `inverse` does the same faster. Raises InputError as `free_arcs` does.
    """
    if not metres_per_radian > 0.0:
        raise InputError(f"expected a positive number, got {metres_per_radian}", place="metres_per_radian")
    one = redundancy(robot, target)
    values = Constraints(robot, obstacles, clearance, limits=True)
    unit = np.ones(len(values.speed))
    unit[2 * robot.n_joints :] = metres_per_radian
    middle, half = 0.5 * (one.ends[1:] + one.ends[:-1]), 0.5 * np.diff(one.ends)
    pick = np.arange(one.branches)

    def room(at: Floats) -> Floats:
        """(m, branches) of the values (m, branches)."""
        q, exists = one.rows(at.reshape(-1))
        own = np.tile(pick, len(at))
        q, exists = q[np.arange(at.size), own], exists[np.arange(at.size), own]
        return np.where(exists, (values(q) / unit).min(axis=-1), -np.inf).reshape(at.shape)

    theta = (np.arange(_NODES) + 0.5) * np.pi / _NODES
    nodes = (middle[:, None] - half[:, None] * np.cos(theta)).reshape(-1)
    rooms = room(np.repeat(nodes[:, None], one.branches, axis=1))
    best = np.argmax(rooms, axis=0)
    at, top = nodes[best], rooms[best, pick]
    width = np.repeat(half, _NODES)[best] * np.pi / _NODES
    for _ in range(_ROUNDS):
        trial = at + width * np.linspace(-1.0, 1.0, 5)[:, None]
        rooms = room(trial)
        best = np.argmax(rooms, axis=0)
        better = rooms[best, pick] > top
        at, top = np.where(better, trial[best, pick], at), np.where(better, rooms[best, pick], top)
        width *= 0.5
    at = np.pi - np.mod(np.pi - at, 2.0 * np.pi)
    given: dict[str, Any] = {one.parameter: at}
    found = inverse(robot, target, **given)
    reason = "" if np.isfinite(top).any() else str(found.reason[0])
    return IkSolutions(
        found.q[pick, pick].copy(), found.valid[pick, pick], found.branch, lambda: found.residual[pick, pick], True, reason,
        bits=classify(robot).bits, flags={"free": top > 0.0}, free=at,
    )  # fmt: skip
