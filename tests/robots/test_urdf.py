"""URDF files: what is read, and what is refused with the line and the element."""

import pickle
import re

import numpy as np
import pytest

from horosphere import kinematics, robots
from horosphere.errors import InputError

LIMIT = '<limit lower="-1" upper="1" velocity="2" effort="3"/>'


def joint(name, kind, parent, child, inner=LIMIT):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>{inner}</joint>'
    )


def write(tmp_path, body, name="robot.urdf"):
    path = tmp_path / name
    path.write_text(f'<?xml version="1.0"?>\n<robot name="test">\n{body}\n</robot>\n')
    return path


def links(*names):
    return "\n".join(f'<link name="{name}"/>' for name in names)


def test_chain_limits_and_joint_types(tmp_path):
    body = links("a", "b", "c", "d", "e") + "".join(
        [
            joint("turn", "revolute", "a", "b"),
            joint("spin", "continuous", "b", "c", '<limit velocity="4" effort="0"/>'),
            joint("push", "prismatic", "c", "d", '<limit lower="0" upper="0.3" velocity="0" effort="7"/>'),
            joint("stuck", "fixed", "d", "e", ""),
        ]
    )
    robot = robots.load(write(tmp_path, body))
    assert robot.joint_names == ("turn", "spin", "push") and robot.link_names == ("a", "b", "c", "d", "e")
    assert [link.kind for link in robot.links] == ["fixed", "revolute", "revolute", "prismatic", "fixed"]
    assert robot.limits.lower.tolist() == [-1, -np.inf, 0] and robot.limits.upper.tolist() == [1, np.inf, 0.3]
    assert robot.limits.velocity.tolist() == [2, 4, np.inf] and robot.limits.effort.tolist() == [3, np.inf, 7]
    assert np.isinf(robot.limits.acceleration).all()
    assert [row["type"] for row in robots.describe(robot)["joints"]] == ["revolute", "continuous", "prismatic"]
    shorter = robots.load(write(tmp_path, body), base="b", tip="d")
    assert shorter.joint_names == ("spin", "push") and "left out: a" in " ".join(shorter.notes)


def test_soft_limits_are_respected_where_they_are_given(tmp_path):
    safety = '<safety_controller k_velocity="1" {}/>'
    for attributes, expected in [
        ('soft_lower_limit="-0.5" soft_upper_limit="0.8"', (-0.5, 0.8)),
        ('soft_lower_limit="-3" soft_upper_limit="3"', (-1, 1)),
        ("", (-1, 1)),
    ]:
        body = links("a", "b") + joint("j", "revolute", "a", "b", LIMIT + safety.format(attributes))
        robot = robots.load(write(tmp_path, body))
        assert (robot.limits.lower[0], robot.limits.upper[0]) == expected
        assert any("soft limits" in note for note in robot.notes) == (expected != (-1, 1))
    bad = LIMIT + safety.format('soft_lower_limit="2" soft_upper_limit="3"')
    with pytest.raises(InputError, match="soft limits"):
        robots.load(write(tmp_path, links("a", "b") + joint("j", "revolute", "a", "b", bad)))


def test_mimic_joints_share_the_coordinate_and_tighten_its_limits(tmp_path):
    mimic = '<mimic joint="m" multiplier="-2" offset="0.5"/>'
    body = (
        links("a", "b", "c", "f") + joint("m", "revolute", "a", "b") + joint("s", "revolute", "b", "c", LIMIT + mimic)
    )
    body += joint("beside", "revolute", "a", "f", LIMIT + mimic)
    robot = robots.load(write(tmp_path, body), tip="c")
    assert robot.joint_names == ("m",)
    # -1 <= -2 q + 0.5 <= 1
    assert (robot.limits.lower[0], robot.limits.upper[0]) == (-0.25, 0.75) and robot.limits.velocity[0] == 1
    assert any("mimics" in note for note in robot.notes)
    frames = kinematics.frames(robot, [0.3]).as_matrix()
    for name, value in (("c", 0.3 - 0.1), ("f", -0.1)):
        frame = frames[robot.link_names.index(name)]
        assert frame[0, 2] == pytest.approx(np.sin(value), abs=1e-15)  # turned about y


