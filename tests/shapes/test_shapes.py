"""Shapes: signed distances against sampled surfaces, checks of what is given, conversion."""

import pickle

import numpy as np
import pytest

import horosphere.shapes as shapes
from horosphere.errors import InputError
from horosphere.shapes import Ball, Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Mesh, PointCloud, as_shapes, pack


def rotation(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    q[:, 0] *= np.sign(np.linalg.det(q))
    return q


def surface(rng, shape, n):
    """Random points on the surface, by formulas of their own."""
    u = rng.normal(size=(n, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    if isinstance(shape, Ball):
        return shape.center + shape.radius * u
    if isinstance(shape, Ellipsoid):
        return shape.center + (u * shape.semi_axes) @ shape.rotation.T
    if isinstance(shape, Box):
        x = rng.uniform(-1, 1, (n, 3))
        side = rng.integers(3, size=n)
        x[np.arange(n), side] = rng.choice([-1.0, 1.0], n)
        return shape.center + (x * shape.half_sizes) @ shape.rotation.T
    axis = (shape.b - shape.a) / np.linalg.norm(shape.b - shape.a)
    across = u - (u @ axis)[:, None] * axis
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    t = rng.uniform(0, 1, n)
    side = shape.a + t[:, None] * (shape.b - shape.a) + shape.radius * across
    if isinstance(shape, Capsule):
        caps = np.where((u @ axis)[:, None] > 0, shape.b, shape.a) + shape.radius * u
    else:
        caps = np.where(t[:, None] > 0.5, shape.b, shape.a) + shape.radius * np.sqrt(rng.random(n))[:, None] * across
    return np.where(rng.random(n)[:, None] < 0.5, side, caps)


def random_shape(rng, kind):
    c = rng.normal(size=3)
    if kind == "ball":
        return Ball(c, 0.7)
    if kind == "ellipsoid":
        return Ellipsoid(c, rng.uniform(0.2, 1.0, 3), rotation(rng))
    if kind == "box":
        return Box(c, rng.uniform(0.2, 1.0, 3), rotation(rng))
    cls = Capsule if kind == "capsule" else Cylinder
    return cls(c, c + rng.normal(size=3), rng.uniform(0.2, 0.8))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", ["ball", "ellipsoid", "box", "capsule", "cylinder"])
def test_signed_distance_is_that_to_the_nearest_surface_point(kind, seed):
    rng = np.random.default_rng(seed)
    shape = random_shape(rng, kind)
    cloud = surface(rng, shape, 60_000)
    assert np.abs(shape.signed_distance(cloud)).max() < 1e-12
    points = shape.bounding_ball()[0] + rng.normal(size=(40, 3)) * 0.8
    d = shape.signed_distance(points)
    sampled = np.linalg.norm(points[:, None] - cloud, axis=2).min(axis=1)
    assert (sampled >= np.abs(d) - 1e-12).all()  # no sample is nearer than the distance
    assert (sampled - np.abs(d)).max() < 0.03  # and one is nearly as near
    centre, radius = shape.bounding_ball()
    assert np.linalg.norm(cloud - centre, axis=1).max() <= radius + 1e-12
    assert shape.signed_distance(centre) < 0.0 < shape.signed_distance(centre + 2.1 * radius * np.array([1.0, 0, 0]))


@pytest.mark.parametrize("seed", range(3))
def test_gradient_of_the_signed_distance_has_length_one(seed):
    rng = np.random.default_rng(seed)
    for kind in ("ellipsoid", "box", "cylinder"):
        shape = random_shape(rng, kind)
        x, h = rng.normal(size=(50, 3)) * 2.0, 1e-6
        g = np.stack(
            [(shape.signed_distance(x + h * e) - shape.signed_distance(x - h * e)) / (2 * h) for e in np.eye(3)], -1
        )
        assert np.quantile(np.abs(np.linalg.norm(g, axis=1) - 1.0), 0.9) < 1e-8


def test_half_space_is_scaled_to_a_unit_normal():
    half = HalfSpace([0.0, 0.0, 2.0], 1.0)
    np.testing.assert_allclose(
        half.signed_distance([[0, 0, 0.5], [5, 5, 2.0], [0, 0, 0]]), [0.0, 1.5, -0.5], atol=1e-15
    )
    assert half.bounding_ball()[1] == np.inf


CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
CUBE_FACES = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])


def test_mesh_of_a_cube_is_a_box():
    rng = np.random.default_rng(0)
    mesh, box = Mesh(CUBE, CUBE_FACES), Box([0.5, 0.5, 0.5], [0.5, 0.5, 0.5])
    assert mesh.is_watertight and not Mesh(CUBE, CUBE_FACES[:-1]).is_watertight
    points = rng.uniform(-1, 2, (200, 3))
    np.testing.assert_allclose(mesh.signed_distance(points), box.signed_distance(points), atol=1e-14)


def test_point_cloud_is_its_balls():
    rng = np.random.default_rng(1)
    centers, radii = rng.normal(size=(10, 3)), rng.uniform(0.1, 0.3, 10)
    cloud, x = PointCloud(centers, radii), rng.normal(size=(2, 5, 3))
    expected = np.min([Ball(c, r).signed_distance(x) for c, r in zip(centers, radii)], axis=0)
    np.testing.assert_allclose(cloud.signed_distance(x), expected, atol=1e-15)


def test_a_ball_lives_in_any_dimension():
    ball = Ball([1.0, 0, 0, 0, 0], 2.0)
    assert ball.dimension == 5 and ball.signed_distance(np.zeros(5)) == -1.0
    assert Ball([0.0, 0.0], 1.0).signed_distance([[3.0, 4.0]]) == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Ball([0, 0, 0], -1.0), "Ball.radius.*>= 0"),
        (lambda: Ball([0, np.nan, 0], 1.0), "nan at index"),
        (lambda: Ball([0.0], 1.0), "at least 2"),
        (lambda: Capsule([0, 0], [1, 0, 0], 0.1), r"expected shape \(\.\.\., 3\)"),
        (lambda: Cylinder([0, 0, 0], [0, 0, 0], 0.1), "coincide"),
        (lambda: Box([0, 0, 0], [1, 1, -1]), ">= 0"),
        (lambda: Box([0, 0, 0], [1, 1, 1], 2 * np.eye(3)), "not a rotation"),
        (lambda: Box([0, 0, 0], [1, 1, 1], np.diag([1.0, 1, -1])), "reflection"),
        (lambda: Ellipsoid([0, 0, 0], [1, 0, 1]), "> 0"),
        (lambda: HalfSpace([0, 0, 0], 1.0), "zero vector"),
        (lambda: Mesh(CUBE, [[0, 1, 8]]), "outside 0 .. 7"),
        (lambda: Mesh(CUBE, [[0.0, 1, 2]]), "integers"),
        (lambda: Mesh(CUBE, np.zeros((0, 3), int)), "no faces"),
        (lambda: PointCloud(np.zeros((0, 3)), 0.1), "at least one"),
        (lambda: PointCloud(np.zeros((2, 3)), [0.1, -0.1]), ">= 0"),
        (lambda: as_shapes("ball"), "cannot read an obstacle from str.*Ball"),
        (lambda: as_shapes([Ball([0, 0, 0], 1), 3]), "from int"),
        (lambda: as_shapes((np.zeros((3, 3)), [1.0, 2.0])), "3 centers but radii"),
        (lambda: pack(as_shapes(Ball([0.0, 0.0], 1.0))), "dimension 2"),
    ],
)
def test_bad_input_is_refused_with_the_remedy(make, says):
    with pytest.raises(InputError, match=says):
        make()


