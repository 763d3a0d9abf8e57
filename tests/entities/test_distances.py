"""Distances and angles: against numerical minimisation, and with 60 digits where cancellation is the danger."""

import numpy as np
import pytest
from scipy.optimize import minimize

import horosphere as hs

from . import exact as e
from .samples import KINDS, random

SHAPES = [((), ()), ((5,), (5,)), ((3, 1), (4,)), ((), (6,))]
DISTANCES = {
    *(("Point", k) for k in KINDS),
    *(("PointPair", k) for k in KINDS),
    ("Line", "Line"), ("Line", "Plane"), ("Line", "Sphere"), ("Plane", "Plane"), ("Plane", "Sphere"), ("Plane", "Circle"),
    ("Sphere", "Sphere"), ("Sphere", "Circle"),
}  # fmt: skip
NONE = {("Line", "Circle"), ("Circle", "Circle")}


def parametrised(x):
    """Plain parametrisation (count of parameters, function) of a single entity; a sphere is its center."""
    name = type(x).__name__
    if name == "Point":
        return 0, lambda t: x.as_euclidean()
    if name == "Sphere":
        return 0, lambda t: x.center
    direction = x.direction if name == "Line" else x.normal
    u = np.linalg.svd(direction[None])[2][1:]
    if name == "Line":
        return 1, lambda t: np.cross(x.direction, x.moment) + t[0] * direction
    if name == "Plane":
        return 2, lambda t: x.normal * x.distance + t @ u
    return 1, lambda t: x.center + x.radius * (np.cos(t[0]) * u[0] + np.sin(t[0]) * u[1])


def by_minimisation(a, b, rng):
    """The smallest distance found from 12 starts, minus the radii of spheres."""
    for x, y in ((a, b), (b, a)):
        if isinstance(x, hs.PointPair):
            return min(by_minimisation(hs.Point.from_euclidean(p), y, rng) for p in x.points)
    (m, f), (n, g) = parametrised(a), parametrised(b)
    radii = sum(x.radius for x in (a, b) if isinstance(x, hs.Sphere))
    if m + n == 0:
        return np.linalg.norm(f([]) - g([])) - radii

    def square(t):
        return np.sum((f(t[:m]) - g(t[m:])) ** 2)

    best = min(minimize(square, rng.uniform(-3, 3, m + n), tol=1e-14).fun for _ in range(12))
    return np.sqrt(best) - radii


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("pair", sorted(DISTANCES), ids="-".join)
def test_distance_is_the_minimum(pair, seed):
    rng = np.random.default_rng(seed)
    a, b = (random(kind, rng) for kind in pair)
    assert a.distance_to(b) == pytest.approx(by_minimisation(a, b, rng), abs=2e-6)
    assert b.distance_to(a) == a.distance_to(b)


@pytest.mark.parametrize("shapes", SHAPES, ids=str)
@pytest.mark.parametrize("pair", sorted(DISTANCES), ids="-".join)
def test_distances_batch(pair, shapes):
    rng = np.random.default_rng(4)
    a, b = (random(kind, rng, shape) for kind, shape in zip(pair, shapes))
    d = a.distance_to(b)
    assert np.shape(d) == np.broadcast_shapes(*shapes)
    full = np.broadcast_shapes(*shapes)
    a, b = a.broadcast_to(full), b.broadcast_to(full)
    for i in np.ndindex(full):
        assert np.asarray(d)[i] == pytest.approx(a[i].distance_to(b[i]) if full else d, rel=1e-14)


