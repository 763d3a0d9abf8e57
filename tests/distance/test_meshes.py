"""Distances to meshes and large clouds against coal, trimesh, least squares over all triangles, and finite differences."""

import numpy as np
import pytest
import trimesh
from random_robots import random_robot, rotation
from scipy.optimize import lsq_linear
from scipy.spatial import ConvexHull, cKDTree
from test_signed_distance import capsule_distance

from horosphere import distance
from horosphere.shapes import Ball, Box, Mesh, PointCloud, pack


def mesh_of(source):
    return Mesh(np.asarray(source.vertices, float), np.asarray(source.faces, np.int64))


def hull(rng, count, size=0.3):
    found = ConvexHull(size * rng.normal(size=(count, 3)))
    source = trimesh.Trimesh(found.points, found.simplices)
    source.fix_normals()
    return source


def lumpy():
    """A closed shape that is not convex: a ring with a box through it would overlap, so a ring alone."""
    return trimesh.creation.torus(0.3, 0.1, major_sections=24, minor_sections=12)


def coal_shape(coal, source, convex):
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for p in source.vertices:
        points.append(np.asarray(p, float))
    for f in source.faces:
        triangles.append(coal.Triangle(*map(int, f)))
    if convex:
        return coal.Convex(points, triangles)
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(triangles), len(points))
    model.addSubModel(points, triangles)
    model.endModel()
    return model


def coal_distance(coal, a, b, radius, shape):
    z = b - a
    length = float(np.linalg.norm(z))
    z = z / length
    x = np.eye(3)[np.argmin(np.abs(z))]
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    at = coal.Transform3s(np.array([x, np.cross(z, x), z]).T, 0.5 * (a + b))
    request = coal.DistanceRequest()
    request.gjk_tolerance = request.epa_tolerance = 1e-13
    request.gjk_max_iterations = request.epa_max_iterations = 1000
    request.enable_signed_distance = True
    return coal.distance(
        coal.Capsule(radius, length), at, shape, coal.Transform3s.Identity(), request, coal.DistanceResult()
    )


@pytest.mark.parametrize("count", [4, 12, 60])
def test_convex_meshes_agree_with_coal(count):
    coal = pytest.importorskip("coal")
    rng = np.random.default_rng(count)
    inside = 0
    for _ in range(20):
        source = hull(rng, count)
        shape, mesh = coal_shape(coal, source, True), mesh_of(source)
        assert pack((mesh,)).rows[0, 9] == 2.0  # known to be convex
        for _ in range(10):
            a = 0.4 * rng.normal(size=3)
            b = a + 0.3 * rng.normal(size=3)
            d, wanted = float(capsule_distance(a, b, 0.05, mesh)), coal_distance(coal, a, b, 0.05, shape)
            inside += d < -0.05
            assert d == pytest.approx(wanted, abs=1e-9)
    assert inside > 5


def test_other_meshes_agree_with_coal_apart():
    coal = pytest.importorskip("coal")
    rng = np.random.default_rng(5)
    source = lumpy()
    shape, mesh = coal_shape(coal, source, False), mesh_of(source)
    seen = 0
    for _ in range(150):
        a = 0.4 * rng.normal(size=3)
        b = a + 0.3 * rng.normal(size=3)
        d = float(capsule_distance(a, b, 0.02, mesh))
        if d > 0.0:
            seen += 1
            assert d == pytest.approx(coal_distance(coal, a, b, 0.02, shape), abs=1e-9)
    assert seen > 50


def segment_to_triangle(a, b, triangle):
    """Independent of the closed form: bounded least squares over the segment and the triangle's two edges, then the third side."""
    p, e, f = triangle[0], triangle[1] - triangle[0], triangle[2] - triangle[0]
    best = np.inf
    found = lsq_linear(np.column_stack([b - a, -e, -f]), p - a, bounds=(0.0, 1.0), tol=1e-14)
    if found.x[1] + found.x[2] <= 1.0:
        best = float(np.linalg.norm(found.fun))
    side = triangle[2] - triangle[1]
    third = lsq_linear(np.column_stack([b - a, -side]), triangle[1] - a, bounds=(0.0, 1.0), tol=1e-14)
    return min(best, float(np.linalg.norm(third.fun)))


