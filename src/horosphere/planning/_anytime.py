"""With time left: the path that was found gets shorter and keeps further away, and is never worse than it was."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..distance import pack_obstacles, signed
from ..numeric import at_least
from ..robots import Robot
from ..shapes import as_shapes
from ._packet_kernels import CHECK, CHUNK, GROW
from ._tree import Search, TreeResult
from ._tree_space import COVER, Space, model_of

Floats = NDArray[np.float64]
COMFORT, OWN_COMFORT = 1 / 16, 1 / 160
"""Distance (share of the robot's reach, 7 cm an arm) from which on more of it is worth nothing; between its own links less."""
WORTH = 2.0
"""What a way right along an obstacle costs more than the same way in the open, as a factor less one."""
FRUITLESS, GAIN = 12, 0.01
"""Trees are grown from other samples until so many in a row have gained less than this share."""
SPACING, MOST_POINTS, ROUNDS, PATIENCE = 0.12, 96, 150, 8
"""Of the band: units between its points, how many at most, rounds, and rounds without 0.1 % of gain before it rests."""
THINNED = (8, 5, 3)
"""Every so many-th point of the band is tried as a waypoint."""


@dataclass(frozen=True, slots=True)
class Improvement:
    """What the time after the first certified plan brought.

    Of the first plan and of this one: length of the joint motion (rad; sliding in reaches), certified clearance (m), mean
    clearance along the motion (m; what is beyond 1/16 of the robot's reach counts as that), duration (s).
    `rounds`: trees grown and rounds of the band. `converged`: it stopped because nothing more was gained, so that more
    time would not have changed the result; else the time was over.
    """

    first_length: float
    length: float
    first_clearance: float
    clearance: float
    first_mean_clearance: float
    mean_clearance: float
    first_duration: float
    duration: float
    rounds: int
    seconds: float
    converged: bool

    def __str__(self) -> str:
        why = "until no more was to be gained" if self.converged else "all the time given"
        if (self.length, self.mean_clearance) == (self.first_length, self.first_mean_clearance):
            return f"no better motion than the first was found in {self.seconds:.2f} s ({why})"
        return (
            f"improved for {self.seconds:.2f} s ({why}): "
            f"length {self.first_length:.3g} -> {self.length:.3g} rad, clearance "
            f"{at_least(self.first_clearance, 3, power=3)} -> {at_least(self.clearance, 3, power=3)} mm (mean "
            f"{1e3 * self.first_mean_clearance:.3g} -> {1e3 * self.mean_clearance:.3g} mm), duration "
            f"{self.first_duration:.3g} -> {self.duration:.3g} s"
        )


def path_length(robot: Robot, q: Floats) -> float:
    """Length of a joint path (k, n), rad; a slide counts in the robot's reach (to a power of two)."""
    weight = model_of(robot, COVER[0]).weight
    return float(np.linalg.norm(np.diff(q * weight, axis=0), axis=1).sum())


class Improver:
    """Makes certified paths better for as long as there is time; `candidates` yields them, each better than the one before."""

    def __init__(
        self,
        robot: Robot,
        found: TreeResult,
        goals: Floats,
        obstacles: Any,
        *,
        clearance: float,
        self_clearance: float,
        seed: int,
        seconds: float,
        kept: float,
    ) -> None:
        self.search = Search(robot, found.waypoints[0], goals, as_shapes(obstacles), clearance, self_clearance, seed)
        self.space = space = Space(self.search, COVER[0]).pack()
        self.seed, self.first = seed, found.waypoints
        self.solids, self.asked = pack_obstacles(self.search.shapes), (clearance, self_clearance)
        self.comfort, self.own_comfort = COMFORT * space.model.reach, OWN_COMFORT * space.model.reach
        self.low, self.high = (q.astype(np.float64) for q in (space.low, space.high))
        # extra margins (m): that of the first path, what its motion keeps (`kept`), and more
        levels = (found.rung, kept - clearance, *(kept - clearance + k * self.comfort / 8 for k in (1, 2, 4)))
        self.levels = sorted({x for x in levels if x >= found.rung})
        self.begin = perf_counter()
        self.deadline = self.begin + seconds
        self.rounds = 0

    @property
    def is_over(self) -> bool:
        return perf_counter() >= self.deadline

    def candidates(self) -> Iterator[Floats]:
        """Paths (k, n), certified at the clearance asked for: the best trees of each margin, then what bands make of them."""
        first = self.cost(self.scaled(self.first))
        best = dict.fromkeys(self.levels, (np.inf, self.first))
        open_levels, fruitless, number = list(self.levels), 0, 0
        while open_levels and fruitless < FRUITLESS and not self.is_over:
            level = open_levels[number % len(open_levels)]
            number += 1
            other = self.regrown(number, level)
            if other is None:  # start or goal is nearer to something than that, or there is no way that wide
                fruitless += 1
                open_levels.remove(level)
                continue
            value = self.cost(self.scaled(other))
            least = min(first, min(cost for cost, _ in best.values()))
            fruitless = 0 if value < (1.0 - GAIN) * least else fruitless + 1
            if value < best[level][0]:
                best[level] = value, other
        found = sorted((cost, level) for level, (cost, _) in best.items() if cost < np.inf)
        yield from (best[level][1] for _, level in found)
        roots = [(level, best[level][1]) for _, level in found[:1]] + [
            (level, self.first) for level in self.levels[1::-1]
        ]
        for level, path in roots:
            band = None if self.is_over else self.relaxed(path, level)
            if band is not None:  # a spline through fewer points bends less
                yield from (band[_every(len(band), k)] for k in THINNED)

    def scaled(self, q: Floats) -> Floats:
        return q * self.space.model.weight

    def regrown(self, number: int, extra: float) -> Floats | None:
        """A path of trees grown from other samples with an extra margin, shortened and certified."""
        self.rounds += 1
        search, space = self.search, self.space
        space.use_samples(self.seed + 7919 * number)
        deadline = 1e9 * self.deadline
        count = space.run(GROW, self.rung(extra), goals=search.goals, shorten=True, deadline=deadline)
        return search.found(space, count, list(range(len(search.goals)))).waypoints if count > 0 else None

    def rung(self, extra: float) -> Floats:
        """For `plan`."""
        return np.array([[extra, min(extra, self.levels[0]), CHUNK, 0]])

    def rooms(self, points: Floats) -> tuple[Floats, Floats]:
        """How far points (k, n) are beyond what is asked for, in shares of the comfort (0 to 1), and the slopes."""
        robot, weight = self.search.robot, self.space.model.weight
        q = np.ascontiguousarray(points / weight)
        outer, slope = signed(robot, q, self.solids, True, static=False)
        inner, own = signed(robot, q, (), True, self_collision=True)
        outer, inner = (outer - self.asked[0]) / self.comfort, (inner - self.asked[1]) / self.own_comfort
        room = np.minimum(outer, inner)
        slopes = np.where((inner < outer)[:, None], own / self.own_comfort, slope / self.comfort) / weight
        slopes[(room >= 1.0) | ~np.isfinite(slopes).all(axis=1)] = 0.0
        return np.clip(room, 0.0, 1.0), slopes

    def cost(self, points: Floats) -> float:
        """Length, in which a piece counts up to 1 + WORTH times where it passes close by something."""
        points = spaced(points, SPACING, MOST_POINTS)
        dear = 1.0 + WORTH * (1.0 - self.rooms(points)[0]) ** 2
        return float((np.linalg.norm(np.diff(points, axis=0), axis=1) * 0.5 * (dear[1:] + dear[:-1])).sum())

    def mean_room(self, q: Floats) -> float:
        """Mean distance (m) to obstacles beyond what is asked for along a path (k, n), up to the comfort."""
        points = spaced(self.scaled(q), SPACING, MOST_POINTS)
        gaps = signed(
            self.search.robot, np.ascontiguousarray(points / self.space.model.weight), self.solids, static=False
        )
        room, way = (
            np.clip((gaps - self.asked[0]) / self.comfort, 0.0, 1.0),
            np.linalg.norm(np.diff(points, axis=0), axis=1),
        )
        return self.comfort * float((way * 0.5 * (room[1:] + room[:-1])).sum() / max(float(way.sum()), 1e-300))

    def relaxed(self, path: Floats, extra: float) -> Floats | None:
        """An elastic band: drawn tight, pushed away from what is near, every new motion certified before it counts.

        Source: Quinlan and Khatib 1993 (elastic bands); here the descent of `cost`, with the certificate as a wall.
        """
        P = spaced(self.scaled(path), SPACING, MOST_POINTS)
        rungs = self.rung(extra)
        if len(P) < 3 or self.blocked(P, rungs):
            return None
        cost, pull, patience = self.cost(P), 0.5, 0
        for _ in range(ROUNDS):
            if self.is_over or pull < 0.02 or patience >= PATIENCE:
                break
            self.rounds += 1
            new, bad = self.moved(P, pull), []
            for _ in range(3):  # where a motion is not certified, its ends stay where they were
                bad = self.blocked(new, rungs)
                for k in bad:
                    new[max(k - 1, 0) : k + 3] = P[max(k - 1, 0) : k + 3]
                if not bad:
                    break
            value = np.inf if bad else self.cost(new)
            if value >= cost:
                pull *= 0.5
                continue
            patience = 0 if value < 0.999 * cost else patience + 1
            P, cost = new, value
        q = P / self.space.model.weight
        q[0], q[-1] = path[0], path[-1]
        return q

    def moved(self, P: Floats, pull: float) -> Floats:
        """One step of the band: towards the middle of the neighbours, and up the slope of the room across the way."""
        room, slope = self.rooms(P)
        new = P.copy()
        dear = 1.0 + WORTH * (1.0 - room[1:-1, None]) ** 2
        tangent = P[2:] - P[:-2]
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
        across = slope[1:-1] - (slope[1:-1] * tangent).sum(axis=1, keepdims=True) * tangent
        # descent of `cost` point by point: the half step to the neighbours' middle, and what the slope is worth beside it
        step = np.linalg.norm(P[2:] - P[:-2], axis=1, keepdims=True)
        push = 2.0 * WORTH * (1.0 - room[1:-1, None]) * across * (0.5 * step) ** 2 / dear
        push *= np.minimum(1.0, 0.5 * step / np.maximum(np.linalg.norm(push, axis=1, keepdims=True), 1e-12))
        new[1:-1] += pull * (0.5 * (P[:-2] + P[2:]) - P[1:-1] + push)
        return np.clip(new, self.low, self.high)

    def blocked(self, P: Floats, rungs: Floats) -> list[int]:
        """Motions of the band that are not certified to keep the margins of a rung."""
        room = self.space.room
        room.path[: len(P)] = P
        room.path[0] = self.space.scaled(self.search.start)
        found, first = [], 0
        while first < len(P) - 1:
            k = self.space.run(CHECK, rungs, points=len(P), first=first)
            if k < 0:
                break
            found.append(k)
            first = k + 1
        return found


def _every(count: int, k: int) -> NDArray[np.int64]:
    """About every k-th of `count` points, the ends among them."""
    return np.unique(np.round(np.linspace(0, count - 1, max((count - 1) // k, 1) + 1)).astype(np.int64))


def spaced(points: Floats, step: float, most: int) -> Floats:
    """The path (k, n) with its corners, and points between them so that none is further than `step` from the next."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    step = max(step, float(lengths.sum()) / max(most - len(points), 8), 1e-3)
    rows = [points[:1]]
    for a, b, length in zip(points[:-1], points[1:], lengths):
        count = max(int(np.ceil(length / step)), 1)
        rows.append(a + np.arange(1, count + 1)[:, None] / count * (b - a))
    return np.concatenate(rows)
