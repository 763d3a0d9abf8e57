"""The camera of a report sees everything that moves or stands in the way, and not from too far."""

from types import SimpleNamespace

import numpy as np
import pytest

import horosphere.scenes as sc
from horosphere.viewer._recording import _camera, direction


@pytest.mark.parametrize("name", ["humanoid-reach", "panda-table", "rn-fig1-basic"])
@pytest.mark.parametrize("seed", range(5))
def test_everything_is_in_the_picture(name, seed):
    rng = np.random.default_rng(seed)
    scene = sc.Scene.load(name)
    up = np.array([0.0, 1.0, 0.0]) if name == "humanoid-reach" else np.array([0.0, 0.0, 1.0])
    points = 10.0 ** rng.uniform(-2, 2) * (rng.normal(size=(50, 3)) * rng.uniform(0.1, 1.0, 3) + rng.normal(size=3))
    if scene.dimension == 2:
        points[:, 2] = 0.0
    server = SimpleNamespace(initial_camera=SimpleNamespace())
    _camera(server, scene, up, direction(scene, up), points)
    camera = server.initial_camera
    back = np.subtract(camera.position, camera.look_at)
    back /= np.linalg.norm(back)
    right = np.cross(camera.up if scene.dimension == 3 else [0.0, 1.0, 0.0], back)
    right /= np.linalg.norm(right)
    local = (points - camera.position) @ np.stack([right, np.cross(back, right), -back]).T
    assert (local[:, 2] > 0).all()
    x, y = (np.abs(local[:, k] / local[:, 2] / np.tan(camera.fov / 2)) for k in range(2))
    assert y.max() < 1.0 and x.max() < 1.25  # inside, in a window of 5 : 4
    assert max(y.max(), x.max() / 1.25) > 0.7  # and not far away
