"""Covers laid closer where bodies of two links overlap in postures in which the links are likely free."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ._cover import LinkCover
from ._document import pack
from ._pairs import BLIND, OFTEN, Sampler
from ._robot import Limits, Link, LinkPair

WORTH = 0.75
"""A closer cover is taken if a pair then overlaps in at most this share of the postures in which it did."""


def closer_covers(
    links: Sequence[Link],
    limits: Limits,
    covers: Mapping[str, LinkCover],
    table: Sequence[LinkPair],
    closer: Callable[[str], LinkCover],
) -> dict[str, LinkCover]:
    """Covers, by link, to take in place of `covers`: of links whose bodies overlap those of another in 30 % of random postures.

    `table`: what is known of the pairs with `covers`; pairs that are not checked for a reason of their own, or whose geometry is
    known to keep apart, are let be. `closer(link)` makes a cover.
    """
    index = {link.name: k for k, link in enumerate(links)}
    pairs = [row for row in table if (row.touching or 0.0) >= OFTEN and (row.checked or row.reason.startswith(BLIND))]
    pairs = [row for row in pairs if row.first in covers and row.second in covers]
    names = sorted({name for row in pairs for name in (row.first, row.second)}, key=index.__getitem__)
    made = {name: closer(name) for name in names}
    now = Sampler(links, limits, pack({name: found.bodies for name, found in made.items()}, list(index)))
    better: set[str] = set()
    for row in pairs:
        if now.touching(index[row.first], index[row.second]) <= WORTH * (row.touching or 0.0):
            better |= {row.first, row.second}
    return {name: made[name] for name in names if name in better}
