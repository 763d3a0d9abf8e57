"""The certificate grants what the theorems say and refuses by name, amount and remedy."""

import numpy as np
import pytest

from horosphere.errors import InputError
from horosphere.fields import HarmonicField, random_world


def test_granted_with_margins_and_rates():
    field = HarmonicField([0, 0, 0], ([[2, 0, 0], [0, 4, 0]], [1, 0.5]))
    certificate = field.certificate()
    assert certificate and certificate.granted and not certificate.refusals
    assert set(certificate.guarantees) == {"invariance", "progress", "convergence", "clearance rate"}
    margins = {check.name: check.margin for check in certificate.checks}
    assert margins["goal outside the zones"] == pytest.approx(1.0)
    assert margins["zones disjoint"] == pytest.approx(np.sqrt(20.0) - 1.5)
    np.testing.assert_allclose(certificate.rates, [2 / 9, 4 / (0.5 * 4.5**2)])
    assert "guaranteed" in str(certificate)


@pytest.mark.parametrize("family", ["discs", "balls", "balls-4d", "flat-ellipses", "plates"])
def test_random_worlds_are_granted(family):
    world = random_world(family, 7)
    assert HarmonicField(world.goal, world.obstacles).certificate().granted


@pytest.mark.parametrize(
    ("options", "failing", "kept"),
    [
        ({"blend": "simplex", "boundary": 3.0}, "boundary within the least gap", set()),
        ({"blend": "nearest"}, "direction continuous", {"invariance", "progress", "clearance rate"}),
        ({"blend": "printed"}, "weights as printed", set()),
        ({"rule": "safe"}, "largest with progress", {"invariance"}),
        ({"rule": "monotone"}, "least safe", {"progress"}),
        ({"exponent": 2.9}, "least safe", {"progress"}),
    ],
)
def test_refusals_name_what_fails(options, failing, kept):
    field = HarmonicField([0, 0, 0], ([[1.5, 0, 0], [0, 4, 0]], [1, 0.5]), **options)
    certificate = field.certificate()
    assert not certificate.granted and set(certificate.guarantees) == kept
    refusal = next(check for check in certificate.refusals if failing in check.name)
    assert (refusal.margin < 0.0 and "obstacle" in refusal.subject) or refusal.subject in (
        "three zones at a time",
        "the equidistant surfaces",
    )
    assert refusal.remedy and "FAILS" in str(certificate)


def test_exponents_up_to_one_plus_rho_keep_everything_but_the_rate():
    field = HarmonicField([0, 0, 0], ([[2, 0, 0], [0, 4, 0]], [1, 0.5]), exponent=[3.0, 9.0])
    assert set(field.certificate().guarantees) == {"invariance", "progress", "convergence"}
    assert not HarmonicField([0, 0, 0], ([[2, 0, 0], [0, 4, 0]], [1, 0.5]), exponent=[3.1, 9.0]).certificate().granted


def test_superposition_certificate_and_its_failures():
    """Sparse: granted and safe. Two discs close together, equilibrium charges: the robot is pushed into the first."""
    sparse = HarmonicField([0, 0], ([[4, 0], [0, -5]], [0.3, 0.3]), blend="sum")
    assert "invariance" in sparse.certificate().guarantees
    rng = np.random.default_rng(0)
    for _ in range(20):
        path = sparse.trace(rng.uniform(5.5, 8.0, 2), step=0.02, method="euler")
        assert path.reached and path.clearance > 0.0
    ring = np.arange(14) * 2 * np.pi / 14
    crowd = HarmonicField([0, 0], (8.0 * np.stack([np.cos(ring), np.sin(ring)], -1), np.ones(14)), blend="sum")
    assert "convergence" not in crowd.certificate().guarantees
    assert any("infinity" in check.name for check in crowd.certificate().refusals)
    # with a total charge above that of the goal everything far away is repelled
    assert (crowd([[40.0, 3.0]]) @ [40.0, 3.0]).item() > 0.0


def test_overlap_is_merged_and_said():
    field = HarmonicField([-3, 0.1], ([[0, 0], [0.5, 0.6], [3, 0]], [0.5, 0.5, 0.4]))
    assert len(field.world.radii) == 2 and "merged obstacle 0 + obstacle 1" in field.notes[0]
    centers, radii = np.array([[0, 0], [0.5, 0.6], [3, 0]]), np.array([0.5, 0.5, 0.4])
    rng = np.random.default_rng(0)
    for _ in range(15):
        start = rng.uniform([4, -3], [6, 3])
        path = field.trace(start, step=rng.choice([0.02, 0.5]))
        dense = np.concatenate([path.points[:-1] + t * np.diff(path.points, axis=0) for t in np.linspace(0, 1, 9)])
        assert path.reached and (np.linalg.norm(dense[:, None] - centers, axis=2) - radii).min() > 0.0
    assert field.certificate().granted


@pytest.mark.parametrize("n", [2, 3, 4])
def test_chains_without_a_common_point_are_joined(n):
    rng = np.random.default_rng(n)
    centers = np.cumsum(np.concatenate([np.zeros((1, n)), rng.normal(0, 0.5, (4, n)) + 0.2]), axis=0)
    radii = np.full(5, 0.6)
    goal = centers.mean(0) - 4.0
    field = HarmonicField(goal, (centers, radii))
    assert len(field.world.radii) < 5 and field.notes
    u = rng.standard_normal((500, n))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    for center in centers:  # every ball lies in a zone
        assert field.clearance(center + 0.6 * u).max() <= 1e-9
    path = field.trace(centers.mean(0) + 4.0 + rng.normal(0, 0.2, n))
    dense = np.concatenate([path.points[:-1] + t * np.diff(path.points, axis=0) for t in np.linspace(0, 1, 9)])
    assert path.reached and (np.linalg.norm(dense[:, None] - centers, axis=2) - 0.6).min() > 0.0


def test_shells_are_among_the_assumptions():
    world = random_world("lobed-stars", 4)
    field = HarmonicField(world.goal, world.obstacles)
    certificate = field.certificate()
    (check,) = (check for check in certificate.checks if check.name.startswith("shells disjoint"))
    assert certificate.granted and check.margin == min(field.chart.widths) and not certificate.notes
    u = np.stack([np.cos(t := np.linspace(0, 2 * np.pi, 4001)), np.sin(t)], axis=-1)
    for a, wa in zip(field.stars, field.chart.widths):  # witness: dense samples of every shell's outer boundary
        edge = a.center + (a.radial(u)[0] + wa)[:, None] * u
        for b, wb in zip(field.stars, field.chart.widths):
            assert a is b or b.level(edge).min() > wb


def test_a_ring_around_the_goal_cannot_be_merged():
    ring = np.arange(12) * 2 * np.pi / 12
    with pytest.raises(InputError, match=r"obstacle 0 \+ obstacle 1.*cannot be merged.*holds the goal"):
        HarmonicField([0, 0], (3.0 * np.stack([np.cos(ring), np.sin(ring)], -1), np.full(12, 0.9)))
