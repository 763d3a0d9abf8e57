"""The field against formulas written out here, finite differences, and the two properties it is built on."""

import itertools

import numpy as np
import pytest

from horosphere.errors import InputError
from horosphere.fields import HarmonicField, random_world

DIMENSIONS = [2, 3, 4, 6]


def scene(n: int, seed: int, count: int = 6):
    """A goal at the origin and `count` disjoint balls that leave it out."""
    rng = np.random.default_rng(seed)
    centers, radii = [], []
    while len(centers) < count:
        c, r = rng.uniform(-3.0, 3.0, n), rng.uniform(0.2, 0.9)
        if np.linalg.norm(c) > r + 0.05 and all(np.linalg.norm(c - d) > r + s + 0.02 for d, s in zip(centers, radii)):
            centers.append(c)
            radii.append(r)
    return np.zeros(n), np.array(centers), np.array(radii)


def outside(rng, centers, radii, count):
    """Points outside the balls, many of them close."""
    n = centers.shape[1]
    far = rng.uniform(-4.0, 4.0, (count, n))
    u = rng.standard_normal((count, n))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    k = rng.integers(len(radii), size=count)
    near = centers[k] + u * (radii[k] + rng.exponential(0.05, count))[:, None]
    x = np.concatenate([far, near])
    return x[(np.linalg.norm(x[:, None] - centers, axis=2) >= radii).all(axis=1)]


def one_field(x, center, radius, p=2.0):
    """E_i with unit goal strength about the goal 0, straight from the text."""
    y = x - center
    rx, ry, far = np.linalg.norm(x), np.linalg.norm(y), np.linalg.norm(center)
    return -x / rx**2 + (radius / (radius + far)) ** (p - 1) * rx ** (p - 2) * y / ry**p


def simplex_projection(v):
    """By bisection on the threshold: independent of any sort."""
    low, high = v.min() - 1.0, v.max()
    for _ in range(200):
        tau = 0.5 * (low + high)
        low, high = (tau, high) if np.maximum(v - tau, 0).sum() > 1.0 else (low, tau)
    return np.maximum(v - tau, 0)


def step_function(s):
    """The quintic with value and two derivatives 0 at -1 and 1 at +1, by solving for its coefficients."""
    a = [[1, t, t**2, t**3, t**4, t**5] for t in (-1.0, 1.0)]
    b = [[0, 1, 2 * t, 3 * t**2, 4 * t**3, 5 * t**4] for t in (-1.0, 1.0)]
    c = [[0, 0, 2, 6 * t, 12 * t**2, 20 * t**3] for t in (-1.0, 1.0)]
    k = np.linalg.solve(np.array(a + b + c), [0, 1, 0, 0, 0, 0])
    return 0.0 if s <= -1 else 1.0 if s >= 1 else float(np.polyval(k[::-1], s))


def blended(x, centers, radii, delta, blend, p):
    d = np.linalg.norm(x - centers, axis=1) - radii
    if blend == "simplex":
        mu = simplex_projection(-d / delta)
    else:
        w = np.ones(len(d))
        for i in range(len(d)):
            for j in range(len(d)):
                gap = np.linalg.norm(centers[i] - centers[j]) - radii[i] - radii[j]
                if i != j:
                    w[i] *= step_function((d[j] - d[i]) / min(delta, gap))
        mu = w / w.sum()
    return sum(m * one_field(x, c, r, q) for m, c, r, q in zip(mu, centers, radii, p))


