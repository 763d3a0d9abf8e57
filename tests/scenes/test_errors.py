"""Scene files that are wrong: every problem at once, with its place and what is allowed."""

import pickle
import re

import pytest

from horosphere.errors import InputError
from horosphere.scenes import Scene, SceneError

GOOD = """\
horosphere/scene: 1
robot: {type: point, radius: 0.1}
start: {position: [0, 0, 0]}
goal: {position: [1, 1, 1]}
obstacles:
  - {type: sphere, center: [5, 5, 5], radius: 1}
"""


def problems(tmp_path, text):
    file = tmp_path / "bad.yaml"
    file.write_text(text)
    with pytest.raises(SceneError) as caught:
        Scene.load(file)
    return [str(error).removeprefix(f"{file}:") for error in caught.value.errors]


def test_the_good_one_is_good(tmp_path):
    (tmp_path / "good.yaml").write_text(GOOD)
    Scene.load(tmp_path / "good.yaml")


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("radius: 0.1", "radius: -0.1", "2:30", "radius: expected a number >= 0, got -0.1"),
        ("radius: 0.1", "radius: .nan", "2:30", "expected a finite number, got nan"),
        ("radius: 0.1", "radius: .inf", "2:30", "expected a finite number, got inf"),
        ("radius: 0.1", "radius: '0.1'", "2:30", "expected a number, got '0.1'"),
        ("radius: 0.1", "raduis: 0.1", "2:22", "unknown field 'raduis'; valid: .*did you mean 'radius'"),
        ("radius: 0.1", "radius: 0.1, radius: 0.2", "2:35", "the field 'radius' stands here twice"),
        (
            "type: point",
            "type: pont",
            "2:15",
            "unknown robot type 'pont'; valid: ball, point, snake, unicycle .*'point'",
        ),
        ("{type: point, radius: 0.1}", "pandda", "2:8", "unknown robot 'pandda'; valid: .*humanoid-arm"),
        ("{type: point, radius: 0.1}", "{}", "2:8", "expected one of the fields name, urdf, file, mechanism, type"),
        (
            "{type: point, radius: 0.1}",
            "{urdf: no.urdf, tip: hand}",
            "2:8",
            "'no.urdf' does not exist.*relative to the scene",
        ),
        (
            "{type: point, radius: 0.1}",
            "{mechanism: humanoid}",
            "2:20",
            "unknown robot mechanism 'humanoid'.*humanoid_arm",
        ),
        ("type: sphere", "type: spher", "6:12", "unknown obstacle type 'spher'; valid: .*did you mean 'sphere'"),
        ("type: sphere, ", "", "6:5", "missing field 'type'; valid: .*half-space"),
        ("radius: 1}", "}", "6:5", "missing field 'radius'"),
        ("radius: 1}", "radius: 0}", "6:47", "expected a number > 0, got 0"),
        ("[5, 5, 5]", "[5, 5]", "6:5", "a ball of dimension 2 in a scene of dimension 3"),
        ("[5, 5, 5]", "[5, five, 5]", "6:32", "expected a number, got 'five'"),
        ("[5, 5, 5]", "5", "6:28", "expected a list of numbers, got 5"),
        ("[1, 1, 1]", "[1, 1]", "4:18", "expected 3 numbers, got 2"),
        ("[1, 1, 1]", "[1, 1, 1], heading: 0", "4:29", "unknown field 'heading'; valid: position"),
        ("horosphere/scene: 1", "horosphere/scene: 2", "1:19", "version 2 is not known; valid: 1"),
        ("horosphere/scene: 1\n", "name: x\n", "1:1", "'horosphere/scene' is missing .*begin the file"),
        ("goal:", "gaol:", "4:1", "unknown field 'gaol'; valid: .*did you mean 'goal'"),
        ("goal: {position: [1, 1, 1]}\n", "", "1:1", "missing field 'goal'"),
    ],
)
def test_one_problem(tmp_path, old, new, place, words):
    assert old in GOOD
    found = problems(tmp_path, GOOD.replace(old, new))
    assert any(line.startswith(f"{place}: ") and re.search(words, line) for line in found), found


