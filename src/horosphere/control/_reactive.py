"""The live loop: one safe joint motion a period, towards a goal that may move, among obstacles that may move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..distance import allowance, pack_obstacles
from ..entities import Point
from ..errors import InputError
from ..numeric import at_most, float_array
from ..robots import Robot
from ..robots._robot import require_robot
from ..shapes import BoxCover, Mesh, Packed, Shape, as_shapes, box_cover
from ..versors import Motor
from ._reactive_pack import pack_arm, workspace

Floats = NDArray[np.float64]

REASONS = ("moving", "arrived", "blocked", "retreating", "stopping", "stopped")
DEFAULT_VELOCITY = 1.0
DEFAULT_RISE_TIME = 0.25
_NO_CONTACTS = np.zeros((0, 0), np.bool_)


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """What to do in the coming period.

    `q_next` (n,): where the joints are at its end, `dq` (n,): their velocity until then, rad or m, per s.
    `reason`: moving; arrived; blocked (at rest, the obstacles hold it off the goal); retreating (something came nearer than the
    clearance allows, and it moves away); stopping (no motion could be proved safe: it brakes on the last proved one); stopped.
    `proved`: the guarantee of docs/live-loop.md holds for this period and the stop after it.
    `clearance`: distance to the nearest obstacle at q, m, from `link` to `other`, allowed contacts left out; `self_clearance`:
    between the robot's own links.
    `error`, `angle`: distance to the goal (m, or joint units for joints) and rad. `stop_time`: s until rest, if need be.
    """

    q_next: Floats
    dq: Floats
    reason: str
    proved: bool
    clearance: float
    link: str | None
    other: str | None
    self_clearance: float
    error: float
    angle: float
    stop_time: float


class Reactive:
    """A velocity controller for an arm: call `step` once a period with the joints' positions.

    The velocity towards the goal is projected on what the obstacles allow, a . u >= v - rate (d - clearance) for the distance d of
    each link to each obstacle near it, v the obstacle's speed, a = grad d; on joint, velocity and acceleration limits, and the
    robot's own links. It is used only if a stop after it is proved to be safe, for obstacles up to the stated speed; otherwise
    less of it, a retreat, or a stop that was proved before. Guarantee and proof: docs/live-loop.md. Our derivation; the
    projection is the control barrier of [Rn]'s sampled-data clip.

    robot; obstacles: as in `shapes.as_shapes`; a mesh is enclosed in boxes (`shapes.box_cover`), `slack` and `notes` say how
    closely, and of a point cloud every ball counts (a few hundred cost little). Pairs of `robot.allowed_obstacles` are not looked
    at, and `notes` names them. period: s. clearance, self_clearance: m.
    goal: joints (n,), a Motor (pose of the tool frame) or a Point (of the tool's origin).
    gamma: largest share of the free distance that one period may use up (0, 1]. rate: 1/s, how fast a distance may close,
    per metre left (default: as fast as the slowest brake allows). gain: 1/s, how the error closes. speed, turn: of the tool, m/s
    and rad/s, for poses and points. posture (n,): where the elbow goes in the null space of such a goal, with posture_gain 1/s.
    velocity, acceleration (n,): limits instead of the robot's. tolerance, angle_tolerance: within which it is "arrived".
    Raises InputError.
    """

    def __init__(
        self,
        robot: Robot,
        obstacles: Any = (),
        *,
        period: float = 1e-3,
        clearance: float = 0.01,
        self_clearance: float = 0.0,
        goal: Any = None,
        obstacle_speed: ArrayLike = 0.0,
        gamma: float = 0.5,
        rate: float | None = None,
        gain: float | None = None,
        speed: float = 0.5,
        turn: float = 2.0,
        posture: ArrayLike | None = None,
        posture_gain: float = 1.0,
        velocity: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        tolerance: float = 1e-3,
        angle_tolerance: float = 1e-2,
        sweeps: int = 30,
    ) -> None:
        require_robot(robot)
        n = robot.n_joints
        for name, value in (("period", period), ("gamma", gamma), ("speed", speed), ("turn", turn)):
            if float(float_array(value, name, ndim=0)) <= 0.0:
                raise InputError(f"expected a number > 0, got {value!r}", place=name)
        if gamma > 1.0:
            raise InputError(f"expected 0 < gamma <= 1, got {gamma!r}", place="gamma")
        for name, value in (("clearance", clearance), ("self_clearance", self_clearance)):
            if float(float_array(value, name, ndim=0)) < 0.0:
                raise InputError(f"expected metres >= 0, got {value!r}", place=name)
        self.robot, self.period = robot, float(period)
        self._assumed: tuple[str, ...] = ()
        self._covers: dict[str, BoxCover] = {}
        self._n, self._arm = n, pack_arm(robot)
        limits = np.zeros((5, n))
        limits[0], limits[1] = robot.limits.lower, robot.limits.upper
        limits[2] = self._limit("velocity", velocity, robot.limits.velocity, np.full(n, DEFAULT_VELOCITY))
        limits[3] = self._limit("acceleration", acceleration, robot.limits.acceleration, limits[2] / DEFAULT_RISE_TIME)
        limits[4] = limits[2] ** 2 / np.mean(limits[2] ** 2)
        self._limits = limits
        rate = min(10.0, gamma / period) if rate is None else float(rate)
        if not 0.0 < rate <= gamma / period:
            raise InputError(f"expected 0 < rate <= gamma / period = {gamma / period:g}, got {rate!r}", place="rate")
        gain = min(10.0, 0.2 / period) if gain is None else float(gain)
        # a retreat has to begin at obstacle_speed / retreat: as far off as the slowest brake can make good
        retreat = min(2.0 * float((limits[3] / limits[2]).min()), rate)
        self.rate = float(rate)
        self._par = np.array(
            [period, clearance, self_clearance, rate, gain, self._arm.tip, speed, turn, posture_gain, sweeps]
            + [tolerance, angle_tolerance, retreat],
            dtype=np.float64,
        )
        self._posture = np.zeros(n)
        if posture is None:
            self._par[8] = 0.0
        else:
            self._posture[:] = float_array(posture, "posture", last=n, ndim=1)
        self._goal_buffer, self._goal = np.zeros(1 + max(n, 12)), None
        self._has_goal = False
        self._solids, self._speeds = Packed(np.zeros((0, 18)), np.zeros(0, np.int64), ()), np.zeros(0)
        self._contacts = _NO_CONTACTS
        self._obstacles: Any = None
        self._speed: Any = None
        self._work: Any = None
        self.reset()
        self.set_obstacles(obstacles, obstacle_speed)
        if goal is not None:
            self.set_goal(goal)

    def _limit(self, name: str, given: ArrayLike | None, stated: Floats, default: Floats) -> Floats:
        if given is not None:
            values = np.broadcast_to(float_array(given, name), (self._n,)).copy()
            if (values <= 0.0).any():
                raise InputError(f"expected limits > 0, got {values.min():g}", place=name)
            return values
        missing = ~np.isfinite(stated) | (stated <= 0.0)
        if missing.any():
            what = "1 rad/s or m/s" if name == "velocity" else f"full speed in {DEFAULT_RISE_TIME:g} s"
            self._assumed += (f"no {name} limit stated for some joints: {what} used",)
        return np.where(missing, default, stated)

    @property
    def slack(self) -> float:
        """How far (m) the boxes round a mesh stand out of it at most; 0 where there is none."""
        return max((cover.slack for cover in self._covers.values()), default=0.0)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed of the robot, what stands for meshes, and which contacts are allowed."""
        meshes = (
            f"{name}: {len(cover.boxes)} boxes for the mesh, slack at most {at_most(cover.slack, decimals=4)} m"
            for name, cover in self._covers.items()
        )
        there = self._solids.names
        contacts = (f"{link} may touch {name}" for link, name in self.robot.allowed_obstacles if name in there)
        return (*self._assumed, *meshes, *contacts)

    def reset(self, dq: ArrayLike | None = None) -> None:
        """Forget the motion so far: the robot is at rest, or moves at `dq` (n,)."""
        self._dq = np.zeros(self._n) if dq is None else float_array(dq, "dq", last=self._n, ndim=1).copy()
        self._unknown = np.full(self._n, np.nan)
        self._expected = self._unknown

    def set_goal(self, goal: Any) -> None:
        """Joints (n,), a Motor or a Point; takes effect at the next step."""
        buffer = self._goal_buffer
        if isinstance(goal, Motor):
            matrix = goal.as_matrix()
            if matrix.shape != (4, 4):
                raise InputError(f"expected one pose, got a batch of shape {matrix.shape[:-2]}", place="goal")
            buffer[0], buffer[1:10], buffer[10:13] = 1.0, matrix[:3, :3].ravel(), matrix[:3, 3]
        elif isinstance(goal, Point):
            position = goal.as_euclidean()
            if position.shape != (3,):
                raise InputError(f"expected one point, got a batch of shape {position.shape[:-1]}", place="goal")
            buffer[0], buffer[1:4] = 2.0, position
        else:
            if not isinstance(goal, (np.ndarray, list, tuple)):
                raise InputError(
                    f"cannot read a goal from {type(goal).__name__}",
                    place="goal",
                    choices=("joints (n,)", "Motor", "Point"),
                )
            joints = float_array(goal, "goal", last=self._n, ndim=1)
            buffer[0], buffer[1 : 1 + self._n] = 0.0, joints
        self._goal, self._has_goal = goal, True

    def set_obstacles(self, obstacles: Any, obstacle_speed: ArrayLike | None = None) -> None:
        """Obstacles (as in `shapes.as_shapes`) from the next step on; obstacle_speed: m/s, one for all or one an obstacle.

        A pair (centers (m, 3), radii (m,)) of arrays is the fast way to say that balls moved.
        """
        balls = isinstance(obstacles, tuple) and len(obstacles) == 2 and isinstance(obstacles[0], np.ndarray)
        count = len(self._solids.rows)
        if balls and self._obstacles == "balls" and obstacles[0].shape == (count, 3) and count:
            rows, (centers, radii) = self._solids.rows, obstacles
            if not (np.isfinite(centers).all() and np.isfinite(radii).all() and np.min(radii) >= 0.0):
                raise InputError("expected finite centers and radii >= 0", place="obstacles")
            rows[:, 1:4] = rows[:, 6:9] = centers
            rows[:, 4] = rows[:, 5] = radii
        else:
            shapes = obstacles if isinstance(obstacles, Packed) else as_shapes(obstacles)
            packed = pack_obstacles(shapes, trees=False)
            if packed.forest is not None:
                raise InputError(
                    "packed obstacles with trees are not taken", place="obstacles", remedy="give the shapes"
                )
            self._covers = {} if isinstance(shapes, Packed) else _covers(shapes, packed)
            # an own, writable copy: packed obstacles are shared
            self._owner = packed.owner.tolist()
            self._solids = Packed(np.array(packed.rows, order="C"), packed.owner, packed.names)
            allowed = allowance(self.robot, self._solids)
            self._contacts = _NO_CONTACTS if allowed is None else np.array(allowed[self._arm.order], order="C")
            self._obstacles = "balls" if balls else obstacles
        if obstacle_speed is None:
            obstacle_speed = self._speed
        if obstacle_speed is not self._speed or len(self._speeds) != len(self._solids.rows):
            self._set_speed(obstacle_speed)
        if len(self._solids.rows) != count or self._work is None:
            self._velocities = np.full((len(self._solids.rows), 3), np.nan)
            self._work = workspace(self._arm, len(self._solids.rows), self._n)
            self._out = np.zeros(self._n + 13)

    def _set_speed(self, speed: Any) -> None:
        values = float_array(speed, "obstacle_speed")
        if (values < 0.0).any() or values.ndim > 1 or (values.ndim and len(values) != len(self._solids.names)):
            raise InputError(
                f"expected m/s >= 0, one number or {len(self._solids.names)}, got {speed!r}", place="obstacle_speed"
            )
        self._speeds = np.ascontiguousarray(
            np.broadcast_to(values, (len(self._solids.names),))[self._solids.owner], dtype=np.float64
        )
        self._speed = speed

    def _velocity_rows(self, velocity: ArrayLike) -> Floats:
        values = float_array(velocity, "obstacle_velocity", last=3, ndim=2)
        if len(values) != len(self._solids.names):
            raise InputError(
                f"expected {len(self._solids.names)} velocities, got {len(values)}", place="obstacle_velocity"
            )
        return values if len(values) == len(self._owner) else values[self._owner]

    def step(
        self,
        q: ArrayLike,
        goal: Any = None,
        obstacles: Any = None,
        obstacle_speed: ArrayLike | None = None,
        dq: ArrayLike | None = None,
        obstacle_velocity: ArrayLike | None = None,
    ) -> Step:
        """The motion of the next period from q (n,), where the joints are now.

        What is not given stays as it was: goal, obstacles (where they are now) and the bound on their speed, m/s. dq: the
        velocity, where it is not the one that the last step asked for. obstacle_velocity (k, 3): how they probably move now, m/s;
        it tells from what to retreat (else from everything that may come), and is no part of the guarantee. Raises InputError.
        """
        from ._reactive_kernels import step_into

        if not (type(q) is np.ndarray and q.dtype == np.float64 and q.shape == (self._n,) and q.flags.carray):
            q = np.array(float_array(q, "q", last=self._n, ndim=1))
        if dq is not None:
            self.reset(dq)
        if obstacles is not None or (obstacle_speed is not None and obstacle_speed is not self._speed):
            if obstacles is None:
                self._set_speed(obstacle_speed)
            else:
                self.set_obstacles(obstacles, obstacle_speed)
        if obstacle_velocity is not None:
            self._velocities[:] = self._velocity_rows(obstacle_velocity)
        if goal is not None and (goal is not self._goal or isinstance(goal, (np.ndarray, list))):
            self.set_goal(goal)
        if not self._has_goal:
            raise InputError(
                "there is no goal yet",
                place="goal",
                choices=("joints (n,)", "Motor", "Point"),
                remedy="Reactive(..., goal=...) or step(q, goal)",
            )
        arm, n, out = self._arm, self._n, self._out
        finite = step_into(
            *arm[:6],
            self._solids.rows,
            self._speeds,
            self._velocities,
            self._contacts,
            arm.G,
            arm.P,
            self._limits,
            self._par,
            self._goal_buffer,
            self._posture,
            arm.tool,
            q,
            self._dq,
            self._expected,
            *self._work,
            out,
        )
        if not finite:
            float_array(q, "q")
        u = out[:n].copy()
        q_next = q + self.period * u
        numbers = out[n : n + 11].tolist()
        self._dq, self._expected = u, q_next if numbers[7] else self._unknown
        item, row = int(numbers[2]), int(numbers[3])
        return Step(
            q_next,
            u,
            REASONS[int(numbers[0])],
            numbers[7] > 0.0,
            numbers[1],
            self._arm.link[item] if item >= 0 else None,
            self._solids.names[self._owner[row]] if item >= 0 else None,
            numbers[4],
            numbers[8],
            numbers[9],
            numbers[10],
        )


def _covers(shapes: tuple[Shape, ...], packed: Packed) -> dict[str, BoxCover]:
    """By name, the boxes that stand for meshes."""
    return {name: box_cover(shape) for shape, name in zip(shapes, packed.names) if isinstance(shape, Mesh)}
