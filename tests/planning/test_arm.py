"""Plans of arms, checked by dense sampling with plain geometry, and the reasons of those that cannot be."""

import dataclasses

import numpy as np
import pytest

from horosphere import kinematics, robots
from horosphere.planning import plan
from horosphere.scenes import GripperPlaneTarget, JointTarget, Options, PoseTarget, PositionTarget, Scene
from horosphere.shapes import Ball, Box
from horosphere.versors import Motor


def segment_distance(a, b, c):
    """Distances of a point c from segments a-b, (...,), by plain vectors."""
    u = b - a
    t = np.clip(((c - a) * u).sum(-1) / np.maximum((u * u).sum(-1), 1e-300), 0.0, 1.0)
    return np.linalg.norm(a + t[..., None] * u - c, axis=-1)


def dense_clearance(scene, trajectory, per_step=10):
    """Least distance of the robot's capsules to balls along the trajectory, sampled between its points."""
    q = np.concatenate([
        a + s * (b - a)
        for a, b in zip(trajectory.positions[:-1], trajectory.positions[1:])
        for s in [np.linspace(0, 1, per_step, endpoint=False)[:, None]]
    ])  # fmt: skip
    frames = kinematics.frames(scene.robot, q).as_matrix()
    bodies, least = scene.robot.capsules, np.inf
    for k in range(len(bodies)):
        T = frames[:, bodies.link[k]]
        a, b = (T[:, :3, :3] @ p + T[:, :3, 3] for p in (bodies.a[k], bodies.b[k]))
        for ball in scene.obstacles:
            least = min(least, (segment_distance(a, b, ball.center) - ball.radius - bodies.radius[k]).min())
    return least


@pytest.fixture(scope="module")
def reach():
    scene = Scene.load("humanoid-reach")
    return scene, plan(scene)


def test_humanoid_reach_is_solved_by_the_field(reach):
    scene, found = reach
    assert found.solved and found.reason == "solved", found.reason
    assert found.solved_by == "harmonic field, closed form"
    assert found.certificate.certified and found.certificate.clearance >= 0.014


def test_humanoid_reach_keeps_its_distance_by_another_measure(reach):
    scene, found = reach
    least = dense_clearance(scene, found.trajectory)
    assert least >= found.certificate.clearance - 1e-12 >= 0.014
    assert least <= found.certificate.clearance * 1.1 + 1e-3  # the bound is worth something


def test_humanoid_reach_moves_gently_and_arrives(reach):
    scene, found = reach
    q = found.trajectory.positions
    assert np.degrees(np.abs(np.diff(q, axis=0)).max()) <= 5.0
    assert ((q >= scene.robot.limits.lower) & (q <= scene.robot.limits.upper)).all()
    tool = kinematics.forward(scene.robot, q).as_matrix()
    np.testing.assert_allclose(tool[0, :3, 3], scene.start.position, atol=1e-9)
    np.testing.assert_allclose(tool[-1, :3, 3], scene.goal.position, atol=1e-9)
    gripper = tool[:, :3, :3] @ [0.0, 1.0, 0.0]
    assert np.abs(gripper @ scene.goal.normal).max() < 2e-3  # along the whole path, not only at its points


def test_choosing_phi_zero_collides():
    """The paper's own choice: every branch with phi = 0 touches the ball somewhere on the same path."""
    scene = Scene.load("humanoid-reach")
    found = plan(scene)
    for branch in range(8):
        q, valid = [], []
        for point in found.path:
            row = kinematics.inverse(scene.robot, kinematics.GripperOnPlane(point, scene.goal.normal), phi=0.0)
            q.append(row.q[branch])
            valid.append(row.valid[branch])
        still = np.repeat(np.array(q)[np.array(valid)], 2, axis=0)
        trajectory = type(found.trajectory)(np.arange(len(still)) * 1.0, still)
        assert dense_clearance(scene, trajectory, per_step=1) < 0.0


def random_scene(seed):
    """Balls between two postures of the humanoid arm that it can hold."""
    rng = np.random.default_rng(seed)
    robot = robots.load("humanoid-arm")
    lower, upper = robot.limits.lower, robot.limits.upper
    ends = []
    while len(ends) < 2:
        q = rng.uniform(lower, upper)
        pose = kinematics.forward(robot, q).as_matrix()
        if 0.3 < np.linalg.norm(pose[:3, 3] - [0, 0.1, 0]) < 0.6:
            gripper = pose[:3, :3] @ [0.0, 1.0, 0.0]
            normal = np.cross(gripper, rng.normal(size=3))
            ends.append(GripperPlaneTarget(pose[:3, 3], normal))
    balls = [Ball(rng.uniform(-0.5, 0.5, 3), rng.uniform(0.03, 0.09)) for _ in range(3)]
    return Scene(robot, *ends, tuple(balls), name=f"random {seed}", options=Options(time_limit=2.0))


@pytest.mark.parametrize("seed", range(12))
def test_whatever_is_called_solved_is_clear(seed):
    scene = random_scene(seed)
    found = plan(scene, method="field")
    if not found.solved:
        assert found.reason and found.reason != "solved"
        assert found.trajectory is None
    else:
        assert dense_clearance(scene, found.trajectory, per_step=4) >= scene.options.clearance - 1e-12


def test_some_random_scenes_are_solved():
    assert sum(plan(random_scene(seed), method="field").solved for seed in range(12)) >= 3


