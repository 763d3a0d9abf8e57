"""Distances in float64 against exact arithmetic: never above the truth, nor below it, by more than docs/certificate.md says."""

from decimal import Decimal

import numpy as np
import pytest
from exact_distances import exact, norm, segment_to_segment, segment_to_solid, segment_to_triangle
from random_robots import rotation, unit

from horosphere.distance._pack import pack_robot
from horosphere.distance._pair_kernels import segment_distance
from horosphere.kernels import jit
from horosphere.numeric import nearest_rotation
from horosphere.robots import Capsules, Limits, Link, Robot
from horosphere.robots._placement import from_quaternion_translation
from horosphere.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, PointCloud, ellipsoid_signed_distance
from horosphere.shapes._pack import pack
from horosphere.shapes._shells import unit_normals

U = 2.0**-53
PROVED = 40.0
"""Times u (|a| + |u| + |centre| + bounding radius): no result may lie above the truth by more."""
SHORT = 16.0
"""The same for how far a result lies below: the search, which is not proved to find the best plane."""


@jit
def _distance(S, a, u, out):
    out[0], out[1], out[2], out[3], out[4] = segment_distance(S, 0, a[0], a[1], a[2], u[0], u[1], u[2], 1, None)


@jit
def _tree_distance(S, a, u, out, forest):
    out[0], out[1], out[2], out[3], out[4] = segment_distance(S, 0, a[0], a[1], a[2], u[0], u[1], u[2], 1, forest)


def computed(solid, a, u):
    rows, out = pack((solid,)).rows, np.empty(5)
    _distance(rows, a, u, out)
    size = sum(np.linalg.norm(x) for x in (a, u, rows[0, 1:4])) + rows[0, 4]
    return out, float(size)


def hard_solid(rng, kind, scale):
    """Sizes from 1e-6 of the scale to all of it, up to 10 km from the origin, along the axes or turned."""
    extent = scale * 10.0 ** rng.uniform(-6 if rng.random() < 0.5 else -1, 0, 3)
    center = rng.choice([0.0, 0.0, 1.0, 1e4]) * rng.normal(size=3)
    R = rotation(rng) if rng.random() < 0.6 else np.eye(3)
    if kind == "cylinder":
        extent[1] = extent[0]
        return Cylinder(center - extent[2] * R[:, 2], center + extent[2] * R[:, 2], extent[0]), center, R, extent
    return (Box if kind == "box" else Ellipsoid)(center, extent, R), center, R, extent


def hard_segment(rng, center, R, extent, scale):
    """Near the surface or at random; a point, nearly along an axis of the solid, of its size, or of any length."""
    middle = center + R @ (rng.normal(size=3) * extent * rng.uniform(0.5, 3))
    if rng.random() < 0.4:
        middle = center + scale * rng.normal(size=3)
    u = scale * 10.0 ** rng.uniform(-3, 0.5) * rng.normal(size=3)
    case = rng.integers(5)
    if case == 0:
        u = np.zeros(3)
    elif case == 1:
        u = scale * (R[:, rng.integers(3)] + 10.0 ** rng.uniform(-14, -3) * rng.normal(size=3))
    elif case == 2:
        u = 2.0 * R @ (extent * rng.normal(size=3))
    return middle - rng.uniform() * u, u


def check(seed, kind):
    rng = np.random.default_rng([seed, len(kind)])
    scale = 10.0 ** rng.uniform(-3, 3)
    solid, center, R, extent = hard_solid(rng, kind, scale)
    a, u = hard_segment(rng, center, R, extent, scale)
    out, size = computed(solid, a, u)
    if out[0] > 0.0 and rng.random() < 0.5:  # all but touching
        a = a - out[2:] * (out[0] - scale * 10.0 ** rng.uniform(-14, -2))
        out, size = computed(solid, a, u)
    if out[0] <= 0.0 and kind != "ellipsoid":  # the shortest way out, another quantity: below the depth of every point
        assert segment_to_solid(solid, a, u) >= Decimal(out[0] - PROVED * U * size), f"seed {seed}"
        return
    error = float(Decimal(float(out[0])) - segment_to_solid(solid, a, u)) / (U * size)
    assert -SHORT <= error <= PROVED, f"seed {seed}: {error} units"


@pytest.mark.parametrize("kind", ["box", "cylinder", "ellipsoid"])
def test_convex_solids_against_60_digits(kind):
    for seed in range(40):
        check(seed, kind)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["box", "cylinder", "ellipsoid"])
@pytest.mark.parametrize("first", range(40, 2040, 100))
def test_convex_solids_against_60_digits_many(first, kind):
    for seed in range(first, first + 100):
        check(seed, kind)


