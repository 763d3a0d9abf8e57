"""Arms written down from their published dimensions (rounded to the structure that matters), for the tests."""

import numpy as np

from horosphere.robots import Limits, Link, Robot

X, Y, Z = (1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0)
_Y, _Z = (0, -1.0, 0), (0, 0, -1.0)

UR5 = [Z, Y, Y, Y, _Z, Y], [
    (0, 0, 0.089159), (0, 0.13585, 0.089159), (0.425, 0.01615, 0.089159), (0.81725, 0.01615, 0.089159),
    (0.81725, 0.10915, 0), (0.81725, 0.10915, -0.0055),
]  # fmt: skip
IIWA = [Z, Y, Z, _Y, Z, Y, Z], [(0, 0, z) for z in (0.1575, 0.36, 0.5645, 0.78, 0.9645, 1.18, 1.261)]
IIWA_RTB = IIWA[0], [(0, 0, 0.1575), (-0.00043624, 0, 0.36), (0, 0, 0.56), (0.00043624, 0, 0.78), *IIWA[1][4:]]
OFFSET_SRS = [Z, Y, Z, _Y, Z, Y, Z], [
    (0, 0, 0.1), (0, 0, 0.3), (0, 0, 0.5), (0.07, 0, 0.7), (0, 0, 0.9), (0, 0, 1.1), (0, 0, 1.2),
]  # fmt: skip
SKEW_SRS = [Z, (0.2, 1, 0.1), (0.1, 0.1, 1), _Y, (0.1, 0.2, 1), (0, 1, 0.3), (0.3, 0, 1)], [
    *[(0, 0, 0.1)] * 3, (0, 0, 0.5), *[(0, 0, 0.9)] * 3,
]  # fmt: skip
XARM7 = [Z, Y, Z, _Y, Z, _Y, _Z], [
    (0, 0, 0.1), (0, 0, 0.267), (0, 0, 0.3), (0.0525, 0, 0.56), (0.13, 0, 0.4), (0.13, 0, 0.2175), (0.206, 0, 0.1205),
]  # fmt: skip
XARM7_REVERSED = XARM7[0][::-1], XARM7[1][::-1]
PUMA = [Z, Y, Y, Z, Y, Z], [
    (0, 0, 0.3), (0, 0.1, 0.67), (0.43, 0.1, 0.67), (0.41, 0.15, 0.9), (0.41, 0.15, 1.1), (0.41, 0.15, 1.2),
]  # fmt: skip
MEET_12 = [Z, Y, X, Z, Y, Z], [(0, 0, 0.3), (0, 0, 0.5), (0.3, 0.1, 0.7), *[(0.3, 0.1, 1.0)] * 3]
PARALLEL_12 = [Z, Z, X, Z, Y, Z], [(0, 0, 0.3), (0.3, 0, 0.3), (0.6, 0, 0.35), *[(0.65, 0.2, 0.7)] * 3]
MEET_23 = [Z, Y, X, Z, Y, Z], [(0, 0, 0.3), (0.2, 0, 0.5), (0, 0, 0.5), *[(0.3, 0.1, 1.0)] * 3]
SPHERICAL_SHOULDER = [Z, Y, Z, Y, Y, Z], [*[(0, 0, 0.3)] * 3, (0.05, 0, 0.7), (0, 0, 1.0), (0.02, 0.1, 1.1)]
NAO = [Y, Z, X, Z, X], [(0, 0.098, 0.1), (0, 0.098, 0.1), *[(0.105, 0.113, 0.1)] * 3]
NAO_REVERSED = NAO[0][::-1], NAO[1][::-1]
SKEW_UR = [Z, (0.1, 1, 0), (0.1, 1, 0), (0.1, 1, 0), (0.2, 0.1, 1), (0.1, 1, 0.3)], [
    (0, 0, 0.1), (0, 0.1, 0.1), (0.4, 0.1, 0.2), (0.8, 0, 0.1), (0.8, 0.1, 0), (0.8, 0.1, 0),
]  # fmt: skip
ANTIPARALLEL_UR = [Z, X, X, (-1.0, 0, 0), Z, (-1.0, 0, 0)], [
    (0, 0, 0), (0, 0, 0.113), (0, 0, 0.59), (0, 0, 0.94), (-0.092, 0, 0), (0, 0, 1.06),
]  # fmt: skip
NOTHING = [Z, Y, Z, (0.3, 1, 0), X, Y], [
    (0, 0, 0.1), (0.03, 0, 0.2), (0.05, 0.04, 0.3), (0.2, 0.1, 0.3), (0.3, 0, 0.45), (0.45, 0.03, 0.5),
]  # fmt: skip
PANDA = [Z, Y, Z, _Y, Z, _Y, _Z], [
    (0, 0, 0), (0, 0, 0.333), (0, 0, 0.333), (0.0825, 0, 0.649), (0, 0, 0.649), (0, 0, 1.033), (0.088, 0, 1.033),
]  # fmt: skip
PEPPER = [Y, Z, X, (np.sin(0.157), 0, np.cos(0.157)), X], [(-0.057, 0.15, 0.087)] * 2 + [(0.1242, 0.165, 0.087)] * 3


