"""Objects in the gripper, and contacts that are allowed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import InputError, unknown_name
from ..numeric import at_most, float_array
from ..shapes import Ball, Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Mesh, PointCloud, Shape, as_shapes
from . import _bodies, _pairs, _placement
from ._bodies import Body, Floats
from ._cover import ROUNDING, CoverOptions, cover_box, cover_cylinder, cover_triangles
from ._robot import Capsules, Link, LinkPair, Robot, require_robot


def attach(
    robot: Robot,
    bodies: Any,
    *,
    link: str | None = None,
    pose: Any = None,
    name: str = "attached",
    allowed: Iterable[str] = (),
    collision: str = "capsules",
    budget: int | None = None,
    tolerance: float | None = None,
) -> Robot:
    """The robot holding an object: a link of its own with the object's bodies, fixed to `link` (default: the tip).

    bodies: obstacle shapes (see `shapes.as_shapes`) or `Capsules`, in the object's frame. pose: Motor, (8,) motor array or 4x4
    matrix of that frame in the frame of `link`; default: the tool frame on the tip, else the link's own frame. Shapes are covered
    like the geometry of a URDF (`collision`, `budget`, `tolerance` of `load`), the notes say with what slack.
    The object is checked against every link that a joint lies between, and every obstacle, but those named in `allowed`: links
    (and then their bodies are not checked against it) or obstacles (kept in `allowed_obstacles`). Raises InputError.
    """
    require_robot(robot)
    if not isinstance(name, str) or not name:
        raise InputError(f"expected a name, got {name!r:.60}", place="name")
    names = [allowed] if isinstance(allowed, str) or not isinstance(allowed, Iterable) else list(allowed)
    if isinstance(allowed, str) or not all(isinstance(other, str) for other in names):
        raise InputError(f"expected names, got {allowed!r}", place="allowed")
    index = robot.tip if link is None else _index(robot, link)
    if name in robot.link_names:
        raise InputError(
            f"the robot already has a link {name!r}", place="name", remedy="detach it first, or give another name"
        )
    frame = _motor(pose, robot.tool if pose is None and index == robot.tip else _placement.IDENTITY)
    found = _read(bodies, CoverOptions(collision, budget, tolerance))  # type: ignore[arg-type]
    new = len(robot.links)
    links = (*robot.links, Link(name, index, frame))
    capsules = _joined(robot.capsules, found, new)
    grown = replace(robot, links=links, capsules=capsules)
    near = {other for other in names if other in robot.link_names}
    # the link it hangs on is one rigid part with it; at the joint of that part the object overlaps by no design, so it is checked
    group = _pairs.rigid_groups(links)
    rows, kept, notes = _pairs.judge(grown, [(int(k), new) for k in np.unique(robot.capsules.link)], group, near)
    slack = max((body.slack for body in found), default=0.0)
    return replace(
        grown,
        self_pairs=np.concatenate([robot.self_pairs, kept]),
        pair_table=(*robot.pair_table, *rows),
        allowed_obstacles=(*robot.allowed_obstacles, *((name, other) for other in names if other not in near)),
        notes=(
            *robot.notes,
            f"{name} attached to {robot.links[index].name}: {len(found)} bodies, slack at most {at_most(slack, decimals=4)} m",
            *notes,
        ),
    )


def detach(robot: Robot, name: str = "attached") -> Robot:
    """The robot without an object that was attached; nothing else may hang on it. Raises InputError."""
    index = _index(robot, name)
    if index != len(robot.links) - 1 and any(link.parent >= index for link in robot.links[index + 1 :]):
        raise InputError(f"links hang on {name!r}", place="name")
    if index in robot.chain or robot.links[index].kind != "fixed":
        raise InputError(f"{name!r} is part of the robot", place="name")
    keep = robot.capsules.link != index
    caps = robot.capsules
    link = caps.link[keep] - (caps.link[keep] > index)
    notes = tuple(note for note, k in zip(caps.note, keep) if k)
    pairs = robot.self_pairs[(robot.self_pairs != index).all(axis=1)]
    return replace(
        robot,
        links=robot.links[:index] + robot.links[index + 1 :],
        capsules=Capsules(link, caps.a[keep], caps.b[keep], caps.radius[keep], notes),
        self_pairs=pairs - (pairs > index),
        tip=robot.tip - (robot.tip > index),
        pair_table=tuple(p for p in robot.pair_table if name not in (p.first, p.second)),
        allowed_obstacles=tuple(p for p in robot.allowed_obstacles if p[0] != name),
        notes=tuple(note for note in robot.notes if not note.startswith(f"{name} attached")),
    )


def allow(robot: Robot, pairs: Iterable[tuple[str, str]], reason: str = "allowed by the caller") -> Robot:
    """The robot with contacts that are allowed: pairs of two of its links, or of a link and the name of an obstacle.

    Two links: out of `self_pairs`, and `pair_table` says so, with the `reason`. A link and anything else: into `allowed_obstacles`.
    """
    free: set[frozenset[str]] = set()
    obstacles = list(require_robot(robot).allowed_obstacles)
    for pair in pairs if isinstance(pairs, Iterable) else (pairs,):
        if isinstance(pair, str) or not isinstance(pair, Sequence) or len(pair) != 2:
            raise InputError(f"expected pairs of two names, got {pair!r}", place="with_allowed")
        first, second = map(str, pair)
        if first not in robot.link_names and second in robot.link_names:
            first, second = second, first
        _index(robot, first)
        if second in robot.link_names:
            free.add(frozenset((first, second)))
        elif (first, second) not in obstacles:
            obstacles.append((first, second))
    names = robot.link_names
    keep = [frozenset((names[i], names[j])) not in free for i, j in robot.self_pairs]
    table = [p for p in robot.pair_table if frozenset((p.first, p.second)) not in free]
    for first, second in sorted(tuple(sorted(pair)) for pair in free):
        table.append(LinkPair(first, second, False, reason))
    return replace(
        robot,
        self_pairs=robot.self_pairs[np.array(keep, bool)],
        pair_table=tuple(table),
        allowed_obstacles=tuple(obstacles),
    )


def _index(robot: Robot, name: str) -> int:
    if not isinstance(name, str) or name not in require_robot(robot).link_names:
        raise unknown_name("link", name, require_robot(robot).link_names, place="link")
    return robot.link_names.index(name)


def _motor(pose: Any, default: Floats) -> Floats:
    if pose is None:
        return default
    array = float_array(getattr(pose, "array", pose), "pose")
    if array.shape == (8,):
        return array
    if array.shape != (4, 4):
        raise InputError(f"expected a Motor, (8,) or (4, 4), got {array.shape}", place="pose")
    if np.abs(array[:3, :3] @ array[:3, :3].T - np.eye(3)).max() > 1e-9 or np.linalg.det(array[:3, :3]) < 0.0:
        raise InputError("not a rigid motion", place="pose")
    return _placement.from_matrix(array)


def _read(bodies: Any, options: CoverOptions) -> list[Body]:
    """Bodies in the object's frame."""
    if isinstance(bodies, Capsules):
        return [
            Body(bodies.a[k], bodies.b[k], float(bodies.radius[k]), bodies.note[k] or "given")
            for k in range(len(bodies))
        ]
    shapes = as_shapes(bodies)
    if not shapes:
        raise InputError("expected at least one shape", place="attach")
    return [body for shape in shapes for body in _bodies_of(shape, options)]


