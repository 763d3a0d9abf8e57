"""Bracket words: how a user writes them and what they expand to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InputError

Word = int | tuple  # a letter 1 .. 4, or a pair of words


def read_word(word: object) -> Word:
    """A bracket word as nested pairs of the letters 1 .. 4.

    Accepts nested pairs such as (1, (2, (1, 2))), the text "[1,[2,[1,2]]]", and flat sequences or digits such as "1212" or
    [1, 2, 1, 2], which are read right-normed: [1,[2,[1,2]]]. "g1" is read as 1. Raises InputError for anything else.
    """
    parsed = _parse_text(word) if isinstance(word, str) else word
    return _normalise(parsed, word)


_LETTERS = ("1", "2", "3", "4")


def _bad_word(word: object, what: str) -> InputError:
    return InputError(
        f"{what} in the bracket word {word!r}",
        place="word",
        choices=("1 (g1)", "2 (g2)", "3 (head)", "4 (tail)"),
        remedy="write nested pairs such as (1, (2, (1, 2))), or '[1,[2,[1,2]]]', or '1212' for the right-normed bracket",
    )


def _parse_text(text: str) -> object:
    tokens = [t for t in text.replace("g", "").replace("(", "[").replace(")", "]") if t not in " ,"]
    stack: list[list] = [[]]
    for token in tokens:
        if token == "[":
            stack.append([])
        elif token == "]":
            if len(stack) == 1:
                raise _bad_word(text, "unmatched closing bracket")
            done = stack.pop()
            stack[-1].append(done)
        elif token in _LETTERS:
            stack[-1].append(int(token))
        else:
            raise _bad_word(text, f"unknown letter {token!r}")
    if len(stack) != 1:
        raise _bad_word(text, "unmatched opening bracket")
    items = stack[0]
    return items[0] if len(items) == 1 else items


def _normalise(item: object, whole: object) -> Word:
    if isinstance(item, (int, np.integer)) and not isinstance(item, bool):
        if not 1 <= int(item) <= 4:
            raise _bad_word(whole, f"unknown letter {int(item)}")
        return int(item)
    if isinstance(item, str):
        if item.strip().lstrip("g") not in _LETTERS:
            raise _bad_word(whole, f"unknown letter {item!r}")
        return int(item.strip().lstrip("g"))
    if not isinstance(item, (Sequence, np.ndarray)):
        raise _bad_word(whole, f"unknown letter {item!r}")
    parts = [_normalise(part, whole) for part in item]
    if not parts:
        raise _bad_word(whole, "nothing between the brackets")
    word = parts[-1]
    for part in reversed(parts[:-1]):
        word = (part, word)
    return word


def word_degree(word: Word) -> int:
    """Number of letters."""
    return 1 if isinstance(word, int) else word_degree(word[0]) + word_degree(word[1])


def word_text(word: Word) -> str:
    """The word, as `read_word` takes it, in the form [1,[2,[1,2]]]."""
    word = read_word(word)
    return str(word) if isinstance(word, int) else f"[{word_text(word[0])},{word_text(word[1])}]"


def expand(word: Word) -> dict[tuple[int, ...], int]:
    """The bracket as a signed sum of words: [a, b] = a b - b a."""
    if isinstance(word, int):
        return {(word,): 1}
    first, second = expand(word[0]), expand(word[1])
    total: dict[tuple[int, ...], int] = {}
    for a, x in first.items():
        for b, y in second.items():
            total[a + b] = total.get(a + b, 0) + x * y
            total[b + a] = total.get(b + a, 0) - x * y
    return {letters: sign for letters, sign in total.items() if sign}
