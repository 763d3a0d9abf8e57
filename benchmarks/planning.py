"""Planning on MotionBenchMaker (Panda): our tree planner beside OMPL's RRT-Connect, on the same problems in one run.

    python benchmarks/planning.py [--set DATA/mbm_panda_problems.tar.bz2] [--each 10]

Needs ompl, pinocchio (pin) and coal for the comparison; without them only our figures are printed. OMPL runs with its own
default range and simplification, and with two checkers: ours (one compiled call a state, from Python) and coal through
Pinocchio (one C++ call a state, from Python). Both are called from Python, some 10 us a state: a planner whose checker is
C++ too takes about 3 ms on this set. A dense check in numpy, 300 configurations a radian, judges every path.
"""

import argparse
import os
import platform
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from horosphere import robots
from horosphere.planning._edge_kernels import SAMPLED
from horosphere.planning._sampled import sampled_clearance
from horosphere.planning._tree import Search, connect
from horosphere.planning._tree_space import COVER, Space
from horosphere.scenes._moveit_files import read_moveit_set
from horosphere.shapes import Box

DATA = Path(os.environ.get("HOROSPHERE_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data")
PUBLISHED = (
    (
        "VAMP (C++, SIMD; arXiv:2309.14545)",
        "planning 0.054 ms median, 0.18 ms mean on this set, without a certificate",
    ),
    (
        "cuRobo 0.7.6 (GPU RTX 6000 Ada; curobo.org/get_started/4_benchmarks.html, 22 November 2024)",
        "31 ms median, 42 ms mean for 800 MotionBenchMaker problems (pose goals, timed minimum-jerk motions)",
    ),
)


def ours(robot, problem):
    start, goal = problem.start_of(robot), problem.goal_of(robot).q
    runs = []
    for _ in range(3):
        begin = time.perf_counter()
        result = connect(robot, start, goal, problem.obstacles)
        runs.append((sum(result.timings[p] for p in ("grow", "simplify", "certify")), time.perf_counter() - begin))
    inner, wall = min(runs)
    return (result.waypoints if result.solved else None), inner, wall


def our_checker(robot, problem):
    """One configuration at a time by the compiled check."""
    from horosphere.kernels import jit
    from horosphere.planning._packet_kernels import check_edge

    start = problem.start_of(robot)
    space = Space(Search(robot, start, problem.goal_of(robot).q[None], problem.obstacles, 0.0, 0.0, 0), COVER[0]).pack()
    zero = np.zeros(robot.n_joints, np.float32)
    margins = space.margins(0.0, 0.0)

    @jit
    def check(packet, q, v, margin, self_margin):
        return check_edge(packet, q, v, np.int64(1), np.int64(SAMPLED), margin, self_margin)

    global _CHECK
    _CHECK = _CHECK or check
    return lambda q: _CHECK(space.packet, np.asarray(q, np.float32), zero, *margins) == 1


_CHECK = None


def coal_checker(robot, problem, urdf):
    """The same spheres, pairs and obstacles in Pinocchio's geometry model, tested by coal."""
    import coal
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(urdf))
    geometry = pin.buildGeomFromUrdf(model, str(urdf), pin.GeometryType.COLLISION)
    links = {}
    for k, item in enumerate(geometry.geometryObjects):
        links.setdefault(item.name.rsplit("_", 1)[0], []).append(k)
    for i, j in robot.self_pairs:
        for a in links.get(robot.link_names[i], ()):
            for b in links.get(robot.link_names[j], ()):
                geometry.addCollisionPair(pin.CollisionPair(a, b))
    count = len(geometry.geometryObjects)
    for k, shape in enumerate(problem.obstacles):
        if isinstance(shape, Box):
            solid, pose = coal.Box(*(2.0 * shape.half_sizes)), pin.SE3(np.array(shape.rotation), np.array(shape.center))
        else:
            axis = shape.b - shape.a
            solid = coal.Cylinder(shape.radius, float(np.linalg.norm(axis)))
            turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0, 1]), axis / np.linalg.norm(axis)).matrix()
            pose = pin.SE3(turn, 0.5 * (shape.a + shape.b))
        index = geometry.addGeometryObject(pin.GeometryObject(f"obstacle{k}", 0, pose, solid))
        for a in range(count):
            geometry.addCollisionPair(pin.CollisionPair(a, index))
    data, geometry_data = model.createData(), pin.GeometryData(geometry)
    return lambda q: not pin.computeCollisions(model, data, geometry, geometry_data, np.asarray(q), True)


