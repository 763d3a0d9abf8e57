"""Where snakes of 5 and 6 links are regular, and why they are controllable off the folds: exact determinants.

    python derivations/snake_regularity.py

The rates of the wheeled links under the loop algebra's basis elements are of degree one in (cos, sin) of every relative
angle (each link turns the element once and maps it linearly), so a determinant of N-1 of them is a trigonometric
polynomial of degree at most N-1 in each angle. Two such polynomials that agree on 2 (N-1) + 1 values of every angle are equal.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product

from horosphere.snake._spectral import turning_rates


def determinant(rows: list[list[Fraction]]) -> Fraction:
    matrix, value = [list(r) for r in rows], Fraction(1)
    for i in range(len(matrix)):
        pivot = next((k for k in range(i, len(matrix)) if matrix[k][i]), None)
        if pivot is None:
            return Fraction(0)
        if pivot != i:
            matrix[i], matrix[pivot], value = matrix[pivot], matrix[i], -value
        value *= matrix[i][i]
        for k in range(i + 1, len(matrix)):
            factor = matrix[k][i] / matrix[i][i]
            matrix[k] = [x - factor * y for x, y in zip(matrix[k], matrix[i])]
    return value


def circle(t: int) -> tuple[Fraction, Fraction]:
    square = Fraction(t * t)
    return (1 - square) / (1 + square), Fraction(2 * t) / (1 + square)


def sine_product(a: tuple, b: tuple) -> Fraction:
    """sin((A - B)/2) cos(A/2) cos(B/2)."""
    return (a[1] * (1 + b[0]) - b[1] * (1 + a[0])) / 4


def regular_four(turns: list[tuple]) -> Fraction:
    return -32 * sine_product(turns[0], turns[1])


def regular_five(turns: list[tuple]) -> Fraction:
    return -256 * sine_product(turns[0], turns[2]) * (1 + turns[1][0]) / 2


def even_product(turns: list[tuple], N: int) -> Fraction:
    value = Fraction(2) ** ((N - 1) ** 2)
    for j, (c, _) in enumerate(turns, start=2):
        value *= ((1 + c) / 2) ** (N - j)
    return value


def grid(N: int) -> product:
    points = [circle(t) for t in range(-(N - 1), N)]
    return product(points, repeat=N - 2)


if __name__ == "__main__":
    for N, formula in ((4, regular_four), (5, regular_five)):
        count = 0
        for turns in grid(N):
            rows = [row for degree in range(2, N) for row in turning_rates(degree, turns, [Fraction(1)] * (N - 1))]
            assert determinant(rows) == formula(list(turns))
            count += 1
        print(f"N = {N}: the regularity determinant equals its closed form on {count} points: proven")
    for N in (3, 4, 5):
        count, sign = 0, set()
        for turns in grid(N):
            rows = [turning_rates(2 * m, turns, [Fraction(1)] * (N - 1))[0] for m in range(1, N)]
            found, expected = determinant(rows), even_product(list(turns), N)
            assert abs(found) == expected
            sign.add((found > 0) - (found < 0))
            count += 1
        assert len(sign) == 1
        print(f"N = {N}: |det [E_2, E_4, ..]| = 2^{(N - 1) ** 2} prod cos(Phi_j/2)^(2(N-j)) on {count} points: proven")
    print("so off the folds Phi_j = pi the brackets of even degree alone span every shape: controllable there.")
