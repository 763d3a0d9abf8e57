"""The papers' own formulas fail where docs/errata.md says they do, and the corrected ones do not."""

import numpy as np
import pytest

from horosphere.fields import HarmonicField


def test_printed_charge_penetrates_in_space_near_the_goal():
    """[Humanoid] (23) in R^3, D < 14/13 R; the goal in front of the ball, starts just off its surface."""
    for distance, enters in ((1.01, True), (1.03, True), (1.15, False)):
        least = np.inf
        for rule in ("printed", "planar-log"):
            field = HarmonicField([0, 0, 0], ([[distance, 0, 0]], [1.0]), rule=rule)
            worst = np.inf
            for angle in np.linspace(0.02, 3.0, 25):
                start = np.array([distance + 1.002 * np.cos(angle), 1.002 * np.sin(angle), 0])
                path = field.trace(start, step=0.002, max_steps=4000, method="euler")
                worst = min(worst, path.clearance)
            if rule == "printed":
                least = worst
            else:
                assert worst > -2e-5
        assert (least < -2e-3) == enters


def test_printed_charge_in_space_holds_the_robot_off_far_too_soon():
    """The stagnation point of q = R / (R + D) in R^3 is at s = D sqrt(q) / (1 - sqrt(q)) beyond the centre, not on the ball."""
    field = HarmonicField([0, 0, 0], ([[1.0, 0, 0]], [0.15]), rule="printed")
    q = 0.15 / 1.15
    s = np.sqrt(q) / (1.0 - np.sqrt(q))
    assert s == pytest.approx(0.565, abs=1e-3)
    assert np.linalg.norm(field.gradient([1.0 + s, 0, 0])) < 1e-12
    assert field([1.0 + s - 0.05, 0, 0])[0] > 0.99 and field([1.0 + s + 0.05, 0, 0])[0] < -0.99


@pytest.fixture(scope="module")
def four_balls():
    """All assumptions of [Rn] section 3.2 hold: disjoint zones, boundary 0.1 below every gap, goal outside."""
    a = np.deg2rad([0, 120, 240])
    c, s = np.cos(np.pi / 4), np.sin(np.pi / 4)
    small = 1.715 * np.stack([np.full(3, -c), s * np.cos(a), s * np.sin(a)], axis=-1)
    centers, radii = np.vstack([small, [50.8149, 0, 0]]), np.array([1.0, 1, 1, 50])
    apart = np.linalg.norm(centers[:, None] - centers, axis=2) + 1e9 * np.eye(4) - radii[:, None] - radii
    assert apart.min() > 0.1
    return np.array([-1000.0, 0, 0]), centers, radii


def test_printed_weights_are_negative_and_move_away_from_the_goal(four_balls):
    goal, centers, radii = four_balls
    field = HarmonicField(goal, (centers, radii), boundary=0.1, blend="printed")
    np.testing.assert_allclose(field.weights(np.zeros(3)), [0.49975, 0.49975, 0.49975, -0.49925], atol=1e-5)
    assert -field.gradient(np.zeros(3)) @ (np.zeros(3) - goal) == pytest.approx(0.065, abs=2e-3)
    for blend in ("simplex", "smooth"):
        mended = HarmonicField(goal, (centers, radii), boundary=0.1, blend=blend)
        assert mended.weights(np.zeros(3)).min() >= 0.0
        assert -mended.gradient(np.zeros(3)) @ (np.zeros(3) - goal) < 0.0


def test_printed_weights_stall_where_the_mended_ones_arrive(four_balls):
    _, centers, radii = four_balls
    goal, start = np.array([-1000.0, 0, 0]), np.array([0.3, 0.001, 0.0005])
    printed = HarmonicField(goal, (centers, radii), boundary=0.1, blend="printed")
    path = printed.trace(start, step=1e-4, max_steps=12_000, method="euler")
    assert np.linalg.norm(path.points[-1] - start) < 0.4 and not path.reached
    for blend in ("simplex", "smooth"):
        field = HarmonicField(goal, (centers, radii), boundary=0.1, blend=blend)
        assert np.linalg.norm(field.trace(start, step=0.01, max_steps=1500).points[-1] - start) > 8.0


