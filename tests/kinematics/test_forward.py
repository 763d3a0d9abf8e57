"""Forward kinematics against pinocchio, the numpy reference, and the geometry of the built-in arms."""

import numpy as np
import pytest
from robots_for_tests import random_q

from horosphere import kinematics, robots
from horosphere.entities import Line, Plane, Point, Sphere
from horosphere.errors import InputError
from horosphere.robots._placement import link_frames
from horosphere.versors import Motor


def test_frames_agree_with_pinocchio(urdf_robot):
    robot, other = urdf_robot
    rng = np.random.default_rng(0)
    for q in random_q(robot, rng, (20,)):
        expected = other.pose(q)[0]
        assert kinematics.frames(robot, q).as_matrix() == pytest.approx(expected, abs=1e-12)
        assert kinematics.forward(robot, q).as_matrix() == pytest.approx(expected[robot.tip], abs=1e-12)


@pytest.mark.parametrize("shape", [(), (1,), (7,), (8,), (3, 5), (0,), (2, 0)])
def test_batches_have_the_shape_of_q(shape):
    robot = robots.load("panda")
    q = random_q(robot, np.random.default_rng(1), shape)
    pose, frames = kinematics.forward(robot, q), kinematics.frames(robot, q)
    assert pose.array.shape == (*shape, 8) and frames.array.shape == (*shape, 12, 8)
    expected = link_frames(robot.links, q)
    assert frames.array == pytest.approx(expected, abs=1e-13)
    for index in np.ndindex(shape):
        assert kinematics.forward(robot, q[index]).array == pytest.approx(pose.array[index], abs=1e-15)


def test_output_goes_into_the_given_array():
    robot = robots.load("ur5")
    q = random_q(robot, np.random.default_rng(2), (9,))
    out = np.empty((9, 8))
    assert np.shares_memory(kinematics.forward(robot, q, out=out).array, out)
    assert out == pytest.approx(kinematics.forward(robot, q).array, abs=0)
    single = np.empty(8)
    for _ in range(2):  # the first call compiles, the second takes the short way
        kinematics.forward(robot, q[3], out=single)
        assert single == pytest.approx(out[3], abs=1e-15)
    locked = out.copy()
    locked.setflags(write=False)
    for bad in (np.empty((9, 7)), np.empty((9, 8), np.float32), np.empty((9, 16))[:, ::2], locked, [1, 2]):
        with pytest.raises(InputError, match="out"):
            kinematics.forward(robot, q, out=bad)
    with pytest.raises(InputError, match="out"):
        kinematics.forward(robot, q[0], out=np.empty(16)[::2])


def test_anything_numpy_takes_is_a_configuration():
    robot = robots.load("planar-3r")
    expected = kinematics.forward(robot, np.array([0.1, 0.2, 0.3])).array
    strided, read_only = np.zeros(6), np.array([0.1, 0.2, 0.3])
    strided[::2] = 0.1, 0.2, 0.3
    read_only.setflags(write=False)
    single = np.array([0.1, 0.2, 0.3], np.float32)
    for q in ([0.1, 0.2, 0.3], (0.1, 0.2, 0.3), strided[::2], read_only):
        assert kinematics.forward(robot, q).array == pytest.approx(expected, abs=1e-15)
    assert kinematics.forward(robot, single).array == pytest.approx(expected, abs=1e-7)
    assert kinematics.frames(robot, read_only).array[-1] == pytest.approx(
        link_frames(robot.links, read_only)[-1], abs=1e-15
    )


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("shape", [(), (20,)])
def test_numbers_that_are_not_finite_are_refused(bad, shape):
    robot = robots.load("srs-arm")
    q = np.zeros((*shape, 7))
    kinematics.forward(robot, q), kinematics.jacobian(robot, q)  # the compiled way is there now
    q[(*shape[:-1], 17, 4) if shape else 4] = bad
    for function in (kinematics.forward, kinematics.frames, kinematics.jacobian, kinematics.forward_and_jacobian):
        with pytest.raises(InputError, match=r"17, 4|\(4,\)"):
            function(robot, q)


def test_a_wrong_number_of_joints_is_refused():
    robot = robots.load("srs-arm")
    for q in (np.zeros(6), np.zeros((3, 8)), 0.0, "straight"):
        with pytest.raises(InputError):
            kinematics.forward(robot, q)


