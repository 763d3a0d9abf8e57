"""Collision bodies: conservative, with a stated slack; capsule files; self-collision pairs."""

import re

import numpy as np
import pytest

from horosphere import robots
from horosphere.errors import InputError
from horosphere.numeric import at_most
from horosphere.robots import _bodies
from horosphere.robots._pairs import segment_distance


def depth_inside(points, bodies):
    """How deep each point lies inside the union of the capsules (negative: outside)."""
    gaps = []
    for body in bodies:
        u = body.b - body.a
        t = np.clip((points - body.a) @ u / max(u @ u, 1e-300), 0, 1)
        gaps.append(body.radius - np.linalg.norm(points - body.a - t[:, None] * u, axis=1))
    return np.max(gaps, axis=0)


def slack_of(body):
    said = float(re.search(r"slack at most ([0-9.]+) m", body.note).group(1))
    assert 0.0 <= said - body.slack <= 1e-4  # rounded up
    return body.slack


@pytest.mark.parametrize("radius, length", [(0.1, 1.0), (0.1, 0.2), (0.3, 0.02), (0.05, 0.0)])
def test_cylinders_lie_inside(radius, length):
    bodies = _bodies.from_cylinder(radius, length)
    angle = np.linspace(0, 2 * np.pi, 200)
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)
    for z in (-0.5 * length, 0.0, 0.5 * length):
        assert depth_inside(rim + [0, 0, z], bodies).min() >= 0
    body = bodies[0]
    assert slack_of(body) == pytest.approx(max(body.b[2] + body.radius - length / 2, body.radius - radius), abs=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_boxes_lie_inside(seed):
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.02, 0.5, 3)
    bodies = _bodies.from_box(size)
    points = rng.uniform(-0.5, 0.5, (5000, 3))
    face = rng.integers(0, 3, 5000)
    points[np.arange(5000), face] = np.sign(points[np.arange(5000), face]) * 0.5
    corners = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, 8).T
    assert depth_inside(np.vstack([points, corners]) * size, bodies).min() >= 0
    # the slack is what stands out: no capsule reaches further from the box
    directions = rng.normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    seen = 0.0
    for body in bodies:
        skin = np.vstack([end + body.radius * directions for end in (body.a, body.b)])
        outside = np.linalg.norm(np.maximum(np.abs(skin) - size / 2, 0), axis=1).max()
        assert outside <= slack_of(body)
        seen = max(seen, outside)
    assert seen > slack_of(bodies[0]) - 5e-3  # and about as far as that


def test_the_built_in_panda_contains_the_public_spheres(shared_data):
    urdf, ours = robots.load(shared_data / "panda_spheres.urdf", tip="panda_hand"), robots.load("panda")
    for k in range(len(urdf.capsules)):
        name = urdf.link_names[urdf.capsules.link[k]]
        mine = [
            _bodies.Body(ours.capsules.a[j], ours.capsules.b[j], ours.capsules.radius[j])
            for j in np.flatnonzero(ours.capsules.link == ours.link_names.index(name))
        ]
        assert depth_inside(urdf.capsules.a[k : k + 1], mine)[0] >= urdf.capsules.radius[k] - 1e-9, (name, k)


def test_capsule_files_and_radii(tmp_path):
    path = tmp_path / "nao.yaml"
    path.write_text(
        "horosphere/capsules: 1\nlinks:\n  LBicep: {radius: 0.04}\n"
        "  torso:\n    - {a: [0, 0, -0.05], b: [0, 0, 0.1], radius: 0.06, note: chest}\n"
    )
    robot = robots.load("nao-left-arm", capsules=path)
    at = {name: np.flatnonzero(robot.capsules.link == k) for k, name in enumerate(robot.link_names)}
    (k,) = at["torso"]
    assert robot.capsules.radius[k] == 0.06 and robot.capsules.note[k] == "chest"
    (k,) = at["LBicep"]
    assert robot.capsules.b[k] == pytest.approx([0.105, 0.015, 0]) and robot.capsules.radius[k] == 0.04
    assert robot.capsules.radius[at["LForeArm"]] == [0.033]
    assert any("capsule file" in note for note in robot.notes)
    bare = robots.load("nao-left-arm", capsules={name: [] for name in robot.link_names}, link_radius=0.02)
    assert len(bare.capsules) == 0
    assert any("NO collision body" in note for note in bare.notes)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("links: [1, 2]\nhorosphere/capsules: 1", "mapping 'links'"),
        ("LBicepp: {radius: 0.1}", "unknown link 'LBicepp'.*did you mean 'LBicep'"),
        ("LBicep: {radius: -0.1}", "not positive"),
        ("LBicep: {radius: .nan}", "finite"),
        ("LBicep: {a: [0, 0], radius: 0.1}", "a"),
        ("LBicep: {a: [0, 0, 0], radius: 0.1, colour: red}", "colour"),
        ("LBicep: [3]", "capsule"),
        ("LBicep: {", "not valid YAML"),
        ("- 3", "mapping"),
    ],
)
def test_bad_capsule_files(tmp_path, text, words):
    path = tmp_path / "capsules.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=words) as error:
        robots.load("nao-left-arm", capsules=path)
    assert str(path) in str(error.value)


