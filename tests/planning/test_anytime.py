"""What the time after the first certified plan brings: never worse, certified, the same again."""

import numpy as np
import pytest

from horosphere import robots
from horosphere.errors import InputError
from horosphere.planning import _reactive, plan
from horosphere.scenes import JointTarget, Options, Scene
from horosphere.shapes import Ball, Box

from ._dense import clearances

HOME = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])


def scene(seed, **options):
    """A Panda that goes round a wall between start and goal, and balls about."""
    rng = np.random.default_rng(seed)
    start, goal = HOME.copy(), HOME.copy()
    start[0], goal[0] = 1.1, -1.1
    balls = [
        Ball(c, 0.06, name=f"ball {k}") for k, c in enumerate(rng.uniform([0.3, -0.9, 0.9], [0.9, 0.9, 1.2], (4, 3)))
    ]
    wall = Box([0.55, 0.0, 0.4], [0.2, 0.02, 0.4], name="wall")
    return Scene(
        robots.load("panda"), JointTarget(start), JointTarget(goal), (wall, *balls), name=f"wall {seed}",
        options=Options(**{"method": "tree", "clearance": 0.01, "improvement_time": 60.0, "seed": seed, **options}),
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(3))
def test_never_worse_certified_and_the_same_again(seed):
    problem = scene(seed)
    first, better = plan(problem, improvement_time=0.0), plan(problem)
    assert first.solved and better.solved and first.improvement is None
    gain = better.improvement
    assert gain is not None and gain.converged and gain.rounds > 0
    lengths = [np.linalg.norm(np.diff(p.trajectory.positions, axis=0), axis=1).sum() for p in (first, better)]
    assert gain.first_length == pytest.approx(lengths[0]) and gain.length == pytest.approx(lengths[1])
    assert lengths[1] <= lengths[0] and better.trajectory.duration <= first.trajectory.duration
    assert better.certificate.certified and better.certificate.clearance >= first.certificate.clearance
    q = better.trajectory.positions
    dense = np.concatenate([a + np.linspace(0, 1, 5)[:, None] * (b - a) for a, b in zip(q, q[1:])])
    outer, inner = clearances(problem.robot, dense, problem.obstacles)
    assert outer.min() >= better.certificate.clearance - 1e-9 and inner.min() >= 0.0
    again = plan(problem)
    np.testing.assert_array_equal(again.trajectory.positions, q)


def test_something_is_gained():
    gains = [plan(scene(seed)).improvement for seed in (0, 1, 2)]
    assert sum(g.length < g.first_length for g in gains) >= 2
    assert sum(g.mean_clearance > g.first_mean_clearance for g in gains) >= 2


def test_the_time_is_kept_and_said():
    found = plan(scene(1, improvement_time=0.01))
    assert found.solved and not found.improvement.converged and found.improvement.seconds < 1.0
    assert any("all the time given" in note for note in found.notes)


def test_reactive_falls_back_only_when_asked(monkeypatch):
    problem = scene(0)
    assert plan(problem, method="reactive").solved_by == "reactive law"
    monkeypatch.setattr(_reactive, "RUNGS", (0.0,))  # none is tried: as if it were stuck
    alone = plan(problem, method="reactive")
    assert not alone.solved and alone.reason.startswith("reactive law: the reactive law got stuck")
    asked = plan(problem, method="reactive-or-tree")
    assert asked.solved_by == "joint-space tree" and any("got stuck" in note for note in asked.notes)
    with pytest.raises(InputError, match="unknown method"):
        plan(problem, method="reactiv")
