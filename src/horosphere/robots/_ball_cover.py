"""A greedy cover of a mesh by balls: few of them, all of the mesh inside, and a bound of how far they stand out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._bodies import GRAIN, Body, enclosing_center
from ._slack import slack_of
from ._solid import Solid

Floats = NDArray[np.float64]
CENTRES = 1_200
"""Places tried for centres, about."""


def cover_by_balls(solid: Solid, budget: int, tolerance: float, seed: int = 0) -> tuple[list[Body], float]:
    """At most `budget` balls that hold the solid, no more than a slack of `tolerance` (m) needs, and their slack.

    A ball of radius r about a point at depth d stands out of the solid by at most r - d. So for a slack e the ball at each
    candidate is known, and the one that holds most of what is still bare is taken until nothing is; e is bisected to the
    least that the budget allows. Then every ball shrinks onto what it alone has to hold. Our derivation.
    """
    rng = np.random.default_rng(seed)
    centres, depth = _candidates(solid, rng)
    needs = _needs(solid, centres)
    alone = needs.max(axis=0) - depth
    one = int(alone.argmin())
    low = max(tolerance, 1e-6)
    chosen = _greedy(needs, depth + low, budget)
    if chosen is None:
        chosen, high = [one], max(float(alone[one]), low)
        for _ in range(12):
            middle = float(np.sqrt(low * high))
            found = _greedy(needs, depth + middle, budget)
            if found is None:
                low = middle
            else:
                high, chosen = middle, found
            if high < 1.03 * low:
                break
    balls, radii = _shrink(solid, centres[chosen])
    bodies = [Body(c, c, float(r)) for c, r in zip(balls, radii)]
    return bodies, slack_of(bodies, solid)


def _candidates(solid: Solid, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Centres to try and their depths: cells deeper than those round them, any cells, points of the surface."""
    chosen = np.zeros((0, 3))
    if len(solid.inside):
        ways = [pool[rng.permutation(len(pool))[: CENTRES // 3]] for pool in (solid.deepest(), solid.inside)]
        chosen = np.concatenate(ways)
    skin = solid.vertices[rng.permutation(len(solid.vertices))[: max(CENTRES - len(chosen), CENTRES // 4)]]
    # between the surfaces of thin parts lies no cell: the middles of pieces do as well
    middles = solid.middles()
    middles = middles[rng.permutation(len(middles))[: CENTRES // 6]]
    centres = np.concatenate([chosen, skin, middles])
    return centres, solid.depth(centres)


def _needs(solid: Solid, centres: Floats) -> NDArray[np.float32]:
    """Radius (k, c) that a ball about each centre needs to hold each piece, in single precision, rounded up."""
    middle = solid.points.mean(axis=0)
    points, places = (solid.points - middle).astype(np.float32), (centres - middle).astype(np.float32)
    squares = (points**2).sum(axis=1)[:, None]
    result = np.empty((len(solid.starts), len(centres)), np.float32)
    for k in range(0, len(centres), 128):
        block = places[k : k + 128]
        distance = squares - 2.0 * (points @ block.T) + (block**2).sum(axis=1)
        result[:, k : k + 128] = np.maximum.reduceat(distance, solid.starts, axis=0)
    return np.sqrt(np.maximum(result, 0.0)) + np.float32(1e-6)


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
    return chosen


def _shrink(solid: Solid, centres: Floats, rounds: int = 6) -> tuple[Floats, Floats]:
    """Each piece goes to the ball that it enlarges least; each ball moves to the middle of its pieces if that makes it stand
    out less. The radii are exact for what each holds."""
    centres = centres.copy()
    radii = np.zeros(len(centres))
    for last in [False] * rounds + [True]:
        need = np.array([solid.most(np.linalg.norm(solid.points - c, axis=1)) for c in centres])
        owner = (need - solid.depth(centres)[:, None]).argmin(axis=0)
        used = np.unique(owner)
        centres, need = centres[used], need[used]
        owner = np.searchsorted(used, owner)
        radii = np.array([need[k, owner == k].max() for k in range(len(centres))])
        if last:
            break
        depth = solid.depth(centres)
        for k in range(len(centres)):
            points = solid.points_of(owner == k)
            centre = enclosing_center(points, 30)
            radius = float(np.linalg.norm(points - centre, axis=1).max())
            if radius - solid.depth(centre[None])[0] < radii[k] - depth[k]:
                centres[k] = centre
    return centres, radii + GRAIN
