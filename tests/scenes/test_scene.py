"""Scenes made in Python, saved and loaded again."""

import os

import numpy as np
import pytest

import horosphere.scenes as sc
from horosphere import entities, robots, shapes, versors
from horosphere.errors import InputError


def same(a, b):
    """Equal records, arrays to the last bits that text keeps."""
    assert type(a) is type(b)
    for name in type(a).__slots__ if hasattr(type(a), "__slots__") else vars(a):
        x, y = getattr(a, name), getattr(b, name)
        if isinstance(x, str) or x is None:
            assert x == y
        else:
            np.testing.assert_allclose(x, y, rtol=1e-13, atol=1e-14)


ROTATION = np.array([[0.0, -1.0, 0.0], [0.6, 0.0, -0.8], [0.8, 0.0, 0.6]])

SOLIDS = [
    shapes.Ball([1, 2, 3], 0.5, name="ball"),
    shapes.Ellipsoid([0, 0, 1], [0.1, 0.2, 0.3], ROTATION),
    shapes.Capsule([0, 0, 0], [0, 1, 0], 0.1),
    shapes.Cylinder([0, 0, 0], [0, 1, 0], 0.1),
    shapes.Box([1, 1, 1], [0.1, 0.2, 0.3], ROTATION, name="box"),
    shapes.HalfSpace([0, 0, 1], -0.1),
    shapes.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
    shapes.PointCloud([[1, 2, 3], [4, 5, 6]], 0.05),
]
PLANE = [
    shapes.Ball([1, 2], 0.5),
    sc.EllipsoidND([0, 1], [0.4, 0.2], np.array([[0.6, -0.8], [0.8, 0.6]])),
    sc.Aerofoil([1, 1], 0.3, -0.03 + 0.02j, 0.2),
    sc.Star([2, 2], 0.4, 6, 0.2, 0.1),
]
SCENES = {
    "arm": sc.Scene(
        robot="humanoid-arm",
        start=[0, 0, 0, 0, 0],
        goal=sc.GripperPlaneTarget([0.3, 0, 0.3], [0, 1, 0]),
        obstacles=SOLIDS,
    ),
    "point": sc.Scene(
        robot=sc.PointRobot(2, 0.05),
        start=[0, 0],
        goal=[3, 3],
        obstacles=PLANE,
        workspace=sc.Workspace([0, 0], 9.0),
        options=sc.Options(clearance=1e-3, seed=7),
        field=sc.FieldOptions(blending="W1", exponents=(1.0, 2.0, 3.0, 4.0)),
        control=sc.ControlOptions(law="super-twisting"),
        description="Two\nlines: [brackets] # and no comment",
    ),
    "4d": sc.Scene(
        robot=sc.PointRobot(4),
        start=[0, 0, 0, 0],
        goal=[1, 1, 1, 1],
        obstacles=[sc.EllipsoidND([3, 3, 3, 3], [1, 1, 2, 1])],
    ),
    "unicycle": sc.Scene(
        robot=sc.UnicycleRobot(0.2), start=sc.HeadingTarget([0, 0], 0.3), goal=sc.HeadingTarget([1, 1])
    ),
    "snake": sc.Scene(
        robot=sc.SnakeRobot([1, 2, 3]), start=sc.PostureTarget(np.arange(5.0)), goal=sc.PostureTarget(np.ones(5))
    ),
    "line": sc.Scene(
        robot="srs-arm", start=sc.PoseTarget([0.3, 0, 0.3], [1, 1, 0, 0]), goal=sc.LineTarget([0, 0, 1], [1, 0, 0])
    ),
    "plane": sc.Scene(robot="srs-arm", start=[0] * 7, goal=sc.PlaneTarget([0, 0, 2], 0.5)),
}


@pytest.mark.parametrize("name", SCENES)
def test_round_trip(tmp_path, name):
    scene = SCENES[name]
    again = sc.Scene.load(scene.save(tmp_path / f"{name}.yaml"))
    same(scene.start, again.start)
    same(scene.goal, again.goal)
    assert len(scene.obstacles) == len(again.obstacles)
    for a, b in zip(scene.obstacles, again.obstacles):
        same(a, b)
    assert (scene.options, scene.field, scene.control) == (again.options, again.field, again.control)
    assert scene.description == again.description
    assert type(scene.robot) is type(again.robot) and scene.robot.name == again.robot.name
    assert [p.name for p in tmp_path.iterdir()] == [f"{name}.yaml"]  # no temporary file stays


