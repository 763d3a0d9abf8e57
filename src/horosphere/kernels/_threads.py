"""Threads for large batches, only when asked for: one core has better uses for the other while a robot moves."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

from ..errors import InputError

WORTH = 100_000
"""Records from which on a batch is shared out."""
LARGEST = (ctypes.c_int64 * 1)(2**62)
"""Records of the largest batch that a direct call takes on; the trampoline reads it here."""
_pools: list[tuple[ThreadPoolExecutor, int]] = []


@contextmanager
def threads(count: int) -> Iterator[None]:
    """While the block runs, batches of 100,000 records and more are shared out to `count` threads, whoever asks for them.

    Results are the same to the bit. Worth it where the memory is the bound, or the arithmetic is (`forward` of a large
    batch), and the cores are free. Raises InputError for a count below 1.
    """
    if count < 1:
        raise InputError(f"expected at least one thread, got {count}", place="count")
    before = LARGEST[0]
    with ThreadPoolExecutor(count, "horosphere") as pool:
        _pools.append((pool, count))
        LARGEST[0] = WORTH - 1 if count > 1 else 2**62
        try:
            yield
        finally:
            LARGEST[0] = before
            _pools.pop()


def in_parts(
    run: Callable[[Sequence[Any], int], bool], arrays: Sequence[Any], alone: Sequence[bool], records: int
) -> bool:
    """run(arrays, records), or of parts of them at the same time; `alone`: arrays that serve every part as they are."""
    if not _pools or records < WORTH:
        return run(arrays, records)
    pool, count = _pools[-1]
    size = -(-records // (8 * count)) * 8  # whole vectors, so that every record is computed as without threads

    def part(first: int) -> bool:
        last = min(first + size, records)
        own = [a if one else a.reshape(records, -1)[first:last] for a, one in zip(arrays, alone, strict=True)]
        return run(own, last - first)

    return all(list(pool.map(part, range(0, records, size))))
