"""Scene files that are right."""

import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from horosphere import scenes, shapes
from horosphere.scenes import Scene

POINT = """
horosphere/scene: 1
robot: {type: point, radius: 1e-2}
start: {position: [0, 0, 0]}
goal: {position: [1.0, 0.5, 1e-1]}
"""


def load(tmp_path, text, name="scene.yaml"):
    file = tmp_path / name
    file.write_text(text)
    return Scene.load(file)


def test_numbers_are_read_as_yaml_1_2_means_them(tmp_path):
    scene = load(tmp_path, POINT)
    assert scene.robot.radius == 0.01
    assert scene.goal.position.tolist() == [1.0, 0.5, 0.1]
    assert (scene.robot.dimension, scene.dimension, scene.name) == (3, 3, "scene")


def test_every_obstacle(tmp_path):
    np.save(tmp_path / "cloud.npy", np.arange(12.0).reshape(4, 3))
    (tmp_path / "tetra.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    scene = load(
        tmp_path,
        POINT
        + """
obstacles:
  - {type: sphere, name: s, center: [1, 2, 3], radius: 0.5}
  - {type: ellipsoid, center: [0, 0, 1], semi_axes: [1, 2, 3], rpy_deg: [10, 20, 30]}
  - {type: capsule, a: [0, 0, 0], b: [0, 0, 1], radius: 0.1}
  - {type: cylinder, a: [0, 0, 0], b: [0, 0, 1], radius: 0.1}
  - {type: cylinder, center: [0, 0, 0.5], axis: [0, 0, 2], length: 1, radius: 0.1}
  - {type: box, center: [1, 0, 0], size: [1, 2, 4], quaternion_wxyz: [0, 1, 0, 0]}
  - {type: half-space, normal: [0, 0, 2], distance: 1}
  - {type: half-space, normal: [0, 0, 2], point: [5, 5, 0.5]}
  - {type: mesh, file: tetra.obj, scale: 2, position: [0, 0, 1], rpy: [0, 0, 1.5707963267948966]}
  - {type: points, file: cloud.npy, radius: 0.01}
  - {type: points, points: [[1, 2, 3]], radius: 0}
""",
    )
    o = scene.obstacles
    assert [type(x).__name__ for x in o] == (
        [
            "Ball",
            "Ellipsoid",
            "Capsule",
            "Cylinder",
            "Cylinder",
            "Box",
            "HalfSpace",
            "HalfSpace",
            "Mesh",
            "PointCloud",
            "PointCloud",
        ]
    )
    assert (o[0].name, o[0].radius, o[0].center.tolist()) == ("s", 0.5, [1, 2, 3])
    expected = Rotation.from_euler("xyz", [10, 20, 30], degrees=True).as_matrix()
    np.testing.assert_allclose(o[1].rotation, expected, atol=1e-15)
    np.testing.assert_allclose([o[3].a, o[3].b], [o[4].a, o[4].b], atol=1e-15)
    assert o[5].half_sizes.tolist() == [0.5, 1, 2]
    np.testing.assert_allclose(o[5].rotation, np.diag([1.0, -1, -1]), atol=1e-15)
    assert o[6].normal.tolist() == [0, 0, 1] and o[6].distance == o[7].distance == 0.5
    # twice as large, a quarter turn about z, one up
    corners = {tuple(np.round(v, 9) + 0.0) for v in o[8].vertices}
    assert corners == {(0, 0, 1), (0, 2, 1), (-2, 0, 1), (0, 0, 3)}
    assert o[9].points.shape == (4, 3)


