"""From where a scene is looked at, and which obstacles have to be seen through: the robot must not move behind a wall."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from ._solids import Solid, box

Floats = NDArray[np.float64]

HIDDEN = 0.2
"""Share of the robot that may be hidden before another direction is looked for."""
TURNS, STEEP = 12, 1.5
"""Directions about the vertical that are tried, and by how much more the steeper ones look down."""
MOST_TRIANGLES = 3000
"""Solids with more are taken for the boxes round them."""

MOST_BLOCKS, FINEST = 100, 16
"""Of a cloud, and how many of them lie side by side at most."""


def look(view: Floats, up: Floats, points: Floats, solids: Mapping[int, Solid]) -> tuple[Floats, frozenset[int]]:
    """A direction towards the eye, and the keys of the solids that hide too much of `points` (k, 3) even so.

    `view` is kept where it is good enough; else it is turned about `up`. Where every direction is barred, all solids that bar
    one are named, so that the picture can be turned.
    """
    triangles = {k: _triangles(solid) for k, solid in solids.items()}
    best, least = view, _hidden(view, points, triangles)
    if not len(points) or least.any(axis=0).mean() <= HIDDEN:
        return view, frozenset()
    barring: set[int] = set()
    for other in _views(view, up):
        hidden = _hidden(other, points, triangles)
        barring |= {k for k, row in zip(triangles, hidden) if row.mean() > 0.5 * HIDDEN}
        if hidden.any(axis=0).mean() < least.any(axis=0).mean() - 1e-9:
            best, least = other, hidden
    return best, frozenset(barring) if least.any(axis=0).mean() > HIDDEN else frozenset()


def blocks(points: Floats) -> Solid:
    """A cloud (k, 3) as the boxes of a grid, at most MOST_BLOCKS, in which it has points."""
    low, size = points.min(axis=0), max(float(np.ptp(points, axis=0).max()), 1e-6)
    for cells in range(FINEST, 0, -1):
        width = size / cells
        filled = np.unique(np.minimum(((points - low) / width).astype(np.int64), cells - 1), axis=0)
        if len(filled) <= MOST_BLOCKS:
            break
    vertices, faces = box(np.zeros(3), np.full(3, 0.5 * width), np.eye(3))
    all_faces = faces + len(vertices) * np.arange(len(filled))[:, None, None]
    centers = low + width * (filled + 0.5)
    return (centers[:, None] + vertices).reshape(-1, 3), all_faces.reshape(-1, 3)


def _views(view: Floats, up: Floats) -> Iterator[Floats]:
    """Turned about the vertical, the nearest first; then the same from higher up."""
    level = view - up * (up @ view)
    side = np.cross(up, level)
    for rise in (1.0, STEEP):
        for turn in sorted(np.arange(TURNS) * (2.0 * np.pi / TURNS), key=lambda x: -np.cos(x)):
            found = np.cos(turn) * level + np.sin(turn) * side + rise * up * (up @ view)
            yield found / np.linalg.norm(found)


def _triangles(solid: Solid) -> Floats:
    vertices, faces = solid
    if len(faces) > MOST_TRIANGLES:
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        vertices, faces = box(0.5 * (low + high), 0.5 * (high - low), np.eye(3))
    return vertices[faces]


def _hidden(view: Floats, points: Floats, triangles: Mapping[int, Floats]) -> NDArray[np.bool_]:
    """(solids, points) what hides what from an eye far away along `view`: lines cross triangles where volumes agree in sign."""
    rows = [np.zeros((0, len(points)), bool)]
    for corners in triangles.values():
        a, b, c = (points[:, None] - corners[:, k] for k in range(3))  # (points, triangles, 3)
        sides = np.stack([np.cross(x, y) @ view for x, y in ((a, b), (b, c), (c, a))])
        crossed = (sides > 0.0).all(axis=0) | (sides < 0.0).all(axis=0)
        volume = (np.cross(a, b) * c).sum(axis=-1)
        total = sides.sum(axis=0)
        ahead = volume * total < 0.0  # the crossing lies at -volume / total along the line
        rows.append((crossed & ahead).any(axis=1)[None])
    return np.concatenate(rows)
