"""`horosphere plan` and `check`, from scene to files."""

import dataclasses
import json
import re
import signal
from hashlib import sha256

import numpy as np
import pytest

from horosphere import kinematics
from horosphere.io import load_trajectory, save_trajectory
from horosphere.scenes import Scene, Trajectory


def capsule_distance(a, b, center):
    """Distance of a point from segments a-b (k, 3)."""
    u = b - a
    s = np.clip(np.sum((center - a) * u, axis=1) / np.sum(u * u, axis=1), 0, 1)[:, None]
    return np.linalg.norm(center - a - s * u, axis=1)


def test_humanoid_reach(reach):
    """The motion itself, checked here by plain geometry on a dense sampling."""
    scene, motion = Scene.load("humanoid-reach"), load_trajectory(reach.folder / "trajectory.npz")
    assert reach.data["solved"] and reach.data["certificate"]["certified"]
    assert np.abs(np.diff(motion.positions, axis=0)).max() <= np.radians(5)
    q = motion.at(np.linspace(motion.time[0], motion.time[-1], 5000))
    frames = kinematics.frames(scene.robot, q).as_matrix()
    capsules, ball = scene.robot.capsules, scene.obstacles[0]
    least = np.inf
    for link, a, b, radius in zip(capsules.link, capsules.a, capsules.b, capsules.radius):
        M = frames[:, link]
        ends = [np.einsum("kij,j->ki", M[:, :3, :3], p) + M[:, :3, 3] for p in (a, b)]
        least = min(least, float((capsule_distance(*ends, ball.center) - radius - ball.radius).min()))
    assert least >= 0.014
    assert 0.014 <= reach.data["certificate"]["clearance"] <= least + 1e-9
    tool = kinematics.forward(scene.robot, motion.positions[[0, -1]]).as_matrix()[:, :3, 3]
    np.testing.assert_allclose(tool, [scene.start.position, scene.goal.position], atol=1e-6)


def test_files(reach):
    assert {p.name for p in reach.folder.iterdir()} == {
        "trajectory.npz",
        "trajectory.csv",
        "certificate.json",
        "report.html",
        "more",
    }
    certificate = json.loads((reach.folder / "certificate.json").read_text())
    assert certificate["verdict"] == reach.data["verdict"]
    files = [reach.folder / "trajectory.csv", reach.folder / "trajectory.npz"]
    assert certificate["sha256"] == {file.name: sha256(file.read_bytes()).hexdigest() for file in files}
    npz, table = load_trajectory(reach.folder / "trajectory.npz"), load_trajectory(reach.folder / "trajectory.csv")
    assert np.array_equal(npz.positions, table.positions) and npz.names == table.names
    assert load_trajectory(reach.folder / "more" / "motion.mcap").names == npz.names
    assert "Solved and certified" in (reach.folder / "report.html").read_text()


def test_check_certifies_what_plan_wrote(run, reach, tmp_path):
    result = run("check", "humanoid-reach", reach.folder / "trajectory.csv", "--out", tmp_path)
    assert result.code == 0 and result.out.startswith("Certified: ")
    assert {p.name for p in tmp_path.iterdir()} == {"certificate.json", "report.html"}
    ours, theirs = (json.loads((f / "certificate.json").read_text()) for f in (tmp_path, reach.folder))
    assert ours["certificate"]["clearance"] == theirs["certificate"]["clearance"]
    assert ours["sha256"] == {"trajectory.csv": theirs["sha256"]["trajectory.csv"]}


def test_check_finds_the_collision(run, reach, tmp_path):
    """The same start and goal joined by a straight motion in joint space, and the planned motion through a larger margin."""
    motion = load_trajectory(reach.folder / "trajectory.npz")
    result = run("check", "humanoid-reach", reach.folder / "trajectory.npz", "--clearance", "0.2", "--json")
    data = json.loads(result.out)
    assert result.code == 1 and not data["certified"]
    assert data["certificate"]["first_violation"]
    far = motion.positions[-1] + [0.5, 0, 0, 0, 0]
    save_trajectory(Trajectory([0, 1], [motion.positions[0], far], names=motion.names), tmp_path / "other.npz")
    result = run("check", "humanoid-reach", tmp_path / "other.npz")
    assert result.code == 1 and result.out.startswith("Not certified: ")


def test_check_puts_the_joints_in_order(run, reach, tmp_path):
    motion = load_trajectory(reach.folder / "trajectory.npz")
    order = [3, 0, 4, 1, 2]
    mixed = dataclasses.replace(
        motion,
        names=tuple(motion.names[j] for j in order),
        **{key: getattr(motion, key)[:, order] for key in ("positions", "velocities", "accelerations")},
    )
    assert run("check", "humanoid-reach", save_trajectory(mixed, tmp_path / "mixed.csv")).code == 0


