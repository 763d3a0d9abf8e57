"""A plan and its certificate among a million points: load, index, plan, certify, with memory.

python benchmarks/cloud.py [POINTS [FOLDER]]     writes points.npy and scene.yaml into FOLDER (default: a temporary one)
"""

from __future__ import annotations

import resource
import sys
import tempfile
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

import horosphere as hs
from horosphere import certify, distance, planning
from horosphere.shapes import Box

SCENE = """horosphere/scene: 1
name: cloud-shelf
description: |
  A Panda moves its hand from beside a shelf into it; table, shelf and the box in it are there as points only.
robot: panda
start: {joints_deg: [-60, 0, 0, -120, 0, 120, 45]}
goal: {position: [0.60, 0.12, 0.47], rpy_deg: [0, 90, 0]}
obstacles:
  - {type: points, name: shelf, file: points.npy, radius: 0.002}
options: {clearance: 0.01}
"""
BOXES = (  # centre, half sizes
    ((0.60, 0.0, 0.06), (0.35, 0.70, 0.02)),  # table
    ((0.72, 0.0, 0.30), (0.14, 0.40, 0.01)),  # boards
    ((0.72, 0.0, 0.66), (0.14, 0.40, 0.01)),
    ((0.72, 0.0, 0.98), (0.14, 0.40, 0.01)),
    ((0.72, -0.41, 0.53), (0.14, 0.01, 0.45)),  # sides
    ((0.72, 0.41, 0.53), (0.14, 0.01, 0.45)),
    ((0.87, 0.0, 0.53), (0.01, 0.42, 0.45)),  # back
    ((0.72, -0.18, 0.40), (0.08, 0.09, 0.08)),  # a box on the lower board
)


def cloud(count: int, seed: int = 1) -> np.ndarray:
    """Points (count, 3) spread evenly over the surfaces of the boxes, with 0.5 mm of noise."""
    rng = np.random.default_rng(seed)
    faces = []
    for centre, half in BOXES:
        for axis in range(3):
            for side in (-1.0, 1.0):
                i, j = (k for k in range(3) if k != axis)
                faces.append((np.array(centre), np.array(half), axis, side, half[i] * half[j]))
    area = np.array([face[4] for face in faces])
    which = rng.choice(len(faces), count, p=area / area.sum())
    points = np.empty((count, 3))
    for k, (centre, half, axis, side, _) in enumerate(faces):
        own = which == k
        local = rng.uniform(-1.0, 1.0, (int(own.sum()), 3))
        local[:, axis] = side
        points[own] = centre + local * half
    return points + 0.0005 * rng.normal(size=points.shape)


def memory() -> float:
    """Largest resident memory so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


class Step:
    """Prints what a step took: seconds of CPU, of the clock, memory afterwards."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __enter__(self) -> Step:
        self.wall, self.cpu = perf_counter(), process_time()
        return self

    def __exit__(self, *_: object) -> None:
        cpu, wall = process_time() - self.cpu, perf_counter() - self.wall
        print(f"{self.name:34s} {cpu:8.3f} s CPU {wall:8.3f} s {memory():8.0f} MB")


def main(count: int, folder: Path) -> None:
    """One scene of `count` points, and the same solids as boxes for comparison."""
    np.save(folder / "points.npy", cloud(count))
    (folder / "scene.yaml").write_text(SCENE)
    few = tuple(Box(centre, np.array(half) + 0.002) for centre, half in BOXES)
    scene = hs.Scene.load("panda-table")
    planning.plan(scene)  # compiles what does not belong to clouds
    print(f"{count} points, {folder / 'scene.yaml'}; before: {memory():.0f} MB")
    with Step("load the scene"):
        scene = hs.Scene.load(folder / "scene.yaml")
    with Step("index the cloud"):
        distance.pack_obstacles(scene.obstacles)
    with Step("plan and certificate"):
        plan = planning.plan(scene)
    print(f"  {plan.reason}; by {plan.solved_by}; " + ", ".join(f"{k} {v:.3f} s" for k, v in plan.timings.items()))
    if plan.trajectory is None:
        return
    for name, obstacles in (("certificate, points", scene.obstacles), ("certificate, boxes", few)):
        with Step(name):
            bound = certify.clearance_bound(scene.robot, plan.trajectory.positions, obstacles, 0.01, static=False)
        print(f"  {1e3 * bound.lower:.2f} to {1e3 * bound.upper:.2f} mm, {bound.evaluations} configurations")
    q = plan.trajectory.positions
    with Step(f"distance.signed, {len(q)} waypoints"):
        distance.signed(scene.robot, q, scene.obstacles, static=False)


if __name__ == "__main__":
    where = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(tempfile.mkdtemp())
    where.mkdir(parents=True, exist_ok=True)
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000, where)
