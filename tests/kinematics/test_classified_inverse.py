"""The structural classifier and the closed forms it chooses, against plain matrix kinematics."""

import numpy as np
import pytest
import structured_arms as arms
from plain_fk import chain_pose, pose_gap, turned

from horosphere.errors import InputError
from horosphere.kinematics import classify, forward, inverse, limit_arcs
from horosphere.robots import load, srs_arm
from horosphere.versors import Motor

# name -> (arm, structure, reversed, redundancy)
CASES = {
    "ur5": (arms.UR5, "parallel6", False, None),
    "skew ur": (arms.SKEW_UR, "parallel6", False, None),
    "ur with axes against each other": (arms.ANTIPARALLEL_UR, "parallel6", False, None),
    "iiwa": (arms.IIWA, "srs7", False, "psi"),
    "srs with elbow offset": (arms.OFFSET_SRS, "srs7", False, "psi"),
    "srs with skew axes": (arms.SKEW_SRS, "srs7", False, "psi"),
    "xarm7": (arms.XARM7, "sew7", False, "q7"),
    "xarm7 from its tip": (arms.XARM7_REVERSED, "sew7", True, "q1"),
    "puma": (arms.PUMA, "spherical6", False, None),
    "axes 1, 2 meet": (arms.MEET_12, "spherical6", False, None),
    "axes 1, 2 parallel": (arms.PARALLEL_12, "spherical6", False, None),
    "axes 2, 3 meet": (arms.MEET_23, "spherical6", False, None),
    "spherical shoulder": (arms.SPHERICAL_SHOULDER, "spherical6", True, None),
    "nao": (arms.NAO, "us5", False, None),
    "nao from its tip": (arms.NAO_REVERSED, "us5", True, None),
}


@pytest.mark.parametrize("seed", [0])
@pytest.mark.parametrize("name", CASES)
def test_every_branch_meets_10000_poses_and_the_posture_is_among_them(name, seed):
    arm, structure, is_reversed, parameter = CASES[name]
    robot = arms.robot(name, arm)
    found = classify(robot)
    assert (found.name, found.is_reversed, found.parameter) == (structure, is_reversed, parameter), str(found)
    q = np.random.default_rng(seed).uniform(-np.pi, np.pi, (10_000, robot.n_joints))
    T = chain_pose(*arms.pose_chain(arm), q)
    s = inverse(robot, Motor.from_matrix(T), seed=q)
    assert s.is_closed_form and s.q.shape[1] == found.branches and s.solved.all()
    assert pose_gap(chain_pose(*arms.pose_chain(arm), s.q), T[:, None])[s.valid].max() < 1e-10
    nearest = np.where(s.valid, np.abs(turned(s.q - q[:, None])).max(-1), 9).min(-1)
    assert nearest.max() < 1e-4 and np.quantile(nearest, 0.99) < 1e-9  # worst: double roots, sqrt(eps)
    assert np.isfinite(s.q).all() and np.abs(s.q).max() <= np.pi
    for k in range(0, 10_000, 1000):  # valid rows are different postures
        rows = s.q[k][s.valid[k]]
        assert (np.abs(turned(rows[:, None] - rows[None])).max(-1) + 9 * np.eye(len(rows))).min() > 1e-6


@pytest.fixture(scope="module")
def panda(shared_data):
    return load(shared_data / "panda_spheres.urdf", tip="panda_link8")


@pytest.fixture(scope="module")
def nao(shared_data):
    return load(shared_data / "nao.urdf", base="torso", tip="l_wrist")


def test_panda_all_branches_at_a_given_q7(panda):
    assert classify(panda).name == "sew7" and classify(panda).near_misses == ()
    q = np.random.default_rng(0).uniform(panda.limits.lower, panda.limits.upper, (10_000, 7))
    T = forward(panda, q)
    s = inverse(panda, T, q7=q[:, 6])
    assert pose_gap(forward(panda, s.q).as_matrix(), T.as_matrix()[:, None])[s.valid].max() < 1e-10
    assert np.where(s.valid, np.abs(s.q - q[:, None]).max(-1), 9).min(-1).max() < 1e-4  # also q6 beyond pi
    # Both elbows inside the limits for a good part of the poses: a solver with one q4 loses them.
    inside = s.within_limits(panda)
    assert inside.any(-1).all()
    assert 0.1 < (inside[:, :4].any(-1) & inside[:, 4:].any(-1)).mean() < 0.3


