"""What users get wrong about robots and what stands around them: exit code 2, one message that names place and remedy."""

import numpy as np
import pytest
import trimesh

from horosphere.cli._app import main

SOLID = '<collision><origin xyz="0 0 0.15"/><geometry><cylinder radius="0.05" length="0.3"/></geometry></collision>'


def joint(name, parent, child, lower=-3, upper=3, xyz="0 0 0.3"):
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/>'
        f'<axis xyz="0 1 0"/><limit lower="{lower}" upper="{upper}" velocity="1" effort="1"/></joint>'
    )


def links(names, inner=SOLID):
    return "".join(f'<link name="{name}">{inner}</link>' for name in names)


CHAIN = links("abcd") + joint("j", "a", "b") + joint("k", "b", "c") + joint("l", "c", "d")
LOOP = links("abc") + joint("j", "a", "b") + joint("k", "b", "c") + joint("l", "a", "c")
ROBOTS = {
    "loop": (LOOP, [], ["'c' has two parents", "cut the loop"]),
    "circle": (links("ab") + joint("j", "a", "b") + joint("k", "b", "a"), [], ["closed loops", "robot.urdf:1"]),
    "tip above": (CHAIN, ["--base", "c", "--tip", "a"], ["lies above the base 'c': a > b > c", "exchange them"]),
    "tip unknown": (CHAIN, ["--tip", "dd"], ["unknown link for the tip 'dd'", "did you mean 'd'"]),
    "no tip": (CHAIN + links("e") + joint("m", "a", "e"), [], ["d (3 joints), e (1 joint)", "--tip"]),
    "limits": (links("ab") + joint("j", "a", "b", 1, -1), [], ["joint 'j'", "lower limit 1 > upper limit -1"]),
    "not xml": ("<link", [], ["robot.urdf:1:", "not well-formed XML", "repair the file"]),
    "srdf": (CHAIN, ["--srdf", "other.srdf"], ["other.srdf:1", "for a robot 'big'", "link 'zz'", "give the SRDF of this robot"]),
    "no group": (CHAIN + links("e") + joint("m", "a", "e"), ["--srdf", "groups.srdf"],
                 ["d (3 joints), e (1 joint)", "name a group of the SRDF (--group): arm, finger; or a tip (--tip)"]),
    "radius": (CHAIN, ["--link-radius", "-1"], ["positive radius", "-1"]),
}  # fmt: skip


@pytest.mark.parametrize("name", ROBOTS)
def test_robots(name, tmp_path, monkeypatch, capsys):
    body, options, says = ROBOTS[name]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.urdf").write_text(f'<robot name="r">{body}</robot>')
    (tmp_path / "other.srdf").write_text('<robot name="big"><disable_collisions link1="a" link2="zz"/></robot>')
    groups = "".join(
        f'<group name="{n}"><chain base_link="a" tip_link="{t}"/></group>' for n, t in (("arm", "d"), ("finger", "e"))
    )
    (tmp_path / "groups.srdf").write_text(f'<robot name="r">{groups}</robot>')
    assert main(["robot", "robot.urdf", *options]) == 2
    said = capsys.readouterr().err
    assert said.count("error:") == 1 and "Traceback" not in said
    for text in says:
        assert text in said.replace("\n", " "), said


def test_missing_and_broken_meshes_are_named(tmp_path, capsys):
    """Still a robot: it is said which links go without a body, and what to do."""
    names = {"b": "package://acme/b.stl", "c": "nan.obj", "d": "empty.stl"}
    body = links("a") + "".join(
        f'<link name="{k}"><collision><geometry><mesh filename="{v}"/></geometry></collision></link>'
        for k, v in names.items()
    )
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="r">{body}{joint("j", "a", "b")}{joint("k", "b", "c")}{joint("l", "c", "d")}</robot>')
    box = trimesh.creation.box([0.1] * 3)
    rows = [f"v {x} {y} {z}" for x, y, z in np.where(np.arange(8)[:, None] == 3, np.nan, box.vertices)]
    (tmp_path / "nan.obj").write_text("\n".join([*rows, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in box.faces)]))
    (tmp_path / "empty.stl").write_text("hello")
    assert main(["robot", str(path)]) == 0
    said = capsys.readouterr().out
    assert "WITHOUT collision body: b, c, d; give a capsule file or a link radius" in said
    assert "package://acme/b.stl not found (set ROS_PACKAGE_PATH" in said


