"""Plans of balls, unicycles and snakes, checked by dense sampling."""

import numpy as np
import pytest

from horosphere.planning import plan
from horosphere.scenes import Scene

POINTS = [
    "rn-fig1-basic", "rn-fig2a-abrupt", "rn-fig2b-smooth", "rn-fig3-operation-plane", "rn-fig4-three-obstacles",
    "rn-fig6-revolute-arm", "field-humanoid-fig3", "field-humanoid-fig6a", "field-humanoid-fig6b", "field-humanoid-fig6c",
]  # fmt: skip


def between(points, count=4):
    s = np.linspace(0, 1, count, endpoint=False)[:, None, None]
    return (points[:-1] + s * np.diff(points, axis=0)).reshape(-1, points.shape[1])


@pytest.mark.parametrize("name", POINTS)
def test_library_scenes_of_balls(name):
    scene = Scene.load(name)
    found = plan(scene)
    assert found.solved, found.reason
    assert found.certificate.certified and found.certificate.clearance >= scene.options.clearance
    path = found.trajectory
    np.testing.assert_allclose(path.positions[0], scene.start.position, atol=1e-12)
    np.testing.assert_allclose(path.positions[-1], scene.goal.position, atol=scene.options.goal_tolerance)
    assert np.linalg.norm(path.velocities, axis=1).max() <= scene.robot.max_speed * (1 + 1e-9)
    dense = between(path.positions)
    for shape in scene.obstacles:
        if hasattr(shape, "radius") and hasattr(shape, "center") and not hasattr(shape, "lobes"):
            gap = np.linalg.norm(dense - shape.center, axis=1).min() - shape.radius - scene.robot.radius
            assert gap >= scene.options.clearance - 1e-12


UNICYCLE = """
horosphere/scene: 1
robot: {type: unicycle, radius: 0.1}
start: {position: [-2, 0], heading: 1.0}
goal: {position: [2, 0.2], heading: 0.0}
obstacles:
  - {type: disk, center: [0, 0.1], radius: 0.5}
  - {type: disk, center: [1, -0.8], radius: 0.3}
options: {clearance: 0.05}
"""


def test_unicycle_drives_and_turns_to_the_goal(tmp_path):
    (tmp_path / "drive.yaml").write_text(UNICYCLE)
    scene = Scene.load(tmp_path / "drive.yaml")
    found = plan(scene)
    assert found.solved, found.reason
    poses, time = found.trajectory.positions, found.trajectory.time
    assert np.abs(poses[-1] - [2, 0.2, 0.0]).max() < 1e-5
    for disk in scene.obstacles:
        assert np.linalg.norm(between(poses)[:, :2] - disk.center, axis=1).min() - disk.radius - 0.1 >= 0.05 - 1e-12
    step, dt = np.diff(poses, axis=0), np.diff(time)
    assert (np.linalg.norm(step[:, :2], axis=1) / dt).max() <= scene.robot.max_speed * (1 + 1e-6)
    assert (np.abs(step[:, 2]) / dt).max() <= scene.robot.max_turn_rate * (1 + 1e-6)
    moving = np.linalg.norm(step[:, :2], axis=1) > 1e-4  # it rolls along its heading: no sideways slip
    along = 0.5 * (poses[1:, 2] + poses[:-1, 2])
    slip = np.abs(step[:, 1] * np.cos(along) - step[:, 0] * np.sin(along))
    assert slip[moving].max() < 1e-3 * np.linalg.norm(step[:, :2], axis=1).max() + 1e-6


def test_goal_in_an_obstacle_is_a_reason(tmp_path):
    (tmp_path / "drive.yaml").write_text(UNICYCLE.replace("center: [0, 0.1]", "center: [1.9, 0.1]"))
    found = plan(Scene.load(tmp_path / "drive.yaml"))
    assert not found.solved and found.trajectory is None and "goal" in found.reason


@pytest.mark.parametrize("name", ["snake-gap", "snake-slalom", "snake-park"])
def test_snakes_arrive_with_their_certificate(name):
    found = plan(Scene.load(name))
    assert found.solved, found.reason
    assert found.certificate.certified and found.certificate.goal_error < 1e-6