def test_all_problems_at_once_in_the_order_of_the_file(tmp_path):
    text = (
        GOOD.replace("radius: 0.1", "radius: -1")
        .replace("[0, 0, 0]", "[0, .nan, 0]")
        .replace("radius: 1}", "radius: x}")
    )
    text += "  - {type: box, center: [0, 0, 0]}\noptions: {clearance: -1, methd: tree, seed: 1.5, method: best}\n"
    found = problems(tmp_path, text)
    lines = [int(line.split(":")[0]) for line in found]
    assert lines == sorted(lines)
    assert {2, 3, 6, 7, 8} == set(lines)
    assert sum(line.startswith("8:") for line in found) == 4


ARM = """\
horosphere/scene: 1
robot: humanoid-arm
start: {joints: [0, 0, 0, 0, 0]}
goal: {position: [0.3, 0, 0.3], plane_normal: [0, 1, 0]}
"""


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("[0, 0, 0, 0, 0]", "[0, 0, 0, 0]", "3:17", "has 5 joints .*got 4 numbers"),
        ("[0, 0, 0, 0, 0]", "[0, 9, 0, 0, 0]", "3:17", "'joint_2' is 9, outside its limits"),
        (
            "joints: [0, 0, 0, 0, 0]",
            "joints_deg: [0, 200, 0, 0, 0]",
            "3:21",
            "'joint_2' is 3.49066, outside its limits",
        ),
        (
            "[0, 0, 0, 0, 0]",
            "[0, 80, 0, 0, 0]",
            "3:17",
            "'joint_2' is 80, .*as degrees all of them would fit: joints_deg",
        ),
        ("[0, 0, 0, 0, 0]", "[0, 4, 0, 0, 0]", "3:17", r"'joint_2' is 4, outside its limits \[[^(]*$"),
        ("[0, 0, 0, 0, 0]", "[0, 400, 0, 0, 0]", "3:17", r"'joint_2' is 400, outside its limits \[[^(]*$"),
        ("joints: [0, 0, 0, 0, 0]", "joints_deg: [0, 4000, 0, 0, 0]", "3:21", r"'joint_2' is 69.8132, [^(]*$"),
        ("plane_normal: [0, 1, 0]", "rpy: [0, 0, 90]", "4:7", "rpy: 90 radians are more than a turn .*rpy_deg"),
        (
            "[0, 0, 0, 0, 0]",
            "{joint_1: 0, jont_2: 0}",
            "3:30",
            "unknown joint 'jont_2'; valid: .*did you mean 'joint_2'",
        ),
        ("[0, 0, 0, 0, 0]", "{joint_1: 0}", "3:17", "no value for the joints joint_2, joint_3, joint_4, joint_5"),
        ("plane_normal: [0, 1, 0]", "plane_normal: [0, 0, 0]", "4:7", "zero vector"),
        (
            "plane_normal: [0, 1, 0]",
            "rpy: [0, 0, 0], rpy_deg: [0, 0, 0]",
            "4:49",
            "'rpy' and 'rpy_deg' exclude each other",
        ),
        ("plane_normal: [0, 1, 0]", "quaternion_wxyz: [1, 1, 0, 0]", "4:7", "quaternion_wxyz has length 1.41421"),
        ("{joints: [0, 0, 0, 0, 0]}", "{plane: {normal: [0, 0, 1], distance: 1}}", "3:8", "plane is no start"),
        ("{joints: [0, 0, 0, 0, 0]}", "{}", "3:8", "expected one of: joints, position"),
        ("robot: humanoid-arm", "robot: {name: humanoid-arm, lower: [0, 1]}", "2:36", "has 5 joints, got 2 numbers"),
    ],
)
def test_arm_problems(tmp_path, old, new, place, words):
    found = problems(tmp_path, ARM.replace(old, new))
    assert any(line.startswith(f"{place}: ") and re.search(words, line) for line in found), found


