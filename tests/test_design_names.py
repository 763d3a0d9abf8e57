"""The fixed public signatures, each called with positions and with keywords: shapes, types, batch axes."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

import horosphere as hs

RNG = np.random.default_rng(20)
UNIT = np.eye(3)
BATCH = (2, 3)


def both(call, *arguments, **keywords):
    """The call by position; by keyword it gives the same."""
    first, second = call(*arguments), call(**keywords)
    same = np.array_equal(first, second) if isinstance(first, np.ndarray) else first == second
    assert same, f"{call} differs by keyword"
    return first


def random(*shape):
    return RNG.normal(size=(*BATCH, *shape))


# ---- entities


def test_point():
    xyz = random(3)
    point = both(hs.Point.from_euclidean, xyz, xyz=xyz)
    assert np.array_equal(point.as_euclidean(), xyz) and point.shape == BATCH


def test_sphere():
    c, r = random(3), np.abs(random())
    ball = both(hs.Sphere.from_center_radius, c, r, center=c, radius=r)
    assert ball.center.shape == (*BATCH, 3) and ball.radius.shape == BATCH
    np.testing.assert_allclose(ball.radius_squared, r * r)
    p = [random(3) for _ in range(4)]
    through = both(hs.Sphere.from_points, *p, **dict(zip("abcd", p)))
    np.testing.assert_allclose(np.linalg.norm(p[3] - through.center, axis=-1), through.radius)


def test_plane():
    n, d = random(3), random()
    plane = both(hs.Plane.from_normal_distance, n, d, normal=n, distance=d)
    np.testing.assert_allclose(np.linalg.norm(plane.normal, axis=-1), 1)
    assert np.array_equal(plane.distance, d)
    a, b, c = random(3), random(3), random(3)
    through = both(hs.Plane.from_points, a, b, c, a=a, b=b, c=c)
    np.testing.assert_allclose(np.sum(through.normal * c, -1), through.distance)


def test_line():
    a, b = random(3), random(3)
    line = both(hs.Line.from_points, a, b, a=a, b=b)
    other = both(hs.Line.from_point_direction, a, b - a, point=a, direction=b - a)
    np.testing.assert_allclose(line.direction, other.direction)
    np.testing.assert_allclose(line.moment, np.cross(a, line.direction), atol=1e-12)  # p x n


def test_circle():
    a, b, c = random(3), random(3), random(3)
    circle = both(hs.Circle.from_points, a, b, c, a=a, b=b, c=c)
    assert circle.center.shape == circle.normal.shape == (*BATCH, 3)
    again = both(
        hs.Circle.from_center_normal_radius, circle.center, circle.normal, circle.radius,
        center=circle.center, normal=circle.normal, radius=circle.radius,
    )  # fmt: skip
    np.testing.assert_allclose(again.radius_squared, circle.radius_squared)


def test_point_pair():
    a, b = random(3), random(3)
    pair = both(hs.PointPair.from_points, a, b, a=a, b=b)
    np.testing.assert_allclose(pair.points, np.stack([a, b], axis=-2), atol=1e-12)


def test_meets_and_what_is_real():
    ball, far = (hs.Sphere.from_center_radius([x, 0, 0], 1.0) for x in (0, 5))
    plane, other = (hs.Plane.from_normal_distance(n, 0.1) for n in UNIT[:2])
    circle, line = ball & plane, plane & other
    assert isinstance(circle, hs.Circle) and isinstance(ball & far, hs.Circle) and isinstance(line, hs.Line)
    for pair in (circle & other, other & circle, line & ball, ball & line, circle & ball):
        assert isinstance(pair, hs.PointPair)
    assert isinstance(line & hs.Plane.from_normal_distance(UNIT[2], 0), hs.Point)
    balls = hs.Sphere.from_center_radius([[0.5, 0, 0], [5, 0, 0]], 1.0)
    assert (ball & balls).is_real.tolist() == [True, False] and (ball & balls).is_real.dtype == bool
    assert type((ball & far).is_real) in (bool, np.bool_)


def test_distances_and_angles():
    a, b = hs.Point.from_euclidean(random(3)), hs.Point.from_euclidean([0.0, 0, 0])
    assert both(a.distance_to, b, other=b).shape == BATCH
    x, y = hs.Line.from_point_direction([0, 0, 0], UNIT[0]), hs.Line.from_point_direction([0, 0, 1], UNIT[1])
    assert x.distance_to(y) == 1.0
    assert both(x.angle_to, y, other=y) == pytest.approx(math.pi / 2)


def test_multivector_order():
    """Grade-lexicographic over e1 .. e5, e5 squares to -1; both null spaces."""
    names = hs.Multivector.NAMES
    assert names[:7] == ("1", "e1", "e2", "e3", "e4", "e5", "e12") and names[-1] == "e12345"
    assert names[16:18] == ("e123", "e124") and len(names) == 32
    p = hs.Point.from_euclidean(random(3))
    x = p.as_euclidean()
    half = 0.5 * np.sum(x * x, -1)
    coefficients = p.as_ipns().coefficients
    assert isinstance(p.as_ipns(), hs.Multivector) and coefficients.shape == (*BATCH, 32)
    np.testing.assert_allclose(coefficients[..., 1:4], x)
    np.testing.assert_allclose(coefficients[..., 4], half - 0.5)  # x + e0 + x^2/2 ei, ei = e4 + e5, e0 = (e5 - e4)/2
    np.testing.assert_allclose(coefficients[..., 5], half + 0.5)
    e5 = hs.Multivector.blade("e5")
    assert (e5 * e5).coefficients[0] == -1.0
    ball = hs.Sphere.from_center_radius([0, 0, 0], 1.0)
    on = hs.Point.from_euclidean([1.0, 0, 0]).as_ipns()
    assert np.abs((on | ball.as_ipns()).coefficients).max() < 1e-15
    assert np.abs((on ^ ball.as_opns()).coefficients).max() < 1e-15


# ---- versors


def test_versors():
    axis, angle = random(3), random()
    rotor = both(hs.Rotor.from_axis_angle, axis, angle, axis=axis, angle=angle)
    shift = both(hs.Translator.from_vector, axis, t=axis)
    plane = hs.Plane.from_normal_distance(axis, angle)
    mirror = both(hs.Reflector.from_plane, plane, plane=plane)
    line = hs.Line.from_points(random(3), random(3))
    motor = both(hs.Motor.from_line_angle, line, angle, line=line, angle=angle)
    matrix = motor.as_matrix()
    assert matrix.shape == (*BATCH, 4, 4)
    np.testing.assert_allclose(both(hs.Motor.from_matrix, matrix, T=matrix).as_matrix(), matrix, atol=1e-12)
    point = hs.Point.from_euclidean(random(3))
    homogeneous = np.concatenate([point.as_euclidean(), np.ones((*BATCH, 1))], axis=-1)[..., None]
    for versor in (rotor, shift, mirror, motor, motor @ motor, rotor @ shift, ~motor):
        moved = (versor @ point).as_euclidean()
        np.testing.assert_allclose(moved, (versor.as_matrix() @ homogeneous)[..., :3, 0], atol=1e-12)
    np.testing.assert_allclose((~motor @ motor).as_matrix(), np.broadcast_to(np.eye(4), (*BATCH, 4, 4)), atol=1e-12)
    for entity in (point, line, plane, hs.Sphere.from_center_radius(axis, 1.0)):
        assert type(motor @ entity) is type(entity)


def test_screw_is_the_matrix_exponential():
    screw = random(6)
    motor = both(hs.Motor.exp, screw, screw=screw)
    for s, T in zip(screw.reshape(-1, 6), motor.as_matrix().reshape(-1, 4, 4)):
        (a, b, c), v = s[:3], s[3:]
        twist = np.array([[0, -c, b, v[0]], [c, 0, -a, v[1]], [-b, a, 0, v[2]], [0, 0, 0, 0]])
        np.testing.assert_allclose(T, expm(twist), atol=1e-12)
    assert motor.log().shape == (*BATCH, 6)
    np.testing.assert_allclose(hs.Motor.exp(motor.log()).as_matrix(), motor.as_matrix(), atol=1e-12)


# ---- robots, kinematics, distance


def test_robots():
    robot = hs.robots.load("panda")
    assert len(robot.joint_names) == robot.n_joints == 7 == len(robot.limits.lower) == len(robot.limits.upper)
    assert set(robot.link_names) and all(isinstance(name, str) for name in robot.link_names)
    again = hs.robots.load(name_or_path="panda", base=None, tip=None)
    assert again.joint_names == robot.joint_names
    arms = (
        (hs.robots.humanoid_arm, {"d0": 0.1, "h": 0.1, "d1": 0.35, "d2": 0.3, "d3": 0.15}, 5),
        (hs.robots.srs_arm, {"dbs": 0.3, "dse": 0.3, "dew": 0.25, "dwf": 0.1}, 7),
        (hs.robots.six_axis_arm, {"a1": 0.1, "d1": 0.3, "a2": 0.4, "a3": 0.03, "d4": 0.4, "d6": 0.1}, 6),
    )
    for make, sizes, joints in arms:
        arm, by_name = make(*sizes.values()), make(**sizes)
        assert arm.n_joints == joints
        zero = hs.kinematics.forward(arm, np.zeros(joints)).as_matrix()
        np.testing.assert_allclose(zero[:3, :3], np.eye(3), atol=1e-12)  # axes as the base at q = 0
        np.testing.assert_array_equal(zero, hs.kinematics.forward(by_name, np.zeros(joints)).as_matrix())


def test_urdf_with_base_and_tip(tmp_path):
    (tmp_path / "arm.urdf").write_text(
        '<robot name="a"><link name="l0"/><link name="l1"/><link name="l2"/>'
        '<joint name="j1" type="revolute"><parent link="l0"/><child link="l1"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
        '<joint name="j2" type="prismatic"><parent link="l1"/><child link="l2"/><axis xyz="1 0 0"/>'
        '<limit lower="0" upper="1" velocity="1" effort="1"/></joint></robot>'
    )
    robot = hs.robots.load(tmp_path / "arm.urdf", "l0", "l2")
    assert robot.joint_names == hs.robots.load(name_or_path=str(tmp_path / "arm.urdf"), base="l0", tip="l2").joint_names
    moved = hs.kinematics.forward(robot, [math.pi / 2, 0.5]) @ hs.Point.origin()
    np.testing.assert_allclose(moved.as_euclidean(), [0, 0.5, 0], atol=1e-12)


def test_forward_and_jacobian():
    robot, q = hs.robots.load("panda"), 0.3 * random(7)
    pose = both(hs.kinematics.forward, robot, q, robot=robot, q=q, out=None)
    assert isinstance(pose, hs.Motor) and pose.shape == BATCH
    buffer = np.empty((*BATCH, 8))
    assert np.array_equal(hs.kinematics.forward(robot, q, buffer).array, pose.array) and np.array_equal(
        buffer, pose.array
    )
    links = both(hs.kinematics.frames, robot, q, robot=robot, q=q)
    assert isinstance(links, hs.Motor) and links.shape == (*BATCH, len(robot.link_names))
    jacobian = both(hs.kinematics.jacobian, robot, q, robot=robot, q=q, out=None)
    assert jacobian.shape == (*BATCH, 6, 7)
    into = np.empty((*BATCH, 6, 7))
    assert np.array_equal(hs.kinematics.jacobian(robot, q, out=into), jacobian) and np.array_equal(into, jacobian)
    q0, h = q[0, 0], 1e-6
    for j in range(7):  # rows angular then linear, at the tip, in base axes
        step = h * np.eye(7)[j]
        back, ahead = (hs.kinematics.forward(robot, q0 + s * step).as_matrix() for s in (-1, 1))
        spin = (ahead[:3, :3] - back[:3, :3]) @ hs.kinematics.forward(robot, q0).as_matrix()[:3, :3].T / (2 * h)
        angular = [spin[2, 1], spin[0, 2], spin[1, 0]]
        linear = (ahead[:3, 3] - back[:3, 3]) / (2 * h)
        np.testing.assert_allclose(jacobian[0, 0][:, j], [*angular, *linear], atol=1e-8)


def test_inverse():
    inverse = hs.kinematics.inverse
    srs = hs.robots.srs_arm(0.3, 0.3, 0.25, 0.1)
    pose = hs.kinematics.forward(srs, 0.5 * random(7))
    found = inverse(robot=srs, target=pose, psi=0.4)
    assert found.q.shape == (*BATCH, len(found.branch), 7) and found.valid.shape == found.q.shape[:-1]
    assert found.branch.ndim == 2 and found.residual.shape == found.valid.shape and found.is_closed_form is True
    assert found.valid.any(axis=-1).all() and np.shape(found.reason) == BATCH
    reached = hs.kinematics.forward(srs, found.q).as_matrix()
    gap = np.abs(reached - pose.as_matrix()[:, :, None]).max(axis=(-1, -2))
    assert (gap[found.valid] < 1e-9).all() and (found.residual[found.valid] < 1e-9).all()
    assert np.array_equal(inverse(srs, pose, psi=0.4).q, found.q)

    arm = hs.robots.humanoid_arm(0.1, 0.1, 0.35, 0.3, 0.15)
    target = hs.kinematics.GripperOnPlane([0.3, 0.1, 0.2], [0, 1, 0])
    same = hs.kinematics.GripperOnPlane(point=[0.3, 0.1, 0.2], normal=[0, 1, 0])
    by_phi = inverse(arm, target, phi=0.2, seed=np.zeros(5))
    assert by_phi.q.shape == (len(by_phi.branch), 5) and isinstance(by_phi.reason, str) and by_phi.valid.any()
    assert np.array_equal(inverse(robot=arm, target=same, phi=0.2, seed=np.zeros(5)).q, by_phi.q)
    tool = hs.kinematics.forward(arm, by_phi.q[by_phi.valid]).as_matrix()[:, :3, 3]
    np.testing.assert_allclose(tool, np.broadcast_to([0.3, 0.1, 0.2], tool.shape), atol=1e-9)
    assert by_phi.valid.shape == by_phi.q.shape[:-1]

    flat = hs.robots.load("planar-3r")
    search = inverse(flat, hs.kinematics.forward(flat, [0.3, 0.4, -0.5]), seed=np.zeros(3))
    assert search.is_closed_form is False and search.valid.any() and search.q.shape == (len(search.branch), 3)


def test_elbow_arcs():
    arm = hs.robots.srs_arm(0.0, 0.316, 0.248, 0.092)
    q = np.array([0.3, 0.8, 0.2, 1.2, 0.1, 0.4, 0.0])
    target, ball = hs.kinematics.forward(arm, q), hs.Sphere.from_center_radius([0.1, 0.25, 0.35], 0.1)
    arcs = hs.kinematics.elbow_arcs(arm, target, [ball], 0.01)
    assert arcs.free.ndim == 2 and arcs.free.shape[1] == 2 and len(arcs.free) > 0
    by_name = hs.kinematics.elbow_arcs(robot=arm, target=target, obstacles=[ball], clearance=0.01)
    assert np.array_equal(by_name.free, arcs.free)


def test_signed_distance():
    robot, q, ball = hs.robots.load("panda"), 0.3 * random(7), hs.Sphere.from_center_radius([0.4, 0.1, 0.5], 0.05)
    plain = both(hs.distance.signed, robot, q, [ball], robot=robot, q=q, obstacles=[ball])
    value, gradient = hs.distance.signed(robot, q, [ball], True)
    assert plain.shape == value.shape == BATCH and gradient.shape == (*BATCH, 7)
    np.testing.assert_allclose(value, plain, atol=1e-15)
    np.testing.assert_array_equal(hs.distance.signed(robot, q=q, obstacles=[ball], gradient=True)[1], gradient)
    one, slope = hs.distance.signed(robot, q[0, 0], ball, gradient=True)
    assert np.shape(one) == () and slope.shape == (7,) and one == pytest.approx(value[0, 0], abs=1e-15)


# ---- fields, maps


@pytest.mark.parametrize("n", [2, 3, 4])
def test_field(n):
    centers, radii = 3.0 * np.eye(n)[:2], np.array([0.5, 0.6])
    goal = np.full(n, 4.0)
    make = hs.fields.HarmonicField
    field = make(goal, (centers, radii), boundary=0.3, rule="planar-log")
    assert repr(make(goal=goal, obstacles=(centers, radii), boundary=0.3, rule="planar-log")) == repr(field)
    x = RNG.normal(size=(*BATCH, n)) - 3.0
    direction = field(x)
    np.testing.assert_allclose(np.linalg.norm(direction, axis=-1), 1)
    gradient, potential = both(field.gradient, x, x=x), both(field.potential, x, x=x)
    assert gradient.shape == (*BATCH, n) and potential.shape == BATCH
    np.testing.assert_allclose(-gradient / np.linalg.norm(gradient, axis=-1, keepdims=True), direction)
    path = field.trace(x[0, 0], step=0.05, tolerance=1e-6)
    assert path.points.ndim == 2 and path.points.shape[1] == n and path.reason == "reached"
    assert path.length > 0 and path.clearance > 0
    np.testing.assert_array_equal(field.trace(x0=x[0, 0], step=0.05, tolerance=1e-6).points, path.points)


def test_obstacles_of_a_field_as_a_list():
    pair = hs.fields.HarmonicField([4.0, 0, 0], (np.array([[2.0, 0, 0]]), np.array([0.5])))
    listed = hs.fields.HarmonicField([4.0, 0, 0], [hs.Sphere.from_center_radius([2.0, 0, 0], 0.5)])
    np.testing.assert_allclose(pair([0, 0.1, 0]), listed([0, 0.1, 0]))


def test_safe_charge():
    R, D = np.full(BATCH, 1.0), np.linspace(1.5, 4, 6).reshape(BATCH)
    call = hs.fields.safe_charge
    for rule in ("safe", "equilibrium", "monotone", "planar-log", "printed"):
        q = call(R, D, 3, rule=rule)
        assert q.shape == BATCH and np.array_equal(call(radius=R, distance=D, dimension=3, rule=rule), q)
    np.testing.assert_allclose(call(R, D, 2, rule="equilibrium"), R / (R + D))


def test_joukowski():
    q = np.array([[[2.0, 1.0], [3.0, -1.0]], [[-2.0, 0.5], [0.0, 2.5]]])
    sizes = {"a": 1.0, "b": 0.4, "center": [0.1, 0.2], "angle": 0.3}
    wing = {"k": 0.8, "mu": -0.1 + 0.05j, "center": [0.1, 0.2], "angle": 0.3}
    for make, given in ((hs.maps.Joukowski.ellipse, sizes), (hs.maps.Joukowski.aerofoil, wing)):
        shape, by_name = make(*given.values()), make(**given)
        p = both(shape.to_circle, q, q=q)
        assert p.shape == q.shape and np.array_equal(by_name.to_circle(q), p)
        np.testing.assert_allclose(both(shape.from_circle, p, p=p), q, atol=1e-12)
        slope, h = both(shape.derivative, p, p=p), 1e-6
        ahead, back = (shape.from_circle(p + [s * h, 0]) for s in (1, -1))
        np.testing.assert_allclose(slope, (ahead - back) / (2 * h), atol=1e-8)
        assert both(shape.contains, q, q=q).shape == q.shape[:-1] and not shape.contains(q).any()
        assert shape.contains(np.array([0.0, 0.2]))


# ---- snakes


def test_snake():
    snake = hs.snake.Snake(links=6, length=2.0, wheel_fraction=0.5)
    N = snake.links - 1
    assert (
        repr(hs.snake.Snake(6, 2.0)) == repr(hs.snake.Snake(lengths=[2.0] * 6)) == repr(snake) == repr(hs.snake.Snake())
    )
    q = RNG.uniform(-1, 1, (*BATCH, N + 3))
    assert both(snake.joints, q, q=q).shape == (*BATCH, N + 2, 2)
    assert both(snake.centres, q, q=q).shape == (*BATCH, N + 1, 2)
    assert both(snake.jacobian, q, q=q).shape[: len(BATCH)] == BATCH
    pfaff, basis = both(snake.pfaff, q, q=q), both(snake.control_basis, q, q=q)
    assert pfaff.shape == (*BATCH, N - 1, N + 3) and basis.shape == (*BATCH, N + 3, 4)
    assert np.abs(pfaff @ basis).max() < 1e-12
    assert both(snake.growth_vector, q[0, 0], True, q=q[0, 0], exact=True) == (4, 5, 7, 8)
    assert isinstance(snake.growth_vector(q[0, 0], exact=False), tuple)
    assert both(snake.is_singular, q, q=q).shape == BATCH and bool(snake.is_singular(np.zeros(N + 3)))
    assert both(snake.bracket, q, "12", q=q, word="12").shape == (*BATCH, N + 3)


def test_snake_motions():
    snake = hs.snake.Snake(links=5)
    q0 = np.array([0, 0, 0, 0.4, 0.5, -0.3, 0.2])
    controls = np.array([[0.1, 0.0, 0.1, 0.2], [0.0, 0.1, -0.1, 0.0]])
    motion = snake.simulate(q0, controls, 0.5)
    by_name = snake.simulate(q0=q0, controls=controls, duration=0.5)
    assert motion.time[-1] == 0.5 and np.array_equal(by_name.end, motion.end) and motion.end.shape == (7,)
    q1 = q0 + [0.05, 0.02, 0, 0, 0, 0, 0]
    steering = snake.steer(q0, q1, 1e-8)
    assert steering.solved and np.abs(steering.motion.end - q1).max() <= 1e-8
    assert snake.steer(q0=q0, q1=q1, tolerance=1e-8).solved
    joints = snake.joints(q0)
    chains = snake.closed_chain(joints[:2], joints[-2:], np.cumsum(q0[2:])[1 : snake.links - 3])
    assert chains is not None


# ---- scenes, plans, certificates


def test_plan_and_certificate(tmp_path):
    scene = hs.Scene.load("humanoid-reach")
    again = hs.Scene.load(path=scene.save(path=tmp_path / "again.yaml"))
    plan = hs.planning.plan(again)
    assert plan.solved is True and isinstance(plan.reason, str) and isinstance(plan.solved_by, str)
    assert all(seconds >= 0 for seconds in plan.timings.values()) and plan.trajectory.positions.ndim == 2
    certificate = hs.certify.certify(scene, plan.trajectory)
    by_name = hs.certify.certify(scene=scene, trajectory=plan.trajectory)
    assert certificate.certified is True and by_name.clearance == certificate.clearance >= scene.options.clearance
    assert certificate.first_violation is None and len(certificate.unresolved) == 0
    assert plan.certificate.certified
    assert hs.planning.plan(scene=scene, clearance=0.012).solved
