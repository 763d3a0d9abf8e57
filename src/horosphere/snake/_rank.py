"""Exact ranks: a lower bound modulo a prime, and fraction-free elimination where that bound must be met from above."""

from __future__ import annotations

from fractions import Fraction
from math import lcm

import numpy as np
from numpy.typing import NDArray

# Primes below 2^31 that are 3 modulo 4, so that 1 + t^2 is never zero and products fit in int64.
PRIMES = (2147483647, 2147483587, 2147483579, 2147483563, 2147483543)


def modular(value: Fraction, prime: int) -> int:
    """A rational number in the field of `prime` elements."""
    return value.numerator * pow(value.denominator, -1, prime) % prime


def rank_modulo(matrix: NDArray[np.int64], prime: int) -> int:
    """Rank over the field of `prime` elements; never above the rank over the rationals."""
    rows = np.array(matrix, dtype=np.int64) % prime
    rank = 0
    for column in range(rows.shape[1]):
        nonzero = np.flatnonzero(rows[rank:, column])
        if nonzero.size == 0:
            continue
        pivot = rank + nonzero[0]
        rows[[rank, pivot]] = rows[[pivot, rank]]
        rows[rank] = rows[rank] * pow(int(rows[rank, column]), -1, prime) % prime
        below = rows[rank + 1 :, column].copy()
        rows[rank + 1 :] = (rows[rank + 1 :] - below[:, None] * rows[rank][None, :] % prime) % prime
        rank += 1
        if rank == rows.shape[0]:
            break
    return rank


def rank_rational(rows: list[list[Fraction]]) -> int:
    """Rank over the rationals, by fraction-free (Bareiss) elimination on integers."""
    matrix = []
    for row in rows:
        scale = lcm(*(x.denominator for x in row)) if row else 1
        matrix.append([int(x * scale) for x in row])
    rank, previous = 0, 1
    columns = len(matrix[0]) if matrix else 0
    for column in range(columns):
        pivot = next((i for i in range(rank, len(matrix)) if matrix[i][column]), None)
        if pivot is None:
            continue
        matrix[rank], matrix[pivot] = matrix[pivot], matrix[rank]
        top = matrix[rank]
        for i in range(rank + 1, len(matrix)):
            low = matrix[i]
            factor = low[column]
            matrix[i] = [(top[column] * x - factor * y) // previous for x, y in zip(low, top)]
        previous = top[column]
        rank += 1
        if rank == len(matrix):
            break
    return rank
