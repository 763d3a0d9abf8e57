"""Inverse kinematics of the 5-DOF humanoid arm against plain matrix kinematics."""

import numpy as np
import pytest
from plain_fk import chain_pose, humanoid, pose_gap, turned

from horosphere.errors import InputError
from horosphere.kinematics import GripperOnPlane, inverse
from horosphere.robots import humanoid_arm
from horosphere.versors import Motor

GEOMETRIES = {
    "offset": (0.2, 0.12, 0.35, 0.30, 0.15),
    "on-axis": (0.1, 0.1, 0.35, 0.30, 0.15),
    "origin, equal links": (0.0, 0.0, 0.3, 0.3, 0.1),
    "below, long forearm": (0.3, -0.1, 0.25, 0.4, 0.2),
}


def targets(lengths, count, seed):
    """Postures, their tip poses, and a random plane that holds each gripper direction."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-np.pi, np.pi, (count, 5))
    T = chain_pose(*humanoid(*lengths), q)
    normal = np.cross(T[:, :3, 1], rng.normal(size=(count, 3)))
    return q, T, normal / np.linalg.norm(normal, axis=1, keepdims=True)


def angle_on_circle(pt, n, g):
    """phi of the gripper direction g, from its definition: g = cos(phi) g0 + sin(phi) n x g0."""
    radial = pt * [1, 0, 1]
    g0 = radial - (radial * n).sum(-1, keepdims=True) * n
    g0 /= np.linalg.norm(g0, axis=-1, keepdims=True)
    return np.arctan2((g * np.cross(n, g0)).sum(-1), (g * g0).sum(-1))


@pytest.mark.parametrize("seed", [0])
@pytest.mark.parametrize("name", GEOMETRIES)
def test_all_branches_of_10000_targets_meet_them_and_hold_the_posture(name, seed):
    lengths = GEOMETRIES[name]
    q, T, n = targets(lengths, 10_000, seed)
    pt, g = T[:, :3, 3], T[:, :3, 1]
    phi = angle_on_circle(pt, n, g)
    found = inverse(humanoid_arm(*lengths), GripperOnPlane(pt, n), phi=phi)
    assert found.q.shape == (10_000, 8, 5) and found.is_closed_form
    reached = chain_pose(*humanoid(*lengths), found.q)
    off = np.linalg.norm(reached[..., :3, 3] - pt[:, None], axis=-1)
    tilt = np.linalg.norm(reached[..., :3, 1] - g[:, None], axis=-1)
    assert found.solved.all()
    assert off[found.valid].max() < 1e-12 and tilt[found.valid].max() < 1e-12
    assert found.residual[found.valid].max() < 1e-12
    nearest = np.where(found.valid, np.abs(turned(found.q - q[:, None])).max(-1), np.inf).min(-1)
    assert nearest.max() < 1e-7 and np.quantile(nearest, 0.999) < 1e-10  # worst near a stretched arm
    assert (found.q > -np.pi).all() and (found.q <= np.pi).all()


@pytest.mark.parametrize("name", GEOMETRIES)
def test_branch_order_is_back_elbow_flip(name):
    lengths = GEOMETRIES[name]
    _, T, n = targets(lengths, 500, 1)
    s = inverse(humanoid_arm(*lengths), GripperOnPlane(T[:, :3, 3], n), phi=0.7)
    back, elbow, flip = s.branch.T
    assert (4 * back + 2 * elbow + flip == np.arange(8)).all()
    inner = s.valid & (np.abs(np.sin(s.q[..., 2])) > 1e-6) & (np.abs(np.sin(s.q[..., 4])) > 1e-6)
    assert ((s.q[..., 2] < 0) == (elbow == 1))[inner].all()
    assert ((s.q[..., 4] < 0) == (flip == 1))[inner].all()
    # back: the arm plane turned by pi; its front normal is e2 x p2 for the wrist p2.
    p2 = T[:, :3, 3] * 0
    posture = chain_pose(*humanoid(*lengths), s.q)
    p2 = posture[..., :3, 3] - lengths[4] * posture[..., :3, 1]
    side = np.cos(s.q[..., 0]) * p2[..., 0] - np.sin(s.q[..., 0]) * p2[..., 2]
    assert ((side < 0) == (back == 1))[s.valid].all()


def test_phi_and_targets_broadcast():
    phi = np.linspace(-3, 3, 72)
    path = GripperOnPlane(np.linspace([0.33, 0, 0.31], [0.41, 0.07, -0.32], 10)[:, None], [0, 2.0, 0])
    s = inverse(humanoid_arm(), path, phi=phi)
    assert s.q.shape == (10, 72, 8, 5) and s.valid.shape == (10, 72, 8)
    one = inverse(humanoid_arm(), GripperOnPlane(path.point[4, 0], [0, 1, 0]), phi=phi[9])
    assert one.q.shape == (8, 5) and np.allclose(one.q, s.q[4, 9], atol=1e-12)


@pytest.mark.parametrize("name", GEOMETRIES)
def test_unreachable_decision_is_that_of_plane_geometry(name):
    d0, h, d1, d2, d3 = GEOMETRIES[name]
    rng = np.random.default_rng(4)
    n, pt = np.array([0.0, 1.0, 0.0]), rng.uniform(-0.9, 0.9, (4000, 3))
    phi = rng.uniform(-np.pi, np.pi, 4000)
    s = inverse(humanoid_arm(d0, h, d1, d2, d3), GripperOnPlane(pt, n), phi=phi)
    radius = np.hypot(pt[:, 0], pt[:, 2])
    g0 = pt * [1, 0, 1] / radius[:, None]
    p2 = pt - d3 * (np.cos(phi)[:, None] * g0 + np.sin(phi)[:, None] * np.cross(n, g0))
    a = np.sqrt(d0**2 - h**2)
    for back in (0, 1):
        distance = np.hypot(np.hypot(p2[:, 0], p2[:, 2]) - (1 - 2 * back) * a, p2[:, 1] - h)
        clear = np.abs(distance - (d1 + d2)) > 1e-9
        assert (s.valid[clear, 4 * back] == ((distance <= d1 + d2) & (distance >= abs(d1 - d2)))[clear]).all()
    far = ~s.solved
    assert far.any() and all("out of reach by" in text for text in s.reason[far])
    assert np.isfinite(s.q).all()


def test_reason_states_the_metres_missing():
    s = inverse(humanoid_arm(0.1, 0.1, 0.35, 0.3, 0.15), GripperOnPlane([1.0, 0.1, 0.0], [0, 1, 0]))
    assert not s.valid.any() and s.reason.startswith("out of reach by 0.2 m")


@pytest.mark.parametrize("name", GEOMETRIES)
def test_a_reachable_pose_gives_its_posture_back(name):
    lengths = GEOMETRIES[name]
    q, T, _ = targets(lengths, 3000, 5)
    s = inverse(humanoid_arm(*lengths), Motor.from_matrix(T))
    assert s.solved.all()
    assert pose_gap(chain_pose(*humanoid(*lengths), s.q), T[:, None])[s.valid].max() < 1e-9
    assert np.where(s.valid, np.abs(turned(s.q - q[:, None])).max(-1), 9).min(-1).max() < 1e-7


def test_a_pose_that_five_joints_cannot_reach_is_a_value_with_a_reason():
    q = np.array([0.3, 0.9, 0.8, 0.4, 0.5])
    T = chain_pose(*humanoid(*GEOMETRIES["offset"]), q)
    T[:3, :3] = T[:3, :3] @ np.array([[np.cos(0.2), 0, np.sin(0.2)], [0, 1, 0], [-np.sin(0.2), 0, np.cos(0.2)]])
    s = inverse(humanoid_arm(*GEOMETRIES["offset"]), Motor.from_matrix(T))
    assert not s.valid.any() and "orientation" in s.reason


@pytest.mark.parametrize("name", GEOMETRIES)
def test_strict_reading_lays_gripper_and_hinge_in_the_plane(name):
    lengths = GEOMETRIES[name]
    _, T, n = targets(lengths, 60, 6)
    s = inverse(humanoid_arm(*lengths), GripperOnPlane(T[:, :3, 3], n), strict=True)
    M = chain_pose(*humanoid(*lengths), s.q)
    hinge, grip = M[..., :3, 2], M[..., :3, 1]  # axis of J5 is minus the z axis of the tip frame
    assert s.solved.any() and s.valid.shape[-1] % 8 == 0
    assert np.abs((hinge * n[:, None]).sum(-1))[s.valid].max() < 1e-11
    assert np.abs((grip * n[:, None]).sum(-1))[s.valid].max() < 1e-11
    assert np.abs(M[..., :3, 3] - T[:, None, :3, 3])[s.valid].max() < 1e-12
    # A dense scan of phi finds no sign change that the solver missed (branch front, elbow up, where the whole circle is real).
    phi = np.linspace(-np.pi, np.pi, 2001)
    for k in range(0, 60, 6):
        scan = inverse(humanoid_arm(*lengths), GripperOnPlane(T[k, :3, 3], n[k]), phi=phi)
        if not scan.valid[:, 0].all():
            continue
        hinge = chain_pose(*humanoid(*lengths), scan.q[:, 0])[:, :3, 2] @ n[k] * np.sin(scan.q[:, 0, 4])
        changes = int((np.sign(hinge[1:]) != np.sign(hinge[:-1])).sum())
        assert s.valid[k].reshape(-1, 8)[:, 0].sum() == changes


def test_strict_in_a_horizontal_plane_contains_phi_zero():
    s = inverse(humanoid_arm(), GripperOnPlane([0.4, 0.2, 0.1], [0, 1, 0]), strict=True)
    assert np.abs(s.free[s.valid]).min() < 1e-12


DEGENERATE = {
    # flag -> (lengths, point, normal, phi, seed)
    "on_axis": ((0.2, 0.12, 0.35, 0.3, 0.15), (0.15, 0.5, 0.0), (0, 1, 0), 0.0, (0.4, 0, 0, 0, 0)),
    "gripper_spare": ((0.2, 0.12, 0.35, 0.3, 0.15), (0.0, 0.6, 0.0), (0, 0, 1), 0.3, (0, 0, 0, 0, 0)),
    "straight_wrist": ((0.1, 0.1, 0.35, 0.3, 0.15), (0.45, 0.45, 0.0), (0, 0, 1), 0.0, (0, 0, 0, 0.7, 0)),
}


@pytest.mark.parametrize("flag", DEGENERATE)
def test_degenerate_targets_are_flagged_and_met(flag):
    lengths, pt, n, phi, seed = DEGENERATE[flag]
    if flag == "straight_wrist":  # elbow at (0, .45) from the shoulder (0, .1), forearm and gripper along x
        pt = (0.45, 0.45, 0.0)
    s = inverse(humanoid_arm(*lengths), GripperOnPlane(pt, n), phi=phi, seed=seed)
    assert s.flags[flag].any() and s.solved
    M = chain_pose(*humanoid(*lengths), s.q)
    assert np.abs(M[..., :3, 3] - np.array(pt))[s.valid].max() < 1e-13
    assert np.abs(M[..., :3, 1] @ np.array(n, float))[s.valid].max() < 1e-13
    if flag == "on_axis":
        assert np.isclose(s.q[s.valid][:, 0], 0.4, atol=1e-12).any()
    if flag == "straight_wrist":
        assert np.isclose(s.q[s.flags[flag] & s.valid][:, 3], 0.7, atol=1e-12).any()


def test_wrist_on_the_shoulder_keeps_theta2_for_equal_links_and_is_unreachable_otherwise():
    for d2, expected in ((0.3, True), (0.25, False)):
        lengths = (0.1, 0.1, 0.3, d2, 0.15)
        pt = (0.15, 0.1, 0.0)  # the wrist falls on (0, .1, 0)
        s = inverse(humanoid_arm(*lengths), GripperOnPlane(pt, (0, 1, 0)), seed=(0.2, 0.5, 0, 0, 0))
        assert s.solved == expected
        if expected:
            M = chain_pose(*humanoid(*lengths), s.q)
            assert np.abs(M[..., :3, 3] - np.array(pt))[s.valid].max() < 1e-13
            assert np.allclose(np.abs(s.q[s.valid][:, 2]), np.pi)
            assert np.allclose(np.abs(s.q[s.valid][:, 1]), 0.5)


def test_stretched_arm_merges_the_elbows():
    lengths = (0.0, 0.0, 0.35, 0.3, 0.15)
    pt = np.array([0.65 + 0.15, 0.0, 0.0])
    s = inverse(humanoid_arm(*lengths), GripperOnPlane(pt, (0, 1, 0)))
    assert s.valid[:4].all() and s.flags["stretched"][:4].all()
    assert np.abs(chain_pose(*humanoid(*lengths), s.q)[..., :3, 3] - pt)[s.valid].max() < 1e-13


def test_bad_input_names_the_place():
    arm = humanoid_arm()
    with pytest.raises(InputError, match="zero length"):
        GripperOnPlane([0, 0, 0], [0, 0, 0])
    with pytest.raises(InputError, match="point"):
        GripperOnPlane([0, np.nan, 0], [0, 0, 1])
    with pytest.raises(InputError, match="psi"):
        inverse(arm, GripperOnPlane([0.3, 0, 0], [0, 1, 0]), psi=1.0)
    with pytest.raises(InputError, match="strict"):
        inverse(arm, GripperOnPlane([0.3, 0, 0], [0, 1, 0]), phi=1.0, strict=True)
    with pytest.raises(InputError, match="seed"):
        inverse(arm, GripperOnPlane([0.3, 0, 0], [0, 1, 0]), seed=[0, 0])
    with pytest.raises(InputError, match="target"):
        inverse(arm, [1, 2, 3])


def test_within_limits_and_nearest():
    arm = humanoid_arm()
    q = np.array([0.3, 0.9, 0.8, 0.4, 0.5])
    pose = Motor.from_matrix(chain_pose(*humanoid(0.1, 0.1, 0.35, 0.3, 0.15), q))
    s = inverse(arm, pose)
    assert s.within_limits(arm).any() and np.allclose(s.nearest(q, arm), q, atol=1e-9)
