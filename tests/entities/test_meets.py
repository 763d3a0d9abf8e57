"""Meets against the outer product of the IPNS blades in the dense algebra, and their degenerate cases."""

import numpy as np
import pytest

import horosphere as hs
from horosphere.entities import _kernels as k

from .samples import KINDS, points_on, random

RESULTS = {
    ("Sphere", "Sphere"): "Circle",
    ("Sphere", "Plane"): "Circle",
    ("Plane", "Sphere"): "Circle",
    ("Plane", "Plane"): "Line",
    ("Circle", "Plane"): "PointPair",
    ("Plane", "Circle"): "PointPair",
    ("Circle", "Sphere"): "PointPair",
    ("Sphere", "Circle"): "PointPair",
    ("Line", "Sphere"): "PointPair",
    ("Sphere", "Line"): "PointPair",
    ("Line", "Plane"): "Point",
    ("Plane", "Line"): "Point",
}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("shapes", [((), ()), ((5,), (5,)), ((3, 1), (4,)), ((), (9,))], ids=str)
@pytest.mark.parametrize("pair", RESULTS, ids="-".join)
def test_the_meet_is_the_outer_product_with_its_sign(pair, shapes, seed):
    rng = np.random.default_rng(seed)
    a, b = (random(kind, rng, shape) for kind, shape in zip(pair, shapes))
    met = a & b
    assert type(met) is getattr(hs, RESULTS[pair]) and met.shape == np.broadcast_shapes(*shapes)
    expected, got = a.as_ipns() ^ b.as_ipns(), met.as_ipns()
    if RESULTS[pair] == "Point":  # the outer product is the flat point (x ^ ei) I
        ei = hs.algebra.basis.ei
        got = (met.as_ipns() ^ ei).undual()
    weight = np.sum(expected.coefficients * got.coefficients, -1) / np.sum(got.coefficients**2, -1)
    np.testing.assert_allclose((weight * got).coefficients, expected.coefficients, atol=1e-11)
    if RESULTS[pair] != "Point":
        assert (weight > 0).all()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("pair", RESULTS, ids="-".join)
def test_real_meets_lie_on_both(pair, seed):
    rng = np.random.default_rng(seed)
    a, b = (random(kind, rng, (200,)) for kind in pair)
    met = a & b
    real = met.is_real
    assert real.sum() > 0
    for i in np.flatnonzero(real)[:20]:
        on = hs.Point.from_euclidean(points_on(met[i], rng))
        for parent in (a[i], b[i]):
            np.testing.assert_allclose(on.distance_to(parent), 0, atol=1e-6 if met[i].array[-1] < 1e-6 else 1e-10)
    if RESULTS[pair] in ("Circle", "PointPair"):
        assert (met.radius_squared[~real] < 0).all() and np.isnan(met.radius[~real]).all()


def test_three_spheres_meet_in_the_points_they_were_drawn_through():
    rng = np.random.default_rng(7)
    x, y = rng.normal(size=(2, 50, 3))
    # the bisecting plane of x and y carries the centers of spheres through both
    u = np.linalg.svd((y - x)[:, None, :])[2][:, 1:]
    centers = 0.5 * (x + y)[:, None] + np.einsum("bij,bjk->bik", rng.normal(size=(50, 3, 2)), u)
    s = [hs.Sphere.from_center_radius(centers[:, i], np.linalg.norm(centers[:, i] - x, axis=-1)) for i in range(3)]
    points = (s[0] & s[1] & s[2]).points
    straight = np.abs(points - np.stack([x, y], -2)).max((-1, -2))
    swapped = np.abs(points - np.stack([y, x], -2)).max((-1, -2))
    assert np.minimum(straight, swapped).max() < 1e-8


