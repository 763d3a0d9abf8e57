"""Triangles that are drawn are those of the solids: volumes and distances against formulas of their own."""

import numpy as np
import pytest
import trimesh

from horosphere import shapes
from horosphere.scenes import Aerofoil, EllipsoidND, Star
from horosphere.viewer._solids import outline_of, solid_of

ROTATION = np.array([[0.0, -1.0, 0.0], [0.6, 0.0, -0.8], [0.8, 0.0, 0.6]])
ROTATION = ROTATION if np.linalg.det(ROTATION) > 0 else ROTATION * [1, 1, -1]
PI = np.pi
CASES = [
    (shapes.Ball([1, 2, 3], 0.5), 4 / 3 * PI * 0.125),
    (shapes.Capsule([1, 0, 0], [1, 2, 0.5], 0.3), PI * 0.09 * np.hypot(2, 0.5) + 4 / 3 * PI * 0.027),
    (shapes.Cylinder([1, 0, 0], [1, 2, 0.5], 0.3), PI * 0.09 * np.hypot(2, 0.5)),
    (shapes.Box([1, 1, 1], [0.1, 0.2, 0.3], ROTATION), 0.048),
    (shapes.Ellipsoid([0, 0, 1], [0.1, 0.2, 0.3], ROTATION), 4 / 3 * PI * 0.006),
]


@pytest.mark.parametrize(("shape", "volume"), CASES, ids=[type(c[0]).__name__ for c in CASES])
def test_solids(shape, volume):
    vertices, faces = solid_of(shape, np.zeros(3), 1.0)
    mesh = trimesh.Trimesh(vertices, faces)  # merges the doubled corners
    assert mesh.is_watertight and mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(volume, rel=0.03)  # positive: faces look outwards
    assert np.abs(shape.signed_distance(vertices)).max() < 1e-9  # corners lie on the surface


def test_half_space_is_a_plate_below_its_plane():
    vertices, _ = solid_of(shapes.HalfSpace([0, 0, 1], 0.3), np.array([5.0, 5, 5]), 2.0)
    assert vertices[:, 2].max() == pytest.approx(0.3) and vertices[:, 2].min() < 0.3
    np.testing.assert_allclose(vertices[:, :2].mean(axis=0), [5, 5])


def test_plane_figures():
    ellipse = EllipsoidND([1, 2], [0.5, 0.2], np.array([[0.6, -0.8], [0.8, 0.6]]))
    star = Star([1, 2], 0.4, 6, 0.3, 0.1)
    wing = Aerofoil([0, 0], 0.3, -0.03 + 0.02j)
    for figure, area in ((ellipse, PI * 0.1), (star, PI * 0.16 * (1 + 0.045)), (shapes.Ball([0, 0], 0.5), PI * 0.25)):
        x, y = outline_of(figure, 2000).T
        assert 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) == pytest.approx(area, rel=1e-4)
    local = (outline_of(ellipse) - ellipse.center) @ ellipse.rotation / ellipse.semi_axes
    np.testing.assert_allclose(np.linalg.norm(local, axis=1), 1)
    tail = outline_of(wing, 4000)
    assert tail[:, 0].max() == pytest.approx(0.6, abs=1e-4)  # the trailing edge of P + k^2/P is at 2k
    vertices, faces = solid_of(star, np.zeros(3), 1.0)
    assert trimesh.Trimesh(vertices, faces).is_watertight
