"""Scenes, gaits, the controller of the paper, and the command line."""

import json

import numpy as np
import plain_model as plain
import pytest

from horosphere.errors import InputError
from horosphere.scenes import Scene
from horosphere.snake import (
    Snake,
    bracket_control,
    certificate_of,
    navigate_scene,
    serpenoid,
    shape_gait,
    snake_of,
    trajectory_of,
)


@pytest.mark.parametrize("name", ["snake-gap", "snake-slalom", "snake-park"])
def test_library_scenes_are_solved_and_certified(name):
    scene = Scene.load(name)
    result, snake = navigate_scene(scene), snake_of(scene)
    assert result.solved, result.reason
    certificate, trajectory = certificate_of(scene, result), trajectory_of(snake, result)
    assert certificate.certified and certificate.clearance >= scene.options.clearance
    np.testing.assert_allclose(np.exp(1j * trajectory.positions[-1, 2:]), np.exp(1j * scene.goal.q[2:]), atol=1e-6)
    discs = [(o.center, o.radius) for o in scene.obstacles]
    half = 0.5 * scene.robot.width
    for q in trajectory.positions[::20]:
        joints = plain.joints(q, snake.lengths)
        t = np.linspace(0, 1, 40)[:, None]
        body = np.concatenate([a + t * (b - a) for a, b in zip(joints[:-1], joints[1:])])
        free = min(np.linalg.norm(body - c, axis=1).min() - r for c, r in discs) - half
        assert free >= certificate.clearance - 1e-9
    # the written velocities are those of the positions, and roll the wheels
    slip = [
        np.abs(plain.pfaff(q, snake.lengths, 0.5) @ v).max()
        for q, v in zip(trajectory.positions, trajectory.velocities)
    ]
    assert max(slip) < 1e-9


def test_a_scene_with_another_robot_is_named():
    with pytest.raises(InputError, match="expected a scene with a snake"):
        navigate_scene(Scene.load("panda-table"))


def test_serpenoid_repeats_its_displacement():
    snake = Snake(6)
    gait = serpenoid(snake, np.array([0, 0, np.pi, 0.1, -0.2, 0.1, 0.2, 0.0]), amplitude=0.4)
    np.testing.assert_allclose(gait.displacement[1:], gait.displacement[:1].repeat(2, 0), atol=1e-9)
    assert 8.0 < np.linalg.norm(gait.displacement[0, :2]) < 12.0 and gait.motion.residual < 1e-12
    turning = serpenoid(snake, np.array([0, 0, np.pi, 0.1, -0.2, 0.1, 0.2, 0.0]), turn=0.02)
    np.testing.assert_allclose(turning.displacement[:, 2], 0.24, atol=1e-9)


def test_shape_gait_drives_its_joints_and_moves():
    snake = Snake(7)
    q = np.array([0.1, 0.2, 0.3, 0.2, 0.5, -0.4, 0.8, -0.3, 0.1])
    gait = shape_gait(snake, q, joints=(2, 4), amplitude=0.2, period=2.0, periods=2)
    assert gait.reason == "" and gait.condition >= 1.0
    t, driven = gait.motion.time, gait.motion.q[:, [4, 6]]
    expected = q[[4, 6]] + 0.2 * (np.sin(np.pi * t[:, None] + [0, np.pi / 2]) - np.sin([0, np.pi / 2]))
    np.testing.assert_allclose(driven, expected, atol=1e-8)
    assert np.linalg.norm(gait.displacement[0, :2]) > 1e-3
    with pytest.raises(InputError, match="two different joints"):
        shape_gait(snake, q, joints=(1, 2))
    with pytest.raises(InputError, match="locked"):
        shape_gait(snake, np.array([0, 0, 0, 0, np.pi, 0.2, 0.3, 0.4, 0]), joints=(2, 3))


def test_the_controller_of_the_paper_converges_very_near_and_not_far():
    rng = np.random.default_rng(3)
    snake = Snake(5)
    q, way = rng.uniform(-0.8, 0.8, snake.n), rng.normal(size=snake.n)
    near = bracket_control(snake, q, q + 1e-3 * way / np.linalg.norm(way))
    assert near.solved and near.errors[-1] < 1e-9
    q7 = np.concatenate([q, [0.3, -0.2, 0.4]])
    far = bracket_control(Snake(8), q7, q7 + 0.03 * rng.normal(size=10), sweeps=8)
    assert not far.solved and far.reason in ("stalled", "diverged")
    assert Snake(8).steer(q7, q7 + 0.003 * rng.normal(size=10)).solved


def run(capsys, *words):
    from horosphere.cli._app import main

    code = main(["snake", *words])
    return code, capsys.readouterr()


def test_growth_command(capsys):
    code, streams = run(capsys, "growth", "--links", "8", "--json")
    rows = json.loads(streams.out)["growth"]
    assert code == 0 and [r["vector"] for r in rows if r["posture"] == "generic"] == [[4, 5, 7, 8, 10]]
    assert {r["posture"]: r["controllable"] for r in rows}["folded"] is False
    code, streams = run(capsys, "growth", "--links", "8", "--wheel-fraction", "0.4", "--posture", "generic")
    assert code == 0 and "(4, 5, 7, 10)" in streams.out
    code, streams = run(capsys, "growth", "--q", "-0.1,0,0,0,0.3,0.5,0.3,0", "--json")
    assert json.loads(streams.out)["growth"][0]["vector"] == [4, 5, 7, 7, 8]
    code, streams = run(capsys, "growth", "--links", "2")
    assert code == 2 and "at least 3 links" in streams.err


def test_motion_commands(capsys, tmp_path):
    code, streams = run(capsys, "simulate", "--word", "12", "--t", "0.05", "--out", str(tmp_path), "--json")
    assert code == 0 and abs(json.loads(streams.out)["order"] - 2) < 0.3
    assert (tmp_path / "motion.png").stat().st_size > 5000 and (tmp_path / "trajectory.npz").exists()
    code, streams = run(capsys, "simulate", "--word", "1x")
    assert code == 2 and "unknown letter 'x'" in streams.err
    posture = "0,0,0,0.2,0.3,-0.2,0.1,0"
    code, streams = run(capsys, "steer", posture, "-0.1,0,0,0.2,0.3,-0.2,0.1,0", "--json")
    assert code == 0 and json.loads(streams.out)["error"] < 1e-9
    code, streams = run(capsys, "steer", "0,0,0,0,3.141592653589793,0,0,0", posture)
    assert code == 2 and "fold" in streams.err
    code, streams = run(capsys, "navigate", "snake-gap", "--out", str(tmp_path / "gap"), "--json")
    assert code == 0 and json.loads(streams.out)["certified"]
