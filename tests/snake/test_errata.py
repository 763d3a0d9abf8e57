"""docs/errata.md, section Snake robots: each printed formula fails and its correction holds, in the dense algebra."""

import numpy as np
import plain_model as plain
import pytest

from horosphere.algebra import Multivector, basis
from horosphere.snake import Snake

e1, e2, e3, e4, e5, e0, ei, Ie, E, I = basis
plus, minus = e4, e5
RNG = np.random.default_rng(7)
SNAKE = Snake(6)
Q = np.concatenate([[0.3, -0.7, 0.4], RNG.uniform(-1.2, 1.2, 5)])
JOINTS = SNAKE.joints(Q)
CENTRES = SNAKE.centres(Q)
TURNS = np.cumsum(Q[2:])


def flat(x):
    return Multivector.vector([x[0], x[1], 0.0, 0.0, 0.0])


def up(x):
    return flat(x) + 0.5 * float(np.dot(x, x)) * ei + e0


def size(a):
    return np.abs(a.coefficients).max()


def place(point):
    c = (point * float(-1.0 / (point | ei).scalar_part)).coefficients
    return c[1:3]


POINTS = [up(x) for x in JOINTS]
PAIRS = [a ^ b for a, b in zip(POINTS[:-1], POINTS[1:])]


def test_row_1_the_null_basis():
    printed_0, printed_i = 0.5 * (minus + plus), minus - plus
    assert (printed_i | printed_0).scalar_part == -1.0
    assert size(printed_0 * printed_i - (-1.0 + (minus ^ plus))) > 1  # the product printed beside it
    assert size(e0 * ei - (-1.0 + (minus ^ plus))) < 1e-15
    pair = e0 ^ (2 * e1 + 2 * ei + e0)
    assert size(pair - (2 * (e0 ^ e1) - 2 * (plus ^ minus))) < 1e-15  # P_{1,0} as printed, with the corrected basis
    second = (2 * e1 + 2 * ei + e0) ^ (4 * e1 + 8 * ei + e0)
    assert size(second - (2 * (e0 ^ e1) + 8 * (e1 ^ ei) - 6 * (plus ^ minus))) < 1e-14


def test_row_2_the_axis():
    a = np.array([0.2, 0.5, -0.4])
    printed = a[0] * (e2 * e3) + a[1] * (e1 * e3) + a[2] * (e1 * e2)
    used = a[0] * (e2 * e3) + a[1] * (e3 * e1) + a[2] * (e1 * e2)
    axis = Multivector.vector([*a, 0.0, 0.0])
    assert size(axis * used - used * axis) < 1e-15 < size(axis * printed - printed * axis)


@pytest.mark.parametrize("i", range(6))
def test_row_3_points_of_a_pair(i):
    pair, s = PAIRS[i], 2.0  # sqrt(P . P) = l^2 / 2
    assert (pair | pair).scalar_part == pytest.approx(s * s)
    toward = (ei | pair).inverse()
    first, second = (s - pair) * toward, -1.0 * (s + pair) * toward
    np.testing.assert_allclose(place(first), JOINTS[i], atol=1e-9)
    np.testing.assert_allclose(place(second), JOINTS[i + 1], atol=1e-9)
    printed = -1.0 * (s + pair) * toward  # printed for Q_i
    assert np.linalg.norm(place(printed) - JOINTS[i]) > 1.9


@pytest.mark.parametrize("i", range(6))
def test_row_4_centres_carry_weight_2_l_squared(i):
    centre = PAIRS[i] * ei * ~PAIRS[i]
    np.testing.assert_allclose(place(centre), CENTRES[i], atol=1e-12)
    assert -(centre | ei).scalar_part == pytest.approx(8.0)


def test_row_5_the_translator_of_an_axis():
    printed = 1.0 - 0.5 * POINTS[2] * ei
    assert (printed * ~printed).scalar_part == pytest.approx(2.0)
    used = 1.0 - 0.5 * flat(JOINTS[2]) * ei
    assert (used * ~used).scalar_part == pytest.approx(1.0)
    axis = used * (e1 * e2) * ~used
    assert size(axis | POINTS[2]) < 1e-12  # the axis goes through its joint


def test_row_6_order_of_the_rotations():
    """R_n .. R_1 with axes through the current joints; the product printed in (2) needs those of the home position."""

    def rotor(axis, angle):
        return np.cos(angle / 2) - axis * np.sin(angle / 2)

    angles = Q[2:]
    home = [up(np.array([2.0 * k, 0.0])) for k in range(7)]
    shift = 1.0 - 0.5 * flat(Q[:2]) * ei

    def through(point):
        t = 1.0 - 0.5 * flat(place(point)) * ei
        return t * (e1 * e2) * ~t

    pair = home[5] ^ home[6]
    by_home = pair
    for k in range(5, -1, -1):
        r = rotor(through(home[k]), angles[k])
        by_home = r * by_home * ~r
    by_home = shift * by_home * ~shift
    assert size(by_home - PAIRS[5]) < 1e-10
    by_current = shift * pair * ~shift
    for k in range(6):
        r = rotor(through(POINTS[k]), angles[k])
        by_current = r * by_current * ~r
    assert size(by_current - PAIRS[5]) < 1e-10
    mixed = pair
    for k in range(5, -1, -1):
        r = rotor(through(POINTS[k]), angles[k])
        mixed = r * mixed * ~r
    assert size(shift * mixed * ~shift - PAIRS[5]) > 1.0


