"""Bodies about given axes that hold a solid: the proof of a cover, piece by piece."""

from __future__ import annotations

import numpy as np

from ._bodies import GRAIN, Body, Floats, distance_to_axis
from ._search_kernels import corners_within
from ._solid import Solid, corners_of

CUTS = 4
"""Times that a piece which no body holds is cut, before a body grows for it."""


def bodies_about(solid: Solid, axes: Floats, depth: Floats, slack: float) -> list[Body]:
    """Capsules about axes (k, 6) at depths (k,) that hold all of the solid, with about this slack.

    A capsule is convex: it holds a piece if it holds its corners. The triangles of the surface, and boxes over what it encloses,
    are cut until each lies in one body; what does not after some cuts enlarges the body that must grow least. Then each piece is
    given to the body that stands out least for it, and every body shrinks to what it was given.
    """
    radius, pieces = depth + slack, []
    for shape, cut in ((solid.triangles, _quarters), (solid.boxes, _octants)):
        rest = shape
        for level in range(CUTS + 1):
            needs = _needs(rest, axes)
            held = np.asarray((needs <= radius[:, None]).any(axis=0))
            if level == CUTS and not held.all():
                owner = (needs - radius[:, None])[:, ~held].argmin(axis=0)
                np.maximum.at(radius, owner, needs[:, ~held][owner, np.arange(len(owner))])
                held[:] = True
            pieces.append((rest[held], (needs[:, held] - depth[:, None]).argmin(axis=0)))
            rest = rest[~held]
            if not len(rest):
                break
            rest = cut(rest)
    bodies = []
    for k in range(len(axes)):
        own = [part[owner == k].reshape(-1, 3) for part, owner in pieces]
        points = np.concatenate(own)
        if len(points):
            bodies.append(_shortened(points, Body(axes[k, :3], axes[k, 3:], 0.0)))
    return bodies


def _needs(pieces: Floats, axes: Floats) -> Floats:
    """Radius (k, m) that a body about each axis needs to hold each piece (m, c, 3)."""
    out = np.empty((len(axes), len(pieces)))
    corners_within(pieces, axes, out)
    return out


def _shortened(points: Floats, body: Body) -> Body:
    """The shortest capsule on an axis that holds points, with no larger radius than the whole axis needs."""
    radius = float(distance_to_axis(points, body).max()) + GRAIN
    u = body.b - body.a
    length = float(np.linalg.norm(u))
    if length < 1e-9:
        return Body(body.a, body.b, radius)
    u = u / length
    along = (points - body.a) @ u
    square = ((points - body.a) ** 2).sum(axis=1) - along**2
    give = np.sqrt(np.maximum(radius**2 - square, 0.0))
    low, high = float((along + give).min()), float((along - give).max())
    if low > high:
        low = high = 0.5 * (low + high)
    low, high = (float(np.clip(value, 0.0, length)) for value in (low, high))
    short = Body(body.a + low * u, body.a + high * u, 0.0)
    return Body(short.a, short.b, float(distance_to_axis(points, short).max()) + GRAIN)


def _quarters(triangles: Floats) -> Floats:
    """Four triangles for each (m, 3, 3), cut at the middles of the edges."""
    middles = 0.5 * (triangles + np.roll(triangles, -1, axis=1))
    corners = [np.stack([triangles[:, k], middles[:, k], middles[:, k - 1]], axis=1) for k in range(3)]
    return np.ascontiguousarray(np.concatenate([*corners, middles]))


def _octants(boxes: Floats) -> Floats:
    """Eight boxes for each (m, 8, 3), as corners."""
    low, high = boxes.min(axis=1), boxes.max(axis=1)
    middle = 0.5 * (low + high)
    lows = corners_of(low, middle)  # the lowest corners of the eight
    half = 0.5 * (high - low)
    return corners_of(lows.reshape(-1, 3), (lows + half[:, None]).reshape(-1, 3))
