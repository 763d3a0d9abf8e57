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