def test_printed_weights_jump_when_a_third_zone_enters():
    """By (k-2) / (k (k-1)) = 1/6 for k = 3, however close the two points are."""
    centers, radii = np.array([[2.0, 0], [-2.0, 0], [0.0, 3.0]]), np.ones(3)
    field = HarmonicField([0, -20], (centers, radii), boundary=0.05, blend="printed")

    def third(y):  # distance of the third zone beyond the boundary layer of the other two, on the axis of symmetry
        return (3.0 - y - 1.0) - (np.hypot(2.0, y) - 1.0) - 0.05

    low, high = 0.0, 1.9
    for _ in range(100):
        y = 0.5 * (low + high)
        low, high = (y, high) if third(y) > 0 else (low, y)
    before, after = field.weights([[0.0, low - 1e-12], [0.0, high + 1e-12]])
    np.testing.assert_allclose(before, [0.5, 0.5, 0.0], atol=1e-6)
    np.testing.assert_allclose(after, [2 / 3, 2 / 3, -1 / 3], atol=1e-6)
    smooth = HarmonicField([0, -20], (centers, radii), boundary=0.05).weights([[0.0, low - 1e-9], [0.0, high + 1e-9]])
    np.testing.assert_allclose(smooth[0], smooth[1], atol=1e-5)


def test_blending_potentials_depends_on_the_unit_of_length():
    """[Rn] (8) read literally: the same scene in metres and in centimetres moves in different directions."""
    centers, radii, x = np.array([[2.0, 0.9], [2.2, -1.0]]), np.array([0.5, 0.6]), np.array([2.1, -0.04])
    literal = [
        HarmonicField([0, 0], (scale * centers, scale * radii), boundary=0.3 * scale, blend="printed-potential")(
            scale * x
        )
        for scale in (1.0, 100.0)
    ]
    fields = [
        HarmonicField([0, 0], (scale * centers, scale * radii), boundary=0.3 * scale)(scale * x)
        for scale in (1.0, 100.0)
    ]
    assert np.linalg.norm(literal[0] - literal[1]) > 0.05
    np.testing.assert_allclose(fields[0], fields[1], atol=1e-12)


def test_printed_potential_is_the_gradient_of_the_blended_potential():
    """Finite differences of sum mu_i U_i with the printed weights: the extra term is the one the paper's (8) implies."""
    centers, radii, x = np.array([[2.0, 0.9], [2.2, -1.0]]), np.array([0.5, 0.6]), np.array([2.1, -0.04])
    field = HarmonicField([0, 0], (centers, radii), boundary=0.3, blend="printed-potential")
    h = 1e-6
    fd = np.array([field.potential(x + h * e) - field.potential(x - h * e) for e in np.eye(2)]) / (2 * h)
    np.testing.assert_allclose(field.gradient(x), fd, rtol=1e-6, atol=1e-8)


def test_sign_of_equation_six():
    """-grad(U_G + U_S) = -e1 / |x - g| + q e2 / |x - S|: printed with both signs turned it leads away from the goal."""
    x, center, radius = np.array([1.5, 0.8, -0.3]), np.array([3.0, 0.5, 0.2]), 0.5
    q = radius / (radius + np.linalg.norm(center))
    e1, e2 = x / np.linalg.norm(x), (x - center) / np.linalg.norm(x - center)
    printed = e1 / np.linalg.norm(x) - q * e2 / np.linalg.norm(x - center)
    h = 1e-6

    def potential(y):
        return np.log(np.linalg.norm(y)) - q * np.log(np.linalg.norm(y - center))

    descent = -np.array([potential(x + h * e) - potential(x - h * e) for e in np.eye(3)]) / (2 * h)
    np.testing.assert_allclose(-printed, descent, atol=1e-8)
    np.testing.assert_allclose(-HarmonicField(np.zeros(3), ([center], [radius])).gradient(x), descent, atol=1e-8)
    assert printed @ x > 0.0