def test_plane_obstacles(tmp_path):
    scene = load(
        tmp_path,
        """
horosphere/scene: 1
robot: {type: point, radius: 0.01}
start: {position: [0, 0]}
goal: {position: [4, 0]}
obstacles:
  - {type: disk, center: [1, 0], radius: 0.2}
  - {type: ellipse, center: [2, 0], semi_axes: [0.5, 0.2], angle_deg: 30}
  - {type: aerofoil, center: [3, 0], k: 0.3, mu: [-0.03, 0.02], angle: 0.1}
  - {type: star, center: [2, 2], radius: 0.4, lobes: 6, amplitude: 0.2}
workspace: {center: [2, 0], radius: 5}
field: {rule: planar-log, blending: W1, exponents: [1, 2, 3, 4]}
control: {period: 0.005, law: explicit}
""",
    )
    disk, ellipse, aerofoil, star = scene.obstacles
    assert isinstance(disk, shapes.Ball) and disk.dimension == 2
    assert ellipse.angle == pytest.approx(np.radians(30))
    assert aerofoil.mu == -0.03 + 0.02j
    assert star.lobes == 6
    assert scene.workspace.radius == 5
    assert scene.field.exponents == (1, 2, 3, 4)
    assert scene.control.law == "explicit"


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("{joints: [0.1, 0.2, 0.3, 0.4, 0.5]}", [0.1, 0.2, 0.3, 0.4, 0.5]),
        ("{joints_deg: [90, 0, 0, 0, 0]}", [np.pi / 2, 0, 0, 0, 0]),
        ("{joints: {joint_5: 0.5, joint_1: 0.1, joint_2: 0, joint_3: 0, joint_4: 0}}", [0.1, 0, 0, 0, 0.5]),
    ],
)
def test_joint_targets(tmp_path, written, expected):
    text = f"horosphere/scene: 1\nrobot: humanoid-arm\nstart: {written}\ngoal: {{position: [0.3, 0, 0.3]}}\n"
    scene = load(tmp_path, text)
    np.testing.assert_allclose(scene.start.q, expected)


def test_tool_targets(tmp_path):
    head = "horosphere/scene: 1\nrobot: humanoid-arm\nstart: {position: [0.3, 0, 0.3], plane_normal: [0, 2, 0]}\n"
    for written, kind in (
        ("{position: [0.3, 0, 0.3]}", scenes.PositionTarget),
        ("{position: [0.3, 0, 0.3], plane_normal: [0, 1, 0]}", scenes.GripperPlaneTarget),
        ("{position: [0.3, 0, 0.3], rpy_deg: [0, 0, 90]}", scenes.PoseTarget),
        ("{position: [0.3, 0, 0.3], quaternion_wxyz: [1, 0, 0, 0]}", scenes.PoseTarget),
        ("{line: {point: [0, 0, 1], direction: [0, 2, 0]}}", scenes.LineTarget),
        ("{plane: {normal: [0, 2, 0], point: [5, 0.3, 1]}}", scenes.PlaneTarget),
    ):
        scene = load(tmp_path, head + f"goal: {written}\n")
        assert type(scene.goal) is kind
    assert scene.goal.distance == pytest.approx(0.3)
    assert scene.start.normal.tolist() == [0, 1, 0]


def test_pose_target_is_the_motor_it_says(tmp_path):
    target = scenes.PoseTarget([1, 2, 3], scenes.matrix_quaternion(Rotation.from_rotvec([0.1, -0.4, 2.0]).as_matrix()))
    expected = np.eye(4)
    expected[:3, :3] = Rotation.from_rotvec([0.1, -0.4, 2.0]).as_matrix()
    expected[:3, 3] = [1, 2, 3]
    np.testing.assert_allclose(target.motor().as_matrix(), expected, atol=1e-14)


@pytest.mark.parametrize("seed", range(5))
def test_quaternions_against_scipy(seed):
    rng = np.random.default_rng(seed)
    R = Rotation.random(random_state=seed).as_matrix() if seed else Rotation.from_rotvec([np.pi, 0, 0]).as_matrix()
    np.testing.assert_allclose(scenes.quaternion_matrix(scenes.matrix_quaternion(R)), R, atol=1e-14)
    rpy = rng.uniform(-3, 3, 3)
    from horosphere.scenes._targets import rpy_quaternion

    expected = Rotation.from_euler("xyz", rpy).as_matrix()
    np.testing.assert_allclose(scenes.quaternion_matrix(rpy_quaternion(rpy)), expected, atol=1e-14)


def test_mechanism_with_its_own_radii_and_limits(tmp_path):
    scene = load(
        tmp_path,
        """
horosphere/scene: 1
robot: {mechanism: humanoid_arm, d0: 0.2, h: 0.1, d1: 0.3, d2: 0.3, d3: 0.1, link_radius: [0.05, 0.04, 0.03],
        lower_deg: [-90, -90, -90, -90, -90], velocity: 1.5}
start: {joints: [0, 0, 0, 0, 0]}
goal: {position: [0.3, 0, 0.3]}
""",
    )
    assert scene.robot.closed_form[1]["d0"] == 0.2
    assert {0.05, 0.04, 0.03} <= set(scene.robot.capsules.radius)
    np.testing.assert_allclose(scene.robot.limits.lower, -np.pi / 2)
    assert scene.robot.limits.velocity.tolist() == [1.5] * 5


