"""What `horosphere warmup` promises: afterwards nothing is compiled that it names."""

import json
import subprocess
import sys

AFTER = """
import numpy as np
from horosphere import kinematics, robots
from horosphere.control import Reactive
from horosphere.kernels import on_compile
from horosphere.planning import plan
from horosphere.scenes import Scene
from horosphere.shapes import Ball, Box, PointCloud

compiled = []
on_compile(compiled.append)
panda, q = robots.load("panda"), np.array([0.0, -0.6, 0.0, -2.2, 0.0, 1.8, 0.7])
ball, box, cloud = Ball([0.5, -0.3, 0.5], 0.1), Box([0.5, 0.4, 0.5], [0.1, 0.1, 0.1]), PointCloud(np.eye(3).repeat(40, 0), 0.01)
robot = panda.with_allowed(("panda_hand", "ball"))
loop = Reactive(robot, [Ball(ball.center, 0.1, name="ball"), box], goal=q + 0.2, obstacle_speed=0.1)
for goal in (None, kinematics.forward(panda, q)):
    loop.step(q, goal)
loop.step(q, obstacles=(np.array([[0.5, -0.3, 0.5]]), np.array([0.1])))
for name in ("panda", "iiwa14"):
    robot = robots.load(name)
    target = kinematics.forward(robot, np.clip(q, robot.limits.lower, robot.limits.upper))
    for obstacles in ([ball], [box], [box, cloud]):
        kinematics.free_arcs(robot, target, obstacles, 0.01)
        kinematics.roomiest(robot, target, obstacles, 0.01, self_clearance=0.0)
plan(Scene.load("humanoid-reach"))
print(compiled)
"""


def test_afterwards_nothing_is_compiled(run):
    data = json.loads(run("warmup", "--json").out)
    assert [*data["parts"]] == ["planning built-in scenes", "the live loop", "free arcs"]
    assert data["compiled"] >= sum(part["compiled"] for part in data["parts"].values())
    done = subprocess.run([sys.executable, "-c", AFTER], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"
