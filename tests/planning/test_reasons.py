"""A refusal says of which postures it speaks, and its figure is that of the best of them."""

import re

import numpy as np
import pytest

import horosphere as hs
from horosphere.planning._configurations import FREE_SAMPLES
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
    assert f"every branch, with {FREE_SAMPLES} values of the free angle phi" in reason
    target = hs.kinematics.GripperOnPlane(goal.position, goal.normal)
    phi = np.linspace(-np.pi, np.pi, FREE_SAMPLES, endpoint=False)
    found = hs.kinematics.inverse(scene.robot, target, phi=phi)
    assert int(count) == found.within_limits(scene.robot).sum() and "postures within the limits" in reason
    best = hs.distance.signed(scene.robot, found.q[found.within_limits(scene.robot)], [BALL]).max()
    assert -1e3 * best == pytest.approx(float(depth), rel=5e-3)


def test_a_goal_that_a_search_looked_at():
    reason = hs.planning.plan(humanoid(PositionTarget([0.41, 0.07, -0.32]), [BALL])).reason
    assert reason.startswith("goal in collision") and "that a numerical search found; others may exist" in reason


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
        panda, far, q7=np.linspace(*np.array([panda.limits.lower[6], panda.limits.upper[6]]), FREE_SAMPLES)
    )
    assert f"the nearest of {FREE_SAMPLES} values of the free angle" in reason and not each.valid.any()
    texts = [float(m[1]) for m in (re.search(r"out of reach by ([\d.]+) m", str(r)) for r in each.reason) if m]
    assert said == min(texts)
