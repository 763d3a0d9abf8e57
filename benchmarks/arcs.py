"""Free arcs of random targets: python benchmarks/arcs.py [targets an arm, default 20].

CPU milliseconds of one call among 20 balls, among nine obstacles of all kinds, with the robot's own links, and of the choice of
the roomiest value (best of three runs of each target; median and largest over the targets). Then the witness: samples every
1e-3 rad that are said to be free and are not, and the share of those free by 1e-3 (rad and m) that no arc holds.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from _harness import heading

from horosphere.distance import signed
from horosphere.kinematics import free_arcs, roomiest
from horosphere.shapes import Ball

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "kinematics"))
from arc_cases import CASES, every_kind, target_of, witnessed

CLEARANCE = 0.01


def timed(call, jobs) -> str:
    """Median and largest CPU milliseconds over the jobs."""
    best = []
    for job in jobs:
        call(*job)
        runs = []
        for _ in range(3):
            started = time.process_time()
            call(*job)
            runs.append(1e3 * (time.process_time() - started))
        best.append(min(runs))
    return f"{np.median(best):9.1f}{max(best):7.1f}"


def line(name: str, count: int) -> str:
    robot, parameter = CASES[name]()
    rng = np.random.default_rng(5)
    jobs = []
    for _ in range(count):
        q = rng.uniform(robot.limits.lower, robot.limits.upper)
        balls = [Ball(rng.uniform([-0.8, -0.8, 0], [0.8, 0.8, 1.0]), rng.uniform(0.03, 0.08)) for _ in range(20)]
        # what touches here may stand still with the tool, and then there is nothing to do
        some = [
            [o for o in kind if signed(robot, q, [o], static=False) > CLEARANCE] for kind in (balls, every_kind(rng))
        ]
        jobs.append((target_of(robot, q, rng), *some))
    text = timed(lambda target, balls, _: free_arcs(robot, target, balls, CLEARANCE), jobs)
    text += timed(lambda target, _, kinds: free_arcs(robot, target, kinds, CLEARANCE), jobs)
    text += timed(lambda target, _, kinds: free_arcs(robot, target, kinds, CLEARANCE, self_clearance=0.0), jobs)
    text += timed(lambda target, _, kinds: roomiest(robot, target, kinds, CLEARANCE), jobs)
    values, total = np.arange(-np.pi + 1e-9, np.pi, 1e-3), np.zeros(3, int)
    for target, _, kinds in jobs:
        arcs = free_arcs(robot, target, kinds, CLEARANCE)
        total += witnessed(robot, parameter, target, kinds, arcs, values, CLEARANCE, margin=1e-3)
    return f"{name:14s}{text}{total[0]:8d}{total[1] - total[2]:7d} of {total[1]}"


if __name__ == "__main__":
    heading()
    print("CPU ms, median and largest; samples")
    heads = ("20 balls", "all kinds", "and own links", "roomiest")
    print(" " * 14 + "".join(f"{head:>16s}" for head in heads) + f"{'false':>8s}{'left out':>10s}")
    for name in CASES:
        print(line(name, int(sys.argv[1]) if len(sys.argv) > 1 else 20), flush=True)