def test_apart_it_is_the_nearest_triangle():
    rng = np.random.default_rng(1)
    for _ in range(12):
        source = trimesh.creation.icosphere(1, 0.3)
        source.vertices *= rng.uniform(0.5, 1.3, (len(source.vertices), 1))  # spiky, no longer convex
        mesh = mesh_of(source)
        a = 0.7 * rng.normal(size=3)
        b = a + 0.3 * rng.normal(size=3)
        d = float(capsule_distance(a, b, 0.0, mesh))
        wanted = min(segment_to_triangle(a, b, t) for t in mesh.vertices[mesh.faces])
        if d > 0.0:
            assert d == pytest.approx(wanted, abs=1e-7)  # the solver's own tolerance
        else:
            assert wanted < 1e-6 or source.contains([0.5 * (a + b)])[0]


def test_points_agree_with_trimesh_inside_and_outside():
    rng = np.random.default_rng(2)
    source = lumpy()
    x = rng.uniform(-0.5, 0.5, (400, 3))
    _, near, _ = trimesh.proximity.ProximityQuery(source).on_surface(x)
    wanted = np.where(np.abs(np.array([winding(p, source.triangles) for p in x])) > 0.5, -near, near)
    assert np.abs(mesh_of(source).signed_distance(x) - wanted).max() < 1e-12
    assert (wanted < 0).sum() > 10


