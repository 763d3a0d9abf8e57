"""The inverse problem: a posture from its joints, and all postures with the first and last link given."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..kernels import E0, E1, EI, MV, Kernel, atan2, blade, kernel, maximum, scalars, sqrt
from ..numeric import float_array, wrap_angle

_E1, _E2, _W = blade("1"), blade("2"), blade("0")
_PLANE = MV({blade("120i"): 1.0})  # e1 e2 (e0 ^ einf): the unit volume of the plane's algebra


def _point(x: Any, y: Any) -> MV:
    return E0 + MV({_E1: x, _E2: y}) + ((x * x + y * y) * 0.5) * EI


@lru_cache(maxsize=64)
def angles_kernel(links: int) -> Kernel:
    """q from the joints (..., 2 (links + 1)) and lengths: [Snake] sec. 6 with both cosine and sine, so that atan2 decides.

    cos theta = (P_0 ^ einf) . (e0 ^ e1 ^ einf) / l_0;  cos Phi_i = (P_{i-1} ^ einf) . (P_i ^ einf) / (l_{i-1} l_i);
    sin Phi_i l_{i-1} l_i = (Q_{i-1} ^ Q_i ^ Q_{i+1} ^ einf)^* e3.
    """
    turn = blade("120i")

    def trace(points: list, lengths: list) -> list:
        # about Q_0, so that the squares of far coordinates do not eat digits
        q = [_point(points[2 * i] - points[0], points[2 * i + 1] - points[1]) for i in range(links + 1)]
        lines = [q[i] ^ q[i + 1] ^ EI for i in range(links)]
        axis = E0 ^ E1 ^ EI
        angles = [atan2((E0 ^ (E0 + E1) ^ q[1] ^ EI)[turn], (axis | lines[0])[0])]
        for i in range(1, links):
            angles.append(atan2((q[i - 1] ^ q[i] ^ q[i + 1] ^ EI)[turn], (lines[i - 1] | lines[i])[0]))
        return [points[0], points[1], *angles]

    trace.__name__ = f"snake_angles_{links}"
    return kernel(links + 2, points=scalars(2 * (links + 1)), lengths=scalars(links))(trace)


@kernel(5, data=scalars(6))
def circle_meet(data):
    """Both points at distances (ra, rb) from a and b, for data = (ax, ay, bx, by, ra, rb), and P.P (negative: none).

    P = (S_a ^ S_b)^* is the pair's dual; its points are (s -+ P)(einf . P)^-1 with s = sqrt(P . P).
    """
    ax, ay, bx, by, ra, rb = data
    s_a = _point(0.0, 0.0) - (ra * ra * 0.5) * EI  # about a
    s_b = _point(bx - ax, by - ay) - (rb * rb * 0.5) * EI
    pair = (s_a ^ s_b) * _PLANE
    square = (pair | pair)[0]
    root = sqrt(maximum(square, 0.0))
    toward = EI | pair
    inverse_square = 1.0 / (toward | toward)[0]
    result = []
    for sign in (1.0, -1.0):
        point = (MV({0: root}) - sign * pair).only(tuple(pair.terms) + (0,)) * toward * (sign * inverse_square)
        weight = 1.0 / -(EI | point)[0]
        result += [ax + point[_E1] * weight, ay + point[_E2] * weight]
    return [*result, square]


@dataclass(frozen=True, slots=True, eq=False)
class ClosedChains:
    """Postures with the first and last link given: `q` (..., 2, N+3), one for each side of the last elbow.

    `valid` (..., 2) is False where the last two links cannot close the chain (q is then NaN); `reason` says how many closed.
    """

    q: NDArray[np.float64]
    valid: NDArray[np.bool_]
    reason: str


def from_joints(points: ArrayLike, lengths: NDArray[np.float64], tolerance: float) -> NDArray[np.float64]:
    """The posture with these joints (..., N+2, 2); see Snake.from_joints."""
    links = len(lengths)
    q = float_array(points, "points", last=2)
    if q.ndim < 2 or q.shape[-2] != links + 1:
        raise InputError(f"expected joints of shape (..., {links + 1}, 2), got {q.shape}", place="points")
    wrong = np.abs(np.linalg.norm(np.diff(q, axis=-2), axis=-1) - lengths)
    if wrong.size and wrong.max() > tolerance:
        where = tuple(int(i) for i in np.unravel_index(wrong.argmax(), wrong.shape))
        raise InputError(
            f"the joints {where[-1]} and {where[-1] + 1} are not one link apart (off by {wrong.max():.3g} m)",
            place="points",
            remedy=f"link lengths are {lengths.tolist()}",
        )
    return angles_kernel(links)(q.reshape(*q.shape[:-2], -1), lengths)


def closed_chain(head: ArrayLike, tail: ArrayLike, free: ArrayLike, lengths: NDArray[np.float64]) -> ClosedChains:
    """All postures with given first and last link; see Snake.closed_chain."""
    links = len(lengths)
    ends = []
    for value, name, length in ((head, "head", lengths[0]), (tail, "tail", lengths[-1])):
        pair = float_array(value, name, last=2, ndim=2)
        if pair.shape != (2, 2):
            raise InputError(f"expected two joints of shape (2, 2), got {pair.shape}", place=name)
        off = abs(np.linalg.norm(pair[1] - pair[0]) - length)
        if off > 1e-9 * max(1.0, length):
            raise InputError(f"the two joints are not one link of {length} m apart (off by {off:.3g} m)", place=name)
        ends.append(pair)
    if links < 4:
        raise InputError(f"a closed chain needs at least 4 links, this snake has {links}", place="links")
    angles = float_array(free, "free", last=links - 4)
    batch = angles.shape[:-1]
    steps = lengths[1 : links - 3, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    inner = ends[0][1] + np.concatenate([np.zeros((*batch, 1, 2)), np.cumsum(steps, axis=-2)], axis=-2)
    data = np.empty((*batch, 6))
    data[..., :2], data[..., 2:4], data[..., 4:] = inner[..., -1, :], ends[1][0], lengths[-3:-1]
    coincide = np.linalg.norm(data[..., :2] - data[..., 2:4], axis=-1) < 1e-12
    data[..., 2] += np.where(coincide, lengths.sum() * 2, 0.0)  # no finite number of solutions: reported as none
    meet = circle_meet(data)
    valid = np.repeat((meet[..., 4] >= 0.0)[..., None], 2, axis=-1)
    joints = np.empty((*batch, 2, links + 1, 2))
    joints[..., 0, :], joints[..., 1, :] = ends[0][0], ends[0][1]
    joints[..., 1 : links - 2, :] = inner[..., None, :, :]
    joints[..., links - 2, :] = meet[..., :4].reshape(*batch, 2, 2)
    joints[..., links - 1, :], joints[..., links, :] = ends[1][0], ends[1][1]
    q = angles_kernel(links)(joints.reshape(*batch, 2, -1), lengths)
    q[..., 3:] = wrap_angle(q[..., 3:])
    q[~valid] = np.nan
    closed = int(valid.sum())
    return ClosedChains(q, valid, f"{closed} of {valid.size} close; the set of solutions has dimension {links - 4}")
