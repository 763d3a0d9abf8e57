"""Kernels against plain trigonometry, finite differences and dense linear algebra."""

import numpy as np
import plain_model as plain
import pytest

from horosphere.errors import InputError
from horosphere.snake import Snake
from horosphere.snake._inverse import angles_kernel
from horosphere.snake._model import snake_kernel


@pytest.mark.parametrize("fraction", [0.5, 0.3, 1.0])
@pytest.mark.parametrize("links", range(3, 14))
def test_every_kernel_agrees_with_trigonometry(links, fraction, rng):
    lengths = rng.uniform(0.5, 3.0, links)
    data = np.append(lengths, fraction)
    q = np.concatenate([rng.uniform(-5, 5, (6, 2)), rng.uniform(-3, 3, (6, links))], axis=1)
    witnesses = {
        "joints": lambda p: plain.joints(p, lengths),
        "centres": lambda p: plain.wheels(p, lengths, fraction),
        "jacobian": lambda p: plain.wheel_jacobian(p, lengths, fraction),
        "pfaff": lambda p: plain.pfaff(p, lengths, fraction),
    }
    for what, witness in witnesses.items():
        values = snake_kernel(what, links).reference(q, data)
        expected = np.array([witness(p).ravel() for p in q])
        np.testing.assert_allclose(values, expected, rtol=0, atol=1e-12 * max(1.0, lengths.sum()), err_msg=what)
    values = snake_kernel("control_basis", links).reference(q, data)
    expected = np.array([plain.basis(p, lengths, fraction).ravel() for p in q])
    scale = np.abs(expected).max(axis=1, keepdims=True)
    np.testing.assert_allclose(values / scale, expected / scale, rtol=0, atol=1e-11)


def test_compiled_batches_and_single_calls_agree_with_trigonometry(rng):
    snake = Snake(8)
    q = rng.uniform(-3, 3, (3, 7, snake.n))
    joints, basis, pfaff = snake.joints(q), snake.control_basis(q), snake.pfaff(q)
    assert joints.shape == (3, 7, 9, 2) and basis.shape == (3, 7, 10, 4) and pfaff.shape == (3, 7, 6, 10)
    for index in np.ndindex(3, 7):
        np.testing.assert_allclose(joints[index], plain.joints(q[index], snake.lengths), rtol=0, atol=1e-12)
        np.testing.assert_allclose(basis[index], plain.basis(q[index], snake.lengths, 0.5), rtol=0, atol=1e-12)
        np.testing.assert_allclose(pfaff[index] @ basis[index], 0.0, atol=1e-13)
    single = snake.split_model(snake.model(q[0, 0].copy()))
    for part, batch in zip(single, (joints, pfaff, basis)):
        np.testing.assert_allclose(part, batch[0, 0], rtol=0, atol=1e-14)


def test_jacobian_is_the_derivative_of_the_wheel_points(rng):
    snake = Snake(lengths=[1.0, 2.0, 1.5, 0.7, 2.2, 1.0], wheel_fraction=0.4)
    q, h = rng.uniform(-2, 2, snake.n), 1e-6
    jacobian = snake.jacobian(q)
    for k in range(snake.n):
        e = h * np.eye(snake.n)[k]
        np.testing.assert_allclose(
            (snake.centres(q + e) - snake.centres(q - e)) / (2 * h), jacobian[:, :, k], atol=1e-8
        )


@pytest.mark.slow
def test_pfaff_rows_are_the_wedge_constraint_in_the_full_algebra(rng):
    """((p . L_k) ^ P_i ^ einf) dualised with e3, in the third-party clifford package."""
    from clifford.g3c import blades, e1, e2, e3, einf, up

    snake = Snake(5, length=1.7)
    q = rng.uniform(-2, 2, snake.n)
    pfaff, joints, centres = snake.pfaff(q), snake.joints(q), snake.centres(q)
    points = [up(x * e1 + y * e2) for x, y in joints]
    wheels = [up(x * e1 + y * e2) for x, y in centres]
    pseudo = blades["e12345"]
    axes = [e1 * einf, e2 * einf] + [(Q ^ einf ^ e3) * pseudo for Q in points]
    for i in range(1, snake.links - 1):
        for k in range(snake.n):
            velocity = (wheels[i] | axes[k]) if k <= 2 + i else 0 * e1
            sign = np.sign(float(((points[0] ^ einf ^ e3) * pseudo)[(1, 2)])) if k >= 2 else 1.0
            wedge = (sign * velocity) ^ points[i] ^ points[i + 1] ^ einf
            value = -float((wedge * pseudo.inv() * e3)[()]) / snake.lengths[i]
            assert abs(abs(value) - abs(pfaff[i - 1, k])) < 1e-12