def with_ompl(robot, problem, valid, limit=10.0):
    from ompl import base as ob
    from ompl import geometric as og

    n = robot.n_joints
    space = ob.RealVectorStateSpace(n)
    bounds = ob.RealVectorBounds(n)
    for j in range(n):
        bounds.setLow(j, float(robot.limits.lower[j]))
        bounds.setHigh(j, float(robot.limits.upper[j]))
    space.setBounds(bounds)
    space.setLongestValidSegmentFraction(1.0 / 32.0 / space.getMaximumExtent())  # 32 states a radian, as ours
    setup = og.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: valid([state[j] for j in range(n)]))
    start, goal = space.allocState(), space.allocState()
    for state, q in ((start, problem.start_of(robot)), (goal, problem.goal_of(robot).q)):
        for j in range(n):
            state[j] = float(q[j])
    setup.setStartAndGoalStates(start, goal)
    setup.setPlanner(og.RRTConnect(setup.getSpaceInformation()))
    begin = time.perf_counter()
    if not setup.solve(limit) or not setup.haveExactSolutionPath():
        return None, 0.0, 0.0
    planned = time.perf_counter() - begin
    setup.simplifySolution()
    total = time.perf_counter() - begin
    states = setup.getSolutionPath().getStates()
    return np.array([[state[j] for j in range(n)] for state in states]), total, planned


def hardware():
    name = platform.processor()
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").is_file() else ():
        if line.startswith("model name"):
            name = line.split(":", 1)[1].strip()
            break
    parts = []
    for package in ("horosphere", "numba", "ompl", "pin", "coal"):
        try:
            parts.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            parts.append(f"{package} -")
    return f"{name}, load {os.getloadavg()[0]:.1f}; Python {platform.python_version()}, {', '.join(parts)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--set", default=DATA / "mbm_panda_problems.tar.bz2")
    parser.add_argument("--robot", default=DATA / "panda_spheres.urdf")
    parser.add_argument("--tip", default="panda_hand")
    parser.add_argument("--each", type=int, default=10, help="problems of each set")
    arguments = parser.parse_args()
    robot = robots.load(arguments.robot, tip=arguments.tip)
    taken, problems = {}, []
    for name, problem in read_moveit_set(arguments.set):
        taken[name] = taken.get(name, 0) + 1
        if taken[name] <= arguments.each:
            problems.append((name, problem))
    methods = {"horosphere": lambda p: ours(robot, p)}
    try:
        from ompl import util

        util.setLogLevel(util.LogLevel.LOG_ERROR)
        methods["OMPL RRT-Connect, our checker"] = lambda p: with_ompl(robot, p, our_checker(robot, p))
        import coal  # noqa: F401
        import pinocchio  # noqa: F401

        methods["OMPL RRT-Connect, coal"] = lambda p: with_ompl(robot, p, coal_checker(robot, p, arguments.robot))
    except ImportError as error:
        print(f"not compared with all: {error}")
    print(hardware())
    print(f"{len(problems)} problems; times in ms: planning + simplification (ours: + certificate)")
    print(f"{'':32s}{'solved':>7s}{'median':>10s}{'mean':>10s}{'p95':>10s}{'ratio':>8s}{'length':>8s}{'touching':>9s}")
    base = None
    for label, method in methods.items():
        times, lengths, touching, solved = [], [], 0, 0
        method(problems[0][1])  # compile, load
        for _, problem in problems:
            path, total, _ = method(problem)
            if path is None:
                continue
            solved += 1
            times.append(1e3 * total)
            lengths.append(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
            touching += min(sampled_clearance(robot, path, problem.obstacles, 300.0)) < 0.0
        base = base or float(np.median(times))
        print(
            f"{label:32s}{solved:7d}{np.median(times):10.3f}{np.mean(times):10.3f}{np.percentile(times, 95):10.3f}"
            f"{np.median(times) / base:8.1f}{np.median(lengths):8.2f}{touching:9d}"
        )
    for label, figures in PUBLISHED:
        print(f"as published, not run here: {label}: {figures}")


if __name__ == "__main__":
    main()
