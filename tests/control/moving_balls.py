"""An arm in the live loop among balls that fly about at random, and a witness of its own for every contact."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linprog

from horosphere import kinematics
from horosphere.control import Reactive


def sphere_centres(robot, Q):
    """Centres (b, m, 3) and radii (m,) of a robot made of spheres: frames of the links times points, in plain numpy."""
    frames = kinematics.frames(robot, Q).as_matrix()[:, robot.capsules.link]
    return np.einsum("bmij,mj->bmi", frames[..., :3, :3], robot.capsules.a) + frames[..., :3, 3], robot.capsules.radius


@dataclass
class Flight:
    """Balls between random points of a box, each at its own constant speed up to `speed`; those near the base turn back.

    `standing`: (x, y, z, radius) of more that do not move.
    """

    rng: np.random.Generator
    count: int
    speed: float
    low: tuple = (-0.9, -0.9, 0.05)
    high: tuple = (0.9, 0.9, 1.2)
    core: float = 0.25
    standing: tuple = ()
    centres: np.ndarray = field(init=False)
    velocities: np.ndarray = field(init=False)
    radii: np.ndarray = field(init=False)

    def __post_init__(self):
        self.low, self.high = np.array(self.low), np.array(self.high)
        self.centres = self.rng.uniform(self.low, self.high, (self.count, 3))
        self.centres[:, 0] = np.where(self.rng.uniform(size=self.count) < 0.5, -0.9, 0.9)
        self.radii = self.rng.uniform(0.03, 0.1, self.count)
        self.velocities = np.zeros((self.count, 3))
        for k in range(self.count):
            self.turn(k)
        fixed = np.reshape(self.standing, (-1, 4))
        self.centres, self.radii = np.concatenate([self.centres, fixed[:, :3]]), np.append(self.radii, fixed[:, 3])
        self.velocities = np.concatenate([self.velocities, np.zeros((len(fixed), 3))])

    def turn(self, k):
        way = self.rng.uniform(self.low, self.high) - self.centres[k]
        self.velocities[k] = way / np.linalg.norm(way) * self.rng.uniform(0.2, 1.0) * self.speed

    def advance(self, h, look=True):
        if look:
            leaving = ((self.centres < self.low) & (self.velocities < 0)) | (
                (self.centres > self.high) & (self.velocities > 0)
            )
            for k in np.flatnonzero(leaving.any(axis=1)):
                self.turn(k)
            # what stands at the base cannot move away, so nothing flies there
            out = self.centres * [1.0, 1.0, 0.0]
            inside = np.linalg.norm(out, axis=1) < self.core + self.radii
            self.velocities[inside & ((out * self.velocities).sum(axis=1) < 0.0)] *= -1.0
        self.centres = self.centres + h * self.velocities


@dataclass(frozen=True)
class Contact:
    time: float
    body: int
    ball: int
    depth: float
    own_rate: float  # of the distance, by the robot's motion
    closing: float  # of the ball, along the normal
    retreat: float  # the fastest any velocity within the limits could move the body away, touching nothing else
    careful: float  # the same, coming nearer to no other ball that might get to it while it stops
    reason: str

    @property
    def kind(self):
        """overrun: faster than any retreat. squeezed: a retreat only towards another ball. avoidable: neither."""
        if self.closing >= self.retreat:
            return "overrun"
        return "squeezed" if self.closing >= self.careful else "avoidable"


def fastest_retreat(loop, q, row, others, ahead=0.2, careful=0.0):
    """max a . u over the velocity limits, while no joint runs into its limit and no other pair touches within `ahead` seconds.

    others: (distance, closing speed of the ball, gradient) of the other pairs that are near, also of the robot's own bodies (speed
    0); those nearer than `careful` may not be approached at all.
    """
    limits = loop._limits
    low = np.minimum(np.maximum(-limits[2], (limits[0] - q) / ahead), 0.0)
    high = np.maximum(np.minimum(limits[2], (limits[1] - q) / ahead), 0.0)
    A = np.array([-slope for _, _, slope in others]) if others else None
    rooms = [max(d, 0.0) / ahead - closing for d, closing, _ in others]
    rooms = [min(room, 0.0) if d < careful else room for room, (d, _, _) in zip(rooms, others)]
    b = np.array(rooms) if others else None
    solution = linprog(-row, A_ub=A, b_ub=b, bounds=np.column_stack([low, high]))
    return float(-solution.fun) if solution.status == 0 else -np.inf  # squeezed: nothing helps


def may_touch(robot, balls):
    """(m, balls) which bodies may touch which balls, from the names: no array of the package."""
    names = [robot.link_names[link] for link in robot.capsules.link]
    return np.array([[(name, f"ball {k}") in robot.allowed_obstacles for k in range(balls)] for name in names])


def rows_at(robot, q, centres, radii, below):
    """Pairs nearer than `below` that may not touch: distance, body, ball, and the gradient of it by finite differences."""

    def distances(Q):
        x, r = sphere_centres(robot, Q)
        return np.linalg.norm(x[:, :, None] - centres[None, None], axis=-1) - r[:, None] - radii

    d, slope = with_slope(distances, q)
    near = zip(*np.nonzero((d < below) & ~may_touch(robot, len(radii))))
    return [(d[i, j], i, j, slope[:, i, j]) for i, j in near if robot.capsules.link[i] > 0]


def own_rows(robot, q, below):
    """Distance and gradient of the pairs of the robot's own bodies that are nearer than `below`."""
    links = robot.capsules.link
    i, j = np.concatenate([np.argwhere((links[:, None] == a) & (links == b)) for a, b in robot.self_pairs]).T

    def distances(Q):
        x, r = sphere_centres(robot, Q)
        return np.linalg.norm(x[:, i] - x[:, j], axis=-1) - r[i] - r[j]

    d, slope = with_slope(distances, q)
    return [(d[k], slope[:, k]) for k in np.flatnonzero(d < below)]


