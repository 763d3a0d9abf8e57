"""docs/errata.md, section V of [Humanoid]: each printed formula fails and its correction holds, in the dense algebra."""

import numpy as np
import pytest
from plain_fk import chain_pose, humanoid, turned

from horosphere.algebra import Multivector, basis

e1, e2, e3, e4, e5, e0, ei, Ie, E, I = basis
D0, H, D1, D2, D3 = LENGTHS = (0.2, 0.12, 0.35, 0.30, 0.15)


def vec(x):
    return Multivector.vector([*x, 0.0, 0.0])


def up(x):
    return vec(x) + 0.5 * float(np.dot(x, x)) * ei + e0


def ipns(x):
    return x * I


def euclid(x):
    return np.array([x.coefficient(name) for name in ("e1", "e2", "e3")], float)


def points_of(pair):
    """Both Euclidean points of an OPNS pair, (B -/+ sqrt(B^2)) (B.e_inf)^-1."""
    v = pair | ei
    root = float(np.sqrt((pair * pair).scalar_part))
    return [euclid((pair + sign * root) * v.inverse()) for sign in (-1.0, 1.0)]


def posture(q):
    """p0, p1, p2, pt of one posture."""
    axes, points, home = humanoid(*LENGTHS)
    M = [chain_pose(axes[:k], points[:k], np.eye(4), np.asarray(q)[:k]) for k in (1, 2, 3, 5)]
    return [m[:3, :3] @ p + m[:3, 3] for m, p in zip(M, (points[1], points[2], points[3], home[:3, 3]))]


Q = np.array([0.4, 1.4, 1.9, 0.5, 0.6])
P0, P1, P2, PT = posture(Q)
N = np.cross(PT - P2, [0.3, 0.5, -0.2])
N /= np.linalg.norm(N)
L_Y = e2 * E  # OPNS line
Z_T = (up(PT) - 0.5 * D3**2 * ei) ^ (vec(N) + float(N @ PT) * ei)


def test_step_1_the_torso_axis_holds():
    assert L_Y.isclose(e0 ^ e2 ^ ei)


def test_step_1_the_pair_of_wrists():
    j_z = Z_T ^ ei
    plane = j_z ^ vec(PT * [1, 0, 1])  # pi_jld*, grade 4
    assert np.abs((plane ^ Z_T).coefficients).max() == 0.0  # as printed: grade 6 in a space of five dimensions
    pair = (ipns(plane) ^ Z_T).dual()
    for p2 in points_of(pair):
        assert np.linalg.norm(p2 - PT) == pytest.approx(D3) and (p2 - PT) @ N == pytest.approx(0, abs=1e-14)


def test_steps_2_and_3_the_shoulder_comes_first():
    # |p0 p1| is a link; with s_1 about e_0, as printed, it is not.
    pi_1 = ipns(L_Y ^ up(P2))
    s_2 = up(P2) - 0.5 * D2**2 * ei
    normal = euclid(pi_1)
    pi_1 = pi_1 * (1.0 / np.linalg.norm(normal))
    printed = points_of(((e0 - 0.5 * D1**2 * ei) ^ s_2 ^ pi_1).dual())
    assert all(abs(np.linalg.norm(p - P0) - D1) > 0.01 for p in printed)
    corrected = points_of(((up(P0) - 0.5 * D1**2 * ei) ^ s_2 ^ pi_1).dual())
    assert min(np.linalg.norm(p - P1) for p in corrected) < 1e-14


def test_step_3_the_plane_of_the_shoulder():
    x = up(np.array([0.3, H, -0.2]))
    assert (x | (e2 - H * ei)).scalar_part == pytest.approx(2 * H)  # as printed: the plane y = -h
    assert (x | (e2 + H * ei)).scalar_part == pytest.approx(0, abs=1e-15)


def test_step_4_the_gripper_line():
    l_2, printed, corrected = up(P1) ^ up(P2) ^ ei, up(P2) ^ up(P1) ^ ei, up(P2) ^ up(PT) ^ ei
    cosine = lambda a, b: float((a | b).scalar_part) / np.sqrt(float((a | a).scalar_part * (b | b).scalar_part))
    assert cosine(printed, l_2) == pytest.approx(-1.0)  # as printed, cos theta5 = -1 in every posture
    assert cosine(corrected, l_2) == pytest.approx(np.cos(Q[4]))
    l_1 = up(P0) ^ up(P1) ^ ei
    assert cosine(l_1, printed) == pytest.approx(-np.cos(Q[2]))  # step 5, cos theta3 = l1.l3
    assert cosine(l_1, l_2) == pytest.approx(np.cos(Q[2]))


def test_step_5_cosines_lose_the_signs_and_the_ratio_keeps_them():
    rng = np.random.default_rng(1)
    lost = 0
    for q in rng.uniform(-np.pi, np.pi, (60, 5)):
        p0, p1, p2, pt = posture(q)
        front = np.array([np.sin(q[0]), 0, np.cos(q[0])])  # arm plane of this posture
        l = [ipns(up(a) ^ up(b) ^ ei) for a, b in ((p0, p0 + [0, 1, 0]), (p0, p1), (p1, p2), (p2, pt))]
        hinge = [-1.0 * ipns(up(p) ^ vec(front) ^ ei) for p in (p0, p1)]

        def ratio(xb, xa, axis):
            r = xb * ~xa
            size = np.sqrt(abs(float((axis * axis).scalar_part)))
            return np.arctan2(float((r * axis).scalar_part) / size, float(r.scalar_part))

        assert turned(ratio(l[1], l[0], hinge[0]) - q[1]) == pytest.approx(0, abs=1e-12)
        assert turned(ratio(l[2], l[1], hinge[1]) - q[2]) == pytest.approx(0, abs=1e-12)
        lost += q[1] < 0 or q[2] < 0
    assert lost > 30  # arccos would have given these wrong


def test_eqs_30_31_the_rotor_about_the_gripper_circle():
    opns = Z_T ^ ei
    j_star = opns * (1.0 / np.sqrt(abs(float((opns * ~opns).scalar_part))))
    assert (j_star * j_star).scalar_part == pytest.approx(1.0)  # as printed: cosh and sinh, no rotation
    mixed = (-0.35 * j_star).exp()
    assert mixed.grades() == (0, 3)
    image = mixed * up(P2) * ~mixed
    assert 4 in image.grades()
    line = ipns(j_star)
    assert (line * line).scalar_part == pytest.approx(-1.0)
    rotor = (-0.35 * line).exp()
    moved = euclid(rotor * up(P2) * ~rotor)
    angle = 0.7
    r = P2 - PT
    assert moved == pytest.approx(PT + np.cos(angle) * r + np.sin(angle) * np.cross(N, r), abs=1e-12)
