"""Growth vectors: two exact methods that share no code, closed forms, and what the readings of a float mean."""

from fractions import Fraction

import numpy as np
import plain_model as plain
import pytest

from horosphere.errors import InputError
from horosphere.snake import Snake, read_word
from horosphere.snake._posture import exact_directions
from horosphere.snake._rank import rank_modulo, rank_rational
from horosphere.snake._spectral import last_degree, turning_rates

GENERIC = {
    2: (4, 5),
    3: (4, 5, 6),
    4: (4, 5, 7),
    5: (4, 5, 7, 8),
    6: (4, 5, 7, 8, 9),
    7: (4, 5, 7, 8, 10),
    8: (4, 5, 7, 8, 10, 11),
    9: (4, 5, 7, 8, 10, 11, 12),
    10: (4, 5, 7, 8, 10, 11, 13),
}
OFF_CENTRE = {5: (4, 5, 7, 8), 6: (4, 5, 7, 9), 7: (4, 5, 7, 10), 8: (4, 5, 7, 10, 11), 10: (4, 5, 7, 10, 13)}


def posture(rng, inner):
    return np.concatenate([rng.uniform(-1, 1, 4), inner, rng.uniform(-1, 1, 1)])


@pytest.mark.parametrize("N", GENERIC)
def test_generic_growth_by_both_exact_methods(N, rng):
    snake = Snake(N + 1)
    q = posture(rng, rng.uniform(-2, 2, N - 2))
    for method in ("spectral", "words"):
        found = snake.growth(q, method)
        assert found.vector == GENERIC[N], method
        assert found.complete and found.degree == len(GENERIC[N]) and len(found.weights) == N + 3
    assert snake.growth_vector(q) == GENERIC[N]


@pytest.mark.parametrize("N", [4, 5, 6, 7])
def test_bracketing_all_four_fields_changes_nothing(N, rng):
    q = posture(rng, rng.uniform(-2, 2, N - 2))
    assert Snake(N + 1).growth(q, "words", fields=4).vector == GENERIC[N]


@pytest.mark.parametrize("fraction", [0.25, 0.4, 0.49, 0.51, 0.75])
@pytest.mark.parametrize("N", OFF_CENTRE)
def test_the_published_vectors_hold_off_the_midpoint(N, fraction, rng):
    q = posture(rng, rng.uniform(-2, 2, N - 2))
    assert Snake(N + 1, wheel_fraction=fraction).growth_vector(q) == OFF_CENTRE[N]


@pytest.mark.parametrize("N", [5, 6, 7])
def test_unequal_lengths_do_not_save_the_published_vectors(N, rng):
    q = posture(rng, rng.uniform(-2, 2, N - 2))
    snake = Snake(lengths=rng.integers(5, 30, N + 1) / 10)
    assert snake.growth(q, "spectral").vector == snake.growth(q, "words").vector == GENERIC[N]


@pytest.mark.parametrize(
    "N, inner, expected",
    [
        (5, [0.3] * 3, (4, 5, 6, 7, 8)),
        (5, [0.0] * 3, (4, 5, 6, 7, 8)),
        (5, [np.pi / 2] * 3, (4, 5, 6, 7, 8)),
        (5, [0.3, -0.3, 0.3], (4, 5, 7, 7, 8)),
        (5, [0.3, 0.7, 0.3], (4, 5, 7, 7, 8)),
        (6, [0.3, -0.3, 0.3, -0.3], (4, 5, 7, 7, 9)),
        (7, [0.3, -0.3, 0.3, -0.3, 0.3], (4, 5, 7, 7, 9, 9, 10)),
        (7, [0.25] * 5, (4, 5, 6, 7, 8, 9, 10)),
    ],
)
def test_special_postures_have_their_own_vectors(N, inner, expected, rng):
    q = posture(rng, np.array(inner))
    snake = Snake(N + 1)
    assert snake.growth(q, "spectral").vector == expected
    assert snake.growth(q, "words").vector == expected
    assert snake.growth_vector(q + 2 * np.pi * np.concatenate([[0, 0], rng.integers(-2, 3, N + 1)])) == expected
    moved = q.copy()
    moved[4:-1] += 1e-9 * rng.normal(size=N - 2)
    assert snake.growth_vector(moved) == GENERIC[N]


