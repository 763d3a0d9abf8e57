"""Goals that leave the tool free: their postures come from many places and branches, and brute force finds none that we do not."""

import re

import numpy as np
import pytest

from horosphere import Point, kinematics, robots
from horosphere.distance import clearance, signed
from horosphere.kinematics._numeric import reach
from horosphere.planning import plan
from horosphere.planning._configurations import MOST, configurations
from horosphere.planning._goal_rounds import ENOUGH, rounds
from horosphere.planning._places import places_of
from horosphere.planning._postures import turned_near
from horosphere.scenes import LineTarget, Options, PlaneTarget, PositionTarget, Scene
from horosphere.shapes import Ball, Box

CLEARANCE = 0.01
PANDA_START = np.radians([0, -45, 0, -135, 0, 90, 45])


def missed(robot, target, q):
    """Metres (m,) from the tool of postures (m, n) to a point, a line or a plane."""
    x = kinematics.forward(robot, q).as_matrix()[..., :3, 3]
    if isinstance(target, PositionTarget):
        return np.linalg.norm(x - target.position, axis=-1)
    if isinstance(target, LineTarget):
        return np.linalg.norm(np.cross(x - target.point, target.direction), axis=-1)
    return np.abs(x @ target.normal - target.distance)


def is_free(robot, q, obstacles):
    """(m,) what the scene asks of postures, without the planner's own words for it."""
    return (signed(robot, q, obstacles, static=False) >= CLEARANCE) & (clearance(robot, q, ()) >= 0.0)


def drawn_scene(name, seed):
    """A ball or a box on the anchor of a line, of a plane, and near a point, more balls about, and a free start; or None."""
    rng, robot = np.random.default_rng(seed), robots.load(name)
    low, high = np.clip(robot.limits.lower, -3.0, 3.0), np.clip(robot.limits.upper, -3.0, 3.0)

    def free(obstacles):
        q = rng.uniform(low, high, (500, robot.n_joints))
        return q[is_free(robot, q, obstacles)][:1]

    anchor = kinematics.forward(robot, free(())[0]).as_matrix()[:3, 3]
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    size = reach(robot)
    on = [
        Ball(anchor, size * rng.uniform(0.05, 0.15), name="block"),
        Box(anchor, size * rng.uniform(0.05, 0.15, 3), name="block"),
    ]
    others = [kinematics.forward(robot, free(())[0]).as_matrix()[:3, 3] for _ in range(3)]
    obstacles = (on[seed % 2], *(Ball(x, 0.06 * size, name=f"ball {k}") for k, x in enumerate(others)))
    start = free(obstacles)
    if not len(start):
        return None
    targets = (
        LineTarget(anchor, direction),
        PlaneTarget(direction, float(direction @ anchor)),
        PositionTarget(anchor + 0.2 * size * direction),
    )
    return robot, start[0], obstacles, targets, rng


def brute_force(robot, target, obstacles, rng, count=400):
    """The share of random places and postures that are free: the numerical inverse from random seeds, and nothing clever."""
    low, high = np.clip(robot.limits.lower, -3.0, 3.0), np.clip(robot.limits.upper, -3.0, 3.0)
    size = reach(robot)
    points = np.tile(getattr(target, "position", getattr(target, "point", np.zeros(3))), (count, 1))
    if isinstance(target, LineTarget):
        points += rng.uniform(-size, size, (count, 1)) * target.direction
    elif isinstance(target, PlaneTarget):
        points = rng.uniform(-size, size, (count, 3))
        points -= (points @ target.normal - target.distance)[:, None] * target.normal
    seeds = rng.uniform(low, high, (count, robot.n_joints))
    found = kinematics.numerical_inverse(robot, Point.from_euclidean(points), seed=seeds, attempts=1)
    q = found.q[found.valid]
    return np.count_nonzero(is_free(robot, q, obstacles)) / count if len(q) else 0.0


def against_brute_force(name, seeds):
    compared = 0
    for seed in seeds:
        made = drawn_scene(name, seed)
        if made is None:
            continue
        robot, start, obstacles, targets, rng = made
        for target in targets:
            share = brute_force(robot, target, obstacles, rng)
            found = configurations(Scene(robot, start, target, obstacles), "goal", start)
            place = f"{name}, seed {seed}, {type(target).__name__}: brute force {share:.3f}"
            assert len(found.q) or share < 0.02, f"{place}: {found.reason}"
            if len(found.q):
                assert missed(robot, target, found.q).max() < 1e-6 and is_free(robot, found.q, obstacles).all(), place
                inside = (found.q >= robot.limits.lower - 1e-9) & (found.q <= robot.limits.upper + 1e-9)
                whole = (
                    isinstance(target, PositionTarget) and kinematics.classify(robot).position
                )  # a grid over all of it
                assert inside.all() and (whole or len(found.q) <= MOST), place
            compared += share >= 0.02
    return compared


@pytest.mark.parametrize("name", ["panda", "ur5", "iiwa14", "humanoid-arm"])
def test_what_brute_force_finds_is_found(name):
    assert against_brute_force(name, range(5)) >= 4


@pytest.mark.slow
@pytest.mark.parametrize("name", ["panda", "ur5", "iiwa14", "humanoid-arm", "nao-left-arm", "srs-arm"])
def test_what_brute_force_finds_is_found_in_many_scenes(name):
    assert against_brute_force(name, range(100, 160)) >= 80


BALL = [-0.2018, 0.2901, 0.5611]


