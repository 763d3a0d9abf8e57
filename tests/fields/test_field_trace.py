"""The sampled-data motion: safe and monotone at any step, and clear outcomes where it cannot go on."""

import numpy as np
import pytest

from horosphere.errors import InputError
from horosphere.fields import HarmonicField, random_world


def least_distance(points, centers, radii):
    """Exact least clearance of the straight pieces, by projection on each."""
    a, b = points[:-1], points[1:]
    length = ((b - a) ** 2).sum(-1)
    t = ((centers[:, None] - a) * (b - a)).sum(-1) / np.where(length > 0, length, 1.0)
    nearest = a + np.clip(t, 0.0, 1.0)[..., None] * (b - a)
    return float((np.linalg.norm(nearest - centers[:, None], axis=-1) - radii[:, None]).min())


@pytest.mark.parametrize("family", ["discs", "balls", "balls-4d", "balls-6d"])
@pytest.mark.parametrize("step", [0.01, 0.1, 1.0, 10.0, 1e4])
def test_any_step_is_safe_and_monotone(family, step):
    for seed in range(3):
        world = random_world(family, seed)
        field = HarmonicField(world.goal, world.obstacles)
        path = field.trace(world.start, step=step, keep=(0.5, 0.9, 1.0)[seed])
        assert (
            path.reached and np.array_equal(path.points[-1], world.goal) and np.array_equal(path.points[0], world.start)
        )
        pieces = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
        assert pieces.max() <= step * (1 + 1e-12)
        assert path.length == pytest.approx(pieces.sum())
        clearance = least_distance(path.points, *world.obstacles)
        assert clearance >= -1e-12
        assert path.clearance == pytest.approx(clearance, abs=1e-12)
        assert np.diff(np.linalg.norm(path.points - world.goal, axis=1)).max() <= 1e-12


@pytest.mark.parametrize("n", [2, 3, 5])
def test_the_unstable_ray_is_left_by_a_stated_step(n):
    e = np.eye(n)[0]
    field = HarmonicField(np.zeros(n), ([2 * e], [1.0]))
    for offset in (0.0, 1e-13, 1e-7, 1e-3):
        start = 5 * e + offset * np.eye(n)[1]
        path = field.trace(start)
        assert path.reached and path.clearance > 0.0 and len(path.points) < 600
        assert np.diff(np.linalg.norm(path.points, axis=1)).max() <= 1e-12
        assert bool(path.notes) == (offset < 1e-5)
    # from the unstable point itself, where the field is zero and the clearance too, one step gains nothing
    path = field.trace(3.0 * e)
    assert path.reached and path.clearance == 0.0 and path.notes
    assert np.diff(np.linalg.norm(path.points, axis=1)).max() < 2e-7
    # a ball behind the goal is no reason to step aside
    assert not HarmonicField(np.zeros(n), ([-2 * e], [1.0])).trace(5 * e).notes


def test_outcomes_are_values():
    field = HarmonicField([0, 0, 0], ([[2, 0, 0], [0, 4, 0]], [1, 0.5]), workspace=([-6] * 3, [6] * 3))
    inside = field.trace([0, 4.2, 0])
    assert not inside.reached and inside.reason.startswith("start inside obstacle 1") and len(inside.points) == 1
    assert inside.clearance == pytest.approx(-0.3)
    assert field.trace([7, 0, 0]).reason == "start outside the workspace by 1 m"
    assert field.trace([5, 1, 0], step=0.01, max_steps=20).reason == "not reached within 20 steps"
    assert field.trace([0, 0, 0]).reached
    assert field.trace([3, 0, 0]).reached  # on the boundary of a zone is outside
    assert "reached" in repr(field.trace([5, 1, 0]))


@pytest.mark.parametrize("gap", [0.5, 1e-2, 1e-3, 1e-4])
def test_the_narrow_gate_between_two_discs_is_no_trap(gap):
    y = 1.0 + 0.5 * gap
    field = HarmonicField([-4.0, 0.0], ([[0, y], [0, -y]], [1, 1]))
    path = field.trace([4.0, 0.0], step=0.02)
    assert path.reached and 0.0 < path.clearance <= 0.5 * gap + 1e-12


