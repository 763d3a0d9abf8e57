"""Without a seed every branch gets the redundancy that keeps its joints farthest from their limits: against dense scans."""

from dataclasses import replace

import numpy as np
import pytest
import structured_arms as arms
from plain_fk import pose_gap, turned

from horosphere.kinematics import classify, forward, inverse, roomiest
from horosphere.robots import load, save, srs_arm

LIMITED = np.radians([170, 110, 170, 110, 170, 110, 175])
XARM7 = np.array(
    [[-6.28, -2.059, -6.28, -0.19198, -6.28, -1.69297, -6.28], [6.28, 2.0944, 6.28, 3.927, 6.28, np.pi, 6.28]]
)
XARM7_LINKS = [  # origins (xyz, rpy) as the maker's URDF has them; angles of pi/2 are written to few digits
    ((0, 0, 0.267), (0, 0, 0)), ((0, 0, 0), (-1.5708, 0, 0)), ((0, -0.293, 0), (1.5708, 0, 0)), ((0.0525, 0, 0), (1.5708, 0, 0)),
    ((0.0775, -0.3425, 0), (1.5708, 0, 0)), ((0, 0, 0), (1.5708, 0, 0)), ((0.076, 0.097, 0), (-1.5708, 0, 0)),
]  # fmt: skip


def xarm7(folder):
    """The maker's axes, rounded angles and limits through a URDF: 1e-6 m off the structure."""
    parts = ['<robot name="xarm7"><link name="l0"/>']
    for k, (xyz, rpy) in enumerate(XARM7_LINKS):
        parts.append(
            f'<link name="l{k + 1}"/><joint name="j{k + 1}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/>'
            f'<origin xyz="{xyz[0]} {xyz[1]} {xyz[2]}" rpy="{rpy[0]} {rpy[1]} {rpy[2]}"/><axis xyz="0 0 1"/>'
            f'<limit lower="{XARM7[0, k]}" upper="{XARM7[1, k]}" velocity="1" effort="1"/></joint>'
        )
    path = folder / "xarm7.urdf"
    path.write_text("".join(parts) + "</robot>")
    return load(path)


def shifted_panda(folder):
    """A Panda whose third axis stands 0.5 mm off."""
    axes, points = arms.PANDA
    points = [*points[:2], (0, 0.0005, 0.333), *points[3:]]
    return replace(arms.robot("shifted", (axes, points)), limits=load("panda").limits)


PERSON = np.radians([[-180, -60, -90, 0, -20, -90, -45], [180, 180, 180, 150, 180, 90, 45]])


def person(folder):
    """An arm of a person: ranges that end at half a turn on one side only, where the number of an angle jumps by a turn."""
    axes = [(0, 0, 1), (1, 0, 0), (0, -1, 0), (0, 0, 1), (0, -1, 0), (0, 0, 1), (1, 0, 0)]
    points = 3 * [(0, 0, 0)] + 2 * [(0, -0.276, 0)] + 2 * [(0, -0.563, 0)]
    arm = arms.robot("person", (axes, points))
    return replace(arm, limits=replace(arm.limits, lower=PERSON[0], upper=PERSON[1]))


def read_again(folder, name, arm, limit):
    save(arms.robot(name, arm, limit), folder / f"{name}.urdf")
    return load(folder / f"{name}.urdf")


CASES = {
    "panda": lambda folder: load("panda"),
    "xarm7": xarm7,
    "iiwa14": lambda folder: load("iiwa14"),
    "srs-arm": lambda folder: load("srs-arm"),
    "shifted panda": shifted_panda,
    "a person's": person,
    "iiwa, 0.4 mm off": lambda folder: read_again(folder, "iiwa", arms.IIWA_RTB, LIMITED),
    "xarm7 from its tip": lambda folder: read_again(folder, "reversed", arms.XARM7_REVERSED, 2.3),
    "srs, elbow offset": lambda folder: read_again(folder, "offset", arms.OFFSET_SRS, LIMITED),
    "srs from its tip": lambda folder: read_again(folder, "offset", [x[::-1] for x in arms.OFFSET_SRS], LIMITED),
}


def rooms(robot, found):
    """(..., 8) the least distance of a joint to its limits; -9 where the row is not valid."""
    room = np.minimum(found.q - robot.limits.lower, robot.limits.upper - found.q).min(axis=-1)
    return np.where(found.valid, room, -9.0)


def scan(robot, structure, pose, values):
    """(8,) the best room of each branch over the values; where Newton's steps took a row to another branch it is not counted."""
    rows = inverse(robot, pose, **{structure.parameter: values})
    room = rooms(robot, rows)
    if structure.gap > 1e-11:
        same = np.abs(turned(rows.q[:, :, None] - rows.q[:, None])).max(axis=-1) < 1e-6
        room[(same & ~np.eye(8, dtype=bool)).any(axis=-1)] = -9.0
    return room.max(axis=0)


