"""MoveIt planning scenes and requests: what they mean, sets of them in folders and archives, and what is wrong with bad ones."""

import io
import re
import tarfile

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from horosphere import kinematics, robots
from horosphere.errors import InputError
from horosphere.scenes import JointTarget, PoseTarget
from horosphere.scenes._moveit_files import read_moveit, read_moveit_set
from horosphere.shapes import Ball, Box, Cylinder, HalfSpace, Mesh

SCENE = """
name: shelf
robot_model_name: panda
robot_state:
  joint_state: {name: [panda_finger_joint1], position: [0.02]}
  multi_dof_joint_state:
    joint_names: [virtual_joint]
    transforms: [{translation: [0, 0, BASE], rotation: [0, 0, 0, 1]}]
world:
  collision_objects:
    - id: board
      primitives: [{type: box, dimensions: [0.6, 0.4, 0.02]}]
      primitive_poses: [{position: [0.5, 0, 0.4], orientation: [0, 0, 0.38268343236, 0.92387953251]}]
    - id: tins
      primitives:
        - {type: cylinder, dimensions: [0.2, 0.03]}
        - {type: 2, dimensions: [0.05]}
        - {type: cone, dimensions: [0.1, 0.04]}
      primitive_poses:
        - {position: {x: 0.5, y: 0.1, z: 0.5}, orientation_euler_xyz: [0.3, -0.2, 0.5]}
        - {position: [0.4, 0, 0.5]}
        - {position: [0.4, 0.2, 0.5]}
    - {id: gone, operation: 1}
    - id: floor
      planes: [{coef: [0, 0, 2, 0.2]}]
    - id: wedge
      pose: {position: [1, 0, 0], orientation: [0, 0, 0, 1]}
      meshes: [{vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
                triangles: [{vertex_indices: [0, 2, 1]}, {vertex_indices: [0, 1, 3]}, [0, 3, 2], [1, 2, 3]]}]
      mesh_poses: [{position: [0, 0, 0.5], orientation: [0, 0, 0, 1]}]
"""
REQUEST = """
group_name: panda_arm
start_state: {joint_state: {name: [panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, panda_joint7],
              position: [0, -0.785, 0, -2.356, 0, 1.571, 0.785]}}
goal_constraints:
  - joint_constraints:
      - {joint_name: panda_joint7, position: 0.7}
      - {joint_name: panda_joint1, position: 0.1}
      - {joint_name: panda_joint2, position: 0.2}
      - {joint_name: panda_joint3, position: 0.3}
      - {joint_name: panda_joint4, position: -0.4}
      - {joint_name: panda_joint5, position: 0.5}
      - {joint_name: panda_joint6, position: 0.6}
  - position_constraints: [{link_name: panda_hand, constraint_region: {primitive_poses: [{position: [0.5, 0, 0.7]}]}}]
    orientation_constraints: [{orientation: [1, 0, 0, 0]}]
"""


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "shelf_set"
    place.mkdir()
    (place / "scene0001.yaml").write_text(SCENE.replace("BASE", "0"))
    (place / "request0001.yaml").write_text(REQUEST)
    return place


