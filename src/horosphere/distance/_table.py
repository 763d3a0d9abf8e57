"""Which body of the robot is how far from which obstacle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..numeric import number
from ..robots import Robot
from ._pack import pack_robot
from ._signed import allowance, configurations, pack_obstacles

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Contact:
    """One pair of bodies: a link of the robot, what it is near to, their signed distance (m), and the witness points (3,)."""

    link: str
    body: int
    other: str
    distance: float
    point: Floats
    other_point: Floats

    def __str__(self) -> str:
        return f"{self.link} to {self.other}: {self.distance:.4f} m"


@dataclass(frozen=True, slots=True, eq=False)
class DistanceTable:
    """Signed distances of every capsule of the robot (rows) to every obstacle (columns), in metres, world frame.

    Attributes
    ----------
    distance: (..., m, k); `points`, `other_points`: (..., m, k, 3) the witnesses on the surfaces of capsule and obstacle.
    links: (m,) name of the link of each capsule; obstacles: (k,) names.
    self_distance: (..., p), with `self_points`, `self_other_points` (..., p, 3) and `self_names` (p,) pairs of link names.
    """

    links: tuple[str, ...]
    obstacles: tuple[str, ...]
    distance: Floats
    points: Floats
    other_points: Floats
    self_names: tuple[tuple[str, str], ...]
    self_bodies: NDArray[np.int64]
    self_distance: Floats
    self_points: Floats
    self_other_points: Floats

    def contacts(self, below: float = np.inf) -> list[Contact]:
        """All pairs nearer than `below` (m), nearest first; of a batch, the nearest configuration of each pair."""
        below = number(below, "below")
        m, k = len(self.links), len(self.obstacles)
        found = []
        flat = self.distance.reshape(math.prod(self.distance.shape[:-2]), m, k)
        for i, j in np.ndindex(m, k) if flat.size else ():
            b = int(flat[:, i, j].argmin())
            if flat[b, i, j] < below:
                x, y = self.points.reshape(-1, m, k, 3)[b, i, j], self.other_points.reshape(-1, m, k, 3)[b, i, j]
                found.append(Contact(self.links[i], i, self.obstacles[j], float(flat[b, i, j]), x, y))
        own = self.self_distance.reshape(len(flat), len(self.self_names))
        for p, (first, second) in enumerate(self.self_names if own.size else ()):
            b = int(own[:, p].argmin())
            if own[b, p] < below:
                x, y = (
                    a.reshape(-1, len(self.self_names), 3)[b, p] for a in (self.self_points, self.self_other_points)
                )
                found.append(Contact(first, int(self.self_bodies[p, 0]), second, float(own[b, p]), x, y))
        return sorted(found, key=lambda contact: contact.distance)

    def nearest(self) -> Contact | None:
        """The nearest pair of all, None if there is none."""
        contacts = self.contacts()
        return contacts[0] if contacts else None


def table(
    robot: Robot, q: ArrayLike, obstacles: Any, *, self_collision: bool = True, static: bool = True
) -> DistanceTable:
    """Signed distances of all pairs at q (..., n), with witness points and names; see `signed` for what they mean.

    A point cloud is one obstacle: its nearest ball. Raises InputError.
    """
    from ._body_kernels import table_into

    Q = configurations(robot, q)
    body, solids = pack_robot(robot, static), pack_obstacles(obstacles)
    flat, m, s = Q.reshape(math.prod(Q.shape[:-1]), robot.n_joints), len(body.frames), len(solids.rows)
    pairs = body.pairs if self_collision else body.pairs[:0]
    extra = (*solids.extra, allowance(robot, solids))
    W = np.empty((len(flat), m * s + len(pairs), 7))
    for b in range(len(flat)):
        table_into(body.joints, body.constants, body.frames, body.capsules, solids.rows, pairs, flat[b], W[b], extra)
    radius = body.capsules[:, 6]
    # the axis point moved along n by its own radius, and on by the distance, gives the two witnesses
    first = np.concatenate((np.repeat(radius, s), radius[pairs[:, 0]]))
    points = W[..., 1:4] - first[:, None] * W[..., 4:7]
    gap = np.where(np.isfinite(W[..., :1]), W[..., :1], 0.0)  # infinite: a body that meets no obstacle
    other_points = points - gap * W[..., 4:7]
    lead = Q.shape[:-1]

    def grid(values: Floats) -> Floats:
        return values[:, : m * s].reshape(len(flat), m, s, *values.shape[2:])

    distance, nearest = _by_owner(grid(W[..., 0]), solids.owner, len(solids))
    links = tuple(robot.links[k].name for k in robot.capsules.link)

    def pick(values: Floats) -> Floats:
        chosen = np.take_along_axis(grid(values), nearest[..., None], axis=2)
        return chosen.reshape(*lead, m, len(solids), 3)

    return DistanceTable(
        links=links,
        obstacles=solids.names,
        distance=distance.reshape(*lead, m, len(solids)),
        points=pick(points),
        other_points=pick(other_points),
        self_names=tuple((links[i], links[j]) for i, j, _ in pairs),
        self_bodies=pairs[:, :2],
        self_distance=W[:, m * s :, 0].reshape(*lead, len(pairs)),
        self_points=points[:, m * s :].reshape(*lead, len(pairs), 3),
        self_other_points=other_points[:, m * s :].reshape(*lead, len(pairs), 3),
    )


def _by_owner(distance: Floats, owner: NDArray[np.int64], count: int) -> tuple[Floats, NDArray[np.int64]]:
    """(b, m, rows) -> least distance and its row for each obstacle, (b, m, count)."""
    best = np.empty((*distance.shape[:2], count))
    row = np.empty(best.shape, np.int64)
    for k in range(count):
        mine = np.flatnonzero(owner == k)
        at = distance[..., mine].argmin(axis=-1)
        row[..., k] = mine[at]
        best[..., k] = np.take_along_axis(distance[..., mine], at[..., None], axis=-1)[..., 0]
    return best, row
