"""Every obstacle a user may bring, checked with the exact distances of horosphere.shapes as witness."""

import numpy as np
import pytest

from horosphere import maps, shapes
from horosphere.entities import Plane, Sphere
from horosphere.errors import InputError
from horosphere.fields import HarmonicField


def rotation(seed):
    q = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


def tetrahedron():
    vertices = np.array([[0, 0, 0], [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]) + [2.0, 2.2, -0.4]
    return shapes.Mesh(vertices, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]), name="wedge")


def all_kinds():
    rng = np.random.default_rng(0)
    return [
        shapes.Ball([2.0, 0.0, 0.3], 0.5, name="ball"),
        shapes.Box([4.0, 0.5, 0.5], [0.4, 0.7, 0.2], rotation(1), name="box"),
        shapes.Cylinder([1.0, -1.6, -0.5], [1.4, -1.2, 0.8], 0.3, name="can"),
        shapes.Capsule([3.0, -1.5, 0.0], [4.2, -1.2, 0.6], 0.25, name="rod"),
        shapes.Ellipsoid([2.6, 0.8, 1.6], [0.7, 0.2, 0.4], rotation(2), name="egg"),
        tetrahedron(),
        shapes.PointCloud(rng.normal(0, 0.15, (40, 3)) + [1.0, 1.4, 0.4], 0.05, name="cloud"),
        shapes.HalfSpace([0, 0, 1.0], -1.5, name="floor"),
    ]


@pytest.mark.parametrize("margin", [0.0, 0.06])
def test_all_kinds_at_once(margin):
    obstacles = all_kinds()
    field = HarmonicField([-0.5, 0.2, 0.1], obstacles, margin=margin)
    assert field.certificate().granted, str(field.certificate())
    assert any("box" in note for note in field.notes)
    rng = np.random.default_rng(3)
    for _ in range(12):
        start = np.array([6.0, 0.0, 0.4]) + rng.uniform(-1, 1, 3) * [0.5, 2.0, 1.2]
        path = field.trace(start, step=rng.choice([0.05, 0.5]))
        dense = np.concatenate([path.points[:-1] + t * np.diff(path.points, axis=0) for t in np.linspace(0, 1, 5)])
        assert path.reached
        for shape in obstacles:
            assert shape.signed_distance(dense).min() > margin - 1e-9, shape.name


def test_entities_are_obstacles():
    sphere = Sphere.from_center_radius([[2.0, 0, 0], [0.0, 2.0, 0]], [0.5, 0.4])
    plane = Plane.from_normal_distance([0, 0, 1.0], -1.0)
    field = HarmonicField([-1, 0, 0], [sphere, plane])
    assert field.names == ("obstacle 0[0]", "obstacle 0[1]", "obstacle 1")
    path = field.trace([4, 0.1, -0.9])
    assert path.reached and path.points[:, 2].min() >= -1.0
    assert field.trace([4, 0, -1.2]).reason.startswith("start outside the workspace")


def test_planar_kinds_together():
    """An aerofoil is alone conformal; in company it becomes a star and the whole stays certified."""
    foil = maps.Joukowski.aerofoil(0.5, -0.06 + 0.05j, [0.0, 0.0], 0.3, name="foil")
    others = [maps.lobed([2.5, 0.8], 0.5, 0.3, 5), maps.ellipsoid([2.3, -1.2], [0.9, 0.15])]
    field = HarmonicField([-2.5, 0.3], [foil, *others, *[]])
    assert field.certificate().granted and any("foil" in note for note in field.notes)
    rng = np.random.default_rng(0)
    for _ in range(8):
        path = field.trace([4.5, rng.uniform(-1.5, 1.5)])
        dense = np.concatenate([path.points[:-1] + t * np.diff(path.points, axis=0) for t in np.linspace(0, 1, 5)])
        assert path.reached and not foil.contains(dense).any()
        assert min(star.level(dense).min() for star in others) > 0.0


def test_user_functions_in_four_dimensions():
    def radius(u):
        return 0.6 + 0.2 * u[:, 0] ** 2 + 0.1 * u[:, 1] * u[:, 2]

    field = HarmonicField(np.zeros(4), [maps.star([2.0, 0, 0, 0], radius, name="mine")])
    path = field.trace([4.5, 0.1, 0.0, -0.1], step=0.1)
    assert path.reached and field.stars[0].level(path.points).min() > 0.0
    np.testing.assert_allclose(np.linalg.norm(field([[4, 1, 0, 0], [2.8, 0.3, 0, 0]]), axis=1), 1.0)


def test_overlapping_shapes_are_merged_about_a_common_point():
    parts = [maps.ellipsoid([2.0, 0.0], [1.0, 0.2]), maps.ellipsoid([2.1, 0.1], [0.2, 1.0])]
    field = HarmonicField([-1.0, 0.0], parts)
    assert len(field.stars) == 1 and "merged" in field.notes[0]
    path = field.trace([4.5, 0.05])
    assert path.reached and min(p.level(path.points).min() for p in parts) > 0.0