@pytest.mark.parametrize(
    ("positions", "names", "words"),
    [
        (np.zeros((2, 4)), (), "4 columns, but 'humanoid-arm' has 5 joints"),
        (np.zeros((2, 5)), ("joint_1", "joint_2", "joint_3", "joint_4", "j5"), "not those of 'humanoid-arm': j5"),
        (
            np.zeros((2, 5)),
            tuple("abcde"),
            "made for another robot, or names the joints otherwise: it moves a, b, c, d, e, ",
        ),
    ],
)
def test_check_refuses_other_joints(run, tmp_path, positions, names, words):
    path = save_trajectory(Trajectory([0, 1], positions, names=names), tmp_path / "t.csv")
    result = run("check", "humanoid-reach", path)
    assert result.code == 2 and words in result.err and str(path) in result.err


def test_goal_out_of_reach(run, tmp_path):
    text = run("scenes", "humanoid-reach").out.replace(
        "goal: {position: [0.41, 0.07, -0.32]", "goal: {position: [2, 0, 0]"
    )
    (tmp_path / "far.yaml").write_text(text)
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "trajectory.npz").write_bytes(b"of an earlier run")
    result = run("plan", tmp_path / "far.yaml", "--out", folder)
    assert result.code == 1 and result.out.startswith("Not solved: ")
    assert "removed trajectory.npz of an earlier run" in " ".join(result.out.split())
    assert {p.name for p in folder.iterdir()} == {"certificate.json", "report.html"}  # nothing that no longer holds
    assert json.loads((folder / "certificate.json").read_text())["solved"] is False


def test_start_in_collision(run, tmp_path):
    text = run("scenes", "humanoid-reach").out.replace("center: [0.33, 0.03, -0.03]", "center: [0.33, 0.0, 0.31]")
    (tmp_path / "hit.yaml").write_text(text)
    result = run("plan", tmp_path / "hit.yaml", "--out", tmp_path / "out", "--no-report")
    assert result.code == 1 and "start" in result.out.splitlines()[0]


def refuse_to_plan(*arguments, **options):
    raise AssertionError("planning started")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("humanoid-rech",), "did you mean 'humanoid-reach'"),
        (("missing.yaml",), "missing.yaml: cannot be read: No such file"),
        (("humanoid-reach", "--out", "/proc/none"), "/proc/none: cannot be made"),
        (("humanoid-reach", "--out", "/dev/null/x"), "cannot be made"),
        (("humanoid-reach", "--clearance", "-0.1"), "--clearance: input should be greater than or equal to 0"),
        (("humanoid-reach", "--clearance", "nan"), "--clearance: input should be a finite number"),
        (("humanoid-reach", "--save", "x.txt"), "no trajectory format has the ending '.txt'; valid: .npz, .csv, .mcap"),
        (("humanoid-reach", "--methd", "tree"), "Did you mean --method?"),
        (("humanoid-reach", "--method", "best"), "method"),
        ((), "SCENE"),
    ],
)
def test_bad_input_before_planning(run, monkeypatch, tmp_path, words, message):
    import horosphere.planning

    monkeypatch.setattr(horosphere.planning, "plan", refuse_to_plan)
    monkeypatch.chdir(tmp_path)
    result = run("plan", *words)
    assert result.code == 2 and message in result.err and result.out == ""
    as_json = run("plan", *words, "--json")
    assert as_json.code == 2 and json.loads(as_json.out)["errors"]


@pytest.mark.parametrize("moment", ["planning", 1, 2, 3, 4])
@pytest.mark.parametrize("trouble", ["interrupted", "disk full"])
def test_nothing_half_done(run, monkeypatch, tmp_path, moment, trouble):
    """Ctrl-C or a full disk while planning or while the n-th file is written: the earlier results stay, all of them."""
    import errno
    import os

    import horosphere.planning

    count = 0
    real = os.fsync
    earlier = {name: name.encode() for name in ("trajectory.npz", "trajectory.csv", "certificate.json", "report.html")}
    for name, content in earlier.items():
        (tmp_path / name).write_bytes(content)

    def strike(*arguments, **options):
        if trouble == "interrupted":
            signal.raise_signal(signal.SIGINT)
        raise OSError(errno.ENOSPC, "No space left on device")

    def fsync(handle):
        nonlocal count
        count += 1
        if count == moment:
            strike()
        real(handle)

    if moment == "planning":
        if trouble == "disk full":
            pytest.skip("planning writes nothing")
        monkeypatch.setattr(horosphere.planning, "plan", strike)
    monkeypatch.setattr(os, "fsync", fsync)
    result = run("plan", "humanoid-reach", "--out", tmp_path)
    if trouble == "interrupted":
        assert result.code == 130 and "interrupted" in result.err
    else:
        assert result.code == 2 and "No space left on device" in result.err and str(tmp_path) in result.err
        assert ".tmp" not in result.err
    assert result.out == ""
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == earlier


