"""Touching and overlapping zones become one star-shaped zone, or are refused with the reason."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..maps import RoundHull, Star, ball_seen_from, common_point, convex_hull, union
from ..maps._directions import directions
from ..numeric import at_most
from ._shells import touching

Array = NDArray[np.float64]


def as_star(body: Star | tuple[Array, float, str]) -> Star:
    """A ball (center, radius, name) as a star; stars as they are."""
    if isinstance(body, Star):
        return body
    center, radius, name = body
    return RoundHull(center, np.zeros(len(center)), radius, radius, name=name)


def merge(bodies: list[Star | tuple[Array, float, str]], goal: Array) -> tuple[list, list[str]]:
    """The bodies with every touching cluster replaced by one star that leaves the goal out, and what was merged.

    Raises InputError naming the cluster where no way of merging leaves the goal outside.
    """
    made: dict[int, tuple[Star, list[Star]]] = {}  # merged stars by identity, and what they were made of
    while True:
        cluster = _first_cluster(bodies)
        if cluster is None:
            break
        parts: list[Star] = []
        for k in cluster:
            parts += made.pop(id(bodies[k]))[1] if id(bodies[k]) in made else [as_star(bodies[k])]
        merged = _merged(parts, goal, " + ".join(part.name for part in parts))
        object.__setattr__(merged, "slack", max(part.slack for part in parts) + excess(merged, parts))
        made[id(merged)] = (merged, parts)
        chosen = set(cluster)
        bodies = [body for k, body in enumerate(bodies) if k not in chosen] + [merged]
    return bodies, [
        f"merged {star.name} into one star-shaped zone that reaches up to {at_most(star.slack, 3, power=3)} mm beyond them"
        for star, _ in made.values()
    ]


def _first_cluster(bodies) -> list[int] | None:
    """A largest connected set of touching bodies; None where nothing touches."""
    m = len(bodies)
    if m < 2:
        return None
    stars = {k: body for k, body in enumerate(bodies) if isinstance(body, Star)}
    centers = np.array([body.center if isinstance(body, Star) else body[0] for body in bodies])
    outer = np.array([body.outer if isinstance(body, Star) else body[1] for body in bodies])
    links: dict[int, list[int]] = {}
    for i, j in _near_pairs(centers, outer):
        if (i not in stars and j not in stars) or touching(as_star(bodies[i]), as_star(bodies[j])):
            links.setdefault(i, []).append(j)
            links.setdefault(j, []).append(i)
    if not links:
        return None
    first = min(links)
    found, todo = {first}, [first]
    while todo:
        for k in links[todo.pop()]:
            if k not in found:
                found.add(k)
                todo.append(k)
    return sorted(found)


def _near_pairs(centers: Array, outer: Array) -> list[tuple[int, int]]:
    """Pairs whose bounding balls touch."""
    if len(centers) > 500:
        from scipy.spatial import cKDTree

        pairs = cKDTree(centers).query_pairs(2.0 * float(outer.max()), output_type="ndarray")
        i, j = pairs[:, 0], pairs[:, 1]
    else:
        i, j = np.triu_indices(len(centers), 1)
    touch = np.linalg.norm(centers[i] - centers[j], axis=1) <= outer[i] + outer[j]
    return [(int(a), int(b)) for a, b in zip(i[touch], j[touch])]


def _merged(parts: list[Star], goal: Array, names: str) -> Star:
    """One star around the parts: their union where they share a point, else balls joined by cones, else their convex hull."""
    reasons = []
    for way in (_union, _tree, _hull):
        try:
            for star in way(parts, names):
                if float(star.level(goal)) > 0.0:
                    return star
                reasons.append(f"{way.__name__[1:]}: holds the goal")
        except InputError as error:
            reasons.append(f"{way.__name__[1:]}: {error.message}")
    raise InputError(
        f"{names} touch or overlap and cannot be merged into one star-shaped zone that leaves the goal out "
        f"({'; '.join(dict.fromkeys(reasons))})",
        place="obstacles",
        remedy="shrink the zones or the margin, or enclose them in one shape of your own",
    )


def _union(parts: list[Star], names: str):
    point = common_point(parts)
    if point is None:
        raise InputError("no point lies inside all of them")
    seen = [ball_seen_from(point, p.center, p.outer, name=p.name) if _is_ball(p) else p for p in parts]
    yield union(seen, point, name=names)


def _is_ball(part: Star) -> bool:
    return isinstance(part, RoundHull) and not part.tip.any()


def _tree(parts: list[Star], names: str):
    """Every ball joined to a small ball about one centre by the cone that touches both: seen whole from there."""
    if not all(_is_ball(part) for part in parts):
        raise InputError("only for balls")
    centers, radii = np.array([p.center for p in parts]), np.array([p.outer for p in parts])
    root = 0.5 * float(radii.min())
    choices = [np.average(centers, axis=0, weights=radii), *centers]
    stars = []
    for c in choices:
        arms = []
        for center, radius in zip(centers, radii):
            tip = center - c
            near = min(root, 0.9 * radius)
            if np.linalg.norm(tip) < 1e-12:
                tip, near = np.zeros_like(tip), radius
            arms.append(RoundHull(np.array(c), tip, near, radius))
        stars.append(union(arms, np.array(c), name=names))
    yield from sorted(stars, key=lambda star: excess(star, parts))


def excess(star: Star, parts: list[Star]) -> float:
    """How far the star's boundary is from the nearest part at most, along that part's rays and on sampled directions, metres."""
    u = directions(star.dimension)
    x = star.center + star.radial(u)[0][:, None] * u
    return max(0.0, float(np.min([part.level(x) for part in parts], axis=0).max()))


def _hull(parts: list[Star], names: str):
    """The convex hull by supporting half-spaces in well-spread directions, smoothed."""
    n = parts[0].dimension
    if n > 3:
        raise InputError(f"not done for shapes in R^{n}")
    w = directions(n, 64 if n == 2 else 200)
    support = np.max([part.support(w) + w @ part.center for part in parts], axis=0)
    from scipy.spatial import HalfspaceIntersection

    inside = np.mean([part.center for part in parts], axis=0)
    corners = HalfspaceIntersection(np.column_stack([w, -support]), inside).intersections
    yield convex_hull(corners, name=names)
