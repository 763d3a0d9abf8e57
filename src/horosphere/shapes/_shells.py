"""What a set of triangles encloses: closed shells with their cavities, which are solids, and the open rest, which is a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ._base import Floats

Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Shell:
    """Triangles (m, 3, 3) of one solid, wound outwards, or of a surface; `corners`, `edges` (m, 3, 3): see `_tree_kernels`.

    `pinched`: at some corner two fans of triangles meet, as where two tips touch.
    """

    triangles: Floats
    corners: Floats
    edges: Floats
    closed: bool
    convex: bool = False
    pinched: bool = False


def open_edges(vertices: Floats, faces: Integers) -> Floats:
    """The edges (k, 2, 3) that do not lie between exactly two faces; vertices at the same place count as one."""
    points, faces = merged(vertices, faces)
    edges, _, count = _undirected(faces)
    return points[edges[count != 2]]


def merged(vertices: Floats, faces: Integers) -> tuple[Floats, Integers]:
    """The same triangles with one vertex a place, without those that have two corners in one place."""
    points, number = np.unique(vertices + 0.0, axis=0, return_inverse=True)  # + 0.0: no negative zeros
    faces = number.reshape(-1)[faces]
    keep = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return points, faces[keep]


def shells(vertices: Floats, faces: Integers) -> list[Shell]:
    """The parts of a mesh that hang together. Of a closed one inside out: if it lies within another it is a cavity of that
    one, otherwise it is turned; parts that overlap stay solids of their own."""
    points, faces = merged(vertices, faces)
    if not len(faces):
        return []
    parts, inner = [], []
    for own in _connected(faces, len(points)):
        part, closed = _consistent(faces[own])
        if not closed:
            parts.append((part, False))
        elif _volume(points, part) < 0.0:
            inner.append(part)
        else:
            parts.append((part, True))
    for part in inner:
        holder = _holder(points, part, parts)
        if holder is None:
            parts.append((part[:, ::-1], True))
        else:
            parts[holder] = (np.concatenate([parts[holder][0], part]), True)
    return [_shell(points, part, closed) for part, closed in parts]


def _undirected(faces: Integers) -> tuple[Integers, Integers, Integers]:
    """Edges (k, 2), the edge of each side of each face (m, 3), and how many faces each has."""
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    size = int(faces.max(initial=0)) + 1
    keys, number, count = np.unique(sides[:, 0] * size + sides[:, 1], return_inverse=True, return_counts=True)
    return np.stack([keys // size, keys % size], axis=1), number.reshape(-1, 3), count


def _connected(faces: Integers, count: int) -> list[Integers]:
    """Indices of the faces of each part."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    rows, columns = np.concatenate([faces[:, 0], faces[:, 1]]), np.concatenate([faces[:, 1], faces[:, 2]])
    graph = coo_matrix((np.ones(len(rows), np.int8), (rows, columns)), shape=(count, count))
    part = connected_components(graph, directed=False)[1][faces[:, 0]]
    order = np.argsort(part, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(part[order])) + 1)