def test_segment_distance_by_search():
    rng = np.random.default_rng(1)
    a, b, c, d = rng.normal(size=(4, 200, 3))
    b[:20] = a[:20]  # balls
    d[10:40] = c[10:40]
    d[50:60] = c[50:60] + 0.7 * (b[50:60] - a[50:60])  # parallel
    s = np.linspace(0, 1, 401)
    first = a[:, None] + s[:, None] * (b - a)[:, None]
    second = c[:, None] + s[:, None] * (d - c)[:, None]
    search = np.array([np.linalg.norm(p[:, None] - q[None], axis=-1).min() for p, q in zip(first, second)])
    found = segment_distance(a, b, c, d)
    assert (found <= search + 1e-12).all() and search - found == pytest.approx(np.zeros(200), abs=2e-2)


def test_self_pairs_skip_neighbours_and_say_what_else():
    panda = robots.load("panda")
    names = [{panda.link_names[i], panda.link_names[j]} for i, j in panda.self_pairs]
    assert {"panda_link0", "panda_hand"} in names and {"panda_link1", "panda_link3"} in names
    assert {"panda_link1", "panda_link2"} not in names and {"panda_link7", "panda_hand"} not in names
    assert {"panda_leftfinger", "panda_rightfinger"} not in names
    humanoid = robots.load("humanoid-arm")  # forearm and gripper meet at the spherical wrist
    assert [[humanoid.link_names[k] for k in pair] for pair in humanoid.self_pairs] == [["upper_arm", "gripper"]]


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan])
def test_bad_link_radius(radius):
    with pytest.raises(InputError, match="link_radius"):
        robots.load("panda", link_radius=radius)


@pytest.mark.parametrize(
    ("shape", "size", "most"),
    [('<box size="0.22 0.2 0.12"/>', 0.22, 0.015), ('<box size="0.04 0.04 0.02"/>', 0.04, 0.008)],
)
def test_a_box_is_covered_as_closely_as_a_mesh(tmp_path, shape, size, most):
    text = ['<robot name="r">']
    for name, found in (("arm", '<cylinder radius="0.005" length="0.1"/>'), ("box", shape)):
        text.append(f'<link name="{name}"><collision><geometry>{found}</geometry></collision></link>')
    joint = '<joint name="j" type="continuous"><parent link="arm"/><child link="box"/></joint></robot>'
    (tmp_path / "r.urdf").write_text("".join([*text, joint]))
    robot = robots.load(tmp_path / "r.urdf")
    said = next(note for note in robot.notes if "stand out" in note)
    assert "(box)" in said and 0.0 < float(re.search(r"at most ([0-9.]+) m", said).group(1)) <= 1.05 * most
    caps, own = robot.capsules, robot.capsules.link == 1
    assert np.linalg.norm(np.maximum(np.abs([caps.a[own], caps.b[own]]), 0), axis=-1).max() < size


def test_the_note_names_the_fattest_body_whatever_it_covers(tmp_path):
    (tmp_path / "r.urdf").write_text(
        '<robot name="r"><link name="a"><collision><geometry><box size="0.1 0.02 0.02"/></geometry></collision></link>'
        '<link name="b"><collision><geometry><cylinder radius="0.03" length="0.3"/></geometry></collision></link>'
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>'
    )
    robot = robots.load(tmp_path / "r.urdf")
    said = next(note for note in robot.notes if "stand out" in note)
    cylinder = _bodies.from_cylinder(0.03, 0.3, 0.015)[0]
    assert said.endswith(f"at most {at_most(cylinder.slack, decimals=4)} m (b)")
