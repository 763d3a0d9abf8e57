"""What the robot of a scene file holds, and what it may touch."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import InputError
from ..robots import Robot
from . import _schema as s
from ._files import resolve
from ._obstacles_read import read_obstacle
from ._problems import Reader
from ._yaml import Loc


def read_held(reader: Reader, data: Any, robot: Any, folder: Path) -> tuple[Any, tuple[Any, ...]]:
    """The robot with the objects of `attached`, and how they were written; problems are noted."""
    if data is None:
        return robot, ()
    if not isinstance(data, list):
        reader.fail(("attached",), "expected a list of objects, written like obstacles")
        return robot, ()
    if robot is not None and not isinstance(robot, Robot):
        reader.fail(("attached",), f"the robot {robot.name!r} holds nothing")
        return robot, ()
    specs = []
    for i, item in enumerate(data):
        loc: Loc = ("attached", i)
        if not isinstance(item, dict):
            reader.fail(loc, "expected fields, one of them 'type'", choices=s.OBSTACLES)
            continue
        spec = dict(item)
        before = len(reader.problems)
        own = reader.section(s.Held, {key: item[key] for key in s.HELD if key in item}, loc)
        try:
            shape = read_obstacle(reader, {k: v for k, v in item.items() if k not in s.HELD}, loc, folder, s.HELD)
            if own is not None and robot is not None and own.link is not None and own.link not in robot.link_names:
                reader.unknown((*loc, "link"), "link", own.link, robot.link_names)
            if len(reader.problems) > before or own is None or robot is None:
                continue
            name = item.get("name") or f"attached {i + 1}"
            robot = robot.with_attached([shape], link=own.link, name=name, allowed=own.allowed)
        except InputError as error:
            reader.caught(loc, error)
        if isinstance(spec.get("file"), str):
            spec["file"] = str(resolve(spec["file"], folder))
        specs.append(spec)
    return robot, tuple(specs)


def read_allowed(
    reader: Reader, data: Any, robot: Any, obstacles: list[Any]
) -> tuple[Any, tuple[tuple[str, str], ...]]:
    """The robot with the contacts of `allowed_obstacles`, pairs (link or attached object, obstacle); problems are noted."""
    if data is None:
        pairs = []
    elif not isinstance(data, list):
        reader.fail(("allowed_obstacles",), "expected a list of pairs [link, obstacle]")
        return robot, ()
    else:
        pairs = data
    if robot is not None and not isinstance(robot, Robot):
        if pairs:
            reader.fail(("allowed_obstacles",), f"the robot {robot.name!r} has no links")
        return robot, ()
    named = [o.name for o in obstacles if o is not None and getattr(o, "name", "")]
    good = []
    for i, pair in enumerate(pairs):
        loc: Loc = ("allowed_obstacles", i)
        if not isinstance(pair, list) or len(pair) != 2 or not all(isinstance(x, str) for x in pair):
            reader.fail(loc, "expected two names: [link or attached object, obstacle]")
        elif robot is None:
            continue
        elif pair[0] not in robot.link_names:
            reader.unknown((*loc, 0), "link or attached object", pair[0], robot.link_names)
        elif pair[1] not in named and pair[1] not in robot.link_names and None not in obstacles:
            reader.unknown((*loc, 1), "obstacle", pair[1], named)
        else:
            good.append((pair[0], pair[1]))
    if robot is None:
        return robot, ()
    for _, name in robot.allowed_obstacles:  # those of attached objects and robot files
        if name not in named and None not in obstacles:
            where = _written(reader.document.data, name)
            if where is not None:
                reader.unknown(where, "link or obstacle", name, [*named, *robot.link_names])
    return (robot.with_allowed(*good) if good else robot), tuple(good)


def _written(data: Any, name: str) -> Loc | None:
    """Where an attached object allows `name`; None if that stands in the file of the robot."""
    for i, item in enumerate(data.get("attached") or ()):
        if isinstance(item, dict) and name in (item.get("allowed") or ()):
            return ("attached", i, "allowed", item["allowed"].index(name))
    return None
