"""Proofs over all directions: bounds of stars and disjoint shells, against dense sampling."""

import numpy as np
import pytest
from test_stars import STARS, unit

from horosphere import maps
from horosphere.errors import InputError
from horosphere.maps._cells import cover, disjoint, extreme_radii, first_cells, grid, halved


@pytest.mark.parametrize("n", [2, 3, 4])
def test_cells_cover_all_directions(n):
    middles, half = first_cells(n)
    for _ in range(2):
        middles, half = halved(middles, half)
    assert len(middles) == 2 * n * 4 ** (n - 1) and len(np.unique(middles, axis=0)) == len(middles)
    u, angle = cover(middles, half)
    v = unit(np.random.default_rng(n).standard_normal((20_000, n)))
    between = np.arccos(np.clip(v @ u.T, -1, 1))
    assert (between <= angle + 1e-12).any(axis=1).all()
    # a direction lies in the cell it goes through
    at = v / np.abs(v).max(axis=1, keepdims=True)
    own = np.abs(at[:, None] - middles).max(axis=2).argmin(axis=1)
    assert (between[np.arange(len(v)), own] <= angle[own]).all()
    assert len(grid(n, 5000)[0]) <= 5000


@pytest.mark.parametrize("name", STARS)
def test_steepness_and_kernel_are_bounds(name):
    star = STARS[name]()
    u = unit(np.random.default_rng(3).standard_normal((20_000, star.dimension)))
    r, g = star.radial(u)
    slope = np.linalg.norm(g, axis=1)
    assert slope.max() <= star.steepness * (1 + 1e-6) + 1e-9
    assert star.kernel <= (r**2 / np.hypot(r, slope)).min() * (1 + 1e-6)
    low, high = extreme_radii(star)
    assert low <= r.min() and high >= r.max()
    if name in ("lobed", "function", "aerofoil"):
        assert low >= 0.97 * r.min() and high <= 1.03 * r.max()


@pytest.mark.parametrize("seed", range(3))
def test_disjoint_is_never_wrong(seed):
    """True only where no sample of the one lies in the other; False only where one does; and it does decide."""
    rng = np.random.default_rng(seed)
    decided = []
    for trial in range(20):
        n = 2 if trial < 16 else 3

        def make(c, n=n):
            if n == 2:
                return maps.lobed(
                    c, rng.uniform(0.5, 0.9), rng.uniform(0.0, 0.45), int(rng.integers(2, 7)), rng.uniform(0, 6)
                )
            turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
            return maps.union(
                [maps.ellipsoid(c, rng.uniform(0.3, 1.0, 3), turn), maps.ellipsoid(c, rng.uniform(0.3, 1.0, 3))]
            )

        a, b = make(np.zeros(n)), make(rng.normal(0, 0.7, n))
        wa, wb = rng.uniform(0, 0.2, 2)
        said = disjoint(a, wa, b, wb)
        u = unit(rng.standard_normal((6000, n)))
        deepest = min(
            (q.level(p.center + t * (p.radial(u)[0] + wp)[:, None] * u) - wq).min()
            for p, wp, q, wq in ((a, wa, b, wb), (b, wb, a, wa))
            for t in (0.2, 0.6, 1.0)
        )
        if said is True:
            assert deepest > 0.0
        elif deepest > 0.02:
            assert said is None
        decided.append(said is not None)
    assert np.mean(decided) > 0.9


def test_a_star_inside_another_is_not_disjoint():
    big = maps.lobed([0, 0], 2.0, 0.2, 3)
    small = maps.lobed([0.5, 0], 0.3, 0.2, 3)
    assert disjoint(big, 0.0, small, 0.0) is False and disjoint(small, 0.0, big, 0.0) is False


def test_a_bay_can_be_entered():
    """The arm of one star reaches 0.3 m into the bay of the other: no plane separates them, the proof does."""
    five = maps.lobed([0, 0], 1.0, 0.45, 4, np.pi)  # bays at 0, 90, ... degrees, 0.55 m from the centre
    arm = maps.ellipsoid([1.65, 0], [0.8, 0.08])
    assert arm.center[0] - 0.8 < 1.0
    assert disjoint(five, 0.0, arm, 0.0) is True
    assert disjoint(five, 0.3, arm, 0.0) is False


def test_function_star_states_what_is_proven():
    def radius(u):
        return 1 + 0.2 * u[:, 0] * u[:, 1]

    sampled, stated = maps.star([0, 0, 0], radius), maps.star([0, 0, 0], radius, steepest=0.2)
    assert not sampled.proven and stated.proven and stated.steepness == 0.2
    assert 0.85 < stated.inner <= 0.9 and 1.1 <= stated.outer < 1.15
    with pytest.raises(InputError, match="steeper than stated"):
        maps.star([0, 0, 0], radius, steepest=0.1)
    with pytest.raises(InputError, match="at least 0"):
        maps.star([0, 0, 0], radius, steepest=-1.0)
    with pytest.raises(InputError, match="expected a function"):
        maps.star([0, 0, 0], 3.0)
