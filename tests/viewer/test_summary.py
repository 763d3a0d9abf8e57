"""What a result says in words."""

import re
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

import horosphere as hs
from horosphere import certify, robots, scenes, shapes
from horosphere.numeric import at_least, at_most
from horosphere.shapes import HalfSpace, PointCloud
from horosphere.viewer import bound, summarise
from horosphere.viewer._parts import MOST_DRAWN, stride


def test_a_lower_bound_is_never_written_larger_than_it_is():
    assert bound(0.03997, 1) == "39.9 mm" and bound(0.039966) == "39.96 mm" and bound(-0.00011, 1) == "-0.2 mm"
    for value in np.random.default_rng(7).uniform(-0.1, 1.0, 2000):
        for digits in (1, 2):
            written = Fraction(bound(value, digits).removesuffix(" mm")) / 1000
            assert 0 <= Fraction(repr(float(value))) - written < Fraction(1, 1000 * 10**digits)
    assert bound(0.0235, 1) == "23.5 mm" and bound(0.0678, 1) == "67.8 mm"  # what is exact stays
    assert bound(0.03999999999999, 1) == "39.9 mm" and bound(0.0) == "0.00 mm" and bound(-0.0) == "0.00 mm"


def test_promises_are_rounded_to_the_safe_side():
    rng = np.random.default_rng(8)
    for value in (*rng.normal(size=2000) * 10.0 ** rng.uniform(-12, 6, 2000), -1e-9, 1e30, -1.5e300):
        exact = Fraction(repr(float(value)))
        for digits in (2, 3, 6):
            low, high = Fraction(at_least(value, digits)), Fraction(at_most(value, digits))
            assert low <= exact <= high and high - low <= abs(exact) * Fraction(10) ** (1 - digits)
        assert Fraction(at_most(value, decimals=4)) >= exact >= Fraction(at_least(value, decimals=4))
    assert at_most(-1e-9, decimals=2) == "0.00" == at_least(-0.0, decimals=2)
    assert at_least(0.0) == "0" and at_least(0.0123, power=3) == "12.3" and at_most(np.inf) == "inf"


def test_a_certificate_says_no_more_than_it_proves():
    robot = robots.load("panda")
    q = 0.5 * (robot.limits.lower + robot.limits.upper)
    for gap in (0.1, 0.0123456789, 0.02):
        top = hs.Scene(robot, q, q, obstacles=(HalfSpace([0, 0, 1.0], -gap),))
        found = certify.certify(top, np.array([q, q]))
        said = Fraction(found.reason.split("at least ")[1].split(" m ")[0])
        assert said <= Fraction(repr(found.clearance))


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
    said = rows_of(PLANE, certificate=certificate, solved=True)
    assert said["Allowed contacts"] == "hand may touch cup; 12 pairs of links: allowed by the caller"
    assert said["Not checked"] == "c / d: always touching", "nobody has allowed that"


def test_the_headline_and_the_row_say_the_same_figure():
    certificate = SimpleNamespace(certified=True, clearance=0.0399678)
    summary = summarise(PLANE, None, certificate=certificate, solved=True)
    assert "closer than 39.96 mm" in summary.verdict
    assert dict(summary.rows)["Certified clearance"].startswith("at least 39.96 mm")


def test_a_large_cloud_is_counted_and_the_report_draws_a_stated_part():
    cloud = PointCloud(np.random.default_rng(9).uniform(1, 2, (130_001, 3)), 0.01, "shelf")
    robot = robots.load("panda")
    q = 0.5 * (robot.limits.lower + robot.limits.upper)
    scene = hs.Scene(robot, q, q, (cloud, PointCloud(np.eye(3), 0.1)))
    said = dict(summarise(scene, None).rows)["Obstacles"]
    assert said == "2 point clouds (130,001 points, one in 3 drawn in the report; 3 points)"
    assert len(cloud.points[:: stride(cloud)]) <= MOST_DRAWN