def test_angles_equal_up_to_rounding_are_equal(rng):
    snake = Snake(6)
    assert snake.growth_vector(posture(rng, np.array([0.1 + 0.2, 0.5, 0.3]))) == (4, 5, 7, 7, 8)
    absolute = np.cumsum(np.full(7, 0.37))
    q = np.concatenate([[0.0, 0.0], absolute[:1], np.diff(absolute[:6])])
    assert snake.growth_vector(q) == (4, 5, 6, 7, 8)
    c, s = exact_directions(np.array([np.pi]))[0]
    assert (c, s) == (-1, 0)
    quarter = exact_directions(np.array([np.pi / 2, -np.pi / 2, 2.0, np.pi - 2.0]))
    assert quarter[:2] == [(0, 1), (0, -1)]
    assert quarter[2][0] == -quarter[3][0] and quarter[2][1] == quarter[3][1]
    tiny = exact_directions(np.array([1e-12]))[0]
    assert tiny[1] != 0 and abs(float(tiny[1]) - 1e-12) < 1e-24


@pytest.mark.parametrize("N, first, all_folded", [(4, 6, 5), (5, 7, 5), (6, 8, 5), (7, 9, 5)])
def test_folds_lose_directions_for_good(N, first, all_folded, rng):
    snake = Snake(N + 1)
    one = snake.growth(posture(rng, np.concatenate([[np.pi], rng.uniform(-2, 2, N - 3)])))
    assert one.vector[-1] == first and not one.complete and "fold" in one.reason
    folded = snake.growth(posture(rng, np.full(N - 2, np.pi)))
    assert folded.vector[-1] == all_folded and not folded.complete
    # unequal lengths: the same posture is controllable
    free = Snake(lengths=np.arange(2, N + 3) / 2).growth(posture(rng, np.full(N - 2, np.pi)))
    assert free.complete


def test_folds_are_invariant_where_the_wheels_coincide(rng):
    """(1 - f) l_{j-1} = f l_j: the joint rate on the fold vanishes for every input, and only then."""
    snake = Snake(lengths=[2.0, 2.0, 3.0, 2.0, 1.0, 1.0], wheel_fraction=0.4)
    assert snake.folds(posture(rng, np.array([np.pi, 0.2, np.pi]))) == (2,)
    for joint, invariant in ((2, True), (3, False), (4, False)):
        inner = rng.uniform(-1, 1, 3)
        inner[joint - 2] = np.pi
        rates = plain.basis(posture(rng, inner), snake.lengths, 0.4)[2 + joint, :2]
        assert (np.abs(rates).max() < 1e-12) == invariant


def test_serre_relations_hold_at_rational_postures(rng):
    """[g1,[g2,[g1,g2]]] = 0 and [g1,[g1,[g1,g2]]] = [g2,[g2,[g1,g2]]] for midpoint wheels, and not off them."""
    from horosphere.snake._growth import _residue_series
    from horosphere.snake._rank import PRIMES

    for fraction, holds in ((Fraction(1, 2), True), (Fraction(2, 5), False)):
        lengths = [Fraction(int(x), 10) for x in rng.integers(5, 30, 8)]
        turns = exact_directions(rng.uniform(-2, 2, 7))
        series = _residue_series(turns, lengths, fraction, 4, 2, PRIMES[0])
        value = {word: series.bracket(read_word(word)) for word in ("1212", "1112", "2212")}
        assert (not value["1212"].any()) == holds
        assert np.array_equal(value["1112"], value["2212"]) == holds
        assert value["1112"].any()


