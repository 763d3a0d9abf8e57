"""MoveIt scenes on the command line: planned, checked, listed, turned into scenes of ours."""

import json
import tarfile

import numpy as np
import pytest


@pytest.fixture(scope="module")
def files(shared_data, tmp_path_factory):
    """One problem of the public set as files, and the archive itself."""
    archive, robot = shared_data / "mbm_panda_problems.tar.bz2", shared_data / "panda_spheres.urdf"
    if not archive.is_file() or not robot.is_file():
        pytest.skip("the public problem set is not there")
    folder = tmp_path_factory.mktemp("moveit")
    with tarfile.open(archive) as tar:
        for kind in ("scene", "request"):
            member = tar.extractfile(f"problems/cage_panda/{kind}0003.yaml")
            (folder / f"{kind}0003.yaml").write_bytes(member.read())
    return folder, archive, robot


def test_plan_and_check(run, files, tmp_path):
    folder, archive, robot = files
    words = ("--robot", robot, "--no-report", "--time", "0", "--clearance", "0.001", "--json")
    data = json.loads(run("plan", f"{archive}:cage/3", "--out", tmp_path / "a", *words).out)
    assert data["solved"] and data["scene"] == "cage_panda-0003" and data["certificate"]["clearance"] >= 0.001
    assert sum("allowed_collision_matrix" in text for text in data["certificate"]["allowed"]) > 9
    # the same as a file: its request is found beside it
    motion = tmp_path / "a" / "trajectory.npz"
    checked = run("check", folder / "scene0003.yaml", motion, "--robot", robot, "--clearance", "0.001")
    assert checked.code == 0 and checked.out.startswith("Certified: no moving part of the robot"), checked.err
    assert "pairs of links: allowed by the scene's allowed_collision_matrix" in checked.out
    # and as a scene of ours
    mine = tmp_path / "mine.yaml"
    made = run("scenes", f"{archive}:cage_panda/0003", "--robot", robot, "--out", mine)
    assert made.code == 0 and "mine.robot.yaml" in made.out and (tmp_path / "mine.robot.yaml").is_file()
    again = json.loads(run("plan", mine, "--out", tmp_path / "b", *words[2:]).out)
    assert again["solved"] and again["certificate"]["clearance"] == pytest.approx(
        data["certificate"]["clearance"], abs=1e-9
    )
    there = [np.load(tmp_path / name / "trajectory.npz")["q"] for name in ("a", "b")]
    np.testing.assert_allclose(there[0], there[1], atol=1e-9)
    refused = run("scenes", f"{archive}:cage_panda/0003", "--robot", robot, "--out", mine)
    assert refused.code == 2 and "exists already" in refused.err and "--force" in refused.err


def test_listed(run, files):
    _, archive, robot = files
    listed = run("scenes", archive).out
    assert "cage_panda" in listed and "0001 to 0100 (100 problems)" in listed
    problems = json.loads(run("scenes", archive, "--json").out)["problems"]
    assert len(problems) == 700 and problems[0] == "bookshelf_small_panda/0001"
    printed = run("scenes", f"{archive}:{problems[0]}", "--robot", robot).out
    assert printed.startswith(
        "horosphere/scene: 1\nname: bookshelf_small_panda-0001\nrobot: {file: bookshelf_small_panda-0001.robot."
    )


def test_what_is_missing_is_named_as_it_is_typed(run, files, tmp_path):
    folder, archive, robot = files
    for words, message in (
        (("plan", folder / "scene0003.yaml"), "give the model (--robot): a URDF"),
        (("plan", folder / "request0003.yaml", "--robot", robot), "this one is its --request"),
        (("plan", "humanoid-reach", "--robot", robot, "--tip", "x"), "--robot, --tip: for MoveIt scenes"),
        (("scenes", "humanoid-reach", "--srdf", robot), "--srdf: for MoveIt scenes"),
        (("plan", archive, "--robot", robot), "there are 700 problems; valid: bookshelf_small_panda"),
        (("plan", f"{archive}:cge/1", "--robot", robot), "did you mean 'cage_panda'?"),
        (("plan", folder / "scene0003.yaml", "--robot", "ur5"), "no value for 'shoulder_pan_joint'"),
        (("field", folder / "scene0003.yaml"), "not that of a MoveIt scene"),
        (("scenes", tmp_path / "none.tar.gz"), "no such file or folder"),
        (("scenes", tmp_path), "no scene*.yaml in it"),
    ):
        result = run(*words)
        said = [
            line for line in result.err.splitlines() if not line.endswith(" ...")
        ]  # progress, where it took a second
        assert result.code == 2 and message in result.err and len(said) == 1, (words, result.err)
    assert not list(tmp_path.iterdir())


POSE = """
start_state: {joint_state: {name: [panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, panda_joint7],
              position: [0, -0.785, 0, -2.356, 0, 1.571, 0.785]}}
goal_constraints:
  - position_constraints: [{link_name: LINK, constraint_region: {primitive_poses: [{position: [0.45, 0.35, 0.4]}]}}]
    orientation_constraints: [{orientation: [0.96, 0.28, 0, 0]}]
"""
BALL = """
world: {collision_objects: [{id: ball, primitives: [{type: sphere, dimensions: [0.1]}],
                             primitive_poses: [{position: [0.5, 0.1, 0.5]}]}]}
"""


@pytest.mark.parametrize("link", ["panda_hand", "panda_link7"])
def test_a_pose_is_reached_by_the_link_that_is_named(run, tmp_path, link):
    """The built-in Panda ends in a tool 10 cm beyond its hand; the wanted pose is the link's."""
    from horosphere import kinematics, robots

    (tmp_path / "scene_a.yaml").write_text(BALL)
    (tmp_path / "request_a.yaml").write_text(POSE.replace("LINK", link))
    words = ("--robot", "panda", "--no-report", "--time", "0", "--out", tmp_path / "out", "--json")
    data = json.loads(run("plan", tmp_path / "scene_a.yaml", *words).out)
    assert data["solved"], data["reason"]
    panda = robots.load("panda")
    q = np.load(tmp_path / "out" / "trajectory.npz")["q"][-1]
    pose = kinematics.frames(panda, q).as_matrix()[panda.link_names.index(link)]
    np.testing.assert_allclose(pose[:3, 3], [0.45, 0.35, 0.4], atol=1e-6)
    x, y = 0.96, 0.28  # a half turn about (x, y, 0)
    turn = 2.0 * np.outer([x, y, 0.0], [x, y, 0.0]) - np.eye(3)
    np.testing.assert_allclose(pose[:3, :3], turn, atol=1e-6)