@pytest.mark.parametrize("blend", ["smooth", "simplex"])
@pytest.mark.parametrize("n", DIMENSIONS)
def test_direction_is_the_blend_of_the_single_fields(n, blend):
    goal, centers, radii = scene(n, seed=n)
    rng = np.random.default_rng(10 + n)
    p = rng.uniform(1.2, np.minimum(1.0 + np.linalg.norm(centers, axis=1) / radii, 5.0))
    p[0] = 2.0
    for delta in (0.02, 0.4, 3.0):
        field = HarmonicField(goal, (centers, radii), boundary=delta, blend=blend, exponent=p)
        x = outside(rng, centers, radii, 40)
        wanted = np.array([blended(point, centers, radii, delta, blend, p) for point in x])
        wanted /= np.linalg.norm(wanted, axis=1, keepdims=True)
        np.testing.assert_allclose(field(x), wanted, atol=2e-10)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_gradient_is_that_of_the_potential(n):
    """Central differences, one obstacle; and the potential is harmonic exactly when the exponent is n."""
    rng = np.random.default_rng(n)
    center, radius = rng.uniform(1.0, 2.0, n), 0.5
    for exponent in {2.0, float(n)}:
        field = HarmonicField(np.zeros(n), ([center], [radius]), rule="equilibrium", exponent=exponent)
        x = outside(rng, center[None], np.array([radius]), 60)
        x = x[np.linalg.norm(x, axis=1) > 0.5]
        h = 1e-4
        plus = np.stack([field.potential(x + h * e) for e in np.eye(n)], axis=-1)
        minus = np.stack([field.potential(x - h * e) for e in np.eye(n)], axis=-1)
        gradient = field.gradient(x)
        np.testing.assert_allclose((plus - minus) / (2 * h), gradient, rtol=1e-5, atol=1e-6)
        laplacian = (plus + minus - 2 * field.potential(x)[:, None]).sum(-1) / h**2
        if exponent == n:
            assert np.abs(laplacian).max() < 2e-4
        else:
            assert np.abs(laplacian).max() > 1e-2
        size = np.linalg.norm(gradient, axis=-1, keepdims=True)
        np.testing.assert_allclose(field(x), -gradient / size, atol=1e-12)


@pytest.mark.parametrize("blend", ["smooth", "simplex"])
@pytest.mark.parametrize("n", DIMENSIONS)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_no_inward_motion_on_a_zone_and_progress_everywhere(n, blend, seed):
    goal, centers, radii = scene(n, seed, count=8)
    field = HarmonicField(goal, (centers, radii), blend=blend, boundary=None if blend == "simplex" else 0.7)
    rng = np.random.default_rng(seed)
    u = rng.standard_normal((4000, n))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    k = rng.integers(len(radii), size=len(u))
    surface = centers[k] + radii[k, None] * u
    assert (field(surface) * u).sum(1).min() > -1e-9
    x = outside(rng, centers, radii, 4000)
    assert (field(x) * x).sum(1).max() < 1e-9


def test_zeros_are_the_antipodes_and_saddles():
    goal, centers, radii = scene(3, 5)
    field = HarmonicField(goal, (centers, radii), boundary=0.3)
    points = field.unstable_points()
    rates = field.certificate().rates
    for center, radius, point, rate in zip(centers, radii, points, rates):
        ray = center / np.linalg.norm(center)
        np.testing.assert_allclose(point, center + radius * ray, atol=1e-12)
        # |E| = |gradient| is zero there; its Jacobian has eigenvalues -rate on the ray, +rate across
        assert np.linalg.norm(field.gradient(point)) < 1e-9
        h = 1e-6
        J = -np.stack(
            [(field.gradient(point + h * e) - field.gradient(point - h * e)) / (2 * h) for e in np.eye(3)], axis=-1
        )
        np.testing.assert_allclose(np.sort(np.linalg.eigvals(J).real), [-rate, rate, rate], rtol=1e-4)


def test_smooth_blend_has_no_jump():
    """Second differences of the direction along lines stay bounded by a constant as the spacing goes to zero."""
    goal, centers, radii = scene(2, 3, count=7)
    field = HarmonicField(goal, (centers, radii), boundary=0.5)
    rng = np.random.default_rng(0)
    for _ in range(20):
        a, b = rng.uniform(-3, 3, (2, 2))
        line = a + np.linspace(0, 1, 20_001)[:, None] * (b - a)
        free = (np.linalg.norm(line[:, None] - centers, axis=2) > radii + 0.01).all(1) & (
            np.linalg.norm(line, axis=1) > 0.2
        )
        e = field.gradient(line)
        jump = np.linalg.norm(np.diff(e, axis=0), axis=1)[free[1:] & free[:-1]]
        assert jump.max(initial=0.0) < 0.02


def test_weights_sum_to_one_and_name_the_zones():
    world = random_world("balls", 1)
    field = HarmonicField(world.goal, world.obstacles, workspace=([-1] * 3, [11] * 3), sensor_range=2.0)
    x = outside(np.random.default_rng(0), *world.obstacles, 300)
    mu = field.weights(x)
    assert mu.shape == (len(x), 60 + 6 + 1) and len(field.names) == 66
    np.testing.assert_allclose(mu.sum(1), 1.0, atol=1e-12)
    assert mu.min() >= 0.0


