"""Sweeps: nothing that one problem does disturbs another, nothing that was found is lost."""

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from horosphere import sweeps
from horosphere.errors import InputError

SCENE = """horosphere/scene: 1
robot: {{type: point, radius: 0.05, dimension: 3}}
start: {{position: [0, 0, {0}]}}
goal: {{position: [1, 0, 0]}}
obstacles:
  - {{type: {1}}}
"""
BALL = "sphere, center: [0.5, 0.01, 0], radius: 0.1"


@pytest.fixture
def folder(tmp_path):
    """Six scenes: four good ones, one whose goal is in a ball, one that is no scene."""
    scenes = tmp_path / "scenes"
    scenes.mkdir()
    for k in range(4):
        (scenes / f"good{k}.yaml").write_text(SCENE.format(0.01 * k, BALL))
    (scenes / "blocked.yaml").write_text(SCENE.format(0, "sphere, center: [1, 0, 0], radius: 0.1"))
    (scenes / "malformed.yaml").write_text("horosphere/scene: 1\nrobot: pnada\n")
    return scenes


def by_name(found):
    return {Path(row["problem"]).stem: row for row in found.rows}


def test_a_table_of_everything_and_its_file(folder, tmp_path):
    found = sweeps.sweep([folder, "rn-fig1-basic"], tmp_path / "out", workers=2, trajectories=True)
    rows = by_name(found)
    assert (
        found.counts == {"solved": 5, "not solved": 1, "bad input": 1} and not found.all_solved and found.resumed == 0
    )
    for k in range(4):
        row = rows[f"good{k}"]
        assert row["certified"] and row["clearance"] >= row["required"] and row["reason"] == ""
    assert "in collision" in rows["blocked"]["reason"] or "goal" in rows["blocked"]["reason"]
    assert "malformed.yaml:2:8" in rows["malformed"]["reason"] and "pnada" in rows["malformed"]["reason"]
    with open(tmp_path / "out" / "sweep.csv", newline="") as file:
        table = list(csv.DictReader(file))
    assert [row["problem"] for row in table] == [row["problem"] for row in found.rows] and len(table) == 7
    assert len(list((tmp_path / "out" / "trajectories").glob("*.npz"))) == 5
    again = sweeps.sweep([folder, "rn-fig1-basic"], tmp_path / "out", workers=2)
    assert again.resumed == 7 and again.rows == found.rows


def test_parquet_says_the_same(folder, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="needs the extra `parquet`")
    found = sweeps.sweep([folder / "good0.yaml", folder / "malformed.yaml"], tmp_path / "out", workers=1)
    assert parquet.read_table(tmp_path / "out" / "sweep.parquet").to_pylist() == list(found.rows)


def test_without_pyarrow_there_is_a_table_and_a_hint(folder, tmp_path, run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    result = run("sweep", folder / "good0.yaml", "--out", tmp_path / "out", "--json")
    data = json.loads(result.out)
    assert result.code == 0 and "horosphere[parquet]" in data["hints"][0]
    assert {p.name for p in (tmp_path / "out").iterdir()} == {"manifest.json", "shards", "sweep.csv"}


POISON = """import os, time
from horosphere.scenes import Scene
real = Scene.load
def load(path):
    if "poison" in os.path.basename(str(path)):
        os.abort()
    if "hangs" in os.path.basename(str(path)):
        time.sleep(1000)
    return real(path)
Scene.load = staticmethod(load)
"""


@pytest.fixture
def poisoned(tmp_path, monkeypatch):
    """Every worker that starts now dies of scenes called poison and sleeps over scenes called hangs."""
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "sitecustomize.py").write_text(POISON)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "site"))
    yield
    monkeypatch.delenv("PYTHONPATH", raising=False)


def test_a_problem_that_kills_its_process_is_named_and_alone(folder, tmp_path, monkeypatch, poisoned):
    (folder / "good1-poison.yaml").write_text(SCENE.format(0.5, BALL))
    found = sweeps.sweep([folder], tmp_path / "out", workers=2)
    rows = by_name(found)
    assert found.counts == {"solved": 4, "not solved": 1, "bad input": 1, "crashed": 1}
    assert rows["good1-poison"]["status"] == "crashed" and "SIGABRT" in rows["good1-poison"]["reason"]
    monkeypatch.delenv("PYTHONPATH")
    assert sweeps.sweep([folder], tmp_path / "out", workers=1).resumed == 7  # known as crashed
    retried = sweeps.sweep([folder], tmp_path / "out", workers=1, retry=True)
    assert retried.resumed == 6 and by_name(retried)["good1-poison"]["status"] == "solved"


