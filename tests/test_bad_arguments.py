"""What a public function cannot use is refused by name, never by a raw error of numpy or Python from within."""

import numpy as np
import pytest

import horosphere as hs
from horosphere.errors import InputError
from horosphere.shapes import Ball, Box, Mesh, PointCloud

PANDA = hs.robots.load("panda")
Q = np.array([0.3, -0.5, 0.2, -2.2, 0.1, 1.8, 0.6])
BOX = Box([0, 0, 0], [1, 1, 1])
POINT = hs.Point.from_euclidean([1, 2, 3])
STAR = hs.maps.lobed([0, 0], 1.0, 0.2, 3)

ROBOT = [  # a name in the place of a robot
    ("forward", lambda: hs.kinematics.forward("panda", Q)),
    ("frames", lambda: hs.kinematics.frames("panda", Q)),
    ("jacobian", lambda: hs.kinematics.jacobian("panda", Q)),
    ("inverse", lambda: hs.kinematics.inverse("panda", hs.Motor.identity())),
    ("numerical_inverse", lambda: hs.kinematics.numerical_inverse("panda", POINT)),
    ("classify", lambda: hs.kinematics.classify("panda")),
    ("limit_arcs", lambda: hs.kinematics.limit_arcs("panda", hs.Motor.identity())),
    ("free_arcs", lambda: hs.kinematics.free_arcs("panda", hs.Motor.identity(), [])),
    ("roomiest", lambda: hs.kinematics.roomiest("panda", hs.Motor.identity(), [])),
    ("elbow_arcs", lambda: hs.kinematics.elbow_arcs("panda", hs.Motor.identity(), [])),
    ("signed", lambda: hs.distance.signed("panda", Q, [])),
    ("allowance", lambda: hs.distance.allowance("panda", hs.distance.pack_obstacles([]))),
    ("pack_robot", lambda: hs.distance.pack_robot("panda")),
    ("Reactive", lambda: hs.control.Reactive("panda", [])),
    ("clearance_bound", lambda: hs.certify.clearance_bound("panda", [Q])),
    ("connect", lambda: hs.planning.connect("panda", Q, Q)),
    ("react", lambda: hs.planning.react("panda", Q, Q)),
    ("starter_scene", lambda: hs.planning.starter_scene("panda", "panda")),
    ("describe", lambda: hs.robots.describe("panda")),
    ("save", lambda: hs.robots.save("panda", "x.yaml")),
    ("attach", lambda: hs.robots.attach("panda", BOX)),
    ("allow", lambda: hs.robots.allow("panda", [("a", "b")])),
    ("link_index", lambda: hs.robots.link_index("panda", "a")),
    ("Scene", lambda: hs.Scene(1.5, Q, Q)),
]

