"""Star shapes: gradients by finite differences, enclosures by membership, supports and margins by dense sampling."""

import numpy as np
import pytest

from horosphere import maps
from horosphere.errors import InputError
from horosphere.maps import _directions


def rotation(n, seed):
    return np.linalg.qr(np.random.default_rng(seed).standard_normal((n, n)))[0]


def unit(x):
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


STARS = {
    "ellipse": lambda: maps.ellipsoid([1, 2], [1.0, 0.1], rotation(2, 0)),
    "ellipsoid": lambda: maps.ellipsoid([0, 1, 2], [1.0, 0.3, 0.6], rotation(3, 1)),
    "ellipsoid-4d": lambda: maps.ellipsoid(np.ones(4), [1.0, 0.3, 2.0, 0.5], rotation(4, 2)),
    "superquadric": lambda: maps.superquadric([0, 0, 0], [1.0, 0.5, 0.2], 6.0, rotation(3, 3)),
    "rounded-diamond": lambda: maps.superquadric([0, 0], [1.0, 0.5], 1.5),
    "box": lambda: maps.smooth_box([0, 0, 1], [1.0, 0.5, 0.2], rotation(3, 4)),
    "cylinder": lambda: maps.smooth_cylinder([0, 0, 0], [1.0, 1.0, 1.0], 0.3),
    "capsule": lambda: maps.capsule([0, 0, 0], [1.0, 2.0, 0], 0.3),
    "cone-hull": lambda: maps.RoundHull(np.zeros(3), np.array([1.0, 0.2, 0]), 0.2, 0.5),
    "cone-hull-2d": lambda: maps.RoundHull(np.zeros(2), np.array([1.0, 0.2]), 0.5, 0.2),
    "ball-off-centre": lambda: maps.ball_seen_from([0.1, 0.2, 0.3, 0], [0, 0, 0.1, 0], 0.5),
    "hull": lambda: maps.convex_hull(np.random.default_rng(5).standard_normal((40, 3))),
    "hull-2d": lambda: maps.convex_hull(np.random.default_rng(6).standard_normal((30, 2)) * [1.0, 0.2]),
    "hull-of-flat-cloud": lambda: maps.convex_hull(np.random.default_rng(7).standard_normal((900, 3)) * [1, 1, 0], 0.1),
    "union": lambda: maps.union(
        [maps.ellipsoid([0, 0, 0], [1, 0.3, 0.4], rotation(3, 8)), maps.ellipsoid([0.1, 0.2, 0], [0.5, 0.9, 0.3])]
    ),
    "lobed": lambda: maps.lobed([0, 0], 1.0, 0.3, 5, 0.4),
    "function": lambda: maps.star([0, 0, 0], lambda u: 1 + 0.2 * u[:, 0] * u[:, 1]),
    "aerofoil": lambda: maps.Joukowski.aerofoil(1.0, -0.1 + 0.1j).as_star(0.05),
}


@pytest.mark.parametrize("name", STARS)
def test_radial_gradient_and_bounds(name):
    star = STARS[name]()
    n = star.dimension
    u = unit(np.random.default_rng(0).standard_normal((200, n)))
    r, g = star.radial(u)
    h = 1e-6
    fd = np.stack(
        [(star.radial(unit(u + h * e))[0] - star.radial(unit(u - h * e))[0]) / (2 * h) for e in np.eye(n)], axis=-1
    )
    assert np.abs(fd - g).max() < 1e-6 * r.max() * max(1.0, np.abs(g).max() / r.max())
    assert np.abs((g * u).sum(1)).max() < 1e-9 * max(1.0, np.abs(g).max())
    dense = unit(np.random.default_rng(1).standard_normal((20_000, n)))
    edge = star.radial(dense)[0]
    assert star.inner <= edge.min() * (1 + 1e-9) and edge.max() <= star.outer * (1 + 1e-9)
    assert star.inner > 0.5 * edge.min() or name in (
        "hull",
        "hull-2d",
        "hull-of-flat-cloud",
        "union",
        "rounded-diamond",
    )
    body = edge[:, None] * dense
    reach = star.support(u) - (body @ u.T).max(axis=0)
    assert reach.min() > -1e-9 and reach.max() < 0.35 * star.outer
    assert (
        star.contains(star.center + 0.999 * body[:100]).all()
        and not star.contains(star.center + 1.001 * body[:100]).any()
    )


@pytest.mark.parametrize("name", [k for k in STARS if k != "aerofoil"])
def test_grown_holds_the_sum_with_a_ball(name):
    star, margin = STARS[name](), 0.1
    n = star.dimension
    rng = np.random.default_rng(2)
    u = unit(rng.standard_normal((4000, n)))
    body = star.center + star.radial(u)[0][:, None] * u
    if name.startswith("hull"):  # a hull promises this for the points, not for its own smooth body
        body = star.center + star.vertices[rng.integers(len(star.vertices), size=4000)]
    moved = body + margin * unit(rng.standard_normal(body.shape))
    assert star.grown(margin).level(moved).max() <= 1e-9


