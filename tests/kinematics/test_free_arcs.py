"""Arcs of the redundancy that are proved between samples, against dense sampling with the distance layer."""

import re
from dataclasses import replace

import numpy as np
import pytest
import structured_arms as arms
from arc_cases import CASES, every_kind, target_of, witnessed

from horosphere.distance import signed
from horosphere.errors import InputError
from horosphere.kinematics import Arcs, elbow_arcs, forward, frames, free_arcs, inverse, limit_arcs, roomiest
from horosphere.kinematics._redundant import redundancy
from horosphere.robots import Capsules, attach, humanoid_arm, load, srs_arm
from horosphere.shapes import Ball, Box, HalfSpace, PointCloud
from horosphere.versors import Motor

DENSE = np.linspace(-np.pi, np.pi, 1201)[1:-1]


@pytest.mark.parametrize(
    ("count", "step"), [(4, 2e-3), pytest.param(40, 1e-4, marks=(pytest.mark.slow, pytest.mark.timeout(1800)))]
)
@pytest.mark.parametrize("name", CASES)
def test_nothing_touches_in_a_free_arc_and_little_is_left_out(name, count, step):
    robot, parameter = CASES[name]()
    rng = np.random.default_rng(7 * list(CASES).index(name) + count)
    values = np.arange(-np.pi + 1e-9, np.pi, step)
    free = found = 0
    for _ in range(count):
        q = rng.uniform(robot.limits.lower, robot.limits.upper)
        target = target_of(robot, q, rng)
        obstacles = [
            o for o in every_kind(rng) if signed(robot, q, [o], static=False) > 0.01
        ]  # so that something is free
        own = 0.0 if len(robot.self_pairs) else None
        arcs = free_arcs(robot, target, obstacles, 0.01, self_clearance=own)
        false, more, seen = witnessed(robot, parameter, target, obstacles, arcs, values, 0.01, own, 1e-3)
        assert false == 0, f"{name}: {false} samples are said to be free and are not"
        free, found = free + more, found + seen
    print(f"{name}: {free - found} of {free} samples that are free by 1e-3 are left out")
    assert free > 500 and found >= 0.999 * free - 3


def test_bodies_in_the_hand_and_allowed_contacts_count_as_in_a_certificate():
    robot = load("panda")
    values = np.arange(-np.pi + 1e-9, np.pi, 5e-3)
    target = forward(robot, [0.3, 0.4, 0.2, -1.9, 0.1, 2.2, 0.5])
    point = target.as_matrix()[:3, 3]
    shelf = Box(point + [0.25, 0.0, 0.2], [0.1, 0.3, 0.02], name="shelf")
    bare = free_arcs(robot, target, [shelf], 0.01)
    holding = attach(robot, [Box([0.0, 0.0, 0.05], [0.03, 0.03, 0.05])], allowed=robot.link_names[-1:])
    for one, own in ((robot, None), (robot, 0.0), (holding, None), (holding, 0.0)):
        arcs = free_arcs(one, target, [shelf], 0.01, self_clearance=own)
        false, free, found = witnessed(one, "q7", target, [shelf], arcs, values, 0.01, own, 1e-3)
        assert false == 0 and found >= free - 3 and free > 0
        assert sum(a.width for a in arcs) <= sum(a.width for a in bare) + 1e-9
    # what is in the hand stands still with the pose: it decides all or nothing, and says so
    wall = Box(point + [0.0, 0.0, -0.1], [0.2, 0.2, 0.05], name="wall")
    touching = free_arcs(holding, target, [wall], 0.01)
    assert not any(len(a.free) for a in touching) and "attached" in touching[0].reason and "wall" in touching[0].reason
    allowed = replace(holding, allowed_obstacles=tuple((link, "wall") for link in holding.link_names))
    assert [a.width for a in free_arcs(allowed, target, [wall])] == [a.width for a in free_arcs(holding, target)]


def test_the_elbow_circle_among_half_spaces_and_clouds_in_closed_form():
    robot, rng = srs_arm(0.3), np.random.default_rng(11)
    psi = np.linspace(-np.pi, np.pi, 2001)[1:-1]
    partly = 0
    for _ in range(60):
        target = forward(robot, rng.uniform(-2.0, 2.0, 7))
        shapes = [HalfSpace(rng.normal(size=3), -rng.uniform(0.0, 0.4)) for _ in range(rng.integers(1, 3))]
        shapes.append(PointCloud(rng.uniform(-0.6, 0.6, (rng.integers(1, 80), 3)), 0.01))
        clearance = rng.uniform(0.0, 0.03)
        arcs = elbow_arcs(robot, target, shapes, clearance, fixed_bodies=False)
        q = inverse(robot, target, psi=psi).q[:, 0]
        arm = only(robot, (robot.capsules.link > 0) & (robot.capsules.link < 7))
        gap = signed(arm, q, shapes) - clearance
        clear = np.abs(gap) > 1e-9
        assert (arcs.contains(psi) == (gap > 0.0))[clear].all()
        partly += 0.0 < arcs.width < 6.28
        hand = only(robot, robot.capsules.link == 7)
        whole = elbow_arcs(robot, target, shapes[:-1], clearance)  # the column stands on what it stands on
        if signed(hand, q[0], shapes[:-1]) < clearance:
            assert not len(whole.free) and "hand" in whole.reason
        else:
            assert whole.width == elbow_arcs(robot, target, shapes[:-1], clearance, fixed_bodies=False).width
    assert partly > 10


