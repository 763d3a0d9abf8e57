"""TOPP-RA timing: limits by finite differences, never slower than the smooth one, jerk, and resampling on the certified path."""

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from horosphere import InputError, Scene, planning, robots
from horosphere.certify import certify
from horosphere.planning import resample
from horosphere.planning._time_optimal import time_optimal_path
from horosphere.planning._timing import motion_limits, timed, timed_path
from horosphere.scenes import JointTarget, Options, Trajectory


def waypoints_of(seed, robot, count=12):
    rng = np.random.default_rng(seed)
    middle = 0.5 * (robot.limits.lower + robot.limits.upper)
    return middle + np.cumsum(rng.normal(size=(count, robot.n_joints)) * 0.1, axis=0)


@pytest.mark.parametrize("seed", range(4))
def test_limits_by_finite_differences_and_faster_than_smooth(seed):
    robot = robots.load("panda")
    limits, points = robot.limits, waypoints_of(seed, robot)
    step = 5e-4
    fast = timed(robot, points, Options(timing="time-optimal", time_step=step))
    smooth = timed(robot, points, Options(time_step=step))
    h = fast.time[1]
    rate = np.diff(fast.positions, axis=0) / h
    change = np.diff(rate, axis=0) / h
    assert (np.abs(rate) <= limits.velocity * (1 + 1e-6)).all()
    assert (np.abs(change) <= limits.acceleration * (1 + 1e-6)).all()
    assert np.abs(rate / limits.velocity).max() > 0.9 or np.abs(change / limits.acceleration).max() > 0.9
    assert fast.duration < 0.85 * smooth.duration
    np.testing.assert_array_equal(fast.positions[[0, -1]], points[[0, -1]])
    np.testing.assert_array_equal(fast.velocities[[0, -1]], 0.0)
    centre = (fast.positions[2:] - fast.positions[:-2]) / (2 * h)
    np.testing.assert_allclose(centre, fast.velocities[1:-1], atol=limits.acceleration.max() * h)
    for path in (fast, smooth):  # the same curve
        other = smooth if path is fast else fast
        gaps = np.linalg.norm(path.positions[::40, None] - other.positions[None], axis=2).min(axis=1)
        assert gaps.max() < 2e-3


@pytest.mark.parametrize("limit", [500.0, 50.0])
@pytest.mark.parametrize("seed", range(2))
def test_jerk_is_kept(seed, limit):
    robot = robots.load("panda")
    step = 1e-3
    free = timed(robot, waypoints_of(seed, robot), Options(timing="time-optimal", time_step=step))
    bound = timed(robot, waypoints_of(seed, robot), Options(timing="time-optimal", time_step=step, jerk=limit))
    h = bound.time[1]
    jerk = np.diff(bound.positions, n=3, axis=0) / h**3
    assert np.abs(jerk).max() <= limit * 1.01
    assert np.abs(np.diff(bound.positions, axis=0) / h).max() <= robot.limits.velocity.max()
    assert (np.abs(np.diff(bound.positions, n=2, axis=0) / h**2) <= robot.limits.acceleration * (1 + 1e-6)).all()
    assert bound.duration > free.duration
    assert np.abs(np.diff(free.positions, n=3, axis=0) / free.time[1] ** 3).max() > 2 * limit


def test_one_joint_is_bang_bang():
    """One joint from rest to rest: the duration that acceleration and velocity allow, to the per mille."""
    for way, v, a in ((0.2, 2.0, 4.0), (3.0, 1.0, 4.0)):
        exact = 2 * np.sqrt(way / a) if way <= v * v / a else way / v + v / a
        path = time_optimal_path(np.linspace([0.0], [way], 5), np.array([v]), np.array([a]), 1e-3)
        assert exact <= path.duration <= 1.01 * exact
        jerky = time_optimal_path(
            np.linspace([0.0], [way], 5), np.array([v]), np.array([a]), 1e-3, jerk=np.array([40.0])
        )
        # the exact time with a jerk limit where all three phases are reached is longer by a / j
        assert exact + (0.1 if way == 3.0 else 0.0) <= jerky.duration * 1.001 and jerky.duration < exact + 0.25


def test_no_motion_and_bad_options():
    robot = robots.load("panda")
    here = 0.5 * (robot.limits.lower + robot.limits.upper)
    assert len(timed(robot, np.stack([here, here]), Options(timing="time-optimal"))) == 1
    with pytest.raises(InputError, match="timing"):
        timed(robot, np.stack([here, here + 0.1]), Options(timing="fast"))
    with pytest.raises(InputError, match="jerk"):
        timed(robot, np.stack([here, here + 0.1]), Options(jerk=10.0))


