"""Random worlds: every one reaches the goal, nothing is touched, the (mapped) distance to the goal never grows, any period."""

import numpy as np
import pytest

from horosphere.fields import HarmonicField, random_world

FAMILIES = ["discs", "balls", "balls-4d", "balls-6d", "flat-ellipses", "lobed-stars", "plates"]
PERIODS = (0.01, 0.03, 0.1, 0.3, 1.0)


def run(family: str, seed: int) -> str | None:
    """What went wrong in one world, if anything."""
    world = random_world(family, seed)
    field = HarmonicField(world.goal, world.obstacles)
    path = field.trace(world.start, step=PERIODS[seed % len(PERIODS)])
    if not path.reached:
        return f"seed {seed}: {path.reason}"
    dense = np.concatenate([path.points[:-1] + t * np.diff(path.points, axis=0) for t in (0.0, 0.25, 0.5, 0.75)])
    if isinstance(world.obstacles, tuple):
        centers, radii = world.obstacles
        if min(np.linalg.norm(dense - c, axis=1).min() - r for c, r in zip(centers, radii)) < 0.0:
            return f"seed {seed}: touched"
    elif min(star.level(dense).min() for star in world.obstacles) < 0.0:
        return f"seed {seed}: touched"
    away = np.linalg.norm(field.chart.to_balls(path.points) - field.world.goal, axis=1)
    if np.diff(away).max() > 1e-9:
        return f"seed {seed}: moved away from the goal by {np.diff(away).max():.2g}"
    return None


@pytest.mark.parametrize("family", FAMILIES)
def test_random_worlds(family):
    count = 30 if family in FAMILIES[:4] else 8
    assert [bad for seed in range(count) if (bad := run(family, seed))] == []


@pytest.mark.slow
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("family", FAMILIES)
def test_a_thousand_random_worlds(family):
    assert [bad for seed in range(1000) if (bad := run(family, seed))] == []