def test_imaginary_meets_are_values():
    a, b = hs.Sphere.from_center_radius([0, 0, 0], 1.0), hs.Sphere.from_center_radius([3, 0, 0], 1.0)
    circle = a & b
    assert not circle.is_real and circle.radius_squared == pytest.approx(1 - 1.5**2) and np.isnan(circle.radius)
    np.testing.assert_allclose(circle.center, [1.5, 0, 0])
    pair = hs.Line.from_points([0, 2, 0], [1, 2, 0]) & a
    assert not pair.is_real and pair.radius_squared == pytest.approx(-3.0) and np.isnan(pair.points).all()
    np.testing.assert_allclose(pair.center, [0, 2, 0], atol=1e-15)
    assert a.distance_to(circle) == np.inf and circle.as_ipns().isclose(hs.Circle.from_ipns(circle.as_ipns()).as_ipns())


def test_tangent_spheres_touch_in_a_circle_of_radius_zero():
    a, b = hs.Sphere.from_center_radius([0, 0, 0], 1.0), hs.Sphere.from_center_radius([3, 0, 0], 2.0)
    circle = a & b
    assert circle.is_real and circle.radius == 0.0
    np.testing.assert_allclose(circle.center, [1, 0, 0], atol=1e-15)


@pytest.mark.parametrize("offset", [0.0, 1e4])
def test_parallels_meet_nowhere_and_say_so(offset):
    up = np.array([0.0, 0.6, 0.8])
    p, q = hs.Plane.from_normal_distance(up, offset), hs.Plane.from_normal_distance(up, offset + 2.0)
    line = p & q
    assert not line.is_real
    np.testing.assert_allclose(line.moment, 2.0 * up, rtol=1e-11)
    point = hs.Line.from_point_direction([offset, 0, 0], [1, 0, 0]) & p
    assert not point.is_real and np.isnan(point.as_euclidean()).all()
    np.testing.assert_allclose(point.direction, [1, 0, 0])
    pair = hs.Circle.from_center_normal_radius([offset, 0, 0], up, 1.0) & p
    assert not pair.is_real and pair.radius_squared == -np.inf and np.isnan(pair.points).all()
    s = hs.Sphere.from_center_radius([offset, 1, 2], 1.0)
    for circle in (s & s, s & hs.Sphere.from_center_radius([offset, 1, 2], 2.0)):
        assert not circle.is_real and circle.radius_squared == -np.inf
        assert (circle.as_ipns().coefficients == 0).all() and "imaginary" in repr(circle)
    for empty in (line, point, pair, circle):
        assert empty.distance_to(hs.Point.origin()) == np.inf


def test_pairs_without_a_meet_are_named():
    rng = np.random.default_rng(0)
    for x in KINDS:
        for y in KINDS:
            if (x, y) not in RESULTS:
                with pytest.raises(hs.InputError, match=f"{x} and {y} have no meet"):
                    _ = random(x, rng) & random(y, rng)
    with pytest.raises(hs.InputError, match="expected an entity, got float"):
        _ = random("Plane", rng) & 1.0
    with pytest.raises(hs.InputError, match="broadcast"):
        _ = random("Plane", rng, (2,)) & random("Plane", rng, (3,))


@pytest.mark.parametrize("count", [1, 3, 8, 21])
def test_compiled_meets_are_the_reference_ones(count):
    rng = np.random.default_rng(count)
    for kernel, kinds in [
        (k.sphere_sphere, ("Sphere", "Sphere")),
        (k.sphere_plane, ("Sphere", "Plane")),
        (k.plane_plane, ("Plane", "Plane")),
        (k.line_plane, ("Line", "Plane")),
        (k.circle_plane, ("Circle", "Plane")),
        (k.circle_sphere, ("Circle", "Sphere")),
        (k.line_sphere, ("Line", "Sphere")),
    ]:
        a, b = (random(kind, rng, (count,)).array for kind in kinds)
        np.testing.assert_allclose(kernel(a, b), kernel.reference(a, b), rtol=1e-9, atol=1e-11)