def test_row_7_the_theorem_and_its_index_range():
    axes = []
    for joint in JOINTS[:-1]:
        t = 1.0 - 0.5 * flat(joint) * ei
        axes.append(t * (e1 * e2) * ~t)
    jacobian = plain.wheel_jacobian(Q, SNAKE.lengths, 0.5)
    for i in range(6):
        centre = up(CENTRES[i])
        columns = [centre | (e1 * ei), centre | (e2 * ei)] + [centre | axis for axis in axes[: i + 1]]
        for k, column in enumerate(columns):
            np.testing.assert_allclose(column.coefficients[1:3], jacobian[i, :, k], atol=1e-12)


def test_row_8_which_links_are_constrained():
    rows = plain.pfaff(Q, SNAKE.lengths, 0.5)
    assert rows.shape[0] == 4 and np.linalg.matrix_rank(rows) == 4
    th, jacobian = TURNS, plain.wheel_jacobian(Q, SNAKE.lengths, 0.5)
    every = np.array([-np.sin(th[i]) * jacobian[i, 0] + np.cos(th[i]) * jacobian[i, 1] for i in range(6)])
    assert SNAKE.n - np.linalg.matrix_rank(every) == 2 and SNAKE.n - np.linalg.matrix_rank(rows) == 4


def test_row_9_the_pfaff_matrix_never_loses_rank():
    for seed in range(50):
        q = np.concatenate([[0, 0, 0], np.random.default_rng(seed).choice([0.0, 0.4, -0.4, np.pi, np.pi / 2], 5)])
        rows = SNAKE.pfaff(q)
        assert np.linalg.svd(rows, compute_uv=False)[-1] > 0.05


def test_row_10_the_circle_condition():
    """Head and tail do not count: wheel axes meet, though (7) as printed is not zero; and it is zero at a fold by accident."""
    q = np.concatenate([[0, 0, 0.1], [1.0], [0.4, 0.4, 0.4], [-0.8]])
    points = [up(x) for x in SNAKE.joints(q)]
    assert SNAKE.singularity(q) < 1e-12
    assert size(points[0] ^ points[1] ^ points[2] ^ points[3]) > 0.1
    for i in (4, 5):
        assert size(points[1] ^ points[2] ^ points[3] ^ points[i]) < 1e-10
    folded = np.concatenate([[0, 0, 0.1], [0.3], [np.pi, 0.7, -0.4], [0.2]])
    f = [up(x) for x in SNAKE.joints(folded)]
    assert size(f[1] ^ f[2] ^ f[3] ^ f[5]) < 1e-10 and SNAKE.singularity(folded) > 1e-3
    # wheel axes as IPNS lines: all triple wedges vanish exactly at the singular posture
    for posture, singular in ((q, True), (folded, False)):
        p = [up(x) for x in SNAKE.joints(posture)]
        lines = [p[i + 1] - p[i] for i in range(1, 5)]
        wedges = [size(lines[a] ^ lines[b] ^ lines[c]) for a, b, c in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))]
        assert (max(wedges) < 1e-10) == singular


def test_row_11_inner_product_of_neighbours():
    for a, b in zip(POINTS[:-1], POINTS[1:]):
        assert (a | b).scalar_part == pytest.approx(-2.0)


def test_row_12_angles_from_pairs():
    printed = ((PAIRS[1] ^ ei) | (e0 ^ e1 ^ ei)).scalar_part
    assert abs(printed - np.cos(Q[2])) > 1e-3
    assert ((PAIRS[0] ^ ei) | (e0 ^ e1 ^ ei)).scalar_part / 2 == pytest.approx(np.cos(Q[2]))
    for i in range(1, 6):
        cosine = ((PAIRS[i - 1] ^ ei) | (PAIRS[i] ^ ei)).scalar_part / 4
        assert cosine == pytest.approx(np.cos(Q[2 + i]))
    np.testing.assert_allclose(np.cos(SNAKE.from_joints(JOINTS)[2:]), np.cos(Q[2:]), atol=1e-12)
    np.testing.assert_allclose(SNAKE.from_joints(JOINTS)[2:], Q[2:], atol=1e-12)  # atan2: the signs too


def test_row_13_the_epsilon_condition_selects_the_folds():
    def value(angle):
        q = np.zeros(8)
        q[4] = angle
        points = [up(x) for x in SNAKE.joints(q)]
        return (points[1] | (points[3] - 2 * ei)).scalar_part

    for angle in (0.3, 1.0, np.pi / 2, 2.5, np.pi):
        assert value(angle) == pytest.approx(-2 - 4 * np.cos(angle))
    assert value(np.pi) == pytest.approx(2.0)  # printed: 2 +- epsilon, the fold
    assert value(np.pi / 2) == pytest.approx(-2.0)
    right_angles = np.concatenate([[0, 0, 0, 0], np.full(3, np.pi / 2), [0]])
    assert SNAKE.is_singular(right_angles)  # even corrected it does not avoid singular postures


def test_row_14_every_posture_is_not_controllable():
    folded = np.array([0, 0, 0, 0.3, np.pi, 0.4, 0.9, 0.2])
    assert SNAKE.growth_vector(folded)[-1] == 7 < 8
    assert np.abs(plain.basis(folded, SNAKE.lengths, 0.5)[4]).max() < 1e-12  # the folded joint cannot move


def test_row_15_the_literal_translator_turns_twice_about_half_the_position():
    printed = 1.0 - 0.5 * POINTS[2] * ei
    half = 1.0 - 0.25 * flat(JOINTS[2]) * ei
    literal, rotation = printed * (e1 * e2) * ~printed, half * (e1 * e2) * ~half
    assert size(literal - 2.0 * rotation) < 1e-12  # twice the rotation about half the position: not the joint's axis
