"""The controller of the paper: brackets carried out one after another. A demonstration, with its limits.

At each sweep the error is written in the frame of g1 .. g4 and the brackets of the loop algebra, and every coefficient b is
carried out by the input word of its bracket with leg time |b|^(1/degree). Higher-order terms of the words are as large as the
error they correct unless that is small: it converges for errors up to about 0.01 (N = 4) or 0.001 (N = 5) and not always,
and not at all for N = 7. Use `Snake.steer`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import wrap_angle
from ._brackets import bracket_vector, input_word
from ._word import Word, word_degree

if TYPE_CHECKING:
    from ._snake import Snake

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class BracketControl:
    """Outcome of bracket control: `errors` (sweeps + 1,) norms of the error after each sweep, `legs` carried out, last `q`.

    `solved` if the last error is at most the tolerance; `reason` says "stalled" or "diverged" otherwise.
    """

    solved: bool
    reason: str
    errors: Array
    legs: int
    q: Array


def chain_words(depth: int) -> list[Word]:
    """Brackets of degree 2 .. depth that span all others of midpoint wheels: one of even, two of odd degree."""
    even: Word = (1, 2)
    words: list[Word] = [even]
    for degree in range(3, depth + 1):
        if degree % 2:
            words += [(1, even), (2, even)]
        else:
            even = (1, (1, even))
            words.append(even)
    return words


def bracket_control(
    snake: Snake, q0: ArrayLike, q1: ArrayLike, tolerance: float = 1e-9, sweeps: int = 40, longest: float = 0.25
) -> BracketControl:
    """From q0 toward a very near q1 by bracket motions; leg times are capped at `longest` seconds. [Snake] sec. 5."""
    if snake.wheel_fraction != 0.5:
        raise InputError("bracket control knows the brackets of midpoint wheels only", place="wheel_fraction")
    q, goal = snake.check(q0, "q0", single=True).copy(), snake.check(q1, "q1", single=True)
    degree = len(snake.growth(q).vector)
    words = chain_words(max(2, degree))
    errors, legs, reason = [], 0, ""
    for sweep in range(sweeps + 1):
        error = goal - q
        error[2:] = wrap_angle(error[2:])
        errors.append(float(np.linalg.norm(error)))
        if errors[-1] <= tolerance or sweep == sweeps:
            break
        if not errors[-1] < 1e3 * errors[0]:
            reason = "diverged"
            break
        frame = np.column_stack([snake.control_basis(q), *(bracket_vector(snake, q, w) for w in words)])
        b = np.linalg.lstsq(frame, error, rcond=1e-12)[0]
        values, times = [b[:4]], [1.0]
        for word, coefficient in zip(words, b[4:]):
            t = min(abs(coefficient) ** (1.0 / word_degree(word)), longest)
            moves = input_word(word, t)
            if coefficient < 0:
                moves = [(letter, -d) for letter, d in reversed(moves)]
            for letter, d in moves:
                if d:
                    values.append(np.sign(d) * np.eye(4)[letter - 1])
                    times.append(abs(d))
        legs += len(times)
        q = snake.simulate(q, np.array(values), durations=times, tolerance=1e-12).end
    solved = errors[-1] <= tolerance
    return BracketControl(solved, "" if solved else reason or "stalled", np.array(errors), legs, q)
