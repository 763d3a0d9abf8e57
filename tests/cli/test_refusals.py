"""What a command cannot do is one line that says what would be right, before anything is computed or written."""

import tarfile

import pytest


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("plan", "humanoid-reach", "--seed", "1.5"), "--seed: expected a whole number, got '1.5'"),
        (("robot", "panda", "--budget", "1e1"), "--budget: expected a whole number"),
        (("snake", "growth", "--links", "7.0"), "--links: expected a whole number"),
        (("plan", "humanoid-reach", "again"), "not understood: 'again' (`horosphere plan --help`"),
        (("desk.yaml",), "A scene is planned with `horosphere plan desk.yaml`. Available commands: plan, check,"),
        (("paln",), "scenes, warmup, snake, bench."),
        (("bench", "foo"), "Available commands: mbm, random."),
        (("bench", "mbm"), "parameter PATH requires an argument"),
        (("bench", "random", "ur5", "--count", "0"), "--count: expected at least 1, got 0"),
        (("bench", "random", "ur5", "--repeats", "0"), "--repeats: expected at least 1, got 0"),
        (("bench", "random", "ur5", "--states-per-rad", "nan"), "--states-per-rad: expected a number at least 0"),
        (("scenes", "--out", "x.yaml"), "--out: which scene? --out writes one; valid: field-humanoid-fig3"),
        (("show", "humanoid-reach", "--seconds", "0"), "--seconds: expected seconds > 0"),
        (("robot", "panda", "--view", "model.pdf"), "model.pdf: no page has the ending '.pdf'; valid: .html, .htm"),
        (("robot", "panda", "--scene", "first.txt"), "first.txt: no scene has the ending '.txt'; valid: .yaml, .yml"),
        (("robot", "panda", "--scene", "x.yaml", "--out", "x.yaml"), "the robot and the scene cannot be one file"),
        (("plan", "humanoid-reach", "--robot", "panda"), "error: humanoid-reach: --robot: for MoveIt scenes"),
    ],
)
def test_one_line(run, words, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(*words)
    assert result.code == 2 and result.out == "" and result.err.count("error:") == 1
    assert said in " ".join(result.err.split())
    assert not any(tmp_path.iterdir())


@pytest.fixture
def archive(tmp_path):
    """Two sets of one problem each; nothing reads what is in them."""
    for name in ("box", "cage"):
        folder = tmp_path / "problems" / name
        folder.mkdir(parents=True)
        (folder / "scene0001.yaml").write_text("name: x\nworld: {collision_objects: []}\n")
        (folder / "request0001.yaml").write_text("{}\n")
    with tarfile.open(tmp_path / "problems.tar.gz", "w:gz") as tar:
        tar.add(tmp_path / "problems", "problems")
    return tmp_path / "problems.tar.gz"


def test_an_archive_is_no_scene(run, archive, tmp_path):
    result = run("scenes", archive, "--out", tmp_path / "x.yaml")
    said = " ".join(result.err.split())
    assert result.code == 2 and "holds 2 scenes, and --out writes one" in said
    assert f"horosphere scenes {archive}:box/0001 --robot URDF --out" in said
    assert not (tmp_path / "x.yaml").exists()
    assert run("scenes", archive).code == 0


def test_sets_that_are_not_there(run, archive):
    result = run("bench", "mbm", archive, "--only", "shelf")
    assert result.code == 2 and "--only: no set begins with 'shelf'; valid: box, cage" in " ".join(result.err.split())


def test_a_robot_is_no_scene(run, tmp_path):
    model = tmp_path / "arm.yaml"
    assert run("robot", "planar-3r", "--out", model).code == 0
    (tmp_path / "arm.urdf").write_text("<robot/>")
    for file in (model, tmp_path / "arm.urdf"):
        result = run("plan", file)
        assert result.code == 2 and result.err.count("error:") == 1
        assert "a robot, expected a scene (`horosphere robot FILE --scene first.yaml`" in " ".join(result.err.split())


def test_a_first_scene_is_for_the_model_that_was_written(run, tmp_path):
    """And what its user changed in it is not written over."""
    model, scene = tmp_path / "models" / "arm.yaml", tmp_path / "desk.yaml"
    words = ("robot", "planar-3r", "--link-radius", "0.05", "--scene", scene)
    assert run(*words, "--out", model).code == 0
    assert "robot: {file: models/arm.yaml}" in scene.read_text()
    planned = run("plan", scene, "--out", tmp_path / "out", "--no-report", "--time", "0")
    assert planned.code == 0 and "Solved and certified" in planned.out
    scene.write_text("mine")
    refused = run(*words)
    assert refused.code == 2 and "exists already (another name, or --force)" in refused.err
    assert scene.read_text() == "mine"
    assert run(*words, "--force", "--out", tmp_path / "arm.urdf").code == 0  # a URDF loses pairs: not the model
    assert "name: planar-3r" in scene.read_text()
