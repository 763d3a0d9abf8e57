"""Certificates of trajectories in scenes: every condition, one at a time."""

import json

import numpy as np
import pytest

from horosphere.certify import certify
from horosphere.errors import InputError
from horosphere.robots import humanoid_arm
from horosphere.robots._placement import compose, link_frames, rotation_translation
from horosphere.scenes import (
    Aerofoil,
    EllipsoidND,
    GripperPlaneTarget,
    JointTarget,
    LineTarget,
    PlaneTarget,
    PointRobot,
    PoseTarget,
    PositionTarget,
    Scene,
    SnakeRobot,
    Star,
    Trajectory,
    UnicycleRobot,
    Workspace,
    matrix_quaternion,
)
from horosphere.shapes import Ball, Box

START, GOAL = np.zeros(5), np.array([0.5, 0.8, 0.9, 0.2, 0.4])


def reach(**changes):
    parts = {
        "robot": humanoid_arm(),
        "start": START,
        "goal": GOAL,
        "obstacles": [Ball([0.33, 0.03, -0.03], 0.075, name="ball")],
    }
    return Scene(**(parts | changes))


def motion(duration=4.0, k=40):
    return Trajectory(np.linspace(0.0, duration, k), np.linspace(START, GOAL, k))


def test_a_clear_motion_is_certified():
    c = certify(reach(), motion())
    assert c.certified and c.first_violation is None and not c.unresolved and c.collision_free
    assert c.limits_ok and c.velocities_ok and c.goal_error == c.start_error == 0.0
    assert 0.0 < c.clearance <= c.clearance_seen and "certified" in c.reason
    text = json.loads(json.dumps(c.as_dict(), allow_nan=False))
    assert text["certified"] is True and text["clearance"] == c.clearance


def test_the_clearance_is_found_closely_or_roughly_where_that_takes_too_long():
    scene, fine = reach(), certify(reach(), motion())
    rough = certify(scene, motion(), tolerance=5e-4, relative=0.05)
    assert fine.clearance_seen - fine.clearance <= max(1e-5, 2e-3 * fine.clearance_seen)
    assert rough.evaluations < fine.evaluations and rough.clearance < fine.clearance
    short = certify(scene, motion(), max_evaluations=rough.evaluations + 2)
    assert short.certified and not short.unresolved and short.clearance == rough.clearance


def test_a_collision_names_link_obstacle_and_time():
    robot = humanoid_arm()
    middle = link_frames(robot.links, 0.5 * (START + GOAL))[4]
    wrist = rotation_translation(middle)[1]
    c = certify(reach(obstacles=[Ball(wrist, 0.03, name="lamp")]), motion())
    v = c.first_violation
    assert not c.certified and v is not None and v.kind == "obstacle" and v.other == "lamp"
    assert v.subject in ("forearm", "forearm_roll", "gripper") and v.time is not None and 0.0 < v.time < 2.0
    assert "lamp" in str(v) and c.clearance < 0.0 and not c.collision_free


def test_the_margin_of_the_scene_decides():
    free = certify(reach(), motion())
    scene = reach()
    options = type(scene.options)(clearance=free.clearance_seen + 1e-3)
    c = certify(scene.with_(options=options), motion())
    assert not c.certified and c.collision_free and c.first_violation is not None
    assert c.first_violation.limit == options.clearance


def test_limits_and_velocities():
    robot = humanoid_arm()
    far = START.copy()
    far[2] = robot.limits.upper[2] + 1e-6
    c = certify(reach(goal=START, obstacles=[]), Trajectory([0.0, 9.0, 18.0], [START, far, START]))
    assert not c.certified and not c.limits_ok and c.velocities_ok
    assert c.first_violation is not None and c.first_violation.subject == robot.joint_names[2]
    fast = certify(reach(), motion(duration=0.2))
    assert not fast.certified and fast.limits_ok and not fast.velocities_ok
    assert fast.first_violation is not None and fast.first_violation.kind == "velocity"
    stated = motion()
    speeds = np.zeros((40, 5))
    speeds[7, 1] = 2.1
    c = certify(reach(), Trajectory(stated.time, stated.positions, speeds))
    assert (
        not c.velocities_ok
        and c.first_violation is not None
        and c.first_violation.time == pytest.approx(stated.time[7])
    )


