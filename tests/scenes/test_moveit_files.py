"""MoveIt problems as scenes: found by content and by name, for the robot of a URDF, saved as scenes of ours."""

import io
import tarfile
from pathlib import Path

import numpy as np
import pytest

from horosphere import distance, kinematics, robots
from horosphere.errors import InputError
from horosphere.scenes import PoseTarget, PositionTarget, Scene, read_moveit
from horosphere.scenes._moveit_files import ProblemSet

SCENE = """
robot_model_name: lifter
robot_state: {joint_state: {name: [lift, left, turn], position: [0.3, 0.02, 0.1]}}
world:
  collision_objects:
    - {id: wall, primitives: [{type: box, dimensions: [0.1, 2, 2]}], primitive_poses: [{position: [1.5, 0, 1]}]}
"""
REQUEST = """
group_name: arm
start_state: {joint_state: {name: [turn, nod], position: [0.2, -0.4]}}
goal_constraints: [{joint_constraints: [{joint_name: nod, position: 0.5}, {joint_name: turn, position: 1.0}]}]
max_velocity_scaling_factor: 0.5
max_acceleration_scaling_factor: 0
"""
POSE = """
goal_constraints:
  - position_constraints: [{link_name: palm, constraint_region: {primitive_poses: [{position: [0.7, 0.1, 0.9]}]}}]
    orientation_constraints: [{orientation: [0, 0, 0.1, 0.99498743710662]}]
"""
BODY = '<link name="{0}"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>'
JOINT = (
    '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><origin xyz="{4}"/><axis xyz="{5}"/>'
    '<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
)
URDF = (
    '<robot name="lifter">'
    + "".join(BODY.format(name) for name in ("base", "column", "upper", "fore", "palm", "left", "right"))
    + JOINT.format("lift", "prismatic", "base", "column", "0 0 0.5", "0 0 1")
    + JOINT.format("turn", "revolute", "column", "upper", "0 0 0.1", "0 0 1")
    + JOINT.format("nod", "revolute", "upper", "fore", "0.4 0 0", "0 1 0")
    + JOINT.format("wrist", "fixed", "fore", "palm", "0.4 0 0", "1 0 0")
    + JOINT.format("left", "prismatic", "palm", "left", "0.1 0.1 0", "0 1 0")
    + JOINT.format("right", "prismatic", "palm", "right", "0.1 -0.1 0", "0 -1 0")
    + "</robot>"
)

MESH = {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 1, 2.5]]}
FAR = {**MESH, "triangles": [[0, 1, 9]]}


@pytest.fixture
def folder(tmp_path):
    for name, text in (("scene0001.yaml", SCENE), ("request0001.yaml", REQUEST), ("lifter.urdf", URDF)):
        (tmp_path / name).write_text(text)
    return tmp_path


def test_the_goals_joints_move_and_the_others_stand_where_the_state_has_them(folder):
    scene = Scene.load(folder / "scene0001.yaml", robot=folder / "lifter.urdf")
    robot = scene.robot
    assert robot.joint_names == ("turn", "nod") and robot.link_names[robot.tip] == "palm"
    np.testing.assert_array_equal(scene.start.q, [0.2, -0.4])  # the request has the last word
    np.testing.assert_array_equal(scene.goal.q, [1.0, 0.5])
    assert (scene.options.velocity_scale, scene.options.acceleration_scale, scene.options.clearance) == (0.5, 1.0, 0.0)
    assert scene.options.method == "tree"
    at = dict(zip(robot.link_names, kinematics.frames(robot, np.zeros(2)).as_matrix()[:, :3, 3]))
    np.testing.assert_allclose(at["upper"], [0, 0, 0.9], atol=1e-12)  # lifted by 0.3
    np.testing.assert_allclose(at["left"], [0.9, 0.12, 0.9], atol=1e-12)  # opened by 0.02
    np.testing.assert_allclose(at["right"], [0.9, -0.1, 0.9], atol=1e-12)  # nothing is said of it
    assert any("lift = 0.3" in note and "left = 0.02" in note for note in robot.notes)