def test_any_normal_proves_a_bound():
    """The lemma itself: planes with random normals never prove more than the distance, near and within the solid."""
    rng = np.random.default_rng(5)
    for kind in ("box", "cylinder", "ellipsoid"):
        for _ in range(20):
            solid, center, R, extent = hard_solid(rng, kind, 1.0)
            a, u = hard_segment(rng, center, R, extent, 1.0)
            n = rng.normal(size=(1000, 3))
            n /= np.linalg.norm(n, axis=1, keepdims=True)
            local = n @ R
            if kind == "box":
                h = np.abs(local) @ extent
            elif kind == "ellipsoid":
                h = np.linalg.norm(local * extent, axis=1)
            else:
                h = extent[0] * np.hypot(local[:, 0], local[:, 1]) + extent[2] * np.abs(local[:, 2])
            proved = np.minimum(n @ (a - center), n @ (a + u - center)) - h
            out, size = computed(solid, a, u)
            assert proved.max() <= out[0] + 60 * U * size


def test_two_segments_against_rationals():
    """At all angles down to 1e-16, all gaps down to none, 10 km away, of lengths four orders apart."""
    rng = np.random.default_rng(6)
    for trial in range(2000):
        scale, R = 10.0 ** rng.uniform(-3, 3), rotation(rng)
        angle, lengths = 10.0 ** rng.uniform(-16, 0), scale * 10.0 ** rng.uniform(-4, 0, 2)
        gap = scale * 10.0 ** rng.uniform(-14, 0) if rng.random() < 0.8 else 0.0
        u, v = lengths[0] * R[:, 0], lengths[1] * (np.cos(angle) * R[:, 0] + np.sin(angle) * R[:, 1])
        if rng.random() < 0.05:
            u = np.zeros(3)
        crossing = rng.choice([0.0, 1.0, 1e4]) * rng.normal(size=3)
        a = crossing - rng.choice([0.0, 1.0, 0.5, rng.uniform(-0.5, 1.5)]) * u
        b = crossing + gap * R[:, 2] - rng.choice([0.0, 1.0, 0.5, rng.uniform(-0.5, 1.5)]) * v
        other = Capsule(b, b + v, 0.0)
        out, _ = computed(other, a, u)
        size = sum(np.linalg.norm(x) for x in (a, u, b, v))
        error = float(Decimal(float(out[0])) - segment_to_segment(a, u, b, other.b - other.a)) / (U * size)
        assert abs(error) <= (PROVED if error > 0 else SHORT), f"trial {trial}: {error} units"


@pytest.mark.parametrize(
    "axes", [(1.0, 1.0, 1e-6), (1e3, 1.0, 1e-3), (1.0, 1.0, 1.0), (0.3, 0.2), (2.0, 1.0, 0.5, 0.5)]
)
def test_points_and_ellipsoids_of_any_dimension(axes):
    e = np.array(axes)
    rng = np.random.default_rng(len(axes))
    p = rng.normal(size=(60, len(e))) * np.concatenate([e * np.ones((30, 1)), np.full((30, len(e)), e.max())])
    p[rng.random(p.shape) < 0.2] = 0.0  # also on the planes of symmetry
    d = ellipsoid_signed_distance(p, e)
    for x, value in zip(p, d):
        if len(e) == 3:
            error = float(Decimal(float(value)) - segment_to_solid(Ellipsoid(np.zeros(3), e), x, np.zeros(3)))
            assert abs(error) <= 16 * U * (np.linalg.norm(x) + e.max())
        n = rng.normal(size=(500, len(e)))
        n /= np.linalg.norm(n, axis=1, keepdims=True)
        assert (n @ x - np.linalg.norm(n * e, axis=1)).max() <= value + 30 * U * (np.linalg.norm(x) + e.max())


def test_triangles_against_rationals():
    """Of every shape down to slivers of 1e-12, up to 10 km away: no result lies above the truth by more than 60 units."""
    rng = np.random.default_rng(12)
    for trial in range(250):
        scale, R, thin = 10.0 ** rng.uniform(-3, 3), rotation(rng), 10.0 ** rng.uniform(-12, 0)
        flat = scale * np.array([[0.0, 0, 0], [1.0, 0, 0], [rng.uniform(-0.5, 1.5), thin, 0]])
        corners = rng.choice([0.0, 1.0, 1e4]) * rng.normal(size=3) + flat @ R.T
        middle = rng.dirichlet(np.ones(3)) @ corners + scale * 10.0 ** rng.uniform(-9, 1) * rng.normal(size=3)
        u = np.zeros(3) if trial % 5 == 0 else scale * 10.0 ** rng.uniform(-3, 1) * rng.normal(size=3)
        a = middle - rng.uniform() * u
        packed = pack((Mesh(corners, np.array([[0, 1, 2]])),))
        out = np.empty(5)
        _tree_distance(packed.rows, a, u, out, packed.forest)
        size = np.linalg.norm(a) + np.linalg.norm(u) + np.linalg.norm(packed.rows[0, 1:4]) + packed.rows[0, 4]
        error = float(Decimal(float(out[0])) - segment_to_triangle(a, u, corners)) / (U * size)
        assert -SHORT - 1e-13 / (U * size) <= error <= 60.0, f"trial {trial}: {error} units"