@pytest.mark.parametrize("radius", [0.08, 0.12])
@pytest.mark.parametrize(
    "target",
    [LineTarget(BALL, [-0.4935, -0.8581, 0.1422]), PlaneTarget([0.0, 1.0, 0.3], 0.2901 + 0.3 * 0.5611)],
    ids=["line", "plane"],
)
def test_a_plan_goes_past_what_sits_on_the_anchor(target, radius):
    robot = robots.load("panda")
    table = Box([0.0, 0.0, -0.1], [2.0, 2.0, 0.1], name="table")
    scene = Scene(
        robot, PANDA_START, target, (table, Ball(BALL, radius, name="ball")), options=Options(improvement_time=0.0)
    )
    found = plan(scene)
    assert found.solved and found.certificate.certified, found.reason
    end = found.trajectory.positions[-1]
    assert missed(robot, target, end) < 1e-6
    tool = kinematics.forward(robot, end).as_matrix()[:3, 3]
    assert np.linalg.norm(tool - BALL) > radius + CLEARANCE
    again = plan(scene)  # nothing in it depends on the clock
    np.testing.assert_array_equal(again.trajectory.positions, found.trajectory.positions)


def test_goal_postures_come_from_several_places_and_branches():
    robot = robots.load("ur5")
    start = np.radians([-60, -90, 90, -90, -90, 0])
    target = LineTarget([0.3, 0.45, 0.35], [1.0, 0.2, 0.5])
    scene = Scene(robot, start, target, (Ball([0.3, 0.45, 0.35], 0.1, name="ball"),))
    q = configurations(scene, "goal", start).q
    along = (kinematics.forward(robot, q).as_matrix()[:, :3, 3] - target.point) @ target.direction
    assert len(q) >= ENOUGH and len(np.unique(np.round(along, 3))) >= 6
    assert {(a, b) for a, b in np.sign(q[:, [2, 4]])} >= {(-1.0, 1.0), (1.0, -1.0)}  # elbow and wrist on either side


def test_an_easy_goal_takes_one_round():
    robot, target = robots.load("panda"), LineTarget([0.5, 0.0, 0.4], [0.0, 1.0, 0.0])
    scene = Scene(robot, PANDA_START, target)
    first = next(rounds(scene, "goal", PANDA_START))
    assert len(first.q) <= 70 and np.count_nonzero(is_free(robot, first.q, ())) >= ENOUGH == first.enough
    assert missed(robot, target, first.q).max() < 1e-6


@pytest.mark.parametrize("seed", range(4))
def test_places_are_spread_evenly_over_what_the_arm_spans(seed):
    rng, robot = np.random.default_rng(seed), robots.load("panda")
    target = [LineTarget, lambda p, d: PlaneTarget(d, float(d @ p))][seed % 2]
    p, d = rng.uniform(-0.5, 0.5, 3), rng.normal(size=3)
    goal, tool = target(p, d / np.linalg.norm(d)), rng.uniform(-0.5, 0.5, 3)
    places = places_of(robot, goal, tool)
    points = places.spread(0, 4000, 1.0, rng.uniform(size=2))
    near = places.spread(0, 100, 0.25, rng.uniform(size=2))
    for x in (places.first, points, near):
        off = x - p
        gap = np.linalg.norm(np.cross(off, goal.direction), axis=1) if seed % 2 == 0 else np.abs(off @ goal.normal)
        assert gap.max() < 1e-12 and np.linalg.norm(x - places.center, axis=1).max() < places.radius + 1e-12
    assert np.linalg.norm(near - places.first[0], axis=1).max() <= 0.5 * places.radius + 1e-12
    u = (points - places.center) @ places.axes.T / places.radius
    share = np.mean(np.linalg.norm(u, axis=1) < 0.5)  # of a segment or a disc
    assert share == pytest.approx(0.5 ** len(places.axes), abs=0.01) and np.abs(u.mean(axis=0)).max() < 0.01


def test_whole_turns_bring_a_goal_near_the_start():
    robot, rng = robots.load("ur5"), np.random.default_rng(0)
    q = rng.uniform(-np.pi, np.pi, (50, 6))
    near = rng.uniform(robot.limits.lower, robot.limits.upper)
    turned = turned_near(robot, q, near)
    pose, again = kinematics.forward(robot, q).as_matrix(), kinematics.forward(robot, turned).as_matrix()
    np.testing.assert_allclose(again, pose, atol=1e-12)
    assert (turned >= robot.limits.lower).all() and (turned <= robot.limits.upper).all()
    assert (np.abs(turned - near) <= np.abs(q - near) + 1e-12).all() and (turned != q).any()


def test_a_refusal_counts_postures_places_and_what_is_in_the_way():
    robot = robots.load("ur5")
    ceiling = (Box([0.0, 0.0, 1.0], [3.0, 3.0, 0.4], name="ceiling"),)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (2000, 6))
    start = q[is_free(robot, q, ceiling)][0]
    scene = Scene(robot, start, PlaneTarget([0, 0, 1.0], 0.85), ceiling)
    reason = plan(scene).reason
    said = re.search(
        r"best of (\d+) postures within the limits at (\d+) places of the plane: .* of 512 of them: 'ceiling' in the way of (\d+)",
        reason,
    )
    assert said is not None, reason
    postures, places, held = map(int, said.groups())
    assert postures >= places > 1000 and 400 < held <= 512
    assert "move the goal or 'ceiling', or let another options.seed look at other postures" in reason


def test_a_line_beyond_the_span_is_told_at_once():
    robot = robots.load("ur5")
    reason = plan(Scene(robot, np.radians([0, -60, 60, -90, -90, 0]), LineTarget([3.0, 0, 0.3], [0, 0, 1.0]))).reason
    away = float(
        re.fullmatch(
            r"goal: the line is unreachable: ([\d.]+) m from the first joint, and the arm spans at most .*", reason
        )[1]
    )
    assert away == pytest.approx(3.0, abs=1e-3)
