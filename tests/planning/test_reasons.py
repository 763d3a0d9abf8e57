"""A refusal says of which postures it speaks, and its figure is that of the best of them."""

import dataclasses
import re

import numpy as np
import pytest

import horosphere as hs
from horosphere.planning._free_angles import FINE_SAMPLES
from horosphere.scenes import GripperPlaneTarget, PositionTarget

BALL = hs.Sphere.from_center_radius([0.41, 0.07, -0.32], 0.06)


START = GripperPlaneTarget([0.33, 0.0, 0.31], [0.0, 1.0, 0.0])


def humanoid(goal, obstacles, start=START):
    return hs.Scene(robot="humanoid-arm", start=start, goal=goal, obstacles=obstacles)


def test_a_goal_in_collision_in_every_branch():
    goal = GripperPlaneTarget([0.41, 0.07, -0.32], [0.0, 1.0, 0.0])
    scene = humanoid(goal, [BALL])
    reason = hs.planning.plan(scene).reason
    count, depth = re.search(r"reaches ([\d.]+) mm into .*best of (\d+) postures", reason).group(2, 1)
    assert f"every branch, with {FINE_SAMPLES} values of the free angle phi" in reason
    target = hs.kinematics.GripperOnPlane(goal.position, goal.normal)
    phi = np.linspace(-np.pi, np.pi, FINE_SAMPLES, endpoint=False)
    found = hs.kinematics.inverse(scene.robot, target, phi=phi)
    assert int(count) == found.within_limits(scene.robot).sum() and "postures within the limits" in reason
    best = hs.distance.signed(scene.robot, found.q[found.within_limits(scene.robot)], [BALL]).max()
    assert -1e3 * best == pytest.approx(float(depth), rel=5e-3)


def test_a_goal_that_a_search_looked_at():
    reason = hs.planning.plan(humanoid(PositionTarget([0.41, 0.07, -0.32]), [BALL])).reason
    assert reason.startswith("goal in collision") and "drawn over orientations; others may exist" in reason
    count, held = map(
        int, re.search(r"best of (\d+) postures within the limits.* 'ball 0' in the way of (\d+)", reason).groups()
    )
    assert count > 10_000 and held > 500 and "move the goal or 'ball 0'" in reason


def test_a_point_that_only_the_arm_itself_is_in_the_way_of():
    nao = hs.robots.load("nao-left-arm")
    tool = hs.kinematics.forward(nao, [1.9, 0.2, -0.6, -1.2, 0.0]).translation
    ball, start = hs.Sphere.from_center_radius(tool, 0.05), np.radians([40, 20, -60, -60, 0])
    scene = hs.Scene(robot=nao, start=start, goal=PositionTarget(tool), obstacles=[ball])
    reason = hs.planning.plan(scene).reason
    assert reason.startswith("goal in collision: ") and "every branch, with 36 values of psi by 20 of q5" in reason
    far = hs.Scene(robot=nao, start=start, goal=PositionTarget([0.4, 0.1, 0.1]), obstacles=[])
    assert "goal: out of reach by" in (reason := hs.planning.plan(far).reason) and "nearest point in reach" in reason


def test_joints_are_one_posture():
    start = np.array([0.7, 1.2, 1.0, 0.0, 0.0])
    tool = hs.kinematics.forward(hs.robots.load("humanoid-arm"), start).translation
    scene = humanoid(PositionTarget([0.3, 0.3, 0.3]), [hs.Sphere.from_center_radius(tool, 0.05)], start)
    reason = hs.planning.plan(scene).reason
    assert reason.startswith("start in collision: link ") and "posture" not in reason


def test_out_of_reach_by_the_least_over_the_free_joint():
    """The wrist of a Panda can be 0.7 m and a little from the shoulder: a pose 2 m away is out of reach whatever q7 is."""
    panda = hs.robots.load("panda")
    far = hs.Motor.from_translation([2.0, 0.0, 0.4]) @ hs.Rotor.from_axis_angle([1, 0, 0], np.pi)
    scene = hs.Scene(robot=panda, start=np.array([0, -0.8, 0, -2.3, 0, 1.6, 0.8]), goal=far, obstacles=[])
    reason = hs.planning.plan(scene).reason
    said = float(re.search(r"out of reach by ([\d.]+) m", reason)[1])
    each = hs.kinematics.inverse(
        panda, far, q7=np.linspace(*np.array([panda.limits.lower[6], panda.limits.upper[6]]), FINE_SAMPLES)
    )
    assert f"the nearest of {FINE_SAMPLES} values of the free angle" in reason and not each.valid.any()
    texts = [float(m[1]) for m in (re.search(r"out of reach by ([\d.]+) m", str(r)) for r in each.reason) if m]
    assert said == min(texts)