def test_what_a_scene_means(folder):
    problem = read_moveit(folder / "scene0001.yaml")
    board, tin, ball, cone, floor, wedge = problem.obstacles
    assert (board.name, tin.name, ball.name, floor.name) == ("board", "tins/0", "tins/1", "floor")
    assert (
        isinstance(board, Box) and isinstance(tin, Cylinder) and isinstance(ball, Ball) and isinstance(floor, HalfSpace)
    )
    np.testing.assert_allclose(board.half_sizes, [0.3, 0.2, 0.01])
    np.testing.assert_allclose(board.rotation, Rotation.from_euler("z", 45, degrees=True).as_matrix(), atol=1e-9)
    # Euler angles about the fixed axes x, y, z in that order
    axis = Rotation.from_euler("xyz", [0.3, -0.2, 0.5]).as_matrix()[:, 2]
    np.testing.assert_allclose(tin.b - tin.a, 0.2 * axis, atol=1e-12)
    np.testing.assert_allclose(0.5 * (tin.a + tin.b), [0.5, 0.1, 0.5])
    assert tin.radius == 0.03 and ball.radius == 0.05
    assert isinstance(cone, Cylinder) and any("cone" in note for note in problem.notes)
    np.testing.assert_allclose(floor.signed_distance([0.0, 0, 0.4]), 0.5)  # 2 z + 0.2 = 0
    assert isinstance(wedge, Mesh) and wedge.is_watertight
    np.testing.assert_allclose(wedge.vertices.min(axis=0), [1, 0, 0.5])
    robot = robots.load("panda")
    np.testing.assert_array_equal(problem.start_of(robot), [0, -0.785, 0, -2.356, 0, 1.571, 0.785])
    goal = problem.goal_of(robot)
    assert isinstance(goal, JointTarget)
    np.testing.assert_array_equal(goal.q, [0.1, 0.2, 0.3, -0.4, 0.5, 0.6, 0.7])
    pose = problem.goal_of(robot, 1)
    assert isinstance(pose, PoseTarget) and problem.goal_links[1] == "panda_hand"
    np.testing.assert_allclose(pose.position, [0.5, 0, 0.7 - 0.1034])  # of the tool, which the built-in Panda has
    np.testing.assert_allclose(np.abs(pose.quaternion), [0, 1, 0, 0], atol=1e-12)
    assert (problem.robot_name, problem.group, problem.start["panda_finger_joint1"]) == ("panda", "panda_arm", 0.02)


def test_obstacles_come_in_the_frame_of_the_base(folder):
    raised = folder / "scene0002.yaml"
    raised.write_text(SCENE.replace("BASE", "0.25"))
    np.testing.assert_allclose(read_moveit(raised).obstacles[0].center, [0.5, 0, 0.15])


def test_sets_in_folders_and_archives(folder, tmp_path):
    (folder / "scene0003.yaml").write_text(SCENE.replace("BASE", "0"))
    for name, mode in (("set.tar.bz2", "w:bz2"), ("set.tar", "w"), ("set.tar.gz", "w:gz")):
        with tarfile.open(tmp_path / name, mode) as archive:
            archive.add(folder, "problems/shelf_set")
        for place in (tmp_path / name, tmp_path):
            found = [x for x in read_moveit_set(place)]
            assert [(s, p.name, len(p.goals)) for s, p in found] == [
                ("shelf_set", "scene0001", 2),
                ("shelf_set", "scene0003", 0),
            ]
    assert next(iter(read_moveit_set(folder / "scene0001.yaml")))[1].goals


@pytest.mark.parametrize(
    ("old", "new", "place", "message"),
    [
        ("type: box", "type: torus", "yaml:12:", "unknown primitive 'torus'"),
        ("[0.6, 0.4, 0.02]", "[0.6, 0.4]", "yaml:12:", "expected 3 finite numbers"),
        ("[0.6, 0.4, 0.02]", "[0.6, 0.4, -1]", "yaml:12:", "sizes > 0"),
        ("0.92387953251]", "2.0]", "yaml:13:", "unit quaternion"),
        ("world:", "world: 3\nold:", "yaml:9:", "expected fields"),
        ("name: shelf", "name: [shelf", "yaml:", "not valid YAML"),
        (
            "{name: [panda_finger_joint1], position: [0.02]}",
            "{name: [a, b], position: [0.02]}",
            "yaml:5:",
            "2 names but 1 pos",
        ),
    ],
)
def test_what_is_wrong_is_named_with_its_place(folder, old, new, place, message):
    bad = folder / "scene0009.yaml"
    assert old in SCENE
    bad.write_text(SCENE.replace("BASE", "0").replace(old, new, 1))
    with pytest.raises(InputError, match=message) as caught:
        read_moveit(bad)
    assert place in caught.value.place


