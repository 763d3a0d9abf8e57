"""Joukowski maps: membership against polygons, round trips, derivative, harmonicity; the printed root maps outside to inside."""

import numpy as np
import pytest

from horosphere.errors import InputError
from horosphere.fields import HarmonicField
from horosphere.maps import Joukowski

SHAPES = {
    "wide": Joukowski.ellipse(2, 1),
    "high": Joukowski.ellipse(0.6, 1.7),
    "turned": Joukowski.ellipse(2, 0.5, [0.4, -0.3], 0.7),
    "circle": Joukowski.ellipse(1, 1),
    "aerofoil": Joukowski.aerofoil(1.0, -0.1 + 0.15j),
    "aerofoil-turned": Joukowski.aerofoil(1.0, [-0.08, 0.1], [0.3, 0.2], -0.5),
}


def polygon_contains(corners, q):
    """Crossing number, written out."""
    inside = np.zeros(len(q), bool)
    for (x1, y1), (x2, y2) in zip(corners, np.roll(corners, -1, axis=0)):
        crosses = (y1 > q[:, 1]) != (y2 > q[:, 1])
        if crosses.any():
            inside[crosses] ^= q[crosses, 0] < (x2 - x1) * (q[crosses, 1] - y1) / (y2 - y1) + x1
    return inside


@pytest.mark.parametrize("name", SHAPES)
def test_membership_round_trip_and_derivative(name):
    shape = SHAPES[name]
    q = np.random.default_rng(4).uniform(-4, 4, (20_000, 2))
    outline = shape.boundary(3000)
    near = np.abs(shape.distance(q)) < 1e-4  # the polygon's own error
    np.testing.assert_array_equal(shape.contains(q)[~near], polygon_contains(outline, q)[~near])
    out = q[~shape.contains(q)]
    p = shape.to_circle(out)
    np.testing.assert_allclose(shape.from_circle(p), out, atol=1e-13)
    assert (np.linalg.norm(p - [shape.mu.real, shape.mu.imag], axis=1) > shape.radius).all()
    h = 1e-6
    for step, turn in (([h, 0.0], 1.0), ([0.0, h], 1j)):  # both directions: Cauchy and Riemann hold
        fd = (shape.from_circle(p + step) - shape.from_circle(p - step)) / (2 * h)
        slope = turn * (shape.derivative(p) @ [1, 1j])
        np.testing.assert_allclose(fd @ [1, 1j], slope, atol=2e-8)


def test_the_outline_is_the_ellipse():
    shape = Joukowski.ellipse(2.0, 0.5, [0.4, -0.3], 0.7)
    c, s = np.cos(0.7), np.sin(0.7)
    local = (shape.boundary(500) - [0.4, -0.3]) @ np.array([[c, -s], [s, c]])
    np.testing.assert_allclose((local / [2.0, 0.5]) ** 2 @ [1, 1], 1.0, atol=1e-12)
    assert shape.radius == 1.25
    star = shape.as_star()
    np.testing.assert_allclose(star.level(shape.boundary(100)), 0.0, atol=1e-12)


def test_the_printed_root_maps_half_of_the_outside_into_the_circle():
    """[Humanoid] (33) with the principal square root; docs/errata.md."""
    shape = SHAPES["wide"]
    q = np.random.default_rng(0).uniform(-4, 4, (20_000, 2))
    q = q[~shape.contains(q)]
    z = q @ [1, 1j]
    printed = 0.5 * (z + np.sqrt(z * z - 3.0))
    inside = np.abs(printed) < shape.radius
    assert 0.45 < inside.mean() < 0.55
    ours = shape.to_circle(q) @ [1, 1j]
    np.testing.assert_allclose(ours[~inside], printed[~inside], atol=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_the_pulled_back_potential_is_harmonic(name):
    shape = SHAPES[name]
    goal = np.array([3.1, 2.2])
    field = HarmonicField(goal, [shape])
    rng = np.random.default_rng(1)
    q = rng.uniform(-4, 4, (200, 2))
    q = q[(shape.distance(q) > 0.25) & (np.linalg.norm(q - goal, axis=1) > 0.4)]
    h = 1e-3
    moved = [field.potential(q + h * e) for e in np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])]
    assert np.abs((sum(moved) - 4 * field.potential(q)) / h**2).max() < 1e-3
    gradient = np.stack([moved[0] - moved[1], moved[2] - moved[3]], axis=-1) / (2 * h)
    np.testing.assert_allclose(field.gradient(q), gradient, atol=2e-4)
    # the map is conformal: steepest descent of the pulled-back potential is the pulled-back motion
    np.testing.assert_allclose(
        field(q), -field.gradient(q) / np.linalg.norm(field.gradient(q), axis=1, keepdims=True), atol=1e-9
    )


@pytest.mark.parametrize("name", SHAPES)
def test_paths_keep_out_and_arrive(name):
    shape = SHAPES[name]
    rng = np.random.default_rng(2)
    runs = 0
    while runs < 12:
        start, goal = rng.uniform(-4, 4, (2, 2))
        if min(shape.distance(start), shape.distance(goal)) < 0.15:
            continue
        runs += 1
        path = HarmonicField(goal, [shape]).trace(start, step=rng.choice([0.02, 0.2, 2.0]))
        dense = np.concatenate([path.points[:-1] + t * np.diff(path.points, axis=0) for t in np.linspace(0, 1, 6)])
        assert path.reached and not shape.contains(dense).any()


def test_margins():
    """A circle 5 % larger keeps paths 3 mm off the trailing edge and 0.11 m off the rest: clearance is not transported evenly."""
    foil = SHAPES["aerofoil"]
    near = foil.distance(foil.boundary(4001, 1.05))
    assert near.min() == pytest.approx(0.003, abs=1e-3) and near.max() == pytest.approx(0.113, abs=5e-3)
    slope = np.linalg.norm(
        foil.derivative(
            foil.circle[0] + foil.circle[1] * np.array([[np.cos(t), np.sin(t)] for t in np.linspace(0, 6.3, 4000)])
        ),
        axis=1,
    )
    assert slope.min() == pytest.approx(0.10, abs=0.01)
    grown = foil.grown(0.1)
    assert foil.distance(grown.boundary(4001, grown.margin)).min() == pytest.approx(0.1, rel=2e-2)
    # adding the margin to both semi-axes is not enough for an ellipse
    t = np.linspace(0, 2 * np.pi, 1001)
    short = Joukowski.ellipse(2.0, 0.5).distance(np.stack([2.3 * np.cos(t), 0.8 * np.sin(t)], axis=-1)).min()
    assert short == pytest.approx(0.3 - 0.047, abs=2e-3)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Joukowski.ellipse(-1, 1), "above 0"),
        (lambda: Joukowski.ellipse(1, np.nan), "finite"),
        (lambda: Joukowski.aerofoil(0, -0.1), "k > 0"),
        (lambda: Joukowski.aerofoil(1, 0.1), "mu"),
        (lambda: Joukowski.aerofoil(1, -0.1, margin=0.9), "margin"),
        (lambda: Joukowski.ellipse(1, 1).to_circle([1, 2, 3]), r"\(..., 2\)"),
        (lambda: HarmonicField([0.2, 0.1], [Joukowski.ellipse(2, 1)]), "goal lies"),
        (lambda: HarmonicField([5, 0, 0], [Joukowski.ellipse(2, 1)]), r"R\^2"),
    ],
)
def test_bad_input(make, words):
    with pytest.raises(InputError, match=words):
        make()
