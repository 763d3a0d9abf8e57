"""Arms made from a few lengths, with closed-form inverse kinematics; at q = 0 all frames are parallel to the base's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InputError
from ..numeric import float_array
from . import _pairs, _placement
from ._bodies import Body
from ._document import pack
from ._robot import Limits, Link, Robot

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def humanoid_arm(
    d0: float = 0.1,
    h: float = 0.1,
    d1: float = 0.35,
    d2: float = 0.30,
    d3: float = 0.15,
    *,
    radii: Sequence[float] = (0.045, 0.04, 0.025),
) -> Robot:
    """The 5-joint arm of [Humanoid] section V: torso yaw, shoulder, elbow, forearm roll, wrist.

    Metres. The shoulder is at height h (along y) and distance d0 from the origin, so d0 >= |h|; upper arm d1, forearm
    d2, gripper d3.
    Home: straight up along y in the plane z = 0. Axes y, -z, -z, y, -z through the origin, shoulder, elbow, wrist,
    wrist.
    `radii`: capsules of upper arm, forearm, gripper. The mechanism is reconstructed from the paper's equations:
    docs/errata.md. Joint limits +-175, 120, 150, 175, 120 degrees, 2 rad/s and 6 rad/s^2 are our choice; the paper
    gives none.
    """
    _positive(d1=d1, d2=d2, d3=d3)
    _finite(d0=d0, h=h)
    if d0 < abs(h):
        raise InputError(
            f"the shoulder cannot be at height {h:g} and only {d0:g} from the origin", place="d0", remedy="d0 >= |h|"
        )
    side = float(np.sqrt((d0 - h) * (d0 + h)))
    names = ("torso", "shoulder", "upper_arm", "forearm", "forearm_roll", "gripper")
    offsets = ((0, 0, 0), (side, h, 0), (0, d1, 0), (0, d2, 0), (0, 0, 0))
    axes = (Y, (0, 0, -1), (0, 0, -1), Y, (0, 0, -1))
    limits = np.radians([175.0, 120, 150, 175, 120])
    upper, fore, grip = (float(r) for r in radii)
    bodies = {
        "upper_arm": [Body(np.zeros(3), np.array([0, d1, 0.0]), upper, "upper arm")],
        "forearm": [Body(np.zeros(3), np.array([0, d2, 0.0]), fore, "forearm")],
        "gripper": [Body(np.zeros(3), np.array([0, d3, 0.0]), grip, "gripper")],
    }
    if side > 0.0:
        bodies["shoulder"] = [
            Body(np.array([0, h, 0.0]), np.array([side, h, 0.0]), upper, "from the torso axis to the shoulder")
        ]
    parameters = {"d0": d0, "h": h, "d1": d1, "d2": d2, "d3": d3}
    return _arm(
        "humanoid_arm", parameters, names, offsets, axes, (0, d3, 0), limits, (2.0, 6.0), bodies, "[Humanoid] section V"
    )


def srs_arm(
    dbs: float = 0.0, dse: float = 0.316, dew: float = 0.248, dwf: float = 0.092, *, radius: float = 0.045
) -> Robot:
    """A 7-joint arm with spherical shoulder and wrist (S-R-S).

    Metres. Home along z: shoulder S = (0, 0, dbs), elbow E = S + dse z, wrist W = E + dew z, tool point F = W + dwf z;
    axes z, y, z, -y, z, y, z through 0, S, S, E, E, W, W. Default lengths: a person of 1.70 m (Winter, Biomechanics
    and Motor Control of
    Human Movement: segments 0.186, 0.146 of the height, half of 0.108 to the grip). Limits 170 degrees in roll and
    120 in bend, as on lightweight arms of this kind; 2 rad/s, 6 rad/s^2 and the capsule radius are our choice.
    """
    _positive(dse=dse, dew=dew, dwf=dwf)
    _finite(dbs=dbs)
    names = ("base", "shoulder_1", "shoulder_2", "upper_arm", "elbow", "forearm", "wrist", "hand")
    offsets = ((0, 0, 0), (0, 0, dbs), (0, 0, 0), (0, 0, dse), (0, 0, 0), (0, 0, dew), (0, 0, 0))
    axes = (Z, Y, Z, (0, -1, 0), Z, Y, Z)
    limits = np.radians([170.0, 120, 170, 120, 170, 120, 175])
    bodies = {
        "upper_arm": [Body(np.zeros(3), np.array([0, 0, dse]), radius, "upper arm")],
        "forearm": [Body(np.zeros(3), np.array([0, 0, dew]), 0.9 * radius, "forearm")],
        "hand": [Body(np.zeros(3), np.array([0, 0, dwf]), 0.8 * radius, "hand")],
    }
    if dbs > 0.0:
        bodies["base"] = [Body(np.zeros(3), np.array([0, 0, dbs]), radius, "column below the shoulder")]
    parameters = {"dbs": dbs, "dse": dse, "dew": dew, "dwf": dwf}
    return _arm("srs_arm", parameters, names, offsets, axes, (0, 0, dwf), limits, (2.0, 6.0), bodies, "")


def six_axis_arm(
    a1: float = 0.1,
    d1: float = 0.35,
    a2: float = 0.4,
    a3: float = 0.03,
    d4: float = 0.4,
    d6: float = 0.08,
    *,
    radius: float = 0.06,
) -> Robot:
    """A 6-joint industrial arm with a spherical wrist.

    Metres. Home: S = (a1, 0, d1), E = S + a2 z, W = E + (d4, 0, a3), tool point F = W + d6 x; axes z, y, y, x, y, x
    through 0, S, E, W, W, W. Limits 170, 120, 150, 180, 120, 180 degrees, 3 rad/s, 10 rad/s^2 and the capsule radius
    are our choice.
    """
    _positive(a2=a2, d4=d4, d6=d6)
    _finite(a1=a1, d1=d1, a3=a3)
    names = ("base", "column", "upper_arm", "forearm", "wrist_1", "wrist_2", "flange")
    offsets = ((0, 0, 0), (a1, 0, d1), (0, 0, a2), (d4, 0, a3), (0, 0, 0), (0, 0, 0))
    axes = (Z, Y, Y, X, Y, X)
    limits = np.radians([170.0, 120, 150, 180, 120, 180])
    bodies = {
        "column": [Body(np.zeros(3), np.array([a1, 0, d1]), radius, "column")],
        "upper_arm": [Body(np.zeros(3), np.array([0, 0, a2]), radius, "upper arm")],
        "forearm": [Body(np.zeros(3), np.array([d4, 0, a3]), radius, "forearm")],
        "flange": [Body(np.zeros(3), np.array([d6, 0, 0]), 0.6 * radius, "flange")],
    }
    parameters = {"a1": a1, "d1": d1, "a2": a2, "a3": a3, "d4": d4, "d6": d6}
    return _arm("six_axis_arm", parameters, names, offsets, axes, (d6, 0, 0), limits, (3.0, 10.0), bodies, "")


def _arm(form, parameters, names, offsets, axes, tool, limits, rates, bodies, source) -> Robot:
    parameters = {key: float(value) for key, value in parameters.items()}
    links = [Link(names[0], -1, _placement.IDENTITY)]
    for k, (offset, axis) in enumerate(zip(offsets, axes, strict=True)):
        links.append(Link(names[k + 1], k, _placement.from_translation(offset), "revolute", np.array(axis, float), k))
    n = len(axes)
    capsules = pack(bodies, list(names))
    bounds = Limits(-limits, limits, np.full(n, rates[0]), np.full(n, rates[1]), np.full(n, np.inf))
    pairs, table, dropped = _pairs.choose_pairs(links, bounds, capsules)
    text = ", ".join(f"{key}={value:g}" for key, value in parameters.items())
    return Robot(
        name=form.replace("_", "-"),
        links=tuple(links),
        tip=n,
        joint_names=tuple(f"joint_{k + 1}" for k in range(n)),
        limits=bounds,
        tool=_placement.from_translation(tool),
        closed_form=(form, parameters),
        capsules=capsules,
        self_pairs=pairs,
        pair_table=table,
        source=f"robots.{form}({text})" + (f", {source}" if source else ""),
        notes=("collision model: one capsule a segment", *dropped),
    )


def _finite(**values: float) -> None:
    for name, value in values.items():
        float_array(value, name, ndim=0)


def _positive(**values: float) -> None:
    _finite(**values)
    for name, value in values.items():
        if value <= 0:
            raise InputError(f"expected a positive length in metres, got {value:g}", place=name)