def only(robot, which):
    c = robot.capsules
    return replace(robot, capsules=Capsules(c.link[which], c.a[which], c.b[which], c.radius[which]))


def test_the_elbow_circle_says_which_obstacles_have_no_closed_form_and_knows_allowed_contacts():
    robot = srs_arm(0.3)
    target = forward(robot, [0.3, 0.6, 0.4, 1.2, 0.3, 0.5, 0.1])
    elbow = frames(robot, [0.3, 0.6, 0.4, 1.2, 0.3, 0.5, 0.1]).as_matrix()[4, :3, 3]
    with pytest.raises(InputError, match=r"no closed form for a Box.*free_arcs"):
        elbow_arcs(robot, target, [Box(elbow, [0.1, 0.1, 0.1])])
    ball = Ball(elbow, 0.05, name="handle")
    touching = elbow_arcs(robot, target, [ball])
    assert 0.0 < touching.width < 6.28
    allowed = replace(robot, allowed_obstacles=(("upper_arm", "handle"), ("forearm", "handle")))
    assert elbow_arcs(allowed, target, [ball]).width == pytest.approx(2.0 * np.pi)
    holding = attach(robot, [Ball([0.0, 0.0, 0.1], 0.05)])
    point = target.as_matrix()[:3, :3] @ [0.0, 0.0, 0.1] + target.as_matrix()[:3, 3]
    told = elbow_arcs(holding, target, [Ball(point, 0.02)])
    assert not len(told.free) and "psi" in told.reason
    on_the_arm = attach(robot, [Ball([0.0, 0.0, 0.0], 0.05)], link="forearm", name="camera")
    with pytest.raises(InputError, match="not the whole segment"):
        elbow_arcs(on_the_arm, target, [ball])


def test_without_obstacles_the_psi_of_an_s_r_s_arm_agree_with_the_closed_form():
    robot = arms.robot("iiwa", arms.IIWA, np.radians([170, 110, 170, 110, 170, 110, 175]))
    target = forward(robot, np.random.default_rng(4).uniform(robot.limits.lower, robot.limits.upper))
    for exact, proved in zip(limit_arcs(robot, target), free_arcs(robot, target)):
        assert abs(exact.width - proved.width) < 0.01
        assert exact.contains(proved.free.mean(axis=1)).all()


@pytest.mark.parametrize("arm", ["IIWA_RTB", "OFFSET_SRS"])
def test_arms_that_miss_their_structure_are_proved_on_their_true_axes(arm):
    robot, rng = arms.robot(arm, getattr(arms, arm), 2.8), np.random.default_rng(8)
    target = forward(robot, rng.uniform(-2.0, 2.0, 7))
    values = np.arange(-np.pi + 1e-9, np.pi, 5e-3)
    false, free, found = witnessed(robot, "psi", target, [], free_arcs(robot, target), values, 0.0, margin=1e-3)
    assert false == 0 and found > 0.99 * free > 500