def test_as_shapes_takes_what_people_have():
    ball, box = Ball([0, 0, 0], 1), Box([0, 0, 0], [1, 1, 1])
    assert as_shapes(ball) == (ball,) and as_shapes([ball, box]) == (ball, box) and as_shapes(None) == ()
    pair = as_shapes((np.array([[0.0, 0, 0], [1, 1, 1]]), 0.5))
    assert [b.radius for b in pair] == [0.5, 0.5] and pair[1].center.tolist() == [1, 1, 1]


def test_as_shapes_takes_entities():
    entities = pytest.importorskip("horosphere.entities")
    sphere = entities.Sphere.from_center_radius([1.0, 2.0, 3.0], 0.5)
    plane = entities.Plane.from_normal_distance([0.0, 0.0, 1.0], 0.25)
    ball, half = as_shapes([sphere, plane])
    np.testing.assert_allclose(ball.center, [1, 2, 3], atol=1e-14)
    assert ball.radius == pytest.approx(0.5, abs=1e-14)
    assert half.signed_distance([0.0, 0.0, 1.0]) == pytest.approx(0.75, abs=1e-14)
    assert len(as_shapes(entities.Sphere.from_center_radius(np.zeros((4, 3)), np.ones(4)))) == 4


def test_values_pickle_and_stay_read_only():
    box = Box([0, 0, 0], [1, 2, 3], name="crate")
    again = pickle.loads(pickle.dumps(box))
    assert again.name == "crate" and again.half_sizes.tolist() == [1, 2, 3]
    with pytest.raises(ValueError, match="read-only"):
        box.center[0] = 1.0


def test_public_names():
    names = {n for n in vars(shapes) if not n.startswith("_")}
    assert {
        "Ball",
        "Ellipsoid",
        "Capsule",
        "Cylinder",
        "Box",
        "HalfSpace",
        "Mesh",
        "PointCloud",
        "as_shapes",
        "pack",
    } <= names


def test_a_bounding_ball_that_is_kept_cannot_be_written():
    cloud = PointCloud(np.eye(3), 0.1)
    centre, radius = cloud.bounding_ball()
    with pytest.raises(ValueError, match="read-only"):
        centre[0] = 9.0
    assert cloud.bounding_ball()[0].tolist() == [0.5, 0.5, 0.5] and radius > 0.1
