"""A robot as the arrays that compiled code reads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..robots import Robot

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
KIND_NUMBER = {"fixed": 0, "revolute": 1, "prismatic": 2}


class Tree(NamedTuple):
    """The link tree of a robot; the order of the fields is the order of arguments in `_kernels.py`."""

    parents: Integers
    origins: Floats
    kinds: Integers
    axes: Floats
    coords: Integers
    mult: Floats
    offs: Floats


def tree(robot: Robot) -> Tree:
    """The arrays of all links, made once per robot; writable, so that each compiled loop sees one array type."""
    if "tree" not in robot.memo:
        links = robot.links
        robot.memo["tree"] = Tree(
            np.array([link.parent for link in links], np.int64),
            np.array([link.origin for link in links]),
            np.array([KIND_NUMBER[link.kind] for link in links], np.int64),
            np.array([link.axis for link in links]),
            np.array([link.coordinate for link in links], np.int64),
            np.array([link.multiplier for link in links]),
            np.array([link.offset for link in links]),
        )
    return robot.memo["tree"]


def chain(robot: Robot) -> Tree:
    """The chain from the base to the tool frame, without its fixed joints: parents i - 1, the last entry is the tool
    frame.

    Entry i < count of moving joints has the frame of the i-th link of the chain that moves.
    """
    if "chain" not in robot.memo:
        from ._joint_kernels import compose

        origins, moving = [], []
        pending = np.array([1.0, 0, 0, 0, 0, 0, 0, 0])
        for index in robot.chain:
            link = robot.links[index]
            pending = compose.reference(pending, link.origin)
            if link.kind != "fixed":
                origins.append(pending)
                moving.append(link)
                pending = np.array([1.0, 0, 0, 0, 0, 0, 0, 0])
        origins.append(compose.reference(pending, robot.tool))
        count = len(origins)
        robot.memo["chain"] = Tree(
            np.arange(-1, count - 1, dtype=np.int64),
            np.array(origins),
            np.array([KIND_NUMBER[link.kind] for link in moving] + [0], np.int64),
            np.array([link.axis for link in moving] + [np.array([0.0, 0.0, 1.0])]),
            np.array([link.coordinate for link in moving] + [-1], np.int64),
            np.array([link.multiplier for link in moving] + [1.0]),
            np.array([link.offset for link in moving] + [0.0]),
        )
    return robot.memo["chain"]