def test_clouds_against_rationals():
    rng = np.random.default_rng(13)
    for trial in range(40):
        scale, far = 10.0 ** rng.uniform(-3, 3), rng.choice([0.0, 1.0, 1e4]) * rng.normal(size=3)
        points, radii = far + scale * rng.normal(size=(80, 3)), scale * rng.uniform(0, 0.1, 80)
        u = np.zeros(3) if trial % 5 == 0 else scale * rng.normal(size=3)
        a = far + scale * rng.uniform(1, 5) * rng.normal(size=3)
        packed, out = pack((PointCloud(points, radii),)), np.empty(5)
        _tree_distance(packed.rows, a, u, out, packed.forest)
        size = np.linalg.norm(a) + np.linalg.norm(u) + np.linalg.norm(packed.rows[0, 1:4]) + packed.rows[0, 4]
        true = min(segment_to_segment(a, u, p, np.zeros(3)) - Decimal(float(r)) for p, r in zip(points, radii))
        assert abs(float(Decimal(float(out[0])) - true)) <= 12 * U * size, f"trial {trial}"


@pytest.mark.parametrize("thin", [1e-3, 1e-8, 1e-13])
def test_the_normal_of_a_sliver_is_right_to_rounding(thin):
    """A triangle a thousandth to next to nothing wide: in float64 alone its normal would be off by 1e-16 / thin."""
    rng = np.random.default_rng(8)
    corners = rng.normal(size=(60, 1, 3)) + np.array(
        [np.array([[0.0, 0, 0], [1.0, 0, 0], [0.4, thin, 0]]) @ rotation(rng).T for _ in range(60)]
    )
    for normal, (a, b, c) in zip(unit_normals(corners), [[exact(x) for x in corner] for corner in corners]):
        u, v = [y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)]
        n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        length = norm(n)
        assert max(abs(float(x / length) - y) for x, y in zip(n, normal)) < 4 * U


@pytest.mark.parametrize("thin", [1e-13, 1e-20, 0.0])
def test_a_sliver_is_as_far_as_its_edges(thin):
    rng = np.random.default_rng(9)
    for _ in range(40):
        R, at = rotation(rng), np.zeros(3) if thin == 1e-20 else rng.normal(size=3)
        corners = at + np.array([[0.0, 0, 0], [1.0, 0, 0], [0.4, thin, 0]]) @ R.T
        a = at + 2.0 * rng.normal(size=3)
        d = float(Mesh(corners, np.array([[0, 1, 2]])).signed_distance(a))
        edges = min(
            float(segment_to_segment(a, np.zeros(3), corners[i], corners[j] - corners[i]))
            for i, j in ((0, 1), (1, 2), (2, 0))
        )
        assert d == pytest.approx(edges, abs=2e-13)


def test_a_flat_triangle_in_a_closed_mesh_changes_nothing():
    """A corner of one face in the middle of the side of another, the gap closed by a triangle without area."""
    rng = np.random.default_rng(10)
    for _ in range(20):
        v = rng.normal(size=(4, 3)) * [1.0, 1.0, 0.2]  # sharp edges
        v = np.vstack([v, v[0] + 0.5 * (v[1] - v[0])])
        whole = Mesh(v, np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]))
        split = Mesh(v, np.array([[0, 4, 2], [4, 1, 2], [0, 1, 4], [0, 3, 1], [1, 3, 2], [2, 3, 0]]))
        x = rng.normal(size=(200, 3)) * [1.0, 1.0, 0.3]
        np.testing.assert_allclose(split.signed_distance(x), whole.signed_distance(x), atol=1e-14)
        assert (split.signed_distance(v.mean(axis=0, keepdims=True)) < 0.0).all()


def test_what_is_nearly_a_rotation_is_made_one():
    """Nine digits, as files have them: distances in a frame that stretches would be off in the ninth digit too."""
    rng = np.random.default_rng(11)
    for n in (2, 3, 5):
        Q = np.linalg.qr(rng.normal(size=(n, n)))[0]
        near = Q + 3e-10 * rng.normal(size=(n, n))
        R = nearest_rotation(near)
        assert np.abs(R.T @ R - np.eye(n)).max() < 1e-15 and np.abs(R - near).max() < 2e-9
    R = np.round(rotation(rng), 9)
    assert np.abs(R @ R.T - np.eye(3)).max() > 1e-12
    box = Box([0, 0, 0], [0.1, 0.2, 0.3], R)
    assert np.abs(box.rotation.T @ box.rotation - np.eye(3)).max() < 1e-15
    motor = from_quaternion_translation((1 + 1e-10) * unit(rng, 4), rng.normal(size=3))
    links = (Link("base", -1, [1.0, 0, 0, 0, 0, 0, 0, 0]), Link("turning", 0, motor, "revolute", [0, 0, 1.0], 0))
    robot = Robot("r", links, 1, ("q",), Limits.unlimited(1), capsules=Capsules([1], [[0, 0, 0]], [[1, 0, 0]], [0.1]))
    C = pack_robot(robot).constants[1, :9].reshape(3, 3)
    assert np.abs(C.T @ C - np.eye(3)).max() < 2e-15