def test_step_is_bounded_and_safe_beside_stars():
    field = HarmonicField([0.0, 0.0], [maps.ellipsoid([2.0, 0.0], [0.2, 1.5])])
    x = np.array([4.0, 0.1])
    for _ in range(400):
        y = field.step(x, 0.05)
        assert np.linalg.norm(y - x) <= 0.05 * (1 + 1e-9) and field.stars[0].level(y) > 0.0
        x = y
        if np.linalg.norm(x) < 1e-6:
            break
    assert np.linalg.norm(x) < 1e-6


@pytest.mark.parametrize(
    ("obstacles", "goal", "words"),
    [
        (
            lambda: [shapes.Mesh(tetrahedron().vertices, tetrahedron().faces[:3], name="open")],
            [0, 0, 0],
            "open.*not watertight",
        ),
        (lambda: [shapes.Box([0, 0, 0], [1, 1, 1], np.eye(3), name="crate")], [0.5, 0, 0], "inside crate"),
        (lambda: [shapes.HalfSpace([0, 0, 1.0], 0.0, name="floor")], [0, 0, -0.1], "100 mm beyond floor"),
        (lambda: [shapes.Ball([1.0, 2.0], 0.5)], [0, 0, 0], r"lies in R\^2"),
        (lambda: [maps.lobed([1, 0], 0.3, 0.2, 5)], [0, 0, 0], r"lies in R\^2"),
        (lambda: [maps.ellipsoid([1, 0], [1.0, 0.3])], [0.2, 0], "inside obstacle 0"),
    ],
)
def test_bad_input(obstacles, goal, words):
    with pytest.raises(InputError, match=words):
        HarmonicField(goal, obstacles())


def test_an_ellipse_alone_in_the_plane_is_mapped_conformally():
    """As [Humanoid] Fig. 6 (a), (b) say; with a neighbour it is a star among stars."""
    from horosphere.scenes import EllipsoidND

    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    shape = EllipsoidND(np.zeros(2), np.array([2.0, 0.5]), turn, name="wing")
    alone = HarmonicField([-3.0, 0.6], [shape], margin=0.1)
    joukowski = HarmonicField([-3.0, 0.6], [maps.Joukowski.ellipse(2.0, 0.5, angle=0.7)], margin=0.1)
    x = np.random.default_rng(0).uniform(-4, 4, (200, 2))
    free = np.asarray(alone.clearance(x)) > 0.0
    assert not alone.stars and alone.names == ("wing",)
    np.testing.assert_allclose(alone(x[free]), joukowski(x[free]), atol=1e-12)
    # the zone holds the ellipse and the margin around it
    angle = np.linspace(0, 2 * np.pi, 500)
    edge = np.stack([2.0 * np.cos(angle), 0.5 * np.sin(angle)], axis=-1)
    normal = np.stack([np.cos(angle) / 2.0, np.sin(angle) / 0.5], axis=-1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert alone.clearance((edge + 0.1 * normal) @ turn.T).max() <= 1e-4
    two = HarmonicField([-3.0, 0.6], [shape, maps.ellipsoid([4, 4], [0.5, 0.2])], margin=0.1)
    assert len(two.stars) == 2 and two.trace([4.0, -0.2]).reached


def test_a_star_and_a_ball_about_a_common_kernel_point_are_joined():
    """The ball reaches into the lobed star's kernel: seen whole from there; elsewhere the hull stands for both."""
    five = maps.lobed([0, 0], 1.0, 0.3, 5)
    ball = np.array([0.25, 0.1]), 1.2
    (joined,) = HarmonicField([-4.0, 0.0], [five, maps.RoundHull(ball[0], np.zeros(2), ball[1], ball[1])]).stars
    assert isinstance(joined, maps.UnionStar) and joined.proven and joined.slack < 0.1
    u = _unit(np.random.default_rng(0).standard_normal((2000, 2)))
    assert joined.level(five.center + five.radial(u)[0][:, None] * u).max() <= 1e-9
    assert joined.level(ball[0] + ball[1] * u).max() <= 1e-9
    far = HarmonicField([-4.0, 0.0], [five, maps.lobed([1.4, 0.1], 0.8, 0.2, 3)])
    (hull,) = far.stars
    assert isinstance(hull, maps.PolytopeStar) and "beyond them" in far.notes[0]
    assert hull.level(five.center + five.radial(u)[0][:, None] * u).max() <= 1e-9


def test_conformal_points_as_goal_start_and_place():
    import horosphere as hs

    point = hs.Point.from_euclidean
    field = HarmonicField(point([0.0, 0.0, 0.0]), [hs.Sphere.from_center_radius([2.0, 0.0, 0.0], 0.5)])
    np.testing.assert_array_equal(field(point([4.0, 0.1, 0.0])), field([4.0, 0.1, 0.0]))
    path = field.trace(point([4.0, 0.1, 0.0]))
    assert path.reached
    np.testing.assert_allclose(path.as_points().as_euclidean(), path.points, atol=1e-12)


def _unit(x):
    return x / np.linalg.norm(x, axis=1, keepdims=True)
