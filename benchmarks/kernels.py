"""Products, exponentials and Panda kinematics against clifford, kingdon, gafro and pinocchio, in one run.

    python benchmarks/kernels.py            # needs the extra `bench`; peers that are not installed are left out

Ratios are the peer's time over ours: above 1 we are faster. Medians of several rounds, all contenders in turn.
"""

from __future__ import annotations

import importlib

import numpy as np
from _harness import compare, heading

import horosphere as hs
from horosphere.kinematics import forward, jacobian
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


def single_elements() -> None:
    a, b = motors(2)
    out = np.empty(8)
    p, g, x = hs.Point.from_euclidean([1.0, 2.0, 3.0]).array, RNG.normal(size=6), np.empty(5)
    peer = Clifford() if clifford else None
    ga, gb, gp = (gafro.Motor.Random(), gafro.Motor.Random(), gafro.Point(1.0, 2.0, 3.0)) if gafro else (None,) * 3
    compare(
        "motor product, one pair",
        {
            "horosphere, kernel with out=": lambda: ours.motor_product(a, b, out=out),
            "horosphere, Motor @ Motor": (lambda m, n: lambda: m @ n)(hs.Motor._wrap(a), hs.Motor._wrap(b)),
            "clifford": peer and peer.product,
            "pygafro": gafro and (lambda: ga * gb),
        },
    )
    compare(
        "motor on a point, one pair",
        {
            "horosphere, kernel with out=": lambda: ours.motor_point(a, p, out=x),
            "clifford": peer and peer.on_point,
            "pygafro": gafro and (lambda: ga.apply(gp)),
        },
    )
    logarithm = ga.log() if gafro else None
    compare(
        "logarithm of a motor, one element",
        {"horosphere": lambda: ours.motor_log(a), "pygafro": gafro and (lambda: ga.log().evaluate())},
    )
    compare(
        "exponential of a screw, one element",
        {
            "horosphere": lambda: ours.motor_exp(g),
            "pygafro": gafro and (lambda: gafro.Motor.exp(gafro.MotorGenerator(logarithm.evaluate())))
            if logarithm and hasattr(gafro, "MotorGenerator")
            else None,
        },
    )


def batches(n: int) -> None:
    a, b = motors(n), motors(n)
    out, screws = np.empty((n, 8)), RNG.normal(size=(n, 6))
    points, moved = hs.Point.from_euclidean(RNG.normal(size=(n, 3))).array, np.empty((n, 5))
    spheres, moved_spheres = np.abs(RNG.normal(size=(n, 4))), np.empty((n, 4))
    lines, moved_lines = RNG.normal(size=(n, 6)), np.empty((n, 6))
    logs = np.empty((n, 6))
    peers = {name: Kingdon(n, name == "G(4,1)") if kingdon else None for name in ("G(4,1)", "G(3,0,1)")}
    one = Clifford() if clifford else None
    loop = min(n, 2000)

    def looped(call):
        """A peer without batches, called one by one (on at most 2,000 elements, scaled)."""
        return call and (lambda: [call() for _ in range(loop)])

    rounds = 9 if n < 100_000 else 5
    title = f"batch of {n:,}"
    print(f"\n{title}: peers without batches are looped over {loop:,} elements; times are per element")

    def against_kingdon(what, call, method):
        others = {f"kingdon {name}": peer and getattr(peer, method) for name, peer in peers.items()}
        compare(f"{what}, {title}", {"horosphere": call, **others}, n, rounds)

    against_kingdon("motor product", lambda: ours.motor_product(a, b, out=out), "product")
    if one:
        compare("motor product, clifford looped", {"clifford": looped(one.product)}, loop, 3)
    against_kingdon("unit motor on a point", lambda: ours.motor_point(a, points, out=moved), "on_point")
    against_kingdon("unit motor on a line", lambda: ours.motor_line(a, lines, out=moved_lines), "on_line")
    compare(
        f"unit motor on a sphere, {title}",
        {"horosphere": lambda: ours.motor_sphere(a, spheres, out=moved_spheres)},
        n,
        rounds,
    )
    compare(f"exponential, {title}", {"horosphere": lambda: ours.motor_exp(screws, out=out)}, n, rounds)
    compare(f"logarithm, {title}", {"horosphere": lambda: ours.motor_log(a, out=logs)}, n, rounds)


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
    robot = hs.robots.load("panda")
    q = RNG.uniform(*PANDA_LIMITS)
    pose, J = np.empty(8), np.empty((6, 7))
    peer = PinocchioPanda(robot) if pinocchio else None
    if peer:
        np.testing.assert_allclose(forward(robot, q).as_matrix(), peer.pose(q), atol=1e-12)
        theirs = peer.pose_and_jacobian(q)[1]
        np.testing.assert_allclose(jacobian(robot, q), np.concatenate([theirs[3:], theirs[:3]]), atol=1e-12)
    arm = gafro.FrankaEmikaRobot() if gafro else None
    values = q.tolist()
    compare(
        "Panda forward kinematics, one configuration",
        {
            "horosphere, forward(robot, q, out)": lambda: forward(robot, q, pose),
            "horosphere, forward(robot, q)": lambda: forward(robot, q),
            "pinocchio, pose read out": peer and (lambda: peer.pose(q)),
            "pinocchio, not read out": peer and (lambda: pinocchio.forwardKinematics(peer.model, peer.data, q)),
            "pygafro": arm and (lambda: arm.getEEMotor(values)),
        },
    )
    compare(
        "Panda pose and 6x7 Jacobian, one configuration",
        {
            "horosphere, jacobian(robot, q, out)": lambda: jacobian(robot, q, J),
            "horosphere, forward and jacobian, out": lambda: (forward(robot, q, pose), jacobian(robot, q, J)),
            "pinocchio, both read out": peer and (lambda: peer.pose_and_jacobian(q)),
            "pygafro": arm and (lambda: (arm.getEEMotor(values), arm.getEEGeometricJacobian(values))),
        },
    )
    n = 20_000
    Q = RNG.uniform(*PANDA_LIMITS, (n, 7))
    poses, Js, some = np.empty((n, 8)), np.empty((n, 6, 7)), Q[:2000]
    ours_fk = compare(f"Panda forward kinematics, batch of {n:,}", {"horosphere": lambda: forward(robot, Q, poses)}, n)
    ours_j = compare(f"Panda Jacobian, batch of {n:,}", {"horosphere": lambda: jacobian(robot, Q, Js)}, n)
    if peer:
        theirs = compare("pinocchio looped", {"forward": lambda: [peer.pose(x) for x in some]}, len(some), 5)
        print(f"  ratio of batches, forward: {theirs['forward'] / ours_fk['horosphere']:.0f}x")
        theirs = compare("pinocchio looped", {"both": lambda: [peer.pose_and_jacobian(x) for x in some]}, len(some), 5)
        print(f"  ratio of batches, Jacobian: {theirs['both'] / ours_j['horosphere']:.0f}x")


if __name__ == "__main__":
    heading("clifford", "kingdon", "pygafro", "pin")
    single_elements()
    for size in (2_000, 1_000_000):
        batches(size)
    panda()