def test_walls_keep_the_motion_inside():
    left = 0
    for seed in range(12):
        world = random_world("discs", seed)
        free = HarmonicField(world.goal, world.obstacles).trace(world.start, step=0.05)
        walled = HarmonicField(world.goal, world.obstacles, workspace=([-1.0, -1.0], [11.0, 11.0])).trace(
            world.start, step=0.05
        )
        left += bool((free.points < -1.0).any() or (free.points > 11.0).any())
        assert walled.reached and (walled.points >= -1.0).all() and (walled.points <= 11.0).all()


def test_a_ball_shaped_workspace_is_not_left():
    class Disc:
        center, radius = (0.0, 0.0), 3.0

    rng = np.random.default_rng(1)
    for _ in range(20):
        field = HarmonicField(rng.uniform(-1.2, 1.2, 2), ([[0.0, 2.0], [1.7, -1.0]], [0.6, 0.5]), workspace=Disc())
        angle = rng.uniform(0, 2 * np.pi)
        start = 2.95 * np.array([np.cos(angle), np.sin(angle)])
        path = field.trace(start, step=rng.choice([0.05, 0.5, 5.0]))
        assert path.reached and np.linalg.norm(path.points, axis=1).max() <= 3.0
        assert field.certificate().granted


def test_plain_integrators_follow_the_same_curve():
    world = random_world("balls", 3)
    field = HarmonicField(world.goal, world.obstacles)
    fine = field.trace(world.start, step=0.002)
    reference = field.trace(world.start, step=0.005, method="dop853")
    rk4 = field.trace(world.start, step=0.02, method="rk4")
    assert reference.reached and rk4.reached
    for path, tolerance in ((fine, 2e-3), (rk4, 5e-4)):
        for point in path.points[:: max(1, len(path.points) // 40)]:
            a, b = reference.points[:-1], reference.points[1:]
            t = np.clip(((point - a) * (b - a)).sum(1) / np.maximum(((b - a) ** 2).sum(1), 1e-30), 0, 1)
            assert np.linalg.norm(a + t[:, None] * (b - a) - point, axis=1).min() < tolerance


def test_step_is_the_first_piece_of_the_trace_and_safe_in_a_loop():
    world = random_world("discs", 4)
    field = HarmonicField(world.goal, world.obstacles)
    path = field.trace(world.start, step=0.3)
    x = world.start
    for k in range(1, 6):
        x = field.step(x, 0.3)
        np.testing.assert_allclose(x, path.points[k], atol=1e-12)


def test_conformal_points_and_entities():
    from horosphere.entities import Sphere

    sphere = Sphere.from_center_radius([1.0, 0.2, 0.0], 0.3)
    by_entity = HarmonicField([0, 0, 0], [sphere]).trace([2, 0, 0])
    by_array = HarmonicField([0, 0, 0], ([[1.0, 0.2, 0.0]], [0.3])).trace([2, 0, 0])
    np.testing.assert_allclose(by_entity.points, by_array.points, atol=1e-14)
    points = by_array.as_points()
    np.testing.assert_allclose(points.as_euclidean(), by_array.points, atol=1e-12)
    flat = HarmonicField([0, 0], ([[1.0, 0.2]], [0.3])).trace([2, 0])
    assert (flat.as_points().as_euclidean()[:, 2] == 0).all()
    with pytest.raises(InputError, match=r"R\^4"):
        HarmonicField([0, 0, 0, 0]).trace([1, 0, 0, 0]).as_points()


def test_margin_grows_every_zone():
    a = HarmonicField([0, 0], ([[2, 0.1]], [0.5]), margin=0.25).trace([4, 0])
    b = HarmonicField([0, 0], ([[2, 0.1]], [0.75])).trace([4, 0])
    np.testing.assert_array_equal(a.points, b.points)
