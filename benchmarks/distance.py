"""Times of distances and certificates, beside coal and pinocchio in the same run.

python benchmarks/distance.py
"""

from __future__ import annotations

import platform
import sys
import time
from collections.abc import Callable
from importlib.metadata import version

import numpy as np

from horosphere import certify, distance, robots
from horosphere.shapes import Ball, Box, Capsule, Cylinder, HalfSpace, Mesh, PointCloud, box_cover


def best(call: Callable[[], object], repeat: int = 7, least: float = 0.02) -> float:
    """Seconds a call, the best of several runs."""
    call()
    n, spent = 1, 0.0
    while spent < least:
        n *= 2
        start = time.perf_counter()
        for _ in range(n):
            call()
        spent = time.perf_counter() - start
    runs = []
    for _ in range(repeat):
        start = time.perf_counter()
        for _ in range(n):
            call()
        runs.append((time.perf_counter() - start) / n)
    return min(runs)


def coal_seconds(robot: robots.Robot, q: np.ndarray, obstacles: list) -> float | None:
    """The same minimum by coal, one pair after another, poses given: seconds a configuration."""
    try:
        import coal
    except ImportError:
        return None
    from horosphere.robots._placement import link_frames, move_points

    def upright(a, b):
        z = (b - a) / max(np.linalg.norm(b - a), 1e-300) if np.linalg.norm(b - a) > 0 else np.array([0.0, 0, 1])
        x = np.eye(3)[np.argmin(np.abs(z))]
        x = x - (x @ z) * z
        x /= np.linalg.norm(x)
        return coal.Transform3s(np.array([x, np.cross(z, x), z]).T, 0.5 * (a + b))

    frames, c = link_frames(robot.links, q), robot.capsules
    bodies = []
    for k, a, b, r in zip(c.link, c.a, c.b, c.radius):
        a, b = move_points(frames[k], a), move_points(frames[k], b)
        bodies.append((coal.Capsule(r, np.linalg.norm(b - a)), upright(a, b)))
    solids = []
    for s in obstacles:
        if isinstance(s, Ball):
            solids.append((coal.Sphere(s.radius), coal.Transform3s(np.eye(3), s.center)))
        elif isinstance(s, Box):
            solids.append((coal.Box(*(2 * s.half_sizes)), coal.Transform3s(s.rotation, s.center)))
        elif isinstance(s, HalfSpace):
            solids.append((coal.Halfspace(s.normal, s.distance), coal.Transform3s.Identity()))
        else:
            cls = coal.Capsule if isinstance(s, Capsule) else coal.Cylinder
            solids.append((cls(s.radius, np.linalg.norm(s.b - s.a)), upright(s.a, s.b)))
    request, result = coal.DistanceRequest(), coal.DistanceResult()

    def run():
        least = np.inf
        for shape, at in bodies:
            for other, there in solids:
                result.clear()
                least = min(least, coal.distance(shape, at, other, there, request, result))
        return least

    return best(run)


def main() -> None:
    print(f"python {sys.version.split()[0]}, numba {version('numba')}, {platform.processor() or platform.machine()}")
    rng = np.random.default_rng(0)
    robot = robots.humanoid_arm()
    obstacles = [
        Ball([0.33, 0.03, -0.03], 0.075),
        Box([0.5, 0.0, 0.4], [0.1, 0.2, 0.05]),
        HalfSpace([0, 1.0, 0], -0.4),
        Cylinder([0.4, -0.4, 0.3], [0.4, 0.2, 0.3], 0.05),
        Capsule([-0.4, 0.5, 0.0], [-0.4, 0.9, 0.2], 0.06),
    ]
    one, many = rng.normal(size=5), rng.normal(size=(10_000, 5))
    pairs = len(robot.capsules) * len(obstacles)
    print(f"humanoid arm, {len(robot.capsules)} capsules x {len(obstacles)} obstacles")
    single = best(lambda: distance.signed(robot, one, obstacles))
    batch = best(lambda: distance.signed(robot, many, obstacles), repeat=3) / len(many)
    slope = best(lambda: distance.signed(robot, many, obstacles, gradient=True), repeat=3) / len(many)
    print(f"  signed, single call          {single * 1e6:9.2f} us")
    print(f"  signed, batch                {batch * 1e6:9.2f} us a configuration, {batch / pairs * 1e9:.0f} ns a pair")
    print(f"  signed + gradient, batch     {slope * 1e6:9.2f} us a configuration")
    peer = coal_seconds(robot, one, obstacles)
    if peer is not None:
        print(f"  coal, pair by pair (Python)  {peer * 1e6:9.2f} us a configuration: ours in batch {peer / batch:.0f}x")
    path = np.linspace(np.zeros(5), [0.6, 0.9, 0.8, 0.3, 0.4], 40)
    bound = certify.clearance_bound(robot, path, obstacles, self_collision=True)
    seconds = best(lambda: certify.clearance_bound(robot, path, obstacles, self_collision=True))
    dense = distance.clearance(robot, np.linspace(path[:-1], path[1:], 200), obstacles).min()
    print(f"certificate, 40 waypoints      {seconds * 1e3:9.3f} ms, {bound.evaluations} configurations")
    print(f"  {bound.lower:.6f} <= least clearance <= {bound.upper:.6f} m; densely sampled {dense:.6f} m")
    meshes_and_clouds(robot, one, many)


def meshes_and_clouds(robot: robots.Robot, one: np.ndarray, many: np.ndarray) -> None:
    """A ring of 20,000 triangles beside coal, and a million points: how long they take to be made ready and to be asked."""
    import trimesh

    ring = trimesh.creation.torus(0.15, 0.04, major_sections=100, minor_sections=100)
    ring.apply_translation([0.35, 0.1, -0.1])

    def made():
        return Mesh(np.asarray(ring.vertices), np.asarray(ring.faces))

    def first(solid) -> float:
        start = time.perf_counter()
        distance.signed(robot, one, [solid])
        return time.perf_counter() - start

    distance.signed(robot, one, [made()])  # compiles
    mesh = made()
    print(f"ring of {len(mesh.faces)} triangles, {len(robot.capsules)} capsules")
    print(f"  made ready                   {first(mesh) * 1e3:9.0f} ms")
    for text, q in (("signed, batch", many[:1000]), ("signed + gradient, batch", many[:1000])):
        seconds = best(lambda q=q, g="grad" in text: distance.signed(robot, q, [mesh], gradient=g), repeat=3) / len(q)
        print(f"  {text:<29}{seconds * 1e6:9.2f} us a configuration")
    start = time.perf_counter()
    boxes, slack = box_cover(made())
    print(f"  {len(boxes)} boxes round it, slack {1e3 * slack:.0f} mm {(time.perf_counter() - start) * 1e3:9.0f} ms")
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-1.0, 1.0, (1_000_000, 2)), 0.05 * rng.normal(size=1_000_000) - 0.6])
    cloud = PointCloud(points, 0.003)
    print(f"cloud of {len(points)} points\n  made ready                   {first(cloud) * 1e3:9.0f} ms")
    seconds = best(lambda: distance.signed(robot, many[:1000], [cloud]), repeat=3) / 1000
    print(f"  signed, batch                {seconds * 1e6:9.2f} us a configuration")


if __name__ == "__main__":
    main()