class Task:
    """What stays fixed along a branch, about a random posture q of an arm, by `task_at`."""

    def __init__(self, name, seed):
        from horosphere.distance import pack_robot
        from horosphere.kernels import jit
        from horosphere.kinematics._tube_kernels import place, rest, task_at

        @jit
        def task(J, C, L, K, path, tool, normal, span, q, d, M, E, D, W, T, X):
            place(J, C, L[:0], K, q, T, X)
            return task_at(T, C, path, tool, normal, span, d, M, E, D, W)

        @jit
        def bound(d, half, r, levers, span):
            return rest(d, half, r, levers, span)

        robot, self.rng = CASES[name]()[0], np.random.default_rng(seed)
        self.q, self.n, self.body = self.rng.uniform(*limits_of(robot)), robot.n_joints, pack_robot(robot, static=False)
        self.one, self.task = redundancy(robot, target_of(robot, self.q, self.rng)), task
        self.columns = self.body.joints[self.one.path, 2]
        self.rest = lambda d, half, r: bound(d, half, r, self.one.levers, self.one.span)
        self.R0 = self.at(self.q, self.along())[-1]

    def along(self):
        """A random direction, in the order of the joints of the path."""
        d = self.rng.normal(size=self.n)
        return d / np.linalg.norm(d)

    def moved(self, step):
        """q after a step in the order of the path."""
        found = self.q.copy()
        found[self.columns] += step
        return found

    def at(self, q, d):
        """Df, D2f(d, .), D3f(d, d, .), the bound of D2f, and the tool's rotation."""
        n, one = self.n, self.one
        M, E, D, W = np.zeros((n, n)), np.zeros((n - 1, n)), np.zeros((n - 1, n)), np.zeros((n, 15))
        T, X = np.empty((len(self.body.joints), 12)), np.empty((0, 7))
        size = self.task(*self.body[:4], one.path, one.tool, one.normal, one.span, q, d, M, E, D, W, T, X)
        return M[: n - 1], E, D, size, T[one.path[-1], :9].reshape(3, 3)

    def slope(self, step):
        """Df after a step, of the f that counts rotations from those at q."""
        M, *_, R = self.at(self.moved(step), np.eye(self.n)[0])
        if self.one.normal.any():
            return M
        Q = R @ self.R0.T
        return np.concatenate([0.5 * (np.trace(Q) * np.eye(3) - Q) @ M[:3], M[3:]])


def test_states_are_numbered_as_in_compiled_code():
    from horosphere.kinematics import _arc_kernels, _free_arcs, _tube_kernels

    for kernels, names in ((_tube_kernels, ("INSIDE", "OUTSIDE")), (_arc_kernels, ("FREE", "BLOCKED"))):
        assert all(getattr(kernels, name) == getattr(_free_arcs, f"_{name}") for name in names)


def limits_of(robot):
    return robot.limits.lower, robot.limits.upper


@pytest.mark.parametrize("name", ["panda", "humanoid"])
def test_a_tube_knows_the_derivatives_of_its_task(name):
    """Against differences, in plain matrices."""
    task, h = Task(name, 5), 1e-3
    d = task.along()
    _, E, D, size, _ = task.at(task.q, d)
    slope = task.slope
    assert np.allclose((slope(h * d) - slope(-h * d)) / (2.0 * h), E, atol=1e-5)
    assert np.allclose((slope(h * d) - 2.0 * slope(0.0 * d) + slope(-h * d)) / h**2, D, atol=1e-5)
    whole = np.sqrt(sum((((slope(h * e) - slope(-h * e)) / (2.0 * h)) ** 2).sum() for e in np.eye(task.n)))
    assert whole <= size + 1e-5 and (size < 1.001 * whole or task.one.normal.any())


@pytest.mark.parametrize("name", CASES)
def test_what_a_tube_does_not_compute_is_within_its_bound(name):
    """Df(q + s d + y) without its parts of first and second order that are computed, in tubes of all lengths and widths."""
    largest = 0.0
    for seed in range(6):
        task = Task(name, seed)
        M0 = task.slope(np.zeros(task.n))
        for _ in range(60):
            d, half, r = task.along(), 10.0 ** task.rng.uniform(-2, 0), 10.0 ** task.rng.uniform(-3, 0)
            s, y = half * task.rng.uniform(-1, 1), task.along()
            y -= (y @ d) * d
            size = r * task.rng.uniform() / np.linalg.norm(y)
            _, E, D, *_ = task.at(task.q, d)
            computed = M0 + s * E + size * task.at(task.q, y)[1] + 0.5 * s * s * D
            left = np.linalg.norm(task.slope(s * d + size * y) - computed)
            assert left <= task.rest(d, half, r) + 1e-12, seed
            largest = max(largest, left / task.rest(d, half, r))
    assert largest > 0.02  # a bound, but no idle one


def test_every_q7_at_which_a_branch_exists_is_found():
    robot = load("panda")
    rng = np.random.default_rng(6)
    for _ in range(20):
        target = forward(robot, rng.uniform(robot.limits.lower, robot.limits.upper))
        one = redundancy(robot, target)
        cell = np.searchsorted(one.ends, DENSE)
        _, exists = one.rows(DENSE)
        _, middle = one.rows(0.5 * (one.ends[1:] + one.ends[:-1]))
        assert (exists == middle[cell - 1]).all()


