"""Products, exponentials and Panda kinematics against clifford, kingdon, gafro and pinocchio, in one run.

    python benchmarks/kernels.py [single | batch | panda]     # default: all

Needs the extra `bench`; peers that are not installed are left out. Ratios are the peer's time over ours: above 1 we are
faster. Medians of many short rounds, all contenders in turn. For a million elements a copy by numpy of as many bytes as the
kernel reads and writes runs beside it: the time that the memory alone takes. HOROSPHERE_DATA: a folder with the file
panda_spheres.urdf, whose chain then takes the place of the catalogue's Panda.
"""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path

import numpy as np
from _harness import compare, heading

import horosphere as hs
from horosphere.kinematics import forward, forward_and_jacobian, jacobian
from horosphere.versors import _kernels as ours


def optional(name: str):
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


clifford, kingdon, gafro, pinocchio = (optional(n) for n in ("clifford", "kingdon", "pygafro", "pinocchio"))
RNG = np.random.default_rng(0)
PANDA_LIMITS = np.array([[-2.9, -1.76, -2.9, -3.07, -2.9, 0.0, -2.9], [2.9, 1.76, 2.9, -0.07, 2.9, 3.75, 2.9]])


def motors(n: int) -> np.ndarray:
    return hs.Motor.exp(RNG.normal(size=(n, 6))).array


class Kingdon:
    """Arrays of coefficients are its batch. In G(4,1), our algebra, a motor has 12 orthonormal blades; in G(3,0,1), the
    smallest algebra with motors, it has 8 like ours: kingdon's best case, without points at infinity or spheres.
    """

    def __init__(self, n: int, conformal: bool) -> None:
        algebra = kingdon.Algebra(4, 1) if conformal else kingdon.Algebra(3, 0, 1)
        if conformal:
            keys = ("e", "e12", "e13", "e23", "e14", "e15", "e24", "e25", "e34", "e35", "e1234", "e1235")
            source = (0, 1, 2, 3, 4, 4, 5, 5, 6, 6, 7, 7)
            point, line = ("e1", "e2", "e3", "e4", "e5"), keys[1:10]
        else:
            keys, source = ("e", "e12", "e13", "e23", "e01", "e02", "e03", "e0123"), range(8)
            point, line = ("e012", "e013", "e023", "e123"), keys[1:7]

        def element(names, rows):
            return algebra.multivector(keys=names, values=[np.ascontiguousarray(row) for row in rows])

        self.a, self.b = (element(keys, motors(n).T[list(source)]) for _ in range(2))
        self.point = element(point, RNG.normal(size=(len(point), n)))
        self.line = element(line, RNG.normal(size=(len(line), n)))

    def product(self):
        return self.a * self.b

    def on_point(self):
        return self.a.sw(self.point)

    def on_line(self):
        return self.a.sw(self.line)


class Clifford:
    """One element at a time in G(4,1), the products compiled by numba inside clifford."""

    def __init__(self) -> None:
        layout, blades = clifford.Cl(4, 1)
        self.a, self.b = (
            clifford.MultiVector(layout, hs.Motor._wrap(m).as_multivector().coefficients) for m in motors(2)
        )
        x = RNG.normal(size=3)
        e0, ei = (blades["e5"] - blades["e4"]) / 2, blades["e4"] + blades["e5"]
        vector = x[0] * blades["e1"] + x[1] * blades["e2"] + x[2] * blades["e3"]
        self.point = vector + 0.5 * (x @ x) * ei + e0

    def product(self):
        return self.a * self.b

    def on_point(self):
        return self.a * self.point * ~self.a


def short(title: str, contenders: dict) -> None:
    """One-element calls: many short rounds."""
    compare(title, contenders, rounds=60, seconds_a_round=0.002)


