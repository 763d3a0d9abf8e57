"""Covers laid closer where bodies of two links overlap in postures in which the links are likely free."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache

from ._cover import LinkCover
from ._document import pack
from ._pairs import BLIND, OFTEN, Sampler
from ._robot import Limits, Link, LinkPair

WORTH = 0.75
"""Closer covers are taken if a pair then overlaps in at most this share of the postures in which it did."""
LITTLE = 0.05
"""Pairs that overlap in no larger share of all postures need no closer cover."""


def closer_covers(
    links: Sequence[Link],
    limits: Limits,
    covers: Mapping[str, LinkCover],
    table: Sequence[LinkPair],
    closer: Callable[[str], LinkCover],
) -> dict[str, LinkCover]:
    """Covers, by link, to take in place of `covers`: of links whose bodies overlap those of another in 30 % of random postures.

    `table`: what is known of the pairs with `covers`; pairs that are not checked for a reason of their own, or whose geometry is
    known to keep apart, are let be. `closer(link)` makes a cover; of a pair often that of one link is enough.
    """
    index = {link.name: k for k, link in enumerate(links)}
    pairs = [row for row in table if (row.touching or 0.0) >= OFTEN and (row.checked or row.reason.startswith(BLIND))]
    bodied = {name for name, cover in covers.items() if cover.bodies}  # others have theirs from a capsule file
    pairs = [row for row in pairs if row.first in bodied and row.second in bodied]
    names = sorted({name for row in pairs for name in (row.first, row.second)}, key=index.__getitem__)
    made = {name: closer(name) for name in names}

    @cache
    def share(row: LinkPair, first: bool, second: bool) -> float:
        """In how many postures a pair overlaps where the closer cover is taken for these of its links."""
        if not (first or second):
            return row.touching or 0.0
        ends = ((row.first, first), (row.second, second))
        packed = pack({name: (made if is_taken else covers)[name].bodies for name, is_taken in ends}, list(index))
        return Sampler(links, limits, packed).touching(index[row.first], index[row.second])

    pairs = [row for row in pairs if share(row, True, True) <= WORTH * share(row, False, False)]
    taken = {name for row in pairs for name in (row.first, row.second)}
    more = {name: len(made[name].bodies) - len(covers[name].bodies) for name in taken}
    for name in sorted(taken, key=lambda name: (-more[name], index[name])):
        own = [(row, row.first in taken, row.second in taken) for row in pairs if name in (row.first, row.second)]
        idle = (
            share(row, first and row.first != name, second and row.second != name)
            <= max(LITTLE, share(row, first, second))
            for row, first, second in own
        )
        taken -= {name} if more[name] > 0 and all(idle) else set()
    return {name: made[name] for name in names if name in taken}