def test_a_pose_goal_is_meant_for_its_link(folder):
    (folder / "request0001.yaml").write_text(REQUEST.split("goal")[0] + POSE)
    state = "start_state: {joint_state: {name: [turn, nod, lift], position: [0.2, -0.4, 0.1]}}"
    (folder / "request0001.yaml").write_text(POSE + state)
    scene = Scene.load(folder / "scene0001.yaml", robot=folder / "lifter.urdf")
    assert scene.robot.joint_names == ("lift", "turn", "nod") and scene.robot.link_names[scene.robot.tip] == "palm"
    np.testing.assert_allclose(scene.goal.position, [0.7, 0.1, 0.9])
    # of the forearm, which is one part with the palm: 0.4 m before it
    (folder / "request0001.yaml").write_text(POSE.replace("palm", "fore") + state)
    scene = Scene.load(folder / "scene0001.yaml", robot=folder / "lifter.urdf", tip="palm")
    c, s = 0.98, 0.1989974874213
    np.testing.assert_allclose(scene.goal.position, [0.7 + 0.4 * c, 0.1 + 0.4 * s, 0.9], atol=1e-9)
    with pytest.raises(InputError, match="pose of 'fore', which moves against the tip 'left'"):
        Scene.load(folder / "scene0001.yaml", robot=folder / "lifter.urdf", tip="left")
    # a tool beyond the link: the built-in Panda's
    panda = robots.load("panda")
    (folder / "p.yaml").write_text(POSE.replace("palm", "panda_hand"))
    goal = read_moveit(folder / "scene0001.yaml", folder / "p.yaml").goal_of(panda)
    assert isinstance(goal, PoseTarget)
    hand = goal.motor().as_matrix() @ np.linalg.inv(tool_of(panda))
    np.testing.assert_allclose(hand[:3, 3], [0.7, 0.1, 0.9], atol=1e-12)


def test_a_place_goal_is_of_the_tool_point(folder):
    """A position constraint alone: any orientation; where the tool point is another point than the link's origin, it is refused."""
    alone = POSE.split("    orientation")[0]
    state = "start_state: {joint_state: {name: [turn, nod, lift], position: [0.2, -0.4, 0.1]}}"
    (folder / "request0001.yaml").write_text(alone + state)
    moved = "robot_state: {multi_dof_joint_state: {transforms: [{translation: [0.2, 0, 0], rotation: [0, 0, 1, 0]}]}, "
    (folder / "scene0001.yaml").write_text(SCENE.replace("robot_state: {", moved))
    scene = Scene.load(folder / "scene0001.yaml", robot=folder / "lifter.urdf")
    assert isinstance(scene.goal, PositionTarget) and scene.robot.link_names[scene.robot.tip] == "palm"
    np.testing.assert_allclose(
        scene.goal.position, [-0.5, -0.1, 0.9], atol=1e-12
    )  # half a turn about z, then 0.2 along x
    (folder / "request0001.yaml").write_text(alone.replace("palm", "fore") + state)
    with pytest.raises(
        InputError, match=r"place of 'fore' in any orientation, 0.4 m from the tool point .*'fore' as the tip"
    ):
        Scene.load(folder / "scene0001.yaml", robot=folder / "lifter.urdf", tip="palm")
    (folder / "request0001.yaml").write_text(
        alone.replace("link_name: palm,", "link_name: palm, target_point_offset: [0, 0, 1],")
    )
    with pytest.raises(InputError, match="read for the origin of its link"):
        Scene.load(folder / "scene0001.yaml", robot=folder / "lifter.urdf")
    (folder / "request0001.yaml").write_text(
        "goal_constraints: [{orientation_constraints: [{orientation: [0, 0, 0, 1]}]}]"
    )
    with pytest.raises(InputError, match="one position and at most one orientation"):
        Scene.load(folder / "scene0001.yaml", robot=folder / "lifter.urdf")


def tool_of(robot):
    """Of the tip link's frame, by both forward kinematics."""
    q = np.linspace(0.1, 0.7, robot.n_joints)
    link = kinematics.frames(robot, q).as_matrix()[robot.tip]
    return np.linalg.inv(link) @ kinematics.forward(robot, q).as_matrix()


SRDF = """<robot name="lifter"><group name="arm"><chain base_link="column" tip_link="fore"/></group>
<disable_collisions link1="base" link2="upper" reason="Never"/></robot>"""


def test_the_group_of_the_request_in_the_srdf(folder):
    (folder / "lifter.srdf").write_text(SRDF)
    scene = Scene.load(folder / "scene0001.yaml", robot=folder / "lifter.urdf", srdf=folder / "lifter.srdf")
    assert scene.robot.link_names[scene.robot.tip] == "fore"
    pair = next(p for p in scene.robot.pair_table if {p.first, p.second} == {"base", "upper"})
    assert not pair.checked
    (folder / "request0001.yaml").write_text(
        "group_name: arm\nstart_state: {joint_state: {name: [nod], position: [0.1]}}" + POSE.replace("palm", "fore")
    )
    scene = Scene.load(folder / "scene0001.yaml", robot=folder / "lifter.urdf", srdf=folder / "lifter.srdf")
    assert scene.robot.joint_names == ("turn", "nod")  # the lift is none of the group


