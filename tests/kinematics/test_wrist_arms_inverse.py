"""Inverse kinematics of the S-R-S and the six-axis arm, and the arcs of the elbow circle, against plain geometry."""

import numpy as np
import pytest
from plain_fk import chain_pose, pose_gap, six_axis, srs, turned

from horosphere.errors import InputError
from horosphere.kinematics import elbow_arcs, inverse
from horosphere.robots import humanoid_arm, six_axis_arm, srs_arm
from horosphere.versors import Motor

SRS = [(0.36, 0.42, 0.4, 0.126), (0.0, 0.316, 0.248, 0.092), (0.1, 0.3, 0.35, 0.1)]
SIX = [(0.025, 0.4, 0.455, 0.035, 0.42, 0.08), (0.0, 0.3, 0.3, 0.0, 0.3, 0.1), (0.15, 0.5, 0.6, -0.1, 0.5, 0.1)]


def elbow_from_definition(lengths, T, psi):
    """E = S + x u + rho (cos psi r + sin psi u x r)."""
    dbs, dse, dew, dwf = lengths
    S = np.array([0, 0, dbs])
    w = T[..., :3, 3] - dwf * T[..., :3, 2] - S
    D = np.linalg.norm(w, axis=-1, keepdims=True)
    u = w / D
    r = np.array([0, 0, 1.0]) - u[..., 2:] * u
    r /= np.linalg.norm(r, axis=-1, keepdims=True)
    x = (dse**2 - dew**2 + D**2) / (2 * D)
    rho = np.sqrt(np.maximum(dse**2 - x**2, 0))
    psi = np.asarray(psi)[..., None]
    return S + x * u + rho * (np.cos(psi) * r + np.sin(psi) * np.cross(u, r))


@pytest.mark.parametrize("lengths", SRS)
@pytest.mark.parametrize("seed", [0])
def test_srs_all_branches_at_the_given_elbow(lengths, seed):
    rng = np.random.default_rng(seed)
    q = rng.uniform(-np.pi, np.pi, (10_000, 7))
    T = chain_pose(*srs(*lengths), q)
    psi = rng.uniform(-np.pi, np.pi, 10_000)
    s = inverse(srs_arm(*lengths), Motor.from_matrix(T), psi=psi)
    assert s.valid.all()
    assert pose_gap(chain_pose(*srs(*lengths), s.q), T[:, None]).max() < 1e-12
    assert s.residual.max() < 1e-12
    assert ((s.q[..., [1, 3, 5]] < 0) == (s.branch == 1)).all()
    axes, points, _ = srs(*lengths)
    home = np.eye(4)
    home[:3, 3] = points[3]
    elbow = chain_pose(axes[:3], points[:3], home, s.q[..., :3])[..., :3, 3]
    assert np.abs(elbow - elbow_from_definition(lengths, T, psi)[:, None]).max() < 1e-9


@pytest.mark.parametrize("lengths", SRS)
def test_srs_with_a_seed_keeps_its_elbow_and_finds_it(lengths):
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (3000, 7))
    T = chain_pose(*srs(*lengths), q)
    s = inverse(srs_arm(*lengths), Motor.from_matrix(T), seed=q)
    gap = np.abs(turned(s.q - q[:, None])).max(-1).min(-1)
    assert gap.max() < 1e-6 and np.quantile(gap, 0.99) < 1e-10


@pytest.mark.parametrize("zero, kept", [(1, 0), (3, 2), (5, 4)])
def test_srs_keeps_a_free_angle_from_the_seed(zero, kept):
    lengths = SRS[0]
    q = np.array([0.4, 0.7, -0.3, 0.9, 0.2, -0.6, 0.5])
    q[zero] = 0.0
    T = chain_pose(*srs(*lengths), q)
    s = inverse(srs_arm(*lengths), Motor.from_matrix(T), seed=q)
    assert s.flags[f"theta{kept + 1}_free"]
    assert pose_gap(chain_pose(*srs(*lengths), s.q), T).max() < 1e-12
    assert np.abs(s.q - q).max(-1).min() < 1e-7


def test_srs_target_over_the_base_uses_x_as_reference():
    lengths = SRS[0]
    T = np.eye(4)
    T[:3, 3] = [0, 0, 0.36 + 0.7 + 0.126]
    s = inverse(srs_arm(*lengths), Motor.from_matrix(T), psi=0.0)
    assert s.flags["reference"] and s.valid.all()
    assert pose_gap(chain_pose(*srs(*lengths), s.q), T).max() < 1e-12


def test_srs_out_of_reach_says_by_how_much():
    T = np.eye(4)
    T[:3, 3] = [1.0, 0, 0.36]
    T[:3, :3] = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    s = inverse(srs_arm(*SRS[0]), Motor.from_matrix(T))
    assert not s.valid.any() and s.reason.startswith("out of reach by 0.054 m") and np.isfinite(s.q).all()


