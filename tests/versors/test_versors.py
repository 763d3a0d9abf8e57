"""Composition and action of versors against 4x4 matrices and the dense sandwich product."""

import numpy as np
import pytest
from entities.samples import KINDS, random

import horosphere as hs
from horosphere.versors import _kernels as k

SEEDS = [0, 1, 2]
SHAPES = [((), ()), ((4,), (4,)), ((3, 1), (5,)), ((), (9,)), ((9,), ())]
VERSORS = {
    "Motor": lambda g, s: hs.Motor.exp(g.normal(size=(*s, 6))),
    "Rotor": lambda g, s: hs.Rotor.from_axis_angle(g.normal(size=(*s, 3)), g.normal(size=s)),
    "Translator": lambda g, s: hs.Translator.from_vector(g.normal(size=(*s, 3))),
    "Reflector": lambda g, s: hs.Reflector.from_plane(random("Plane", g, s)),
}
RIGID = [v for v in VERSORS if v != "Reflector"]


def homogeneous(matrix, x):
    return np.einsum("...ij,...j->...i", matrix[..., :3, :3], x) + matrix[..., :3, 3]


def turned(matrix, n):
    return np.einsum("...ij,...j->...i", matrix[..., :3, :3], n)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("shapes", SHAPES, ids=str)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("versor", VERSORS)
def test_action_is_that_of_the_matrix(versor, kind, shapes, seed):
    rng = np.random.default_rng(seed)
    v, x = VERSORS[versor](rng, shapes[0]), random(kind, rng, shapes[1])
    y, t = v @ x, v.as_matrix()
    assert type(y) is type(x) and y.shape == np.broadcast_shapes(*shapes)
    if kind == "Point":
        np.testing.assert_allclose(y.as_euclidean(), homogeneous(t, x.as_euclidean()), atol=1e-14)
        np.testing.assert_allclose(y.array[..., 4], 0.5 * np.sum(y.as_euclidean() ** 2, -1), rtol=1e-15)
    elif kind == "PointPair":
        np.testing.assert_allclose(y.points, homogeneous(t[..., None, :, :], x.points), atol=1e-13)
    elif kind == "Line":
        a, b = x.point, x.point + x.direction
        moved = hs.Line.from_points(homogeneous(t, a), homogeneous(t, b))
        np.testing.assert_allclose(y.array, moved.array, atol=1e-13)
    elif kind == "Plane":
        np.testing.assert_allclose(y.normal, turned(t, x.normal), atol=1e-14)
        np.testing.assert_allclose(y.side_of(homogeneous(t, x.point)), 0, atol=1e-14)
    else:
        np.testing.assert_allclose(y.center, homogeneous(t, x.center), atol=1e-14)
        np.testing.assert_allclose(y.radius, np.broadcast_to(x.radius, y.shape), rtol=1e-15)
        if kind == "Circle":
            np.testing.assert_allclose(y.normal, turned(t, x.normal), atol=1e-14)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("versor", RIGID)
