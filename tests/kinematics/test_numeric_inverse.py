"""The numerical inverse: solved to the tolerance inside the limits, or said why not."""

import numpy as np
import pytest
from robots_for_tests import random_q

from horosphere import kinematics, robots
from horosphere.entities import Line, Point
from horosphere.errors import InputError
from horosphere.kinematics import numerical_inverse
from horosphere.versors import Motor, Translator


def pose_error(robot, q, matrix):
    """Distance (m) and angle (rad) between the tool at q and a pose, by matrices."""
    reached = kinematics.forward(robot, q).as_matrix()
    change = reached[..., :3, :3] @ np.swapaxes(matrix[..., :3, :3], -1, -2)
    skew = change - np.swapaxes(change, -1, -2)
    sine = 0.5 * np.sqrt(skew[..., 2, 1] ** 2 + skew[..., 0, 2] ** 2 + skew[..., 1, 0] ** 2)
    angle = np.arctan2(sine, 0.5 * (np.trace(change, axis1=-2, axis2=-1) - 1))
    return np.linalg.norm(reached[..., :3, 3] - matrix[..., :3, 3], axis=-1), angle


def test_what_is_missing_is_said_in_what_the_target_asks_for():
    """A point asks for no orientation."""
    panda, short = robots.load("panda"), {"attempts": 2, "iterations": 1}
    pose = Translator.from_vector([0.3, 0.4, 0.5]) @ Motor.identity()
    for target, turned in ((pose, True), (pose @ Point.from_euclidean([0, 0, 0]), False)):
        reason = numerical_inverse(panda, target, **short).reason
        assert reason.startswith("not reached: ") and (" m and " in reason) == (" rad away" in reason) == turned, reason


@pytest.mark.parametrize("name", ["panda", "ur5", "iiwa14", "srs-arm"])
def test_random_reachable_poses(name):
    robot = robots.load(name)
    q = random_q(robot, np.random.default_rng(0), (1000,))
    target = kinematics.forward(robot, q)
    found = numerical_inverse(robot, target)
    assert found.valid.mean() >= 0.995
    ok = found.valid[:, 0]
    distance, angle = pose_error(robot, found.q[ok, 0], target.as_matrix()[ok])
    assert distance.max() < 1e-8 and angle.max() < 1e-7
    assert found.within_limits(robot)[ok].all()
    assert not found.is_closed_form
    assert found.residual[ok].max() < 1e-8


def test_panda_urdf_of_the_data_folder(shared_data):
    robot = robots.load(shared_data / "panda_spheres.urdf", tip="panda_hand")
    q = random_q(robot, np.random.default_rng(1), (1000,))
    target = kinematics.forward(robot, q)
    found = numerical_inverse(robot, target, tolerance=1e-6)
    assert found.valid.mean() >= 0.995
    distance, angle = pose_error(robot, found.q[:, 0], target.as_matrix())
    assert np.quantile(distance, 0.995) < 1e-6 and np.quantile(angle, 0.995) < 2e-6


def test_position_direction_and_line_targets():
    robot = robots.load("panda")
    q = random_q(robot, np.random.default_rng(2), (100,))
    pose = kinematics.forward(robot, q)
    place = (pose @ Point.from_euclidean(np.zeros(3))).as_euclidean()
    z = pose.as_matrix()[:, :3, 2]

    def reached(found):
        assert found.valid.all() and found.within_limits(robot).all()
        matrix = kinematics.forward(robot, found.q[:, 0]).as_matrix()
        return matrix[:, :3, 3], matrix[:, :3, 2]

    x, _ = reached(numerical_inverse(robot, Point.from_euclidean(place)))
    assert x == pytest.approx(place, abs=1e-8)
    for direction in (z, Line.from_point_direction(place, z)):
        x, axis = reached(numerical_inverse(robot, (Point.from_euclidean(place), direction)))
        assert x == pytest.approx(place, abs=1e-8) and axis == pytest.approx(z, abs=1e-8)
    x, axis = reached(numerical_inverse(robot, Line.from_point_direction(place, z)))
    assert axis == pytest.approx(z, abs=1e-8)
    assert np.cross(x - place, z) == pytest.approx(np.zeros((100, 3)), abs=1e-8)
    # another axis of the tool
    y = pose.as_matrix()[:, :3, 1]
    found = numerical_inverse(robot, (Point.from_euclidean(place), y), tool_axis=[0, 2, 0])
    assert found.valid.all()
    assert kinematics.forward(robot, found.q[:, 0]).as_matrix()[:, :3, 1] == pytest.approx(y, abs=1e-8)


def test_a_direction_opposite_to_the_start_is_found():
    robot = robots.load("planar-3r")
    target = (Point.from_euclidean([0.5, 0.0, 0.5]), [0.0, 0.0, -1.0])
    found = numerical_inverse(robot, target, seed=np.zeros(3), attempts=1)  # the arm is straight up, its axis is +z
    assert found.valid.all()
    assert kinematics.forward(robot, found.q[0]).as_matrix()[:3, 2:] == pytest.approx(
        np.array([[0, 0.5], [0, 0], [-1, 0.5]]), abs=1e-8
    )


