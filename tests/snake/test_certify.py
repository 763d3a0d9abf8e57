"""Certificates of trajectories and of the snake against itself: by dense sampling, and by breaking what is certified."""

import dataclasses
import re

import numpy as np
import pytest

from horosphere.errors import InputError
from horosphere.scenes import Scene, Trajectory
from horosphere.snake import Snake, certificate_of, certify_trajectory, navigate_scene, snake_of, trajectory_of
from horosphere.snake._world import self_distance


@pytest.fixture(scope="module")
def gap():
    scene = Scene.load("snake-gap")
    result = navigate_scene(scene)
    trajectory = trajectory_of(snake_of(scene), result)
    assert trajectory is not None
    return scene, result, trajectory


@pytest.mark.parametrize("seed", range(4))
def test_self_distance_is_the_least_over_dense_points(seed):
    rng = np.random.default_rng(seed)
    snake = Snake(6)
    joints = snake.joints(rng.uniform(-1.6, 1.6, (30, snake.n)))
    part = np.linspace(0, 1, 200)[:, None]
    for one, found in zip(joints, self_distance(joints)):
        points = one[:-1, None] + part * (one[1:] - one[:-1])[:, None]
        dense = min(
            np.linalg.norm(points[i][:, None] - points[j], axis=-1).min() for i in range(6) for j in range(i + 2, 6)
        )
        assert found <= dense + 1e-12
        assert dense - found < 0.02


def test_navigation_brings_a_whole_certificate(gap):
    scene, result, _ = gap
    proof = certificate_of(scene, result)
    assert proof.certified and 0.0 < proof.self_clearance <= proof.self_clearance_seen
    assert proof.start_error < 1e-9 and proof.goal_error < 1e-6
    assert "not checked" in proof.reason
    assert any("wave" in note for note in result.notes)


def test_a_trajectory_is_certified_by_itself(gap):
    scene, _, trajectory = gap
    proof = certify_trajectory(scene, trajectory)
    assert proof.certified, proof.reason
    snake = snake_of(scene)
    dense = trajectory.at(np.linspace(0, trajectory.time[-1], 20001))
    from horosphere.snake import Surroundings

    free = Surroundings.of(list(scene.obstacles), None).of_body(snake.joints(dense), 0.5 * scene.robot.width)
    assert proof.clearance <= free.min()


@pytest.mark.parametrize(
    "change, text",
    [
        (lambda q: q[:-40], "goal is missed"),
        (lambda q: q + np.eye(8)[1] * 0.5, "start is missed"),
        (lambda q: q + np.eye(8)[3] * np.sin(np.linspace(0, 40, len(q)))[:, None], "slips sideways"),
        (lambda q: np.concatenate([q[:1], q[-1:]]), "slips sideways|clearance"),
    ],
)
def test_what_is_wrong_is_said(gap, change, text):
    scene, _, trajectory = gap
    q = change(trajectory.positions)
    proof = certify_trajectory(scene, Trajectory(np.arange(len(q)) * 0.1, q, None, None, trajectory.names))
    assert not proof.certified

    assert re.search(text, proof.reason)


def test_links_that_cross_are_seen(gap):
    scene, _, trajectory = gap
    q = trajectory.positions[:1].repeat(2, axis=0).copy()
    q[:, 3:7] = 1.9
    proof = certify_trajectory(
        scene, dataclasses.replace(trajectory, time=np.array([0.0, 1.0]), positions=q, velocities=None)
    )
    assert not proof.certified and "links come too close" in proof.reason


def test_wrong_columns_are_named(gap):
    scene, _, trajectory = gap
    with pytest.raises(InputError, match="expected 8 columns"):
        certify_trajectory(scene, Trajectory(trajectory.time, trajectory.positions[:, :5], None, None, ()))


def test_the_command_checks_a_snake(gap, tmp_path, capsys):
    from horosphere.cli._app import main
    from horosphere.io import save_trajectory

    scene, _, trajectory = gap
    save_trajectory(trajectory, tmp_path / "t.npz")
    assert main(["check", "snake-gap", str(tmp_path / "t.npz"), "--json"]) == 0
    assert main(["check", "snake-park", str(tmp_path / "t.npz"), "--json"]) == 1