def scene(folder, obstacle="", robot="robot.urdf", start="[0, 0.3, 0.3]"):
    (folder / "robot.urdf").write_text(f'<robot name="r">{CHAIN}</robot>')
    ends = f"start: {{joints: {start}}}\ngoal: {{joints: [0.1, 0.2, 0.3]}}"
    text = f"horosphere/scene: 1\nrobot: {robot}\n{ends}\nobstacles:\n{obstacle}"
    (folder / "s.yaml").write_text(text)
    return str(folder / "s.yaml")


OBSTACLES = {
    "{type: points, file: empty.npy}": "'empty.npy' holds no points (leave an empty cloud out)",
    "{type: points, file: nan.npy}": "'nan.npy': point 1 is not finite",
    "{type: mesh, file: nan.obj}": "'nan.obj': vertex 3 is not finite",
    "{type: mesh, file: nan.ply}": "'nan.ply': vertex 0 is not finite",
    "{type: points, file: nan.ply}": "'nan.ply': point 0 is not finite",
    "{type: mesh, file: open.stl}": "not watertight: 4 of its edges",
    "{type: mesh, file: hello.stl}": "'hello.stl' holds no triangles",
    "{type: mesh, file: gone.stl}": "file 'gone.stl' does not exist",
    "{type: mesh, file: a.docx}": "no mesh is read from '.docx'; valid: .stl, .obj, .ply",
}