@pytest.mark.parametrize("name", sc.names())
def test_library_round_trip(tmp_path, name):
    scene = sc.Scene.load(name)
    again = sc.Scene.load(scene.save(tmp_path / "copy.yaml"))
    if hasattr(scene.robot, "content"):
        assert again.robot.content == scene.robot.content
        np.testing.assert_array_equal(again.robot.capsules.radius, scene.robot.capsules.radius)
    else:
        same(again.robot, scene.robot)
    for a, b in zip(scene.obstacles, again.obstacles, strict=True):
        same(a, b)
    assert again.options == scene.options


def test_paths_move_with_the_file(tmp_path):
    (tmp_path / "data").mkdir()
    np.save(tmp_path / "data" / "cloud.npy", np.ones((2, 3)))
    (tmp_path / "a.yaml").write_text(
        "horosphere/scene: 1\nrobot: {type: point}\nstart: {position: [0, 0, 0]}\ngoal: {position: [0, 0, 1]}\n"
        "obstacles:\n  - {type: points, file: data/cloud.npy, radius: 0.1}\n"
    )
    (tmp_path / "deep" / "er").mkdir(parents=True)
    saved = sc.Scene.load(tmp_path / "a.yaml").save(tmp_path / "deep" / "er" / "b.yaml")
    assert "../../data/cloud.npy" in saved.read_text()
    assert len(sc.Scene.load(saved).obstacles[0].points) == 2


def test_kind_constructor():
    motor = versors.Motor.from_matrix(np.block([[ROTATION, np.array([[0.1], [0.2], [0.3]])], [np.zeros((1, 3)), 1.0]]))
    scene = sc.Scene(
        robot="humanoid-arm",
        start=np.zeros(5),
        goal=motor,
        obstacles=[
            entities.Sphere.from_center_radius([1, 1, 1], 0.1),
            entities.Plane.from_normal_distance([0, 0, 1], -1.0),
        ],
    )
    assert isinstance(scene.start, sc.JointTarget)
    np.testing.assert_allclose(scene.goal.as_matrix(), motor.as_matrix(), atol=1e-14)
    assert [type(o) for o in scene.obstacles] == [shapes.Ball, shapes.HalfSpace]
    point = scene.with_(goal=entities.Point.from_euclidean([0.3, 0, 0.3]))
    np.testing.assert_allclose(point.goal.position, [0.3, 0, 0.3])


@pytest.mark.parametrize(
    ("changes", "place", "words"),
    [
        ({"start": np.zeros(4)}, "Scene.start", "has 5 joints"),
        ({"goal": "home"}, "Scene.goal", "expected joints, a Motor, a Point"),
        ({"start": [0, 0, 0, 0, np.nan]}, "joints", "finite"),
        ({"goal": sc.HeadingTarget([0, 0], 1.0)}, "Scene.goal", "no goal for the robot"),
        ({"obstacles": [shapes.Ball([0, 0], 1.0)]}, "Scene.obstacles.0", "dimension 2 in a scene of dimension 3"),
        ({"robot": "humanoid"}, None, "unknown robot 'humanoid'"),
    ],
)
def test_what_does_not_fit(changes, place, words):
    given = {"robot": "humanoid-arm", "start": np.zeros(5), "goal": sc.PositionTarget([0.3, 0, 0.3]), **changes}
    with pytest.raises(InputError, match=words) as caught:
        sc.Scene(**given)
    assert place is None or caught.value.place.startswith(place)


def test_unknown_change():
    with pytest.raises(InputError, match=r"unknown field 'gaol'.*'goal'"):
        SCENES["arm"].with_(gaol=3)


