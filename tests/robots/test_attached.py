"""Objects in the gripper, allowed contacts, and robots written to files and read back."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import horosphere as hs
from horosphere import distance, kinematics, robots
from horosphere.errors import InputError
from horosphere.shapes import Ball, Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Mesh, PointCloud

from .mesh_arm import link_mesh, write_arm


def configurations(robot, seed, count=20):
    limits = robot.limits
    low, high = np.maximum(limits.lower, -3.0), np.minimum(limits.upper, 3.0)
    return np.random.default_rng(seed).uniform(low, high, (count, robot.n_joints))


TURN = Rotation.from_euler("xyz", [0.3, -0.7, 1.1]).as_matrix()
SOLIDS = [
    Ball([0.01, 0.02, 0.03], 0.04),
    Capsule([0, 0, 0], [0.1, 0, 0.1], 0.02),
    Cylinder([0, 0, 0], [0.05, 0.1, 0.1], 0.03),
    Box([0.01, 0.0, 0.05], [0.03, 0.05, 0.08], TURN),
    Ellipsoid([0.0, 0.0, 0.05], [0.03, 0.05, 0.08], TURN),
    Mesh(np.asarray(link_mesh(3, 0.2, 1, 0).vertices), np.asarray(link_mesh(3, 0.2, 1, 0).faces)),
    PointCloud(np.random.default_rng(0).normal(size=(20, 3)) * 0.05, 0.01),
]


@pytest.mark.parametrize("collision", ["capsules", "spheres"])
@pytest.mark.parametrize("solid", SOLIDS, ids=lambda s: type(s).__name__)
def test_an_object_is_held_by_its_bodies(solid, collision):
    robot = robots.load("panda").with_attached(solid, collision=collision, name="thing")
    index = robot.link_names.index("thing")
    caps = robot.capsules
    own = caps.link == index
    centre, radius = solid.bounding_ball()
    points = np.random.default_rng(1).uniform(-radius, radius, (4000, 3)) + centre
    if isinstance(solid, PointCloud):
        points = solid.points[np.arange(4000) % 20] + 0.01 * points
    points = points[solid.signed_distance(points) <= 0.0]
    from horosphere.robots._bodies import Body, distance_to_axis

    bodies = [Body(caps.a[k], caps.b[k], caps.radius[k]) for k in np.flatnonzero(own)]
    inside = np.max([b.radius - distance_to_axis(points, b) for b in bodies], axis=0)
    assert len(points) > 50 and inside.min() >= -1e-9
    if collision == "spheres":
        assert np.array_equal(caps.a[own], caps.b[own])


def test_it_moves_with_the_tool():
    robot, q = robots.load("panda"), configurations(robots.load("panda"), 0)
    held = robot.with_attached(Ball([0.0, 0.0, 0.1], 0.03), name="cup")
    assert held.n_joints == 7 and held.tip == robot.tip
    assert kinematics.forward(held, q).array == pytest.approx(kinematics.forward(robot, q).array, abs=1e-15)
    centre = (kinematics.forward(robot, q).as_matrix() @ [0.0, 0.0, 0.1, 1.0])[:, :3]
    far = Ball([3.0, 0.0, 0.0], 0.1)
    only = robots.Robot(
        held.name, held.links, held.tip, held.joint_names, held.limits, held.tool,
        capsules=robots.Capsules([12], [[0, 0, 0.1]], [[0, 0, 0.1]], [0.03]),
    )  # fmt: skip
    assert distance.signed(only, q, [far]) == pytest.approx(
        np.linalg.norm(centre - [3, 0, 0], axis=1) - 0.13, abs=1e-12
    )
    # on a link, at a pose
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = TURN, [0.1, 0.2, 0.3]
    for given in (pose, hs.Motor.from_matrix(pose), hs.Motor.from_matrix(pose).array):
        side = robot.with_attached(Ball([0.0, 0.0, 0.1], 0.03), link="panda_link3", pose=given)
        frames = kinematics.frames(side, q).as_matrix()
        link3 = frames[:, side.link_names.index("panda_link3")]
        assert frames[:, -1] == pytest.approx(link3 @ pose, abs=1e-12)


def test_what_it_is_checked_against():
    robot = robots.load("panda")
    held = robot.with_attached(Box([0, 0, 0.05], [0.02, 0.02, 0.06]), name="box", allowed=["panda_link5", "table"])
    table = {p.first: p for p in held.pair_table if p.second == "box"}
    assert set(table) == {robot.link_names[k] for k in np.unique(robot.capsules.link)}
    assert table["panda_hand"].reason == table["panda_link7"].reason == "no joint between them"
    assert table["panda_link5"].reason == "allowed by the caller" and not table["panda_link5"].checked
    assert table["panda_link1"].checked and table["panda_link6"].checked  # no overlap by design at the wrist
    assert held.allowed_obstacles == (("box", "table"),)
    assert any("box attached to panda_hand" in note for note in held.notes)
    back = robots.detach(held, "box")
    assert back.link_names == robot.link_names and back.notes == robot.notes and back.allowed_obstacles == ()
    assert np.array_equal(back.self_pairs, robot.self_pairs) and back.content == robot.content
    assert back.pair_table == robot.pair_table and np.array_equal(back.capsules.link, robot.capsules.link)
    for wrong in ("cup", "panda_link5"):
        with pytest.raises(InputError):
            robots.detach(held, wrong)


def test_allowed_contacts():
    robot = robots.load("panda")
    free = robot.with_allowed(("panda_link0", "panda_hand"), ("panda_link1", "table"), ("table", "panda_link1"))
    names = robot.link_names
    assert [names.index("panda_link0"), names.index("panda_hand")] not in free.self_pairs.tolist()
    assert len(free.self_pairs) == len(robot.self_pairs) - 1
    (pair,) = [p for p in free.pair_table if {p.first, p.second} == {"panda_link0", "panda_hand"}]
    assert not pair.checked and pair.reason == "allowed by the caller"
    assert free.allowed_obstacles == (("panda_link1", "table"),)
    assert robots.describe(free)["collision"]["allowed_obstacles"] == [["panda_link1", "table"]]
    with pytest.raises(InputError, match="unknown link 'wall'"):
        robot.with_allowed(("wall", "table"))
    with pytest.raises(InputError, match="pairs of two names"):
        robot.with_allowed("panda_link0")


@pytest.mark.parametrize(
    ("bodies", "options", "words"),
    [
        (Ball([0, 0, 0], 0.1), {"link": "hand"}, "unknown link 'hand'.*panda_hand"),
        (Ball([0, 0, 0], 0.1), {"name": "panda_hand"}, "already has a link"),
        (Ball([0, 0, 0], 0.1), {"pose": np.eye(3)}, "expected a Motor"),
        (Ball([0, 0, 0], 0.1), {"pose": 2 * np.eye(4)}, "not a rigid motion"),
        (HalfSpace([0, 0, 1], 0.0), {}, "cannot be held"),
        (Ball([0, 0], 0.1), {}, "cannot be held"),
        ([], {}, "at least one shape"),
        ("cup", {}, "cannot read an obstacle"),
    ],
)
def test_bad_objects(bodies, options, words):
    with pytest.raises(InputError, match=words):
        robots.load("panda").with_attached(bodies, **options)


@pytest.mark.parametrize("name", ["panda", "ur5", "nao-left-arm", "humanoid-arm", "planar-3r", "attached"])
def test_robots_survive_urdf(tmp_path, name):
    robot = robots.load("panda" if name == "attached" else name)
    if name == "attached":
        robot = robot.with_attached(Capsule([0, 0, 0], [0.1, 0.05, 0], 0.02), name="bar")
    robots.save(robot, tmp_path / "r.urdf")
    tool = not np.allclose(robot.tool, [1, 0, 0, 0, 0, 0, 0, 0])
    tip = robot.link_names[robot.tip] + ("_tool" if tool else "")
    again = robots.load(tmp_path / "r.urdf", tip=tip)
    assert again.joint_names == robot.joint_names and again.name == robot.name
    for key in ("lower", "upper", "velocity"):
        assert getattr(again.limits, key) == pytest.approx(np.minimum(getattr(robot.limits, key), 1e9), abs=1e-15)
    q = configurations(robot, 1)
    assert kinematics.forward(again, q).as_matrix() == pytest.approx(
        kinematics.forward(robot, q).as_matrix(), abs=1e-12
    )
    assert len(again.capsules) == len(robot.capsules)
    # the same bodies, as seen by the distance to a ball
    ball = Ball([0.4, 0.3, 0.5], 0.05)
    assert distance.signed(again, q, [ball]) == pytest.approx(distance.signed(robot, q, [ball]), abs=1e-8)
    checked = {frozenset((again.link_names[i], again.link_names[j])) for i, j in again.self_pairs}
    if name != "attached":
        assert checked == {frozenset((robot.link_names[i], robot.link_names[j])) for i, j in robot.self_pairs}


def test_mimic_joints_survive_urdf(tmp_path):
    limit = '<limit lower="-1" upper="2" velocity="2" effort="3"/>'
    text = '<robot name="m"><link name="a"/><link name="b"/><link name="c"/>'
    for name, one, two, more in (
        ("j", "a", "b", ""),
        ("k", "b", "c", '<mimic joint="j" multiplier="-0.5" offset="0.1"/>'),
    ):
        text += f'<joint name="{name}" type="revolute"><parent link="{one}"/><child link="{two}"/><origin xyz="0 0 1"/>'
        text += f'<axis xyz="0 1 0"/>{limit}{more}</joint>'
    (tmp_path / "m.urdf").write_text(text + "</robot>")
    robot = robots.load(tmp_path / "m.urdf")
    robots.save(robot, tmp_path / "n.urdf")
    again = robots.load(tmp_path / "n.urdf")
    q = configurations(robot, 0)
    assert kinematics.forward(again, q).as_matrix() == pytest.approx(
        kinematics.forward(robot, q).as_matrix(), abs=1e-14
    )
    assert again.limits.upper == pytest.approx(robot.limits.upper)


def test_yourdfpy_reads_what_is_written(tmp_path):
    yourdfpy = pytest.importorskip("yourdfpy")
    robot = robots.load("iiwa14")
    robots.save(robot, tmp_path / "r.urdf")
    other = yourdfpy.URDF.load(str(tmp_path / "r.urdf"), load_meshes=False)
    q = configurations(robot, 2, 5)
    for row in q:
        other.update_cfg(dict(zip(robot.joint_names, row)))
        expected = kinematics.frames(robot, row).as_matrix()[robot.tip]
        assert other.get_transform(robot.link_names[robot.tip], robot.link_names[0]) == pytest.approx(
            expected, abs=1e-9
        )


@pytest.mark.parametrize("collision", ["capsules", "spheres"])
def test_a_covered_robot_survives_its_files(tmp_path, collision):
    path, _ = write_arm(tmp_path, 1, joints=3)
    robot = robots.load(path, collision=collision, budget=3)
    robot = robot.with_attached(Ball([0, 0, 0.1], 0.05)).with_allowed(("attached", "table"))
    robots.save(robot, tmp_path / "robot.yaml")
    again = robots.load(tmp_path / "robot.yaml")
    assert again.content == robot.content and again.notes == robot.notes
    assert again.pair_table == robot.pair_table and again.allowed_obstacles == (("attached", "table"),)
    assert np.array_equal(again.self_pairs, robot.self_pairs) and again.capsules.note == robot.capsules.note
    for key in ("link", "a", "b", "radius"):
        assert getattr(again.capsules, key).tobytes() == getattr(robot.capsules, key).tobytes()
    robots.save(robot, tmp_path / "spheres.urdf")
    spheres = robots.load(tmp_path / "spheres.urdf", tip=robot.link_names[robot.tip], collision=collision)
    if collision == "spheres":
        assert "<cylinder" not in (tmp_path / "spheres.urdf").read_text()
        assert all(note == "sphere, exact" for note in spheres.capsules.note)
        assert np.sort(spheres.capsules.radius) == pytest.approx(np.sort(robot.capsules.radius), abs=0)


def test_bad_robot_files(tmp_path):
    robot = robots.load("panda")
    with pytest.raises(InputError, match=r"\.json.*valid: \.yaml, \.urdf"):
        robots.save(robot, tmp_path / "robot.json")
    with pytest.raises(InputError, match="cannot be written"):
        robots.save(robot, tmp_path / "nowhere" / "robot.urdf")
    assert list(tmp_path.iterdir()) == []
    robots.save(robot, tmp_path / "robot.yaml")
    text = (tmp_path / "robot.yaml").read_text()
    for old, new, words in (
        ("checked: true", "checked: maybe", "checked"),
        ("links: [panda_link0, panda_link2]", "links: [panda_link0]", "two names"),
        ("links: [panda_link0, panda_link2]", "links: [panda_link0, elbow]", "unknown link 'elbow'"),
    ):
        assert old in text
        (tmp_path / "bad.yaml").write_text(text.replace(old, new))
        with pytest.raises(InputError, match=words):
            robots.load(tmp_path / "bad.yaml")
