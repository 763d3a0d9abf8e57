"""The shell map: inverse, Jacobian, boundary to ball, identity outside, in several dimensions."""

import numpy as np
import pytest

from horosphere import maps
from horosphere.errors import InputError


def rotation(n, seed):
    return np.linalg.qr(np.random.default_rng(seed).standard_normal((n, n)))[0]


def example(n):
    if n == 2:
        return [maps.ellipsoid([0, 0], [1.0, 0.1], rotation(2, 0)), maps.lobed([3, 0], 1.0, 0.4, 5)], [0.3, 0.4]
    a = np.linspace(0.3, 1.0, n)
    return [maps.ellipsoid(np.zeros(n), a, rotation(n, 1)), maps.superquadric(np.eye(n)[0] * 4, a, 5.0)], [0.2, 1.0]


@pytest.mark.parametrize("n", [2, 3, 4, 6])
def test_round_trip_jacobian_and_determinant(n):
    stars, widths = example(n)
    h = maps.ShellMap.of(stars, widths)
    rng = np.random.default_rng(n)
    x = np.concatenate(
        [
            star.center + (star.radial(u)[0] + rng.uniform(1e-6, 1.1 * width, 1000))[:, None] * u
            for star, width in zip(stars, widths)
            for u in [rotation_directions(rng, 1000, n)]
        ]
    )
    np.testing.assert_allclose(h.from_balls(h.to_balls(x)), x, atol=1e-12)
    J = h.jacobian(x)
    e = 1e-6
    fd = np.stack([(h.to_balls(x + e * v) - h.to_balls(x - e * v)) / (2 * e) for v in np.eye(n)], axis=-1)
    assert np.abs(fd - J).max() < 2e-7 * max(1.0, np.abs(J).max())
    assert np.linalg.det(J).min() > 0.0
    v = rng.standard_normal(x.shape)
    np.testing.assert_allclose(h.pull_velocity(x, v), np.linalg.solve(J, v[..., None])[..., 0], atol=1e-9)
    np.testing.assert_allclose(h.pull_gradient(x, v), np.einsum("bij,bi->bj", J, v), atol=1e-12)


def rotation_directions(rng, count, n):
    u = rng.standard_normal((count, n))
    return u / np.linalg.norm(u, axis=1, keepdims=True)


@pytest.mark.parametrize("n", [2, 3, 5])
def test_outline_to_ball_and_identity_outside(n):
    stars, widths = example(n)
    h = maps.ShellMap.of(stars, widths)
    rng = np.random.default_rng(n)
    for star, width, inner in zip(stars, widths, h.inner):
        u = rotation_directions(rng, 500, n)
        edge = star.radial(u)[0]
        z = h.to_balls(star.center + edge[:, None] * u)
        np.testing.assert_allclose(np.linalg.norm(z - star.center, axis=1), inner, rtol=1e-12)
        out = star.center + (edge + 1.000001 * width)[:, None] * u
        np.testing.assert_array_equal(h.to_balls(out), out)
        # along a ray the image never moves more slowly than the point
        s = np.linspace(0.0, width, 200)
        ray = star.center + (edge[:20, None] + s)[..., None] * u[:20, None]
        image = np.linalg.norm(h.to_balls(ray) - star.center, axis=-1)
        assert (np.diff(image, axis=1) >= np.diff(s) - 1e-12).all()


def test_widths_are_checked():
    star = maps.ellipsoid([0, 0], [1, 0.5])
    with pytest.raises(InputError, match="widths"):
        maps.ShellMap.of([star], [0.0])
    with pytest.raises(InputError, match="1 shell widths"):
        maps.ShellMap.of([star], [0.1, 0.2])