@pytest.mark.parametrize("which", ["start", "goal"])
def test_start_and_goal_must_be_met(which):
    off = (START if which == "start" else GOAL) + 1e-3
    c = certify(reach(**{which: off}), motion())
    assert not c.certified and c.first_violation is not None and c.first_violation.kind == which
    assert getattr(c, f"{which}_error") == pytest.approx(1e-3)


def test_goals_in_space():
    robot = humanoid_arm()
    R, p = rotation_translation(compose(link_frames(robot.links, GOAL)[robot.tip], robot.tool))
    normal = np.cross(R[:, 1], [1.0, 0, 0])
    shift, e = np.array([0.0, 3e-3, 4e-3]), np.array([0.0, 0.6, 0.8])
    turn = np.array([[np.cos(0.01), -np.sin(0.01), 0], [np.sin(0.01), np.cos(0.01), 0], [0, 0, 1.0]])
    for target, metres, radians in (
        (PoseTarget(p, matrix_quaternion(R)), 0.0, 0.0),
        (PoseTarget(p + shift, matrix_quaternion(R @ turn)), 5e-3, 0.01),
        (PositionTarget(p + shift), 5e-3, 0.0),
        (GripperPlaneTarget(p, normal), 0.0, 0.0),
        (LineTarget(p + [0, 2e-3, 0], [1.0, 0, 0]), 2e-3, 0.0),
        (PlaneTarget(e, e @ p + 1e-3), 1e-3, 0.0),
        (JointTarget(GOAL), 0.0, 0.0),
    ):
        c = certify(reach(goal=target, obstacles=[]), motion())
        assert c.goal_error == pytest.approx(metres, abs=1e-12) and c.goal_angle_error == pytest.approx(
            radians, abs=1e-12
        )
        assert c.certified == (metres == 0.0 and radians == 0.0)


def test_joint_names_are_brought_into_order():
    m, robot = motion(), humanoid_arm()
    order = [3, 1, 4, 0, 2]
    shuffled = Trajectory(m.time, m.positions[:, order], names=tuple(robot.joint_names[i] for i in order))
    assert certify(reach(), shuffled).clearance == certify(reach(), m).clearance
    with pytest.raises(InputError, match="the trajectory moves a, b, c, d, e"):
        certify(reach(), Trajectory(m.time, m.positions, names=tuple("abcde")))
    with pytest.raises(InputError, match=r"\(k, 5\)"):
        certify(reach(), np.zeros((4, 6)))


def test_waypoints_without_times():
    c = certify(reach(), motion().positions)
    assert c.certified and c.velocities_ok
    v = certify(reach(goal=GOAL + 1.0), motion().positions).first_violation
    assert v is not None and v.time is None


def test_self_collision_has_its_own_margin():
    c = certify(reach(obstacles=[]), motion())
    assert np.isposinf(c.clearance) and c.certified and c.as_dict()["clearance"] is None
    robot = humanoid_arm()
    assert len(robot.self_pairs)
    scene = reach(obstacles=[])
    options = type(scene.options)(self_clearance=c.self_clearance_seen + 0.01)
    d = certify(scene.with_(options=options), motion())
    assert not d.certified and d.first_violation is not None and d.first_violation.kind == "self"


OUTLINES = {
    "ball": Ball([0.5, 0.5], 0.2),
    "ellipse": EllipsoidND([0.5, 0.5], [0.3, 0.1], None),
    "star": Star([0.5, 0.5], 0.2, 5, 0.3),
    "aerofoil": Aerofoil([0.5, 0.5], 0.1, -0.01 + 0.01j, 0.4),
}