def _bodies_of(shape: Shape, options: CoverOptions) -> list[Body]:
    if isinstance(shape, Ball) and shape.dimension == 3:
        return [Body(shape.center, shape.center, shape.radius, "sphere, exact")]
    if isinstance(shape, Capsule):
        body = Body(shape.a, shape.b, shape.radius, "capsule, exact")
        return (
            [body]
            if options.kind == "capsules"
            else _bodies.as_balls(body, options.most, options.tolerance_for(2.0 * shape.radius))
        )
    if isinstance(shape, Cylinder) and options.kind == "capsules":
        frame, length = _frame_along(shape)
        single = cover_cylinder(shape.radius, length, options)
        if single is not None:
            return [body.moved(frame.T, 0.5 * (shape.a + shape.b)) for body in single]
    if isinstance(shape, Box) and options.kind == "capsules":
        parallel = cover_box(2.0 * shape.half_sizes, options)
        if parallel is not None:
            return [body.moved(shape.rotation, shape.center) for body in parallel]
    if isinstance(shape, PointCloud):
        radii = np.broadcast_to(shape.radius, len(shape.points))
        return [Body(p, p, float(r), "point, exact") for p, r in zip(shape.points, radii)]
    if isinstance(shape, HalfSpace) or shape.dimension != 3:
        raise InputError(f"a {type(shape).__name__} cannot be held", place="attach")
    turn = shape.rotation if isinstance(shape, Box | Ellipsoid) else None
    if isinstance(shape, Cylinder):
        turn = _frame_along(shape)[0].T
    found, slack = cover_triangles(triangles_of(shape), options, turn)
    if isinstance(shape, Cylinder):
        slack += ROUNDING * shape.radius
    note = f"{type(shape).__name__.lower()}, slack at most {at_most(slack, decimals=4)} m"
    return [Body(b.a, b.b, b.radius, note, slack) for b in found]


