"""The robot of a MoveIt problem: which of a URDF's joints move, and where the others stand."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import robots
from ..errors import InputError
from ._moveit import MoveItProblem

if TYPE_CHECKING:
    from ..robots import Robot
    from ..robots._srdf import Srdf
    from ..robots._urdf import Joint, Urdf


def robot_for(
    problem: MoveItProblem, robot: Robot | str | Path | None, tip: str | None = None, srdf: str | Path | None = None
) -> Robot:
    """The model to plan with: a Robot, or one that is loaded from a file or by name.

    Of a URDF the joints of the goal move (for a pose goal those of the request's group in the SRDF, else all that lie above its
    link); the others stand where the start state has them. Without `tip` it is the end of that chain. Raises InputError.
    """
    if robot is None:
        named = f" ({problem.robot_name!r})" if problem.robot_name else ""
        built_in = f"; {problem.robot_name!r} is one of them" if problem.robot_name in robots.names() else ""
        raise InputError(
            f"a MoveIt scene names its robot{named} and holds no model of it", place=problem.source,
            remedy=f"give the model (`robot`): a URDF, a robot file or a built-in name{built_in}",
        )  # fmt: skip
    if isinstance(robot, robots.Robot):
        if tip is not None or srdf is not None:
            raise InputError("tip and srdf are for a robot that is read from a URDF", place="robot")
        return robot
    path = Path(robot)
    if str(robot) in robots.names() or path.suffix.lower() in (".yaml", ".yml") or not path.is_file():
        return robots.load(robot, tip=tip, srdf=srdf)
    from ..robots._srdf import read_srdf
    from ..robots._urdf import MOVABLE, read_urdf

    urdf = read_urdf(path)
    group = _group(None if srdf is None else read_srdf(Path(srdf), urdf), problem.group)
    joints = {joint.name: joint for joint in urdf.joints.values() if joint.type in MOVABLE}
    tip, moving = _chain(problem, urdf, joints, tip, group)
    locked = {
        name: x for name, x in problem.start.items() if name in joints and name not in moving and not joints[name].mimic
    }
    return robots.load(path, tip=tip, srdf=srdf, locked=locked)


def _group(srdf: Srdf | None, name: str) -> tuple[str, str] | None:
    """Base and tip of the request's group, if the SRDF has it as a chain."""
    return None if srdf is None else srdf.groups.get(name)


def _chain(
    problem: MoveItProblem, urdf: Urdf, joints: dict[str, Joint], tip: str | None, group: tuple[str, str] | None
) -> tuple[str | None, set[str]]:
    """The tip, and the names of the joints that move."""
    problem.need_goal()
    goal: Any = problem.goals[0]
    if not isinstance(goal, dict):
        tip = tip or (group[1] if group else problem.goal_links[0] or None)
        base = group[0] if group else None
        above = _above(urdf, tip, base) if tip in urdf.joints else []
        return tip, {urdf.joints[link].name for link in above}
    strange = [name for name in goal if name not in joints]
    if strange:
        raise InputError(
            f"goal_constraints: {urdf.path.name} has no joint {', '.join(map(repr, strange))} that moves",
            place=problem.request or problem.source,
            remedy=f"the problem is for robot {problem.robot_name!r}, this one is {urdf.name!r}"
            if problem.robot_name
            else None,
            choices=sorted(joints),
        )
    return tip or (group[1] if group else _end(urdf, [joints[name] for name in goal])), set(goal)


def _above(urdf: Urdf, link: str, base: str | None = None) -> list[str]:
    """The links from `link` up to (without) `base` or the root, which a joint carries."""
    links = []
    while link in urdf.joints and link != base:
        links.append(link)
        link = urdf.joints[link].parent
    return links


def _end(urdf: Urdf, joints: list[Joint]) -> str | None:
    """The link that the last of the joints of one chain carries, or what hangs fixed on it; None if they are no chain."""
    last = max((joint.child for joint in joints), key=lambda link: len(_above(urdf, link)), default=None)
    if last is None or not {joint.child for joint in joints} <= set(_above(urdf, last)):
        return None
    children = urdf.children()
    while len(children[last]) == 1 and urdf.joints[children[last][0]].type == "fixed":
        last = children[last][0]
    return last
