"""`horosphere bench mbm` on one set of the public problems."""

import json

import pytest

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


def test_the_robot_that_is_taken_for_want_of_the_sets_own_is_named(shared_data, capsys, tmp_path):
    (tmp_path / "set.tar.bz2").symlink_to(shared_data / "mbm_panda_problems.tar.bz2")
    arguments = ["bench", "mbm", str(tmp_path / "set.tar.bz2"), "--repeats", "1", "--states-per-rad", "0"]
    assert main([*arguments, "--only", "cage"]) == 1
    said = capsys.readouterr().out
    assert "no panda_spheres.urdf beside the set" in said and "more; --json or --out names all" in said


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


ARM = "".join(
    f'<link name="{name}"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.04 0.04 0.2"/></geometry></collision></link>'
    for name in ("base", "upper", "lower", "hand", "camera")
) + "".join(
    f'<joint name="to_{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 0.25"/>'
    f'<axis xyz="{axis}"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
    for parent, child, kind, axis in (
        ("base", "upper", "revolute", "0 1 0"),
        ("upper", "lower", "revolute", "0 1 0"),
        ("lower", "hand", "revolute", "1 0 0"),
        ("upper", "camera", "fixed", "1 0 0"),
    )
)


def test_random_reads_a_urdf_as_the_robot_command_does(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{ARM}</robot>')
    words = ["bench", "random", "arm.urdf", "--count", "2", "--repeats", "1", "--states-per-rad", "50", "--json"]
    assert main([*words, "--tip", "hand", "--budget", "2"]) == 0
    data = json.loads(capsys.readouterr().out)
    (line,) = data["sets"]
    assert data["robots"] == ["arm"] and (line["problems"], line["certified"], line["touching"]) == (2, 2, 0)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["arm.urdf"], "the tree has 2 ends: hand (3 joints), camera (1 joint)"),
        (["arm.urdf"], "name one of them (--tip)"),
        (["arm.urdf", "--tip", "hnad"], "unknown link for the tip 'hnad'"),
        (["arm.urdf", "--tip", "hand", "--budget", "0"], "--budget: expected a number of bodies >= 1, got 0"),
        (["arm.urdf", "--tip", "hand", "--srdf", "no.srdf"], "no.srdf"),
        (["ur5", "--tip", "hand"], "base, tip, locked, srdf and group are for URDF files"),
    ],
)
def test_what_is_wrong_with_a_robot_is_said_as_elsewhere(words, says, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{ARM}</robot>')
    assert main(["bench", "random", *words]) == 2
    told = capsys.readouterr().err
    assert main(["robot", *words]) == 2
    assert says in told and capsys.readouterr().err == told


def test_the_options_of_a_robot_file_are_the_same_everywhere(capsys):
    told = []
    for words in (["robot"], ["bench", "random"]):
        assert main([*words, "--help"]) == 0
        told.append(" ".join(capsys.readouterr().out.split()))
    for option in ("--base", "--tip", "--capsules", "--link-radius", "--srdf", "--group", "--collision", "--budget"):
        assert all(option in text for text in told), option
    assert all("Last link of the chain (URDF)" in text for text in told)


def test_times_stand_on_one_line_each(capsys):
    """Also where they have four digits and the names of the sets are long."""
    from rich.table import Table

    from horosphere.cli import _output

    table = Table(box=None, padding=(0, 2, 0, 0))
    for name in ("set", *"abcde"):
        table.add_column(name, no_wrap=True)
    table.add_row("table_under_pick_panda", *["1111 / 2222 / 33333"] * 5)
    _output.print_table(table, wide=True)
    assert capsys.readouterr().out.splitlines()[1].split("  ") == [
        "table_under_pick_panda",
        *["1111 / 2222 / 33333"] * 5,
    ]