def test_joints_beside_the_chain_are_locked_within_their_limits(tmp_path):
    away = '<limit lower="0.2" upper="0.9" velocity="1" effort="1"/>'
    body = links("a", "b", "f1", "f2") + joint("m", "revolute", "a", "b") + joint("grip", "revolute", "b", "f1", away)
    body += joint("twin", "revolute", "b", "f2", away + '<mimic joint="grip" multiplier="2"/>')
    robot = robots.load(write(tmp_path, body), tip="b")
    assert robot.joint_names == ("m",) and "grip = 0.2, twin = 0.4" in " ".join(robot.notes)
    frames = kinematics.frames(robot, [0.0]).as_matrix()
    assert frames[2, 0, 2] == pytest.approx(np.sin(0.2)) and frames[3, 0, 2] == pytest.approx(np.sin(0.4))
    held = robots.load(write(tmp_path, body), tip="f1", locked={"m": 0.4})
    assert held.joint_names == ("grip",)
    assert kinematics.frames(held, [0.3]).as_matrix()[1, 0, 2] == pytest.approx(np.sin(0.4))
    with pytest.raises(InputError, match=r"grip"):
        robots.load(write(tmp_path, body), tip="b", locked={"gripp": 0.0})


def test_a_mimic_of_nothing_beside_the_chain_is_locked_and_told(tmp_path):
    body = links("a", "b", "f") + joint("m", "revolute", "a", "b")
    body += joint("finger", "revolute", "b", "f", LIMIT + '<mimic joint="gone" offset="0.7"/>')
    robot = robots.load(write(tmp_path, body), tip="b")
    assert robot.joint_names == ("m",)
    assert "locked, since they mimic joints that the file does not have: finger (gone)" in " ".join(robot.notes)
    assert kinematics.frames(robot, [0.3]).as_matrix()[2, 0, 2] == pytest.approx(np.sin(0.3))  # finger at 0
    with pytest.raises(InputError, match=r"finger.*unknown joint 'gone'") as caught:
        robots.load(write(tmp_path, body), tip="f")
    assert "drop its <mimic>" in caught.value.remedy


def test_what_other_programs_put_into_a_urdf_does_no_harm(tmp_path):
    """Prefixes that are not declared (drake:acceleration), and elements of others in a link that have our names."""
    limit = LIMIT.replace("<limit", '<limit drake:acceleration="3"')
    body = '<link name="a"><checking><capsule name="x"/><geometry/></checking></link>' + links("b")
    body += joint("m", "revolute", "a", "b", limit) + '<drake:joint name="m"><drake:rotor value="1"/></drake:joint>'
    assert robots.load(write(tmp_path, body)).joint_names == ("m",)
    with pytest.raises(InputError, match="xacro that is not expanded, first <xacro:macro>"):
        robots.load(write(tmp_path, body + '<xacro:macro name="x"/>'))
    with pytest.raises(InputError, match="not well-formed XML"):
        robots.load(write(tmp_path, body + "<link>"))


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (links("a", "b") + joint("j", "revolute", "a", "b", '<limit lower="1" upper="-1"/>'), "lower limit 1 > upper"),
        (links("a", "b") + joint("j", "revolute", "a", "b", '<limit lower="nan" upper="1"/>'), "lower='nan'"),
        (links("a", "b") + joint("j", "revolute", "a", "b", '<limit lower="one" upper="1"/>'), "lower='one'"),
        (links("a", "b") + joint("j", "revolute", "a", "b", ""), "needs <limit>"),
        (links("a", "b") + joint("j", "hinge", "a", "b"), "joint type 'hinge'.*revolute"),
        (links("a", "b") + joint("j", "floating", "a", "b", ""), "floating joints cannot"),
        (links("a", "b") + joint("j", "revolute", "a", "c"), "child link 'c' is not defined"),
        (links("a", "b", "b"), "link 'b' is defined twice"),
        (links("a", "b", "c") + joint("j", "revolute", "a", "c") + joint("k", "revolute", "b", "c"), "two parents"),
        (links("a", "b", "c") + joint("j", "revolute", "b", "c") + joint("k", "revolute", "c", "b"), "own ancestor"),
        (links("a", "b") + joint("j", "revolute", "a", "b", LIMIT + '<mimic joint="x"/>'), "unknown joint 'x'"),
        (links("a", "b") + joint("j", "revolute", "a", "b", LIMIT + '<mimic joint="j"/>'), "mimics itself"),
        (links("a", "b") + joint("j", "fixed", "a", "b", ""), "no joint moves"),
        (links("a") + "<link/>", "without a name"),
        (links("a", "b") + joint("j", "revolute", "a", "b").replace("0 1 0", "0 0 0"), "zero vector"),
        (links("a", "b") + joint("j", "revolute", "a", "b").replace("0 0 0.5", "0 0"), "expected 3 numbers"),
        ('<link name="a"><collision><geometry><sphere radius="-1"/></geometry></collision></link>', "negative size"),
        ('<link name="a"><collision><geometry><cone radius="1"/></geometry></collision></link>', "shape 'cone'"),
        ('<link name="a"><collision><geometry><cylinder radius="1"/></geometry></collision></link>', "without length"),
        ("<link name='a'>", "not well-formed XML"),
        ("", "no links"),
    ],
)
def test_what_is_wrong_is_named_with_its_place(tmp_path, body, words):
    path = write(tmp_path, body)
    with pytest.raises(InputError, match=words) as error:
        robots.load(path)
    assert str(path) in str(error.value)
    if words not in ("own ancestor", "no joint moves", "no links"):
        line = int(str(error.value).removeprefix(str(path)).split(":")[1])
        assert 1 <= line <= 5