def test_signs_and_special_positions():
    ball = hs.Sphere.from_center_radius([0, 0, 0], 2.0)
    assert hs.Point.origin().distance_to(ball) == -2.0
    assert ball.distance_to(hs.Sphere.from_center_radius([1, 0, 0], 0.5)) == -1.5
    z0 = hs.Plane.from_normal_distance([0, 0, 1], 0.0)
    assert z0.distance_to(hs.Plane.from_normal_distance([0, 0, -3], 2.0)) == 2.0
    assert z0.distance_to(hs.Plane.from_normal_distance([0, 1, 1], 2.0)) == 0.0
    assert z0.distance_to(hs.Line.from_points([0, 0, 3], [1, 0, 3])) == 3.0
    assert hs.Line.from_points([0, 0, 3], [1, 0, 3]).distance_to(hs.Line.from_points([5, 4, 3], [4, 4, 3])) == 4.0
    circle = hs.Circle.from_center_normal_radius([0, 0, 3], [0, 1, 1], 1.0)
    assert z0.distance_to(circle) == pytest.approx(3 - np.sqrt(0.5))
    assert hs.Point.from_euclidean([0, 0, 3]).distance_to(circle) == pytest.approx(1.0)
    for a, b in NONE:
        rng = np.random.default_rng(1)
        with pytest.raises(hs.InputError, match=f"{a} and {b} have no distance"):
            random(a, rng).distance_to(random(b, rng))


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("gap", [1e-12, 1e-8, 1e-3, 1.0])
def test_small_distances_far_away(seed, gap):
    """1e4 from the origin: points are exact, the others to a few units in the last place of their coordinates (2e-12)."""
    rng = np.random.default_rng(seed)
    a = rng.normal(size=3)
    a *= 1e4 / np.linalg.norm(a)
    u, v, w = rng.normal(size=(3, 3))
    near = a + gap * v / np.linalg.norm(v)
    p = hs.Point.from_euclidean(near)
    exact = float(e.norm(e.sub(e.vec(near), e.vec(a))))
    assert p.distance_to(hs.Point.from_euclidean(a)) == pytest.approx(exact, rel=1e-15)
    b, c = a + u, a + w
    A, B, C, P = (e.vec(x) for x in (a, b, c, near))
    ulp = 1.82e-12
    n = e.unit(e.sub(B, A))
    assert p.distance_to(hs.Line.from_points(a, b)) == pytest.approx(
        float(e.norm(e.cross(e.sub(P, A), n))), abs=4 * ulp
    )
    n = e.unit(e.cross(e.sub(B, A), e.sub(C, A)))
    expected = abs(float(e.dot(e.sub(P, A), n)))
    assert p.distance_to(hs.Plane.from_points(a, b, c)) == pytest.approx(expected, abs=2 * ulp)
    ball = hs.Sphere.from_center_radius(a, 2 * gap)
    assert p.distance_to(ball) == pytest.approx(exact - 2 * gap, rel=1e-14)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("size", [1e-6, 1e-3, 1.0, 1e3])
def test_rounds_far_away_keep_their_size(seed, size):
    """Centers to a few units in the last place of the coordinates at 1e4, radii to 1e-14 relative plus that rounding."""
    rng = np.random.default_rng(seed)
    far = rng.normal(size=3)
    far *= 1e4 / np.linalg.norm(far)
    a, b, c = far + size * rng.normal(size=(3, 3))
    center, radius = e.circumcircle(e.vec(a), e.vec(b), e.vec(c))
    circle = hs.Circle.from_points(a, b, c)
    edges = np.array([a - b, b - c, c - a])
    condition = np.linalg.norm(edges, axis=-1).prod() / np.linalg.norm(np.cross(edges[0], edges[1])) / size
    assert circle.radius == pytest.approx(float(radius), rel=1e-14 * condition * 10)
    assert np.abs(circle.center - [float(x) for x in center]).max() < 4e-12 + 1e-13 * size * condition
    pair = hs.PointPair.from_points(a, b)
    assert np.abs(pair.points - [a, b]).max() < 4e-12
    half = float(e.norm(e.sub(e.vec(b), e.vec(a)))) / 2
    assert pair.radius == pytest.approx(half, rel=1e-15)
    ball = hs.Sphere.from_center_radius(far, size)
    assert ball.radius == pytest.approx(size, rel=1e-15) and (ball.center == far).all()


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("ratio", [1.0, 1e-4, 1e4])
def test_meets_of_spheres_far_away(seed, ratio):
    """Two spheres of very different sizes 1e4 from the origin: the circle against 60 digits."""
    rng = np.random.default_rng(seed)
    c1 = rng.normal(size=3) * 1e4
    u = rng.normal(size=3)
    c2 = c1 + u / np.linalg.norm(u) * max(1.0, ratio)
    a, b = hs.Sphere.from_center_radius(c1, 1.0), hs.Sphere.from_center_radius(c2, ratio)
    center, square = e.sphere_circle(e.vec(c1), e.Decimal(1), e.vec(c2), e.Decimal(ratio))
    circle = a & b
    scale = min(1.0, ratio)
    assert np.abs(circle.center - [float(x) for x in center]).max() < 1e-11
    assert abs(circle.radius_squared - float(square)) < 1e-11 * max(1.0, ratio) * scale