def test_a_problem_that_hangs_is_given_up(folder, tmp_path, poisoned):
    (folder / "hangs.yaml").write_text(SCENE.format(0.5, BALL))
    started = time.monotonic()
    found = sweeps.sweep([folder], tmp_path / "out", workers=2, timeout=4.0)
    assert found.counts == {"solved": 4, "not solved": 1, "bad input": 1, "timed out": 1}
    assert by_name(found)["hangs"]["reason"] == "still at it after 4 s" and time.monotonic() - started < 60


def test_goes_on_after_an_interruption(folder, tmp_path, monkeypatch, poisoned):
    (folder / "hangs.yaml").write_text(SCENE.format(0.5, BALL))
    words = [sys.executable, "-m", "horosphere", "sweep", str(folder), "--out", str(tmp_path / "out"), "--workers", "2"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    shards, deadline = tmp_path / "out" / "shards", time.monotonic() + 60
    while not list(shards.glob("*.jsonl")) and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert process.returncode == 130 and "goes on" in err and out == ""
    known = [json.loads(line) for path in shards.glob("*.jsonl") for line in path.read_text().splitlines()]
    assert 1 <= len(known) <= 6 and not list(shards.glob("*.tmp")) and not (tmp_path / "out" / "sweep.csv").exists()
    monkeypatch.delenv("PYTHONPATH")
    found = sweeps.sweep([folder], tmp_path / "out", workers=2)
    assert found.resumed == len(known) and found.counts == {"solved": 5, "not solved": 1, "bad input": 1}


def test_a_changed_scene_is_solved_anew_and_others_are_not(folder, tmp_path):
    sweeps.sweep([folder], tmp_path / "out", workers=1)
    (folder / "malformed.yaml").write_text(SCENE.format(0.2, BALL))
    (folder / "new.yaml").write_text(SCENE.format(0.3, BALL))
    (folder / "good0.yaml").unlink()
    found = sweeps.sweep([folder], tmp_path / "out", workers=1)
    assert found.resumed == 4 and found.counts == {"solved": 5, "not solved": 1}
    plain, wider = (sweeps.expand([folder], options=options) for options in ({}, {"clearance": 0.02}))
    assert not {p.key for p in plain} & {p.key for p in wider}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "expected at least one scene"),
        (("nothing.yaml",), "nothing.yaml: no such file"),
        (("humanoid-rech",), "did you mean 'humanoid-reach'"),
        (("humanoid-reach", "--workers", "0"), "--workers: expected at least one"),
        (("humanoid-reach", "--seeds", "0"), "--seeds: expected at least one"),
        (("humanoid-reach", "--timeout", "nan"), "--timeout: expected"),
        (("humanoid-reach", "--clearance", "-1"), "--clearance: input should be"),
        (("humanoid-reach", "--out", "/dev/null/x"), "cannot be made"),
    ],
)
def test_bad_input(run, words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("sweep", *words)
    assert result.code == 2 and message in result.err and not list(tmp_path.iterdir())


def test_a_shard_of_something_else(folder, tmp_path):
    (tmp_path / "out" / "shards").mkdir(parents=True)
    (tmp_path / "out" / "shards" / "00000.jsonl").write_text("{}\n")
    with pytest.raises(InputError, match=r"00000\.jsonl: not a shard"):
        sweeps.sweep([folder], tmp_path / "out")


def test_a_cluster_needs_its_extra_and_an_answer(run, tmp_path, monkeypatch):
    words = ("sweep", "rn-fig1-basic", "--scheduler", "tcp://127.0.0.1:9", "--out", tmp_path / "out")
    monkeypatch.setitem(sys.modules, "distributed", None)
    result = run(*words)
    assert result.code == 2 and "horosphere[cluster]" in result.err


@pytest.mark.slow
def test_on_a_dask_cluster(folder, tmp_path, poisoned):
    distributed = pytest.importorskip("distributed", reason="needs the extra `cluster`")
    (folder / "good1-poison.yaml").write_text(SCENE.format(0.5, BALL))
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        found = sweeps.sweep([folder], tmp_path / "out", scheduler=cluster.scheduler_address, seeds=5)
    assert found.counts == {"solved": 20, "not solved": 5, "bad input": 5, "crashed": 5}
