"""`bench mbm`: the public problem set, and what a table says and writes."""

import csv
import json

import numpy as np
import pytest

from horosphere import robots
from horosphere.errors import InputError
from horosphere.planning._bench import BenchRow, BenchTable, bench_mbm, sampled_clearance
from horosphere.planning._reactive import react
from horosphere.planning._tree import connect
from horosphere.scenes._moveit import read_moveit_set
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
    result = connect(panda, problem.start_of(panda), problem.goal_of(panda).q, problem.obstacles)
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


def test_bench_runs_and_sums_up(shared_data, problems, tmp_path):
    seen = []
    table = bench_mbm(
        shared_data / "mbm_panda_problems.tar.bz2", only="box", repeats=1, progress=lambda s, k: seen.append((s, k))
    )
    assert len(table.rows) == 100 == len(seen) and all(row.solved and row.total < row.wall for row in table.rows)
    [line] = table.summary()
    assert line[:3] == ("box_panda", 100, 100) and 1.0 < line[3] < 1e5 and line[-1] == "-"
    with pytest.raises(InputError, match="unknown kind"):
        table.save(tmp_path / "a.xls")


def test_tables(tmp_path):
    def row(name, solved, total, clear):
        return BenchRow(name, "p", solved, "", total, 2 * total, 0, total, 0, 0, 7, 3.0, 4, 0.0, 0.002, clear, 1.0)

    table = BenchTable(
        (row("a", True, 1e-4, 0.01), row("a", True, 3e-4, -0.01), row("b", False, 0.0, 0.0)), "panda", 300
    )
    a, b, whole = table.summary()
    assert a == ("a", 2, 2, pytest.approx(200), pytest.approx(200), pytest.approx(290), pytest.approx(400), 3.0, 1)
    assert b[:3] == ("b", 1, 0) and whole[:3] == ("all", 3, 2)
    rows = list(csv.DictReader(table.save(tmp_path / "a.csv").open()))
    assert len(rows) == 3 and rows[0]["set"] == "a" and float(rows[1]["total"]) == 3e-4
    saved = json.loads(table.save(tmp_path / "a.json").read_text())
    assert saved["robot"] == "panda" and saved["rows"][2]["solved"] is False
    try:
        import pyarrow.parquet
    except ImportError:
        with pytest.raises(InputError, match="pyarrow"):
            table.save(tmp_path / "a.parquet")
    else:
        assert pyarrow.parquet.read_table(table.save(tmp_path / "a.parquet")).num_rows == 3
