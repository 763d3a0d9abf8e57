"""Time of one step of the live loop: the Panda among 20 obstacles that all may move, inside compiled code and from Python.

python benchmarks/reactive.py [URDF with spheres] [tip]
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from _harness import heading

from horosphere import distance, robots
from horosphere.control import Reactive
from horosphere.kernels import jit
from horosphere.shapes import Ball, Box

ROOT = Path(__file__).resolve().parent.parent
HOME = np.array([0.0, -0.6, 0.0, -2.2, 0.0, 1.8, 0.7])


def obstacles(robot: robots.Robot, rng: np.random.Generator, count: int, boxes: bool) -> list:
    """Balls (or balls and boxes in turn) about the arm, 4 cm off its home posture at least."""
    found: list = []
    while len(found) < count:
        c = rng.uniform([-0.7, -0.7, 0.1], [0.7, 0.7, 1.0])
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        solid = Box(c, rng.uniform(0.03, 0.1, 3), turn) if boxes and len(found) % 2 else Ball(c, rng.uniform(0.03, 0.1))
        if distance.signed(robot, HOME, [solid]) > 0.04:
            found.append(solid)
    return found


def main() -> None:
    from horosphere.control._reactive_kernels import step_into

    heading()
    file = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT.parent / "shared" / "data" / "panda_spheres.urdf"
    if file.is_file():
        robot = robots.load(file, tip=sys.argv[2] if len(sys.argv) > 2 else "panda_grasptarget")
    else:
        robot = robots.load("panda")
    rng = np.random.default_rng(0)
    print(f"{robot.name}: {len(robot.capsules)} bodies, {len(robot.self_pairs)} link pairs; 1 ms period")
    for boxes in (False, True):
        for speed in (0.0, 0.1):
            loop = Reactive(robot, obstacles(robot, rng, 20, boxes), goal=HOME, obstacle_speed=speed)
            states, calls, whole, sizes = [], [], [], []
            q = HOME
            lower, upper = np.maximum(robot.limits.lower, -3), np.minimum(robot.limits.upper, 3)
            for k in range(6000):
                if k % 1500 == 0:
                    loop.set_goal(rng.uniform(lower, upper))
                states.append((q, loop._dq, loop._expected, loop._goal_buffer.copy()))
                started = time.perf_counter()
                step = loop.step(q)
                whole.append(time.perf_counter() - started)
                q = step.q_next
            arm = loop._arm
            for q, before, expected, goal in states[::10]:
                fixed = (
                    *arm[:6],
                    loop._solids.rows,
                    loop._speeds,
                    loop._velocities,
                    loop._contacts,
                    arm.G,
                    arm.P,
                    loop._limits,
                    loop._par,
                    goal,
                    loop._posture,
                    arm.tool,
                )
                out = loop._out
                if not calls:
                    repeat(step_into, fixed, q, before, expected, loop._work, out)
                runs = []
                for _ in range(5):  # the machine is shared: the best of five
                    started = time.perf_counter()
                    repeat(step_into, fixed, q, before, expected, loop._work, out)
                    runs.append((time.perf_counter() - started) / REPEAT)
                calls.append(min(runs))
                sizes.append(out[-2:].copy())
            name = "balls and boxes" if boxes else "balls"
            print(
                f"  20 {name}, {speed:g} m/s: compiled {np.median(calls) * 1e6:5.1f} us median, "
                f"{np.percentile(calls, 99) * 1e6:5.1f} p99; step() {np.median(whole) * 1e6:5.1f} us median, "
                f"{np.percentile(whole, 99) * 1e6:5.1f} p99; "
                f"{np.mean(sizes, axis=0)[0]:.0f} pairs, {np.mean(sizes, axis=0)[1]:.0f} rows"
            )


REPEAT = 10


@jit
def _repeat(step, fixed, q, before, expected, work, out):
    for _ in range(10):
        step(*fixed, q, before, expected, *work, out)


def repeat(step, fixed, q, before, expected, work, out):
    """The same step ten times inside compiled code."""
    _repeat(step, fixed, q, before, expected, work, out)


if __name__ == "__main__":
    main()
