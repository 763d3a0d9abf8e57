"""A robot as the tree planner sees it: moving frames, balls over its bodies, and how far anything can reach."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..robots import Robot
from ..robots._placement import rotation_translation

Floats = NDArray[np.float64]
ROUNDING = 2.0**-24
"""Largest relative error of one operation in single precision."""
LOOSE = 2.0
"""A group of balls is split while the ball round it is more than this many times as large as its largest."""


@dataclass(frozen=True, eq=False)
class Frames:
    """The moving frames of a robot: frame 0 is the base, every joint that moves starts one; z is its axis.

    `joints` (F, 2): parent frame, coordinate. `data` (F, 16): see `_edge_kernels`. `of_link` (L,): the frame a link is fixed
    to, `in_frame` (L, 4, 4) its pose there.
    """

    joints: NDArray[np.int64]
    data: Floats
    of_link: NDArray[np.int64]
    in_frame: Floats


@dataclass(frozen=True, eq=False)
class Balls:
    """Balls that hold the robot's bodies, at two levels: all that is fixed to one frame, and compact groups of one link.

    `bodies` (C, 3): frame, first group, last + 1. `groups` (G, 2): first ball, last + 1; `links` (G,) the link of each.
    `body_bounds` (C, 4), `bounds` (G, 4), `balls` (B, 4): centre and radius in the frame. `allowed` (C,): names of the obstacles
    that the links of a body may touch, the same for all of them.
    `inflation`: no ball reaches further than this (metres) beyond what it covers.
    """

    bodies: NDArray[np.int64]
    body_bounds: Floats
    groups: NDArray[np.int64]
    links: NDArray[np.int64]
    bounds: Floats
    balls: Floats
    inflation: float
    allowed: tuple[tuple[str, ...], ...] = ()


def moving_frames(robot: Robot) -> Frames:
    """Fixed links joined to the frame that carries them; each frame turned so that its joint's axis is z."""
    of_link = np.zeros(len(robot.links), np.int64)
    in_frame = np.zeros((len(robot.links), 4, 4))
    joints, data = [(0, 0)], [np.zeros(16)]
    for i, link in enumerate(robot.links):
        step = _matrix(link.origin)
        if link.parent >= 0:
            of_link[i] = of_link[link.parent]
            step = in_frame[link.parent] @ step
        if link.kind != "fixed":
            to_z = np.eye(4)
            to_z[:3, :3] = _turn_to_z(link.axis / np.linalg.norm(link.axis))
            placed = step @ to_z
            row = np.zeros(16)
            row[0:9], row[9:12] = placed[:3, :3].T.ravel(), placed[:3, 3]
            row[12 if link.kind == "revolute" else 14] = link.multiplier
            row[13 if link.kind == "revolute" else 15] = link.offset
            joints.append((int(of_link[i]), link.coordinate))
            data.append(row)
            of_link[i] = len(joints) - 1
            step = to_z.T
        in_frame[i] = step
    return Frames(np.array(joints, np.int64), np.array(data), of_link, in_frame)


def cover(robot: Robot, frames: Frames, fineness: float) -> Balls:
    """Balls over all capsules: exact for a sphere; on a segment so dense that no radius grows by more than `fineness` (m)."""
    may = [tuple(sorted(other for own, other in robot.allowed_obstacles if own == name)) for name in robot.link_names]
    found: dict[tuple[int, tuple[str, ...]], list[tuple[int, Floats]]] = {}
    worst = 0.0
    bodies = robot.capsules
    for link in np.unique(bodies.link):
        pose = frames.in_frame[link]
        own: list[Floats] = []
        for k in np.flatnonzero(bodies.link == link):
            a, b, r = bodies.a[k], bodies.b[k], float(bodies.radius[k])
            length = float(np.linalg.norm(b - a))
            pieces, grown = 0, r
            if length > 1e-9:
                pieces = math.ceil(length / (2.0 * math.sqrt(2.0 * r * fineness + fineness**2)))
                grown = math.hypot(r, 0.5 * length / pieces)
            worst = max(worst, grown - r)
            along = np.linspace(0.0, 1.0, pieces + 1)[:, None] if pieces else np.zeros((1, 1))
            centres = (a + along * (b - a)) @ pose[:3, :3].T + pose[:3, 3]
            own.append(np.column_stack([centres, np.full(len(centres), grown)]))
        key = int(frames.of_link[link]), may[link]
        found.setdefault(key, []).extend((int(link), g) for g in _compact(np.concatenate(own)))
    sets = [(frame, link, group) for frame in sorted(found) for link, group in found[frame]]
    ends = np.cumsum([0] + [len(group) for _, _, group in sets])
    counts = np.cumsum([0] + [len(found[frame]) for frame in sorted(found)])
    whole = [np.concatenate([group for _, group in found[frame]]) for frame in sorted(found)]
    return Balls(
        np.column_stack([[frame for frame, _ in sorted(found)], counts[:-1], counts[1:]])
        .astype(np.int64)
        .reshape(-1, 3),
        np.array([enclosing_ball(balls) for balls in whole]).reshape(-1, 4),
        np.column_stack([ends[:-1], ends[1:]]).astype(np.int64),
        np.array([link for _, link, _ in sets], np.int64),
        np.array([enclosing_ball(group) for _, _, group in sets]).reshape(-1, 4),
        np.concatenate(whole) if whole else np.zeros((0, 4)),
        worst,
        tuple(names for _, names in sorted(found)),
    )