def test_panda_passes_a_ball_by_its_closed_form():
    robot = robots.load("panda")
    start = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.785])
    goal = PoseTarget([0.35, -0.45, 0.25], [0, 0.866, -0.5, 0])
    scene = Scene(robot, JointTarget(start), goal, (Ball([0.45, -0.2, 0.35], 0.08, name="ball"),))
    found = plan(scene, method="field")
    assert found.solved, found.reason
    np.testing.assert_array_equal(found.trajectory.positions[0], start)
    reached = kinematics.forward(robot, found.trajectory.positions[-1])
    np.testing.assert_allclose(reached.as_matrix(), goal.motor().as_matrix(), atol=1e-6)
    assert dense_clearance(dataclasses.replace(scene, robot=_without_base(robot)), found.trajectory, 2) >= 0.01


def _without_base(robot):
    bodies = robot.capsules
    moves = bodies.link > 0
    kept = type(bodies)(bodies.link[moves], bodies.a[moves], bodies.b[moves], bodies.radius[moves])
    return dataclasses.replace(robot, capsules=kept)


@pytest.mark.parametrize(
    "name, start, end, way",
    [
        ("nao-left-arm", [40, 20, -60, -60, 0], [20, 30, -40, -40, 0], "closed form"),
        ("panda", [0, -23, 0, -126, 0, 103, 45], [20, -10, 5, -110, 0, 103, 45], "Jacobian"),
    ],
)
def test_a_point_is_reached(name, start, end, way):
    robot = robots.load(name)
    goal = kinematics.forward(robot, np.radians(end)).as_matrix()[:3, 3]
    scene = Scene(robot, JointTarget(np.radians(start)), PositionTarget(goal), options=Options(clearance=0.0))
    found = plan(scene, method="field")
    assert found.solved, found.reason
    assert found.solved_by == f"harmonic field, {way}"
    tip = kinematics.forward(robot, found.trajectory.positions[-1]).as_matrix()[:3, 3]
    np.testing.assert_allclose(tip, goal, atol=1e-6)


def test_both_ends_given_as_joints():
    robot = robots.load("panda")
    a = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.785])
    b = np.array([0.9, 0.2, -0.3, -1.9, 0.2, 2.0, 0.5])
    found = plan(Scene(robot, JointTarget(a), JointTarget(b), (Ball([0.75, 0.3, 0.4], 0.07),)))
    assert found.solved, found.reason
    np.testing.assert_array_equal(found.trajectory.positions[[0, -1]], [a, b])


# ---------------------------------------------------------------- what cannot be, is said
def changed(**changes):
    return dataclasses.replace(Scene.load("humanoid-reach"), **changes)


def test_goal_out_of_reach_is_said_with_the_distance():
    found = plan(changed(goal=GripperPlaneTarget([1.5, 0.0, 0.0], [0, 1, 0])))
    assert not found.solved and found.trajectory is None
    assert found.reason.startswith("goal:") and "reach" in found.reason


def test_goal_inside_an_obstacle_is_said():
    scene = Scene.load("humanoid-reach")
    ball = Ball(scene.goal.position, 0.05, name="wall lamp")
    found = plan(dataclasses.replace(scene, obstacles=(ball,)))
    assert not found.solved
    assert "goal in collision" in found.reason and "'wall lamp'" in found.reason and "gripper" in found.reason


def test_a_start_that_is_too_close_names_the_pair():
    robot = robots.load("panda")
    start = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.785])
    tool = kinematics.forward(robot, start).as_matrix()[:3, 3]
    box = Box(tool, [0.02, 0.02, 0.02], name="part")
    found = plan(Scene(robot, JointTarget(start), JointTarget(start + 0.3), (box,)))
    assert not found.solved and found.reason.startswith("start too close") and "'part'" in found.reason


def test_start_beyond_a_limit_names_the_joint():
    robot = robots.load("panda")
    start = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.785])
    try:
        found = plan(Scene(robot, JointTarget(start + [9, 0, 0, 0, 0, 0, 0]), JointTarget(start)))
    except ValueError as error:  # a scene may refuse it already
        assert "panda_joint1" in str(error) or "joint" in str(error)
    else:
        assert not found.solved and "'panda_joint1'" in found.reason


def test_no_continuous_chain_is_said_not_looped():
    """Candidates exist at every point, but no branch leads through: the field alone must say so (math of the robust loop)."""
    scene = changed(
        start=GripperPlaneTarget([0.45, 0.0, 0.32], [0, 1, 0]),
        goal=GripperPlaneTarget([0.45, 0.0, -0.32], [0, 1, 0]),
        obstacles=(Ball([0.42, 0.0, 0.0], 0.1, name="ball"),),
    )
    found = plan(scene, method="field")
    assert not found.solved
    assert "path point" in found.reason


def test_unknown_options_are_refused_with_the_valid_ones():
    with pytest.raises(ValueError, match="clearance"):
        plan(Scene.load("humanoid-reach"), clearence=0.02)


def test_options_change_the_plan():
    found = plan(Scene.load("humanoid-reach"), clearance=0.03)
    assert found.solved and found.certificate.clearance >= 0.03


def test_motor_is_a_goal():
    robot = robots.load("panda")
    start = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.785])
    goal = kinematics.forward(robot, start + 0.2)
    found = plan(Scene(robot, start, Motor._wrap(goal.array.copy())))
    assert found.solved, found.reason
