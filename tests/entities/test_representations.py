"""Blades of the entities: null spaces, both duals, parameters out again, against the dense algebra and vector geometry."""

import numpy as np
import pytest

import horosphere as hs
from horosphere.algebra import Multivector, basis

from .samples import KINDS, points_on, random

SEEDS = [0, 1, 2]
SHAPES = [(), (1,), (4,), (2, 3), (0,)]
GRADES = {"Point": 1, "Sphere": 1, "Plane": 1, "Circle": 2, "Line": 2, "PointPair": 3}


def up(x):
    """The conformal point of coordinates, by the dense algebra."""
    x = np.asarray(x, float)
    coordinates = np.zeros((*x.shape[:-1], 5))
    coordinates[..., :3] = x
    return Multivector.vector(coordinates) + 0.5 * np.sum(x * x, -1) * basis.ei + basis.e0


def size(a):
    return np.abs(a.coefficients).max(-1)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", KINDS)
def test_its_points_are_the_null_space(kind, seed):
    rng = np.random.default_rng(seed)
    x = random(kind, rng)
    on, off = up(points_on(x, rng)), up(rng.normal(size=(9, 3)) + 5)
    ipns, opns = x.as_ipns(), x.as_opns()
    assert (size(on | ipns) < 1e-13 * 100).all() and (size(off | ipns) > 1e-3).all()
    assert (size(on ^ opns) < 1e-13 * 100).all() and (size(off ^ opns) > 1e-3).all()
    assert ipns.grades() == (GRADES[kind],)
    if kind != "Point":
        assert opns.isclose(ipns.dual()) and opns.grades() == (5 - GRADES[kind],)


@pytest.mark.parametrize("seed", SEEDS)
def test_opns_blades_are_the_outer_products_of_points_in_order(seed):
    """The signs of the convention: every join is the OPNS blade up to a positive weight."""
    a, b, c, d = np.random.default_rng(seed).normal(size=(4, 3))
    joins = [
        (hs.Line.from_points(a, b), up(a) ^ up(b) ^ basis.ei),
        (hs.Plane.from_points(a, b, c), up(a) ^ up(b) ^ up(c) ^ basis.ei),
        (hs.Circle.from_points(a, b, c), up(a) ^ up(b) ^ up(c)),
        (hs.PointPair.from_points(a, b), up(a) ^ up(b)),
    ]
    for x, blade in joins:
        weight = np.sum(x.as_opns().coefficients * blade.coefficients) / np.sum(x.as_opns().coefficients ** 2)
        assert weight > 0
        assert (weight * x.as_opns()).isclose(blade, rtol=1e-12)
    sphere, blade = hs.Sphere.from_points(a, b, c, d), up(a) ^ up(b) ^ up(c) ^ up(d)
    weight = (
        blade.coefficients[np.argmax(np.abs(blade.coefficients))]
        / sphere.as_opns().coefficients[np.argmax(np.abs(blade.coefficients))]
    )
    assert (weight * sphere.as_opns()).isclose(blade, rtol=1e-11)


def test_the_printed_forms_of_table_1():
    n, d, c, r = np.array([0.0, 0.6, 0.8]), 0.3, np.array([1.0, -2.0, 0.5]), 0.7
    plane = hs.Plane.from_normal_distance(n, d).as_ipns()
    assert plane.isclose(0.6 * basis.e2 + 0.8 * basis.e3 + d * basis.ei)
    assert hs.Sphere.from_center_radius(c, r).as_ipns().isclose(up(c) - 0.5 * r**2 * basis.ei)
    line = hs.Line.from_point_direction(c, n)
    direction, moment = 0.6 * basis.e2 + 0.8 * basis.e3, Multivector.vector([*np.cross(c, n), 0, 0])
    assert line.as_ipns().isclose(direction * basis.Ie - (basis.ei ^ moment))
    np.testing.assert_allclose(line.moment, np.cross(c, n), atol=1e-15)
    s1, s2 = (hs.Sphere.from_center_radius(x, 1.5).as_ipns() for x in (c, c + n))
    assert hs.Circle.from_ipns(s1 ^ s2).as_ipns().isclose(s1 ^ s2)  # both centers one apart: weight 1


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("kind", KINDS)
def test_blades_of_any_weight_come_back(kind, shape, seed):
    rng = np.random.default_rng(seed)
    x = random(kind, rng, shape)
    weight = rng.uniform(0.3, 3.0, size=shape)
    for back in (type(x).from_ipns(weight * x.as_ipns()), type(x).from_opns(weight * x.as_opns())):
        assert back.shape == shape
        assert back.isclose(x, rtol=1e-11, atol=1e-11).all()


