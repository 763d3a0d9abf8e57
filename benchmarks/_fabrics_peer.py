"""The package `fabrics` on planar worlds of discs, run by `benchmarks/fields.py fabrics` in an environment of its own.

It wants numpy below 2, which horosphere cannot have: `python -m venv DIR && DIR/bin/pip install fabrics`, then
FABRICS_PYTHON=DIR/bin/python. Reads an NPZ of worlds, prints one JSON row a world. A point with two sliding joints, the default
geometries and energies of the package (0.10).
"""

import json
import logging
import sys
import time

import numpy as np
from fabrics.planner.parameterized_planner import ParameterizedFabricPlanner
from forwardkinematics.urdfFks.generic_urdf_fk import GenericURDFFk
from mpscenes.goals.goal_composition import GoalComposition

logging.disable(logging.WARNING)
POINT = """<robot name="point"><link name="world"/><link name="slide"/><link name="body"/>
<joint name="x" type="prismatic"><parent link="world"/><child link="slide"/><origin xyz="0 0 0" rpy="0 0 0"/><axis xyz="1 0 0"/>
<limit lower="-20" upper="20" effort="100" velocity="10"/></joint>
<joint name="y" type="prismatic"><parent link="slide"/><child link="body"/><origin xyz="0 0 0" rpy="0 0 0"/><axis xyz="0 1 0"/>
<limit lower="-20" upper="20" effort="100" velocity="10"/></joint></robot>"""
BODY = 1e-3  # metres: the packages's bodies are balls


def planner(count, goal):
    made = ParameterizedFabricPlanner(2, GenericURDFFk(POINT, root_link="world", end_links=["body"]))
    made.set_components(collision_links=["body"], goal=goal, number_obstacles=count)
    made.concretize()
    return made


def goal_at(position):
    return GoalComposition(
        name="goal",
        content_dict={
            "subgoal0": {
                "weight": 1.0,
                "is_primary_goal": True,
                "indices": [0, 1],
                "parent_link": "world",
                "child_link": "body",
                "desired_position": list(map(float, position)),
                "epsilon": 0.05,
                "type": "staticSubGoal",
            }
        },
    )


def run(made, start, goal, centers, radii, period=0.01, most=6000):
    """Accelerations held for `period` seconds; reached within 5 cm."""
    obstacles = {}
    for k, (c, r) in enumerate(zip(centers, radii)):
        obstacles |= {f"x_obst_{k}": np.r_[c, 0.0], f"radius_obst_{k}": np.array([r])}
    q, v, points, spent = start.copy(), np.zeros(2), [start.copy()], 0.0
    for _ in range(most):
        if np.linalg.norm(q - goal) < 0.05:
            break
        begin = time.perf_counter()
        a = made.compute_action(
            q=q, qdot=v, x_goal_0=goal, weight_goal_0=1.0, radius_body_body=np.array([BODY]), **obstacles
        )
        spent += time.perf_counter() - begin
        q, v = q + period * v + 0.5 * period**2 * a, v + period * a
        points.append(q.copy())
    x = np.array(points)
    clear = float((np.linalg.norm(x[:, None] - centers, axis=2) - radii).min())
    return {
        "reached": bool(np.linalg.norm(q - goal) < 0.05),
        "clearance": clear,
        "ratio": float(np.linalg.norm(np.diff(x, axis=0), axis=1).sum() / np.linalg.norm(start - goal)),
        "us": 1e6 * spent / max(len(x) - 1, 1),
    }


if __name__ == "__main__":
    worlds = np.load(sys.argv[1])
    began = time.perf_counter()
    made = planner(worlds["centers"].shape[1], goal_at(worlds["goal"][0]))
    print(json.dumps({"build": time.perf_counter() - began}), flush=True)
    for row in zip(worlds["start"], worlds["goal"], worlds["centers"], worlds["radii"]):
        print(json.dumps(run(made, *row)), flush=True)