def test_likely_tips_come_first(tmp_path):
    names = ["base", "a", "b", "c", "d", "wrist", "l_gripper", "l_finger_tip", "hand_camera"]
    body = links(*names)
    for k, (one, two) in enumerate(zip(names[:7], names[1:7])):
        body += joint(f"j{k}", "revolute", one, two)
    body += joint("f", "revolute", "l_gripper", "l_finger_tip") + joint("g", "revolute", "l_gripper", "hand_camera")
    told = r"the tree has 2 ends: l_finger_tip \(7 joints\), hand_camera \(7 joints\); "
    told += r"likely tools before them: l_gripper \(6 joints\), wrist \(5 joints\) \(name"
    with pytest.raises(InputError, match=told):
        robots.load(write(tmp_path, body))


@pytest.mark.parametrize(("arm", "hands", "fingers"), [(4, 1, 4), (6, 1, 0), (6, 1, 3), (7, 2, 5), (9, 2, 30)])
def test_the_ends_that_are_told_add_up(tmp_path, arm, hands, fingers):
    names, body = ["base"], joint("fixed", "fixed", "base", "camera")
    for hand in "lr"[:hands]:
        chain = ["base", *(f"{hand}_arm{k}" for k in range(arm - 1)), f"{hand}_wrist"]
        tips = [f"{hand}_tool", *(f"{hand}_finger{k}" for k in range(fingers))]
        names += [*chain[1:], *tips]
        for one, two in zip(chain, chain[1:]):
            body += joint(f"to_{two}", "revolute", one, two)
        for k, tip in enumerate(tips):
            body += joint(f"to_{tip}", "revolute" if k else "fixed", chain[-1], tip)
    with pytest.raises(InputError) as error:
        robots.load(write(tmp_path, links(*names, "camera") + body))
    found = re.search(
        r"the tree has (\d+) ends: (.*?)(?: and (\d+) more)?(?:; likely tools before them: (.*))?$", error.value.message
    )
    number, shown, more, tools = found.groups()
    count = {link: int(n) for link, n in re.findall(r"(\w+) \((\d+) joints?\)", shown)}
    ends = {f"{hand}_{tip}" for hand in "lr"[:hands] for tip in ["tool", *(f"finger{k}" for k in range(fingers))]}
    assert int(number) == len(ends) + 1 == len(count) + int(more or 0) and len(count) == min(8, len(ends) + 1)
    assert set(count) <= {*ends, "camera"}
    assert all(n == arm * (link != "camera") + ("finger" in link) for link, n in count.items())
    if arm >= 5:  # else no arm
        assert list(count)[:hands] == [f"{hand}_tool" for hand in "lr"[:hands]]
        assert tools == ", ".join(f"{hand}_wrist ({arm} joints)" for hand in "lr"[:hands])


def test_base_and_tip_must_make_a_chain(tmp_path):
    body = links("a", "b", "c", "d") + joint("j", "revolute", "a", "b") + joint("k", "revolute", "b", "c")
    body += joint("l", "revolute", "b", "d")
    path = write(tmp_path, body)
    with pytest.raises(InputError, match=r"the tree has 2 ends: c \(2 joints\), d \(2 joints\) \(name"):
        robots.load(path)
    with pytest.raises(InputError, match=r"unknown link for the tip 'e'.*valid: a, b, c, d"):
        robots.load(path, tip="e")
    with pytest.raises(InputError, match="base 'x'"):
        robots.load(path, base="x", tip="c")
    with pytest.raises(InputError, match="'b' lies above the base 'c': a > b > c"):
        robots.load(path, base="c", tip="b")
    with pytest.raises(InputError, match="2 links have no parent"):
        robots.load(write(tmp_path, links("a", "b", "z") + joint("j", "revolute", "a", "b")), tip="b")


