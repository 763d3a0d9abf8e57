"""Which links are checked against each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from . import _placement
from ._robot import Capsules, Limits, Link

Floats = NDArray[np.float64]
SAMPLES = 48
SEED = 0


def rigid_groups(links: Sequence[Link]) -> NDArray[np.int64]:
    """For each link the first link of the rigid group it belongs to: fixed joints do not start a new group."""
    group = np.arange(len(links))
    for i, link in enumerate(links):
        if link.kind == "fixed" and link.parent >= 0:
            group[i] = group[link.parent]
    return group


def neighbours(links: Sequence[Link], group: NDArray[np.int64], bodied: set[int]) -> set[tuple[int, int]]:
    """Pairs of groups that touch at a joint, or at several joints in one point with only bodiless links between."""
    found: set[tuple[int, int]] = set()
    for i, link in enumerate(links):
        root, parent = i, link.parent
        while parent >= 0:
            found.add((int(group[i]), int(group[parent])))
            shift = np.linalg.norm(_placement.rotation_translation(links[root].origin)[1])
            if group[parent] != parent or int(parent) in bodied or shift > 1e-3:
                break
            root, parent = parent, links[parent].parent
    return found


def choose_pairs(links: Sequence[Link], limits: Limits, capsules: Capsules) -> tuple[NDArray[np.int64], list[str]]:
    """Pairs of links (k, 2) whose capsules can meet in a way that means something, and why others were dropped.

    Dropped: links of one rigid group or of neighbouring groups (they touch at the joint), and, with a note, pairs
    whose capsules overlap in the middle of all limits or in more than half of 48 random configurations within the
    limits (seed 0): there the capsules are too fat to tell.
    """
    owners = np.unique(capsules.link)
    group = rigid_groups(links)
    neighbour = neighbours(links, group, set(group[owners].tolist()))
    pairs = [
        (int(i), int(j))
        for n, i in enumerate(owners)
        for j in owners[n + 1 :]
        if group[i] != group[j] and not {(group[i], group[j]), (group[j], group[i])} & neighbour
    ]
    if not pairs:
        return np.zeros((0, 2), np.int64), []
    low, high = np.clip(limits.lower, -np.pi, np.pi), np.clip(limits.upper, -np.pi, np.pi)
    q = np.random.default_rng(SEED).uniform(low, high, (SAMPLES, len(low)))
    q[0] = 0.5 * (low + high)
    frames = _placement.link_frames(links, q)
    a = _placement.move_points(frames[:, capsules.link], capsules.a)
    b = _placement.move_points(frames[:, capsules.link], capsules.b)
    kept, notes = [], []
    for i, j in pairs:
        first, second = np.flatnonzero(capsules.link == i), np.flatnonzero(capsules.link == j)
        m, n = np.repeat(first, len(second)), np.tile(second, len(first))
        gap = segment_distance(a[:, m], b[:, m], a[:, n], b[:, n]) - capsules.radius[m] - capsules.radius[n]
        touching = gap.min(axis=1) < 0.0
        if touching[0] or touching.mean() > 0.5:
            why = "in mid-range" if touching[0] else f"in {touching.mean():.0%} of random configurations"
            notes.append(
                f"{links[i].name} / {links[j].name} not checked against each other: their capsules overlap {why}"
            )
        else:
            kept.append((i, j))
    return np.array(kept, np.int64).reshape(-1, 2), notes


def segment_distance(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Distance (...) between segments ab and cd (..., 3): the least over the four ends and the inner critical point."""
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = (np.einsum("...i,...i", x, y) for x, y in ((u, u), (v, v), (u, v)))
    uw, vw = np.einsum("...i,...i", u, w), np.einsum("...i,...i", v, w)

    def at(s: Floats, t: Floats) -> Floats:
        gap = w + s[..., None] * u - t[..., None] * v
        return np.einsum("...i,...i", gap, gap)

    tiny = 1e-30
    zero, one = np.zeros_like(uu), np.ones_like(uu)
    best = np.minimum(
        np.minimum(at(zero, np.clip(vw / (vv + tiny), 0, 1)), at(one, np.clip((vw + uv) / (vv + tiny), 0, 1))),
        np.minimum(at(np.clip(-uw / (uu + tiny), 0, 1), zero), at(np.clip((uv - uw) / (uu + tiny), 0, 1), one)),
    )
    det = uu * vv - uv * uv
    s = np.clip((uv * vw - vv * uw) / (det + tiny), 0, 1)
    t = np.clip((uu * vw - uv * uw) / (det + tiny), 0, 1)
    return np.sqrt(np.minimum(best, at(s, t)))
