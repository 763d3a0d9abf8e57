"""Attached objects, allowed contacts, SRDF and meshes in scene files, through to plan and certificate."""

import json

import numpy as np
import pytest
import trimesh

from horosphere import distance
from horosphere.certify import certify
from horosphere.cli._app import main
from horosphere.numeric import at_most
from horosphere.planning import plan
from horosphere.scenes import Scene, SceneError
from horosphere.shapes import box_cover

SCENE = """horosphere/scene: 1
robot: panda
start: {position: [0.5, -0.3, 0.13], rpy_deg: [180, 0, 0]}
goal: {position: [0.5, 0.3, 0.13], rpy_deg: [180, 0, 0]}
attached:
  - {type: box, name: part, center: [0, 0, 0.04], size: [0.04, 0.04, 0.1], allowed: [table]}
obstacles:
  - {type: box, name: table, center: [0.55, 0, 0.0], size: [0.4, 1.2, 0.1]}
  - {type: box, name: wall, center: [0.5, 0.0, 0.25], size: [0.3, 0.04, 0.3]}
allowed_obstacles:
  - [panda_hand, wall]
"""


def write(folder, text, name="scene.yaml"):
    path = folder / name
    path.write_text(text)
    return path


def test_what_is_allowed_reaches_distances_certificate_and_saved_files(tmp_path):
    scene = Scene.load(write(tmp_path, SCENE))
    assert scene.robot.allowed_obstacles == (("part", "table"), ("panda_hand", "wall"))
    scene.save(tmp_path / "again.yaml")
    again = Scene.load(tmp_path / "again.yaml")
    assert again.robot.allowed_obstacles == scene.robot.allowed_obstacles
    assert np.array_equal(again.robot.capsules.a, scene.robot.capsules.a)
    q = np.array([0.0, 0.5, 0, -2.2, 0, 2.6, 0.8])
    found = distance.table(scene.robot, q, scene.obstacles, static=False)
    held, hand = (np.array(found.links) == name for name in ("part", "panda_hand"))
    assert np.isposinf(found.distance[held, 0]).all() and np.isfinite(found.distance[held, 1]).all()
    assert np.isposinf(found.distance[hand, 1]).all() and np.isfinite(found.distance[hand, 0]).all()
    assert float(distance.signed(scene.robot, q, scene.obstacles, static=False)) == pytest.approx(found.distance.min())
    certificate = certify(scene, np.stack([q, q]))
    assert certificate.allowed[:2] == ("part may touch table", "panda_hand may touch wall")
    assert certificate.clearance == pytest.approx(found.distance.min(), abs=1e-9)


@pytest.mark.parametrize("method", ["tree", "auto"])
def test_a_part_slides_off_the_table(tmp_path, method):
    scene = Scene.load(write(tmp_path, SCENE.replace("[panda_hand, wall]", "[part, table]")))
    refused = plan(Scene.load(write(tmp_path, SCENE.replace(", allowed: [table]", ""), "no.yaml")), method=method)
    assert not refused.solved and "'part'" in refused.reason and "'table'" in refused.reason
    found = plan(scene, method=method)
    assert found.solved and found.certificate.allowed == ("part may touch table",)
    # an independent look: nothing but the part comes near anything
    q = found.trajectory.positions
    near = distance.table(scene.robot, q, scene.obstacles, static=False)
    held = np.array(near.links) == "part"
    assert near.distance[:, ~held].min() >= 0.01 and near.distance[:, held, 1].min() >= 0.01
    bare = distance.signed(
        scene.robot.with_allowed(), q, [o for o in scene.obstacles if o.name == "wall"], static=False
    )
    assert bare.min() >= 0.01


@pytest.mark.parametrize(
    ("old", "new", "place", "says"),
    [
        ("[panda_hand, wall]", "[panda_hnd, wall]", "11:6", "unknown link or attached object 'panda_hnd'.*did you mean 'panda_hand'"),
        ("[panda_hand, wall]", "[panda_hand, wal]", "11:18", "unknown obstacle 'wal'; valid: table, wall.*did you mean"),
        ("[panda_hand, wall]", "panda_hand", "11:5", "expected two names"),
        ("allowed: [table]", "alowed: [table]", "6:76", "unknown field 'alowed'.*did you mean 'allowed'"),
        ("allowed: [table]", "allowed: [tabel]", "6:86", "unknown link or obstacle 'tabel'.*did you mean 'table'"),
        ("allowed: [table]", "link: hand", "6:82", "unknown link 'hand'"),
        ("allowed: [table]", "size: 3", "6:76", "stands here twice"),
        ("robot: panda", "robot: {type: point, radius: 0.1}", None, "holds nothing"),
    ],
)  # fmt: skip
def test_mistakes_are_named_with_their_place(tmp_path, old, new, place, says, capsys):
    path = write(tmp_path, SCENE.replace(old, new))
    with pytest.raises(SceneError, match=f"(?s){says}") as caught:
        Scene.load(path)
    if place:
        assert f"{path}:{place}" in str(caught.value)
    assert main(["plan", str(path), "--out", str(tmp_path / "out")]) == 2