def test_brackets_of_head_and_tail_with_everything_vanish(rng):
    for fraction in (0.5, 0.35):
        snake = Snake(6, wheel_fraction=fraction)
        q = rng.uniform(-2, 2, snake.n)
        for word in ("13", "23", "34", "14", "24", "312", "412", "3112"):
            np.testing.assert_allclose(snake.bracket(q, word), 0.0, atol=1e-12)


def test_brackets_agree_with_finite_differences_of_the_witness(rng):
    snake = Snake(lengths=rng.uniform(1, 2, 6), wheel_fraction=0.4)
    q = rng.uniform(-1, 1, snake.n)

    def field(index):
        return lambda p: plain.basis(p, snake.lengths, 0.4)[:, index]

    def bracket(x, y, h=1e-3):
        def derivative(f, p, v):  # eighth order
            weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
            return sum(w * (f(p + k * h * v) - f(p - k * h * v)) for k, w in weights.items()) / h

        return lambda p: derivative(y, p, x(p)) - derivative(x, p, y(p))

    g1, g2 = field(0), field(1)
    first = bracket(g1, g2)
    np.testing.assert_allclose(snake.bracket(q, "12"), first(q), atol=1e-9)
    second = snake.bracket(q, (2, (1, 2)))
    np.testing.assert_allclose(second, bracket(g2, first, 2e-3)(q), atol=1e-4 * np.abs(second).max())
    np.testing.assert_allclose(snake.bracket(q, "[[1,2],2]"), -snake.bracket(q, "212"), atol=1e-13)


def test_spectral_elements_are_the_brackets(rng):
    """The loop algebra's basis elements against nested brackets from the word series, floats, unequal lengths."""
    snake = Snake(lengths=rng.uniform(1, 2, 7))
    q = rng.uniform(-1, 1, snake.n)
    angle = q[2] + q[3]
    inverse = (1 / snake.lengths[1:-1]).tolist()
    turns = [(float(np.cos(a)), float(np.sin(a))) for a in q[4:-1]]
    for degree, words in ((2, ["12"]), (3, ["112", "212"]), (4, ["1112"]), (5, ["11112", "21112"])):
        rates = np.array(turning_rates(degree, turns, inverse, 0.0, 1.0))
        if degree % 2:  # basis vectors along and across the first wheeled link, turned to the world
            c, s = np.cos(angle), np.sin(angle)
            rates = np.array([[c, -s], [s, c]]) @ rates
        values = np.array([np.cumsum(snake.bracket(q, w)[2:])[1:-1] for w in words])
        assert np.linalg.matrix_rank(values, tol=1e-9) == len(words)
        coefficients, residual, *_ = np.linalg.lstsq(rates.T, values.T, rcond=None)
        np.testing.assert_allclose(rates.T @ coefficients, values.T, atol=1e-10)
        # the coefficients are whole numbers, the same at every posture: the algebra's structure constants
        np.testing.assert_allclose(coefficients, np.round(coefficients), atol=1e-8)


@pytest.mark.parametrize("N", [4, 5])
def test_closed_form_regularity_is_the_determinant(N, rng):
    snake = Snake(N + 1)
    q = rng.uniform(-3, 3, (5, snake.n))
    for p, value in zip(q, snake.regularity(q)):
        turns = [(np.cos(a), np.sin(a)) for a in p[4:-1]]
        rows = [row for degree in range(2, N) for row in turning_rates(degree, turns, [1.0] * (N - 1), 0.0, 1.0)]
        assert np.linalg.det(np.array(rows)) == pytest.approx(value, rel=1e-9, abs=1e-9)
    assert snake.regularity(
        posture(rng, np.array([0.4, 0.9, 0.4])[: N - 2] if N == 5 else np.array([0.4, 0.4]))
    ) == pytest.approx(0)