def winding(p, corners):
    a, b, c = (corners[:, i] - p for i in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    cosine = la * lb * lc + (a * b).sum(-1) * lc + (b * c).sum(-1) * la + (c * a).sum(-1) * lb
    return float(np.arctan2((a * np.cross(b, c)).sum(-1), cosine).sum() / (2.0 * np.pi))


def test_a_mesh_of_a_box_is_the_box():
    rng = np.random.default_rng(3)
    for _ in range(10):
        box = Box(0.1 * rng.normal(size=3), rng.uniform(0.05, 0.5, 3), rotation(rng))
        source = trimesh.creation.box(2.0 * box.half_sizes)
        mesh = Mesh(np.asarray(source.vertices) @ box.rotation.T + box.center, np.asarray(source.faces))
        for _ in range(20):
            a = 0.4 * rng.normal(size=3)
            b = a + 0.4 * rng.normal(size=3) * (rng.random() < 0.8)
            d, g = capsule_distance(a, b, 0.03, mesh, gradient=True)
            wanted, slope = capsule_distance(a, b, 0.03, box, gradient=True)
            assert float(d) == pytest.approx(float(wanted), abs=1e-12)
            assert np.linalg.norm(g) == pytest.approx(1.0)
            if abs(g @ slope - 1.0) > 1e-6:  # two ways out of one length
                assert float(d) < 0.0


def test_depth_in_a_ring_is_that_of_the_deepest_point():
    rng = np.random.default_rng(4)
    mesh, seen = mesh_of(lumpy()), 0
    for _ in range(60):
        angle = rng.uniform(0.0, 2.0 * np.pi)
        a = 0.3 * np.array([np.cos(angle), np.sin(angle), 0.0]) + 0.05 * rng.normal(size=3)
        b = a + 0.2 * rng.normal(size=3)
        along = mesh.signed_distance(a + np.linspace(0.0, 1.0, 4001)[:, None] * (b - a)).min()
        if along < 0.0:
            seen += 1
            d = float(capsule_distance(a, b, 0.01, mesh)) + 0.01
            assert along - 1e-4 < d < along + 1e-3
    assert seen > 20


def test_parts_cavities_and_wrong_windings():
    outer, inner = trimesh.creation.box([1.0, 1.0, 1.0]), trimesh.creation.box([0.6, 0.6, 0.6])
    inner.invert()
    hollow = mesh_of(trimesh.util.concatenate([outer, inner]))
    assert hollow.is_watertight
    np.testing.assert_allclose(
        hollow.signed_distance([[0, 0, 0], [0.4, 0, 0], [0.7, 0, 0]]), [0.3, -0.1, 0.2], atol=1e-12
    )
    assert float(capsule_distance(np.zeros(3), np.array([0.1, 0, 0]), 0.05, hollow)) == pytest.approx(0.15)
    outer.invert()
    assert mesh_of(outer).signed_distance([0.0, 0, 0]) == pytest.approx(-0.5)
    mixed = np.array(outer.faces)
    mixed[::2] = mixed[::2, ::-1]
    assert Mesh(outer.vertices, mixed).signed_distance([0.0, 0, 0]) == pytest.approx(-0.5)
    two = mesh_of(trimesh.util.concatenate([outer, outer.copy().apply_translation([0.75, 0, 0])]))
    assert two.signed_distance([0.3, 0.0, 0.0]) == pytest.approx(-0.2)  # in both: the depth in the first
    soup = Mesh(outer.triangles.reshape(-1, 3), np.arange(36).reshape(-1, 3))  # as an STL holds it: corners not shared
    assert soup.is_watertight and soup.signed_distance([0.0, 0, 0]) == pytest.approx(-0.5)


def crumpled(rng):
    """A ball whose corners were moved by more than its triangles are long: it folds over itself."""
    source = trimesh.creation.icosphere(3, 0.3)
    return trimesh.Trimesh(source.vertices + 0.05 * rng.normal(size=source.vertices.shape), source.faces, process=False)


def knotted(rng):
    """A tube along a curve that passes through itself: in the crossing its winding number is 2."""
    t = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    path = 0.3 * np.stack([np.sin(t), np.sin(t) * np.cos(t), 0.05 * np.sin(3.0 * t)], axis=1)
    along = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    across = np.cross(along, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across, axis=1)[:, None]
    angle = np.linspace(0.0, 2.0 * np.pi, 10, endpoint=False)[:, None]
    ring = np.cos(angle)[None] * across[:, None] + np.sin(angle)[None] * np.array([0.0, 0.0, 1.0])
    vertices = (path[:, None] + rng.uniform(0.03, 0.08) * ring).reshape(-1, 3)
    i, j = np.divmod(np.arange(600), 10)
    a, b, c, d = 10 * i + j, 10 * ((i + 1) % 60) + j, 10 * ((i + 1) % 60) + (j + 1) % 10, 10 * i + (j + 1) % 10
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return trimesh.Trimesh(vertices, faces, process=False)


def pinched(rng):
    """A ring, where two corners of one section were put at the same place: two fans of triangles meet there."""
    source = trimesh.creation.torus(0.3, 0.1, major_sections=8, minor_sections=6)
    vertices = np.array(source.vertices)
    section = np.flatnonzero((np.abs(vertices[:, 1]) < 1e-9) & (vertices[:, 0] > 0.0))
    low, high = section[np.argsort(vertices[section, 2])[[0, -1]]]
    vertices[high] = vertices[low]
    return trimesh.Trimesh(rng.uniform(0.5, 1.5) * vertices, source.faces, process=False)


@pytest.mark.parametrize("make", [crumpled, knotted, pinched])
@pytest.mark.parametrize("seed", range(3))
def test_inside_a_surface_that_crosses_itself_is_what_it_winds_round(make, seed):
    rng = np.random.default_rng(seed)
    source = make(rng)
    mesh = mesh_of(source)
    assert mesh.is_watertight and (pack((mesh,)).rows[:, 9] == 3.0).all()
    x = rng.uniform(*(1.2 * source.bounds), (1_000, 3))
    inside = np.abs([winding(p, source.triangles) for p in x]) > 0.5
    _, near, _ = trimesh.proximity.ProximityQuery(source).on_surface(x)
    signed = mesh.signed_distance(x)
    assert ((signed < 0.0) == inside).all() and np.abs(np.abs(signed) - near).max() < 1e-6  # trimesh's own tolerance
    assert 30 < inside.sum() < 970
    for a, b in zip(x[:40], x[40:80], strict=True):  # a segment is apart only where no point of it lies inside
        b = a + 0.2 * (b - a)
        points = a + np.linspace(0.0, 1.0, 200)[:, None] * (b - a)
        d = float(capsule_distance(a, b, 0.0, mesh))
        step = 0.5 * np.linalg.norm(b - a) / 199
        _, near, _ = trimesh.proximity.ProximityQuery(source).on_surface(points)
        if any(abs(winding(p, source.triangles)) > 0.5 for p in points):
            assert d <= 0.0
        elif d > 0.0:
            assert near.min() - step - 1e-12 < d < near.min() + 1e-12
        else:
            assert near.min() <= step


def test_a_folded_surface_says_nothing_of_points_far_away():
    """A fan of slivers with dents larger than the slivers are wide; seen from afar its normals point anywhere."""
    rng = np.random.default_rng(5)
    source = trimesh.creation.cylinder(0.05, 0.2, sections=48).subdivide().subdivide().subdivide()
    source.merge_vertices()
    source = trimesh.Trimesh(
        source.vertices + 5e-4 * rng.normal(size=source.vertices.shape), source.faces, process=False
    )
    x = rng.normal(size=(2_000, 3))
    x *= rng.uniform(0.13, 1.0, (2_000, 1)) / np.linalg.norm(x, axis=1)[:, None]
    assert (mesh_of(source).signed_distance(x) > 0.0).all()


def test_an_open_mesh_is_a_surface():
    source = trimesh.creation.box([1.0, 1.0, 1.0])
    sheet = Mesh(source.vertices, source.faces[:-1])
    assert not sheet.is_watertight and len(sheet.open_edges()) == 3
    assert sheet.signed_distance([0.1, 0.0, 0.0]) > 0.0
    through = source.triangles[0].mean(axis=0)
    assert float(capsule_distance(1.2 * through, 0.5 * through, 0.05, sheet)) == pytest.approx(-0.05)


@pytest.mark.parametrize("seed", range(4))
def test_gradients_by_finite_differences(seed):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng)
    solids = [
        mesh_of(lumpy().apply_transform(trimesh.transformations.translation_matrix(0.5 * rng.normal(size=3)))),
        mesh_of(hull(rng, 20).apply_translation(0.5 * rng.normal(size=3))),
        PointCloud(0.5 * rng.normal(size=(300, 3)), rng.uniform(0.0, 0.03, 300)),
    ]
    for solid in solids:
        q = rng.uniform(-1.0, 1.0, (8, robot.n_joints))
        _, g = distance.signed(robot, q, [solid], gradient=True)
        step, missed = 1e-6, 0
        for k in range(robot.n_joints):
            e = step * np.eye(robot.n_joints)[k]
            plus, minus = (distance.signed(robot, q + s * e, [solid]) for s in (1, -1))
            missed += (np.abs((plus - minus) / (2.0 * step) - g[:, k]) > 1e-5).sum()
        assert missed <= 2  # kinks, where two features are equally near


