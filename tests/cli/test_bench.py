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
            "--out-file",
            str(rows),
            "--json",
        ]
    )
    (line,) = json.loads(capsys.readouterr().out)["sets"]
    assert code == 1  # one problem of the set has its goal in collision, and says so
    assert (line["problems"], line["solved"]) == (100, 99)
    text = rows.read_text().splitlines()
    assert len(text) == 101 and sum("mm inside" in row for row in text) == 1


def test_a_set_that_is_not_there(capsys, tmp_path):
    assert main(["bench", "mbm", str(tmp_path / "nothing.tar.bz2")]) == 2
    assert "nothing.tar.bz2" in capsys.readouterr().err