def with_slope(distances, q):
    """Distances at q, and their derivatives by each joint: finite differences."""
    e, n = 1e-6, len(q)
    d = distances(np.concatenate([q[None], q + e * np.eye(n), q - e * np.eye(n)]))
    return d[0], (d[1 : 1 + n] - d[1 + n :]) / (2 * e)


def simulate(
    robot,
    seconds,
    seed,
    *,
    speed,
    balls=8,
    standing=(),
    period=1e-3,
    clearance=0.01,
    chunk=500,
    goals=None,
    known=True,
    **options,
):
    """Runs the loop, which may see how the balls move now (known) or not; new goals as it arrives or every 4 s.

    Returns contacts (the first of each touch), steps by reason, least clearance, goals reached, what limits say, and how many
    times a body was in a contact that is allowed.
    """
    rng = np.random.default_rng(seed)
    flight = Flight(rng, balls, speed, standing=standing)
    q = np.array([0.0, -0.6, 0.0, -2.2, 0.0, 1.8, 0.7])
    for _ in range(1000):  # no ball at the robot to begin with
        x, r = sphere_centres(robot, q[None])
        near = (np.linalg.norm(x[0][:, None] - flight.centres, axis=-1) - r[:, None] - flight.radii).min(0) < 0.1
        near[balls:] = False
        if not near.any():
            break
        flight.centres[near] = rng.uniform(flight.low, flight.high, (near.sum(), 3))
    loop = Reactive(
        robot, (flight.centres, flight.radii), period=period, clearance=clearance, **options,
        obstacle_speed=[speed] * balls + [0.0] * len(standing),
    )  # fmt: skip
    lower, upper = loop._limits[0], loop._limits[1]
    contacts, touching, reasons, least = [], set(), {}, np.inf
    goal, since, reached = None, 0.0, 0
    count = round(seconds / period)
    unproved, touched, may = 0, 0, may_touch(robot, len(flight.radii))
    worst_speed = worst_acceleration = 0.0
    before = np.zeros(robot.n_joints)
    for start in range(0, count, chunk):
        Q, Cs = [], []
        for k in range(start, min(start + chunk, count)):
            if goal is None or since > 4.0:
                goal, since = rng.uniform(0.9 * lower, 0.9 * upper) if goals is None else goals(rng), 0.0
                loop.set_goal(goal)
            seen = flight.velocities if known else None
            step = loop.step(q, obstacles=(flight.centres, flight.radii), obstacle_velocity=seen)
            reasons[step.reason] = reasons.get(step.reason, 0) + 1
            unproved += not step.proved
            Q.append(q)
            Cs.append((flight.centres, flight.velocities.copy(), step.dq, step.reason))
            worst_speed = max(worst_speed, np.max(np.abs(step.dq) / loop._limits[2]))
            worst_acceleration = max(worst_acceleration, np.max(np.abs(step.dq - before) / (period * loop._limits[3])))
            before = step.dq
            q, since = step.q_next, since + period
            if step.reason == "arrived":
                goal, reached = None, reached + 1
            flight.advance(period, k % 8 == 0)
        x, r = sphere_centres(robot, np.array(Q))
        moving = np.flatnonzero(robot.capsules.link > 0)
        C = np.array([c[0] for c in Cs])
        d = np.full((len(Q), len(C[0])), np.inf)
        for i in moving:
            own = np.linalg.norm(x[:, i, None] - C, axis=-1) - r[i] - flight.radii
            d = np.minimum(d, np.where(may[i], np.inf, own))
            touched += int((may[i] & (own < 0.0)).any(axis=1).sum())
        least = min(least, d.min())
        for k, j in zip(*np.nonzero(d < 0.0)):
            if (j, start + k - 1) not in touching:
                centres, velocities, dq, reason = Cs[k]
                rows = rows_at(robot, Q[k], centres, flight.radii, 0.3)
                depth, i, _, row = min((row for row in rows if row[2] == j), key=lambda row: row[0])

                def closing(i, j, k=k, centres=centres, velocities=velocities, x=x):
                    n = x[k, i] - centres[j]
                    return float(n @ velocities[j] / np.linalg.norm(n))

                others = [(e, closing(a, b), slope) for e, a, b, slope in rows if (a, b) != (i, j)]
                others += [(e, 0.0, slope) for e, slope in own_rows(robot, Q[k], 0.05)]
                retreat = fastest_retreat(loop, Q[k], row, others)
                careful = fastest_retreat(loop, Q[k], row, others, careful=clearance + 0.3 * speed)
                contacts.append(
                    Contact(
                        (start + k) * period,
                        int(i),
                        int(j),
                        depth,
                        float(row @ dq),
                        closing(i, j),
                        retreat,
                        careful,
                        reason,
                    )
                )
            touching.add((j, start + k))
        touching = {(j, k) for j, k in touching if k >= start + len(Q) - 2}
    return dict(
        contacts=contacts,
        reasons=reasons,
        least=least,
        reached=reached,
        unproved=unproved,
        touched=touched,
        speed=worst_speed,
        acceleration=worst_acceleration,
    )
