"""`horosphere bench mbm` on one set of the public problems."""

import json

from horosphere.cli._app import main


def test_a_set_is_run_and_tabled(shared_data, capsys, tmp_path):
    archive = shared_data / "mbm_panda_problems.tar.bz2"
    rows = tmp_path / "rows.csv"
    code = main(
        [
            "bench",
            "mbm",
            str(archive),
            "--only",
            "table_pick_panda",
            "--repeats",
            "1",
            "--states-per-rad",
            "0",
            "--out",
            str(rows),
            "--json",
        ]
    )
    said = json.loads(capsys.readouterr().out)
    (line,) = said["sets"]
    assert code == 1  # one problem of the set has its goal in collision, and says so
    assert (line["problems"], line["solved"], line["certified"], line["touching"]) == (100, 99, 99, None)
    assert [item["problem"] for item in said["not_solved"]] == ["table_pick_panda scene0041"]
    text = rows.read_text().splitlines()
    assert len(text) == 101 and sum("mm inside" in row for row in text) == 1


def test_a_set_that_is_not_there(capsys, tmp_path):
    assert main(["bench", "mbm", str(tmp_path / "nothing.tar.bz2")]) == 2
    assert "nothing.tar.bz2" in capsys.readouterr().err


def test_random_prints_a_table(capsys, tmp_path):
    assert main(["bench", "random", "planar-3r", "--count", "2", "--repeats", "1", "--states-per-rad", "50"]) == 0
    text = capsys.readouterr().out
    assert "planar-3r" in text and "median / mean / p95" in text and "joint-space tree: 2" in text


def test_where_nothing_can_be_written_is_said_first(capsys, tmp_path):
    assert main(["bench", "random", "--out", str(tmp_path / "no" / "rows.csv")]) == 2
    assert "rows.csv" in capsys.readouterr().err