@pytest.mark.slow
def test_point_pairs_are_outer_products(rng):
    from clifford.g3c import e1, e2, einf, eo, up

    snake = Snake(4)
    q = rng.uniform(-2, 2, snake.n)
    joints, pairs = snake.joints(q), snake.point_pairs(q)
    for i in range(snake.links):
        c = pairs[i]
        pair = c[0] * (e1 ^ e2) + c[1] * (e1 ^ eo) + c[2] * (e1 ^ einf) + c[3] * (e2 ^ eo) + c[4] * (e2 ^ einf)
        pair = pair + c[5] * (eo ^ einf)
        expected = up(joints[i, 0] * e1 + joints[i, 1] * e2) ^ up(joints[i + 1, 0] * e1 + joints[i + 1, 1] * e2)
        assert abs(pair - expected) < 1e-11


def test_joint_speeds_are_equal_for_midpoint_wheels(rng):
    snake = Snake(lengths=rng.uniform(0.5, 3.0, 8))
    q, u = rng.uniform(-2, 2, snake.n), rng.normal(size=2)
    rate = snake.control_basis(q)[:, :2] @ u
    h = 1e-6
    velocity = (plain.joints(q + h * rate, snake.lengths) - plain.joints(q - h * rate, snake.lengths)) / (2 * h)
    np.testing.assert_allclose(np.linalg.norm(velocity[1:-1], axis=1), np.linalg.norm(u), rtol=1e-8)


def test_posture_from_joints_inverts_joints(rng):
    snake = Snake(lengths=rng.uniform(0.5, 3.0, 7))
    q = rng.uniform(-3, 3, (20, snake.n))
    q[:, :2] *= 30
    np.testing.assert_allclose(snake.from_joints(snake.joints(q)), q, rtol=0, atol=1e-11)
    assert angles_kernel(7).trace.operations()


@pytest.mark.parametrize("links", [4, 6, 8])
def test_closed_chains_hold_both_ends_and_contain_the_posture_they_come_from(links, rng):
    snake = Snake(lengths=rng.uniform(1.0, 2.0, links))
    q = np.concatenate([rng.uniform(-2, 2, 3), rng.uniform(-1, 1, links - 1)])
    joints = snake.joints(q)
    free = rng.uniform(-np.pi, np.pi, (300, links - 4))
    free[0] = np.cumsum(q[2:])[1 : links - 3]
    chains = snake.closed_chain(joints[:2], joints[-2:], free)
    found = chains.q[chains.valid]
    assert len(found) >= 2
    ends = np.array([plain.joints(p, snake.lengths) for p in found])
    np.testing.assert_allclose(ends[:, :2], np.broadcast_to(joints[:2], (len(found), 2, 2)), atol=1e-11)
    np.testing.assert_allclose(ends[:, -2:], np.broadcast_to(joints[-2:], (len(found), 2, 2)), atol=1e-11)
    wrapped = np.abs(np.exp(1j * chains.q[0, :, 2:]) - np.exp(1j * q[2:])).max(axis=1)
    assert wrapped.min() < 1e-9
    assert np.isnan(chains.q[~chains.valid]).all()


def test_singular_means_that_wheel_axes_meet(rng):
    snake = Snake(7)
    circle = np.concatenate([rng.uniform(-1, 1, 4), np.full(4, 0.4), [0.9]])
    straight = np.concatenate([rng.uniform(-1, 1, 4), np.zeros(4), [0.9]])
    bent = np.concatenate([rng.uniform(-1, 1, 4), [0.4, -0.3, 0.5, 0.2], [0.9]])
    assert snake.is_singular(circle) and snake.is_singular(straight) and not snake.is_singular(bent)
    # with the joints locked a singular posture can turn: a rigid motion in the null space of the Pfaff matrix
    for q, expected in ((circle, True), (bent, False)):
        locked = np.zeros((snake.n, 3))
        locked[:3, :3] = np.eye(3)
        left = np.linalg.svd(plain.pfaff(q, snake.lengths, 0.5) @ locked, compute_uv=False)[-1]
        assert (left < 1e-12) == expected


@pytest.mark.parametrize(
    "call, text",
    [
        (lambda: Snake(2), "at least 3 links"),
        (lambda: Snake(lengths=[1.0, 2.0]), "at least 3 links"),
        (lambda: Snake(5, lengths=[1.0, 2.0, 1.0]), "expected 5 lengths"),
        (lambda: Snake(lengths=[1.0, -2.0, 1.0]), "positive link lengths"),
        (lambda: Snake(4, length=float("nan")), "finite"),
        (lambda: Snake(4.5), "whole number"),
        (lambda: Snake(5, wheel_fraction=0.0), "above 0"),
        (lambda: Snake(6).joints(np.zeros(7)), "posture of 8 numbers"),
        (lambda: Snake(6).joints([0, 0, np.nan, 0, 0, 0, 0, 0]), "finite numbers"),
        (lambda: Snake(6).model(np.array([0, 0, np.inf, 0, 0, 0, 0, 0.0])), "finite numbers"),
        (lambda: Snake(6).from_joints(np.zeros((7, 2))), "one link apart"),
        (lambda: Snake(6).closed_chain([[0, 0], [1, 0]], [[5, 0], [7, 0]], [0, 0]), "one link of 2.0 m"),
    ],
)
def test_bad_input_is_named(call, text):
    with pytest.raises(InputError, match=text):
        call()
