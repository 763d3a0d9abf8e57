"""Inverse kinematics side by side with peers: python benchmarks/ik.py [speed | branches | poses] (all without a word).

speed: one pose and many, every contender in one interleaved run. branches: which solutions of a pose one side has and the
other has not; every solution is checked by forward kinematics in plain matrices first. poses: FK(IK) of 10,000 poses a robot,
read back from the URDF that is written of it; further robots: `poses FILE.urdf:TIP[:BASE] ...`. Peers that are not installed
are left out; `pip install .[bench]` brings them.
"""

from __future__ import annotations

import importlib.util
import sys
import tempfile
from pathlib import Path

import numpy as np
from _harness import compare, heading
from _ik_peers import Arm, eaik_solver, pytracik_solver, roboticstoolbox_solver, ssik_arms

from horosphere import kinematics, robots
from horosphere.versors import Motor

SAME = 2e-4  # radians: solutions nearer than this are one (angles at double roots are good to 1e-6, those of peers to 1e-4)
PEERS = {"ssik": "ssik", "eaik": "eaik", "roboticstoolbox": "roboticstoolbox-python", "pytracik": "pytracik"}
MODULES = ("franka_panda_ik", "ur5_ik", "iiwa14_ik", "puma560_ik")


def installed(name: str) -> bool:
    return importlib.util.find_spec(name) is not None


# ---------------------------------------------------------------- speed
def speed() -> None:
    """One pose and 10,000 poses."""
    rng = np.random.default_rng(0)
    for arm, ssik in ssik_arms(*MODULES) or [(arm, None) for arm in own_arms()]:
        robot = arm.robot()
        structure = kinematics.classify(robot)
        q = rng.uniform(-1.5, 1.5, (10_000, arm.n))
        poses, T = kinematics.forward(robot, q), arm.pose(q[0])
        one = kinematics.forward(robot, q[0])
        free = {} if structure.parameter is None else {structure.parameter: 0.3}
        many = {} if structure.parameter is None else {structure.parameter: q[:, -1].copy()}
        table = {"horosphere: all branches" + "".join(f" at a given {p}" for p in free): (
            lambda r=robot, p=one, f=free: kinematics.inverse(r, p, **f)
        )}  # fmt: skip
        if free:
            table["horosphere: best redundancy of each branch"] = lambda r=robot, p=one: kinematics.inverse(r, p)
        if ssik is not None:
            table["ssik: all branches" + (", its redundancy samples" if free else "")] = lambda s=ssik, T=T: s(T)
        if installed("eaik"):
            _, solve, _ = eaik_solver(arm, [(arm.n - 1, float(q[0, -1]))] if free else None)
            table["eaik: all branches" + (", last joint locked" if free else "")] = lambda s=solve, T=T: s(T)
        if installed("roboticstoolbox"):
            numeric = roboticstoolbox_solver(arm)
            table["roboticstoolbox ik_LM: one solution"] = lambda s=numeric, T=T: s(T)
        if installed("pytracik"):
            search = pytracik_solver(arm)
            table["pytracik: one solution"] = lambda s=search, T=T: s(T)
        compare(f"{arm.name} ({structure.name}), one pose", table)
        table = {"horosphere: all branches": lambda r=robot, p=poses, f=many: kinematics.inverse(r, p, **f)}
        if installed("eaik") and not free:
            peer, _, asked = eaik_solver(arm)
            rows = list(asked(arm.pose(q)))
            table["eaik IK_batched, 2 threads"] = lambda s=peer, rows=rows: s.IK_batched(rows, 2)
        compare(f"{arm.name}, 10,000 poses, per pose", table, items=10_000, rounds=3)
    arm = robots.humanoid_arm()
    path = np.linspace([0.33, 0.0, 0.31], [0.41, 0.07, -0.32], 100)
    point, line = (kinematics.GripperOnPlane(p, [0, 1, 0]) for p in (path[0], path[:, None]))
    phi = np.linspace(-np.pi, np.pi, 72, endpoint=False)
    compare("humanoid arm, 8 branches, one target", {"horosphere": lambda: kinematics.inverse(arm, point, phi=0.3)})
    many = {"horosphere": lambda: kinematics.inverse(arm, line, phi=phi)}
    compare("humanoid arm, 8 branches, 100 points x 72 phi, per target", many, items=7200)