OTHERS = [
    ("shape: 1 values have no batch shape (2,)", lambda: POINT.reshape(2)),
    ("shape: a batch of shape () has no shape None", lambda: POINT.broadcast_to(None)),
    ("values: expected Point values, got int", lambda: hs.Point.stack(3)),
    ("value: expected a Multivector, got int", lambda: hs.Motor.from_multivector(3)),
    ("name: unknown blade 3; valid: 1, e1,", lambda: hs.Multivector.blade(3)),
    ("grades: expected grades 0..5", lambda: POINT.as_ipns().grade(np.ones(2))),
    ("PointCloud.radius: expected numbers, got text", lambda: PointCloud(np.eye(3), "text")),
    ("PointCloud.radius: expected one number or one for each of the 3", lambda: PointCloud(np.eye(3), [1.0, 2.0])),
    ("Mesh.faces: its rows differ in length", lambda: Mesh(np.eye(3), [[0, 1, 2], [0]])),
    ("mesh: expected a Mesh, got Ball", lambda: hs.shapes.box_cover(Ball([0, 0, 0], 1.0))),
    ("cloud: expected a PointCloud, got int", lambda: hs.shapes.ball_tree(3)),
    ("shapes[0]: expected a Shape, got str", lambda: hs.shapes.pack(("ball",))),
    ("semi_axes: expected numbers above 0", lambda: hs.shapes.ellipsoid_signed_distance([1, 1], [1, 0])),
    ("name_or_path: expected the path of a file, got NoneType", lambda: hs.robots.load(None)),
    ("link_radius: expected numbers, got text", lambda: hs.robots.load("panda", link_radius="wide")),
    ("d0: expected numbers, got None", lambda: hs.robots.humanoid_arm(None, 0.1, 0.3, 0.3, 0.1)),
    ("capsule a: expected shape (2, 3)", lambda: hs.robots.Capsules([0, 0], np.ones(3), np.ones((2, 3)), [1, 1])),
    ("name: expected a name", lambda: PANDA.with_attached(BOX, name=None)),
    ("allowed: expected names, got 'table'", lambda: PANDA.with_attached(BOX, allowed="table")),
    ("with_allowed: expected pairs of two names", lambda: hs.robots.allow(PANDA, 3)),
    ("link: unknown link 3; valid: panda_hand,", lambda: hs.kinematics.jacobian(PANDA, Q, link=3)),
    ("attempts: expected a whole number, got 2.5", lambda: hs.kinematics.numerical_inverse(PANDA, POINT, attempts=2.5)),
    ("tolerance: expected a number above 0", lambda: hs.kinematics.numerical_inverse(PANDA, POINT, tolerance=0)),
    ("below: expected numbers, got None", lambda: hs.distance.table(PANDA, Q, [BOX]).contacts(None)),
    ("seed: expected a whole number", lambda: hs.fields.random_world("balls", None)),
    ("x: expected shape (..., 2)", lambda: hs.fields.HarmonicField([0, 0], ([[1, 1]], [0.1])).obstructed([1, 2, 3])),
    ("radius: expected numbers, got text", lambda: hs.maps.lobed([0, 0], "wide", 0.2, 3)),
    ("parts[1]: expected a star, got int", lambda: hs.maps.union([STAR, 3])),
    ("mu: expected numbers, got text", lambda: hs.maps.Joukowski.aerofoil(1.0, "mu")),
    ("period: expected one number, got shape (2,)", lambda: hs.control.Reactive(PANDA, [], period=[1, 2])),
    ("gain: expected numbers, got None", lambda: hs.control.SlidingMode(None)),
    ("path: expected the path of a file, got NoneType", lambda: hs.Scene.load(None)),
    ("PointRobot.dimension: expected a whole number", lambda: hs.scenes.PointRobot(2.5)),
    ("quaternion: expected shape (..., 4)", lambda: hs.scenes.quaternion_matrix([1, 0, 0])),
    ("names: expected the joints' names", lambda: hs.scenes.Trajectory([0], np.zeros((1, 2)), names="ab")),
    ("duration: expected numbers, got None", lambda: hs.snake.Snake(5).simulate(np.zeros(7), [0, 0, 0, 0], None)),
    ("snake: expected a Snake, got str", lambda: hs.snake.serpenoid("snake", np.zeros(7))),
    ("scene: expected a Scene, got str", lambda: hs.certify.certify("panda-table", [Q])),
    ("scene.robot: not for a SnakeRobot", lambda: hs.certify.certify(hs.Scene.load("snake-gap"), np.zeros((2, 8)))),
    ("margin: expected numbers, got None", lambda: hs.certify.clearance_bound(PANDA, [Q], [BOX], None)),
    ("seed: expected a whole number, got 1.5", lambda: hs.planning.connect(PANDA, Q, Q, seed=1.5)),
    ("time_limit: expected numbers, got None", lambda: hs.planning.connect(PANDA, Q, Q, time_limit=None)),
    ("trajectory: expected a Trajectory, got list", lambda: hs.planning.resample([Q], 100.0)),
    ("count: expected at least 1, got 0", lambda: hs.planning.bench_random("panda", count=0)),
    ("repeats: expected at least 1, got 0", lambda: hs.planning.bench_random("panda", repeats=0)),
    ("clearance: expected a number at least 0", lambda: hs.planning.bench_random("panda", clearance=-1.0)),
    ("path: expected the path of a file, got NoneType", lambda: hs.io.load_trajectory(None)),
    ("trajectory: expected a Trajectory, got NoneType", lambda: hs.io.save_trajectory(None, "x.npz")),
    ("path: expected the path of a file, got int", lambda: hs.io.save_json({}, 3)),
    ("nothing between the brackets", lambda: hs.snake.word_text([])),
]  # fmt: skip


@pytest.mark.parametrize(("name", "call"), ROBOT, ids=[name for name, _ in ROBOT])
def test_a_robot_is_expected(name, call):
    with pytest.raises(InputError, match=r"robot: expected a Robot, got (str|float)") as error:
        call()
    assert error.value.place == "robot" and "robots.load" in error.value.remedy


@pytest.mark.parametrize(("said", "call"), OTHERS, ids=[said.split(":")[0] for said, _ in OTHERS])
def test_the_argument_is_named(said, call):
    with pytest.raises(InputError) as error:
        call()
    assert said in str(error.value) and error.value.place