@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_obstacles(obstacle, tmp_path, capsys):
    np.save(tmp_path / "empty.npy", np.zeros((0, 3)))
    np.save(tmp_path / "nan.npy", np.array([[0, 0, 1.0], [0, 0, np.nan]]))
    box = trimesh.creation.box([0.1] * 3)
    rows = [f"v {x} {y} {z}" for x, y, z in np.where(np.arange(8)[:, None] == 3, np.nan, box.vertices)]
    (tmp_path / "nan.obj").write_text("\n".join([*rows, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in box.faces)]))
    trimesh.Trimesh(box.vertices, box.faces[:-2]).export(tmp_path / "open.stl")
    nothing = trimesh.Trimesh(np.full((8, 3), np.nan), box.faces, process=False, validate=False)
    nothing.export(tmp_path / "nan.ply")
    (tmp_path / "hello.stl").write_text("hello")
    (tmp_path / "a.docx").write_text("hello")
    assert main(["plan", scene(tmp_path, f"  - {obstacle}"), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "s.yaml:6:5" in said and OBSTACLES[obstacle] in said.replace("\n", " ") and said.count("error:") == 1


@pytest.mark.parametrize(
    ("robot", "says"),
    [
        (
            "{urdf: robot.urdf, lower: [1, -1, -1], upper: [0, 1, 1]}",
            "joint 'j' is left no position: lower 1 > upper 0",
        ),
        ("{urdf: robot.urdf, link_radius: {bb: 0.1}}", "unknown link 'bb'; valid: a, b, c, d (did you mean 'b'?)"),
        ("{urdf: robot.urdf, tip: dd}", "unknown link for the tip 'dd'"),
        ("{urdf: robot.urdf, srdf: gone.srdf}", "'gone.srdf' does not exist"),
        ("{urdf: robot.urdf, budget: 0}", "expected a number >= 1, got 0"),
    ],
)
def test_robots_of_scenes(robot, says, tmp_path, capsys):
    assert main(["plan", scene(tmp_path, robot=robot), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err.replace("\n", " ")
    assert "s.yaml:2:" in said and says in said, said


def test_a_start_in_self_collision_names_the_pair_and_the_depth(tmp_path, capsys):
    file = scene(tmp_path, robot="{urdf: robot.urdf, tolerance: 0.05}", start="[0, 2.9, 2.9]")
    assert main(["plan", file, "--out", str(tmp_path / "out"), "--no-report"]) == 1
    assert "start in collision: link 'b' reaches 101 mm into 'd'" in capsys.readouterr().out


def test_a_corrupt_archive(tmp_path, capsys):
    path = tmp_path / "problems.tar.bz2"
    path.write_bytes(b"BZh91AY&SY" + 50 * b"x")
    assert main(["bench", "mbm", str(path)]) == 2
    said = capsys.readouterr().err.replace("\n", " ")
    assert "not a readable archive" in said and "valid: .tar" in said


XACRO = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{}</robot>'
LEFT_OUT = {
    "macro": ("arm.urdf.xacro", '<xacro:arg name="side"/>\n<xacro:arm/>', "arm.urdf.xacro:1", "<xacro:arg>",
              "xacro arm.urdf.xacro side:=... > arm.urdf"),
    "renamed": ("arm.urdf", CHAIN + "<xacro:gripper/>", "arm.urdf:1", "<xacro:gripper>", "xacro arm.urdf > arm-expanded.urdf"),
    "ending": ("arm.xacro", "", "arm.xacro:1", "without links", "xacro arm.xacro > arm.urdf"),
    "values": ("arm.urdf", CHAIN.replace('name="a"', 'name="${p}a"'), "arm.urdf:1", "first <link>", "expand it"),
}  # fmt: skip


@pytest.mark.parametrize("name", LEFT_OUT)
def test_xacro_must_be_expanded(name, tmp_path, monkeypatch, capsys):
    """In the command and in a scene; an expanded file that keeps the name space is a robot."""
    file, body, *says = LEFT_OUT[name]
    monkeypatch.chdir(tmp_path)
    (tmp_path / file).write_text(XACRO.format(body))
    (tmp_path / "s.yaml").write_text(
        f"horosphere/scene: 1\nrobot: {file}\nstart: {{joints: [0]}}\ngoal: {{joints: [1]}}\n"
    )
    for command in (["robot", file], ["plan", "s.yaml"]):
        assert main(command) == 2
        said = capsys.readouterr().err.replace("\n", " ")
        assert all(text in said for text in says) and said.count("error:") == 1, said
    (tmp_path / "whole.urdf").write_text(XACRO.format(CHAIN + '<gazebo><a b="$(arg x)"/></gazebo>'))
    assert main(["robot", "whole.urdf"]) == 0
    capsys.readouterr()


def test_what_is_no_file(tmp_path, monkeypatch, capsys):
    """A folder (which URDFs are in it), a pipe, a name that is nothing."""
    import os

    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "empty").mkdir()
    (tmp_path / "robots" / "arm").mkdir(parents=True)
    for place in ("b.urdf", "arm/a.urdf", "arm/a.txt"):
        (tmp_path / "robots" / place).write_text("")
    for name, *says in (
        ("robots", "a folder, not a file", "robots/b.urdf, robots/arm/a.urdf (name one of them)"),
        ("empty", "a folder, not a file", "no URDF in it"),
        ("pipe", "not a regular file"),
        ("nothing.urdf", "no such file"),
        ("no/thing", "no such file", "valid: humanoid-arm"),
    ):
        assert main(["robot", name]) == 2
        said = capsys.readouterr().err.replace("\n", " ")
        assert all(text in said for text in says), said


def test_a_group_of_the_srdf_that_is_not_named(tmp_path, monkeypatch, capsys):
    """Where the tip is plain without it, a note says which groups there are."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.urdf").write_text(f'<robot name="r">{CHAIN}</robot>')
    groups = "".join(
        f'<group name="{n}"><chain base_link="a" tip_link="{t}"/></group>' for n, t in (("arm", "d"), ("upper", "c"))
    )
    (tmp_path / "r.srdf").write_text(f'<robot name="r">{groups}</robot>')
    for options, says in (
        ([], "no group of r.srdf is named"),
        (["--group", "upper"], "chain of the SRDF's group 'upper': a to c"),
    ):
        assert main(["robot", "robot.urdf", "--srdf", "r.srdf", *options]) == 0
        said = " ".join(capsys.readouterr().out.split())
        assert says in said and ("it has arm, upper" in said) == (not options)
