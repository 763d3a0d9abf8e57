"""Inverse kinematics of any robot: closed form where the structure allows it, else a numerical search."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from ..entities import Point
from ..errors import InputError
from ..robots._robot import require_robot
from ..versors import Motor
from ._classify import classify
from ._humanoid import humanoid_inverse
from ._point_arms import point_inverse
from ._solutions import IkSolutions
from ._structured import parameter_value, structured_inverse
from ._targets import GripperOnPlane
from ._wrist_arms import six_axis_inverse, srs_inverse


def inverse(
    robot: Any,
    target: Any,
    *,
    phi: ArrayLike | None = None,
    psi: ArrayLike | None = None,
    q7: ArrayLike | None = None,
    q1: ArrayLike | None = None,
    q5: ArrayLike | None = None,
    seed: ArrayLike | None = None,
    strict: bool = False,
    closed_form: bool = True,
    **options: Any,
) -> IkSolutions:
    """Every posture of the robot that brings its tip to the target. Radians, metres, base frame.

    target: Motor, the pose of the tip (...); for the 5-DOF humanoid arm also GripperOnPlane(point, normal); for arms of the
    kind us5 (NAO, Pepper) also Point, a position alone, with the redundancies psi and q5; for the numerical search what
    `numerical_inverse` takes. All leading axes broadcast.
    phi, psi, q7, q1, q5: (...) the redundancy that `classify(robot)` names. Left out, it is that of the seed; without a
    seed the value with the largest distance to the joint limits, for every branch its own (phi: 0; nothing limited: 0).
    seed: (..., n) where a free angle stays and a search starts. strict: the 5-DOF arm's whole gripper parallel to the
    plane. closed_form=False, or a robot without one: `numerical_inverse(robot, target, seed=seed, **options)`.
    Unreachable targets are values: `.valid` is False and `.reason` says why. Raises InputError for what cannot be used.
    """
    structure = require_robot(robot).memo.get("structure") or classify(robot)
    given = {"phi": phi, "psi": psi, "q7": q7, "q1": q1, "q5": q5}
    if closed_form and structure.position is not None and isinstance(target, Point):
        _no_options(options)
        for name in ("phi", "q7", "q1", "strict"):
            if {**given, "strict": strict or None}[name] is not None:
                raise InputError(
                    f"a position alone has no {name!r} with {robot.name!r}", place=name, choices=("psi", "q5", "seed")
                )
        return point_inverse(robot, target, psi=psi, q5=q5, seed=seed)
    pose = isinstance(target, Motor) or getattr(target, "shape", ())[-2:] == (4, 4)
    if not closed_form or not structure.is_closed_form or not (pose or isinstance(target, GripperOnPlane)):
        return _numerical(robot, target, structure.name, given, seed, strict, options)
    _no_options(options)
    value = parameter_value(structure, given, robot.name)
    if structure.name == "humanoid_arm":
        return humanoid_inverse(robot, target, phi=value, seed=seed, strict=strict)
    if strict or isinstance(target, GripperOnPlane):
        raise InputError(
            f"{'strict' if strict else 'GripperOnPlane'} belongs to the 5-DOF humanoid arm, and {robot.name!r} is not one",
            place="strict" if strict else "target", remedy="give a Motor, the tip's pose",
        )  # fmt: skip
    if structure.name == "srs_arm":
        return srs_inverse(robot, target, psi=value, seed=seed)
    if structure.name == "six_axis_arm":
        return six_axis_inverse(robot, target, seed=seed)
    return structured_inverse(robot, target, parameter=value, seed=seed)


def _no_options(options: dict[str, Any]) -> None:
    if options:
        raise InputError(
            f"unknown option {next(iter(options))!r} of a closed form", place="inverse", remedy="or closed_form=False",
            choices=("seed", "phi", "psi", "q7", "q1", "q5", "strict", "closed_form"),
        )  # fmt: skip


def _numerical(robot, target, name, given, seed, strict, options) -> IkSolutions:
    from ._numeric import numerical_inverse

    for key, value in {**given, "strict": strict or None}.items():
        if value is not None:
            raise InputError(
                f"the numerical inverse of {robot.name!r} has no {key!r}", place=key, remedy="leave it out"
            )
    if isinstance(target, GripperOnPlane):
        raise InputError(
            f"GripperOnPlane is a target of the 5-DOF humanoid arm, and {robot.name!r} ({name}) is not one",
            place="target", remedy="give a Motor, or (Point, direction)",
        )  # fmt: skip
    return numerical_inverse(robot, target, seed=seed, **options)