def test_files_that_are_not_there_and_other_files(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        robots.load(tmp_path / "missing.urdf")
    with pytest.raises(InputError, match=r"unknown robot 'pandaa'.*did you mean 'panda'"):
        robots.load("pandaa")
    (tmp_path / "other.urdf").write_text("<sdf><model/></sdf>")
    with pytest.raises(InputError, match="root element is <sdf>"):
        robots.load(tmp_path / "other.urdf")


def test_package_paths_are_resolved_without_a_network(tmp_path, monkeypatch):
    import trimesh

    from horosphere.robots._meshes import resolve

    package = tmp_path / "my_robot"
    (package / "meshes").mkdir(parents=True)
    (package / "urdf").mkdir()
    trimesh.creation.box((0.2, 0.1, 0.1)).export(package / "meshes" / "arm.stl")
    mesh = '<collision><geometry><mesh filename="package://my_robot/meshes/{}"/></geometry></collision>'
    body = f'<link name="a">{mesh.format("gone.stl")}</link><link name="b">{mesh.format("arm.stl")}</link>'
    robot = robots.load(write(package / "urdf", body + joint("j", "revolute", "a", "b")))
    assert set(robot.capsules.link.tolist()) == {1}
    notes = " ".join(robot.notes)
    assert "gone.stl not found" in notes and "WITHOUT collision body: a" in notes
    elsewhere = write(tmp_path, links("a"), "elsewhere.urdf")
    assert resolve("package://other/x.stl", elsewhere) is None
    (tmp_path / "ros" / "other").mkdir(parents=True)
    (tmp_path / "ros" / "other" / "x.stl").write_text("")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    assert resolve("package://other/x.stl", elsewhere) == tmp_path / "ros" / "other" / "x.stl"
    assert resolve("https://example.org/x.stl", elsewhere) is None


def test_real_files(shared_data):
    panda = robots.load(shared_data / "panda_spheres.urdf", tip="panda_grasptarget")
    assert panda.n_joints == 7 and len(panda.capsules) == 59
    assert (panda.capsules.a == panda.capsules.b).all()
    assert all("exact" in note for note in panda.capsules.note)
    nao = robots.load(shared_data / "nao.urdf", base="torso", tip="l_gripper")
    assert nao.joint_names == ("LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw", "LHand")
    assert any("not found" in note for note in nao.notes) and any("WITHOUT" in note for note in nao.notes)
    arm = robots.load(shared_data / "nao.urdf", "torso", "l_gripper", link_radius=0.03, locked={"LHand": 0.0})
    assert arm.n_joints == 5 and any("radius 0.03" in note for note in arm.notes)
    assert {"LBicep", "LForeArm", "l_wrist"} <= {arm.link_names[k] for k in arm.capsules.link}


def test_the_reader_agrees_with_yourdfpy(shared_data):
    yourdfpy = pytest.importorskip("yourdfpy")
    for name, tip in (("panda_spheres.urdf", "panda_hand"), ("nao.urdf", "l_gripper")):
        path = shared_data / name
        other = yourdfpy.URDF.load(str(path), build_scene_graph=True, load_meshes=False)
        robot = robots.load(path, tip=tip)
        other.update_cfg({joint: 0.0 for joint in other.actuated_joint_names})
        low, high = robot.limits.lower, robot.limits.upper
        assert [(other.joint_map[n].limit.lower, other.joint_map[n].limit.upper) for n in robot.joint_names] == [
            *zip(low, high)
        ]
        frames = kinematics.frames(robot, np.zeros(robot.n_joints)).as_matrix()
        locked = " ".join(robot.notes)
        for k in robot.chain:
            expected = other.get_transform(robot.link_names[k], robot.link_names[0])
            assert frames[k] == pytest.approx(expected, abs=1e-12), (robot.link_names[k], locked)


def test_robots_pickle(tmp_path):
    robot = robots.load("panda")
    kinematics.forward(robot, np.zeros(7))
    twin = pickle.loads(pickle.dumps(robot))
    assert twin.content == robot.content and twin.notes == robot.notes
    assert kinematics.forward(twin, np.zeros(7)).array == pytest.approx(
        kinematics.forward(robot, np.zeros(7)).array, abs=0
    )
