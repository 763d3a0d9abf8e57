"""The general method: iterated derivatives along words of control fields, for any wheel position.

For a function f and a word w = (w_1 .. w_n) let f_w = X_{w_1} X_{w_2} .. X_{w_n} f at the posture. These numbers obey
(f g)_w = sum over splittings of w of f_u g_v (Leibniz), so they follow order by order from the equations of the links;
brackets are signed sums of them. Works on integers modulo a prime (exact) and on floats. Uses nothing of the loop algebra.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ._word import Word, expand, word_degree

_BLOCK = 1 << 20


@lru_cache(maxsize=32)
def _splittings(letters: int, length: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """For every subset of positions (rows) and every word (columns): where the subword and its complement are stored."""
    words = np.arange(letters**length)
    digits = [(words // letters ** (length - 1 - i)) % letters for i in range(length)]
    starts = [(letters**n - 1) // (letters - 1) for n in range(length + 1)]
    left = np.zeros((1 << length, words.size), np.int64)
    right = np.zeros_like(left)
    for subset in range(1 << length):
        for i, digit in enumerate(digits):
            target = left if subset >> i & 1 else right
            target[subset] = target[subset] * letters + digit
        size = subset.bit_count()
        left[subset] += starts[size]
        right[subset] += starts[length - size]
    return left, right


class Series:
    """Iterated derivatives of a few functions along all words up to a length; level by level, modulo `prime` or in floats.

    Functions: x, y and the absolute angles theta_0 .. theta_N of the links. Fields: g1, g2 (velocity of joint 1 along e1 and
    e2 with a steady head), and with `letters=4` also g3 (head link about joint 1) and g4 (tail joint).
    """

    def __init__(
        self,
        directions: NDArray,
        lengths: NDArray,
        wheel_rate: NDArray,
        ratio: int | float,
        depth: int,
        letters: int = 2,
        prime: int = 0,
    ) -> None:
        """`directions` (N+1, 2) of the links, `wheel_rate` 1/(f length) and `ratio` (1-f)/f, as residues or floats."""
        self.letters, self.prime, self.links = letters, prime, len(directions)
        kind = np.int64 if prime else np.float64
        size = (letters ** (depth + 1) - 1) // (letters - 1)
        self._cosine, self._sine = np.zeros((2, self.links, size), kind)
        self._cosine[:, 0], self._sine[:, 0] = directions[:, 0], directions[:, 1]
        self._velocity = np.zeros((self.links, 2, 2, size), kind)  # joint, letter, component
        self._velocity[1, 0, 0, 0] = self._velocity[1, 1, 1, 0] = 1
        self._along, self._across = np.zeros((2, self.links, 2, size), kind)
        self._rates = np.zeros((self.links, letters, size), kind)
        self.values = [np.zeros((2 + self.links, letters**n), kind) for n in range(depth + 1)]
        for length in range(depth):
            self._raise(length, lengths, wheel_rate, ratio)

    def _reduce(self, x: NDArray) -> NDArray:
        return x % self.prime if self.prime else x

    def _product(self, a: NDArray, b: NDArray, length: int) -> NDArray:
        left, right = _splittings(self.letters, length)
        step = max(1, _BLOCK // (left.shape[1] * int(np.prod(np.broadcast_shapes(a.shape[:-1], b.shape[:-1])))))
        total = 0
        for i in range(0, len(left), step):
            terms = self._reduce(a[..., left[i : i + step]] * b[..., right[i : i + step]])
            total = self._reduce(total + terms.sum(axis=-2))
        return np.asarray(total)

    def _raise(self, length: int, lengths: NDArray, wheel_rate: NDArray, ratio: int | float) -> None:
        count, start = self.letters**length, (self.letters**length - 1) // (self.letters - 1)
        here = slice(start, start + count)
        after = start + count
        rates = np.zeros((self.links, self.letters, count), self._cosine.dtype)  # of the absolute angles
        for j in range(1, self.links - 1):
            u = self._velocity[j]
            c, s = self._cosine[j], self._sine[j]
            across = self._reduce(self._product(c, u[:, 1], length) - self._product(s, u[:, 0], length))
            rates[j, :2] = self._reduce(-across * wheel_rate[j])
            if j + 2 < self.links:
                along = self._reduce(self._product(c, u[:, 0], length) + self._product(s, u[:, 1], length))
                self._along[j][:, here], self._across[j][:, here] = along, self._reduce(-across * ratio)
                a, n = self._along[j], self._across[j]
                self._velocity[j + 1, :, 0, here] = self._reduce(
                    self._product(c, a, length) - self._product(s, n, length)
                )
                self._velocity[j + 1, :, 1, here] = self._reduce(
                    self._product(s, a, length) + self._product(c, n, length)
                )
        if self.links > 2:
            rates[-1, :2] = rates[-2, :2]
        if self.letters == 4 and length == 0:
            rates[0, 2, 0] = rates[-1, 3, 0] = 1
        self._rates[:, :, here] = rates
        s_rate = self._product(self._sine[:, None], self._rates, length)
        c_rate = self._product(self._cosine[:, None], self._rates, length)
        ahead = slice(after, after + count * self.letters)
        self._cosine[:, ahead] = self._reduce(-np.swapaxes(s_rate, 1, 2)).reshape(self.links, -1)
        self._sine[:, ahead] = np.swapaxes(c_rate, 1, 2).reshape(self.links, -1)
        level = self.values[length + 1].reshape(2 + self.links, count, self.letters)
        level[2:] = np.swapaxes(rates, 1, 2)
        if length == 0:
            level[0, 0, 0] = level[1, 0, 1] = 1
        if self.letters == 4:
            level[0, :, 2] = self._reduce(self._sine[0, here] * lengths[0])
            level[1, :, 2] = self._reduce(-self._cosine[0, here] * lengths[0])

    def right_normed(self, degree: int) -> NDArray:
        """Values of [X_a, [X_b, [.., [X_y, X_z]]]] for every word of the degree with y < z: (brackets, 2 + links)."""
        digits = np.stack(np.unravel_index(np.arange(self.letters**degree), (self.letters,) * degree), axis=1)
        if degree > 1:
            digits = digits[digits[:, -2] < digits[:, -1]]
        total = 0
        weights = self.letters ** np.arange(degree - 1, -1, -1)
        for right in range(1 << (degree - 1)):
            behind = [i for i in range(degree - 1) if right >> i & 1]
            order = [i for i in range(degree - 1) if not right >> i & 1] + [degree - 1] + behind[::-1]
            terms = self.values[degree][:, digits[:, order] @ weights]
            total = self._reduce(total - terms if len(behind) % 2 else total + terms)
        return np.asarray(total).T

    def bracket(self, word: Word) -> NDArray:
        """Value of one bracket, nested pairs of letters 1 .. 4: (2 + links,)."""
        degree = word_degree(word)
        total = np.zeros(2 + self.links, self._cosine.dtype)
        for letters, sign in expand(word).items():
            index = 0
            for letter in letters:
                index = index * self.letters + letter - 1
            total = self._reduce(total + sign * self.values[degree][:, index])
        return total