@pytest.mark.parametrize("poses, scanned", [(500, 25), pytest.param(2000, 1000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", CASES)
def test_every_branch_that_has_a_value_inside_the_limits_gets_the_best(name, poses, scanned, tmp_path):
    robot, seed = CASES[name](tmp_path), 40
    structure = classify(robot)
    lower, upper = np.maximum(robot.limits.lower, -np.pi), np.minimum(robot.limits.upper, np.pi)
    q = np.random.default_rng(seed).uniform(lower, upper, (poses, 7))
    T = forward(robot, q)
    found = inverse(robot, T)
    assert found.q.shape == (poses, 8, 7) and found.free.shape == (poses, 8)
    inside = found.within_limits(robot)
    assert inside.any(axis=-1).all(), f"seed {seed}, poses {np.flatnonzero(~inside.any(axis=-1))}"
    assert pose_gap(forward(robot, found.q).as_matrix(), T.as_matrix()[:, None])[found.valid].max() < 1e-10
    near = structure.gap > 1e-8
    low, high = (
        (-np.pi, np.pi) if structure.parameter == "psi" else (lower[j := int(structure.parameter[1]) - 1], upper[j])
    )
    room, values = rooms(robot, found), np.linspace(low, high, 2000)
    lost, short, branches = 0, [], 0
    for k in range(scanned):
        best = scan(robot, structure, T[k], values)
        lost += ((best > 1e-3) & (room[k] < 0.0)).sum()
        short.append((best - room[k])[best > 0.0])
        branches += (best > 1e-3).sum()
    short = np.concatenate(short)
    assert branches > 1.5 * scanned
    assert lost <= branches // (300 if near else 1500), (
        f"seed {seed}: {lost} of {branches} branches have values inside the limits and got none"
    )
    assert (short > (5e-3 if near else 1.5e-3)).mean() < (0.02 if near else 0.005), (
        f"seed {seed}: {np.sort(short)[-20:]}"
    )


def test_an_interval_that_ends_at_half_a_turn_is_found(tmp_path):
    """Poses whose only rows inside the limits lie between two samples, at one of which an angle is a turn further."""
    robot = person(tmp_path)
    q = [
        [1.069, 3.003, 1.267, 1.954, 3.105, -1.433, 0.648],
        [2.3, -0.178, -0.61, 0.249, 3.035, -1.568, 0.478],
        [-0.311, 1.363, 1.031, 2.104, 2.895, -1.534, 0.235],
        [0.692, 1.158, 0.604, 0.625, 3.111, -1.51, 0.747],
        [-2.221, 1.112, 1.718, 2.486, 2.655, -1.56, 0.52],
    ]
    assert inverse(robot, forward(robot, q)).within_limits(robot).any(axis=-1).all()


@pytest.mark.parametrize("name", ["panda", "iiwa14", "shifted panda"])
def test_one_pose_is_a_batch_of_one_and_the_value_gives_the_row_again(name, tmp_path):
    robot = CASES[name](tmp_path)
    q = np.random.default_rng(41).uniform(robot.limits.lower, robot.limits.upper, (20, 7))
    T = forward(robot, q)
    many = inverse(robot, T)
    for k in range(20):
        one = inverse(robot, T[k])
        assert np.array_equal(one.q, many.q[k]) and np.array_equal(one.valid, many.valid[k])
        assert one.free.shape == (8,) and one.reason == many.reason[k]
        again = inverse(robot, T[k], **{classify(robot).parameter: one.free})
        rows = again.q[np.arange(8), np.arange(8)]
        close = np.abs(turned(rows - one.q)).max(axis=-1) < 1e-7
        assert close[one.within_limits(robot)].all()


@pytest.mark.parametrize("name", ["panda", "iiwa14", "xarm7 from its tip"])
def test_it_is_the_roomiest_without_obstacles(name, tmp_path):
    robot = CASES[name](tmp_path)
    q = np.random.default_rng(42).uniform(robot.limits.lower, robot.limits.upper, (6, 7))
    for pose in (forward(robot, x) for x in q):
        ours, choice = rooms(robot, inverse(robot, pose)), rooms(robot, roomiest(robot, pose))
        assert (ours >= choice - 2e-3)[choice > 0.0].all()
        assert (choice > 0.0).any()


def test_without_limits_psi_is_zero_and_out_of_reach_is_a_value():
    infinite = np.full(7, np.inf)
    arm = srs_arm(0.36, 0.42, 0.4, 0.126)
    free = replace(arm, limits=replace(arm.limits, lower=-infinite, upper=infinite))
    pose = forward(free, [0.3, 0.4, 0.5, -1.0, 0.6, 0.7, 0.8])
    for robot in (free, arms.robot("offset", arms.OFFSET_SRS, np.inf)):
        found = inverse(robot, forward(robot, [0.3, 0.4, 0.5, -1.0, 0.6, 0.7, 0.8]))
        assert (found.free == 0.0).all() and found.valid.all()
    for robot in (arm, load("panda"), load("iiwa14")):
        far = pose.as_matrix().copy()
        far[:3, 3] = [3.0, 0.0, 0.4]
        found = inverse(robot, type(pose).from_matrix(far))
        assert not found.valid.any() and np.isfinite(found.q).all() and found.reason.startswith("out of reach by ")