def write_arm(folder, extra=""):
    """A planar arm of four links with cylinders, and an SRDF that disables one pair."""
    solid = '<origin xyz="0 0 0.15"/><geometry><cylinder radius="0.03" length="0.3"/></geometry>'
    link = f'<link name="l{{}}"><collision>{solid}</collision></link>'
    joint = (
        '<joint name="j{0}" type="revolute"><parent link="l{0}"/><child link="l{1}"/><origin xyz="0 0 0.3"/>'
        '<axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
    )
    body = "".join(link.format(k) for k in range(4)) + "".join(joint.format(k, k + 1) for k in range(3))
    (folder / "arm.urdf").write_text(f'<robot name="small">{body}{extra}</robot>')
    (folder / "arm.srdf").write_text(
        '<robot name="small"><group name="arm"><chain base_link="l0" tip_link="l3"/></group>'
        '<disable_collisions link1="l0" link2="l2" reason="Never"/></robot>'
    )


def test_srdf_in_a_scene(tmp_path):
    write_arm(tmp_path)
    text = """horosphere/scene: 1
robot: {urdf: arm.urdf, srdf: arm.srdf, group: arm, collision: spheres, budget: 6}
start: {joints: [0.0, 0.3, 0.3]}
goal: {joints: [0.4, 0.3, 0.3]}
"""
    scene = Scene.load(write(tmp_path, text))
    why = {(p.first, p.second): p.reason for p in scene.robot.pair_table}
    assert why[("l0", "l2")] == "disabled in the SRDF: Never"
    assert np.array_equal(scene.robot.capsules.a, scene.robot.capsules.b)
    scene.save(tmp_path / "again.yaml")
    assert Scene.load(tmp_path / "again.yaml").robot.pair_table == scene.robot.pair_table
    assert certify(scene, np.array([[0.0, 0.3, 0.3], [0.4, 0.3, 0.3]])).allowed == (
        "l0 may touch l2: disabled in the SRDF: Never",
    )
    with pytest.raises(SceneError, match=r"scene.yaml:2:\d+.*group 'arms'|unknown group 'arms'.*did you mean 'arm'"):
        Scene.load(write(tmp_path, text.replace("group: arm,", "group: arms,")))
    (tmp_path / "arm.srdf").write_text('<robot name="big"><disable_collisions link1="x" link2="l2"/></robot>')
    with pytest.raises(SceneError, match=r"not for this URDF.*'big'.*link 'x'"):
        Scene.load(write(tmp_path, text.replace("group: arm,", "")))


MESH = """horosphere/scene: 1
robot: panda
start: {joints: [-0.9, 0.3, 0.0, -2.0, 0.0, 2.2, 0.8]}
goal: {joints: [0.9, 0.3, 0.0, -2.0, 0.0, 2.2, 0.8]}
obstacles:
  - {type: mesh, name: ring, file: ring.stl, position: [0.45, 0, 0.5]}
  - {type: points, name: scan, file: scan.npy, radius: 0.004}
"""


def scan(count):
    """Points on a wall behind the arm and a pole before it."""
    rng = np.random.default_rng(0)
    wall = np.column_stack([np.full(count, -0.6), rng.uniform(-1, 1, count), rng.uniform(0, 1.5, count)])
    pole = np.column_stack(
        [0.8 + 0.03 * rng.normal(size=count // 4), 0.03 * rng.normal(size=count // 4), rng.uniform(0, 1, count // 4)]
    )
    return np.concatenate([wall, pole])


def test_around_a_mesh_and_a_scan(tmp_path):
    ring = trimesh.creation.torus(0.15, 0.03, major_sections=24, minor_sections=12)
    ring.export(tmp_path / "ring.stl")
    np.save(tmp_path / "scan.npy", scan(40_000))
    scene = Scene.load(write(tmp_path, MESH))
    found = plan(scene, method="tree")
    assert found.solved and found.certificate.certified
    cover = box_cover(scene.obstacles[0])
    said = f"ring was enclosed in {len(cover.boxes)} boxes, slack at most {at_most(cover.slack, decimals=4)} m"
    assert sum(said in note for note in found.notes) == 1
    dense = found.trajectory.positions
    far = np.min([one.signed_distance(points_on(scene.robot, dense)) for one in scene.obstacles], axis=0)
    assert far.min() > 0.0 and found.certificate.clearance >= 0.01
    assert json.dumps(found.certificate.as_dict())


def points_on(robot, q):
    """Points on the capsules' axes."""
    from horosphere.robots._placement import link_frames, move_points

    c = robot.capsules
    moving = np.flatnonzero(~robot.static_bodies)
    frames = link_frames(robot.links, q)[:, c.link[moving]]
    return np.concatenate([move_points(frames, c.a[moving]), move_points(frames, c.b[moving])], axis=1)


def test_a_mesh_that_is_not_closed(tmp_path, capsys):
    box = trimesh.creation.box([0.1, 0.1, 0.1])
    trimesh.Trimesh(box.vertices, box.faces[:-1]).export(tmp_path / "open.stl")
    text = MESH.replace("ring.stl", "open.stl").replace(
        "  - {type: points, name: scan, file: scan.npy, radius: 0.004}\n", ""
    )
    assert main(["plan", str(write(tmp_path, text))]) == 2
    said = capsys.readouterr().err
    assert "scene.yaml:6:5" in said and "not watertight: 3 of its edges" in said and "fill: hull" in said
    hull = Scene.load(write(tmp_path, text.replace("position:", "fill: hull, position:"))).obstacles[0]
    assert hull.is_watertight and float(hull.signed_distance([0.45, 0.0, 0.5])) == pytest.approx(-0.05, abs=1e-6)
    sheet = Scene.load(write(tmp_path, text.replace("position:", "fill: surface, position:"))).obstacles[0]
    assert float(sheet.signed_distance([0.45, 0.0, 0.5])) == pytest.approx(0.05, abs=1e-6)
