"""The snake in the conformal algebra of its plane, traced once for each number of links.

The plane's algebra is the part of G(4,1) without e3: motors have the blades 1, e12, e1i, e2i, points e1, e2, e0, ei.
With the frames M_0 = T(x, y) R(theta), M_i = M_{i-1} T(l_{i-1} e1) R(Phi_i):

    joints Q_i = M_i e0 ~M_i      point pairs P_i = Q_i ^ Q_{i+1}      wheel points p_i = M_i pt(f l_i) ~M_i
    link axes L_i = M_i e12 ~M_i      d p_i / d q_k = p_i . L_k      Pfaff rows ((p_i . L_k) ^ P_i ^ einf)^* e3 / l_i = 0
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from ..kernels import E0, E1, EI, MV, Kernel, apply_motor, blade, blades, kernel, scalars, sincos

_E12, _E1I, _E2I = blade("12"), blade("1i"), blade("2i")
_E1, _E2, _AREA = blade("1"), blade("2"), blade("120i")
_POINT = blades("1", "2", "0", "i")
_AXIS = blades("12", "1i", "2i")
_FLAT = (_E1, _E2)
_SHIFTS = (MV({_E1I: 1.0}), MV({_E2I: 1.0}))  # "axes at infinity": p . (e_k einf) is the velocity e_k of a translation


def _rotor(angle: Any) -> MV:
    s, c = sincos(angle * 0.5)
    return MV({0: c, _E12: -s})


def _translator(x: Any, y: Any) -> MV:
    return MV({0: 1.0, _E1I: x * -0.5, _E2I: y * -0.5})


def _frames(q: list, lengths: list) -> list[MV]:
    frames = [_translator(q[0], q[1]) * _rotor(q[2])]
    for i in range(1, len(lengths)):
        frames.append(frames[-1] * (_translator(lengths[i - 1], 0.0) * _rotor(q[2 + i])))
    return frames


def _point_along(distance: Any) -> MV:
    return E0 + distance * E1 + (distance * distance * 0.5) * EI


def _joints(frames: list[MV], lengths: list) -> list[MV]:
    points = [apply_motor(m, E0, _POINT) for m in frames]
    return [*points, apply_motor(frames[-1], _point_along(lengths[-1]), _POINT)]


def _wheels(frames: list[MV], lengths: list, fraction: Any) -> list[MV]:
    return [apply_motor(m, _point_along(fraction * length), _POINT) for m, length in zip(frames, lengths)]


def _generators(frames: list[MV]) -> list[MV]:
    return [*_SHIFTS, *(apply_motor(m, MV({_E12: 1.0}), _AXIS) for m in frames)]


def _wheel_velocities(frames: list[MV], lengths: list, fraction: Any) -> list[list[MV | None]]:
    """Entry [i][k] is the velocity of wheel point i per unit of coordinate k, p_i . L_k, or None where it vanishes."""
    axes = _generators(frames)
    wheels = _wheels(frames, lengths, fraction)
    return [[p | axes[k] if k <= 2 + i else None for k in range(len(axes))] for i, p in enumerate(wheels)]


def _pfaff(frames: list[MV], lengths: list, fraction: Any) -> list:
    joints = _joints(frames, lengths)
    velocities = _wheel_velocities(frames, lengths, fraction)
    entries: list = []
    for i in range(1, len(frames) - 1):
        line = joints[i] ^ joints[i + 1] ^ EI
        scale = 1.0 / lengths[i]
        for velocity in velocities[i]:
            # the wedge is a multiple of e1 e2 (e0 ^ einf), minus the dual of e3
            entries.append(0.0 if velocity is None else (velocity ^ line)[_AREA] * scale)
    return entries


def _directions(frames: list[MV]) -> list[MV]:
    return [apply_motor(m, E1, _FLAT) for m in frames]


def _basis(frames: list[MV], lengths: list, fraction: Any) -> list:
    links = len(frames)
    d = _directions(frames)
    columns: list[list] = []
    for u in (MV({_E1: 1.0}), MV({_E2: 1.0})):
        rates: list = [0.0]
        column = [u[_E1], u[_E2], 0.0]
        for i in range(1, links - 1):
            turn = (d[i] ^ u)[_E12]  # n_i . u
            rates.append(turn * (-1.0 / (fraction * lengths[i])))
            reflected = d[i] * u * d[i]
            ratio = (1.0 - fraction) / fraction
            u = (0.5 * (1.0 - ratio)) * u + (0.5 * (1.0 + ratio)) * reflected.only(_FLAT)
        column += [rates[i] - rates[i - 1] for i in range(1, links - 1)]
        columns.append([*column, 0.0])
    head = [lengths[0] * d[0][_E2], -(lengths[0] * d[0][_E1]), 1.0, -1.0]
    columns.append(head + [0.0] * (links - 2))
    columns.append([0.0] * (links + 1) + [1.0])
    return [column[row] for row in range(links + 2) for column in columns]


def _flat(points: list[MV]) -> list:
    return [p[b] for p in points for b in _FLAT]


@lru_cache(maxsize=64)
def snake_kernel(what: str, links: int) -> Kernel:
    """The kernel of one quantity: arguments q (..., links + 2) and data (links + 1,) = lengths then wheel fraction."""
    n = links + 2
    sizes = {
        "joints": 2 * (links + 1),
        "centres": 2 * links,
        "jacobian": 2 * links * n,
        "pfaff": (links - 2) * n,
        "control_basis": 4 * n,
        "frames": 4 * links,
        "axes": 3 * links,
    }
    sizes["model"] = sizes["joints"] + sizes["pfaff"] + sizes["control_basis"]

    def trace(q: list, data: list) -> list:
        lengths, fraction = data[:links], data[links]
        frames = _frames(q, lengths)
        if what == "joints":
            return _flat(_joints(frames, lengths))
        if what == "centres":
            return _flat(_wheels(frames, lengths, fraction))
        if what == "jacobian":
            table = _wheel_velocities(frames, lengths, fraction)
            return [0.0 if v is None else v[b] for row in table for b in _FLAT for v in row]
        if what == "pfaff":
            return _pfaff(frames, lengths, fraction)
        if what == "control_basis":
            return _basis(frames, lengths, fraction)
        if what == "frames":
            return [m[b] for m in frames for b in (0, _E12, _E1I, _E2I)]
        if what == "axes":
            return [axis[b] for axis in _generators(frames)[2:] for b in _AXIS]
        return _flat(_joints(frames, lengths)) + _pfaff(frames, lengths, fraction) + _basis(frames, lengths, fraction)

    trace.__name__ = f"snake_{what}_{links}"
    return kernel(sizes[what], q=scalars(n), data=scalars(links + 1))(trace)