def _compact(balls: Floats) -> list[Floats]:
    """Balls cut across their longest direction until a ball round a part is not much larger than the largest in it."""
    if len(balls) < 4 or enclosing_ball(balls, 2)[3] < LOOSE * balls[:, 3].max():
        return [balls]
    centred = balls[:, :3] - balls[:, :3].mean(axis=0)
    along = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
    order = np.argsort(along, kind="stable")
    half = len(balls) // 2
    return [part for piece in (order[:half], order[half:]) for part in _compact(balls[np.sort(piece)])]


def enclosing_ball(balls: Floats, rounds: int = 24) -> Floats:
    """Centre and radius (4,) of a small ball that holds balls (m, 4): from the middle of their box by steps to the furthest."""
    centre = 0.5 * ((balls[:, :3] - balls[:, 3:]).min(axis=0) + (balls[:, :3] + balls[:, 3:]).max(axis=0))
    best, radius = centre, np.inf
    for k in range(1, rounds):
        offset = balls[:, :3] - centre
        distance = np.sqrt((offset**2).sum(axis=1))
        reach = distance + balls[:, 3]
        far = int(np.argmax(reach))
        if reach[far] < radius:
            best, radius = centre, reach[far]
        if distance[far] < 1e-12:
            break
        centre = centre + 0.25 / (k + 1.0) * offset[far]
    return np.array([*best, radius + (1e-6 if len(balls) > 1 else 0.0)])


def body_pairs(robot: Robot, frames: Frames, balls: Balls) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """`pairs` (P, 5) and `group_pairs` (K, 2) of `_edge_kernels`, from the pairs of links that are to be checked."""
    body_of = np.repeat(np.arange(len(balls.bodies)), balls.bodies[:, 2] - balls.bodies[:, 1])
    wanted: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for i, j in robot.self_pairs:
        for a in np.flatnonzero(balls.links == i):
            for b in np.flatnonzero(balls.links == j):
                ga, gb = sorted((int(a), int(b)), key=lambda g: int(body_of[g]))
                if body_of[ga] != body_of[gb]:
                    wanted.setdefault((int(body_of[ga]), int(body_of[gb])), []).append((ga, gb))
    pairs, rows = [], []
    for (a, b), groups in sorted(wanted.items()):
        meet = _common_ancestor(frames.joints, int(balls.bodies[a, 0]), int(balls.bodies[b, 0]))
        pairs.append((a, b, meet, len(rows), len(rows) + len(groups)))
        rows += sorted(groups)
    return np.array(pairs, np.int64).reshape(-1, 5), np.array(rows, np.int64).reshape(-1, 2)


def spans(frames: Frames, balls: Balls, low: Floats, high: Floats) -> tuple[Floats, Floats, Floats]:
    """A point that does not move (3,); no point of body c is ever further from it than (C,); and from the axis of frame f (F,)."""
    count = len(frames.joints)
    root = frames.data[1, 9:12].copy() if count > 1 else np.zeros(3)
    slide = np.zeros(count)
    for f in range(1, count):
        c = frames.joints[f, 1]
        ends = frames.data[f, 14] * np.array([low[c], high[c]]) + frames.data[f, 15]
        slide[f] = np.abs(ends).max()
    distance = np.zeros(count)
    for f in range(1, count):
        parent, origin = frames.joints[f, 0], frames.data[f, 9:12]
        distance[f] = slide[f] + (
            distance[parent] + np.linalg.norm(origin) if parent else np.linalg.norm(origin - root)
        )
    local = np.linalg.norm(balls.body_bounds[:, :3], axis=1) + balls.body_bounds[:, 3]
    still = np.linalg.norm(balls.body_bounds[:, :3] - root, axis=1) + balls.body_bounds[:, 3]
    span = np.array([distance[f] + s if f else t for f, s, t in zip(balls.bodies[:, 0], local, still)])
    lever = np.zeros(count)  # longest distance of a body's point from frame f's origin, below f in the tree
    for g, f in enumerate(balls.bodies[:, 0]):
        total, f = local[g], int(f)
        while f:
            lever[f] = max(lever[f], total)
            total += np.linalg.norm(frames.data[f, 9:12]) + slide[f]
            f = int(frames.joints[f, 0])
    return root, span, lever


def position_error(frames: Frames, lever: Floats, span: Floats, root: Floats, low: Floats, high: Floats) -> float:
    """Bound (m) of the error of a ball's centre in single precision, at any configuration of the search region.

    Derived in docs/planner.md: angles are wrong by at most 8 A u, a frame's axes by at most (8 A + 20) u a joint.
    """
    depth = np.zeros(len(lever))
    angle, slide = 0.0, 0.0
    for f in range(1, len(lever)):
        depth[f] = depth[frames.joints[f, 0]] + 1
        c = frames.joints[f, 1]
        turn, turn_offset, push, push_offset = frames.data[f, 12:16]
        furthest = max(abs(low[c]), abs(high[c]))
        angle = max(angle, abs(turn) * furthest + abs(turn_offset))
        slide += abs(push) * furthest + abs(push_offset)
    size = float(np.abs(root).max() + span.max(initial=0.0))
    turning = 2.0 * (8.0 * angle + 20.0) * float(lever.sum())
    return ROUNDING * (turning + 8.0 * slide + 10.0 * float(depth.max(initial=0.0)) * size)


def _matrix(motor: Any) -> Floats:
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = rotation_translation(motor)
    return result


def _turn_to_z(axis: Floats) -> Floats:
    """A rotation whose third column is `axis`; the identity for z."""
    if axis[2] > 1.0 - 1e-15:
        return np.eye(3)
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = np.cross(helper, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def _common_ancestor(joints: NDArray[np.int64], a: int, b: int) -> int:
    above = {0}
    while a:
        above.add(a)
        a = int(joints[a, 0])
    while b not in above:
        b = int(joints[b, 0])
    return b
