"""Files are complete or not there."""

import json
import threading

import numpy as np
import pytest

from horosphere.errors import InputError
from horosphere.io import output_folder, save_json, save_trajectory, to_json, writing, writing_set
from horosphere.scenes import Trajectory


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, SystemExit])
@pytest.mark.parametrize("before", [None, "old"])
def test_an_interruption_leaves_what_was_there(tmp_path, error, before):
    path = tmp_path / "file.txt"
    if before:
        path.write_text(before)
    with pytest.raises(error), writing(path) as file:
        file.write("half of the new")
        raise error
    assert [p.name for p in tmp_path.iterdir()] == (["file.txt"] if before else [])
    assert not before or path.read_text() == before


@pytest.mark.parametrize("ending", ["npz", "csv", "mcap"])
@pytest.mark.parametrize("moment", ["fsync", "replace"])
def test_interrupted_trajectories(tmp_path, monkeypatch, ending, moment):
    def interrupt(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"horosphere._atomic.os.{moment}", interrupt)
    with pytest.raises(KeyboardInterrupt):
        save_trajectory(Trajectory([0, 1], [[0.0], [1.0]]), tmp_path / f"t.{ending}")
    assert not list(tmp_path.iterdir())


def test_output_folder(tmp_path):
    assert output_folder(tmp_path / "a" / "b").is_dir()
    assert not list((tmp_path / "a" / "b").iterdir())
    (tmp_path / "file").write_text("")
    for bad, words in (
        (tmp_path / "file", "is a file"),
        (tmp_path / "file" / "x", "cannot be made"),
        ("/proc/horosphere", "cannot be made"),
    ):
        with pytest.raises(InputError, match=words):
            output_folder(bad)
    with pytest.raises(InputError, match="cannot be written"), writing(tmp_path / "none" / "x.txt"):
        pass


def test_json_is_strict(tmp_path):
    value = {"a": np.array([1.0, np.nan, np.inf]), "b": np.int64(3), "c": (np.bool_(True), None), "d": tmp_path}
    assert json.loads(to_json(value)) == {"a": [1.0, None, None], "b": 3, "c": [True, None], "d": str(tmp_path)}
    assert json.loads(save_json(Trajectory([0.0], [[1.0]]), tmp_path / "t.json").read_text())["positions"] == [[1.0]]


@pytest.mark.parametrize("before", [(), ("a.txt",), ("a.txt", "b.txt")])
def test_a_set_is_written_whole_or_not_at_all(tmp_path, before):
    """Its last file cannot be put in place, since a folder has that name: what was there stays, and nothing new appears."""
    for name in before:
        (tmp_path / name).write_text("old")
    (tmp_path / "c.txt").mkdir()
    with (
        pytest.raises(InputError, match="cannot be written"),
        writing_set(tmp_path, ("a.txt", "b.txt", "c.txt")) as stage,
    ):
        for name in ("a.txt", "b.txt", "c.txt"):
            (stage / name).write_text("new")
    assert sorted(p.name for p in tmp_path.iterdir()) == [*before, "c.txt"]
    assert all((tmp_path / name).read_text() == "old" for name in before)


def test_two_threads_write_sets_into_one_folder(tmp_path):
    """Both are in their block at the same time."""
    both, failed = threading.Barrier(2, timeout=10.0), []

    def write(name):
        try:
            with writing_set(tmp_path, (name,)) as stage:
                both.wait()
                (stage / name).write_text(name)
                both.wait()
        except Exception as error:
            failed.append(error)
            both.abort()

    threads = [threading.Thread(target=write, args=(name,)) for name in ("a.txt", "b.txt")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed and sorted(p.name for p in tmp_path.iterdir()) == ["a.txt", "b.txt"]