# ---------------------------------------------------------------- branches
def branches(poses: int = 200) -> None:
    """Solutions that one side has and the other has not, in poses."""
    print(f"\nbranches, {poses} random poses an arm: poses in which a solution of one is missing from the other")
    print(f"{'arm':24s}{'form':14s}{'peer':8s}{'solutions: ours':>16s}{'peer':>8s}{'we lose':>9s}{'peer loses':>12s}")
    total = np.zeros(2, int)
    for arm, solve in ssik_arms():
        robot = arm.robot()
        structure = kinematics.classify(robot)
        if not structure.is_closed_form:
            print(f"{arm.name:24s}no closed form here: numerical")
            continue
        q = np.random.default_rng(1).uniform(-np.pi, np.pi, (poses, arm.n))
        total += report(arm, robot, structure, "ssik", lambda T, k, solve=solve: solve(T), q)
        if installed("eaik"):

            def locked(T, k, arm=arm, q=q):
                return eaik_solver(arm, [(6, float(q[k, 6]))])[1](T)

            known = eaik_solver(arm)[0].hasKnownDecomposition() if arm.n < 7 else False
            known = known or (arm.n == 7 and eaik_solver(arm, [(6, 0.3)])[0].hasKnownDecomposition())
            fixed = eaik_solver(arm)[1] if known and arm.n < 7 else None
            if known:
                ask = (lambda T, k, solve=fixed: solve(T)) if fixed else locked
                total += report(arm, robot, structure, "eaik", ask, q)
            else:
                print(f"{'':38s}eaik    has no decomposition for it")
    print(f"in all: we lose {total[0]}, peers lose {total[1]}")


def report(arm: Arm, robot, structure, peer: str, ask, q) -> np.ndarray:
    """One line of the table; (poses in which we lose, poses in which the peer loses)."""
    lose, loses, ours_count, peer_count = 0, 0, 0, 0
    # Of an arm that misses its structure psi is approximate: rows lie that near on the same curve of postures.
    near = 1e-2 if structure.parameter == "psi" and structure.gap > 1e-11 else SAME
    locked = peer == "eaik" and arm.n == 7
    # Where a peer samples another redundancy than ours, what it has left out is not lost.
    comparable = arm.n < 7 or locked or (structure.name == "sew7" and not structure.is_reversed)
    for k, T in enumerate(arm.pose(q)):
        theirs = np.asarray(ask(T, k), float).reshape(-1, arm.n)
        if len(theirs):
            theirs = theirs[np.abs(arm.pose(theirs) - T).max(axis=(-1, -2)) < 1e-6]
        # A redundant arm is asked at the redundancy of each solution of the peer; else the pose has one set.
        seeds = theirs if structure.parameter else q[k : k + 1]
        if len(seeds) == 0:
            loses += 1
            continue
        found = kinematics.inverse(robot, Motor.from_matrix(T), seed=seeds)
        rows = found.q.reshape(-1, arm.n)[found.valid.reshape(-1)]
        good = np.abs(arm.pose(rows) - T).max(axis=(-1, -2)) < 1e-9
        lose += not (good.all() and all(apart(rows, x).min(initial=9.0) < near for x in theirs))
        if locked:
            rows = rows[np.abs((rows[:, 6] - q[k, 6] + np.pi) % (2 * np.pi) - np.pi) < SAME]
        loses += comparable and not all(apart(theirs, x).min(initial=9.0) < 10 * SAME for x in rows)
        ours_count += len(distinct(rows))
        peer_count += len(distinct(theirs))
    name = f"{arm.name:24s}{structure.name:14s}" if peer == "ssik" else " " * 38
    count = len(q)
    print(
        f"{name}{peer:8s}{ours_count / count:16.2f}{peer_count / count:8.2f}{lose:9d}{loses if comparable else '-':>12}",
        flush=True,
    )
    return np.array([lose, loses])


