"""Growth vectors: how many directions the brackets of each degree add at a posture."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from ..errors import unknown_name
from ._posture import exact_directions, exact_number
from ._rank import PRIMES, modular, rank_modulo, rank_rational
from ._spectral import factor_bound, last_degree, turning_rates
from ._words import Series

METHODS = ("auto", "spectral", "words", "float")
_DEEPEST = 9  # of the general method: 4^degree products
_KEPT, _DROPPED = 1e-7, 1e-14  # float mode: singular values between the two decide nothing


@dataclass(frozen=True, slots=True)
class Growth:
    """A growth vector with what it follows from and how it was certified.

    `vector` (n_1, .., n_r) counts directions on the whole configuration space; it ends with the last degree that adds one.
    `factor` is the same without the head and tail fields g3, g4, which commute with everything: n - 2.
    `weights` lists the degree at which each direction appears; `degree` is the degree of nonholonomy.
    `complete`: all N + 3 directions appear. `reason` says why not, or what a float could not decide ("" otherwise).
    `gaps` (float mode): for each degree the smallest kept and the largest dropped relative singular value.
    """

    vector: tuple[int, ...]
    dimension: int
    method: str
    certificate: str
    reason: str
    gaps: tuple[tuple[float, float], ...] = ()

    @property
    def factor(self) -> tuple[int, ...]:
        return tuple(n - 2 for n in self.vector)

    @property
    def weights(self) -> tuple[int, ...]:
        steps = np.diff((0, *self.vector))
        return tuple(int(w) for w in np.repeat(np.arange(1, len(steps) + 1), steps))

    @property
    def degree(self) -> int:
        return len(self.vector)

    @property
    def complete(self) -> bool:
        return self.vector[-1] == self.dimension

    @property
    def is_decided(self) -> bool:
        """False where float singular values leave a rank open."""
        return not self.reason.startswith("undecided")


def growth(
    q: NDArray[np.float64], lengths: NDArray[np.float64], fraction: float, method: str = "auto", fields: int = 2
) -> Growth:
    """Growth vector at one posture q (N+3,) of a snake with the given lengths (N+1,) and wheel fraction.

    `auto` takes `spectral` (exact rational, midpoint wheels) or `words` (exact modulo primes, any wheels); `float` is the
    floating point version of the same. `fields=4` lets `words` bracket all of g1 .. g4 instead of counting g3, g4 by hand.
    """
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    midpoint = exact_number(fraction) == Fraction(1, 2)
    if method == "spectral" and not midpoint:
        raise unknown_name("method for wheels off the midpoint", method, ("auto", "words", "float"))
    if method == "float":
        return _float_growth(q, lengths, fraction, midpoint)
    if method == "spectral" or (method == "auto" and midpoint):
        return _spectral_growth(q, lengths)
    return _word_growth(q, lengths, fraction, fields)


def _trim(vector: list[int]) -> tuple[int, ...]:
    while len(vector) > 1 and vector[-1] == vector[-2]:
        vector = vector[:-1]
    return tuple(vector)


def _spectral_growth(q: NDArray[np.float64], lengths: NDArray[np.float64]) -> Growth:
    wheeled = len(lengths) - 2
    turns = exact_directions(q[4 : 3 + wheeled])
    inverse = [1 / exact_number(x) for x in lengths[1:-1]]
    scale = inverse[0]
    inverse = [x / scale for x in inverse]  # the unit of length changes no rank
    prime = PRIMES[0]
    rows: list[list[Fraction]] = []
    vector, proof = [4], "exact: "
    for degree in range(2, last_degree(wheeled) + 1):
        rows += turning_rates(degree, turns, inverse)
        residues = np.array([[modular(x, prime) for x in row] for row in rows], np.int64)
        rank = rank_modulo(residues, prime)
        if rank < min(wheeled, factor_bound(degree) - 2):
            rank = rank_rational(rows)
        vector.append(4 + rank)
        if rank == wheeled:
            break
    complete = vector[-1] == wheeled + 4
    proof += "rational arithmetic on the basis of the loop algebra of g1, g2"
    reason = "" if complete else "the brackets of every degree together span no more; the posture lies on a fold"
    return Growth(_trim(vector), wheeled + 4, "spectral", proof, reason)


def _residue_series(
    turns: list[tuple[Fraction, Fraction]],
    lengths: list[Fraction],
    fraction: Fraction,
    depth: int,
    fields: int,
    prime: int,
) -> Series:
    c, s = 1, 0
    directions = [(1, 0)]
    for turn in turns:
        a, b = modular(turn[0], prime), modular(turn[1], prime)
        c, s = (c * a - s * b) % prime, (s * a + c * b) % prime
        directions.append((c, s))
    return Series(
        np.array(directions, np.int64),
        np.array([modular(x, prime) for x in lengths], np.int64),
        np.array([modular(1 / (fraction * x), prime) for x in lengths], np.int64),
        modular((1 - fraction) / fraction, prime),
        depth,
        fields,
        prime,
    )


def _word_growth(q: NDArray[np.float64], lengths: NDArray[np.float64], fraction: float, fields: int) -> Growth:
    dimension = len(q)
    turns = exact_directions(q[3:])
    exact_lengths, exact_fraction = [exact_number(x) for x in lengths], exact_number(fraction)
    start, deepest = (4, 7) if fields == 4 else (5, _DEEPEST)
    primes = PRIMES[:3]
    vector: list[int] = []
    for depth in range(start, deepest + 1, 2 if fields == 2 else 1):
        vectors = []
        for prime in primes:
            series = _residue_series(turns, exact_lengths, exact_fraction, depth, fields, prime)
            vectors.append(_modular_vector(series, depth, fields, dimension))
        longest = max(len(v) for v in vectors)
        vector = [max(v[min(i, len(v) - 1)] for v in vectors) for i in range(longest)]
        if vector[-1] == dimension:
            break
    reason = (
        ""
        if vector[-1] == dimension
        else f"{vector[-1]} of {dimension} directions up to degree {deepest}, where the search ends"
    )
    proof = f"exact modulo the primes {', '.join(map(str, primes))}: each rank is proven as a lower bound, and equal for all"
    return Growth(_trim(vector), dimension, "words", proof, reason)


def _modular_vector(series: Series, depth: int, fields: int, dimension: int) -> list[int]:
    rows = np.zeros((0, dimension), np.int64)
    vector = []
    for degree in range(1, depth + 1):
        rows = np.vstack([rows, series.right_normed(degree)])
        vector.append(rank_modulo(rows, series.prime) + 4 - fields)
        if vector[-1] == dimension:
            break
    return vector


def _float_growth(q: NDArray[np.float64], lengths: NDArray[np.float64], fraction: float, midpoint: bool) -> Growth:
    wheeled = len(lengths) - 2
    if midpoint:
        relative = q[4 : 3 + wheeled]
        turns = list(zip(np.cos(relative).tolist(), np.sin(relative).tolist()))
        inverse = (lengths[1] / lengths[1:-1]).tolist()
        last = last_degree(wheeled)
    else:
        last = min(_DEEPEST, wheeled + 3)
        angles = np.concatenate([[0.0], np.cumsum(q[3:])])
        directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        series = Series(directions, lengths, 1 / (fraction * lengths), (1 - fraction) / fraction, last)
    rows = np.zeros((0, wheeled))
    vector, gaps, reason = [4], [], ""
    for degree in range(2, last + 1):
        if midpoint:
            new = np.array(turning_rates(degree, turns, inverse, 0.0, 1.0))
        else:
            new = series.right_normed(degree)[:, 3 : 3 + wheeled]
        norms = np.linalg.norm(new, axis=1, keepdims=True)
        rows = np.vstack([rows, (new / np.where(norms > 0, norms, 1.0))])
        values = np.linalg.svd(rows, compute_uv=False)
        values = np.concatenate([values / max(values[0], 1e-300), np.zeros(max(0, wheeled - len(values)))])
        rank = int((values > _KEPT).sum())
        kept, dropped = values[rank - 1] if rank else 0.0, values[rank] if rank < len(values) else 0.0
        gaps.append((float(kept), float(dropped)))
        vector.append(4 + rank)
        if dropped > _DROPPED and not reason:
            reason = (
                f"undecided: at degree {degree} a relative singular value {dropped:.1e} is neither zero nor clearly not; "
                "use exact=True"
            )
        if rank == wheeled:
            break
    if not reason and vector[-1] < wheeled + 4:
        reason = f"{vector[-1]} of {wheeled + 4} directions up to degree {last}"
    proof = "floating point: singular values, not a proof"
    return Growth(_trim(vector), wheeled + 4, "float", proof, reason, tuple(gaps))