@pytest.mark.parametrize("lengths", SIX)
@pytest.mark.parametrize("seed", [0])
def test_six_axis_all_branches(lengths, seed):
    q = np.random.default_rng(seed).uniform(-np.pi, np.pi, (10_000, 6))
    T = chain_pose(*six_axis(*lengths), q)
    s = inverse(six_axis_arm(*lengths), Motor.from_matrix(T))
    assert s.solved.all()
    assert pose_gap(chain_pose(*six_axis(*lengths), s.q), T[:, None])[s.valid].max() < 1e-12
    gap = np.where(s.valid, np.abs(turned(s.q - q[:, None])).max(-1), 9).min(-1)
    assert gap.max() < 1e-6 and np.quantile(gap, 0.999) < 1e-10
    # Valid rows are different postures.
    for k in range(0, 10_000, 500):
        rows = s.q[k][s.valid[k]]
        apart = np.abs(turned(rows[:, None] - rows[None])).max(-1) + 9 * np.eye(len(rows))
        assert apart.min() > 1e-6


@pytest.mark.parametrize("zero, kept", [(4, 3)])
def test_six_axis_straight_wrist_keeps_theta4(zero, kept):
    q = np.array([0.4, 0.7, -0.3, 0.9, 0.0, -0.6])
    T = chain_pose(*six_axis(*SIX[0]), q)
    s = inverse(six_axis_arm(*SIX[0]), Motor.from_matrix(T), seed=q)
    assert s.flags["straight_wrist"].any()
    assert pose_gap(chain_pose(*six_axis(*SIX[0]), s.q), T)[s.valid].max() < 1e-12
    assert np.abs(s.q[s.valid] - q).max(-1).min() < 1e-7


def segment_distance(a, b, c):
    ab = b - a
    t = np.clip(((c - a) * ab).sum(-1) / (ab * ab).sum(-1), 0, 1)
    return np.linalg.norm(a + t[..., None] * ab - c, axis=-1)


@pytest.mark.parametrize("seed", [0])
def test_elbow_arcs_agree_with_dense_sampling(seed):
    rng = np.random.default_rng(seed)
    lengths, radius = SRS[0], 0.05
    arm = srs_arm(*lengths, radius=radius)
    psi = np.linspace(-np.pi, np.pi, 721)[1:]
    kinds = set()
    for _ in range(300):
        T = chain_pose(*srs(*lengths), rng.uniform(-2.5, 2.5, 7))
        centers = rng.uniform(-0.5, 0.5, (rng.integers(1, 5), 3)) + [0, 0, 0.5]
        radii, clearance = rng.uniform(0.03, 0.2, len(centers)), rng.uniform(0, 0.05)
        arcs = elbow_arcs(arm, Motor.from_matrix(T), (centers, radii), clearance, fixed_bodies=False)
        E = elbow_from_definition(lengths, T, psi)
        S, W = np.array([0, 0, lengths[0]]), T[:3, 3] - lengths[3] * T[:3, 2]
        gap = np.full(len(psi), np.inf)
        for c, r in zip(centers, radii):
            upper = segment_distance(np.broadcast_to(S, E.shape), E, c) - radius
            fore = segment_distance(np.broadcast_to(W, E.shape), E, c) - 0.9 * radius
            gap = np.minimum(gap, np.minimum(upper, fore) - r)
        clear = np.abs(gap - clearance) > 1e-9
        assert (arcs.contains(psi) == (gap >= clearance))[clear].all()
        inside = ((psi[:, None] >= arcs.free[:, 0]) & (psi[:, None] <= arcs.free[:, 1])).any(-1)
        assert (inside == (gap >= clearance))[clear].all()
        kinds.add("all" if arcs.width > 6.28 else "none" if not len(arcs.free) else len(arcs.joined()))
    assert {"all", "none", 1} <= kinds


def test_arc_ends_touch_the_clearance_and_nearest_is_free():
    lengths = SRS[0]
    arm = srs_arm(*lengths, radius=0.05)
    T = chain_pose(*srs(*lengths), np.array([0.3, 0.6, 0.4, 1.2, 0.3, 0.5, 0.1]))
    E = elbow_from_definition(lengths, T, 0.4)
    arcs = elbow_arcs(arm, Motor.from_matrix(T), (E[None], [0.03]), 0.01, fixed_bodies=False)
    assert len(arcs.joined()) == 1 and not arcs.contains(0.4) and arcs.contains(0.4 + np.pi)
    assert repr(arcs).startswith("Arcs(psi free from ")
    W = T[:3, 3] - lengths[3] * T[:3, 2]
    for end in arcs.joined().ravel():
        e = elbow_from_definition(lengths, T, end)
        upper = segment_distance(np.array([0, 0, lengths[0]]), e, E) - 0.05
        fore = segment_distance(W, e, E) - 0.045
        assert abs(min(upper, fore) - 0.03 - 0.01) < 1e-12
    assert arcs.contains(arcs.nearest(0.4) + 1e-9) or arcs.contains(arcs.nearest(0.4) - 1e-9)


def test_elbow_arcs_name_what_blocks_everything():
    lengths = SRS[0]
    T = chain_pose(*srs(*lengths), np.array([0.3, 0.6, 0.4, 1.2, 0.3, 0.5, 0.1]))
    arcs = elbow_arcs(srs_arm(*lengths), Motor.from_matrix(T), (T[None, :3, 3], [0.02]))
    assert arcs.free.shape == (0, 2) and "hand" in arcs.reason
    with pytest.raises(InputError, match="GripperOnPlane"):
        elbow_arcs(humanoid_arm(), Motor.from_matrix(T), [])
