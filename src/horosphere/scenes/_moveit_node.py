"""A value of a ROS message written as YAML that knows its place, and poses in it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ._targets import quaternion_matrix
from ._yaml import Document, Loc

Floats = NDArray[np.float64]
_EULER = "Euler angles are written as orientation_euler_xyz: radians, about the fixed axes x, y, z in that order"


class Node:
    """A value of a YAML document that knows its place."""

    def __init__(self, document: Document, loc: Loc, value: Any) -> None:
        self.document, self.loc, self.value = document, loc, value

    @staticmethod
    def root(document: Document) -> Node:
        for problem in document.problems:
            raise InputError(problem.message, place=document.place(problem.loc), remedy=problem.remedy)
        node = Node(document, (), document.data)
        if not isinstance(document.data, dict):
            raise node.error("expected the fields of a MoveIt message", "planning scene or motion-plan request as YAML")
        return node

    def error(self, message: str, remedy: str | None = None, choices: Any = None) -> InputError:
        return InputError(message, place=self.place, remedy=remedy, choices=choices)

    @property
    def place(self) -> str:
        """file:line:column"""
        return self.document.place(self.loc)

    def get(self, name: str) -> Any:
        if not isinstance(self.value, dict):
            raise self.error(f"expected fields, {name!r} among them, got {type(self.value).__name__}")
        value = self.value.get(name)
        return None if value is None else Node(self.document, (*self.loc, name), value)

    def need(self, name: str) -> Node:
        node = self.get(name)
        if node is None:
            raise self.error(f"missing field {name!r}")
        return node

    def plain(self, name: str) -> Any:
        node = self.get(name)
        return None if node is None else node.value

    def items(self, name: str) -> list[Node]:
        node = self.get(name)
        if node is None:
            return []
        if not isinstance(node.value, list):
            raise node.error(f"expected a list, got {type(node.value).__name__}")
        return [Node(self.document, (*node.loc, k), value) for k, value in enumerate(node.value)]

    def number(self) -> float:
        """A finite number."""
        value = self.value
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self.error(f"expected a finite number, got {value!r}")
        return float(value)

    def make(self, kind: Callable[..., Any], *arguments: Any, **fields: Any) -> Any:
        """What a constructor makes of it; what it refuses is said at this place."""
        try:
            return kind(*arguments, **fields)
        except InputError as error:
            raise self.error(error.message, error.remedy, error.choices) from None

    def numbers(self, count: int | None = None, keys: tuple[str, ...] = ()) -> Floats:
        """A list of finite numbers, or fields x, y, z ..."""
        value = self.value
        if isinstance(value, dict) and keys and set(value) >= set(keys):
            value = [value[key] for key in keys]
        good = isinstance(value, list) and all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in value)
        array = np.array(value if good else [np.nan], np.float64)
        if (count is not None and len(array) != count) or not np.isfinite(array).all():
            raise self.error(
                f"expected {count if count is not None else ''} finite numbers, got {value!r}".replace("  ", " ")
            )
        return array


def pose_of(node: Node | None) -> Floats:
    """4x4 from position and orientation (x, y, z, w), or Euler angles about the fixed axes x, y, z in that order."""
    pose = np.eye(4)
    if node is None:
        return pose
    position = node.get("position") or node.get("translation")
    if position is not None:
        pose[:3, 3] = position.numbers(3, ("x", "y", "z"))
    turn = node.get("orientation") or node.get("rotation")
    if turn is not None:
        if isinstance(turn.value, list) and len(turn.value) == 3:
            raise turn.error("expected a quaternion (x, y, z, w), got 3 numbers", _EULER)
        x, y, z, w = turn.numbers(4, ("x", "y", "z", "w"))
        length = float(np.sqrt(x * x + y * y + z * z + w * w))
        if abs(length - 1.0) > 1e-3:
            raise turn.error(f"expected a unit quaternion (x, y, z, w), its length is {length:.4g}")
        pose[:3, :3] = quaternion_matrix(np.array([w, x, y, z]) / length)
    euler = node.get("orientation_euler_xyz")
    if euler is not None:
        if turn is not None:
            raise euler.error("two rotations, this and a quaternion", "keep one of them")
        a, b, c = euler.numbers(3, ("x", "y", "z"))
        if max(abs(a), abs(b), abs(c)) > 2.0 * math.pi:
            raise euler.error(f"{max(a, b, c, key=abs):g} radians are more than a turn", "angles are radians")
        (ca, cb, cc), (sa, sb, sc) = np.cos([a, b, c]), np.sin([a, b, c])
        x_turn = np.array([[1, 0, 0], [0, ca, -sa], [0, sa, ca]])
        y_turn = np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
        z_turn = np.array([[cc, -sc, 0], [sc, cc, 0], [0, 0, 1]])
        pose[:3, :3] = z_turn @ y_turn @ x_turn
    return pose


def inverse(pose: Floats) -> Floats:
    inverse = np.eye(4)
    inverse[:3, :3] = pose[:3, :3].T
    inverse[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return inverse