@pytest.mark.parametrize("seed", range(3))
def test_angles(seed):
    rng = np.random.default_rng(seed)
    u, v = rng.normal(size=(2, 40, 3))
    p = rng.normal(size=(40, 3))
    cosine = np.sum(u * v, -1) / np.linalg.norm(u, axis=-1) / np.linalg.norm(v, axis=-1)
    lines = hs.Line.from_point_direction(p, u), hs.Line.from_point_direction(p + v, v)
    planes = hs.Plane.from_normal_distance(u, 1.0), hs.Plane.from_normal_distance(v, 2.0)
    circles = hs.Circle.from_center_normal_radius(p, u, 1.0), hs.Circle.from_center_normal_radius(p, v, 1.0)
    pair = hs.PointPair.from_points(p, p + u)
    for a, b in [lines, planes, circles, (planes[0], circles[1]), (pair, lines[1]), (circles[0], planes[1])]:
        np.testing.assert_allclose(np.cos(a.angle_to(b)), cosine, atol=1e-14)
    for a, b in [(lines[0], planes[1]), (planes[0], lines[1]), (pair, circles[1]), (lines[0], circles[1])]:
        np.testing.assert_allclose(np.sin(a.angle_to(b)), np.abs(cosine), atol=1e-14)
        assert ((a.angle_to(b) >= 0) & (a.angle_to(b) <= np.pi / 2)).all()
    # spheres: s1.s2 = r1 r2 cos, with the radii at a common point
    a, b = random("Sphere", rng, (100,)), random("Sphere", rng, (100,))
    inner = (a.as_ipns() | b.as_ipns()).scalar_part / (a.radius * b.radius)
    meet = (a & b).is_real
    assert (np.isnan(a.angle_to(b)) == ~meet).all() and 0 < meet.sum() < 100
    np.testing.assert_allclose(np.cos(a.angle_to(b))[meet], inner[meet], atol=1e-12)
    plane = random("Plane", rng, (100,))
    inner, meet = (a.as_ipns() | plane.as_ipns()).scalar_part / a.radius, (a & plane).is_real
    assert (np.isnan(a.angle_to(plane)) == ~meet).all()
    np.testing.assert_allclose(np.cos(plane.angle_to(a))[meet], inner[meet], atol=1e-12)
    with pytest.raises(hs.InputError, match="Point and Line have no angle"):
        hs.Point.origin().angle_to(lines[0])


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 1e-3, np.pi / 2, np.pi - 1e-8, np.pi])
def test_small_angles_have_all_digits(angle):
    a = hs.Line.from_point_direction([0, 0, 0], [1, 0, 0])
    b = hs.Line.from_point_direction([0, 0, 1], [np.cos(angle), np.sin(angle), 0])
    assert a.angle_to(b) == pytest.approx(angle, rel=1e-15, abs=1e-16)
