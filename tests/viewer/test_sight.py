"""The picture is taken from where the robot is seen, and what hides it everywhere is seen through."""

import numpy as np
import pytest

from horosphere import scenes, shapes
from horosphere.viewer._recording import direction
from horosphere.viewer._sight import HIDDEN, MOST_BLOCKS, _hidden, _triangles, blocks, look
from horosphere.viewer._solids import box, solid_of

UP = np.array([0.0, 0.0, 1.0])
VIEW = np.array([1.0, -0.8, 0.6]) / np.linalg.norm([1.0, -0.8, 0.6])


def wall(center, half):
    return box(center, half, np.eye(3))


@pytest.mark.parametrize("seed", range(5))
def test_what_hides_what(seed):
    """Against signed distances along the line of sight."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    solids = [
        shapes.Box(rng.normal(size=3), rng.uniform(0.2, 1.0, 3), turn * np.sign(np.linalg.det(turn))),
        shapes.Cylinder(rng.normal(size=3), rng.normal(size=3) + 2.0, 0.6),
        shapes.Ball(rng.normal(size=3), 0.8),
    ]
    points, view = 2.0 * rng.normal(size=(60, 3)), rng.normal(size=3)
    view /= np.linalg.norm(view)
    found = _hidden(view, points, {k: _triangles(solid_of(o, np.zeros(3), 1.0)) for k, o in enumerate(solids)})
    along = points[:, None] + np.linspace(0.0, 12.0, 4000)[:, None] * view
    for o, row in zip(solids, found):
        depth = o.signed_distance(along).min(axis=1)
        sure = np.abs(depth) > 0.03  # triangles are a little inside the round ones
        assert sure.sum() > 30
        np.testing.assert_array_equal(row[sure], depth[sure] < 0.0, err_msg=f"{o} seed {seed}")


def test_nothing_changes_where_the_robot_is_seen():
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (40, 3))
    view, glassy = look(VIEW, UP, points, {0: wall([-2, 0, 0], [0.1, 2, 2])})
    assert view is VIEW and not glassy


def test_a_wall_is_walked_round():
    points = np.random.default_rng(2).uniform(-0.5, 0.5, (40, 3))
    view, glassy = look(VIEW, UP, points, {0: wall([1, -0.8, 0.6], [0.9, 0.9, 0.9])})
    assert not glassy and view @ VIEW < 0.99 and abs(np.linalg.norm(view) - 1.0) < 1e-12
    hidden = _hidden(view, points, {0: _triangles(wall([1, -0.8, 0.6], [0.9, 0.9, 0.9]))})
    assert hidden.mean() <= HIDDEN


def test_a_cloud_is_walked_round_like_what_it_is_of():
    """A plate as points: hidden is what the plate hides, but for the width of a block at its rim."""
    rng = np.random.default_rng(5)
    points = rng.uniform(-0.5, 0.5, (40, 3))
    cloud = VIEW + rng.uniform(-1.0, 1.0, (20_000, 3)) * [0.01, 1.0, 1.0]
    vertices, faces = blocks(cloud)
    assert len(faces) % 12 == 0 and len(faces) <= 12 * MOST_BLOCKS
    assert (vertices.min(axis=0) <= cloud.min(axis=0)).all() and (vertices.max(axis=0) >= cloud.max(axis=0)).all()
    view, _ = look(VIEW, UP, points, {0: (vertices, faces)})
    assert view @ VIEW < 0.99
    plate = {0: _triangles(wall(VIEW, [0.01, 1.0, 1.0]))}
    assert _hidden(VIEW, points, plate).mean() > HIDDEN >= _hidden(view, points, plate).mean()
    assert len(blocks(np.ones((1, 3)))[1]) == 12


def test_a_room_is_made_of_glass():
    points = np.random.default_rng(3).uniform(-0.3, 0.3, (40, 3))
    sides = {k: (2.0 * np.eye(3)[k % 3] * (1 if k < 3 else -1), 2.0 - 1.9 * np.eye(3)[k % 3]) for k in range(6)}
    _, glassy = look(VIEW, UP, points, {k: wall(*side) for k, side in sides.items()})
    assert {0, 1, 3, 4} <= glassy and 5 not in glassy  # the floor hides nothing


def test_large_meshes_are_taken_for_their_boxes():
    vertices = np.random.default_rng(4).uniform(-1, 1, (3000, 3))
    faces = np.arange(12_000).reshape(-1, 3) % 3000
    assert len(_triangles((vertices, faces))) == 12


def test_built_in_scenes_keep_their_side():
    scene = scenes.Scene.load("humanoid-reach")
    view = direction(scene, np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(view, np.array([1.0, 0.45, 0.7]) / np.linalg.norm([1.0, 0.45, 0.7]))