@pytest.mark.parametrize(
    "joint, value, label",
    [(1, 0.0, "axes 1, 3 coincide"), (3, 0.0, "S on axis 5"), (3, -1e-6, "S near axis 5"), (3, -0.46699, "stretched")]
    + [(4, np.pi / 2, "wrist pair double"), (4, 0.0, "q5 = 0"), (5, 0.0, "q6 = 0"), (5, np.pi, "q6 = pi")],
)
def test_panda_degenerate_postures_are_found_again(panda, joint, value, label):
    q = np.random.default_rng(3).uniform(panda.limits.lower, panda.limits.upper, (200, 7))
    q[:, joint] = value
    T = forward(panda, q)
    s = inverse(panda, T, seed=q)
    assert s.solved.all(), label
    assert pose_gap(forward(panda, s.q).as_matrix(), T.as_matrix()[:, None])[s.valid].max() < 1e-10
    gap = np.where(s.valid, np.abs(turned(s.q - q[:, None])).max(-1), 9).min(-1)
    # Angles at a double root are good to the square root of the file's own rounding (3e-12); q1 is kept only below 2e-11.
    assert (gap < 1e-3).mean() > (0.5 if joint == 1 else 0.97), label


def test_panda_without_q7_or_seed_gets_the_roomiest_posture(panda):
    q = np.random.default_rng(5).uniform(panda.limits.lower, panda.limits.upper, (60, 7))
    T = forward(panda, q)
    s = inverse(panda, T)
    inside = s.within_limits(panda)
    assert inside.any(-1).all()
    assert pose_gap(forward(panda, s.q).as_matrix(), T.as_matrix()[:, None])[s.valid].max() < 1e-10
    assert np.array_equal(s.free[s.valid], s.q[s.valid][:, 6])
    # No sampled q7 does much better, and none at all keeps the start's margin from being beaten or matched.
    room = np.minimum(s.q - panda.limits.lower, panda.limits.upper - s.q).min(-1)
    best = np.where(s.valid, room, -9).max(-1)
    dense = inverse(panda, Motor.from_matrix(T.as_matrix()[:, None]), q7=np.linspace(-2.8, 2.8, 400))
    other = np.minimum(dense.q - panda.limits.lower, panda.limits.upper - dense.q).min(-1)
    other = np.where(dense.valid, other, -9).max((-1, -2))
    assert (best >= other - 0.05).mean() > 0.95


def test_nao_poses_have_four_branches_and_one_inside_the_limits(nao):
    q = np.random.default_rng(0).uniform(nao.limits.lower, nao.limits.upper, (5000, 5))
    T = forward(nao, q)
    s = inverse(nao, T)
    assert s.valid.all() and s.q.shape[1:] == (4, 5)
    assert pose_gap(forward(nao, s.q).as_matrix(), T.as_matrix()[:, None]).max() < 1e-10
    assert (s.within_limits(nao).sum(-1) == 1).all()
    off = T.as_matrix()
    off[:, :3, 3] += [0.01, 0.02, 0.03]
    missed = inverse(nao, Motor.from_matrix(off))
    assert missed.valid.sum() < 20 and "5-dimensional" in missed.reason[~missed.solved][0]


def test_the_nao_hand_joint_is_no_arm_joint_and_is_said_so(shared_data):
    found = classify(load(shared_data / "nao.urdf", base="torso", tip="l_gripper"))
    assert not found.is_closed_form and "miss by" in str(found)
    assert "with the tip l_wrist, it would be us5" in str(found)


def test_near_miss_is_reported_in_millimetres_and_solved_exactly_from_the_other_end():
    robot = arms.robot("iiwa of a public URDF", arms.IIWA_RTB)
    found = classify(robot)
    assert {(i, j) for i, j, _ in found.near_misses} >= {(1, 2), (3, 4)}
    assert all(abs(gap - 0.00043624) < 1e-12 for *_, gap in found.near_misses)
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (300, 7))
    T = chain_pose(*arms.pose_chain(arms.IIWA_RTB), q)
    s = inverse(robot, Motor.from_matrix(T), seed=q)
    assert s.solved.mean() > 0.95
    assert pose_gap(chain_pose(*arms.pose_chain(arms.IIWA_RTB), s.q), T[:, None])[s.valid].max() < 1e-9