def test_humanoid_arm_at_home_and_by_hand():
    arm = robots.humanoid_arm(0.2, 0.1, 0.35, 0.30, 0.15)
    side = np.sqrt(0.2**2 - 0.1**2)
    points = kinematics.frames(arm, np.zeros(5)) @ Point.from_euclidean(np.zeros(3))
    assert points.as_euclidean()[2:5] == pytest.approx(
        np.array([[side, 0.1, 0], [side, 0.45, 0], [side, 0.75, 0]]), abs=1e-15
    )
    home = kinematics.forward(arm, np.zeros(5)).as_matrix()
    assert home[:3, :3] == pytest.approx(np.eye(3), abs=1e-15)
    assert home[:3, 3] == pytest.approx([side, 0.90, 0], abs=1e-15)
    # shoulder out by 90 degrees: the arm points along +x; then the torso turns it to -z
    out = kinematics.forward(arm, [0, np.pi / 2, 0, 0, 0]).as_matrix()[:3, 3]
    assert out == pytest.approx([side + 0.8, 0.1, 0], abs=1e-15)
    turned = kinematics.forward(arm, [np.pi / 2, np.pi / 2, 0, 0, 0]).as_matrix()[:3, 3]
    assert turned == pytest.approx([0, 0.1, -(side + 0.8)], abs=1e-15)


@pytest.mark.parametrize(
    ("arm", "tip"),
    [
        (robots.srs_arm(0.36, 0.42, 0.40, 0.126), [0, 0, 1.306]),
        (robots.six_axis_arm(0.1, 0.3, 0.4, 0.03, 0.5, 0.08), [0.68, 0, 0.73]),
    ],
    ids=["srs", "six"],
)
def test_other_arms_at_home(arm, tip):
    home = kinematics.forward(arm, np.zeros(arm.n_joints)).as_matrix()
    assert home[:3, :3] == pytest.approx(np.eye(3), abs=1e-15)
    assert home[:3, 3] == pytest.approx(tip, abs=1e-15)


@pytest.mark.parametrize("seed", range(3))
def test_carried_entities_move_with_their_link(seed):
    robot = robots.load("panda")
    rng = np.random.default_rng(seed)
    q = random_q(robot, rng, (4,))
    matrix = kinematics.frames(robot, q).as_matrix()[:, robot.link_names.index("panda_link5")]
    p, n = rng.normal(size=3), rng.normal(size=3)
    n /= np.linalg.norm(n)
    place, direction = np.einsum("bij,j->bi", matrix[:, :3, :3], p) + matrix[:, :3, 3], matrix[:, :3, :3] @ n

    def at(entity):
        return kinematics.carry(robot, q, entity, "panda_link5")

    assert at(Point.from_euclidean(p)).as_euclidean() == pytest.approx(place, abs=1e-13)
    line = at(Line.from_point_direction(p, n))
    assert line.direction == pytest.approx(direction, abs=1e-13)
    assert line.moment == pytest.approx(np.cross(place, direction), abs=1e-13)
    plane = at(Plane.from_normal_distance(n, n @ p))
    assert plane.distance == pytest.approx((direction * place).sum(-1), abs=1e-13)
    assert at(Sphere.from_center_radius(p, 0.2)).center == pytest.approx(place, abs=1e-13)
    with pytest.raises(InputError, match="panda_link5"):
        kinematics.carry(robot, q, line, "panda_link55")


def test_robots_that_move_alike_share_compiled_code():
    from horosphere.kinematics._robot_kernels import robot_kernel

    first, second, other = robots.srs_arm(), robots.srs_arm(radius=0.01), robots.srs_arm(0.1)
    assert robot_kernel(first, "forward") is robot_kernel(second, "forward")
    assert robot_kernel(first, "forward") is not robot_kernel(other, "forward")


def test_compiled_kernel_agrees_with_its_numpy_reference():
    from horosphere.kinematics._robot_kernels import robot_kernel

    robot = robots.load("iiwa14")
    q = random_q(robot, np.random.default_rng(3), (21,))
    pose, J = kinematics.forward_and_jacobian(robot, q)
    expected = robot_kernel(robot, "forward and jacobian").reference(q)
    assert pose.array == pytest.approx(expected[0], abs=1e-14)
    np.testing.assert_allclose(J, expected[1], rtol=0, atol=1e-14)
    assert isinstance(pose, Motor) and J.shape == (21, 6, 7)