def _ur(d1, a2, a3, d4, d5):
    return UR5[0], [(0, 0, d1), (0, 0, d1), (a2, 0, d1), (a2 + a3, 0, d1), (a2 + a3, d4, 0), (a2 + a3, d4, d1 - d5)]


# What `benchmarks/ik.py poses` and the slow test go through, by name; dimensions as the makers publish them.
REAL = {
    "Panda and FR3": PANDA,
    "Panda from its tip": (PANDA[0][::-1], PANDA[1][::-1]),
    "xArm7": XARM7,
    "xArm7 from its tip": XARM7_REVERSED,
    "UR3": _ur(0.1519, 0.24365, 0.21325, 0.11235, 0.08535),
    "UR5": UR5,
    "UR10": _ur(0.1273, 0.612, 0.5723, 0.163941, 0.1157),
    "UR10 from its tip": tuple(x[::-1] for x in _ur(0.1273, 0.612, 0.5723, 0.163941, 0.1157)),
    "three axes against each other": ANTIPARALLEL_UR,
    "iiwa14": IIWA,
    "S-R-S, elbow offset": OFFSET_SRS,
    "S-R-S, elbow offset, from tip": (OFFSET_SRS[0][::-1], OFFSET_SRS[1][::-1]),
    "S-R-S, skew axes": SKEW_SRS,
    "Puma (wrist 4-6)": PUMA,
    "6R, shoulder 1-3 spherical": SPHERICAL_SHOULDER,
    "6R, axes 1, 2 meet": MEET_12,
    "6R, axes 1, 2 parallel": PARALLEL_12,
    "6R, axes 2, 3 meet": MEET_23,
    "NAO left arm": NAO,
    "NAO left arm from its tip": NAO_REVERSED,
    "Pepper left arm": PEPPER,
}


def robot(name, arm, limit=np.pi):
    """A Robot from axes and points at q = 0, all frames parallel to the base's, tool 0.1 m along z of the last frame."""
    axes, points = (np.array(x, float) for x in arm)
    n = len(axes)
    links, before = [Link("base", -1, _shift(np.zeros(3)))], np.zeros(3)
    for k in range(n):
        axis = axes[k] / np.linalg.norm(axes[k])
        links.append(Link(f"link_{k + 1}", k, _shift(points[k] - before), "revolute", axis, k))
        before = points[k]
    limits, inf = np.broadcast_to(limit, n).astype(float), np.full(n, np.inf)
    names = tuple(f"joint_{k + 1}" for k in range(n))
    return Robot(name, tuple(links), n, names, Limits(-limits, limits, inf, inf, inf), tool=_shift([0, 0, 0.1]))


def pose_chain(arm):
    """Unit axes, points and home pose for `plain_fk.chain_pose`."""
    axes, points = (np.array(x, float) for x in arm)
    home = np.eye(4)
    home[:3, 3] = points[-1] + [0, 0, 0.1]
    return axes / np.linalg.norm(axes, axis=1, keepdims=True), points, home


def _shift(t):
    return np.array([1.0, 0, 0, 0, *(-0.5 * np.asarray(t, float)), 0])
