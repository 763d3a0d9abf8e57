"""The unicycle: exact arcs, bounded turn rate, arrives without contact at any period."""

import numpy as np
import pytest

from horosphere import control
from horosphere.control import _unicycle
from horosphere.fields import HarmonicField, random_world


def test_arc_against_fine_integration():
    for v, rate in ((1.0, 2.0), (0.3, -1.0), (1.0, 1e-9), (0.5, 0.0)):
        x, heading, n = np.zeros(2), 0.4, 20_000
        for _ in range(n):
            x = x + v * 0.5 / n * np.array([np.cos(heading + 0.25 * rate / n), np.sin(heading + 0.25 * rate / n)])
            heading += rate * 0.5 / n
        np.testing.assert_allclose(_unicycle._arc(0.4, v, rate, 0.5), x, atol=1e-9)


@pytest.mark.parametrize("period", [0.01, 0.1, 0.5])
def test_drives_among_discs(period):
    for seed in range(3):
        world = random_world("discs", seed)
        centers, radii = world.obstacles
        field = HarmonicField(world.goal, world.obstacles, margin=0.005)
        robot = control.Unicycle(max_turn_rate=2.0)
        run = control.drive(
            field,
            [*world.start, 2.0 * seed],
            world.goal,
            robot=robot,
            room=field.room,
            period=period,
            clearance=lambda x, c=centers, r=radii: (np.linalg.norm(x[:, None] - c, axis=2) - r).min(1),
        )
        assert run.reached and run.clearance > 0.0
        assert np.abs(run.turn_rates).max() <= 2.0 and (run.speeds >= 0.0).all() and run.speeds.max() <= 1.0 + 1e-12
        assert (np.diff(run.speeds) <= 4.0 * period + 1e-9).all()


def test_room_is_safe_and_not_timid():
    """Going the whole room along u touches nothing; along a tangent or away it is unlimited."""
    field = HarmonicField([0.0, 0.0], ([[2.0, 0.0], [0.0, 3.0]], [0.5, 1.0]), workspace=([-4, -4], [5, 5]))
    rng = np.random.default_rng(0)
    x = rng.uniform(-4, 5, (400, 2))
    x = x[field.clearance(x) > 0.0]
    u = rng.standard_normal(x.shape)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    room = field.room(x, u)
    for t in np.linspace(0, 1, 21):
        assert field.clearance(x + t * room[:, None] * u).min() > -1e-9
    assert HarmonicField([0.0, 0.0], ([[2.0, 0.0]], [0.5])).room([4.0, 0.0], [1.0, 0.0]) == np.inf
    assert HarmonicField([0.0, 0.0], ([[2.0, 0.0]], [0.5])).room([4.0, 0.0], [-1.0, 0.0]) == pytest.approx(1.5)


def test_room_of_an_arc_is_a_bound_over_all_headings_and_close():
    """Against 2,001 headings: never more than their least, and within 2 % of it."""
    rng = np.random.default_rng(3)
    field = HarmonicField([0.0, 0.0], ([[2.0, 0.0], [0.0, 3.0], [-3.0, -1.0]], [0.5, 1.0, 0.8]))
    checked = 0
    for _ in range(300):
        x, heading, turn = rng.uniform(-5, 5, 2), rng.uniform(-np.pi, np.pi), rng.uniform(-np.pi, np.pi)
        if field.clearance(x) <= 0.0:
            continue
        at = heading + turn * np.linspace(0.0, 1.0, 2001)
        least = field.room(np.broadcast_to(x, (2001, 2)), np.stack([np.cos(at), np.sin(at)], axis=-1)).min()
        bound = _unicycle._arc_room(field.room, x, heading, turn)
        if np.isfinite(least) and np.isfinite(bound):
            assert bound <= least * (1.0 + 1e-12)
            assert bound >= 0.9 * least
            checked += 1
            for v in (0.5 * bound, bound):  # an arc of that length, in one second
                arc = np.array([x + _unicycle._arc(heading, v, turn, t) for t in np.linspace(0.0, 1.0, 41)])
                assert field.clearance(arc).min() >= -1e-12
    assert checked > 100


def test_the_recorded_clearance_is_that_of_the_disc():
    field = HarmonicField([0.0, 0.0], ([[3.0, 0.1]], [0.5]), margin=0.3)
    run = control.drive(
        field,
        [5.0, 0.0, np.pi],
        [0.0, 0.0],
        robot=control.Unicycle(radius=0.25),
        room=field.room,
        clearance=lambda x: np.linalg.norm(x - [3.0, 0.1], axis=1) - 0.5,
    )
    seen = np.linalg.norm(run.poses[:, :2] - [3.0, 0.1], axis=1).min() - 0.5 - 0.25
    assert run.reached and 0.0 < run.clearance <= seen + 1e-12 and seen - run.clearance < 0.01