@pytest.mark.parametrize("kind", KINDS)
def test_blades_of_other_types_are_refused(kind):
    rng = np.random.default_rng(3)
    for other in KINDS:
        if other != kind and {kind, other} != {"Point", "Sphere"}:
            with pytest.raises(hs.InputError):
                getattr(hs, kind).from_ipns(random(other, rng).as_ipns())
    with pytest.raises(hs.InputError):
        getattr(hs, kind).from_ipns(np.zeros(32))
    with pytest.raises(hs.InputError):
        hs.Point.from_ipns(hs.Sphere.from_center_radius([0, 1, 0], 2.0).as_ipns())


@pytest.mark.parametrize("seed", SEEDS)
def test_parameters_of_joins(seed):
    rng = np.random.default_rng(seed)
    a, b, c, d = rng.normal(size=(4, 50, 3))
    circle, sphere, plane = (
        hs.Circle.from_points(a, b, c),
        hs.Sphere.from_points(a, b, c, d),
        hs.Plane.from_points(a, b, c),
    )
    for p in (a, b, c):
        np.testing.assert_allclose(np.linalg.norm(p - circle.center, axis=-1), circle.radius, rtol=1e-9)
        np.testing.assert_allclose(np.sum((p - circle.center) * circle.normal, -1), 0, atol=1e-9)
        np.testing.assert_allclose(np.linalg.norm(p - sphere.center, axis=-1), sphere.radius, rtol=1e-9)
        np.testing.assert_allclose(np.sum(p * plane.normal, -1), plane.distance, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(d - sphere.center, axis=-1), sphere.radius, rtol=1e-8)
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    np.testing.assert_allclose(circle.normal, n, atol=1e-11)
    np.testing.assert_allclose(plane.normal, n, atol=1e-11)
    np.testing.assert_allclose(hs.PointPair.from_points(a, b).points, np.stack([a, b], -2), atol=1e-14)
    line = hs.Line.from_points(a, b)
    np.testing.assert_allclose(np.cross(b, line.direction), line.moment, atol=1e-13)
    np.testing.assert_allclose(line.direction, (b - a) / np.linalg.norm(b - a, axis=-1, keepdims=True), atol=1e-15)


@pytest.mark.parametrize("seed", SEEDS)
def test_helpers_stay_on_the_entity(seed):
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(7, 3))
    for kind in ("Plane", "Line"):
        entity = random(kind, rng)
        foot = entity.project(x)
        np.testing.assert_allclose(hs.Point.from_euclidean(foot).distance_to(entity), 0, atol=1e-14)
        np.testing.assert_allclose(
            np.linalg.norm(x - foot, axis=-1), hs.Point.from_euclidean(x).distance_to(entity), atol=1e-14
        )
    circle = random("Circle", rng)
    on = hs.Point.from_euclidean(circle.point_at(np.linspace(0, 6, 5)))
    np.testing.assert_allclose(on.distance_to(circle), 0, atol=1e-14)
    plane, sphere = random("Plane", rng), random("Sphere", rng)
    np.testing.assert_allclose(plane.side_of(x), x @ plane.normal - plane.distance)
    assert (sphere.contains(x) == (np.linalg.norm(x - sphere.center, axis=-1) <= sphere.radius)).all()
    np.testing.assert_allclose(circle.plane.side_of(circle.point_at(1.0)), 0, atol=1e-14)
    pair = random("PointPair", rng)
    np.testing.assert_allclose(hs.Point.from_euclidean(pair.points).distance_to(pair.line), 0, atol=1e-14)
    np.testing.assert_allclose(hs.Point.from_euclidean(pair.points).distance_to(pair.sphere), 0, atol=1e-14)