def test_frames(folder):
    place = folder / "scene0001.yaml"
    place.write_text(SCENE.replace("{id: wall,", "{id: wall, header: {frame_id: base},"))
    assert Scene.load(place, robot=folder / "lifter.urdf").obstacles[0].center[0] == 1.5
    place.write_text(SCENE.replace("{id: wall,", "{id: wall, header: {frame_id: upper},"))
    with pytest.raises(InputError, match="'upper' is not at the robot's base 'base'") as caught:
        Scene.load(place, robot=folder / "lifter.urdf")
    assert "scene0001.yaml:6:" in caught.value.place
    place.write_text(SCENE.replace("{id: wall,", "{id: wall, header: {frame_id: camera},"))
    with pytest.raises(InputError, match="unknown frame 'camera'"):
        Scene.load(place, robot=folder / "lifter.urdf")
    fixed = (
        "fixed_frame_transforms: [{child_frame_id: camera, transform: {translation: [0, 0, 1], "
        "rotation: [0, 0, 0.70710678118655, 0.70710678118655]}}]\n"
    )
    place.write_text(fixed + place.read_text())
    wall = Scene.load(place, robot=folder / "lifter.urdf").obstacles[0]
    np.testing.assert_allclose(wall.center, [0, 1.5, 2], atol=1e-9)
    # a robot that stands elsewhere: the world's objects move against it, those of its base do not
    moved = "robot_state: {multi_dof_joint_state: {transforms: [{translation: [1, 0, 0], rotation: [0, 0, 0, 1]}]}, "
    for frame, x in (("world", 0.5), ("base", 1.5)):
        text = SCENE.replace("robot_state: {", moved).replace(
            "{id: wall,", f"{{id: wall, header: {{frame_id: {frame}}},"
        )
        place.write_text(text)
        assert Scene.load(place, robot=folder / "lifter.urdf").obstacles[0].center[0] == x


