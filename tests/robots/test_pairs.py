"""Pairs of links: each has its reason, no pair that a plan may touch is dropped, SRDF files, what stands still."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from horosphere import distance, kinematics, robots
from horosphere.errors import InputError
from horosphere.robots import Limits, Link, LinkPair
from horosphere.robots._apart import least_gap
from horosphere.robots._kept import digest
from horosphere.robots._pairs import ALWAYS, OFTEN, SAMPLES, _warnings

from .mesh_arm import write_arm

SRDF = """<?xml version="1.0"?>
<robot name="acme">
  <!-- as MoveIt's assistant writes it -->
  <group name="arm"><chain base_link="link0" tip_link="link6"/></group>
  <group name="hand"><link name="link7"/></group>
  <group name="both"><group name="arm"/><group name="hand"/></group>
  <group name="by_joints"><joint name="joint2"/><joint name="joint3"/><joint name="joint4"/></group>
  <group name="split"><joint name="joint1"/><joint name="joint7"/></group>
  <group_state name="home" group="arm"><joint name="joint1" value="0.5"/></group_state>
  <end_effector name="hand" parent_link="link6" group="hand"/>
  <virtual_joint name="world" type="fixed" parent_frame="world" child_link="link0"/>
  <passive_joint name="joint7"/>
  <disable_collisions link1="link0" link2="link1" reason="Adjacent"/>
  <disable_collisions link1="link1" link2="link3" reason="Never"/>
  <disable_collisions link1="link6" link2="link4" reason="User"/>
