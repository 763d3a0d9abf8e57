"""The reactive law: its rows against finite differences, its projection against scipy, its paths against dense sampling."""

import numpy as np
import pytest
from scipy.optimize import minimize

from horosphere.errors import InputError
from horosphere.planning import _reactive, _reactive_kernels
from horosphere.planning._reactive import react
from horosphere.planning._tree import Search
from horosphere.planning._tree_space import COVER, Space
from horosphere.robots._placement import link_frames, rotation_translation
from horosphere.shapes import Ball, Box, HalfSpace

from ._dense import along, clearances
from .test_tree import free, furniture, made


def law_for(robot, q, obstacles):
    search = Search(robot, q, q[None], tuple(obstacles), 0.0, 0.0, 0)
    return _reactive._Law(search, Space(search, COVER[0]).pack())


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", ["panda", "gantry"])
def test_rows_are_slopes_of_gaps(name, seed):
    robot, rng = made(name), np.random.default_rng(seed)
    low, high = np.clip(robot.limits.lower, -2, 2), np.clip(robot.limits.upper, -2, 2)
    obstacles = furniture(rng, 5)
    q = free(robot, rng, obstacles, 0.0, low, high)
    law = law_for(robot, q, obstacles)
    space, sight = law.space, 0.6
    arrays = law.room, space.packet

    def look(q):
        count = _reactive_kernels.near_rows(space.scaled(q), sight, 0.05, *arrays)
        return law.room[2][:count].astype(float), law.room[3][:count].copy()

    rows, gaps = look(q)
    assert len(rows) > 3 and (gaps < sight).all()
    outer, inner = clearances(robot, q[None], obstacles)
    seen = min(outer[0], inner[0] if inner[0] < 0.05 else np.inf)
    assert abs(gaps.min() - seen) < 4e-3  # capsules: the cover stands out, and the check has gaps
    slopes = np.zeros_like(rows)
    for j in range(robot.n_joints):
        step = np.zeros(robot.n_joints)
        step[j] = 2e-3 / space.model.weight[j]
        ahead, back = look(q + step)[1], look(q - step)[1]
        if len(ahead) != len(gaps) or len(back) != len(gaps):
            pytest.skip("something came into sight or left it within the step")
        slopes[:, j] = (ahead - back) / 4e-3
    smooth = np.abs(slopes - rows).max(axis=1) < 0.02  # where the nearest ball changes, the gap has a kink
    assert smooth.mean() > 0.8


@pytest.mark.parametrize("seed", range(5))
def test_projection_is_the_nearest_admissible_motion(seed):
    rng = np.random.default_rng(seed)
    robot = made("panda")
    law = law_for(robot, np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]), [])
    rows, gaps = rng.normal(size=(6, 7)) * 0.4, rng.uniform(0.01, 0.08, 6)
    law.room[2][:6], law.room[3][:6] = rows, gaps
    wish = rng.normal(size=7) * 0.1
    u = np.float32(wish)
    _reactive_kernels.project(u, 6, 0.8, 0.002, 2000, law.room)
    bound = -0.8 * (gaps - 0.002)
    constraint = {"type": "ineq", "fun": lambda x: rows @ x - bound, "jac": lambda x: rows}
    exact = minimize(lambda x: ((x - wish) ** 2).sum(), wish, constraints=constraint, options={"ftol": 1e-14}).x
    assert (rows @ u >= bound - 1e-4).all()
    np.testing.assert_allclose(u, exact, atol=1e-3)


@pytest.mark.parametrize("name", ["panda", "ur5", "iiwa14", "srs-arm"])
def test_paths_keep_the_clearance(name):
    robot, rng = made(name), np.random.default_rng(1)
    low, high = np.clip(robot.limits.lower, -np.pi, np.pi), np.clip(robot.limits.upper, -np.pi, np.pi)
    obstacles = [*furniture(rng, 4), HalfSpace([0, 0, 1], -0.7)]
    solved = 0
    for _ in range(4):
        start, goal = (free(robot, rng, obstacles, 0.005, low, high) for _ in range(2))
        result = react(robot, start, goal, obstacles, clearance=0.005, time_limit=1.0)
        if result.solved:
            solved += 1
            np.testing.assert_array_equal(result.waypoints[[0, -1]], [start, goal])
            outer, inner = clearances(robot, along(result.waypoints, 40), obstacles)
            assert outer.min() >= 0.005 and inner.min() >= 0.0
    assert solved >= 2


def test_the_law_alone_goes_round_a_ball_and_says_when_it_is_stuck():
    robot = made("panda")
    start = np.array([0.6, 0.3, 0.0, -1.9, 0.0, 2.2, 0.0])
    goal = start * [-1, 1, 1, 1, 1, 1, 1]
    middle = start * [0, 1, 1, 1, 1, 1, 1]
    hand = rotation_translation(link_frames(robot.links, middle)[robot.tip])[1]
    ball = Ball(hand + 0.13 * np.array([1.0, 0.0, 0.3]), 0.07)  # in the way of the hand, with room towards the base
    assert clearances(robot, middle[None], [ball])[0][0] < 0.0
    around = react(robot, start, goal, [ball], vias=0)
    assert around.solved and len(around.waypoints) > 3
    wall = [Box([0.8, 0.0, 0.7], [0.5, 0.02, 0.7])]
    stuck = react(robot, start, goal, wall, vias=0)
    assert not stuck.solved and "stuck" in stuck.reason
    with pytest.raises(InputError, match="start"):
        react(robot, start[:3], goal)