def same_robot(a, b):
    """Everything that planning sees of them: kinematics, limits, bodies, pairs, contacts."""
    assert (a.content, a.name, a.joint_names, a.link_names) == (b.content, b.name, b.joint_names, b.link_names)
    assert (a.allowed_obstacles, a.pair_table, a.notes) == (b.allowed_obstacles, b.pair_table, b.notes)
    for limit in ("lower", "upper", "velocity", "acceleration", "effort"):
        np.testing.assert_array_equal(getattr(a.limits, limit), getattr(b.limits, limit))
    for part in ("link", "a", "b", "radius"):
        np.testing.assert_array_equal(getattr(a.capsules, part), getattr(b.capsules, part))
    np.testing.assert_array_equal(a.self_pairs, b.self_pairs)


def test_a_robot_made_in_python_stands_beside_its_scene(tmp_path):
    robot = robots.load("panda").with_attached(
        [shapes.Box([0, 0, 0.05], [0.02, 0.03, 0.05])], name="part", allowed=["rack"]
    )
    scene = sc.Scene(
        robot=robot.with_allowed(("panda_link2", "panda_link5"), ("panda_hand", "rack")),
        start=np.array([0, -0.8, 0, -2.3, 0, 1.5, 0.8]),
        goal=sc.PoseTarget([0.5, 0.2, 0.6], [0, 1, 0, 0]),
        obstacles=[
            shapes.Box([0.6, 0, 0.1], [0.1, 0.2, 0.1], ROTATION, name="rack"),
            shapes.Mesh([[1, 0, 0], [1, 1, 0], [1, 0, 1]], [[0, 1, 2]], name="sheet"),
        ],
    )
    path = scene.save(tmp_path / "mine.yaml")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mine.robot.yaml", "mine.yaml"]
    again = sc.Scene.load(path)
    same_robot(scene.robot, again.robot)
    same(scene.goal, again.goal)
    for a, b in zip(scene.obstacles, again.obstacles, strict=True):
        same(a, b)
    (tmp_path / "deep").mkdir()
    moved = again.save(tmp_path / "deep" / "copy.yaml")  # the robot's file is named, not copied
    assert "../mine.robot.yaml" in moved.read_text() and len(list(moved.parent.iterdir())) == 1
    same_robot(scene.robot, sc.Scene.load(moved).robot)


@pytest.mark.parametrize("broken", ["mine.yaml", "mine.robot.yaml"])
def test_scene_and_robot_are_written_both_or_none(tmp_path, monkeypatch, broken):
    scene = SCENES["arm"].with_(robot=SCENES["arm"].robot, name="old")
    path = scene.save(tmp_path / "mine.yaml")
    before = {p.name: p.read_text() for p in tmp_path.iterdir()}
    new = scene.with_(name="new", robot=robots.load("srs-arm"), start=np.zeros(7), goal=np.full(7, 0.1))
    replace = os.replace

    def full_disk(source, target):
        if os.fspath(target) == os.fspath(tmp_path / broken):
            monkeypatch.setattr(os, "replace", replace)  # what was there can be put back
            raise OSError(28, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(os, "replace", full_disk)
    with pytest.raises(InputError, match="No space left"):
        new.save(path)
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == before
    assert sc.Scene.load(new.save(path)).robot.n_joints == 7


class TestTrajectory:
    def test_values(self):
        t = sc.Trajectory([0, 1, 3], [[0, 0], [1, 2], [1, 6]], names=("a", "b"))
        assert (t.duration, t.max_step, len(t)) == (3.0, 4.0, 3)
        np.testing.assert_allclose(t.at([-1, 0.5, 2, 9]), [[0, 0], [0.5, 1], [1, 4], [1, 6]])
        assert not t.positions.flags.writeable
        assert sc.Trajectory([0.0], [[1.0, 2.0]]).at([0, 1]).tolist() == [[1, 2], [1, 2]]

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (([0, 0], [[0], [1]]), "time does not increase"),
            (([0, 1, 2], [[0], [1]]), "3 times but 2 waypoints"),
            (([0, 1], [[0], [np.nan]]), r"index \(1, 0\)"),
            (([], np.zeros((0, 2))), "at least one waypoint"),
            (([0, 1], [0, 1]), "expected 2 axes"),
            (([0, 1], [[0], [1]], [[0]]), r"expected shape \(2, 1\)"),
            (([0, 1], [[0], [1]], None, None, ("a", "b")), "2 names but 1 joints"),
        ],
    )
    def test_refused(self, arguments, words):
        with pytest.raises(InputError, match=words):
            sc.Trajectory(*arguments)
