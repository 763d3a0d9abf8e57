"""Arms for `ik.py`, given as axes, points and home pose, and the same arm in horosphere and in its peers."""

from __future__ import annotations

import importlib
import importlib.util
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from horosphere import robots
from horosphere.robots import Limits, Link
from horosphere.versors import Motor


@dataclass(frozen=True)
class Arm:
    """Pose of the tip = exp(S1 q1) ... exp(Sn qn) home, about unit axes (n, 3) through points (n, 3) at q = 0."""

    name: str
    axes: np.ndarray
    points: np.ndarray
    home: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    @property
    def n(self) -> int:
        return len(self.axes)

    def robot(self) -> robots.Robot:
        """The arm in horosphere: frames parallel to the base's at q = 0."""
        links, before = [Link("base", -1, _shift(np.zeros(3)))], np.zeros(3)
        for k in range(self.n):
            links.append(Link(f"link_{k + 1}", k, _shift(self.points[k] - before), "revolute", self.axes[k], k))
            before = self.points[k]
        tool = self.home.copy()
        tool[:3, 3] -= before
        inf, names = np.full(self.n, np.inf), tuple(f"joint_{k + 1}" for k in range(self.n))
        limits = Limits(self.lower, self.upper, inf, inf, inf)
        return robots.Robot(self.name, tuple(links), self.n, names, limits, tool=Motor.from_matrix(tool).array)

    def pose(self, q: np.ndarray) -> np.ndarray:
        """(..., 4, 4) by matrices: the referee of all solutions."""
        M = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))
        for i, (n, p) in enumerate(zip(self.axes, self.points)):
            T = np.zeros((*q.shape[:-1], 4, 4))
            T[..., :3, :3], T[..., 3, 3] = _rotation(n, q[..., i]), 1.0
            T[..., :3, 3] = p - T[..., :3, :3] @ p
            M = M @ T
        return M @ self.home


def from_forward(name: str, forward: Callable[[np.ndarray], np.ndarray], n: int) -> Arm:
    """An arm of revolute joints from its forward kinematics alone: the axis of joint i is that of pose(q_i = 1) ~pose(0)."""
    home, axes, points = np.asarray(forward(np.zeros(n)), float), [], []
    for i in range(n):
        q = np.zeros(n)
        q[i] = 2.0
        T = np.asarray(forward(q), float) @ np.linalg.inv(home)
        R = T[:3, :3]
        axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
        axis /= np.linalg.norm(axis)
        points.append(np.linalg.lstsq(np.eye(3) - R, T[:3, 3], rcond=1e-8)[0])
        axes.append(axis)
    return Arm(name, np.array(axes), np.array(points), home, np.full(n, -np.pi), np.full(n, np.pi))


def ssik_arms(*names: str) -> list[tuple[Arm, Callable]]:
    """ssik's ready-made arms of these modules (all without names): the arm, and its solver for all branches of a pose."""
    if importlib.util.find_spec("ssik") is None:
        return []
    import ssik

    found = []
    for entry in ssik.list_arms():
        if names and entry.name not in names:
            continue
        module = importlib.import_module(entry.import_path)
        arm = from_forward(entry.name, module.fk, entry.dof)

        def solve(T, module=module):
            return np.array([s.q for s in module.solve(T, respect_limits=False, enumerate_windings=False)])

        found.append((arm, solve))
    return found


def eaik_solver(arm: Arm, locked: list[tuple[int, float]] | None = None):
    """EAIK's robot of an arm, and the pose it is asked for: its tip is the last axis point, its frame the base's at q = 0."""
    from eaik.IK_HP import HPRobot

    steps = np.vstack([np.diff(np.vstack([np.zeros(3), arm.points]), axis=0), arm.home[:3, 3] - arm.points[-1]])
    robot = HPRobot(arm.axes, steps, locked)
    turn = np.eye(4)
    turn[:3, :3] = arm.home[:3, :3].T

    def solve(T):
        found = robot.IK(T @ turn)
        return np.array([q for q, off in zip(found.Q, found.is_LS) if not off]).reshape(-1, arm.n)

    return robot, solve, lambda T: T @ turn


def roboticstoolbox_solver(arm: Arm) -> Callable:
    """One solution by its compiled Levenberg-Marquardt search."""
    from roboticstoolbox import ET, ETS
    from spatialmath import SE3

    chain, before = [], np.eye(4)
    for k in range(arm.n):
        frame = np.eye(4)
        frame[:3, :3], frame[:3, 3] = _frame_of(arm.axes[k]), arm.points[k]
        chain += [ET.SE3(SE3(np.linalg.inv(before) @ frame, check=False)), ET.Rz()]
        before = frame
    chain.append(ET.SE3(SE3(np.linalg.inv(before) @ arm.home, check=False)))
    ets = ETS(chain)
    ets.qlim = np.array([arm.lower, arm.upper])
    return lambda T: ets.ik_LM(T, tol=1e-12)


def pytracik_solver(arm: Arm, timeout: float = 0.02) -> Callable:
    """One solution by TRAC-IK, from the URDF that horosphere writes of the arm."""
    import pytracik

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        robots.save(arm.robot(), path)
        text = path.read_text()
    names = [line.split('"')[1] for line in text.splitlines() if "<link name=" in line]
    solver = pytracik.TRAC_IK(names[0], names[-1], text, timeout, 1e-6, pytracik.SolveType.Speed)
    middle = np.clip(0.5 * (arm.lower + arm.upper), arm.lower, arm.upper)
    from scipy.spatial.transform import Rotation

    def solve(T):
        x, y, z, w = Rotation.from_matrix(T[:3, :3]).as_quat()
        return pytracik.ik(solver, middle, *T[:3, 3], x, y, z, w)

    return solve


def _shift(t) -> np.ndarray:
    return np.array([1.0, 0, 0, 0, *(-0.5 * np.asarray(t, float)), 0])


def _frame_of(axis: np.ndarray) -> np.ndarray:
    x = np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.7 else [0, 1.0, 0])
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis], axis=1)


def _rotation(axis, angle):
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], float)
    s, c = np.sin(angle)[..., None, None], np.cos(angle)[..., None, None]
    return np.eye(3) + s * K + (1 - c) * (K @ K)