@pytest.mark.parametrize("name", ["panda-table", "nao-reach"])
def test_library_scenes_are_solved(run, tmp_path, name):
    result = run("plan", name, "--out", tmp_path, "--json", "--no-report")
    data = json.loads(result.out)
    assert result.code == 0 and data["solved"], data["verdict"]
    assert data["certificate"]["clearance"] >= data["clearance_required"]


@pytest.mark.parametrize(("name", "urdf"), [("panda-urdf", "panda_spheres.urdf"), ("nao-urdf", "nao.urdf")])
def test_example_scenes_with_urdf(run, shared_data, tmp_path, name, urdf):
    import shutil
    from pathlib import Path

    examples = Path(__file__).parents[2] / "examples" / "scenes"
    for file in examples.glob("*.yaml"):
        shutil.copy(file, tmp_path)
    shutil.copy(shared_data / urdf, tmp_path / f"{name.split('-')[0]}.urdf")
    result = run("plan", tmp_path / f"{name}.yaml", "--out", tmp_path / "out", "--json", "--no-report")
    data = json.loads(result.out)
    assert result.code == 0 and data["solved"], data["verdict"]
    if name == "nao-urdf":
        assert any("5 capsules from the capsule file" in note for note in data["notes"])
        assert any("not found" in note and "mesh" in note for note in data["notes"])


def test_a_trajectory_without_times_is_said_to_have_none(run, tmp_path):
    """Far too fast at one second a waypoint, were these seconds: nothing is checked against them, and that is said."""
    assert run("plan", "humanoid-reach", "--out", tmp_path, "--no-report").code == 0
    q = np.load(tmp_path / "trajectory.npz")["q"]
    np.savez(tmp_path / "bare.npz", q=q)
    result = run("check", "humanoid-reach", tmp_path / "bare.npz")
    assert result.code == 0 and "has no times" in result.out and "one second apart" in result.out
    assert "has no times" not in run("check", "humanoid-reach", tmp_path / "trajectory.npz").out


def test_a_trajectory_in_degrees_is_told(run, reach, tmp_path):
    motion = load_trajectory(reach.folder / "trajectory.npz")
    bare = dataclasses.replace(motion, velocities=None, accelerations=None)
    for q, says in ((np.degrees(bare.positions), True), (bare.positions, False), (100.0 * bare.positions + 9.0, False)):
        file = save_trajectory(dataclasses.replace(bare, positions=q), tmp_path / "t.npz")
        result = run("check", "humanoid-reach", file)
        assert ("taken as degrees" in " ".join(result.out.split())) == says


def test_half_a_cloud_is_never_planned_around(run, tmp_path):
    head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    text = "horosphere/scene: 1\nrobot: {type: point, radius: 0.05, dimension: 3}\nstart: {position: [0, 0, 0]}\n"
    text += "goal: {position: [2, 0, 0]}\nobstacles:\n  - {type: points, file: cloud.ply, radius: 0.1}\n"
    (tmp_path / "s.yaml").write_text(text)
    (tmp_path / "cloud.ply").write_text(head + "1 2 0\n1 -2 0\n")
    result = run("plan", tmp_path / "s.yaml", "--out", tmp_path / "out")
    assert (
        result.code == 2
        and "s.yaml:6:5" in result.err
        and "says 3 vertices, it holds 2" in " ".join(result.err.split())
    )
    assert not (tmp_path / "out").exists()


def test_time_for_improvement_is_an_option(run, tmp_path):
    result = run("plan", "panda-table", "--method", "tree", "--time", "0.2", "--out", tmp_path, "--no-report", "--json")
    said = json.loads(result.out)
    assert result.code == 0 and said["options"]["improvement_time"] == 0.2
    assert said["improvement"]["length"] <= said["improvement"]["first_length"]
    assert run("plan", "panda-table", "--time", "-1", "--out", tmp_path).err.count("--time") == 1


def test_a_configuration_space_is_measured_in_radians(run, tmp_path):
    result = run("plan", "rn-fig6-revolute-arm", "--out", tmp_path, "--no-report")
    assert result.code == 0
    said = result.out.split("note:")[0]
    assert re.search(r"closer than [\d.]+ mrad to any obstacle", said) and "required 10 mrad" in said
    assert not re.search(r"\d (mm|m)\b", said), said
