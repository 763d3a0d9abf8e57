"""Charges against brute force over the sphere, and the figures that the closed forms imply."""

import numpy as np
import pytest

from horosphere.errors import InputError
from horosphere.fields import safe_charge


def least_safe_by_search(rho: float, p: float) -> float:
    """max over the unit ball's surface of -(goal term . normal), found on a fine grid: the charge must outweigh it."""
    angle = np.linspace(0.0, np.pi, 60_001)
    x = np.stack([rho + np.cos(angle), np.sin(angle)], axis=-1)  # goal at 0, centre at (rho, 0), radius 1
    normal = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return float(((x * normal).sum(-1) / np.linalg.norm(x, axis=-1) ** p).max())


@pytest.mark.parametrize("p", [1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0])
def test_safe_charge_is_the_largest_inward_pull_on_the_sphere(p):
    for rho in np.concatenate([[1.01, 1.05, 1.2], np.linspace(1.5, 12.0, 12)]):
        got = safe_charge(2.0, 2.0 * rho, 3, rule="safe", exponent=p)
        # with radius 2 the charge is the same: it is relative to the radius
        assert got == pytest.approx(least_safe_by_search(rho, p), rel=1e-6)


@pytest.mark.parametrize("n", [2, 3, 4, 6])
def test_monotone_charge_is_the_largest_with_progress(n):
    rng = np.random.default_rng(n)
    for rho in (1.05, 1.5, 3.0, 8.0):
        q = float(safe_charge(1.0, rho, n, rule="monotone"))
        u = rng.standard_normal((20_000, n))
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        u[0] = np.eye(n)[0]  # the point behind the ball decides
        y = u * (1.0 + rng.exponential(0.5, (len(u), 1)))
        y[0] = u[0]
        x = y + rho * np.eye(n)[0]
        for factor, sign in ((1.0, -1.0), (1.001, 1.0)):
            e = -x / np.linalg.norm(x, axis=1, keepdims=True) ** n
            e += factor * q * y / np.linalg.norm(y, axis=1, keepdims=True) ** n
            assert sign * (x * e).sum(1).max() > -1e-12


def test_the_printed_charge_in_space_is_unsafe_below_fourteen_thirteenths():
    for distance, safe in ((14.0 / 13.0 - 1e-9, False), (14.0 / 13.0 + 1e-9, True), (1.02, False), (5.0, True)):
        printed, least = (float(safe_charge(1.0, distance, 3, rule=r)) for r in ("printed", "safe"))
        assert (printed >= least) == safe


@pytest.mark.parametrize(("n", "critical"), [(3, 14 / 13), (4, 9 / 8), (5, 1.1588), (6, 1.1842)])
def test_critical_distance_of_the_printed_charge(n, critical):
    rho = np.linspace(1.001, 1.6, 600_001)
    unsafe = safe_charge(1.0, rho, n, rule="printed") < safe_charge(1.0, rho, n, rule="safe")
    assert rho[unsafe].max() == pytest.approx(critical, abs=6e-5)


def test_no_charge_below_one_is_safe_close_to_the_goal():
    for n in (3, 4, 5):
        border = np.sqrt(1.0 + (n - 2.0) * n ** (-n / (n - 2.0)))
        assert float(safe_charge(1.0, border, n)) == pytest.approx(1.0, rel=1e-9)
    assert border > 1.0


def test_all_rules_agree_in_the_plane_and_broadcast():
    radius, distance = np.array([[0.5], [1.0]]), np.array([2.0, 3.0, 4.0])
    values = [
        safe_charge(radius, distance, 2, rule=r) for r in ("safe", "equilibrium", "monotone", "planar", "printed")
    ]
    assert values[0].shape == (2, 3)
    for value in values:
        np.testing.assert_allclose(value, radius / (radius + distance), rtol=1e-14)


@pytest.mark.parametrize(
    ("kwargs", "words"),
    [
        ({"radius": 0.0, "distance": 1.0}, "radius"),
        ({"radius": -1.0, "distance": 1.0}, "radius"),
        ({"radius": 1.0, "distance": 0.9}, "goal lies in the ball"),
        ({"radius": np.nan, "distance": 0.9}, "finite"),
        ({"radius": 1.0, "distance": 2.0, "dimension": 1}, "dimension"),
        ({"radius": 1.0, "distance": 2.0, "rule": "saef"}, "safe"),
        ({"radius": 1.0, "distance": 2.0, "exponent": 1.0}, "exponent"),
    ],
)
def test_bad_input(kwargs, words):
    with pytest.raises(InputError, match=words):
        safe_charge(kwargs.pop("radius"), kwargs.pop("distance"), **kwargs)
