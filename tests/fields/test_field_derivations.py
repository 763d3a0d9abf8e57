"""The evidence scripts of the errata run through, and the revolute arm's ellipsoids hold its blocked configurations."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from horosphere.scenes import Scene

ROOT = Path(__file__).resolve().parents[2]
NAMES = ["charge", "weights", "sign", "joukowski", "liouville", "theorems"]


@pytest.mark.parametrize("name", NAMES)
def test_script_runs(name, capsys):
    runpy.run_path(str(ROOT / "derivations" / f"fields_{name}.py"), run_name="__main__")
    assert capsys.readouterr().out.count("\n") >= 3


def test_configuration_space_ellipsoids_hold_every_blocked_configuration():
    arm = runpy.run_path(str(ROOT / "derivations" / "fields_revolute_arm.py"))
    scene = Scene.load("rn-fig6-revolute-arm")
    q = np.random.default_rng(0).uniform(*arm["LIMITS"].T, (60_000, 3))
    blocked = q[arm["clearance"](q) < 0.0]
    assert len(blocked) > 500 and len(scene.obstacles) == 3
    depth = np.min([shape.signed_distance(blocked) for shape in scene.obstacles], axis=0)
    assert depth.max() < 0.0


def test_the_arm_moves_clear_of_the_cylinders():
    from horosphere.fields import HarmonicField

    arm = runpy.run_path(str(ROOT / "derivations" / "fields_revolute_arm.py"))
    scene = Scene.load("rn-fig6-revolute-arm")
    path = HarmonicField(scene.goal.position, scene.obstacles, margin=0.01).trace(scene.start.position, step=0.02)
    assert path.reached and arm["clearance"](path.points).min() > 0.02
    low, high = arm["LIMITS"].T
    assert (path.points >= low).all() and (path.points <= high).all()