@pytest.mark.parametrize("jerk", [None, 200.0])
def test_without_topp_ra_limits_hold_all_the_same(monkeypatch, jerk):
    from horosphere.planning import _time_optimal

    robot = robots.load("panda")
    options = Options(timing="time-optimal", time_step=1e-3, jerk=jerk)
    best = timed(robot, waypoints_of(0, robot), options)
    monkeypatch.setattr(_time_optimal, "_fastest", lambda *_: None)
    path = timed(robot, waypoints_of(0, robot), options)
    h = path.time[1]
    assert (np.abs(np.diff(path.positions, axis=0)) / h <= robot.limits.velocity).all()
    assert (np.abs(np.diff(path.positions, n=2, axis=0)) / h**2 <= robot.limits.acceleration * (1 + 1e-6)).all()
    if jerk:
        assert np.abs(np.diff(path.positions, n=3, axis=0)).max() / h**3 <= jerk * 1.01
    assert path.duration > best.duration


def scene_and_plan():
    scene = Scene.load("humanoid-reach")
    return scene, planning.plan(scene, timing="time-optimal")


@pytest.fixture(scope="module")
def reached():
    return scene_and_plan()


def test_a_plan_with_optimal_timing_is_certified(reached):
    scene, plan = reached
    assert plan.solved and plan.certificate.certified
    assert plan.trajectory.duration < planning.plan(scene).trajectory.duration


@pytest.mark.parametrize("rate", [1000.0, 250.0, 83.0])
def test_resampled_for_a_controller(reached, rate):
    scene, plan = reached
    anew = resample(plan.trajectory, rate, plan.scene)
    np.testing.assert_allclose(np.diff(anew.trajectory.time), 1 / rate, rtol=1e-9)
    assert anew.stretch >= 1.0 and certify(plan.scene, anew.trajectory).certified
    same = resample(plan.trajectory, rate)
    assert same.how == "same path"
    np.testing.assert_allclose(np.diff(same.trajectory.time), 1 / rate, rtol=1e-9)
    assert certify(plan.scene, same.trajectory).certified
    # every old waypoint is one of the new, in order, and what lies between is on the straight line
    new, at = same.trajectory.positions, -1
    for point in plan.trajectory.positions:
        hits = np.flatnonzero(np.abs(new - point).max(axis=1) < 1e-12)
        assert len(hits) and hits[-1] > at
        at = hits[hits > at][0]
    speed = np.abs(np.diff(new, axis=0)).max(axis=0) * rate
    assert (
        speed
        <= np.abs(np.diff(plan.trajectory.positions, axis=0) / np.diff(plan.trajectory.time)[:, None]).max(axis=0)
        * (1 + 1e-9)
    ).all()


def joint_motion(name, **options):
    """A plan between two random postures of a robot alone in the world."""
    robot = robots.load(name)
    rng = np.random.default_rng(8)
    low, high = np.maximum(robot.limits.lower, -2.5), np.minimum(robot.limits.upper, 2.5)
    for _ in range(50):
        a, b = (0.5 * (low + high) + 0.3 * (high - low) * rng.uniform(-1.0, 1.0, robot.n_joints) for _ in range(2))
        plan = planning.plan(Scene(robot=robot, start=JointTarget(a), goal=JointTarget(b)), **options)
        if plan.solved:
            return plan
    raise AssertionError("no posture free")


@pytest.mark.parametrize("options", [{}, {"timing": "time-optimal"}, {"timing": "time-optimal", "jerk": 500.0}])
@pytest.mark.parametrize("name", ["panda", "ur5", "humanoid-arm"])
def test_a_drive_gets_set_points_within_the_limits(name, options):
    """Every plan is resampled smoothly; finite differences at the controller's own rate keep every limit, from rest to rest."""
    plan = joint_motion(name, **options)
    velocity, acceleration, _ = motion_limits(plan.scene.robot, plan.scene.options)
    for rate in (125.0, 250.0, 333.0, 1000.0):
        new = resample(plan.trajectory, rate, plan.scene)
        assert new.how == "certified anew" and new.certificate.certified
        assert 1.0 <= new.stretch <= 1.0 + (2 * plan.scene.options.time_step + 2 / rate) / plan.trajectory.duration
        t = new.trajectory
        np.testing.assert_allclose(np.diff(t.time), 1 / rate, rtol=1e-9)
        q = np.concatenate([t.positions[:1]] * 3 + [t.positions] + [t.positions[-1:]] * 3)
        speed, push, jerk = (np.abs(np.diff(q, n=n, axis=0)) * rate**n for n in (1, 2, 3))
        assert (speed <= velocity * (1 + 1e-6)).all() and (push <= acceleration * (1 + 1e-6)).all()
        assert np.abs(jerk).max() <= options.get("jerk", np.inf) * (1 + 1e-3)
        middle = (t.positions[2:] - t.positions[:-2]) * rate / 2
        np.testing.assert_allclose(middle, t.velocities[1:-1], atol=acceleration.max() / rate)
        assert (np.abs(t.velocities) <= velocity * (1 + 1e-9)).all()
        assert (np.abs(t.accelerations) <= acceleration * (1 + 1e-9)).all()
        # no further from the plan's own points than a sixth of their second differences, where it is not through them
        away = np.abs(t.positions[:, None] - plan.trajectory.positions[None, ::10]).max(axis=2).min(axis=0)
        bound = acceleration.max() * plan.scene.options.time_step**2 / 6 + speed.max() / rate
        assert away.max() <= bound
    if name == "panda" and options == {"timing": "time-optimal"}:  # what the limits would be without the care taken
        steps = np.diff(resample(plan.trajectory, 1000.0).trajectory.positions, n=2, axis=0) * 1e6
        assert (np.abs(steps) / acceleration).max() > 5.0


