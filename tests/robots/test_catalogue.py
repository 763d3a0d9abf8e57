"""Built-in robots, robot files, the record itself."""

import json

import numpy as np
import pytest

from horosphere import kinematics, robots
from horosphere.errors import InputError

NAMES = ("humanoid-arm", "iiwa14", "nao-left-arm", "panda", "planar-3r", "srs-arm", "ur5")


def test_the_catalogue():
    assert robots.names() == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_built_in_robots_are_complete(name):
    robot = robots.load(name)
    assert robot.name == name and robot.source and len(robot.capsules) > 0 and len(robot.self_pairs) > 0
    limits = robot.limits
    assert np.isfinite([limits.lower, limits.upper, limits.velocity, limits.acceleration]).all()
    assert (limits.lower < limits.upper).all() and (limits.velocity > 0).all() and (limits.acceleration > 0).all()
    json.dumps(robots.describe(robot))
    for array in (robot.links[1].origin, limits.lower, robot.capsules.a, robot.tool):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


@pytest.mark.parametrize("name", NAMES)
def test_saved_and_loaded_again_to_the_last_bit(name, tmp_path):
    robot = robots.load(name)
    robots.save(robot, tmp_path / "robot.yaml")
    twin = robots.load(tmp_path / "robot.yaml")
    assert twin.content == robot.content and twin.closed_form == robot.closed_form
    assert twin.joint_names == robot.joint_names and twin.link_names == robot.link_names
    for key in ("lower", "upper", "velocity", "acceleration", "effort"):
        assert (getattr(twin.limits, key) == getattr(robot.limits, key)).all()
    for key in ("link", "a", "b", "radius"):
        assert (getattr(twin.capsules, key) == getattr(robot.capsules, key)).all()
    assert (twin.self_pairs == robot.self_pairs).all() and twin.notes == robot.notes
    assert [path.name for path in tmp_path.iterdir()] == ["robot.yaml"]
    with pytest.raises(InputError, match="cannot be written"):
        robots.save(robot, tmp_path / "no such folder" / "robot.yaml")


def test_mimic_joints_survive_saving(tmp_path):
    links = '<link name="a"/><link name="b"/><link name="c"/>'
    joint = '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><axis xyz="0 1 0"/>{}</joint>'
    limit = '<limit lower="-1" upper="1"/>'
    path = tmp_path / "m.urdf"
    path.write_text(
        '<robot name="m">' + links + joint.format("p", "prismatic", "a", "b", limit)
        + joint.format("r", "continuous", "b", "c", '<mimic joint="p" multiplier="3" offset="0.2"/>') + "</robot>"
    )  # fmt: skip
    robot = robots.load(path)
    robots.save(robot, tmp_path / "m.yaml")
    twin = robots.load(tmp_path / "m.yaml")
    assert twin.content == robot.content
    assert kinematics.forward(twin, [0.1]).array == pytest.approx(kinematics.forward(robot, [0.1]).array, abs=0)


def test_arms_made_from_lengths():
    arm = robots.humanoid_arm(0.2, -0.1, 0.3, 0.25, 0.1)
    assert arm.closed_form == ("humanoid_arm", {"d0": 0.2, "h": -0.1, "d1": 0.3, "d2": 0.25, "d3": 0.1})
    assert robots.srs_arm(0.36, 0.42, 0.40, 0.126).closed_form[1]["dew"] == 0.40
    assert robots.six_axis_arm(0.1, 0.3, 0.4, 0.03, 0.5, 0.08).n_joints == 6
    with pytest.raises(InputError, match="height"):
        robots.humanoid_arm(0.1, 0.2)
    for bad in (0.0, -0.1, np.nan, np.inf):
        with pytest.raises(InputError, match="d1"):
            robots.humanoid_arm(d1=bad)
        with pytest.raises(InputError, match="dse"):
            robots.srs_arm(dse=bad)


def test_the_iiwa_of_the_catalogue_is_its_closed_form_arm():
    robot = robots.load("iiwa14")
    arm = robots.srs_arm(**robot.closed_form[1])
    q = np.random.default_rng(0).uniform(-2, 2, (20, 7))
    assert kinematics.forward(robot, q).as_matrix() == pytest.approx(kinematics.forward(arm, q).as_matrix(), abs=1e-14)