@pytest.mark.parametrize("N", [3, 4, 5, 6])
def test_even_brackets_span_everything_off_the_folds(N, rng):
    """|det [E_2, E_4, ..]| = 2^((N-1)^2) prod cos(Phi_j / 2)^(2 (N - j)), exactly, at rational postures."""
    turns = exact_directions(rng.uniform(-2.5, 2.5, N - 2))
    rows = [turning_rates(2 * m, turns, [Fraction(1)] * (N - 1))[0] for m in range(1, N)]
    determinant = _determinant(rows)
    product = Fraction(2) ** ((N - 1) ** 2)
    for j, (c, _) in enumerate(turns, start=2):
        product *= ((1 + c) / 2) ** (N - j)
    assert abs(determinant) == product


def _determinant(rows):
    matrix, value = [list(r) for r in rows], Fraction(1)
    for i in range(len(matrix)):
        pivot = next(k for k in range(i, len(matrix)) if matrix[k][i])
        if pivot != i:
            matrix[i], matrix[pivot], value = matrix[pivot], matrix[i], -value
        value *= matrix[i][i]
        for k in range(i + 1, len(matrix)):
            factor = matrix[k][i] / matrix[i][i]
            matrix[k] = [x - factor * y for x, y in zip(matrix[k], matrix[i])]
    return value


def test_float_mode_agrees_and_says_where_it_cannot_decide(rng):
    snake = Snake(8)
    q = posture(rng, np.array([0.5, -0.8, 0.3, 1.0, -0.4]))
    found = snake.growth(q, "float")
    assert found.vector == GENERIC[7] and found.is_decided and len(found.gaps) == 4
    near = q.copy()
    near[4:-1] = 0.3 + 1e-10 * np.arange(5)
    doubtful = snake.growth(near, "float")
    assert not doubtful.is_decided
    with pytest.warns(UserWarning, match="undecided"):
        snake.growth_vector(near, exact=False)
    assert snake.growth_vector(near) != snake.growth_vector(np.where(np.isclose(near, 0.3, atol=1e-8), 0.3, near))


def test_growth_stops_where_the_algebra_does():
    assert last_degree(4) == 9
    folded = Snake(6).growth(np.array([0, 0, 0, 0, np.pi, 0.4, 0.9, 0]))
    assert folded.vector == (4, 5, 7)


def test_ranks_agree_with_numpy_on_integers(rng):
    for rank in range(5):
        matrix = rng.integers(-5, 6, (6, max(rank, 1))) @ rng.integers(-5, 6, (max(rank, 1), 7)) * (rank > 0)
        expected = np.linalg.matrix_rank(matrix.astype(float)) if rank else 0
        assert rank_rational([[Fraction(int(x)) for x in row] for row in matrix]) == expected
        assert rank_modulo(matrix, 2147483647) == expected


@pytest.mark.parametrize(
    "call, text",
    [
        (lambda s: s.growth(np.zeros(8), "magic"), "unknown method"),
        (lambda s: s.growth(np.zeros(7)), "posture of 8"),
        (lambda s: s.growth(np.zeros((2, 8))), "1 axes"),
        (lambda s: Snake(6, wheel_fraction=0.4).growth(np.zeros(8), "spectral"), "off the midpoint"),
        (lambda s: s.bracket(np.zeros(8), "1x"), "unknown letter 'x'"),
        (lambda s: s.bracket(np.zeros(8), (1, 5)), "unknown letter 5"),
        (lambda s: s.bracket(np.zeros(8), "[1,[2"), "unmatched"),
        (lambda s: Snake(8).regularity(np.zeros(10)), "5 or 6 equal links"),
    ],
)
def test_bad_input_is_named(call, text):
    with pytest.raises(InputError, match=text):
        call(Snake(6))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_both_methods_agree_on_many_postures(seed):
    rng = np.random.default_rng(seed)
    for N in range(2, 8):
        snake = Snake(N + 1)
        choices = np.array([0.0, 0.3, -0.3, np.pi / 2, np.pi, 1.1, np.pi - 1.1])
        q = posture(rng, rng.choice(choices, N - 2))
        exact, words = snake.growth(q, "spectral"), snake.growth(q, "words")
        assert exact.vector[: words.degree] == words.vector[: exact.degree]