def apart(rows, x):
    """Largest difference of the angles of rows (k, n) to those of x (n,), modulo a turn."""
    return np.abs((rows - x + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)


def distinct(rows) -> list:
    kept: list = []
    for x in rows:
        if not kept or apart(np.array(kept), x).min() > SAME:
            kept.append(x)
    return kept


# ---------------------------------------------------------------- poses
def poses(*files: str, count: int = 10_000) -> None:
    """FK(IK) of every robot, through a URDF and the classifier."""
    print(f"\n{count} random poses inside the limits; error: largest entry of FK(IK) - pose over all valid rows")
    heads = ("solved", "rows a pose", "inside limits", "largest error", "posture found again")
    print(f"{'robot':38s}{'form':20s}" + "".join(f"{word:>21s}" for word in heads))
    for name, robot in [*named_robots(), *(given_robot(text) for text in files)]:
        structure = kinematics.classify(robot)
        form = structure.name + (" reversed" if structure.is_reversed else "")
        low, high = np.maximum(robot.limits.lower, -np.pi), np.minimum(robot.limits.upper, np.pi)
        q = np.random.default_rng(0).uniform(low, high, (count, robot.n_joints))
        wanted = kinematics.forward(robot, q)
        if not structure.is_closed_form:
            print(f"{name:38s}{structure}")
            continue
        found = kinematics.inverse(robot, wanted, seed=q)
        error = np.abs(kinematics.forward(robot, found.q).as_matrix() - wanted.as_matrix()[:, None]).max(axis=(-1, -2))
        again = np.where(found.valid, apart(found.q, q[:, None]), 9.0).min(axis=-1)
        inside = found.within_limits(robot).any(axis=-1).mean()
        print(
            f"{name:38s}{form:20s}{found.solved.mean():21.2%}{found.valid.sum(-1).mean():21.2f}{inside:21.2%}"
            f"{error[found.valid].max():21.1e}{(again < SAME).mean():21.2%}",
            flush=True,
        )


def named_robots():
    """The catalogue, and arms of published dimensions written to URDF and read again."""
    for name in ("panda", "ur5", "iiwa14", "nao-left-arm"):
        yield name, robots.load(name)
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "kinematics"))
    import structured_arms as arms

    with tempfile.TemporaryDirectory() as folder:
        for name, arm in arms.REAL.items():
            path = Path(folder) / "arm.urdf"
            robots.save(arms.robot(name, arm), path)
            yield f"{name} (URDF)", robots.load(path)


def given_robot(text: str):
    file, tip, *base = text.split(":")
    return f"{Path(file).stem}: {tip}", robots.load(file, tip=tip, base=base[0] if base else None)


def own_arms() -> list[Arm]:
    """Panda and UR5 of the catalogue, where ssik with its arms is not installed."""
    from _ik_peers import from_forward

    found = []
    for name in ("panda", "ur5"):
        robot = robots.load(name)
        found.append(from_forward(name, lambda q, r=robot: kinematics.forward(r, q).as_matrix(), robot.n_joints))
    return found


if __name__ == "__main__":
    heading(*(name for module, name in PEERS.items() if installed(module)))
    word, rest = (sys.argv[1] if len(sys.argv) > 1 else "all"), sys.argv[2:]
    if word in ("speed", "all"):
        speed()
    if word in ("branches", "all"):
        branches(*map(int, rest[:1]))
    if word in ("poses", "all"):
        poses(*(rest if word == "poses" else ()))
