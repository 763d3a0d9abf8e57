"""Brackets as vectors, and as motions: the input word whose leading displacement is a bracket."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array
from ._word import Word, word_degree
from ._words import Series

if TYPE_CHECKING:
    from ._motion import Motion
    from ._snake import Snake


def bracket_vector(snake: Snake, q: NDArray[np.float64], word: Word) -> NDArray[np.float64]:
    """Value of a bracket of the control fields at q (..., N+3), with [X, Y] = DY X - DX Y."""
    if isinstance(word, int):
        return snake.control_basis(q)[..., word - 1]
    letters = 4 if _highest(word) > 2 else 2
    flat = q.reshape(-1, q.shape[-1])
    result = np.empty_like(flat)
    for row, posture in zip(result, flat):
        angles = np.cumsum(posture[2:])
        series = Series(
            np.stack([np.cos(angles), np.sin(angles)], axis=1),
            snake.lengths,
            1.0 / (snake.wheel_fraction * snake.lengths),
            snake.wheel_ratio,
            word_degree(word),
            letters,
        )
        value = series.bracket(word)
        row[:3], row[3:] = value[:3], np.diff(value[2:])
    return result.reshape(q.shape)


def _highest(word: Word) -> int:
    return word if isinstance(word, int) else max(_highest(word[0]), _highest(word[1]))


def input_word(word: Word, t: float) -> list[tuple[int, float]]:
    """(letter, signed duration) pairs, in order of time, that move by t^degree [word] to leading order.

    [a, b] is a, then b, then a backwards, then b backwards; equal neighbours are merged.
    """
    if isinstance(word, int):
        return [(word, t)]
    a, b = input_word(word[0], t), input_word(word[1], t)
    moves: list[tuple[int, float]] = []
    for letter, duration in [*a, *b, *_reverse(a), *_reverse(b)]:
        if moves and moves[-1][0] == letter:
            duration += moves.pop()[1]
        if duration != 0.0:
            moves.append((letter, duration))
    return moves


def _reverse(moves: list[tuple[int, float]]) -> list[tuple[int, float]]:
    return [(letter, -duration) for letter, duration in reversed(moves)]


@dataclass(frozen=True, slots=True, eq=False)
class BracketMotion:
    """A bracket carried out as an input word with leg time t.

    `predicted` = t^degree times the bracket, `measured` the simulated displacement, both (N+3,); `order` is the slope of
    log |measured| between t/2 and t: the degree of the bracket, or more where the bracket vanishes. `rest_order` is the
    slope of |measured - predicted|. `legs` lists (letter, signed duration).
    """

    word: Word
    degree: int
    t: float
    predicted: NDArray[np.float64]
    measured: NDArray[np.float64]
    order: float
    rest_order: float
    legs: tuple[tuple[int, float], ...]
    motion: Motion


def bracket_motion(snake: Snake, q0: ArrayLike, word: Word, t: float) -> BracketMotion:
    """See Snake.bracket_motion."""
    q = snake.check(q0, single=True)
    t = float(float_array(t, "t", ndim=0))
    if t <= 0.0:
        raise InputError(f"expected a positive leg time, got {t}", place="t")
    vector = bracket_vector(snake, q, word)
    degree = word_degree(word)
    sizes, rests, motions = [], [], []
    for leg in (t, 0.5 * t):
        motion = _carry_out(snake, q, input_word(word, leg))
        motions.append(motion)
        sizes.append(np.linalg.norm(motion.displacement))
        rests.append(np.linalg.norm(motion.displacement - leg**degree * vector))
    order, rest = (float(np.log2(max(x[0], 1e-300) / max(x[1], 1e-300))) for x in (sizes, rests))
    return BracketMotion(
        word,
        degree,
        t,
        t**degree * vector,
        motions[0].displacement,
        order,
        rest,
        tuple(input_word(word, t)),
        motions[0],
    )


def _carry_out(snake: Snake, q: NDArray[np.float64], legs: list[tuple[int, float]]) -> Motion:
    values = np.zeros((len(legs), 4))
    for row, (letter, duration) in zip(values, legs):
        row[letter - 1] = np.sign(duration)
    return snake.simulate(q, values, durations=[abs(d) for _, d in legs], tolerance=1e-14)
