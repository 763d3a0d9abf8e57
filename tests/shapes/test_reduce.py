"""Large clouds: what is reduced still holds every point, within the stated slack; the index finds what a search finds."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from horosphere.errors import InputError
from horosphere.shapes import Mesh, PointCloud, ball_tree, box_cover, few_balls, reduce_cloud


def room(m, seed):
    """Points on the walls of a room with noise, and far outliers."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1.0, 1.0, (m, 3))
    wall = rng.integers(0, 3, m)
    x[np.arange(m), wall] = np.sign(x[np.arange(m), wall])
    x += 0.003 * rng.normal(size=x.shape)
    x[:3] *= 4.0
    return x


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("voxel", [0.005, 0.05, 0.7])
def test_a_reduced_cloud_holds_the_points_within_its_slack(seed, voxel):
    x = room(4000, seed)
    radius = np.random.default_rng(seed).uniform(0.0, 0.01, len(x)) if seed % 2 else 0.004
    cloud, slack = reduce_cloud(PointCloud(x, radius), voxel)
    assert len(cloud.points) <= len(x) and slack <= 2.0 * np.sqrt(3.0) * voxel
    # every ball of the original lies in one of the new
    r = np.broadcast_to(radius, len(x))
    near = cKDTree(cloud.points).query_ball_point(x, cloud.radius.max() + 1e-9)
    for k in range(0, len(x), 7):
        gap = np.linalg.norm(cloud.points[near[k]] - x[k], axis=1) + r[k] - cloud.radius[near[k]]
        assert gap.min() <= 1e-12
    # no point of the new solid is further from the old one
    direction = np.random.default_rng(seed + 10).normal(size=(len(cloud.points), 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    skin = cloud.points + cloud.radius[:, None] * direction
    beyond = [(np.linalg.norm(x - p, axis=1) - r).min() for p in skin[::11]]
    assert max(beyond) <= slack + 1e-12


def test_a_fine_grid_changes_nothing():
    x = room(500, 0)
    cloud, slack = reduce_cloud(x, 1e-5, radius=0.01)
    assert slack == 0.0 and len(cloud.points) == 500
    assert np.array_equal(cloud.points[np.lexsort(cloud.points.T)], x[np.lexsort(x.T)])
    assert (cloud.radius == 0.01).all()


def nearest(tree, p):
    """Least distance to a ball, walking the tree."""
    best, stack, seen = np.inf, [0], 0
    inner = tree.leaves - 1
    while stack:
        i = stack.pop()
        seen += 1
        if np.linalg.norm(p - tree.nodes[i, :3]) - tree.nodes[i, 3] >= best:
            continue
        if i < inner:
            stack += sorted((2 * i + 1, 2 * i + 2), key=lambda n: -np.linalg.norm(p - tree.nodes[n, :3]))
            continue
        own = tree.balls[tree.first[i - inner] : tree.first[i - inner + 1]]
        best = min(best, (np.linalg.norm(p - own[:, :3], axis=1) - own[:, 3]).min())
    return best, seen


@pytest.mark.parametrize("m, seed", [(1, 0), (2, 1), (9, 2), (1000, 3), (3001, 4)])
def test_walking_the_tree_finds_the_nearest_ball(m, seed):
    rng = np.random.default_rng(seed)
    cloud = PointCloud(rng.normal(size=(m, 3)), rng.uniform(0.0, 0.1, m))
    tree = ball_tree(cloud)
    assert np.array_equal(np.sort(tree.order), np.arange(m))
    assert np.array_equal(tree.balls[:, :3], cloud.points[tree.order])
    assert np.diff(tree.first).max() <= 8 and len(tree.nodes) == 2 * tree.leaves - 1
    visited = []
    for p in rng.normal(size=(40, 3)) * 2.0:
        found, seen = nearest(tree, p)
        visited.append(seen)
        assert found == pytest.approx(cloud.signed_distance(p), abs=1e-12)
    assert m < 1000 or np.mean(visited) < 0.4 * len(tree.nodes)


def test_a_million_points():
    x = room(1_000_000, 0)
    cloud, slack = reduce_cloud(x, 0.02, radius=0.005)
    tree = ball_tree(cloud)
    assert len(tree.balls) == len(cloud.points) < 200_000 and slack < 2.0 * np.sqrt(3.0) * 0.02


@pytest.mark.parametrize("arguments, words", [
    ((np.zeros((0, 3)), 0.1), "at least one point"),
    ((np.zeros((2, 3)), 0.0), "voxel"),
    ((np.array([[0.0, 0, np.nan]]), 0.1), "finite|NaN"),
    ((np.array([[0.0, 0, 0], [1e3, 0, 0]]), 1e-6), "too many"),
])  # fmt: skip
def test_bad_clouds(arguments, words):
    with pytest.raises(InputError, match=words):
        reduce_cloud(*arguments)


def test_bad_leaf():
    with pytest.raises(InputError, match="leaf"):
        ball_tree(PointCloud(np.zeros((3, 3)), 0.1), leaf=1)


@pytest.mark.parametrize("most", [20, 400])
@pytest.mark.parametrize("kind", ["torus", "turned plate", "open"])
def test_boxes_hold_a_mesh_with_the_slack_stated(kind, most):
    rng = np.random.default_rng(most)
    source = trimesh.creation.torus(0.3, 0.1) if kind != "turned plate" else trimesh.creation.box([1.0, 0.6, 0.02])
    source.apply_transform(trimesh.transformations.random_rotation_matrix(rng.random(3)))
    faces = np.asarray(source.faces)[: -1 if kind == "open" else None]
    mesh = Mesh(np.asarray(source.vertices), faces)
    boxes, slack = box_cover(mesh, most)
    assert len(boxes) <= most
    x = rng.uniform(-0.6, 0.6, (20_000, 3))
    x = np.concatenate([x[mesh.signed_distance(x) <= 0.0], trimesh.sample.sample_surface(source, 2000, seed=1)[0]])
    if kind == "open":
        x = mesh.vertices[mesh.faces].mean(axis=1)
    assert np.min([box.signed_distance(x) for box in boxes], axis=0).max() < 1e-9
    for box in boxes:
        y = box.center + (rng.uniform(-1, 1, (50, 3)) * box.half_sizes) @ box.rotation.T
        assert mesh.signed_distance(y).max() <= slack
    assert box_cover(mesh, most) is box_cover(mesh, most)


@pytest.mark.parametrize("count", [50, 1001, 1500, 30_000])
def test_few_balls_hold_a_large_cloud(count):
    rng = np.random.default_rng(0)
    points, radii = rng.uniform(-1, 1, (count, 3)) * [1, 1, 0.01], rng.uniform(0.001, 0.003, count)
    points[0] = [100.0, 0.0, 0.0]  # a stray point far away must not cost the others their fineness
    centres, sizes = few_balls(PointCloud(points, radii), 1000)
    assert len(centres) <= 1000
    if count <= 1000:
        np.testing.assert_array_equal(centres, points)
    for k in range(0, count, 97):
        assert (np.linalg.norm(centres - points[k], axis=1) + radii[k] - sizes).min() < 1e-12
    assert sizes.max() < 0.08  # a plate of 4 square metres under 1000 balls
