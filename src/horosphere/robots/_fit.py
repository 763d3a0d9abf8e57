"""A greedy cover of a mesh by balls or capsules: few of them, all of the mesh inside, and a bound of how far they stand out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._bodies import GRAIN, Body, Floats, distance_to_axis, enclosing_center
from ._candidates import Axes, depth_along, make_candidates
from ._need_kernels import needs_of
from ._slack import slack_of
from ._solid import Solid

ROUNDS = 1
MOST_HARD = 1_000
"""Pieces that no candidate holds are candidates themselves, so many at most."""


def cover_solid(
    solid: Solid, budget: int, tolerance: float, *, capsules: bool, seed: int = 0
) -> tuple[list[Body], float]:
    """At most `budget` bodies that hold the solid, no more than a slack of `tolerance` (m) needs, and their slack.

    A ball of radius r about a point at depth d stands out of the solid by at most r - d, and so does a capsule all of whose
    axis lies at least so deep. So for a slack e the body at each candidate is known, and the one that holds most of what is
    still bare is taken until nothing is; e is bisected to the least that the budget allows. Then every body shrinks onto what
    it alone has to hold. Our derivation.
    """
    axes = make_candidates(solid, capsules, tolerance, np.random.default_rng(seed))
    needs = _needs(solid, axes, solid.leading)
    hard = np.flatnonzero((needs - axes.depth).min(axis=1) > 0.9 * tolerance)
    if len(hard):
        places = solid.middles()[hard[:MOST_HARD]]
        more = Axes(places, places, solid.depth(places))
        axes, needs = axes.joined(more), np.concatenate([needs, _needs(solid, more, solid.leading)], axis=1)
    alone = needs.max(axis=0) - axes.depth
    one = int(alone.argmin())
    low = max(0.97 * tolerance, 1e-6)
    chosen = _greedy(needs, axes.depth + low, budget)
    if chosen is None:
        chosen, high = [one], max(float(alone[one]), low)
        for _ in range(12):
            middle = float(np.sqrt(low * high))
            found = _greedy(needs, axes.depth + middle, budget)
            if found is None:
                low = middle
            else:
                high, chosen = middle, found
            if high < 1.03 * low:
                break
    bodies = _shrink(solid, axes.chosen(chosen))
    return bodies, slack_of(bodies, solid)


def _needs(solid: Solid, axes: Axes, count: int | None = None) -> NDArray[np.float32]:
    """Radius (k, c) that a body about each axis needs to hold each of the first `count` pieces."""
    starts = np.append(solid.starts, len(solid.points))[: None if count is None else count + 1]
    result = np.empty((len(starts) - 1, len(axes.a)), np.float32)
    needs_of(solid.points, starts, np.ascontiguousarray(axes.a), np.ascontiguousarray(axes.b), result)
    return result


def _greedy(needs: NDArray[np.float32], radii: Floats, budget: int) -> list[int] | None:
    """Columns that hold all rows, the one that holds most of what is left first; None if the budget does not do."""
    holds = needs <= radii.astype(np.float32)
    counts = holds.sum(axis=0, dtype=np.int32)
    bare = np.ones(len(needs), bool)
    chosen: list[int] = []
    while bare.any():
        best = int(np.argmax(counts))
        if len(chosen) == budget or counts[best] == 0:
            return None
        chosen.append(best)
        new = bare & holds[:, best]
        counts -= holds[new].sum(axis=0, dtype=np.int32)
        bare &= ~new
    # what was taken first may be held by the others by now
    times = holds[:, chosen].sum(axis=1, dtype=np.int32)
    for column in list(chosen):
        if (times - holds[:, column] > 0).all():
            times -= holds[:, column]
            chosen.remove(column)
    return chosen


def _shrink(solid: Solid, axes: Axes) -> list[Body]:
    """Each piece goes to the body that it enlarges least; each ball moves to the middle of its pieces if that makes it stand
    out less, each axis is shortened to what its radius needs. The radii are exact for what each holds."""
    a, b, depth = axes.a.copy(), axes.b.copy(), axes.depth.copy()
    owner = np.zeros(0, np.int64)
    for _ in range(ROUNDS):
        need = _needs(solid, Axes(a, b, depth)).T
        owner = (need - depth[:, None]).argmin(axis=0)
        used = np.unique(owner)
        a, b, need, owner = a[used], b[used], need[used], np.searchsorted(used, owner)
        for k in range(len(a)):
            points = solid.points_of(owner == k)
            radius = float(need[k, owner == k].max())
            a[k], b[k] = _better(solid, points, Body(a[k], b[k], radius), float(depth[used[k]]))
        depth = depth_along(solid, a, b)
    bodies = []
    for k in np.unique(owner):
        body = Body(a[k], b[k], 0.0)
        radius = float(distance_to_axis(solid.points_of(owner == k), body).max()) + GRAIN
        bodies.append(Body(a[k], b[k], radius))
    return bodies


def _better(solid: Solid, points: Floats, body: Body, depth: float) -> tuple[Floats, Floats]:
    """Ends of an axis that is no worse for the points: shorter, or the middle of a small ball."""
    u = body.b - body.a
    length = float(np.linalg.norm(u))
    if length < 1e-9:
        centre = enclosing_center(points, 30)
        radius = float(np.linalg.norm(points - centre, axis=1).max())
        better = radius - solid.depth(centre[None])[0] < body.radius - depth
        return (centre, centre) if better else (body.a, body.b)
    u = u / length
    along = (points - body.a) @ u
    square = ((points - body.a) ** 2).sum(axis=1) - along**2
    give = np.sqrt(np.maximum(body.radius**2 - square, 0.0))
    low, high = float((along + give).min()), float((along - give).max())
    if low > high:
        low = high = 0.5 * (low + high)
    low, high = (float(np.clip(value, 0.0, length)) for value in (low, high))
    return body.a + low * u, body.a + high * u
