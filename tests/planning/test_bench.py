"""`bench mbm`: the public problem set, and what a table says and writes."""

import csv
import json

import numpy as np
import pytest

from horosphere import robots
from horosphere.errors import InputError
from horosphere.planning import _bench_table, bench_mbm, bench_random
from horosphere.planning._bench_random import ROBOTS, random_problem, with_bodies
from horosphere.planning._bench_table import BenchRow, BenchTable
from horosphere.planning._reactive import react
from horosphere.planning._sampled import clearances, densely, sampled_clearance
from horosphere.planning._tree import connect
from horosphere.robots._pairs import segment_distance
from horosphere.robots._placement import link_frames, move_points
from horosphere.scenes._moveit_files import read_moveit_set
from horosphere.shapes import Ball


@pytest.fixture(scope="module")
def problems(shared_data):
    archive = shared_data / "mbm_panda_problems.tar.bz2"
    if not archive.is_file():
        pytest.skip(f"{archive} is not there")
    return list(read_moveit_set(archive))


@pytest.fixture(scope="module")
def panda(shared_data):
    return robots.load(shared_data / "panda_spheres.urdf", tip="panda_hand")


def judge(panda, chosen, planner, states_per_rad):
    """How many are solved; every path must be certified and clear where it is sampled."""
    solved = 0
    for name, problem in chosen:
        start, goal = problem.start_of(panda), problem.goal_of(panda).q
        result = planner(panda, start, goal, problem.obstacles)
        if not result.solved:
            continue
        solved += 1
        np.testing.assert_array_equal(result.waypoints[[0, -1]], [start, goal])
        clear = sampled_clearance(panda, result.waypoints, problem.obstacles, states_per_rad)
        assert min(clear) >= 0.0, (name, problem.name, clear)
    return solved


def test_a_sample_of_the_public_problems(panda, problems):
    assert judge(panda, problems[3::40], connect, 100) == len(problems[3::40])


def test_the_invalid_problem_is_explained(panda, problems):
    [problem] = [p for s, p in problems if s.startswith("table_pick") and p.name == "scene0041"]
    for planner in (connect, lambda *a: react(*a, time_limit=0.1)):
        result = planner(panda, problem.start_of(panda), problem.goal_of(panda).q, problem.obstacles)
        assert not result.solved and result.reason.startswith("goal: 'panda_hand' is 3.6 mm inside 'Object3'")


def test_the_reactive_law_on_a_sample(panda, problems):
    chosen = problems[5::40]
    assert judge(panda, chosen, lambda *a: react(*a, time_limit=2.0), 100) >= 0.9 * len(chosen)


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_all_public_problems(panda, problems):
    assert judge(panda, problems, connect, 300) == 699


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_all_public_problems_by_the_reactive_law(panda, problems):
    assert judge(panda, problems, lambda *a: react(*a, time_limit=2.0), 300) >= 0.95 * 699


def test_sampled_clearance_by_hand(panda):
    """The base ball of link 0 (centre (0, 0, 0.05), radius 0.08) never moves."""
    path = np.array([[0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]] * 2)
    path[1] += 0.1
    outer, inner = sampled_clearance(panda, path, [Ball([-0.5, 0.0, 0.05], 0.1)], 50)
    assert abs(outer - 0.32) < 1e-12 and inner > 0
    base = Ball([-0.5, 0.0, 0.05], 0.1, name="post")
    allowed = panda.with_allowed(("panda_link0", "post"))
    assert sampled_clearance(allowed, path, [base], 50)[0] > sampled_clearance(panda, path, [base], 50)[0] == outer


def test_bench_runs_and_sums_up(shared_data, problems, tmp_path):
    seen = []
    table = bench_mbm(
        shared_data / "mbm_panda_problems.tar.bz2", only="box", repeats=1, progress=lambda *said: seen.append(said)
    )
    assert seen == [("box_panda", k + 1, 100) for k in range(100)]
    assert all(row.solved and row.is_certified and row.total < row.call for row in table.rows)
    [line] = table.summary()
    assert (line["set"], line["problems"], line["solved"], line["certified"]) == ("box_panda", 100, 100, 100)
    assert 1.0 < line["total_us"][0] < 1e5 and line["touching"] is None
    assert table.solvers() == {"joint-space tree": 100}
    with pytest.raises(InputError, match="unknown kind"):
        table.save(tmp_path / "a.xls")
    with pytest.raises(InputError, match="unknown mode"):
        bench_mbm(shared_data / "mbm_panda_problems.tar.bz2", mode="trees")


def _row(name, solved, total, clear, proved=0.001):
    return BenchRow(
        name, "p", "panda", "joint-space tree", solved, "", total, 2 * total, 0, total, 0, 0, 7, 3.0, 4, 0.0, 0.002,
        proved, clear, 1.0,
    )  # fmt: skip