def test_a_misspelt_type_hides_nothing_else(tmp_path):
    text = """\
horosphere/scene: 1
robot: {type: pont, raduis: 3}
start: {position: [0, 0]}
goal: {position: [0, zero]}
obstacles:
  - {type: spher, center: [5, five], radius: -1}
  - {type: shpere, center: [5, 5], raduis: 1}
  - {type: [sphere], center: [5, 5], radius: 1}
  - {type: wombat, center: 5}
  - {type: sphere, center: [1, 1], name: a}
  - {type: sphere, center: [1, 1], radius: 1, name: b}
  - {type: sphere, center: [2, 2], radius: 1, name: b}
options: {clearence: 3}
"""
    expected = [
        "2:15: robot.type: unknown robot type 'pont'",
        "2:21: robot.raduis: unknown field 'raduis'",
        "4:22: goal.position[1]: expected a number, got 'zero'",
        "6:12: obstacles[0].type: unknown obstacle type 'spher'",
        "6:31: obstacles[0].center[1]: expected a number, got 'five'",
        "6:46: obstacles[0].radius: expected a number > 0, got -1",
        "7:5: obstacles[1]: missing field 'radius'",
        "7:12: obstacles[1].type: unknown obstacle type 'shpere'",
        "7:36: obstacles[1].raduis: unknown field 'raduis'",
        "8:12: obstacles[2].type: unknown obstacle type ['sphere']",
        "9:12: obstacles[3].type: unknown obstacle type 'wombat'",
        "10:5: obstacles[4]: missing field 'radius'",
        "12:53: obstacles[6].name: obstacle 5 is named 'b' already",
        "13:11: options.clearence: unknown field 'clearence'",
    ]
    found = problems(tmp_path, text)
    assert len(found) == len(expected)
    assert all(one.startswith(start) for one, start in zip(found, expected)), found


def test_what_does_not_need_the_robot_is_told_without_it(tmp_path):
    text = """\
horosphere/scene: 1
robot: {mechanism: srs_amr, dbs: 0.1, dse: -1, dew: 0.3, dwf: 0.1}
start: {joints: [0, 0, 0, 0, 0, 0, 0]}
goal: {plane: {normal: [0, 0, 1], distance: 0.2}}
obstacles:
  - {type: sphere, center: [5, 5], radius: 1, name: a}
allowed_obstacles: [[hand, a], [a, b, c]]
workspace: {center: [0, 0], radius: 1}
"""
    expected = [
        "2:20: robot.mechanism: unknown robot mechanism 'srs_amr'",
        "2:44: robot.dse: expected a number > 0, got -1",
        "6:5: obstacles[0]: a ball of dimension 2 in a scene of dimension 3",
        "7:32: allowed_obstacles[1]: expected two names",
        "8:21: workspace.center: expected 3 numbers, got 2",
    ]
    found = problems(tmp_path, text)
    assert len(found) == len(expected)
    assert all(one.startswith(start) for one, start in zip(found, expected)), found


def test_obstacle_names_are_told_apart(tmp_path):
    ball = "  - {type: sphere, name: a, center: [5, 5, 5], radius: 1}\n"
    (line,) = problems(tmp_path, GOOD.split("obstacles:")[0] + "obstacles:\n" + 2 * ball)
    assert line.startswith("7:26: ") and "obstacle 0 is named 'a' already" in line


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("a: [1, 2\nb: 3", "2:2", "not valid YAML"),
        ("a: b: c", "1:5", "not valid YAML"),
        ("\tx: 1", "1:1", "not valid YAML"),
    ],
)
def test_malformed_yaml(tmp_path, text, place, words):
    file = tmp_path / "bad.yaml"
    file.write_text(text)
    with pytest.raises(InputError, match=words) as caught:
        Scene.load(file)
    assert caught.value.place == f"{file}:{place}"


@pytest.mark.parametrize("text", ["", "- 1", "just words", "3", "&a {x: *a}", "? [1, 2]\n: 3"])
def test_no_scene_at_all(tmp_path, text):
    file = tmp_path / "bad.yaml"
    file.write_text(text)
    with pytest.raises(InputError):
        Scene.load(file)