@pytest.mark.parametrize(
    ("file", "old", "new", "place", "message"),
    [
        ("scene", "world:", "wall:", "scene0001.yaml:2:", "no field 'world'.*collision_objects: .."),
        ("scene", "type: box", "type: prism", "scene0001.yaml:6:", "unknown primitive 'prism'; valid: box, cone, cylinder, sphere"),
        ("request", "joint_name: nod", "joint_name: knot", "request0001.yaml", "no joint 'knot' that moves; valid: left, lift, nod"),
        ("request", "[turn, nod], position: [0.2, -0.4]", "[turn], position: [0.2]", "request0001.yaml", "no value for 'nod'"),
        ("request", "[0.2, -0.4]", "[0.2, -3.4]", "request0001.yaml: start", "joint 'nod' is -3.4, outside its limits"),
        ("request", "goal_constraints", "goals", "request0001.yaml", "the request has no goal"),
        ("request", "group_name: arm", "path_constraints: {joint_constraints: [{joint_name: nod}]}", "0001.yaml:2:", "on the way"),
        ("request", "velocity_scaling_factor: 0.5", "velocity_scaling_factor: fast", "request0001.yaml:", "number, got 'fast'"),
        ("request", "position: 0.5", "position: []", "request0001.yaml:4:", "expected a finite number, got .."),
        ("request", "name: [turn, nod]", "name: 2", "request0001.yaml:3:", "expected a list, got int"),
        ("scene", "type: box", "type: [box]", "scene0001.yaml:6:", "unknown primitive .'box'.; valid: box"),
        ("scene", "primitives: [{type: box, dimensions: [0.1, 2, 2]}], primitive_poses", f"meshes: {2 * [MESH]}, mesh_poses",
         "scene0001.yaml:6:", "2 meshes but 1 mesh_poses"),
        ("scene", "primitives: [{type: box, dimensions: [0.1, 2, 2]}], primitive_poses", f"meshes: {[MESH]}, mesh_poses",
         "scene0001.yaml:6:", "expected three vertex numbers, got .0, 1, 2.5."),
        ("scene", "primitives: [{type: box, dimensions: [0.1, 2, 2]}], primitive_poses", f"meshes: {[FAR]}, mesh_poses",
         "scene0001.yaml:6:", "outside 0 .. 2"),
        ("scene", "primitives: [{type: box, dimensions: [0.1, 2, 2]}], primitive_poses", "planes: [{coef: [0, 0, 0, 1]}], plane_poses",
         "scene0001.yaml:6:", "zero vector"),
        ("scene", "{position: [1.5, 0, 1]}", "{position: [1.5, 0, 1], orientation: [0, 0, 1.6]}", "scene0001.yaml:6:",
         "quaternion .x, y, z, w., got 3 numbers .*orientation_euler_xyz: radians"),
        ("scene", "{position: [1.5, 0, 1]}", "{position: [1.5, 0, 1], orientation_euler_xyz: [0, 0, 90]}", "scene0001.yaml:6:",
         "90 radians are more than a turn"),
        ("scene", "{position: [1.5, 0, 1]}", "{orientation: [0, 0, 0, 1], orientation_euler_xyz: [0, 0, 1]}", "scene0001.yaml:6:",
         "two rotations.*keep one"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_place_and_remedy(folder, file, old, new, place, message):
    path = folder / f"{file}0001.yaml"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(InputError, match=message) as caught:
        Scene.load(folder / "scene0001.yaml", robot=folder / "lifter.urdf")
    assert place in caught.value.place


def test_what_is_missing_is_asked_for(folder):
    scene, urdf = folder / "scene0001.yaml", folder / "lifter.urdf"
    with pytest.raises(InputError, match=r"names its robot \('lifter'\) and holds no model.*a URDF"):
        Scene.load(scene)
    with pytest.raises(InputError, match="this is a motion-plan request"):
        Scene.load(folder / "request0001.yaml", robot=urdf)
    (folder / "kitchen.yaml").write_text(SCENE)
    with pytest.raises(InputError, match=r"no goal, since it has no request .*request0001.yaml beside"):
        Scene.load(folder / "kitchen.yaml", robot=urdf)
    assert Scene.load(folder / "kitchen.yaml", robot=urdf, request=folder / "request0001.yaml").name == "kitchen"
    with pytest.raises(InputError, match="`robot`, `tip`: for MoveIt scenes"):
        Scene.load("humanoid-reach", robot="panda", tip="x")
    with pytest.raises(InputError, match="start_state has no value for 'panda_joint1'"):
        Scene.load(scene, robot="panda")


def archive_of(folder: Path, file: Path, more: tuple[str, ...] = ()) -> Path:
    with tarfile.open(file, "w:bz2") as archive:
        for name in ("box_arm", "cage_arm", "cage_leg"):
            for number in ("0001", "0002", "0010"):
                for kind in ("scene", "request"):
                    archive.add(folder / f"{kind}0001.yaml", f"problems/{name}/{kind}{number}.yaml")
        for name in more:
            archive.add(folder / "scene0001.yaml", name)
    return file


@pytest.mark.parametrize(
    ("name", "full"),
    [
        ("box_arm/0002", "box_arm/0002"),
        ("box/0002", "box_arm/0002"),
        ("box/2", "box_arm/0002"),
        ("problems/cage_leg/scene0010.yaml", "cage_leg/0010"),
        ("cage_l/request0010", "cage_leg/0010"),
    ],
)
def test_problems_of_an_archive_by_name(folder, name, full):
    file = archive_of(folder, folder / "set.tar.bz2")
    assert ProblemSet.read(file).find(name) == full
    scene = Scene.load(f"{file}:{name}", robot=folder / "lifter.urdf")
    assert scene.name == full.replace("/", "-") and full.split("/")[0] in scene.source


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("", "there are 9 problems; valid: box_arm, cage_arm, cage_leg .*PATH:SET/NUMBER"),
        ("cage/0001", "'cage' may be several sets; valid: cage_arm, cage_leg"),
        ("cgae_arm/0001", "unknown set 'cgae_arm'; .*did you mean 'cage_arm'"),
        ("box_arm", "'box_arm' is a set of 3 problems; valid: 0001, 0002, 0010"),
        ("box_arm/0011", "no problem '0011' in 'box_arm'; valid: 0001, 0002, 0010 .name one as"),
        ("0001", "'0001' names no set"),
    ],
)
def test_names_that_are_none(folder, name, message):
    file = archive_of(folder, folder / "set.tar.bz2")
    with pytest.raises(InputError, match=message) as caught:
        Scene.load(f"{file}:{name}" if name else file, robot=folder / "lifter.urdf")
    assert caught.value.place == str(file)


def test_archives_that_are_none(folder):
    with pytest.raises(InputError, match="no such file or folder"):
        Scene.load(f"{folder}/none.tar.bz2:a/1", robot=folder / "lifter.urdf")
    good = archive_of(folder, folder / "set.tar.bz2").read_bytes()
    for name, content in (("half.tar.bz2", good[: len(good) // 2]), ("noise.tgz", bytes(range(256)))):
        (folder / name).write_bytes(content)
        with pytest.raises(InputError, match="not a readable archive"):
            Scene.load(f"{folder / name}:box/1", robot=folder / "lifter.urdf")
    alone = folder / "one.tar"
    with tarfile.open(alone, "w") as archive:
        for kind in ("scene", "request"):
            archive.add(folder / f"{kind}0001.yaml", f"{kind}0001.yaml")
    assert Scene.load(alone, robot=folder / "lifter.urdf").name == "0001"  # there is no other
    text = tarfile.TarInfo("scene0003.yaml")
    text.size = 4
    with tarfile.open(folder / "latin.tar", "w") as archive:
        archive.addfile(text, io.BytesIO(b"\xff\xfe\xfd\xfc"))
    with pytest.raises(InputError, match=r"latin\.tar/scene0003\.yaml: cannot be read"):
        Scene.load(folder / "latin.tar", robot=folder / "lifter.urdf")


def test_saved_as_a_scene_of_ours_it_is_the_same_problem(shared_data, tmp_path):
    archive, seed = shared_data / "mbm_panda_problems.tar.bz2", 5
    rng = np.random.default_rng(seed)
    found = ProblemSet.read(archive)
    model = robots.load(shared_data / "panda_spheres.urdf", tip="panda_hand")
    for folder in found.sets:
        name = f"{folder}/{rng.integers(1, 101):04}"
        scene = found.problem(found.scenes[name]).scene(model)
        again = Scene.load(scene.save(tmp_path / f"{folder}.yaml"))
        assert (tmp_path / f"{folder}.robot.yaml").is_file()
        np.testing.assert_array_equal(again.start.q, scene.start.q)
        np.testing.assert_array_equal(again.goal.q, scene.goal.q)
        assert [o.name for o in again.obstacles] == [o.name for o in scene.obstacles]
        assert again.robot.pair_table == scene.robot.pair_table and again.robot.joint_names == scene.robot.joint_names
        q = rng.uniform(model.limits.lower, model.limits.upper, (50, 7))
        for obstacles, own in ((scene.obstacles, False), ((), True)):
            there = again.obstacles if obstacles else ()
            np.testing.assert_allclose(
                distance.signed(again.robot, q, there, self_collision=own),
                distance.signed(scene.robot, q, obstacles, self_collision=own),
                atol=1e-12, err_msg=f"{name}, seed {seed}",
            )  # fmt: skip


HELD = """robot_state:
  joint_state: {name: [lift], position: [0.3]}
  attached_collision_objects:
    - {link_name: palm, touch_links: [left], object: {id: part, primitives: [{type: sphere, dimensions: [0.04]}],
       primitive_poses: [{position: [0.12, 0, 0]}]}}
allowed_collision_matrix: {entry_names: [part, wall, base, fore],
                           entry_values: [[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1], [0, 0, 1, 0]]}
"""


def test_what_is_held_and_allowed_is_saved_with_it(folder):
    place = folder / "scene0001.yaml"
    place.write_text(HELD + SCENE[SCENE.index("world:") :])
    scene = Scene.load(place, robot=folder / "lifter.urdf")
    again = Scene.load(scene.save(folder / "mine.yaml"))
    robot = again.robot
    assert "part" in robot.link_names and ("part", "wall") in robot.allowed_obstacles
    assert robot.pair_table == scene.robot.pair_table and robot.allowed_obstacles == scene.robot.allowed_obstacles
    reasons = {frozenset((p.first, p.second)): p.reason for p in robot.pair_table if not p.checked}
    assert "left" in {name for pair in reasons for name in pair if "part" in pair}
    assert (
        robot.content == scene.robot.content
        and again.options == scene.options
        and again.start.q.tolist() == [0.2, -0.4]
    )
    q = np.random.default_rng(3).uniform(-1.5, 1.5, (40, 2))
    for other in ((), again.obstacles):
        ours, theirs = (distance.signed(r, q, other, self_collision=not other) for r in (robot, scene.robot))
        np.testing.assert_array_equal(ours, theirs)