def test_built_in_panda_and_nao_stand_as_the_public_descriptions(shared_data):
    rng = np.random.default_rng(1)
    panda, other = robots.load("panda"), robots.load(shared_data / "panda_spheres.urdf", tip="panda_hand")
    q = rng.uniform(-1, 1, (10, 7))
    ours = kinematics.frames(panda, q).as_matrix()[:, panda.tip]
    # that file writes a right angle with twelve digits
    assert ours == pytest.approx(kinematics.forward(other, q).as_matrix(), abs=2e-11)
    nao = robots.load("nao-left-arm")
    other = robots.load(shared_data / "nao.urdf", "torso", "l_gripper", locked={"LHand": 0.0})
    q = rng.uniform(-1, 1, (10, 5))
    assert kinematics.forward(nao, q).as_matrix() == pytest.approx(kinematics.forward(other, q).as_matrix(), abs=1e-12)
    assert nao.limits.lower == pytest.approx(other.limits.lower, abs=1e-4)
    assert nao.limits.upper == pytest.approx(other.limits.upper, abs=1e-4)


GOOD = "horosphere/robot: 1\nname: r\nlinks:\n- {name: a}\n- {name: b, parent: a, type: revolute, axis: [0, 1, 0]}\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("links: []", "horosphere/robot: 1"),
        ("horosphere/robot: 1\nlinks: 3", "list of links"),
        (GOOD.replace("parent: a", "parent: c"), "unknown parent 'c'"),
        (GOOD.replace("revolute", "hinge"), "joint type 'hinge'"),
        (GOOD.replace("name: b", "name: a"), "name of its own"),
        (GOOD.replace("[0, 1, 0]", "[0, 0, 0]"), "zero vector"),
        (GOOD.replace("[0, 1, 0]", "[0, 1]"), "axis"),
        (GOOD.replace("type:", "typ:"), "unknown field 'typ'.*did you mean 'type'"),
        (GOOD + "tip: z", "unknown link for the tip 'z'"),
        (GOOD + "closed_form: {magic: {}}", "magic"),
        (GOOD.replace("axis:", "limits: {lower: 2, upper: 1}, axis:"), "lower limit 2 > upper limit 1"),
        (GOOD.replace("axis:", "limits: {lower: two}, axis:"), "expected a number"),
        (GOOD.replace("axis:", "limits: {velocity: -1}, axis:"), "positive"),
    ],
)
def test_bad_robot_files(tmp_path, text, words):
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=words) as error:
        robots.load(path)
    assert str(path) in str(error.value)


def test_a_robot_is_checked_when_it_is_made():
    good = robots.load("planar-3r")
    base = good.links[0]
    limits = robots.Limits.unlimited(3)
    with pytest.raises(InputError, match="parent"):
        robots.Robot("bad", (base, robots.Link("x", 3, good.tool)), 1, (), robots.Limits.unlimited(0))
    with pytest.raises(InputError, match="joints but"):
        robots.Robot("bad", good.links, 3, ("a", "b"), limits)
    with pytest.raises(InputError, match="tip"):
        robots.Robot("bad", good.links, 9, good.joint_names, limits)
    with pytest.raises(InputError, match="lower"):
        robots.Limits(*np.array([[1.0], [0.0], [1], [1], [1]]))
    with pytest.raises(InputError, match="negative radius"):
        robots.Capsules(np.zeros(1, int), np.zeros((1, 3)), np.zeros((1, 3)), np.array([-1.0]))


@pytest.mark.parametrize("name", ["panda", "humanoid-arm"])
def test_a_robot_file_that_was_cut_off_is_refused(name, tmp_path):
    """At the end of whatever line: it would be a robot with fewer bodies, or with pairs that nobody checks."""
    robot = robots.load(name)
    robots.save(robot, tmp_path / "whole.yaml")
    lines = (tmp_path / "whole.yaml").read_text().splitlines(keepends=True)
    assert f"holds: {{links: {len(robot.links)}, capsules: {len(robot.capsules)}, pairs: " in "".join(lines)
    end = max(k for k, line in enumerate(lines) if line.startswith(("- links:", "- [")))  # where the last pair begins
    seed = len(lines)
    print("seed", seed)
    for cut in [end, *np.random.default_rng(seed).integers(1, end, 12).tolist()]:
        (tmp_path / "cut.yaml").write_text("".join(lines[:cut]))
        with pytest.raises(InputError):
            robots.load(tmp_path / "cut.yaml")
    (tmp_path / "cut.yaml").write_text("".join(lines).replace("capsules: ", "capsules: 9", 1))
    with pytest.raises(InputError, match=r"says that it holds 9.* capsules, it holds .*cut off.*take it out"):
        robots.load(tmp_path / "cut.yaml")


def test_the_middle_of_the_limits():
    inf = np.full(5, np.inf)
    limits = robots.Limits(
        np.array([-1.0, -np.inf, 0.5, -np.inf, 2.0]), np.array([3.0, np.inf, np.inf, -0.5, 2.0]), inf, inf, inf
    )
    assert limits.middle.tolist() == [1.0, 0.0, 0.5, -0.5, 2.0]