@pytest.mark.parametrize("seed", range(3))
def test_a_tree_gives_what_single_rows_give(seed):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng)
    cloud = PointCloud(rng.normal(size=(500, 3)), rng.uniform(0.0, 0.1, 500))
    q = rng.uniform(-1.0, 1.0, (20, robot.n_joints))
    balls = [Ball(p, float(r)) for p, r in zip(cloud.points, cloud.radius)]
    many = [
        cloud,
        mesh_of(hull(rng, 10)),
        mesh_of(lumpy()),
        PointCloud(rng.normal(size=(100, 3)), 0.01),
        Box([1, 0, 0], [0.1] * 3),
    ]
    np.testing.assert_allclose(distance.signed(robot, q, cloud), distance.signed(robot, q, balls), atol=1e-14)
    alone = np.min([distance.signed(robot, q, [one]) for one in many], axis=0)
    np.testing.assert_allclose(distance.signed(robot, q, many), alone, atol=1e-14)
    table = distance.table(robot, q, many)
    assert table.distance.shape == (20, len(robot.capsules), 5)
    np.testing.assert_allclose(table.distance.min(axis=(1, 2)), alone, atol=1e-14)


def test_a_million_points():
    rng = np.random.default_rng(0)
    x = rng.uniform(-1.0, 1.0, (1_000_000, 3))
    robot = random_robot(rng)
    cloud = PointCloud(x, 0.005)
    found = float(distance.signed(robot, np.zeros(robot.n_joints), [cloud]))
    few = [PointCloud(x[k::10], 0.005) for k in range(10)]
    assert found == pytest.approx(
        min(float(distance.signed(robot, np.zeros(robot.n_joints), [c])) for c in few), abs=1e-14
    )
    p = rng.uniform(-1.0, 1.0, (200, 3))
    np.testing.assert_allclose(cloud.signed_distance(p), cKDTree(x).query(p)[0] - 0.005, atol=1e-12)
