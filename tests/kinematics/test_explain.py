"""What is said where no posture inside the limits reaches a target."""

import re

import numpy as np
import pytest
import structured_arms as arms

from horosphere.errors import InputError
from horosphere.kinematics import GripperOnPlane, classify, forward, inverse
from horosphere.robots import humanoid_arm, load
from horosphere.versors import Motor


def test_out_of_reach_names_the_nearest_pose():
    robot = load("ur5")
    far = np.eye(4)
    far[:3, 3] = [3.0, 0.0, 0.4]
    words = inverse(robot, Motor.from_matrix(far)).explain(robot, Motor.from_matrix(far))
    assert words.startswith("out of reach by ")
    away = float(re.search(r"([0-9.]+) m away", words)[1])
    assert 1.9 < away < 2.3  # the arm spans about 0.95 m from its base


def test_limits_that_leave_nothing_name_branch_and_joint():
    robot = arms.robot("short of travel", arms.UR5, [3.1, 3.1, 0.2, 3.1, 3.1, 3.1])
    free = arms.robot("free", arms.UR5)
    pose = forward(free, [0.3, -1.0, 1.4, 0.2, 0.9, -0.4])
    words = inverse(robot, pose).explain(robot, pose)
    assert "none inside the joint limits" in words and "needs joint_3 at" in words and "11.46 deg" in words
    assert inverse(free, pose).explain(free, pose) == ""


@pytest.mark.parametrize("name, parameter", [("panda", "q7"), ("iiwa14", "psi")])
def test_another_value_of_the_redundancy_is_named(name, parameter):
    robot = load(name)
    pose = forward(robot, np.array([0.4, 0.5, -0.3, -1.8, 0.4, 1.6, 0.6]))
    values = np.linspace(-2.8, 2.8, 200)
    rows = inverse(robot, pose, **{parameter: values})
    bad = values[~rows.within_limits(robot).any(axis=-1)][0]
    found = inverse(robot, pose, **{parameter: bad})
    words = found.explain(robot, pose)
    assert words.startswith(f"inside the joint limits at other values of {parameter} only: the widest interval is ")
    low, high = (np.radians(float(x)) for x in re.search(r"is (-?[0-9.]+) to (-?[0-9.]+) deg", words).groups())
    row = next(k for k in range(8) if found.name(k) in words)
    inside = inverse(robot, pose, **{parameter: np.linspace(low + 1e-6, high - 1e-6, 9)}).within_limits(robot)
    assert high > low and inside[:, row].all()


def test_a_point_that_the_humanoid_arm_cannot_reach():
    arm, target = humanoid_arm(), GripperOnPlane([2.0, 0, 0], [0, 1, 0])
    assert "m away" in inverse(arm, target).explain(arm, target)
    with pytest.raises(InputError, match="batch"):
        inverse(arm, target, phi=np.zeros(3)).explain(arm, target)


def test_axes_that_meet_in_pairs_only_are_said_to():
    axes, points = arms.PUMA
    points = [*points[:4], (0.41, 0.15, 1.1), (0.41, 0.25, 1.1)]
    bent = arms.robot("bent wrist", (axes[:5] + [(1.0, 0, 0)], points))
    assert "100 mm from where 4-5 meet" in str(classify(bent))