def test_action_is_the_sandwich(versor, kind, seed):
    rng = np.random.default_rng(seed)
    v, x = VERSORS[versor](rng, ()), random(kind, rng)
    m = v.as_multivector()
    assert (m * ~m).isclose(hs.Multivector.scalar(1.0), atol=1e-14)
    assert (m * x.as_ipns() * ~m).isclose((v @ x).as_ipns(), atol=1e-12)
    assert (m * x.as_opns() * ~m).isclose((v @ x).as_opns(), atol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", KINDS)
def test_reflection_is_the_sandwich(kind, seed):
    """(-1)^k pi X pi on the IPNS k-blade, or on the OPNS blade for lines and pairs, whose points keep their order."""
    rng = np.random.default_rng(seed)
    mirror, x = VERSORS["Reflector"](rng, ()), random(kind, rng)
    pi = mirror.as_multivector()
    if kind in ("Line", "PointPair"):
        expected, got = pi * x.as_opns().involute() * pi, (mirror @ x).as_opns()
    else:
        expected, got = pi * x.as_ipns().involute() * pi, (mirror @ x).as_ipns()
    assert expected.isclose(got, atol=1e-12)
    assert (mirror @ (mirror @ x)).isclose(x, atol=1e-12) and ~mirror == mirror


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("shapes", SHAPES, ids=str)
@pytest.mark.parametrize("second", RIGID)
@pytest.mark.parametrize("first", RIGID)
def test_composition_is_that_of_the_matrices(first, second, shapes, seed):
    rng = np.random.default_rng(seed)
    a, b = VERSORS[first](rng, shapes[0]), VERSORS[second](rng, shapes[1])
    c = a @ b
    assert type(c).__name__ == (first if first == second else "Motor")
    assert c.shape == np.broadcast_shapes(*shapes)
    np.testing.assert_allclose(c.as_matrix(), a.as_matrix() @ b.as_matrix(), atol=1e-14)
    np.testing.assert_allclose((~a).as_matrix(), np.linalg.inv(a.as_matrix()), atol=1e-13)
    assert (a.as_multivector() * b.as_multivector()).isclose(c.as_multivector(), atol=1e-13).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_two_reflections_make_a_motor(seed):
    rng = np.random.default_rng(seed)
    a, b = VERSORS["Reflector"](rng, (6,)), VERSORS["Reflector"](rng, (6,))
    np.testing.assert_allclose((a @ b).as_matrix(), a.as_matrix() @ b.as_matrix(), atol=1e-13)
    # about the line of both planes, by twice their angle, right-handed from the plane reflected in first [eq 15]
    line = b.plane & a.plane
    expected = hs.Motor.from_line_angle(line, 2 * b.plane.angle_to(a.plane))
    assert (a @ b).is_same_motion(expected, 1e-11).all()
    # parallel planes: a translation by twice the gap, from the first to the second [eq 13]
    p, q = (hs.Reflector.from_plane(hs.Plane.from_normal_distance([0, 0, 1], d)) for d in (0.0, 0.7))
    np.testing.assert_allclose((q @ p).log(), [0, 0, 0, 0, 0, 1.4], atol=1e-15)


@pytest.mark.parametrize("seed", SEEDS)
def test_rotation_about_a_line(seed):
    rng = np.random.default_rng(seed)
    line, angle, advance = random("Line", rng, (7,)), rng.uniform(0.1, 3, 7), rng.normal(size=7)
    m = hs.Motor.from_line_angle(line, angle, advance)
    assert (m @ line).isclose(line, atol=1e-13).all()
    on = line.point
    np.testing.assert_allclose((m @ hs.Point.from_euclidean(on)) - hs.Point.from_euclidean(on),
                               advance[:, None] * line.direction, atol=1e-13)  # fmt: skip
    x = rng.normal(size=(7, 3))
    arm = x - line.project(x)
    moved = (m @ hs.Point.from_euclidean(x)).as_euclidean() - line.project(x) - advance[:, None] * line.direction
    expected = np.cos(angle)[:, None] * arm + np.sin(angle)[:, None] * np.cross(line.direction, arm)
    np.testing.assert_allclose(moved, expected, atol=1e-13)
    axis, theta, slide = m.as_screw()
    np.testing.assert_allclose(theta, angle, rtol=1e-13)
    np.testing.assert_allclose(slide, advance, atol=1e-13)
    assert axis.isclose(line, atol=1e-12).all()
    half = np.cos(angle / 2) - np.sin(angle / 2) * line.as_ipns()
    assert half.isclose(hs.Motor.from_line_angle(line, angle).as_multivector(), atol=1e-13).all()


def test_screw_of_a_translation_and_of_the_identity():
    axis, angle, advance = hs.Motor.from_translation([0, 3, 4]).as_screw()
    assert angle == 0 and advance == 5.0
    np.testing.assert_allclose(axis.direction, [0, 0.6, 0.8])
    axis, angle, advance = hs.Motor.identity().as_screw()
    assert angle == 0 and advance == 0 and (axis.direction == [0, 0, 1]).all()


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 1e-4, 1.0, 2.0, np.pi - 1e-8, np.pi])
def test_matrices_come_back(angle, seed):
    rng = np.random.default_rng(seed)
    axis = np.concatenate([rng.normal(size=(20, 3)), np.eye(3), -np.eye(3)])
    m = hs.Motor.exp(np.concatenate([angle * axis / np.linalg.norm(axis, axis=-1)[:, None], 3 * axis], -1))
    back = hs.Motor.from_matrix(m.as_matrix())
    assert back.is_same_motion(m, 1e-14).all() and (back.array[:, 0] >= 0).all()
    np.testing.assert_allclose(back.as_matrix(), m.as_matrix(), atol=1e-14)
    r = hs.Rotor.from_matrix(m.as_matrix()[:, :3, :3])
    np.testing.assert_allclose(r.as_rotation_matrix(), m.as_matrix()[:, :3, :3], atol=1e-14)
    if 0 < angle < 1e-3:  # small rotations keep their relative accuracy through the matrix
        np.testing.assert_allclose(np.linalg.norm(back.log()[:, :3], axis=-1), angle, rtol=1e-14)


