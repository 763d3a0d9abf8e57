"""Which links are checked against each other, and why."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from . import _placement
from ._apart import known_gap
from ._bodies import enclosing_ball
from ._cover import BUDGETS, Surface
from ._robot import Capsules, Limits, Link, LinkPair, Robot
from ._srdf import Srdf

Floats = NDArray[np.float64]
SAMPLES = 512
SEED = 0
ALWAYS = 0.95
"""Bodies that overlap in this share of the configurations are too fat to tell anything, or touch by design."""
OFTEN = 0.3
"""From this share on, a note is made of a pair that stays checked."""
RIGID = "no joint between them"
BLIND = "always touching"
MOST = 12
"""Pairs that a note names."""


def rigid_groups(links: Sequence[Link]) -> NDArray[np.int64]:
    """For each link the first link of the rigid group it belongs to: fixed joints do not start a new group."""
    group = np.arange(len(links))
    for i, link in enumerate(links):
        if link.kind == "fixed" and link.parent >= 0:
            group[i] = group[link.parent]
    return group


def neighbours(links: Sequence[Link], group: NDArray[np.int64], bodied: set[int]) -> dict[tuple[int, int], str]:
    """Pairs of groups that touch at a joint, or at several joints in one point with only bodiless links between, and why."""
    found: dict[tuple[int, int], str] = {}
    for i, link in enumerate(links):
        root, parent, reason = i, link.parent, "adjacent: joined by a joint"
        while parent >= 0:
            found.setdefault((int(group[i]), int(group[parent])), reason)
            shift = np.linalg.norm(_placement.rotation_translation(links[root].origin)[1])
            if group[parent] != parent or int(parent) in bodied or shift > 1e-3:
                break
            root, parent, reason = parent, links[parent].parent, "adjacent: joined by joints that meet in one point"
    return found | {(j, i): why for (i, j), why in found.items()}


def choose_pairs(
    links: Sequence[Link],
    limits: Limits,
    capsules: Capsules,
    srdf: Srdf | None = None,
    allowed: Collection[frozenset[str]] = (),
    surfaces: Mapping[str, Surface] | None = None,
) -> tuple[NDArray[np.int64], tuple[LinkPair, ...], list[str]]:
    """Pairs of links (k, 2) to check, what is known of every pair, and notes.

    Not checked: links without a joint between them; neighbours, whose bodies overlap at the joint (unless the SRDF enables the
    pair); pairs that the SRDF disables or the caller allows; and pairs that overlap in at least 95 % of 512 random
    configurations within the limits (seed 0), since no motion would be left; and pairs whose bodies overlap in 30 % of them while
    their geometry (`surfaces`, triangles by link) is shown to keep apart in every posture. All others are checked, however
    seldom or often they overlap in those: samples prove nothing of what a plan may touch.
    """
    owners = [int(i) for i in np.unique(capsules.link)]
    group = rigid_groups(links)
    neighbour = neighbours(links, group, {int(group[i]) for i in owners})
    sampler = Sampler(links, limits, capsules)
    table: list[LinkPair] = []
    kept: list[tuple[int, int]] = []
    notes: list[str] = []
    blind: list[LinkPair] = []
    doubtful: list[LinkPair] = []
    for n, i in enumerate(owners):
        for j in owners[n + 1 :]:
            first, second = links[i].name, links[j].name
            pair = frozenset((first, second))
            why = srdf.why_disabled(first, second) if srdf else None
            adjacent = neighbour.get((int(group[i]), int(group[j])))
            if group[i] == group[j]:
                table.append(LinkPair(first, second, False, RIGID))
                continue
            if pair in allowed:
                table.append(LinkPair(first, second, False, "allowed by the caller"))
                continue
            if adjacent and not (srdf and pair in srdf.enabled):
                table.append(LinkPair(first, second, False, adjacent))
                continue
            share = sampler.touching(i, j)
            if why is not None:
                table.append(LinkPair(first, second, False, f"disabled in the SRDF: {why}", share))
                if share > 0.0 and why == "Never":
                    notes.append(
                        f"{first} / {second}: the SRDF says they never touch, their bodies {_seen(share)}; not checked"
                    )
                continue
            row = _by_samples(first, second, share)
            if share >= OFTEN and surfaces:
                gap = known_gap(links, limits, (surfaces.get(first), surfaces.get(second)), (i, j))
                if gap is not None:
                    row = _by_geometry(first, second, share, gap)
            table.append(row)
            if share >= OFTEN and (row.checked or row.reason.startswith(BLIND)):
                (doubtful if row.checked else blind).append(row)
            kept += [(i, j)] if row.checked else []
    notes += _warnings(blind, doubtful, [links[i].name for i in capsules.link], capsules.note)
    return np.array(kept, np.int64).reshape(-1, 2), tuple(table), notes


def judge(
    robot: Robot, pairs: Sequence[tuple[int, int]], group: NDArray[np.int64], allowed: Collection[str]
) -> tuple[tuple[LinkPair, ...], NDArray[np.int64], list[str]]:
    """The same for pairs (link, object) of an object that does not overlap its neighbours by design: rows, pairs, notes."""
    sampler = Sampler(robot.links, robot.limits, robot.capsules)
    table, kept, seen = [], [], []
    for i, j in pairs:
        first, second = robot.links[i].name, robot.links[j].name
        if group[i] == group[j]:
            table.append(LinkPair(first, second, False, RIGID))
            continue
        if first in allowed:
            table.append(LinkPair(first, second, False, "allowed by the caller"))
            continue
        row = _by_samples(first, second, sampler.touching(i, j))
        table.append(row)
        seen += [row] if (row.touching or 0.0) >= OFTEN else []
        kept += [(i, j)] if row.checked else []
    owners = [robot.links[k].name for k in robot.capsules.link]
    split = [row for row in seen if not row.checked], [row for row in seen if row.checked]
    return tuple(table), np.array(kept, np.int64).reshape(-1, 2), _warnings(*split, owners, robot.capsules.note)


def _seen(share: float) -> str:
    return f"overlap in {_count(share)} of {SAMPLES} random configurations"


def _count(share: float) -> int:
    return round(share * SAMPLES)


def _by_samples(first: str, second: str, share: float) -> LinkPair:
    """Whether a pair is checked, from the share of configurations in which it touches."""
    if share >= ALWAYS:
        return LinkPair(first, second, False, f"{BLIND}: they {_seen(share)}", share)
    return LinkPair(first, second, True, f"they {_seen(share)}" if share else "not seen touching", share)


def _warnings(
    blind: list[LinkPair], doubtful: list[LinkPair], owners: Sequence[str], notes: Sequence[str]
) -> list[str]:
    """What to know of pairs whose bodies overlap nearly always, and often, and what would help.

    `owners`, `notes`: of each body. A larger budget is of use only to a mesh that takes less than the usual one.
    """

    def help_for(pairs: list[LinkPair]) -> str:
        for name in {name for pair in pairs for name in (pair.first, pair.second)}:
            kinds = [note for owner, note in zip(owners, notes, strict=True) if owner == name and "mesh of" in note]
            if 0 < len(kinds) < min(BUDGETS.values()):
                return "give a tighter model (a smaller tolerance, a larger budget, a capsule file)"
        return "give a tighter model (a capsule file)"

    result = []
    for pairs, state, overlap in ((blind, "NOT checked since", "nearly always"), (doubtful, "checked though", "often")):
        if not pairs:
            continue
        one = len(pairs) == 1
        said = f"{len(pairs)} {'pair of links is' if one else 'pairs of links are'} {state} {'its' if one else 'their'}"
        named = ", ".join(f"{pair.first}/{pair.second} ({_count(pair.touching or 0.0)})" for pair in pairs[:MOST])
        named += f" and {len(pairs) - MOST} more" if len(pairs) > MOST else ""
        remedy = "allow them (an SRDF, an allowed contact) if they cannot meet in truth"
        seen = f"{said} bodies {overlap} overlap: {named} of {SAMPLES} random configurations"
        result.append(f"{seen}; {remedy}, or {help_for(pairs)}")
    return result


def _by_geometry(first: str, second: str, share: float, gap: float) -> LinkPair:
    """A pair whose bodies overlap while its geometry keeps apart."""
    why = f"their bodies {_seen(share)}, their geometry keeps {1e3 * gap:.1f} mm apart in every posture"
    return LinkPair(first, second, False, f"never touching: {why}", share)


class Sampler:
    """Overlaps of links in random configurations."""

    def __init__(self, links: Sequence[Link], limits: Limits, capsules: Capsules) -> None:
        low, high = np.clip(limits.lower, -np.pi, np.pi), np.clip(limits.upper, -np.pi, np.pi)
        low, high = np.minimum(low, high), np.maximum(low, high)
        q = np.random.default_rng(SEED).uniform(low, high, (SAMPLES, len(low)))
        self.capsules = capsules
        self.frames = _placement.link_frames(links, q)
        self.cache: dict[int, tuple[Floats, Floats, Floats, Floats]] = {}

    def _placed(self, i: int) -> tuple[Floats, Floats, Floats, Floats]:
        """Ends a, b (samples, m, 3) and radii (m,) of the bodies of a link, and a ball round them (samples, 4)."""
        if i not in self.cache:
            caps, own = self.capsules, self.capsules.link == i
            a, b, r = caps.a[own], caps.b[own], caps.radius[own]
            ball = enclosing_ball(np.concatenate([a, b]), np.tile(r, 2))
            frames = self.frames[:, i][:, None]
            middle = _placement.move_points(frames, ball[None, :3])[:, 0]
            around = np.column_stack([middle, np.full(len(middle), ball[3])])
            ends = (_placement.move_points(frames, a), _placement.move_points(frames, b))
            self.cache[i] = (*ends, r, around)
        return self.cache[i]

    def touching(self, i: int, j: int) -> float:
        """Share of the configurations in which bodies of the two links overlap."""
        a, b, r, first = self._placed(i)
        c, d, s, second = self._placed(j)
        near = np.linalg.norm(first[:, :3] - second[:, :3], axis=1) < first[:, 3] + second[:, 3]
        if not near.any():
            return 0.0
        a, b, c, d = a[near, :, None], b[near, :, None], c[near, None], d[near, None]
        if np.array_equal(a, b) and np.array_equal(c, d):
            distance = np.linalg.norm(a - c, axis=-1)
        else:
            distance = segment_distance(*np.broadcast_arrays(a, b, c, d))
        return float((distance < r[:, None] + s).any(axis=(1, 2)).sum()) / SAMPLES


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
