"""What a result says in words."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from horosphere import scenes, shapes
from horosphere.viewer import bound, summarise


def test_a_lower_bound_is_never_written_larger_than_it_is():
    assert bound(0.03997, 1) == "39.9 mm" and bound(0.039966) == "39.96 mm" and bound(-0.00011, 1) == "-0.2 mm"
    for value in np.random.default_rng(7).uniform(-0.1, 1.0, 2000):
        for digits in (1, 2):
            written = float(bound(value, digits).removesuffix(" mm"))
            assert written <= 1e3 * value + 1e-6 and 1e3 * value - written < 1.001 * 10.0**-digits
    assert bound(0.0235, 1) == "23.5 mm" and bound(0.0678, 1) == "67.8 mm"  # what is exact stays


PLANE = scenes.Scene(
    robot=scenes.PointRobot(2, 0.1),
    start=[0, 0],
    goal=[4, 0],
    obstacles=[
        scenes.EllipsoidND([2, 0], [0.4, 0.2]),
        scenes.EllipsoidND([2, 2], [0.4, 0.2]),
        shapes.Ball([3, 1], 0.2),
    ],
)


def rows_of(scene, **facts):
    return dict(summarise(scene, None, **facts).rows)


@pytest.mark.parametrize("seed", range(4))
def test_times_add_up(seed):
    rng = np.random.default_rng(seed)
    parts = {f"part {k}": float(x) for k, x in enumerate(10.0 ** rng.uniform(-4, 0.5, 5))}
    total = sum(parts.values()) * rng.uniform(1.0, 1.5)
    said = rows_of(PLANE, timings={**parts, "total": total})["Time spent"]
    values = [float(x) * {"s": 1.0, "ms": 1e-3, "us": 1e-6}[u] for x, u in re.findall(r"([\d.]+) (s|ms|us)\b", said)]
    assert values[0] == pytest.approx(total, abs=5e-3) and len(values) in (6, 7)
    assert sum(values[1:]) == pytest.approx(values[0], abs=0.005 * total + 0.02), said
    assert "other" not in rows_of(PLANE, timings={"field": 1.5, "total": 1.5})["Time spent"]


def test_words_of_the_plane_and_of_speeds():
    rows = rows_of(PLANE)
    assert rows["Obstacles"] == "2 ellipses, 1 ball"
    assert rows["Robot"] == "ball of radius 0.1 m in R^2, at most 1 m/s and 4 m/s^2"


def test_allowed_contacts_are_told_by_reason():
    pairs = tuple(f"a{k} may touch b: allowed by the caller" for k in range(12))
    share = ("c may touch d: always touching in 100 % of the samples",)
    certificate = SimpleNamespace(certified=True, clearance=0.1, allowed=("hand may touch cup", *pairs, *share))
    said = rows_of(PLANE, certificate=certificate, solved=True)["Allowed contacts"]
    assert said == "hand may touch cup; 12 pairs of links: allowed by the caller; c may touch d: always touching"