def single_elements() -> None:
    a, b = motors(2)
    m, n, point = hs.Motor._wrap(a), hs.Motor._wrap(b), hs.Point.from_euclidean([1.0, 2.0, 3.0])
    screw, out = RNG.normal(size=6), np.empty(8)
    peer = Clifford() if clifford else None
    ga, gb, gp = (gafro.Motor.Random(), gafro.Motor.Random(), gafro.Point(1.0, 2.0, 3.0)) if gafro else (None,) * 3
    log = gafro.MotorGenerator(ga.log().evaluate()) if gafro else None
    short(
        "motor product, one pair",
        {
            "horosphere, Motor @ Motor": lambda: m @ n,
            "horosphere, kernel with out=": lambda: ours.motor_product(a, b, out=out),
            "clifford": peer and peer.product,
            "pygafro": gafro and (lambda: ga * gb),
        },
    )
    short(
        "motor on a point, one pair",
        {
            "horosphere, Motor @ Point": lambda: m @ point,
            "clifford": peer and peer.on_point,
            "pygafro": gafro and (lambda: ga.apply(gp)),
        },
    )
    short(
        "exponential of a screw, one element",
        {
            "horosphere, Motor.exp(screw)": lambda: hs.Motor.exp(screw),
            "pygafro": gafro and (lambda: gafro.Motor.exp(log)),
        },
    )
    short(
        "logarithm of a motor, one element",
        {"horosphere, motor.log()": lambda: m.log(), "pygafro": gafro and (lambda: ga.log().evaluate())},
    )