def test_near_the_seed_the_answer_stays_near():
    robot = robots.load("panda")
    q = np.array([0.3, -0.4, 0.2, -2.0, 0.1, 1.8, 0.5])
    near = kinematics.forward(robot, q + 1e-3)
    found = numerical_inverse(robot, near, seed=q)
    assert found.valid.all()
    assert np.abs(found.q - q).max() < 0.02


def test_several_solutions_differ_and_all_reach():
    robot = robots.load("ur5")
    q = np.array([0.4, -1.1, 1.3, -0.6, 0.9, 0.2])
    target = kinematics.forward(robot, q)
    found = numerical_inverse(robot, target, solutions=8)
    assert found.q.shape == (8, 6) and found.valid.sum() >= 6
    rows = found.q[found.valid]
    distance, angle = pose_error(robot, rows, target.as_matrix())
    assert distance.max() < 1e-8 and angle.max() < 1e-7
    gaps = np.abs(rows[:, None] - rows[None]).max(-1) + np.eye(len(rows))
    assert gaps.min() > 0.02


def test_what_cannot_be_reached_is_a_value_with_a_reason():
    robot = robots.load("panda")
    far = Motor.from_matrix(np.block([[np.eye(3), np.array([[2.0], [0], [0.5]])], [np.zeros((1, 3)), np.ones((1, 1))]]))
    found = numerical_inverse(robot, far, attempts=5)
    assert not found.valid.any() and "unreachable" in found.reason
    assert np.isfinite(found.q).all() and found.within_limits(robot).sum() == 0
    assert found.residual[0] == pytest.approx(max(pose_error(robot, found.q[0], far.as_matrix())), rel=1e-6)
    # reachable but for the limits: one joint, a quarter turn too far
    arm = robots.load("planar-3r")
    limits = robots.Limits(*(np.array(v) for v in ([-1.0] * 3, [1.0] * 3, [1.0] * 3, [1.0] * 3, [1.0] * 3)))
    arm = robots.Robot(arm.name, arm.links, arm.tip, arm.joint_names, limits, arm.tool)
    behind = numerical_inverse(arm, Point.from_euclidean([0.0, 0.0, -2.9]), attempts=20)
    assert not behind.valid.any() and "limit" in behind.reason and "theta_1" in behind.reason
    assert (np.abs(behind.q) <= 1.0).all()


def test_batches_of_targets_and_seeds():
    robot = robots.load("ur5")
    q = random_q(robot, np.random.default_rng(3), (2, 3))
    found = numerical_inverse(robot, kinematics.forward(robot, q), seed=q)
    assert found.q.shape == (2, 3, 1, 6) and found.valid.shape == (2, 3, 1) and found.reason.shape == (2, 3)
    assert found.q[..., 0, :] == pytest.approx(q, abs=1e-12)
    again = numerical_inverse(robot, kinematics.forward(robot, q))
    once_more = numerical_inverse(robot, kinematics.forward(robot, q))
    assert (again.q == once_more.q).all()


def test_a_prismatic_joint_and_no_limits(tmp_path):
    path = tmp_path / "gantry.urdf"
    joints = "".join(
        f'<link name="l{k + 1}"/><joint name="j{k}" type="{kind}"><parent link="l{k}"/><child link="l{k + 1}"/>'
        f'<origin xyz="0 0 0.1"/><axis xyz="{axis}"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
        for k, (kind, axis) in enumerate(
            [("prismatic", "1 0 0"), ("prismatic", "0 1 0"), ("continuous", "0 0 1"), ("revolute", "0 1 0")]
        )
    )
    path.write_text(f'<robot name="gantry"><link name="l0"/>{joints}</robot>')
    robot = robots.load(path)
    q = np.array([1.3, -0.7, 5.0, 0.4])
    found = numerical_inverse(robot, kinematics.forward(robot, q))
    assert found.valid.all()
    assert kinematics.forward(robot, found.q[0]).as_matrix() == pytest.approx(
        kinematics.forward(robot, q).as_matrix(), abs=1e-8
    )


@pytest.mark.parametrize(
    ("target", "options", "word"),
    [
        (np.eye(4), {}, "Motor"),
        (Translator.from_vector([0, 0, 1]), {}, "Motor"),
        ((Point.from_euclidean([0, 0, 1]), [0, 0, 0]), {}, "zero"),
        (Point.from_euclidean([0, 0, 1]), {"tool_axis": [0, 0, 0]}, "zero"),
        (Point.from_euclidean([0, 0, 1]), {"seed": np.zeros(5)}, "seed"),
        (Point.from_euclidean([0, 0, 1]), {"seed": np.full(7, np.nan)}, "seed"),
        (Point.from_euclidean([0, 0, 1]), {"attempts": 0}, "attempts: expected at least 1"),
    ],
)
def test_bad_input(target, options, word):
    with pytest.raises(InputError, match=word):
        numerical_inverse(robots.load("panda"), target, **options)