def test_rounded_urdf_angles_are_polished_to_the_true_axes():
    axes, points = arms.UR5
    axes = [np.array(a) + (1e-9 * np.array([1, 0, -1]) if k in (2, 3) else 0) for k, a in enumerate(axes)]
    robot = arms.robot("rounded ur5", (axes, points))
    assert classify(robot).name == "parallel6" and classify(robot).gap > 1e-10
    q = np.random.default_rng(2).uniform(-np.pi, np.pi, (1000, 6))
    T = chain_pose(*arms.pose_chain((axes, points)), q)
    s = inverse(robot, Motor.from_matrix(T))
    assert s.solved.mean() > 0.99
    assert pose_gap(chain_pose(*arms.pose_chain((axes, points)), s.q), T[:, None])[s.valid].max() < 1e-10


def test_coincidences_of_axes_that_are_not_neighbours_are_not_used():
    robot = arms.robot("no structure", arms.NOTHING)
    found = classify(robot)
    assert not found.is_closed_form and found.branches == 1 and "miss by" in str(found)


def test_reasons_and_bad_input(panda):
    far = np.eye(4)
    far[:3, 3] = [2.0, 0, 0]
    s = inverse(panda, Motor.from_matrix(far), q7=0.0)
    assert not s.valid.any() and s.reason.startswith("out of reach by 1.")
    with pytest.raises(InputError, match="psi"):
        inverse(panda, Motor.from_matrix(far), psi=0.1)
    with pytest.raises(InputError, match="4, 4"):
        inverse(arms.robot("ur5", arms.UR5), np.zeros((4, 4)) * np.nan)
    with pytest.raises(InputError, match="redundancy"):
        limit_arcs(arms.robot("ur5", arms.UR5), Motor.from_matrix(far))


LIMITED = np.radians([170, 110, 170, 110, 170, 110, 175])


@pytest.mark.parametrize("name", ["iiwa", "offset", "skew", "built-in"])
def test_psi_intervals_inside_the_limits_are_exact(name):
    chosen = {"iiwa": arms.IIWA, "offset": arms.OFFSET_SRS, "skew": arms.SKEW_SRS}
    robot = srs_arm(0.36, 0.42, 0.4, 0.126) if name == "built-in" else arms.robot(name, chosen[name], LIMITED)
    rng = np.random.default_rng(7)
    total = 0
    for _ in range(25):
        T = forward(robot, rng.uniform(robot.limits.lower, robot.limits.upper))
        arcs = limit_arcs(robot, T)
        psi = rng.uniform(-np.pi, np.pi, 300)
        inside = inverse(robot, T, psi=psi).within_limits(robot)
        for k, arc in enumerate(arcs):
            clear = np.ones(300, bool)
            for end in arc.free.ravel():
                clear &= np.abs(turned(psi - end)) > 1e-7
            assert (arc.contains(psi) == inside[:, k])[clear].all()
            total += len(arc.joined())
    assert total > 50


def test_q7_intervals_inside_the_limits(panda):
    rng = np.random.default_rng(8)
    for _ in range(5):
        q = rng.uniform(panda.limits.lower, panda.limits.upper)
        T = forward(panda, q)
        arcs = limit_arcs(panda, T)
        assert any(arc.contains(q[6], -1e-9).any() for arc in arcs)
        q7 = rng.uniform(-2.9, 2.9, 200)
        inside = inverse(panda, T, q7=q7).within_limits(panda)
        wrong = sum(int((arc.contains(q7) != inside[:, k]).sum()) for k, arc in enumerate(arcs))
        assert wrong <= 2  # arcs narrower than a 512th of the range may be missed, as documented


def test_residual_and_names():
    robot = arms.robot("ur5", arms.UR5)
    q = np.array([0.3, -1.0, 0.8, 0.2, 0.9, -0.4])
    s = inverse(robot, forward(robot, q))
    assert s.residual.shape == (8,) and s.residual[s.valid].max() < 1e-12 and s.reason == ""
    assert s.name(5) == "shoulder=1 wrist=0 elbow=1"
    assert np.abs(s.nearest(q) - q).max() < 1e-9