@pytest.mark.parametrize("n", [2, 3, 5])
def test_walls_and_sensor_range(n):
    """On a wall the motion is inward; beyond the range it is straight; on a zone nothing changes."""
    rng = np.random.default_rng(n)
    goal, centers, radii = scene(n, n)
    field = HarmonicField(goal, (centers, radii), workspace=([-4.2] * n, [4.5] * n), sensor_range=0.6, boundary=0.3)
    x = rng.uniform(-4.0, 4.0, (500, n))
    x[:, 0] = -4.2
    assert (field(x)[:, 0] >= 0).all()
    far = outside(rng, centers, radii, 1000)
    d = np.linalg.norm(far[:, None] - centers, axis=2) - radii
    far = far[d.min(1) > 0.95]
    np.testing.assert_allclose(field(far), -far / np.linalg.norm(far, axis=1, keepdims=True), atol=1e-12)
    assert len(far) > 10


def test_batches_keep_their_shape_and_take_integers():
    field = HarmonicField([0, 0], ([[3, 0]], [1]))
    assert field([[[5, 1], [6, 2]]]).shape == (1, 2, 2)
    assert (
        field([5, 1]).shape == (2,) and field.potential([5, 1]).shape == () and field.gradient([[5, 1]]).shape == (1, 2)
    )
    np.testing.assert_array_equal(field([0, 0]), [0, 0])
    assert HarmonicField([1.0, 2.0])([3.0, 2.0]).tolist() == [-1.0, 0.0]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: HarmonicField([0.0], ()), "n >= 2"),
        (lambda: HarmonicField([0.0, np.nan]), "finite"),
        (lambda: HarmonicField([0, 0], ([[1, 2, 3]], [1])), r"\(m, 2\)"),
        (lambda: HarmonicField([0, 0], ([[1, 2]], [1, 2])), "1 obstacle centers"),
        (lambda: HarmonicField([0, 0], ([[1, 2]], [0])), "above 0"),
        (lambda: HarmonicField([0, 0], ([[1, 2]], [-1])), "above 0"),
        (lambda: HarmonicField([0, 0], ([[1, np.inf]], [1])), "finite"),
        (lambda: HarmonicField([0, 0], ([[0.5, 0]], [1])), "goal lies 500 mm inside obstacle 0"),
        (lambda: HarmonicField([0, 0], ([[2, 0]], [1]), margin=1.5), "inside obstacle 0"),
        (lambda: HarmonicField([0, 0], rule="plannar"), "planar-log"),
        (lambda: HarmonicField([0, 0], blend="smoth"), "smooth"),
        (lambda: HarmonicField([0, 0], boundary=-1), "at least 0"),
        (lambda: HarmonicField([0, 0], workspace=([1, 1], [2, 2])), "beyond the workspace's lower wall 0"),
        (lambda: HarmonicField([0, 0], workspace=([1, 1], [0, 2])), "lower < upper"),
        (lambda: HarmonicField([0, 0], ["a"]), "cannot use str"),
        (lambda: HarmonicField([0, 0], ([[3, 0]], [1]))([1, 2, 3]), r"\(..., 2\)"),
        (lambda: HarmonicField([0, 0], ([[3, 0]], [1])).trace([1, np.nan]), "finite"),
        (lambda: HarmonicField([0, 0], ([[3, 0]], [1])).trace([5, 0], step=0), "above 0"),
        (lambda: HarmonicField([0, 0], ([[3, 0]], [1])).trace([5, 0], method="rk5"), "rk4"),
        (lambda: HarmonicField([0, 0], ([[3, 0]], [1]), exponent=[2, 2]), "exponent"),
    ],
)
def test_bad_input(make, words):
    with pytest.raises(InputError, match=words):
        make()