def test_tables(tmp_path):
    rows = _row("a", True, 1e-4, 0.01), _row("a", True, 3e-4, -0.01, -1e-5), _row("b", False, 0.0, 0.0)
    a, b, whole = (table := BenchTable(rows, 300)).summary()
    assert (a["solved"], a["certified"], a["touching"], a["length"]) == (2, 1, 1, 3.0)
    assert a["total_us"] == pytest.approx((200, 200, 290)) and a["call_us"][0] == pytest.approx(400)
    assert (b["problems"], b["solved"], whole["set"], whole["problems"], whole["solved"]) == (1, 0, "all", 3, 2)
    written = list(csv.DictReader(table.save(tmp_path / "a.csv").open()))
    assert len(written) == 3 and written[0]["set"] == "a" and float(written[1]["total"]) == 3e-4
    saved = json.loads(table.save(tmp_path / "a.json").read_text())
    assert saved["states_per_rad"] == 300 and saved["rows"][2]["solved"] is False


def test_parquet(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    table = BenchTable((_row("a", True, 1e-4, 0.01), _row("b", False, 0.0, 0.0)), 300)
    read = parquet.read_table(table.save(tmp_path / "a.parquet")).to_pylist()
    assert [row["set"] for row in read] == ["a", "b"] and read[0]["total"] == 1e-4 and not read[1]["solved"]
    assert [path.name for path in tmp_path.iterdir()] == ["a.parquet"]


def test_parquet_without_pyarrow_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError) as caught:
        _bench_table.check_format(tmp_path / "a.parquet")
    assert "pyarrow" in caught.value.message and "horosphere[parquet]" in caught.value.remedy


@pytest.mark.parametrize("name", ["panda", "ur5", "iiwa14"])
def test_the_judge_leaves_out_only_what_is_further_away(name):
    """Against every body, every pair and every obstacle, one after the other."""
    robot, seed = robots.load(name), 7
    _, _, obstacles = random_problem(robot, seed)
    q = np.random.default_rng(seed).uniform(-2.5, 2.5, (40, robot.n_joints))
    bodies = robot.capsules
    frames = link_frames(robot.links, q)[:, bodies.link]
    a, b = move_points(frames, bodies.a), move_points(frames, bodies.b)
    points = a + np.linspace(0.0, 1.0, 33)[:, None, None, None] * (b - a)
    outer = np.min([(shape.signed_distance(points) - bodies.radius).min(axis=(0, 2)) for shape in obstacles], axis=0)
    inner = np.full(len(q), np.inf)
    for i, j in robot.self_pairs:
        for m in np.flatnonzero(bodies.link == i):
            for n in np.flatnonzero(bodies.link == j):
                gaps = segment_distance(a[:, m], b[:, m], a[:, n], b[:, n]) - bodies.radius[m] - bodies.radius[n]
                inner = np.minimum(inner, gaps)
    for most in (np.inf, 0.01):
        found = clearances(robot, q, obstacles, most=most)
        for ours, all_of_them in zip(found, (outer, inner), strict=True):
            assert np.abs(ours - np.minimum(all_of_them, most)).max() < 1e-12
    assert (inner < 0.0).any() and (inner > 0.0).any()


@pytest.mark.parametrize("name", ROBOTS)
def test_random_problems_are_solvable_and_not_trivial(name):
    robot, blocked = with_bodies(name), 0
    for seed in range(2):
        start, goal, obstacles = random_problem(robot, seed)
        again = random_problem(robot, seed)
        np.testing.assert_array_equal(np.concatenate([start, goal]), np.concatenate(again[:2]))
        assert len(obstacles) == len(again[2]) > 0
        for q in (start, goal):
            outer, inner = clearances(robot, q[None], obstacles)
            assert outer[0] >= 0.01 and inner[0] > 0.0
        direct = densely(np.array([start, goal]), 20.0)
        outer, inner = clearances(robot, direct, obstacles)
        blocked += outer.min() < 0.0 or inner.min() < 0.0
    assert blocked == 2


@pytest.mark.parametrize("mode", ["tree", "reactive-or-tree"])
def test_random_problems_of_every_robot_are_solved(mode):
    """Robots that nothing was tuned on; the judge is plain numpy and the other certificate."""
    table = bench_random(count=1, seed=100, mode=mode, repeats=1, states_per_rad=60.0, time_limit=5.0)
    assert [line["set"] for line in table.summary()][-1] == "all" and len(table.rows) == len(ROBOTS)
    for row in table.rows:
        assert row.solved and row.is_certified and not row.touches, row
        assert min(row.obstacle_clearance - 0.01, row.self_clearance) >= row.certified_again - 1e-9


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_fifty_random_problems_of_every_robot():
    table = bench_random(count=50, repeats=1, states_per_rad=100.0)
    assert all(row.solved and row.is_certified and not row.touches for row in table.rows)
