"""Forward kinematics by 4 x 4 matrices and Rodrigues' formula: a witness that shares no code with horosphere."""

import numpy as np


def rotation(axis, angle):
    """(..., 3, 3) about a unit axis."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], float)
    s, c = np.sin(angle)[..., None, None], np.cos(angle)[..., None, None]
    return np.eye(3) + s * K + (1 - c) * (K @ K)


def chain_pose(axes, points, home, q):
    """(..., 4, 4) pose exp(S1 q1) ... exp(Sn qn) home."""
    M = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))
    for i, (n, p) in enumerate(zip(axes, points)):
        n, p = np.asarray(n, float), np.asarray(p, float)
        T = np.zeros((*q.shape[:-1], 4, 4))
        T[..., 3, 3] = 1
        T[..., :3, :3] = rotation(n, q[..., i])
        T[..., :3, 3] = p - T[..., :3, :3] @ p
        M = M @ T
    return M @ home


def humanoid(d0, h, d1, d2, d3):
    """Axes, points and home pose of the 5-joint arm, written down from its definition."""
    a = np.sqrt(d0**2 - h**2)
    p0, p1, p2, pt = (np.array([a, y, 0.0]) for y in (h, h + d1, h + d1 + d2, h + d1 + d2 + d3))
    axes = [(0, 1, 0), (0, 0, -1), (0, 0, -1), (0, 1, 0), (0, 0, -1)]
    return axes, [np.zeros(3), p0, p1, p2, p2], shifted(pt)


def srs(dbs, dse, dew, dwf):
    """Axes, points and home pose of the S-R-S arm."""
    S, E, W, F = (np.array([0, 0, z]) for z in np.cumsum([dbs, dse, dew, dwf]))
    axes = [(0, 0, 1), (0, 1, 0), (0, 0, 1), (0, -1, 0), (0, 0, 1), (0, 1, 0), (0, 0, 1)]
    return axes, [np.zeros(3), S, S, E, E, W, W], shifted(F)


def six_axis(a1, d1, a2, a3, d4, d6):
    """Axes, points and home pose of the six-axis arm."""
    S = np.array([a1, 0, d1])
    E = S + [0, 0, a2]
    W = E + [d4, 0, a3]
    axes = [(0, 0, 1), (0, 1, 0), (0, 1, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0)]
    return axes, [np.zeros(3), S, E, W, W, W], shifted(W + [d6, 0, 0])


def shifted(x):
    """The pose with axes of the base and origin x."""
    T = np.eye(4)
    T[:3, 3] = x
    return T


def pose_gap(a, b):
    """(...) largest absolute difference of two poses' entries."""
    return np.abs(a - b).max(axis=(-1, -2))


def turned(x):
    """Angles modulo a turn, in (-pi, pi]."""
    return (x + np.pi) % (2 * np.pi) - np.pi