def boundary(solid, n=20_000):
    """Points of the outline, from its definition."""
    t = np.linspace(0.0, 2.0 * np.pi, n)
    circle = np.column_stack((np.cos(t), np.sin(t)))
    if isinstance(solid, Ball):
        return solid.center + solid.radius * circle
    if isinstance(solid, EllipsoidND):
        return solid.center + (circle * solid.semi_axes) @ solid.rotation.T
    if isinstance(solid, Star):
        return (
            solid.center
            + (solid.radius * (1 + solid.amplitude * np.cos(solid.lobes * (t - solid.angle))))[:, None] * circle
        )
    P = solid.mu + abs(solid.k - solid.mu) * np.exp(1j * t)
    w = (P + solid.k**2 / P) * np.exp(1j * solid.angle)
    return solid.center + np.column_stack((w.real, w.imag))


@pytest.mark.parametrize("kind", OUTLINES)
@pytest.mark.parametrize("seed", range(3))
def test_a_ball_on_a_polyline_in_the_plane(kind, seed):
    rng = np.random.default_rng(seed)
    solid, outline = OUTLINES[kind], boundary(OUTLINES[kind])
    path = np.array([[0.0, 0.0], rng.uniform([0.0, 0.8], [0.3, 1.0]), [1.0, 1.0]])
    s = np.linspace(0, 1, 300)[:, None, None]
    points = (path[:-1] + s * (path[1:] - path[:-1])).reshape(-1, 2)
    sampled = (
        min(np.linalg.norm(points[i : i + 50, None] - outline, axis=2).min() for i in range(0, len(points), 50)) - 0.05
    )
    c = certify(Scene(PointRobot(2, 0.05), path[0], path[-1], (solid,)), Trajectory([0.0, 2.0, 4.0], path))
    assert sampled - 2e-3 * abs(sampled) - 2e-4 < c.clearance <= sampled + 1e-12  # the outline is met from outside only
    assert c.certified == (c.clearance >= c.margin)


def test_a_ball_through_a_ball_in_five_dimensions():
    center = np.array([0.5, 0.01, 0, 0, 0])
    scene = Scene(PointRobot(5, 0.1), np.zeros(5), np.eye(5)[0], (Ball(center, 0.2),))
    c = certify(scene, Trajectory([0.0, 1.0], [np.zeros(5), np.eye(5)[0]]))
    assert c.clearance == pytest.approx(0.01 - 0.3, abs=1e-12) and c.first_violation is not None
    reached = 0.5 - np.sqrt(0.31**2 - 0.01**2)  # margin 0.01
    assert c.first_violation.time == pytest.approx(reached, abs=2e-5)


def test_point_robot_speed_wall_and_goal():
    scene = Scene(PointRobot(2, 0.1, max_speed=1.0), [0, 0], [1, 0], (), workspace=Workspace([0.0, 0.0], 1.05))
    c = certify(scene, Trajectory([0.0, 0.5], [[0, 0], [1.0, 0]]))
    assert {v.kind for v in c.violations} == {"workspace", "velocity"} and not c.velocities_ok
    late = certify(scene.with_(workspace=None), Trajectory([0.0, 1.0], [[0, 0], [0.9, 0]]))
    assert late.goal_error == pytest.approx(0.1) and not late.certified


def test_a_box_in_space_and_a_unicycle():
    scene = Scene(PointRobot(3, 0.1), [-1, 0, 0], [1, 0, 0], (Box([0, 0.5, 0], [0.2, 0.2, 0.2]),))
    c = certify(scene, np.array([[-1.0, 0, 0], [1, 0, 0]]))
    assert c.certified and c.clearance == pytest.approx(0.2, abs=3e-4) and c.clearance <= 0.2
    from horosphere.scenes import HeadingTarget

    drive = Scene(UnicycleRobot(0.1), HeadingTarget([0, 0]), HeadingTarget([1, 0], 0.5), (Ball([0.5, 0.5], 0.2),))
    c = certify(drive, np.array([[0, 0, 0.0], [1, 0, 0.5]]))
    assert c.certified and c.clearance == pytest.approx(0.2, abs=1e-12) and c.goal_angle_error == 0.0


def test_a_snake_is_refused():
    from horosphere.scenes import PostureTarget

    scene = Scene(SnakeRobot(np.ones(3)), PostureTarget(np.zeros(5)), PostureTarget(np.ones(5)))
    with pytest.raises(InputError, match="SnakeRobot"):
        certify(scene, np.zeros((2, 5)))
