"""FK(IK) of the arms people own, through the URDF that is written of them and the classifier."""

import numpy as np
import pytest
import structured_arms as arms
from plain_fk import chain_pose, pose_gap, turned

from horosphere.kinematics import classify, inverse
from horosphere.robots import load, save
from horosphere.versors import Motor


@pytest.mark.parametrize("count", [300, pytest.param(10_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", arms.REAL)
def test_every_valid_row_meets_the_pose_and_one_is_the_posture(name, count, tmp_path):
    arm = arms.REAL[name]
    save(arms.robot(name, arm), tmp_path / "arm.urdf")
    robot = load(tmp_path / "arm.urdf")
    assert classify(robot).is_closed_form, str(classify(robot))
    q = np.random.default_rng(len(name)).uniform(-np.pi, np.pi, (count, robot.n_joints))
    T = chain_pose(*arms.pose_chain(arm), q)
    found = inverse(robot, Motor.from_matrix(T), seed=q)
    assert found.solved.all()
    assert pose_gap(chain_pose(*arms.pose_chain(arm), found.q), T[:, None])[found.valid].max() < 1e-10
    again = np.where(found.valid, np.abs(turned(found.q - q[:, None])).max(-1), 9).min(-1)
    assert again.max() < 1e-4 and np.quantile(again, 0.99) < 1e-8