def test_other_trouble(folder, tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        read_moveit(tmp_path / "scene7.yaml")
    corrupt = tmp_path / "broken.tar.bz2"
    corrupt.write_bytes(b"BZh9" + bytes(range(200)))
    with pytest.raises(InputError, match="not a readable archive"):
        list(read_moveit_set(corrupt))
    whole = io.BytesIO()
    with tarfile.open(fileobj=whole, mode="w:bz2") as archive:
        archive.add(folder, "problems")
    corrupt.write_bytes(whole.getvalue()[:-40])
    with pytest.raises(InputError, match="not a readable archive"):
        list(read_moveit_set(corrupt))
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(InputError, match=r"no scene\*"):
        list(read_moveit_set(empty))
    with pytest.raises(InputError, match="no such file"):
        list(read_moveit_set(tmp_path / "nowhere"))
    with pytest.raises(InputError, match=r"no value for .* of robot 'ur5'"):
        read_moveit(folder / "scene0001.yaml").start_of(robots.load("ur5"))


def test_as_a_scene(folder):
    robot = robots.load("panda")
    scene = read_moveit(folder / "scene0001.yaml").scene(robot)
    assert scene.robot.content == robot.content and len(scene.obstacles) == 6 and scene.name == "scene0001"
    assert [note for note in scene.robot.notes if note not in robot.notes] == [
        "tins/2: the cone is enclosed in its cylinder",
        "the request has 2 goals; this is the motion to the first",
    ]


HELD = """
  attached_collision_objects:
    - link_name: panda_hand
      object: {header: {frame_id: FRAME}, id: cup, pose: {position: POSITION, orientation: [0, 0, 0, 1]},
               primitives: [{type: cylinder, dimensions: [0.1, 0.02]}], primitive_poses: [{position: [0, 0, 0.01]}]}
      touch_links: [panda_link7, no_such_link]
"""
MATRIX = """
allowed_collision_matrix:
  entry_names: [panda_link2, panda_link5, cup, tins, ghost]
  entry_values:
    - {enabled: [false, true, false, false, false]}
    - [true, false, false, false, false]
    - [false, false, false, true, false]
    - [false, false, true, false, false]
    - [false, false, false, false, false]
  default_entry_names: [board]
  default_entry_values: [true]
"""


def write_held(folder, frame="panda_hand", position="[0, 0, 0.1]", matrix=MATRIX, base="0"):
    path = folder / "scene0004.yaml"
    held = HELD.replace("FRAME", frame).replace("POSITION", position)
    text = SCENE.replace("robot_state:", "robot_state:" + held.rstrip()).replace("BASE", base)
    path.write_text(text + matrix)
    (folder / "request0004.yaml").write_text(REQUEST)
    return path


def bodies_of(robot, q, name):
    """Ends of a link's capsules in the base frame."""
    from horosphere.robots._placement import link_frames, move_points

    own = robot.capsules.link == robot.link_names.index(name)
    frame = link_frames(robot.links, q)[robot.link_names.index(name)]
    return np.stack([move_points(frame, robot.capsules.a[own]), move_points(frame, robot.capsules.b[own])])


def test_attached_objects_and_the_allowed_collision_matrix(folder):
    bare = robots.load("panda")
    problem = read_moveit(write_held(folder))
    robot = problem.scene(bare).robot
    q = problem.start_of(robot)
    assert set(robot.link_names) - set(bare.link_names) == {"cup"}
    # a cylinder of 0.1 m about (0, 0, 0.11) of the hand
    hand = kinematics.frames(bare, q).as_matrix()[bare.link_names.index("panda_hand")]
    middle = bodies_of(robot, q, "cup").mean(axis=(0, 1))
    np.testing.assert_allclose(middle, hand[:3, :3] @ [0, 0, 0.11] + hand[:3, 3], atol=1e-9)
    checked = {frozenset((robot.link_names[i], robot.link_names[j])) for i, j in robot.self_pairs}
    assert frozenset(("panda_link7", "cup")) not in checked and frozenset(("panda_link4", "cup")) in checked
    before = {frozenset((bare.link_names[i], bare.link_names[j])) for i, j in bare.self_pairs}
    pair = frozenset(("panda_link2", "panda_link5"))
    assert pair in before and pair not in checked
    allowed = set(robot.allowed_obstacles)
    assert {("cup", "tins/0"), ("cup", "tins/1"), ("cup", "tins/2")} <= allowed
    assert ("panda_hand", "tins/0") not in allowed and ("panda_link3", "floor") not in allowed
    assert {("panda_hand", "board"), ("cup", "board")} <= allowed  # the default of a name holds for all
    assert any("no link of 'panda': no_such_link" in note for note in robot.notes)
    assert any("neither links of 'panda' nor objects: ghost" in note for note in robot.notes)


@pytest.mark.parametrize("base", ["0", "0.25"])
def test_an_attached_object_stated_elsewhere_hangs_where_it_is(folder, base):
    robot = robots.load("panda")
    problem = read_moveit(write_held(folder, "world", "[0.4, 0.1, 0.9]", base=base))
    q = problem.start_of(robot)
    middle = bodies_of(problem.robot_of(robot), q, "cup").mean(axis=(0, 1))
    np.testing.assert_allclose(middle, [0.4, 0.1, 0.91 - float(base)], atol=1e-9)
    # without shapes the object of that name is picked up from the world
    path = write_held(folder)
    path.write_text(re.sub(r"object: \{header.*?\n.*?\n", "object: {id: tins}\n", path.read_text()))
    problem = read_moveit(path)
    picked = problem.scene(robot)
    assert len(picked.obstacles) == 3 and not any(o.name.startswith("tins") for o in picked.obstacles)
    far = np.linalg.norm(bodies_of(picked.robot, q, "tins").reshape(-1, 3) - [0.4, 0.0, 0.5], axis=1)
    assert far.min() < 1e-9  # its ball


@pytest.mark.parametrize(
    ("old", "new", "place", "message"),
    [
        ("link_name: panda_hand", "link_name: hand", "yaml:7:", "unknown link 'hand'.*did you mean"),
        ("frame_id: panda_hand", "frame_id: camera", "yaml:7:", "unknown frame 'camera'"),
        (
            "primitives: [{type: cylinder, dimensions: [0.1, 0.02]}], primitive_poses: [{position: [0, 0, 0.01]}]",
            "weight: 1",
            "yaml:7:",
            "'cup' has no shape",
        ),
        ("entry_names: [panda_link2,", "entry_names: [", "yaml:", "4 entry_names, but entry_values has 5 rows"),
        ("entry_names: [panda_link2,", "entry_names: [cup,", "yaml:", "'cup' stands in it twice"),
        ("[true, false, false, false, false]", "[true, 2, false, false, false]", "yaml:", "true and false"),
        ("[true, false, false, false, false]", "[true, false, true, false, false]", "yaml:", "contradict each other"),
        ("default_entry_values: [true]", "default_entry_values: []", "yaml:", "1 default_entry_names, but 0"),
    ],
)
def test_mistakes_about_contacts_are_named_with_their_place(folder, old, new, place, message):
    path = write_held(folder)
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(InputError, match=message) as caught:
        read_moveit(path).robot_of(robots.load("panda"))
    assert place in caught.value.place


def test_the_request_has_the_last_word_on_what_is_held(folder):
    write_held(folder)
    gone = "start_state: {attached_collision_objects: [{link_name: panda_hand, object: {id: cup, operation: 1}}], "
    (folder / "request0004.yaml").write_text(REQUEST.replace("start_state: {", gone))
    problem = read_moveit(folder / "scene0004.yaml")
    assert not problem.held and "cup" not in problem.robot_of(robots.load("panda")).link_names


def test_the_public_set(shared_data):
    archive = shared_data / "mbm_panda_problems.tar.bz2"
    if not archive.is_file():
        pytest.skip(f"{archive} is not there")
    found = list(read_moveit_set(archive))
    sets = {name: sum(s == name for s, _ in found) for name, _ in found}
    assert len(sets) == 7 and set(sets.values()) == {100}
    assert all(len(p.goals) == 1 and p.obstacles and not p.notes and not p.held for _, p in found)
    assert all(p.contacts.allowed("panda_hand", "panda_leftfinger") for _, p in found)