@pytest.mark.parametrize("name", ["panda", "iiwa"])
def test_the_roomiest_value_beats_dense_sampling(name):
    robot, parameter = CASES[name]()
    rng = np.random.default_rng(9)
    values, some = np.arange(-np.pi + 1e-9, np.pi, 5e-3), 0
    for _ in range(4):
        q = rng.uniform(robot.limits.lower, robot.limits.upper)
        target = forward(robot, q)
        obstacles = [o for o in every_kind(rng) if signed(robot, q, [o], static=False) > 0.01]
        best = roomiest(robot, target, obstacles, 0.01, self_clearance=0.0)
        assert best.q.shape == (8, 7) and best.residual[best.valid].max() < 1e-10
        rows, rooms = inverse(robot, target, **{parameter: values}), np.full(8, -np.inf)
        for k in np.flatnonzero(best.valid):
            both = np.concatenate([best.q[k : k + 1], rows.q[rows.valid[:, k], k]])
            gaps = signed(robot, both, obstacles, static=False) - 0.01
            gaps = np.minimum(gaps, signed(robot, both, (), self_collision=True))
            margin = np.minimum(both - robot.limits.lower, robot.limits.upper - both).min(axis=-1)
            room = np.minimum(margin, gaps / 0.1)
            rooms[k] = room[0]
            assert room[0] > room[1:].max() - 0.02
            assert best.flags["free"][k] == (room[0] > 0.0)
        assert best.flags["best"].sum() == 1 and best.reason == ""
        assert rooms[best.flags["best"]] == pytest.approx(rooms.max(), abs=1e-9)
        some += best.flags["free"].sum()
    assert some > 4


def test_a_target_without_a_free_value_is_a_value_with_a_reason():
    robot = load("panda")
    target = forward(robot, [0.3, 0.4, 0.2, -1.9, 0.1, 2.2, 0.5])
    blocked = roomiest(robot, target, [Ball(target.as_matrix()[:3, 3], 0.05)], 0.02)
    assert blocked.valid.any() and not blocked.flags["free"].any() and not blocked.flags["best"].any()
    assert "no branch is free" in blocked.reason and "from the obstacles" in blocked.reason
    far = target.as_matrix()
    far[:3, 3] *= 5.0
    missed = roomiest(robot, Motor.from_matrix(far))
    assert not missed.valid.any() and "out of reach" in missed.reason


def test_arcs_are_read_at_a_glance():
    robot = load("panda")
    target = forward(robot, [0.3, 0.4, 0.2, -1.9, 0.1, 2.2, 0.5])
    arcs = free_arcs(robot, target, [Ball([0.0, 0.0, 3.0], 0.1)], 0.01, self_clearance=0.0)
    for arc in arcs:
        said = repr(arc)
        if len(arc.free):
            ends = [float(x) for x in re.findall(r"-?\d+\.\d{3}", said)]
            assert said.startswith("Arcs(q7 free from ") and said.endswith(" rad)")
            assert np.allclose(ends, arc.joined().ravel(), atol=6e-4)
        else:
            wishes = "inside the joint limits, 0.01 m from the obstacles and with its links clear of each other"
            assert said == f"Arcs(none: no value keeps this branch {wishes})"
    assert len({len(arc.free) > 0 for arc in arcs}) == 2, "both kinds are seen"
    assert repr(limit_arcs(robot, target)[0]).startswith("Arcs(q7 free") or not len(limit_arcs(robot, target)[0].free)
    assert repr(Arcs(np.array([[-np.pi, np.pi]]))) == "Arcs(angle free everywhere)"
    assert (
        repr(Arcs(np.array([[-np.pi, -3.0], [1.0, np.pi]]), parameter="psi"))
        == "Arcs(psi free from 1.000 to 3.283 rad)"
    )


def test_a_narrow_gap_between_two_walls_is_found():
    """Two balls leave less of the circle free than lies between the nodes of the search."""
    robot = load("iiwa14")
    target = forward(robot, [0.3, 0.7, 0.2, -1.4, 0.1, 1.1, 0.5])
    elbow = lambda at: frames(robot, inverse(robot, target, psi=at).q[0]).as_matrix()[robot.chain[4], :3, 3]
    for radius, narrow in ((0.055, 0.06), (0.06, 0.011), (0.061, 0.003), (0.063, 0.0)):
        walls = [Ball(elbow(x), radius) for x in (-0.1, 0.1, 1.0, 2.0, 3.0, 4.0, 5.0)]
        arcs, best = free_arcs(robot, target, walls), roomiest(robot, target, walls)
        for k, arc in enumerate(arcs):
            assert arc.width <= narrow and best.flags["free"][k] == (arc.width > 0.0)
            assert arc.width == 0.0 or arc.contains(best.free[k])
        assert any(len(arc.free) for arc in arcs) == (narrow > 0.0)


def test_arcs_say_what_they_are_not_for():
    pose = forward(load("ur5"), np.zeros(6))
    with pytest.raises(InputError, match="no redundancy"):
        elbow_arcs(load("ur5"), pose, [])
    with pytest.raises(InputError, match="GripperOnPlane"):
        free_arcs(humanoid_arm(), pose)
    with pytest.raises(InputError, match="one pose"):
        free_arcs(load("panda"), forward(load("panda"), np.zeros((2, 7))))
