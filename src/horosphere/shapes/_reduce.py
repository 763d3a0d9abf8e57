"""A large point cloud made small, all points inside: one ball a cell of a grid, with the slack, or so many balls at most."""

from __future__ import annotations

from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..numeric import float_array, whole_number
from ._base import Floats, number
from ._forest import grow
from ._sampled import PointCloud


class Reduced(NamedTuple):
    """A cloud that holds another, and how far (m) a point of it can be from that other one."""

    cloud: PointCloud
    slack: float


def reduce_cloud(points: PointCloud | ArrayLike, voxel: float, radius: float = 0.0, name: str = "") -> Reduced:
    """One ball a cell of side `voxel` (m) with points in it, round all of them. A million points take under a second.

    points: a `PointCloud`, or (m, 3) with balls of `radius` (m). A ball of radius R about c reaches at most
    R + min(|c - p| - r) beyond the balls (p, r) that it holds; the slack is the largest of these. Raises InputError.
    """
    cloud = (
        points
        if isinstance(points, PointCloud)
        else PointCloud(float_array(points, "points", last=3, ndim=2), radius, name)
    )
    side = number(voxel, "voxel", positive=True)
    low = cloud.points.min(axis=0)
    extent = float(np.ptp(cloud.points, axis=0).max())
    if extent / side >= 1 << 20:
        raise InputError(
            f"a cloud of {extent:g} m cut into cells of {side:g} m has too many of them",
            place="voxel",
            remedy=f"give at least {extent / (1 << 20):.3g} m",
        )
    cell = ((cloud.points - low) / side).astype(np.int64)
    key = (cell[:, 0] << 42) | (cell[:, 1] << 21) | cell[:, 2]
    order = np.argsort(key)
    key, x = key[order], cloud.points[order]
    r = np.broadcast_to(cloud.radius, len(x))[order]
    starts = np.concatenate([[0], np.flatnonzero(key[1:] != key[:-1]) + 1])
    counts = np.diff(np.append(starts, len(x)))
    centre = 0.5 * (np.minimum.reduceat(x, starts) + np.maximum.reduceat(x, starts))
    away = np.linalg.norm(x - np.repeat(centre, counts, axis=0), axis=1)
    radii = np.maximum.reduceat(away + r, starts)
    slack = float((radii + np.minimum.reduceat(away - r, starts)).max())
    # rounding must not put a point outside; a cell with one point keeps its ball to the last bit
    radii = np.where(counts > 1, radii * (1.0 + 1e-12), radii)
    return Reduced(PointCloud(centre, radii, name or cloud.name), max(slack, 0.0))


def few_balls(cloud: PointCloud, most: int) -> tuple[Floats, Floats]:
    """Centres (k, 3) and radii (k,) of at most `most` balls that hold all balls of a cloud; the balls themselves if they are few.

    Nodes of the cloud's tree: the largest is divided again and again. Uses the index that distances need anyway.
    """
    if not isinstance(cloud, PointCloud):
        raise InputError(f"expected a PointCloud, got {type(cloud).__name__}", place="cloud")
    most = whole_number(most, "most", 1)
    if len(cloud.points) <= most:
        return cloud.points, np.broadcast_to(cloud.radius, len(cloud.points))
    rows, (nodes, ends, balls, _) = grow(cloud)
    radii, first = nodes[:, 3].tolist(), int(rows[0, 7]) - 1  # the first leaf
    heap, single = [(-radii[0], 0)], []
    while heap and len(heap) + len(single) < most:
        node = heappop(heap)[1]
        if node < first:
            for child in (2 * node + 1, 2 * node + 2):
                heappush(heap, (-radii[child], child))
        elif len(heap) + len(single) + ends[node - first + 1] - ends[node - first] <= most:
            single += range(ends[node - first], ends[node - first + 1])
        else:
            heappush(heap, (-radii[node], node))
            break
    kept = np.concatenate([nodes[[node for _, node in heap]].reshape(-1, 4), balls[np.array(single, np.int64)]])
    return kept[:, :3].copy(), kept[:, 3].copy()