@pytest.mark.parametrize("name", STARS)
def test_distance_is_a_lower_bound(name):
    star = STARS[name]()
    n = star.dimension
    rng = np.random.default_rng(3)
    u = _directions.directions(n)
    surface = star.center + star.radial(u)[0][:, None] * u
    x = star.center + rng.uniform(-2.5, 2.5, (300, n)) * star.outer
    x = x[star.level(x) > 0]
    true = np.linalg.norm(x[:, None] - surface, axis=2).min(axis=1)  # from above
    bound = star.distance(x)
    assert (bound <= true + 1e-9).all() and (bound > 0.0).all()


def test_enclosures_hold_what_they_enclose():
    rng = np.random.default_rng(4)
    Q, half = rotation(3, 9), np.array([0.7, 0.4, 0.15])
    box = maps.smooth_box([1, 2, 3], half, Q)
    inside = np.array([1, 2, 3]) + (rng.uniform(-1, 1, (5000, 3)) * half) @ Q.T
    corners = np.array([1, 2, 3]) + (np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T * half) @ Q.T
    assert box.level(np.concatenate([inside, corners])).max() <= 1e-12
    a, b, radius = np.array([0.1, 0, 0]), np.array([0.5, 1.0, 0.2]), 0.3
    axis = (b - a) / np.linalg.norm(b - a)
    across = np.linalg.svd(axis[None])[2][1:]
    angle = rng.uniform(0, 2 * np.pi, 4000)
    rim = radius * (np.cos(angle)[:, None] * across[0] + np.sin(angle)[:, None] * across[1])
    assert maps.smooth_cylinder(a, b, radius).level(a + rng.integers(0, 2, (4000, 1)) * (b - a) + rim).max() <= 1e-12
    for n, radius in ((2, 0.0), (3, 0.0), (3, 0.2), (4, 0.1)):
        points = rng.standard_normal((60, n))
        hull = maps.convex_hull(points, radius)
        assert hull.level(points + radius * unit(rng.standard_normal(points.shape))).max() <= 1e-9
        assert 0.0 < hull.slack < 0.4 * hull.outer
    big = maps.convex_hull(rng.standard_normal((3000, 3)), most_facets=100)
    assert len(big.normals) <= 110 and big.slack > 0.0


def test_union_holds_its_parts():
    parts = [
        maps.ellipsoid([0, 0], [1, 0.3]),
        maps.capsule([0.2, -1], [0.2, 0.4], 0.2),
        maps.ball_seen_from([0, 0], [0.3, 0], 0.5),
    ]
    whole = maps.union(parts)
    for part in parts:
        u = _directions.directions(2)
        assert whole.level(part.center + part.radial(u)[0][:, None] * u).max() <= 1e-9
    assert maps.common_point([maps.capsule([0, 0], [1, 0], 0.1), maps.capsule([0, 1], [1, 1], 0.1)]) is None


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: maps.ellipsoid([0, 0], [1, -1]), "above 0"),
        (lambda: maps.ellipsoid([0, 0], [1, 1], [[1, 1], [0, 1]]), "orthogonal"),
        (lambda: maps.ellipsoid([0, 0, 0], [1, 1]), r"\(..., 2\)"),
        (lambda: maps.superquadric([0, 0], [1, 1], 1.0), "powers"),
        (lambda: maps.smooth_cylinder([0, 0, 0], [0, 0, 0], 1), "coincide"),
        (lambda: maps.capsule([0, 0], [1, 0], 0), "above 0"),
        (lambda: maps.convex_hull(np.zeros((0, 3))), "empty"),
        (lambda: maps.convex_hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]), "flat"),
        (lambda: maps.convex_hull([[0, 0, np.nan]]), "finite"),
        (lambda: maps.union([maps.ellipsoid([0, 0], [1, 1]), maps.ellipsoid([5, 0], [1, 1])]), "no common inner point"),
        (lambda: maps.star([0, 0], lambda u: u[:, 0]), "above 0"),
        (lambda: maps.star([0, 0], lambda u: np.ones(3)), "shape"),
        (lambda: maps.star([0, 0], lambda u: np.full(len(u), np.nan)), "above 0"),
        (lambda: maps.star([0, 0], lambda u: 1 / 0), "failed"),
        (lambda: maps.star([0, 0], lambda u: 1.0 + (u[:, 1] > 0)), "jumps"),
        (lambda: maps.lobed([0, 0], 1, 1.2, 5), "depth"),
        (lambda: maps.ball_seen_from([2, 0], [0, 0], 1), "outside the ball"),
    ],
)
def test_bad_input(make, words):
    with pytest.raises(InputError, match=words):
        make()