@pytest.mark.parametrize("seed", SEEDS)
def test_rotors_against_scipy(seed):
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(seed)
    w = rng.normal(size=(30, 3))
    theirs = Rotation.from_rotvec(w)
    ours = hs.Rotor.exp(w)
    np.testing.assert_allclose(ours.as_rotation_matrix(), theirs.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(ours.as_quaternion(), theirs.as_quat(scalar_first=True), atol=1e-14)
    np.testing.assert_allclose(hs.Rotor.from_quaternion(3 * ours.as_quaternion()).array, ours.array, atol=1e-15)
    np.testing.assert_allclose(ours.log(), theirs.as_rotvec(), atol=1e-14)
    axis, angle = ours.as_axis_angle()
    again = hs.Rotor.from_axis_angle(axis, angle)
    assert (again.isclose(ours, atol=1e-14) | again.isclose(-ours, atol=1e-14)).all()
    a, b = rng.normal(size=(2, 30, 3))
    for target in (b, a, -a, -a + 1e-9 * b):
        turn = hs.Rotor.between(a, target).as_rotation_matrix()
        expected = target / np.linalg.norm(target, axis=-1, keepdims=True)
        got = np.einsum("...ij,...j", turn, a / np.linalg.norm(a, axis=-1, keepdims=True))
        np.testing.assert_allclose(got, expected, atol=2e-8)


def test_a_thousand_products_stay_unit():
    m = step = hs.Motor.exp([0.1, 0.2, -0.3, 0.4, 0.5, 0.6])
    for _ in range(999):
        m = step @ m
    expected = hs.Motor.exp(1000 * np.array([0.1, 0.2, -0.3, 0.4, 0.5, 0.6]))
    assert m.is_same_motion(expected, 1e-11)
    assert hs.Motor.renormalised(m).is_same_motion(expected, 1e-11)


@pytest.mark.parametrize("count", [1, 5, 8, 17])
def test_compiled_actions_are_the_reference_ones(count):
    rng = np.random.default_rng(count)
    m = VERSORS["Motor"](rng, (count,)).array
    for kernel, kind in [
        (k.motor_point, "Point"), (k.motor_line, "Line"), (k.motor_plane, "Plane"), (k.motor_sphere, "Sphere"),
        (k.motor_round, "Circle"), (k.motor_round, "PointPair"),
    ]:  # fmt: skip
        x = random(kind, rng, (count,)).array
        np.testing.assert_allclose(kernel(m, x), kernel.reference(m, x), rtol=0, atol=1e-13)
    np.testing.assert_allclose(k.motor_product(m, m), k.motor_product.reference(m, m), rtol=0, atol=1e-14)
    np.testing.assert_allclose(k.motor_matrix(m), k.motor_matrix.reference(m), rtol=0, atol=1e-14)


def test_from_multivector():
    m = VERSORS["Motor"](np.random.default_rng(0), (4,))
    assert hs.Motor.from_multivector(m.as_multivector()).isclose(m, atol=1e-14).all()
    with pytest.raises(hs.InputError, match="expected a motor"):
        hs.Motor.from_multivector(m.as_multivector() + hs.algebra.basis.e1)
    x = hs.Multivector(np.random.default_rng(1).normal(size=32))
    assert (m[0] @ x).isclose(m[0].as_multivector() * x * ~m[0].as_multivector())