</robot>
"""
OTHER = SRDF.replace("link6", "panda_hand").replace('name="acme"', 'name="panda"')


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    """The URDF, an SRDF of it, and the robot without and with it."""
    folder = tmp_path_factory.mktemp("acme")
    path, _ = write_arm(folder, primitives=True)
    srdf = folder / "acme.srdf"
    srdf.write_text(SRDF)
    return path, srdf, robots.load(path), robots.load(path, srdf=srdf)


def by_name(robot):
    return {frozenset((p.first, p.second)): p for p in robot.pair_table}


def test_every_pair_of_links_has_a_reason(arm):
    _, _, robot, _ = arm
    table = by_name(robot)
    bodied = [robot.link_names[k] for k in np.unique(robot.capsules.link)]
    assert set(table) == {frozenset((a, b)) for a in bodied for b in bodied if a != b}
    assert all(pair.reason for pair in robot.pair_table)
    checked = {frozenset((robot.link_names[i], robot.link_names[j])) for i, j in robot.self_pairs}
    assert checked == {key for key, pair in table.items() if pair.checked}
    assert table[frozenset(("link2", "link3"))].reason == "adjacent: joined by a joint"
    shown = robots.describe(robot)["collision"]["pairs"]
    assert len(shown) == len(table) and {"links", "checked", "why", "touching"} == set(shown[0])


@pytest.mark.parametrize("name", ["panda", "ur5", "iiwa14", "nao-left-arm", "srs-arm"])
def test_no_pair_that_may_touch_or_part_is_dropped(name):
    """Witness: distances of the bodies by `distance`, at other random configurations."""
    robot = robots.load(name)
    rng = np.random.default_rng(7)
    q = rng.uniform(robot.limits.lower, robot.limits.upper, (400, robot.n_joints))
    names = robot.link_names
    dropped = 0
    for pair in robot.pair_table:
        if pair.reason.startswith(("no joint", "adjacent")):
            assert not pair.checked
            continue
        only = [[names.index(pair.first), names.index(pair.second)]]
        one = robots.Robot(
            robot.name,
            robot.links,
            robot.tip,
            robot.joint_names,
            robot.limits,
            capsules=robot.capsules,
            self_pairs=only,
        )
        touching = (distance.signed(one, q, [], self_collision=True) < 0.0).mean()
        assert pair.touching == pytest.approx(touching, abs=0.12)
        assert pair.checked == (pair.touching < ALWAYS)
        if not pair.checked:
            dropped += 1
            assert touching > 0.9 and any(
                "NOT checked" in n and pair.first in n and pair.second in n for n in robot.notes
            )
    assert dropped == {"ur5": 2, "nao-left-arm": 1}.get(name, 0)


def test_pairs_that_often_overlap_stay_and_are_said(arm):
    robot = robots.load(arm[0], capsules={"link7": {"a": [0, 0, 0], "radius": 0.16}})
    assert any(
        "1 pair of links is NOT checked" in note and "link5/link7 (512)" in note for note in robot.notes
    )  # 512 of 512
    often = [p for p in robot.pair_table if p.checked and p.touching is not None and p.touching >= OFTEN]
    assert often
    for pair in often:
        said = [note for note in robot.notes if "checked though" in note]
        assert len(said) == 1 and f"{pair.first}/{pair.second} ({round(pair.touching * SAMPLES)})" in said[0]
        assert f"{round(pair.touching * SAMPLES)} of {SAMPLES}" in pair.reason


def test_a_budget_is_named_only_where_it_is_of_use():
    row = LinkPair("a", "b", False, "always touching", 1.0)
    box, mesh = "box, slack at most 0.0100 m", "mesh of 12 triangles, slack at most 0.0100 m"
    for notes, useful in (([box, "sphere, exact"], False), ([box, mesh], True)):
        (note,) = _warnings([row], [], ["a", "b"], notes)
        assert ("budget" in note) == useful and "a/b (512)" in note
    (note,) = _warnings([row], [], ["a", *["b"] * 40], [box, *[mesh] * 40])
    assert "budget" not in note  # none left
    (note,) = _warnings([], [replace(row, checked=True)] * 2, ["a", "b"], [box, mesh])
    assert note.startswith("2 pairs of links are checked though their bodies often overlap")


def test_srdf_disables_pairs_and_chooses_the_chain(arm):
    path, srdf, plain, robot = arm
    table = by_name(robot)
    never = table[frozenset(("link1", "link3"))]
    assert not never.checked and never.reason == "disabled in the SRDF: Never"
    assert table[frozenset(("link4", "link6"))].reason == "disabled in the SRDF: User"
    assert by_name(plain)[frozenset(("link4", "link6"))].checked
    assert never.touching == by_name(plain)[frozenset(("link1", "link3"))].touching
    assert any("link1 / link3: the SRDF says they never touch" in n for n in robot.notes) == (never.touching > 0)
    # several groups are chains: the ends are the URDF's
    assert robot.link_names[robot.tip] == "link7" and robot.n_joints == 7
    for group, base, tip in (("arm", "link0", "link6"), ("both", "link0", "link7"), ("by_joints", "link1", "link4")):
        part = robots.load(path, srdf=srdf, group=group)
        assert (part.link_names[0], part.link_names[part.tip]) == (base, tip)
        assert any(f"group {group!r}: {base} to {tip}" in note for note in part.notes)
    for group, words in (("split", "not one chain"), ("arms", "unknown group 'arms'.*did you mean 'arm'")):
        with pytest.raises(InputError, match=words):
            robots.load(path, srdf=srdf, group=group)


def test_the_only_group_is_the_chain(tmp_path):
    path, _ = write_arm(tmp_path, primitives=True, joints=3)
    srdf = tmp_path / "one.srdf"
    srdf.write_text('<robot name="acme"><group name="arm"><chain base_link="link0" tip_link="link2"/></group></robot>')
    assert robots.load(path, srdf=srdf).joint_names == ("joint1", "joint2")
    assert robots.load(path, srdf=srdf, tip="link3").n_joints == 3


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (OTHER, "not for this URDF.*'panda'.*'acme'.*panda_hand.*line 4"),
        (SRDF.replace('passive_joint name="joint7"', 'passive_joint name="wheel"'), "joint 'wheel' .line 12"),
        (SRDF.replace('value="0.5"', 'value="half"'), "joint 'joint1'.*number"),
        (SRDF.replace('link1="link0" link2="link1"', 'link1="link0"'), "without the name of a link"),
        (SRDF.replace('link1="link0" link2="link1"', 'link1="link1" link2="link1"'), "with itself"),
        ("<robot><group", "not well-formed"),
        ("<sdf/>", "root element is <sdf>.*SRDF"),
    ],
)  # fmt: skip
def test_an_srdf_for_another_robot_is_refused(arm, tmp_path, text, words):
    srdf = tmp_path / "other.srdf"
    srdf.write_text(text)
    with pytest.raises(InputError, match=words) as error:
        robots.load(arm[0], srdf=srdf)
    assert str(srdf) in str(error.value)


def test_srdf_needs_a_urdf(tmp_path):
    with pytest.raises(InputError, match="srdf"):
        robots.load("panda", srdf=tmp_path / "x.srdf")
    with pytest.raises(InputError, match="no such file"):
        robots.load(write_arm(tmp_path, primitives=True, joints=1)[0], srdf=tmp_path / "x.srdf")


def test_srdf_links_off_by_default(tmp_path):
    path, _ = write_arm(tmp_path, primitives=True, joints=4)
    srdf = tmp_path / "four.srdf"
    srdf.write_text(
        '<robot name="acme"><disable_default_collisions link="link4"/>'
        '<enable_collisions link1="link4" link2="link1"/><enable_collisions link1="link0" link2="link1"/></robot>'
    )
    table = by_name(robots.load(path, srdf=srdf))
    assert table[frozenset(("link0", "link4"))].reason == "disabled in the SRDF: Default"
    assert "SRDF" not in table[frozenset(("link1", "link4"))].reason
    # neighbours that are enabled are looked at, and overlap at their joint always
    assert "always touching" in table[frozenset(("link0", "link1"))].reason


def test_bodies_that_stand_still():
    robot = robots.load("panda")
    still = {robot.link_names[k] for k in robot.capsules.link[robot.static_bodies]}
    assert still == {"panda_link0"} and not robot.static_bodies.flags.writeable
    q = np.random.default_rng(0).uniform(robot.limits.lower, robot.limits.upper, (20, 7))
    frames = kinematics.frames(robot, q).array[:, robot.capsules.link]
    moves = np.ptp(frames, axis=0).max(axis=-1) > 1e-9
    assert np.array_equal(moves, ~robot.static_bodies)


@pytest.mark.parametrize("name", ["panda", "ur5", "humanoid-arm"])
def test_link_bounds_hold_the_bodies(name):
    robot = robots.load(name)
    caps, rng = robot.capsules, np.random.default_rng(0)
    assert robot.link_bounds.shape == (len(robot.links), 4)
    assert {k for k in range(len(robot.links)) if robot.link_bounds[k, 3] >= 0} == set(caps.link.tolist())
    for k in range(len(caps)):
        directions = rng.normal(size=(200, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        skin = np.concatenate([end + caps.radius[k] * directions for end in (caps.a[k], caps.b[k])])
        centre, radius = robot.link_bounds[caps.link[k], :3], robot.link_bounds[caps.link[k], 3]
        assert np.linalg.norm(skin - centre, axis=1).max() <= radius + 1e-12
    for k in np.unique(caps.link):
        ends = np.concatenate([caps.a[caps.link == k], caps.b[caps.link == k]])
        span = np.linalg.norm(ends[:, None] - ends, axis=2).max() / 2
        assert robot.link_bounds[k, 3] <= 1.16 * (span + caps.radius[caps.link == k].max())  # Jung: sqrt(4/3)


@pytest.mark.parametrize("seed", range(60))
def test_apart_in_every_posture_means_in_all_that_the_limits_allow(seed):
    """Two boxes on a circle of one metre: they meet where the joint's angle is that of the box that stands, turns and all."""
    rng = np.random.default_rng(seed)
    multiplier, offset = rng.choice([1.0, -0.4, 2.0]), rng.uniform(-4.0, 4.0)
    low = rng.uniform(-9.0, 6.0)
    high = low + rng.uniform(0.2, 9.0)
    middle, width = multiplier * 0.5 * (low + high) + offset, 0.5 * abs(multiplier) * (high - low)
    where = middle + rng.choice([-1.0, 1.0]) * (rng.uniform(0.0, width) if seed % 2 else width + 0.5)
    box = np.asarray(trimesh.creation.box((0.1, 0.1, 0.1)).triangles)
    links = (
        Link("base", -1, np.eye(8)[0]),
        Link("arm", 0, np.eye(8)[0], "revolute", coordinate=0, multiplier=multiplier, offset=offset),
    )
    stands = box + [np.cos(where), np.sin(where), 0.0]
    gap = least_gap(links, Limits([low], [high], [1.0], [1.0], [1.0]), (stands, box + [1.0, 0.0, 0.0]), (0, 1))
    angles = np.linspace(middle - width, middle + width, 20_001)
    apart = np.abs(np.remainder(angles - where + np.pi, 2.0 * np.pi) - np.pi).min()
    assert (gap is None) if apart < 0.05 else apart < 0.3 or gap is not None