def said_nearest(reason):
    """Tip and distance of the nearest pose that a reason names."""
    m = re.search(r"the nearest found inside the limits has the tip at \((.+?)\), ([\d.e-]+) m away", reason)
    assert m is not None, reason
    return np.array(m[1].split(", "), float), float(m[2])


def test_a_goal_out_of_reach_names_the_nearest_pose():
    """The witness: no posture of 20,000 random ones comes nearer to a far point than the tip that is named."""
    ur5 = hs.robots.load("ur5")
    start = np.array([0, -1.0, 1.4, 0.2, 0.9, -0.4])
    far = np.array([1.3, 0.2, 0.3])
    q = np.random.default_rng(0).uniform(ur5.limits.lower, ur5.limits.upper, (20_000, 6))
    sampled = np.linalg.norm(hs.kinematics.forward(ur5, q).as_matrix()[:, :3, 3] - far, axis=1).min()
    turned = hs.Motor.from_translation(far) @ hs.Rotor.from_axis_angle([1, 0, 0], np.pi)
    for goal in (PositionTarget(far), turned):
        result = hs.planning.plan(hs.Scene(robot=ur5, start=start, goal=goal))
        tip, away = said_nearest(result.reason)
        assert not result.solved and result.reason.startswith("goal: ") and "reach" in result.reason
        assert away == pytest.approx(np.linalg.norm(tip - far), abs=2e-3)
        if isinstance(goal, PositionTarget):
            assert away < sampled < away + 0.2
    assert 0.0 < float(re.search(r" m away and turned by ([\d.]+) degrees", result.reason)[1]) <= 180.0


@pytest.mark.parametrize("name", ["ur5", "panda"])
def test_a_goal_that_a_joint_limit_forbids_names_joint_and_nearest_pose(name):
    """Joints 1 and 2 may turn by 0.2 rad about the start only: a goal behind the robot is in reach, but not for them."""
    robot = hs.robots.load(name)
    q = {"ur5": [0.3, -1.0, 1.4, 0.2, 0.9, -0.4], "panda": [0, -0.8, 0, -2.3, 0, 1.6, 0.8]}[name]
    lower, upper = robot.limits.lower.copy(), robot.limits.upper.copy()
    lower[0], upper[0] = q[0] - 0.2, q[0] + 0.2
    lower[2:], upper[2:] = np.array(q[2:]) - 0.3, np.array(q[2:]) + 0.3
    short = dataclasses.replace(robot, limits=dataclasses.replace(robot.limits, lower=lower, upper=upper))
    behind = np.array(q)
    behind[0] += 1.5
    goal = hs.kinematics.forward(robot, behind)
    result = hs.planning.plan(hs.Scene(robot=short, start=np.array(q), goal=goal))
    tip, away = said_nearest(result.reason)
    assert not result.solved and "limits" in result.reason
    assert away > 0.05 and away == pytest.approx(np.linalg.norm(tip - goal.translation), abs=2e-3)
    assert any(joint in result.reason for joint in robot.joint_names)


@pytest.mark.parametrize("position", [[0.0, 0.0, 1.9], [0.9, 0.0, 0.0], [0.0, -1.3, 0.2]])
def test_no_figure_is_finer_than_it_is_known(position):
    """A search ends where a coordinate is -1.7e-13: that is 0."""
    from horosphere.kinematics._explain import nearest_pose

    robot = hs.robots.load("srs-arm")
    for target in (
        hs.Point.from_euclidean(position),
        hs.Motor.from_matrix(np.block([[np.eye(3), np.c_[position]], [0, 0, 0, 1]])),
    ):
        said = nearest_pose(robot, target)
        numbers = [float(x) for x in re.findall(r"-?\d[\d.]*(?:e[-+]?\d+)?", said)]
        assert len(numbers) >= 4 and all(x == 0.0 or abs(x) >= 1e-6 for x in numbers), said
        assert "-0," not in said and "(-0" not in said.replace("(-0.", "")