def triangles_of(shape: Shape) -> Floats:
    """Triangles (t, 3, 3) round a solid: of a mesh its own; else none of the solid lies outside them."""
    from ._cover import box_triangles, cylinder_triangles

    if isinstance(shape, Mesh):
        return shape.vertices[shape.faces]
    if isinstance(shape, Box):
        return box_triangles(2.0 * shape.half_sizes) @ shape.rotation.T + shape.center
    if isinstance(shape, Cylinder):
        frame, length = _frame_along(shape)
        return cylinder_triangles(shape.radius, length) @ frame + 0.5 * (shape.a + shape.b)
    if isinstance(shape, Ellipsoid):
        z = np.linspace(0.0, np.pi, 17)
        angle = np.linspace(0.0, 2.0 * np.pi, 33)
        grid = np.stack(
            [np.outer(np.sin(z), np.cos(angle)), np.outer(np.sin(z), np.sin(angle)), np.outer(np.cos(z), np.ones(33))],
            axis=-1,
        )
        a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
        ball = np.concatenate(
            [np.stack([a, b, c], axis=-2).reshape(-1, 3, 3), np.stack([a, c, d], axis=-2).reshape(-1, 3, 3)]
        )
        # faces of a polyhedron with its corners on the sphere come as near as this to the middle
        normal = np.cross(ball[:, 1] - ball[:, 0], ball[:, 2] - ball[:, 0])
        size = np.linalg.norm(normal, axis=1)
        near = np.abs((normal * ball[:, 0]).sum(axis=1))[size > 1e-12] / size[size > 1e-12]
        return ball / near.min() * shape.semi_axes @ shape.rotation.T + shape.center
    raise InputError(f"no surface of a {type(shape).__name__}", place="attach")


def _frame_along(shape: Cylinder) -> tuple[Floats, float]:
    """Rows (3, 3) of a frame with its z along a cylinder, and its length (m)."""
    u = shape.b - shape.a
    length = float(np.linalg.norm(u))
    side = np.cross(u, np.eye(3)[int(np.argmin(np.abs(u)))])
    side /= np.linalg.norm(side)
    return np.array([side, np.cross(u / length, side), u / length], dtype=np.float64), length


def _joined(first: Capsules, bodies: list[Body], link: int) -> Capsules:
    return Capsules(
        np.concatenate([first.link, np.full(len(bodies), link, np.int64)]),
        np.concatenate([first.a, [body.a for body in bodies]]),
        np.concatenate([first.b, [body.b for body in bodies]]),
        np.concatenate([first.radius, [body.radius for body in bodies]]),
        (*first.note, *(body.note for body in bodies)),
    )
