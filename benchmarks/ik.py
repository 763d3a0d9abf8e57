"""Inverse kinematics side by side with peers: python benchmarks/ik.py (peers that are not installed are left out)."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

import numpy as np
from _harness import compare, heading

from horosphere import kinematics, robots


def panda():
    """The Panda of the shared data folder, or None."""
    root = Path(__file__).resolve().parent.parent
    path = Path(os.environ.get("HOROSPHERE_DATA", root.parent / "shared" / "data")) / "panda_spheres.urdf"
    return robots.load(path, tip="panda_link8") if path.exists() else None


def main() -> None:
    """Print the tables."""
    heading(*(name for name in ("ssik", "eaik", "roboticstoolbox", "pytracik") if importlib.util.find_spec(name)))
    rng = np.random.default_rng(0)
    humanoid = robots.humanoid_arm()
    path = np.linspace([0.33, 0.0, 0.31], [0.41, 0.07, -0.32], 100)
    one = kinematics.GripperOnPlane(path[0], [0, 1, 0])
    many = kinematics.GripperOnPlane(path[:, None], [0, 1, 0])
    phi = np.linspace(-np.pi, np.pi, 72, endpoint=False)
    compare("humanoid arm, 8 branches, one target", {"inverse": lambda: kinematics.inverse(humanoid, one, phi=0.3)})
    compare(
        "humanoid arm, 8 branches, 100 points x 72 phi, per target",
        {"inverse": lambda: kinematics.inverse(humanoid, many, phi=phi)}, items=7200,
    )  # fmt: skip
    for arm in (robots.srs_arm(), robots.six_axis_arm()):
        q = rng.uniform(-np.pi, np.pi, (10_000, arm.n_joints))
        poses = kinematics.forward(arm, q)
        single = kinematics.forward(arm, q[0])
        compare(f"{arm.name}, 8 branches, one pose", {"inverse": lambda a=arm, p=single: kinematics.inverse(a, p)})
        compare(
            f"{arm.name}, 8 branches, 10,000 poses, per pose",
            {"inverse": lambda a=arm, p=poses: kinematics.inverse(a, p)}, items=10_000,
        )  # fmt: skip
    robot = panda()
    if robot is None:
        print("\nno Panda: set HOROSPHERE_DATA to the folder with panda_spheres.urdf")
        return
    q = rng.uniform(robot.limits.lower, robot.limits.upper, (10_000, 7))
    poses, single, q7 = kinematics.forward(robot, q), kinematics.forward(robot, q[0]), q[:, 6].copy()
    compare(
        "Panda, one pose",
        {
            "all 8 branches at a given q7": lambda: kinematics.inverse(robot, single, q7=0.3),
            "best q7 of every branch": lambda: kinematics.inverse(robot, single),
            "numerical, one solution": lambda: kinematics.inverse(robot, single, closed_form=False),
        },
    )
    compare(
        "Panda, 8 branches at given q7, 10,000 poses, per pose",
        {"inverse": lambda: kinematics.inverse(robot, poses, q7=q7)}, items=10_000,
    )  # fmt: skip


if __name__ == "__main__":
    main()