@pytest.mark.parametrize("seed", range(12))
def test_the_index_changes_nothing_at_any_scale(seed):
    """Boundaries from next to nothing to wider than a cell, far from the origin, few and many cells, on their borders."""
    rng = np.random.default_rng([seed, 77])
    n, scale = int(rng.integers(2, 4)), 10.0 ** rng.uniform(-3, 3)
    grid = np.stack(np.meshgrid(*[np.arange(9.0)] * n), axis=-1).reshape(-1, n)
    radii = scale * rng.uniform(0.05, 0.45, len(grid))
    shift = scale * 10.0 ** rng.uniform(0, 3) * rng.normal(size=n)
    centers = shift + scale * grid[rng.permutation(len(grid))]
    goal = shift + scale * np.full(n, -1.5)
    field = HarmonicField(goal, (centers, radii), boundary=scale * 10.0 ** rng.uniform(-6, 0.5))
    fast = field.indexed(int(10.0 ** rng.uniform(0, 4.5)))
    index = fast.world.index
    corners = goal + index.grid[0] + rng.integers(0, index.grid[2] + 1, (200, n)) / index.grid[1]
    x = np.vstack([shift + scale * rng.uniform(-2, 10, (1000, n)), corners, centers + scale * 1e-9])
    np.testing.assert_array_equal(fast(x), field(x))
    listed = [np.sort(index.entries[a:b, 0]) for a, b in itertools.pairwise(index.starts)]
    assert all(len(np.unique(cell)) == len(cell) > 0 for cell in listed)


def test_an_index_of_many_balls_is_small():
    side = np.arange(20.0)
    centers = np.stack(np.meshgrid(side, side, side), axis=-1).reshape(-1, 3)
    radii = np.random.default_rng(3).uniform(0.1, 0.4, len(centers))
    index = HarmonicField(np.full(3, -2.0), (centers, radii), boundary=0.2).indexed().world.index
    assert index.bytes < 1300 * len(centers) and index.mean_candidates < 40


@pytest.mark.parametrize(
    "flat", [(True, False, False), (True, True, False), (False, True, True), (False, False, False)]
)
def test_an_index_of_flat_worlds_is_small(flat):
    """Tiny zones on a plane, or along a line: the box round them is next to nothing in other directions."""
    rng = np.random.default_rng(5)
    centers = np.where(flat, 0.0, rng.uniform(1, 2, (50, 3)))
    field = HarmonicField(np.full(3, -1.0), (centers, np.full(50, 1e-6)), boundary=0.1)
    fast = field.indexed()
    assert fast.world.index.grid[2].prod() < 8 * 4096
    x = rng.uniform(-0.5, 2.5, (300, 3))
    np.testing.assert_array_equal(fast(x), field(x))


def test_odd_indices():
    one, none = HarmonicField([0, 0, 0], ([[1, 0, 0]], [0.2])), HarmonicField([0.0, 0, 0])
    x = np.random.default_rng(0).uniform(-2, 2, (100, 3))
    for cells in (None, 1, 2.5):
        np.testing.assert_array_equal(one.indexed(cells)(x), one(x))
    np.testing.assert_array_equal(none.indexed()(x), none(x))
    for cells in (0, -5, np.nan):
        with pytest.raises(InputError, match="cells: expected at least one"):
            one.indexed(cells)


@pytest.mark.parametrize("n", [2, 3])
def test_the_index_changes_nothing(n):
    """Inside and outside the grid, for every compiled blend, among balls of very different sizes."""
    rng = np.random.default_rng(n)
    centers = rng.uniform(0, 20, (3000, n))
    radii = rng.uniform(0.02, 0.1, len(centers)) + (rng.random(len(centers)) < 0.01) * 1.0
    order, kept = np.argsort(-radii), []
    for k in order:
        if not kept or (np.linalg.norm(centers[kept] - centers[k], axis=1) - radii[kept] - radii[k]).min() > 0.01:
            kept.append(k)
        if len(kept) == 600:
            break
    x = rng.uniform(-3, 23, (3000, n))
    for blend in ("smooth", "simplex", "nearest"):
        field = HarmonicField(np.full(n, -2.0), (centers[kept], radii[kept]), blend=blend, boundary=0.05)
        fast = field.indexed()
        np.testing.assert_array_equal(fast(x), field(x))
        assert fast.world.index.mean_candidates < 60
    with pytest.raises(InputError, match="all zones"):
        HarmonicField(np.full(n, -2.0), (centers[kept], radii[kept]), blend="sum").indexed()


def test_large_worlds_are_built_and_certified_quickly():
    rng = np.random.default_rng(0)
    grid = np.stack(np.meshgrid(*[np.arange(12.0)] * 3), axis=-1).reshape(-1, 3) + rng.uniform(-0.2, 0.2, (1728, 3))
    field = HarmonicField([-1.0, -1.0, -1.0], (grid, np.full(len(grid), 0.25)))
    assert field.certificate().granted and len(field.world.radii) == 1728