@pytest.mark.parametrize("seed", range(3))
def test_cubics_where_waypoints_are_not_evenly_spaced(seed):
    """Of a motion of someone else: time is stretched until the limits hold; joints may come in another order."""
    robot = robots.load("panda")
    rng = np.random.default_rng(seed)
    a, b = robot.limits.lower + (robot.limits.upper - robot.limits.lower) * rng.uniform(0.45, 0.55, (2, 7))
    u = np.concatenate([[0.0], np.sort(rng.uniform(0.05, 0.95, 8)), [1.0]])[:, None]
    q, dq = a + (b - a) * (3 * u**2 - 2 * u**3), 6 * (u - u**2) * (b - a)
    duration = 0.5 * np.sqrt(6 * (np.abs(b - a) / robot.limits.acceleration).max())  # twice as fast as it may be
    order = rng.permutation(7)
    names = tuple(robot.joint_names[i] for i in order)
    motion = Trajectory(u[:, 0] * duration, q[:, order], dq[:, order] / duration, None, names)
    scene = Scene(robot=robot, start=JointTarget(a), goal=JointTarget(b))
    new = resample(motion, 1000.0, scene)
    assert new.how == "certified anew" and 1.99 <= new.stretch <= 2.2
    push = np.abs(np.diff(new.trajectory.positions, n=2, axis=0)) * 1e6
    assert (push <= robot.limits.acceleration[order] * (1 + 1e-6)).all() and new.trajectory.names == names


def test_why_a_motion_is_not_smooth(reached):
    _, plan = reached
    strict = plan.scene.with_(options=dataclasses.replace(plan.scene.options, clearance=0.5))
    new = resample(plan.trajectory, 500.0, strict)
    assert new.how.startswith("same path: a smooth curve is not certified (") and "mm" in new.how
    bare = Trajectory(plan.trajectory.time, plan.trajectory.positions)
    assert resample(bare, 500.0, plan.scene).how == "same path: the trajectory states no velocities"


def test_a_corner_is_kept():
    """Plain interpolation at another rate would cut this corner by 0.25."""
    path = Trajectory([0.0, 0.5, 1.0], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    new = resample(path, 3.0).trajectory.positions
    assert any(np.array_equal(row, [1.0, 0.0]) for row in new)
    with pytest.raises(InputError, match="rate"):
        resample(path, 0.0)


def test_the_default_does_not_import_toppra():
    code = (
        "import sys, numpy as np; from horosphere import robots; from horosphere.planning._timing import timed; "
        "from horosphere.scenes import Options; r = robots.load('panda'); "
        "timed(r, np.zeros((2, 7)) + [[0.0], [0.1]], Options()); print(sorted({'toppra', 'scipy'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_agrees_with_smooth_on_any_coordinates():
    points = np.array([[0.0, 0.0], [0.5, 0.2], [0.6, 0.9]])
    v, a = np.array([1.0, 1.0]), np.array([3.0, 3.0])
    fast, smooth = time_optimal_path(points, v, a, 1e-3), timed_path(points, v, a, 1e-3, ("x", "y"))
    assert fast.duration < smooth.duration


def test_the_page_runs():
    page = (Path(__file__).parents[2] / "docs" / "timing.md").read_text()
    names: dict = {}
    exec(page.split("```python\n")[1].split("```")[0], names)
    assert names["plan"].solved and names["fast"].certificate.certified and names["fast"].how == "certified anew"


def test_mcap_holds_what_foxglove_needs(tmp_path, reached):
    factory = pytest.importorskip("mcap_ros2.decoder").DecoderFactory()
    from mcap.reader import make_reader

    from horosphere.io import save_trajectory

    trajectory = resample(reached[1].trajectory, 500.0).trajectory
    with open(save_trajectory(trajectory, tmp_path / "t.mcap"), "rb") as file:
        reader = make_reader(file, decoder_factories=[factory])
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        (schema,), (channel,) = summary.schemas.values(), summary.channels.values()
        assert (schema.name, schema.encoding) == ("trajectory_msgs/msg/JointTrajectory", "ros2msg")
        assert (channel.message_encoding, channel.topic) == ("cdr", "/joint_trajectory")
        ((_, _, _, message),) = reader.iter_decoded_messages()
    times = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in message.points]
    np.testing.assert_allclose(times, trajectory.time, atol=1e-9)
    np.testing.assert_array_equal([p.positions for p in message.points], trajectory.positions)