def test_files_that_are_not_there(tmp_path):
    with pytest.raises(InputError, match="cannot be read: No such file"):
        Scene.load(tmp_path / "missing.yaml")
    with pytest.raises(InputError, match="expected a file, got a folder"):
        Scene.load(tmp_path)
    with pytest.raises(InputError, match=r"unknown scene 'humanoid-rech'.*did you mean 'humanoid-reach'"):
        Scene.load("humanoid-rech")
    (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(InputError, match=r"cannot be read as text: it is UTF-16 \(.*save it as UTF-8"):
        Scene.load(tmp_path / "binary.yaml")
    (tmp_path / "binary.yaml").write_bytes(b"ab\xaf")
    with pytest.raises(InputError, match=r"byte 2 is not UTF-8 .*name another file"):
        Scene.load(tmp_path / "binary.yaml")


@pytest.mark.parametrize(
    ("obstacle", "words"),
    [
        ("type: [mesh]", r"unknown obstacle type \['mesh'\]"),
        (
            "type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces: [[0, 1, 1000000000000000000000]]",
            "integers",
        ),
    ],
)
def test_an_obstacle_that_is_none(tmp_path, obstacle, words):
    text = "horosphere/scene: 1\nrobot: panda\nstart: {joints_deg: [0, -45, 0, -135, 0, 90, 45]}\n"
    text += "goal: {position: [0.5, 0.3, 0.4], rpy_deg: [180, 0, 45]}\nobstacles:\n"
    [line] = problems(tmp_path, f"{text}  - {{{obstacle}}}\n")
    assert line.startswith("6:") and re.search(words, line), line


def test_bad_files_of_obstacles(tmp_path):
    (tmp_path / "empty.csv").write_text("x,y,z\n")
    (tmp_path / "text.stl").write_text("no mesh at all")
    (tmp_path / "nan.csv").write_text("0,0,0\n1,nan,1\n")
    text = GOOD + "".join(
        f"  - {{type: {kind}, file: {name}}}\n"
        for kind, name in (
            ("points", "empty.csv"),
            ("mesh", "text.stl"),
            ("points", "nan.csv"),
            ("mesh", "x.step"),
            ("points", "scene.doc"),
        )
    )
    (tmp_path / "x.step").write_text("")
    found = problems(tmp_path, text)
    assert [line.split(":")[0] for line in found] == ["7", "8", "9", "10", "11"]
    for line, words in zip(
        found,
        ("holds no points", "read as a mesh|no triangles", "point 1 is not finite", "valid: .stl", "does not exist"),
    ):
        assert re.search(words, line), line


def test_scene_errors_pickle(tmp_path):
    file = tmp_path / "bad.yaml"
    file.write_text(GOOD.replace("radius: 1}", "radius: x, y: 1}"))
    with pytest.raises(SceneError) as caught:
        Scene.load(file)
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and len(again.errors) == 2


def test_degrees_taken_for_radians_are_told_once(tmp_path):
    """Of several joints outside their limits the last says it; a joint that slides is no angle."""
    text = "horosphere/scene: 1\nrobot: panda\nstart: {joints: [0, -45, 0, -135, 0, 90, 45]}\ngoal: {joints: [0, 0, 0, -2, 0, 2, 0]}\n"
    found = problems(tmp_path, text)
    assert len(found) == 4 and ["joints_deg" in line for line in found] == [False, False, False, True]
    with pytest.raises(InputError, match=r"numpy\.radians in Python"):
        Scene("humanoid-arm", [0, 80, 0, 0, 0], [0, 0, 0, 0, 0])
    link = '<link name="{0}"/>'
    joint = (
        '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><axis xyz="0 0 1"/>'
        '<limit lower="0" upper="3" velocity="1" effort="1"/></joint>'
    )
    body = (
        "".join(map(link.format, "abc"))
        + joint.format("slide", "prismatic", "a", "b")
        + joint.format("t", "revolute", "b", "c")
    )
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{body}</robot>')
    for start, hint in (("[2, 90]", True), ("[90, 1]", False), ("[90, 90]", False)):
        text = f"horosphere/scene: 1\nrobot: r.urdf\nstart: {{joints: {start}}}\ngoal: {{joints: [0, 0]}}\n"
        found = problems(tmp_path, text)
        assert any("joints_deg" in line for line in found) == hint, found
