"""Chains that have a structure with a closed form but move in fewer dimensions than it needs, as a neck or a waist often does."""

import numpy as np
import pytest
import structured_arms as arms
from plain_fk import pose_gap, turned
from structured_arms import X, Y, Z

from horosphere.kinematics import classify, forward, inverse, numerical_inverse

STIFF = "dimensions only"
NECK = (
    [X, Y, Z, X, Y],
    [(0, 0, 0), (0, 0, 0), *[(0, 0.25, 0)] * 3],
)  # the second axis goes through the point of the last three
SPINE = [X, Z, *NECK[0]], [(0, -0.2, 0), *[(0, 0, 0)] * 3, *[(0, 0.25, 0)] * 3]


def found_again(robot, q, T):
    """Rows that are said to be valid reach the pose, and the posture it was made from is one of them."""
    rows = inverse(robot, T, seed=q)
    gap = pose_gap(forward(robot, rows.q).as_matrix(), T.as_matrix()[:, None])
    assert rows.valid.any(axis=-1).all() and gap[rows.valid].max() < 1e-9
    away = np.where(rows.valid, np.abs(turned(rows.q - q[:, None])).max(axis=-1), np.inf).min(axis=-1)
    return ((away < 1e-5) | rows.flags["angle_kept"].any(axis=-1)).all()


def test_a_chain_on_a_lattice_has_a_closed_form_that_holds_or_none():
    seed = 5
    rng = np.random.default_rng(seed)
    closed, stiff = 0, 0
    for _ in range(300):
        n = int(rng.integers(5, 8))
        steps = rng.choice([0.0, 0.1, 0.25], (n, 3)) * (rng.random((n, 1)) < 0.55) * np.eye(3)[rng.integers(3, size=n)]
        axes = rng.choice([-1.0, 1.0], (n, 1)) * np.eye(3)[rng.integers(3, size=n)]
        robot = arms.robot("lattice", (axes, np.cumsum(steps, axis=0)))
        structure = classify(robot)
        stiff += STIFF in str(structure)
        if structure.is_closed_form:
            closed += 1
            q = rng.uniform(-3.0, 3.0, (20, n))
            assert found_again(robot, q, forward(robot, q)), f"seed {seed}: {structure}"
    assert closed > 15 and stiff > 30


@pytest.mark.parametrize("name, arm, freedoms", [("us5", NECK, 4), ("sew7", SPINE, 5)])
def test_a_neck_and_a_spine_are_told_and_solved_numerically(name, arm, freedoms):
    robot = arms.robot(name, arm, 1.2)
    structure = classify(robot)
    assert structure.name == "numerical" and structure.position is None
    assert f"{name} but for this" in str(structure) and f"in {freedoms} {STIFF}" in str(structure)
    q = np.random.default_rng(6).uniform(-1.2, 1.2, (10, len(arm[0])))
    T = forward(robot, q)
    rows = inverse(robot, T)
    assert rows.within_limits(robot).all() and numerical_inverse(robot, T).solved.all()
    assert pose_gap(forward(robot, rows.q).as_matrix(), T.as_matrix()[:, None]).max() < 1e-8