def test_keys_tell_long_lists_of_long_arrays_apart():
    first = np.random.default_rng(0).normal(size=(500, 3, 3))
    second = first.copy()
    second[250, 1, 1] += 1e-9
    assert digest([first, "a"]) != digest([second, "a"]) and digest([first, "a"]) == digest([first.copy(), "a"])
    assert digest([first], "a") != digest([first, "a"])


DISCS = """<robot name="discs">
<link name="foot"><collision><geometry><cylinder radius="0.1" length="0.04"/></geometry></collision></link>
<link name="post"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
<link name="arm"><collision><origin xyz="0 0 0" rpy="1.5708 0 0"/><geometry><cylinder radius="0.06" length="0.1"/></geometry>
</collision></link>
<joint name="turn" type="revolute"><parent link="foot"/><child link="post"/><origin xyz="0 0 0.05"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
<joint name="lift" type="revolute"><parent link="post"/><child link="arm"/><origin xyz="0 0 {height}"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
<joint name="slide" type="prismatic"><parent link="arm"/><child link="end"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.1" velocity="1" effort="1"/></joint>
<link name="end"/></robot>"""


def test_covers_are_laid_closer_where_links_would_touch_all_the_time(tmp_path):
    """One link passes a centimetre over the next but one: nothing is proved for them, bodies at the usual tolerance overlap."""
    path = tmp_path / "discs.urdf"
    path.write_text(DISCS.format(height=0.045))  # 15 mm between the discs
    robot = robots.load(path)
    said = [note for note in robot.notes if "half the usual tolerance" in note]
    row = by_name(robot)[frozenset(("foot", "arm"))]
    coarse = robots.load(path, tolerance=0.015)  # a tolerance that is given is kept to
    before = by_name(coarse)[frozenset(("foot", "arm"))]
    assert not any("half the usual" in note for note in coarse.notes)
    assert said and row.touching < 0.5 * before.touching