def test_urdf_with_a_capsule_file_beside_it(tmp_path):
    (tmp_path / "two.urdf").write_text(
        """<robot name="two"><link name="base"/><link name="arm"/><link name="hand"/>
        <joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" velocity="2" effort="3"/></joint>
        <joint name="f" type="fixed"><parent link="arm"/><child link="hand"/><origin xyz="0 0 0.5"/></joint></robot>"""
    )
    (tmp_path / "bodies.yaml").write_text(
        "horosphere/capsules: 1\nlinks:\n  arm: [{a: [0, 0, 0], b: [0, 0, 0.5], radius: 0.07}]\n"
    )
    text = """
horosphere/scene: 1
robot: {urdf: two.urdf, capsules: bodies.yaml}
start: {joints: {j: -0.5}}
goal: {joints: {j: 0.5}}
"""
    robot = load(tmp_path, text).robot
    assert robot.capsules.radius.tolist() == [0.07]
    robot = load(tmp_path, text.replace("capsules: bodies.yaml", "link_radius: 0.06")).robot
    assert set(robot.capsules.radius) == {0.06}


def test_snake_and_unicycle(tmp_path):
    scene = load(
        tmp_path,
        "horosphere/scene: 1\nrobot: {type: snake, links: 4, length: 1.0}\n"
        "start: {position: [0, 0], heading: 0, joints: [0.1, 0.2, 0.3]}\n"
        "goal: {position: [1, 2], heading_deg: 90, joints_deg: [0, 0, 90]}\n",
    )
    assert scene.robot.lengths.tolist() == [1, 1, 1, 1]
    np.testing.assert_allclose(scene.goal.q, [1, 2, np.pi / 2, 0, 0, np.pi / 2])
    scene = load(
        tmp_path,
        "horosphere/scene: 1\nrobot: {type: unicycle}\nstart: {position: [0, 0], heading: 1}\ngoal: {position: [1, 2]}\n",
    )
    assert (scene.start.heading, scene.goal.heading) == (1.0, None)


@pytest.mark.parametrize("name", scenes.names())
def test_library(name):
    scene = Scene.load(name)
    assert scene.name == name
    assert scene.description


def test_humanoid_reach_holds_the_published_numbers():
    scene = Scene.load("humanoid-reach")
    assert scene.robot.closed_form == ("humanoid_arm", {"d0": 0.1, "h": 0.1, "d1": 0.35, "d2": 0.3, "d3": 0.15})
    assert scene.start.position.tolist() == [0.33, 0, 0.31]
    assert scene.goal.position.tolist() == [0.41, 0.07, -0.32]
    (ball,) = scene.obstacles
    assert (ball.center.tolist(), ball.radius) == ([0.33, 0.03, -0.03], 0.075)
    assert scene.options.clearance >= 0.014
    assert scene.options.max_joint_step == pytest.approx(np.radians(5))


def test_package_paths(tmp_path, monkeypatch):
    package = tmp_path / "ws" / "my_robot"
    (package / "meshes").mkdir(parents=True)
    np.save(package / "meshes" / "cloud.npy", np.ones((2, 3)))
    text = POINT + "obstacles:\n  - {type: points, file: 'package://my_robot/meshes/cloud.npy', radius: 0.1}\n"
    (package / "scenes").mkdir()
    assert len(load(package / "scenes", text).obstacles[0].points) == 2  # a folder above the scene
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    with pytest.raises(scenes.SceneError, match="ROS_PACKAGE_PATH"):
        load(elsewhere, text)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ws"))
    assert len(load(elsewhere, text).obstacles[0].points) == 2


def test_aliases_of_yaml(tmp_path):
    scene = load(tmp_path, POINT + "obstacles:\n  - &a {type: sphere, center: [9, 9, 9], radius: 0.1}\n  - *a\n")
    assert len(scene.obstacles) == 2


def test_pickle():
    scene = pickle.loads(pickle.dumps(Scene.load("humanoid-reach")))
    assert scene.robot.n_joints == 5 and scene.obstacles[0].radius == 0.075