def _consistent(faces: Integers) -> tuple[Integers, bool]:
    """The faces wound alike, and whether they are closed: every edge between two faces that run along it in opposite ways."""
    edges, number, count = _undirected(faces)
    if (count != 2).any():
        return faces, False
    forward = faces == edges[number][..., 0]
    if (np.bincount(number.ravel(), forward.ravel(), len(edges)) == 1).all():
        return faces, True
    order = np.argsort(number.ravel(), kind="stable").reshape(-1, 2)
    turned = np.full(len(faces), -1)
    turned[0], queue = 0, [0]
    for face in queue:
        for side in range(3):
            first, second = order[number[face, side]]
            mine, other = (first, second) if first // 3 == face else (second, first)
            wanted = turned[face] ^ int(forward.flat[mine] == forward.flat[other])
            if turned[other // 3] < 0:
                turned[other // 3] = wanted
                queue.append(other // 3)
            elif turned[other // 3] != wanted:
                return faces, False  # one-sided, like a bottle of Klein's
    return np.where(turned[:, None] > 0, faces[:, ::-1], faces), True


def _volume(points: Floats, faces: Integers) -> float:
    a, b, c = (points[faces[:, k]] - points[faces[0, 0]] for k in range(3))
    return float((a * np.cross(b, c)).sum()) / 6.0


def _holder(points: Floats, part: Integers, parts: list[tuple[Integers, bool]]) -> int | None:
    """The closed part of least volume that holds another one."""
    inside, found = points[part[0, 0]], []
    for k, (other, closed) in enumerate(parts):
        low, high = points[other].min(axis=(0, 1)), points[other].max(axis=(0, 1))
        within = closed and (points[part] >= low).all() and (points[part] <= high).all()
        if within and abs(winding(inside, points[other])) > 0.5:
            found.append((abs(_volume(points, other)), k))
    return min(found)[1] if found else None


def winding(p: Floats, corners: Floats) -> float:
    """Sum of the signed solid angles of triangles seen from p, over 4 pi (Van Oosterom and Strackee's formula)."""
    a, b, c = (corners[:, i] - p for i in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    volume = (a * np.cross(b, c)).sum(-1)
    cosine = la * lb * lc + (a * b).sum(-1) * lc + (b * c).sum(-1) * la + (c * a).sum(-1) * lb
    return float(np.arctan2(volume, cosine).sum() / (2.0 * np.pi))


def _shell(points: Floats, faces: Integers, closed: bool) -> Shell:
    triangles = points[faces]
    sides = np.roll(triangles, -1, axis=1) - triangles
    _, number, count = _undirected(faces)
    normal, lengths = unit_normals(triangles), np.linalg.norm(sides, axis=2)
    # three corners in a line, to the rounding of their coordinates: the normal says nothing. Such a triangle counts as a piece
    # of the face beyond its longest side, whose other corner lies on that side
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    flat = np.flatnonzero(area <= 1e-14 * np.abs(triangles).max(axis=(1, 2)) * lengths.max(axis=1))
    normal[flat] = 0.0
    at_edge = np.zeros((len(count), 3))
    np.add.at(at_edge, number.ravel(), np.repeat(normal, 3, axis=0))
    if len(flat):
        longest = lengths[flat].argmax(axis=1)
        along = number[flat, longest]
        short = np.array([number[flat, (longest + k) % 3] for k in (1, 2)])
        beyond, other = at_edge[along], 0.5 * at_edge[short].sum(axis=0)
        normal[flat] = beyond
        np.add.at(at_edge, short, np.broadcast_to(beyond, (2, *beyond.shape)))
        np.add.at(at_edge, along, other)
    before = -np.roll(sides, 1, axis=1)
    angle = np.arctan2(np.linalg.norm(np.cross(sides, before), axis=-1), (sides * before).sum(-1))
    at_corner = np.zeros((int(faces.max()) + 1, 3))
    np.add.at(at_corner, faces.ravel(), (angle[..., None] * normal[:, None]).reshape(-1, 3))
    convex = closed and _convex(triangles)
    pinched = closed and not convex and _pinched(faces, number)
    return Shell(triangles, at_corner[faces], at_edge[number], closed, convex, pinched)


def _pinched(faces: Integers, number: Integers) -> bool:
    """Whether the faces at some vertex of a closed surface do not follow each other all round it; `number`: edges of the faces."""
    side = np.argsort(number.ravel(), kind="stable").reshape(-1, 2)
    twin = np.empty(3 * len(faces), np.int64)
    twin[side[:, 0]], twin[side[:, 1]] = side[:, 1], side[:, 0]
    following = 3 * (twin // 3) + (twin + 1) % 3  # side -> the side of the next face that starts at the same vertex
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    graph = coo_matrix((np.ones(len(twin), np.int8), (np.arange(len(twin)), following)), shape=(len(twin), len(twin)))
    return connected_components(graph, directed=False)[0] > len(np.unique(faces))


def unit_normals(triangles: Floats) -> Floats:
    """Unit normals (m, 3) of triangles (m, 3, 3), right to rounding even of slivers; zero where the corners lie in a line.

    Differences and products in double-double: a sliver's normal taken in float64 is off by the inverse of its angle, and
    distances to its plane with it. Sources: Knuth's sum, Dekker's product.
    """
    a, c = triangles[:, 0], np.empty((len(triangles), 3))
    (u, du), (v, dv) = ((_two_difference(triangles[:, k], a)) for k in (1, 2))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        p, dp = _two_product(u[:, j], v[:, k])
        q, dq = _two_product(u[:, k], v[:, j])
        high, low = _two_difference(p, q)
        low = low + (dp - dq) + (u[:, j] * dv[:, k] + du[:, j] * v[:, k]) - (u[:, k] * dv[:, j] + du[:, k] * v[:, j])
        c[:, i] = high + low
    largest = np.abs(c).max(axis=1, keepdims=True)
    c = c / np.where(largest > 0.0, largest, 1.0)
    return c / np.where(largest > 0.0, np.linalg.norm(c, axis=1, keepdims=True), 1.0)


def _two_difference(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    s = a - b
    t = s - a
    return s, (a - (s - t)) - (b + t)


def _two_product(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    p = a * b
    (ah, al), (bh, bl) = _halves(a), _halves(b)
    return p, al * bl - (((p - ah * bh) - al * bh) - ah * bl)


def _halves(a: Floats) -> tuple[Floats, Floats]:
    c = 134217729.0 * a  # 2^27 + 1
    high = c - (c - a)
    return high, a - high


def _convex(triangles: Floats) -> bool:
    """Whether a closed shell fills its convex hull, to rounding."""
    from scipy.spatial import ConvexHull, QhullError

    corners = triangles.reshape(-1, 3)
    try:
        hull = ConvexHull(corners).volume
    except QhullError:
        return False
    a, b, c = (triangles[:, k] - corners[0] for k in range(3))
    volume = float((a * np.cross(b, c)).sum()) / 6.0
    return abs(hull - volume) <= 1e-9 * hull