def batches(n: int) -> None:
    first, second = hs.Motor.exp(RNG.normal(size=(n, 6))), hs.Motor.exp(RNG.normal(size=(n, 6)))
    point = hs.Point.from_euclidean(RNG.normal(size=(n, 3)))
    a, b, points = first.array, second.array, point.array
    out, screws, moved = np.empty((n, 8)), RNG.normal(size=(n, 6)), np.empty((n, 5))
    spheres, moved_spheres = np.abs(RNG.normal(size=(n, 4))), np.empty((n, 4))
    lines, moved_lines = RNG.normal(size=(n, 6)), np.empty((n, 6))
    logs = np.empty((n, 6))
    peers = {f"kingdon {name}": Kingdon(n, name == "G(4,1)") if kingdon else None for name in ("G(4,1)", "G(3,0,1)")}
    one, few = Clifford() if clifford else None, 500
    motor, generator = (gafro.Motor.Random(), None) if gafro else (None, None)
    if gafro:
        generator = gafro.MotorGenerator(motor.log().evaluate())
    title = f"batch of {n:,}"
    print(f"\n{title}: times are per element")

    def run(what, kernel, arrays, result, method=None, looped=None, values=None):
        """One kernel against kingdon's method of this name and against looped calls; its share of the memory's speed.

        values: the same as an operator on values, which makes its result anew as the peers do.
        """
        others = {"horosphere, on values": values} if values else {}
        others |= {name: peer and getattr(peer, method) for name, peer in peers.items()} if method else {}
        if looped:
            name, call = looped
            others[f"{name}, looped over {few}"] = call and (lambda: [call() for _ in range(few)], few)
        rounds, slices = (15, 0.01) if n < 100_000 else (5, 0.02)
        if n >= 100_000:
            numbers = sum(x.shape[-1] for x in (*arrays, result))
            source = np.ones((n, numbers // 2 + numbers % 2))
            target = np.empty_like(source)
            others["numpy, copy of as many bytes"] = lambda: np.copyto(target, source)
        found = compare(
            f"{what}, {title}", {"horosphere, out=": lambda: kernel(*arrays, out=result), **others}, n, rounds, slices
        )
        if n >= 100_000:
            share = found["numpy, copy of as many bytes"] / found["horosphere, out="]
            print(
                f"  reached of the memory's speed: {share:.0%} ({8 * numbers / found['horosphere, out='] / 1e9:.0f} GB/s)"
            )

    product, on_point = ("clifford", one and one.product), ("clifford", one and one.on_point)
    run("motor product", ours.motor_product, (a, b), out, "product", product, lambda: first @ second)
    run("unit motor on a point", ours.motor_point, (a, points), moved, "on_point", on_point, lambda: first @ point)
    run("unit motor on a line", ours.motor_line, (a, lines), moved_lines, "on_line")
    run("unit motor on a sphere", ours.motor_sphere, (a, spheres), moved_spheres)
    exp = gafro and (lambda: gafro.Motor.exp(generator))
    run("exponential", ours.motor_exp, (screws,), out, None, ("pygafro", exp))
    run("logarithm", ours.motor_log, (a,), logs, None, ("pygafro", gafro and (lambda: motor.log().evaluate())))


class PinocchioPanda:
    """pinocchio on the same chain; read-out: the tip's pose as a matrix, the Jacobian at the tip in base axes."""

    def __init__(self, robot) -> None:
        self.model = pinocchio.Model()
        parent = 0
        for i in robot.chain[1:]:
            link = robot.links[i]
            placement = pinocchio.SE3(hs.Motor._wrap(link.origin).as_matrix())
            if link.kind == "revolute":
                joint = pinocchio.JointModelRevoluteUnaligned(*(float(c) for c in link.axis))
                if np.allclose(link.axis, [0, 0, 1]):
                    joint = pinocchio.JointModelRZ()
                parent = self.model.addJoint(parent, joint, self._carried(placement), link.name)
                self.offset = pinocchio.SE3.Identity()
            else:
                self.offset = self._carried(placement)
        tool = self.offset * pinocchio.SE3(hs.Motor._wrap(robot.tool).as_matrix())
        self.tip = self.model.addFrame(pinocchio.Frame("tip", parent, tool, pinocchio.FrameType.OP_FRAME))
        self.data = self.model.createData()

    offset = None

    def _carried(self, placement):
        return placement if self.offset is None else self.offset * placement

    def pose(self, q):
        pinocchio.forwardKinematics(self.model, self.data, q)
        return pinocchio.updateFramePlacement(self.model, self.data, self.tip).homogeneous

    def pose_and_jacobian(self, q):
        J = pinocchio.computeFrameJacobian(self.model, self.data, q, self.tip, pinocchio.LOCAL_WORLD_ALIGNED)
        return pinocchio.updateFramePlacement(self.model, self.data, self.tip).homogeneous, J


def panda() -> None:
    folder = os.environ.get("HOROSPHERE_DATA")
    robot = hs.robots.load("panda")
    if folder:
        robot = hs.robots.load(str(Path(folder, "panda_spheres.urdf")), tip="panda_grasptarget")
    print(f"\nPanda from {Path(robot.source).name if folder else 'the catalogue'}")
    q = RNG.uniform(*PANDA_LIMITS)
    pose, J = np.empty(8), np.empty((6, 7))
    peer = PinocchioPanda(robot) if pinocchio else None
    if peer:
        np.testing.assert_allclose(forward(robot, q).as_matrix(), peer.pose(q), atol=1e-12)
        theirs = peer.pose_and_jacobian(q)[1]
        np.testing.assert_allclose(jacobian(robot, q), np.concatenate([theirs[3:], theirs[:3]]), atol=1e-12)
    arm = gafro.FrankaEmikaRobot() if gafro else None
    values = q.tolist()
    short(
        "Panda forward kinematics, one configuration",
        {
            "horosphere, forward(robot, q, out)": lambda: forward(robot, q, pose),
            "horosphere, forward(robot, q)": lambda: forward(robot, q),
            "pinocchio, pose read out": peer and (lambda: peer.pose(q)),
            "pinocchio, not read out": peer and (lambda: pinocchio.forwardKinematics(peer.model, peer.data, q)),
            "pygafro": arm and (lambda: arm.getEEMotor(values)),
        },
    )
    short(
        "Panda pose and 6x7 Jacobian, one configuration",
        {
            "horosphere, forward_and_jacobian(robot, q)": lambda: forward_and_jacobian(robot, q),
            "horosphere, forward_and_jacobian, out": lambda: forward_and_jacobian(robot, q, (pose, J)),
            "horosphere, jacobian(robot, q, out) alone": lambda: jacobian(robot, q, J),
            "pinocchio, both read out": peer and (lambda: peer.pose_and_jacobian(q)),
            "pygafro": arm and (lambda: (arm.getEEMotor(values), arm.getEEGeometricJacobian(values))),
        },
    )
    n = 20_000
    Q = RNG.uniform(*PANDA_LIMITS, (n, 7))
    poses, Js, some = np.empty((n, 8)), np.empty((n, 6, 7)), Q[:500]
    print(f"\nbatches of {n:,}, pinocchio looped over {len(some)}: times are per configuration")
    compare(
        "Panda forward kinematics",
        {
            "horosphere, forward(robot, q, out)": lambda: forward(robot, Q, poses),
            "pinocchio, pose read out, looped": peer and (lambda: [peer.pose(x) for x in some], len(some)),
        },
        n,
    )
    compare(
        "Panda pose and Jacobian",
        {
            "horosphere, forward_and_jacobian, out": lambda: forward_and_jacobian(robot, Q, (poses, Js)),
            "pinocchio, both read out, looped": peer and (lambda: [peer.pose_and_jacobian(x) for x in some], len(some)),
        },
        n,
    )


if __name__ == "__main__":
    wanted = sys.argv[1:] or ["single", "batch", "panda"]
    heading("clifford", "kingdon", "pygafro", "pin")
    if "single" in wanted:
        single_elements()
    if "batch" in wanted:
        batches(2_000)
        batches(1_000_000)
    if "panda" in wanted:
        panda()
