"""Every kind of goal with several robots: joints, pose, point, and the tool on a line or a plane of the algebra."""

import numpy as np
import pytest

from horosphere import kinematics, robots
from horosphere.distance import clearance
from horosphere.planning import plan
from horosphere.scenes import JointTarget, LineTarget, PlaneTarget, PositionTarget, Scene
from horosphere.shapes import Ball


@pytest.mark.parametrize("name", ["panda", "ur5", "iiwa14", "nao-left-arm"])
def test_goals(name):
    rng = np.random.default_rng(0)
    robot = robots.load(name)
    low, high = np.clip(robot.limits.lower, -2.0, 2.0), np.clip(robot.limits.upper, -2.0, 2.0)

    def free():
        while True:
            q = 0.5 * (low + high) + 0.4 * (high - low) * rng.uniform(-1.0, 1.0, robot.n_joints)
            if clearance(robot, q, ()) > 0.003:
                return q

    start, goal = free(), free()
    pose = kinematics.forward(robot, goal)
    T = pose.as_matrix()
    p = T[:3, 3]
    across = LineTarget(p, T[:3, 0]), PlaneTarget(T[:3, 2], float(T[:3, 2] @ p))
    for target in (JointTarget(goal), pose, PositionTarget(p), *across):
        found = plan(Scene(robot, start, target, [Ball(p + [0, 0, 0.35], 0.03)]), clearance=0.002)
        assert found.solved, (name, target, found.reason)
        q = found.trajectory.positions[-1]
        x = kinematics.forward(robot, q).as_matrix()
        if isinstance(target, LineTarget):  # the tool point on the line, whatever its place there
            assert np.linalg.norm(np.cross(x[:3, 3] - p, T[:3, 0])) < 1e-6
        elif isinstance(target, PlaneTarget):
            assert abs((x[:3, 3] - p) @ T[:3, 2]) < 1e-6
        else:
            assert np.abs(x[:3, 3] - p).max() < 1e-6
        assert not hasattr(target, "as_matrix") or np.abs(x - T).max() < 1e-6
