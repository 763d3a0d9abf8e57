"""Clearance and distance to the goal, by plain geometry."""

import numpy as np
import pytest

import horosphere.scenes as sc
from horosphere import kinematics, shapes
from horosphere.viewer import measure, summarise


def test_point_robot():
    scene = sc.Scene(
        robot=sc.PointRobot(3, 0.1), start=[0, 0, 0], goal=[2, 0, 0], obstacles=[shapes.Ball([1, 1, 0], 0.3)]
    )
    m = measure(scene, sc.Trajectory([0, 2], [[0, 0, 0], [2, 0, 0]]))
    np.testing.assert_allclose(m.to_goal, 2 - m.q[:, 0], atol=1e-12)
    np.testing.assert_allclose(m.clearance, np.hypot(m.q[:, 0] - 1, 1) - 0.4, atol=1e-12)


def test_plane_figures_by_dense_sampling():
    rng = np.random.default_rng(0)
    star = sc.Star([0, 0], 1.0, 5, 0.3, 0.2)
    scene = sc.Scene(robot=sc.PointRobot(2), start=[-3, 0], goal=[3, 0], obstacles=[star])
    x = rng.uniform(-2, 2, (200, 2))
    from horosphere.viewer._measure import clearance

    found = clearance(scene, x)
    t = np.linspace(0, 2 * np.pi, 20001)
    curve = (1 + 0.3 * np.cos(5 * (t - 0.2)))[:, None] * np.stack([np.cos(t), np.sin(t)], axis=1)
    dense = np.linalg.norm(x[:, None] - curve[None], axis=2).min(axis=1)
    r, phi = np.hypot(*x.T), np.arctan2(x[:, 1], x[:, 0])
    inside = r < 1 + 0.3 * np.cos(5 * (phi - 0.2))
    np.testing.assert_allclose(found, np.where(inside, -dense, dense), atol=2e-4)


@pytest.mark.parametrize(
    ("goal", "expected"),
    [
        (sc.PositionTarget([0.1, 0.2, 0.3]), lambda p: np.linalg.norm(p - [0.1, 0.2, 0.3])),
        (sc.LineTarget([0, 0, 1], [0, 2, 0]), lambda p: np.hypot(p[0], p[2] - 1)),
        (sc.PlaneTarget([0, 0, 2], 1.0), lambda p: abs(p[2] - 0.5)),
    ],
)
def test_arm(goal, expected):
    scene = sc.Scene(robot="humanoid-arm", start=np.zeros(5), goal=goal)
    q = np.array([0.3, 0.5, 0.4, -0.2, 0.1])
    m = measure(scene, sc.Trajectory([0, 1], [np.zeros(5), q]))
    tool = kinematics.forward(scene.robot, q).as_matrix()[:3, 3]
    np.testing.assert_allclose(m.tool[-1], tool, atol=1e-12)
    assert m.to_goal[-1] == pytest.approx(expected(tool))
    assert m.clearance is None


def test_summary_says_what_was_used():
    scene = sc.Scene.load("humanoid-reach")
    trajectory = sc.Trajectory([0, 1], [np.zeros(5), np.full(5, 0.1)])
    summary = summarise(scene, trajectory, measure(scene, trajectory), solved=False, reason="no way at point 3")
    rows = dict(summary.rows)
    assert not summary.good and summary.verdict == "Not solved: no way at point 3"
    assert rows["Collision model"].startswith("3 capsules on 3 links")
    assert rows["Largest step"].startswith("5.73 degrees")
    assert rows["Obstacles"] == "1 ball"
