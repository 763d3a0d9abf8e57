"""Jacobians against pinocchio and against finite differences."""

import numpy as np
import pytest
from robots_for_tests import random_q

from horosphere import kinematics, robots
from horosphere.entities import Circle, Line, Plane, Point, PointPair, Sphere
from horosphere.errors import InputError


def test_jacobians_agree_with_pinocchio(urdf_robot):
    robot, other = urdf_robot
    rng = np.random.default_rng(0)
    for q in random_q(robot, rng, (10,)):
        expected = other.pose(q)[1]
        assert kinematics.jacobian(robot, q) == pytest.approx(expected[robot.tip], abs=1e-12)
        assert kinematics.forward_and_jacobian(robot, q)[1] == pytest.approx(expected[robot.tip], abs=1e-12)
        for k, name in enumerate(robot.link_names):
            if name in other.model.names or k % 7 == 0:
                assert kinematics.jacobian(robot, q, link=name) == pytest.approx(expected[k], abs=1e-12)


@pytest.mark.parametrize("name", ["humanoid-arm", "ur5", "planar-3r"])
def test_twist_is_the_derivative_of_the_pose(name):
    robot = robots.load(name)
    rng = np.random.default_rng(1)
    q, h = random_q(robot, rng), 1e-6
    J = kinematics.jacobian(robot, q)
    rotation = kinematics.forward(robot, q).as_matrix()[:3, :3]
    for j in range(robot.n_joints):
        step = h * np.eye(robot.n_joints)[j]
        after, before = (kinematics.forward(robot, q + s * step).as_matrix() for s in (1, -1))
        spin = (after - before)[:3, :3] / (2 * h) @ rotation.T
        expected = [spin[2, 1], spin[0, 2], spin[1, 0], *((after - before)[:3, 3] / (2 * h))]
        assert J[:, j] == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("shape", [(), (5,), (2, 9)])
def test_batches_and_out(shape):
    robot = robots.load("srs-arm")
    q = random_q(robot, np.random.default_rng(2), shape)
    J = kinematics.jacobian(robot, q)
    assert J.shape == (*shape, 6, 7)
    out = np.empty(J.shape)
    assert kinematics.jacobian(robot, q, out=out) is out
    assert out == pytest.approx(J, abs=0)
    place = np.empty((*shape, 8))
    pose, both = kinematics.forward_and_jacobian(robot, q, out=(place, out))
    assert pose.array.base is place and both is out and not pose.array.flags.writeable
    assert both == pytest.approx(J, abs=1e-15)
    for index in np.ndindex(shape):
        assert kinematics.jacobian(robot, q[index]) == pytest.approx(J[index], abs=1e-14)
    with pytest.raises(InputError, match="out"):
        kinematics.jacobian(robot, q, out=np.empty((*shape, 7, 6)))
    with pytest.raises(InputError, match="out"):
        kinematics.jacobian(robot, q, out=np.asfortranarray(np.empty((*shape, 6, 7))))


def test_a_point_of_a_link():
    robot = robots.load("panda")
    rng = np.random.default_rng(3)
    q, point, h = random_q(robot, rng, (4,)), rng.normal(size=3), 1e-6
    J = kinematics.jacobian(robot, q, link="panda_link4", point=point)
    assert J.shape == (4, 6, 7)
    assert (J[..., 4:] == 0).all()
    for j in range(7):
        step = h * np.eye(7)[j]
        a, b = (
            kinematics.carry(robot, q + s * step, Point.from_euclidean(point), "panda_link4").as_euclidean()
            for s in (1, -1)
        )
        assert J[:, 3:, j] == pytest.approx((a - b) / (2 * h), abs=1e-8)
    many = kinematics.jacobian(robot, q[0], point=rng.normal(size=(6, 3)))
    assert many.shape == (6, 6, 7)
    with pytest.raises(InputError, match="point"):
        kinematics.jacobian(robot, q, point=[0.0, np.nan, 0.0])


ENTITIES = {
    "point": lambda a, b, c: Point.from_euclidean(a),
    "line": lambda a, b, c: Line.from_point_direction(a, b),
    "plane": lambda a, b, c: Plane.from_normal_distance(b, 0.3),
    "sphere": lambda a, b, c: Sphere.from_center_radius(a, 0.4),
    "circle": Circle.from_points,
    "pair": lambda a, b, c: PointPair.from_points(a, b),
}


@pytest.mark.parametrize("kind", ENTITIES)
@pytest.mark.parametrize("link", [None, "elbow"])
def test_entity_jacobian_is_the_derivative_of_the_moved_entity(kind, link):
    robot = robots.load("srs-arm")
    rng = np.random.default_rng(4)
    a, b, c = rng.normal(size=(3, 3))
    entity = ENTITIES[kind](a, b, c)
    q, h = random_q(robot, rng, (3,)), 1e-6
    J = kinematics.entity_jacobian(robot, q, entity, link)
    values = kinematics.carry(robot, q, entity, link).array
    assert J.shape == (*values.shape, 7)
    for j in range(7):
        step = h * np.eye(7)[j]
        after, before = (kinematics.carry(robot, q + s * step, entity, link).array for s in (1, -1))
        assert J[..., j] == pytest.approx((after - before) / (2 * h), abs=2e-8)


def test_prismatic_and_mimic_joints_carry_entities(urdf_robot):
    robot, _ = urdf_robot
    rng = np.random.default_rng(5)
    q, h = random_q(robot, rng), 1e-6
    line = Line.from_points(*rng.normal(size=(2, 3)))
    J = kinematics.entity_jacobian(robot, q, line)
    for j in range(robot.n_joints):
        step = h * np.eye(robot.n_joints)[j]
        after, before = (kinematics.carry(robot, q + s * step, line).array for s in (1, -1))
        assert J[:, j] == pytest.approx((after - before) / (2 * h), abs=5e-8)
    with pytest.raises(InputError, match="entity"):
        kinematics.entity_jacobian(robot, q, np.zeros(3))
