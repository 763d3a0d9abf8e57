"""From posture to posture among obstacles: the head follows the harmonic field, the body follows the head.

1. The field of fields.HarmonicField leads joint 1 toward a gate behind the goal posture; the line is followed with a
   limited curvature, and a Dubins curve enters the gate from the latest point of it that has a free one.
2. From the gate the path runs along the goal's body, so that the snake arrives close to its goal posture.
3. Driven head first, link by link the body relaxes onto the path: a midpoint-wheeled link is an all-pass filter of its front
   joint's path, a delay by its length. Off-tracking in curves of radius R is about 0.35 l^2 / R.
4. Steering makes the arrival exact; the whole motion is certified in continuous time. What comes too close is planned again
   with other radii and margins, and the outcome says what failed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError, unknown_name
from ..numeric import at_least, wrap_angle
from ._dubins import dubins
from ._extended import two_to
from ._motion import Motion
from ._paths import STEP, resample, weave
from ._world import SnakeCertificate, Surroundings, certify_motion

if TYPE_CHECKING:
    from ._snake import Snake
    from ._steer import Steering

Array = NDArray[np.float64]
# where the path meets the goal's body: turning radii behind its tail, angle aside
_GATES = ((1.0, 0.0), (0.5, 0.0), (0.0, 0.0), (1.0, 0.5), (1.0, -0.5), (1.0, 1.0), (1.0, -1.0))
_SINGULAR = 0.02  # singularity measure below which a posture counts as near singular
_WAVE = 0.3  # amplitude of the wave of itself, in mean link lengths: headings swing by about 0.3 rad


@dataclass(frozen=True, slots=True)
class NavigateOptions:
    """`width` of the links and certified `clearance`, metres; `workspace` (lower, upper) corners not to be left; `speed` of joint
    1, m/s; `weave`: lateral amplitude in metres of a wave laid over the path where there is room, which keeps the posture away
    from singular ones; 0: none; None: by itself, where the posture would be singular and only if that makes it less so;
    `seed` of the steering."""

    width: float = 0.1
    clearance: float = 0.05
    workspace: Any = None
    speed: float = 1.0
    weave: float | None = None
    seed: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Navigation:
    """The outcome of navigation.

    `motion`: the whole motion in time; `path` (k, 2): the path of joint 1; `certificate`: clearance in continuous time;
    `steering`: the exact arrival; `error`: largest coordinate error at the end; `singularity` (k,): measure along the motion.
    `reason` is "" when `solved`, else one of the failure classes with its numbers; `attempts`: plans tried, each (radius,
    margin, what came of it); `failure`: the class alone: "", "path", "body", "steering", "arrival".
    """

    solved: bool
    failure: str
    reason: str
    motion: Motion | None
    path: Array
    certificate: SnakeCertificate | None
    steering: Steering | None
    error: float
    attempts: tuple[tuple[float, float, str], ...]
    notes: tuple[str, ...]

    def singularity(self, snake: Snake) -> Array:
        """The singularity measure along the motion, (k,)."""
        return np.zeros(0) if self.motion is None else snake.singularity(self.motion.q)


_ORDER = ("", "path", "body", "steering", "arrival")


def navigate(snake: Snake, q0: ArrayLike, q1: ArrayLike, obstacles: Any, **options: Any) -> Navigation:
    """See Snake.navigate."""
    for name in options:
        if name not in NavigateOptions.__dataclass_fields__:
            raise unknown_name("option", name, NavigateOptions.__dataclass_fields__, place="navigate")
    settings = NavigateOptions(**options)
    start, goal = snake.check(q0, "q0", single=True), snake.check(q1, "q1", single=True)
    around = Surroundings.of(obstacles, settings.workspace)
    half = 0.5 * settings.width
    for posture, name in ((start, "q0"), (goal, "q1")):
        free = float(around.of_body(snake.joints(posture), half))
        if free < settings.clearance:
            raise InputError(
                f"an obstacle is {free:.3g} m from the body, less than the clearance {settings.clearance:g} m",
                place=name,
                remedy="move the posture or the obstacle, or ask for less clearance",
            )
        folded = snake.folds(posture)
        if folded:
            raise InputError(
                f"the posture lies on the fold of joint {', '.join(map(str, folded))}",
                place=name,
                remedy="no motion reaches or leaves such a fold; choose a posture off it",
            )
    size = float(snake.lengths.mean())
    attempts: list[tuple[float, float, str]] = []
    best: Navigation | None = None
    for radius, factor in (
        (3.0, 1.0),
        (2.0, 1.0),
        (2.0, 2.0),
        (3.0, 2.0),
        (1.5, 1.5),
        (1.5, 0.5),
        (2.0, 0.4),
        (1.2, 2.0),
        (1.2, 1.0),
    ):
        turning = radius * size
        margin = half + settings.clearance + factor * 0.35 * size**2 / turning
        outcome = _one_plan(snake, start, goal, around, settings, turning, margin)
        attempts.append((turning, margin, outcome.reason or "done"))
        if best is None or outcome.solved or _ORDER.index(outcome.failure) > _ORDER.index(best.failure):
            best = outcome
        if outcome.solved:
            break
    assert best is not None
    return _with(best, attempts=tuple(attempts), notes=around.notes + best.notes)


def _with(result: Navigation, **changes: Any) -> Navigation:
    from dataclasses import replace

    return replace(result, **changes)


def _failed(failure: str, reason: str, path: Array | None = None, motion: Motion | None = None) -> Navigation:
    return Navigation(
        False, failure, reason, motion, np.zeros((0, 2)) if path is None else path, None, None, np.inf, (), ()
    )


def _one_plan(
    snake: Snake,
    start: Array,
    goal: Array,
    around: Surroundings,
    settings: NavigateOptions,
    radius: float,
    margin: float,
) -> Navigation:
    size = float(snake.lengths.mean())
    step = STEP * size
    required = 0.5 * settings.width + settings.clearance
    joints0, joints1 = snake.joints(start), snake.joints(goal)
    begin = joints0[1]
    ahead = _direction(joints0[0] - joints0[1])
    body = joints1[-2:0:-1]  # Q_N .. Q_1 of the goal
    enter = _direction(body[1] - body[0]) if len(body) > 1 else _direction(joints1[0] - joints1[1])
    approach, reason, line = None, "path: no free gate behind the goal's body", None
    for back, aside in _GATES if radius >= 3.0 * size else _GATES[:3]:
        c, sn = np.cos(aside), np.sin(aside)
        way = np.array([c * enter[0] - sn * enter[1], sn * enter[0] + c * enter[1]])
        gate = body[0] - back * radius * way
        if float(around.of_points(gate + np.linspace(0, 1, 9)[:, None] * (body[0] - gate)).min()) < required:
            continue
        field_line = _field_line(around, begin, ahead, gate, radius, margin, step)
        if field_line is None:
            reason = "path: every free gate lies in an obstacle's margin"
            continue
        line = field_line
        entry = (float(gate[0]), float(gate[1]), float(np.arctan2(way[1], way[0])))
        approach = _enter(around, line, entry, radius, step, margin, required)
        if approach is not None:
            break
        reason = f"path: no curve of radius {radius:g} m leads free into the gate"
    if approach is None:
        return _failed("path", reason, None if line is None else line[:, :2])
    path = resample(np.concatenate([approach[:, :2], _along_body(gate, way, body, step)]), step)
    if settings.weave:
        where = np.ones(len(path))
        return _follow(snake, start, goal, around, settings, weave(path, around, settings.weave, where, size, required))
    plain = _follow(snake, start, goal, around, settings, path)
    if settings.weave is None and plain.solved and snake.links > 4:
        return _woven(snake, start, goal, around, settings, path, plain)
    return plain


def _woven(
    snake: Snake,
    start: Array,
    goal: Array,
    around: Surroundings,
    settings: NavigateOptions,
    path: Array,
    plain: Navigation,
) -> Navigation:
    """The solved plan with a wave where its posture was singular, if that is certified too and less singular; else as it was."""
    size = float(snake.lengths.mean())
    way = _along(snake, plain, path)
    before = float(np.mean(way < _SINGULAR))
    if before < 0.05:
        return plain
    required = 0.5 * settings.width + settings.clearance
    wave = weave(path, around, _WAVE * size, np.asarray(way < _SINGULAR, np.float64), size, required)
    other = _follow(snake, start, goal, around, settings, wave)
    after = float(np.mean(_along(snake, other, wave) < _SINGULAR)) if other.solved else 1.0
    if after > 0.8 * before:
        return _with(
            plain, notes=(f"singular postures on {before:.0%} of the way; a wave would not have made them fewer",)
        )
    note = (
        f"a wave of {_WAVE * size:.2g} m over the path: near singular on {after:.0%} of the way instead of {before:.0%}"
    )
    return _with(other, notes=(note,))


def _along(snake: Snake, plan: Navigation, path: Array) -> Array:
    """The singularity measure when joint 1 drives along its path, (k,), before the arrival."""
    if plan.motion is None:
        return np.zeros(len(path))
    along = np.linalg.norm(np.diff(path, axis=0), axis=1)
    moved = np.concatenate([[0.0], np.cumsum(along)])
    joint = np.linalg.norm(np.diff(snake.joints(plan.motion.q)[:, 1], axis=0), axis=1)
    gone = np.concatenate([[0.0], np.cumsum(joint)])
    return np.interp(moved, gone, snake.singularity(plan.motion.q))


def _follow(
    snake: Snake, start: Array, goal: Array, around: Surroundings, settings: NavigateOptions, path: Array
) -> Navigation:
    """The motion of the snake led along a path by joint 1, and its arrival."""
    inputs, durations = _drive(snake, start, goal, path, settings.speed)
    motion = snake.simulate(start, inputs, durations=durations, tolerance=1e-9)
    certificate = certify_motion(snake, motion, around, 0.5 * settings.width, settings.clearance)
    if not certificate.certified:
        return _failed(
            "body", f"body: the clearance on the way is {at_least(certificate.clearance, 3)} m", path, motion
        )
    return _arrive(snake, goal, around, settings, path, motion, inputs, durations, start)


def _direction(v: Array) -> Array:
    return v / np.linalg.norm(v)


def _field_line(
    around: Surroundings, begin: Array, ahead: Array, gate: Array, radius: float, margin: float, step: float
) -> Array | None:
    """The gradient line followed with curvature at most 1/radius: (k, 3) rows of x, y, heading."""
    from ..fields import HarmonicField

    box = None if around.lower is None else (around.lower, around.upper)
    try:
        field = HarmonicField(gate, (around.centers, around.radii), margin=margin, workspace=box)
    except InputError:
        return None
    x, heading = begin.copy(), float(np.arctan2(ahead[1], ahead[0]))
    rows = [(x[0], x[1], heading)]
    distance = float(np.linalg.norm(gate - begin))
    for _ in range(int((4.0 * distance + 20.0 * radius) / step)):
        way = field(x)
        if not np.isfinite(way).all() or (way == 0).all():
            break
        turn = float(wrap_angle(np.arctan2(way[1], way[0]) - heading))
        heading += float(np.clip(turn / (0.5 * radius), -1.0 / radius, 1.0 / radius)) * step
        x = x + step * np.array([np.cos(heading), np.sin(heading)])
        rows.append((x[0], x[1], heading))
        if np.linalg.norm(gate - x) < 2.0 * step:
            break
    return np.array(rows)


def _enter(
    around: Surroundings,
    line: Array,
    gate: tuple[float, float, float],
    radius: float,
    step: float,
    margin: float,
    required: float,
) -> Array | None:
    """The line up to its latest point from which a free Dubins curve enters the gate, and that curve."""
    free = around.of_points(line[:, :2])
    blocked = np.flatnonzero(free < min(margin, float(free[0])) - 1e-9)
    last = int(blocked[0]) if blocked.size else len(line)
    best, best_length = None, np.inf
    for index in range(last - 1, -1, -max(1, last // 24)):
        x, y, heading = (float(v) for v in line[index])
        for curve in dubins((x, y, heading), gate, radius, step):
            length = index * step + len(curve) * step
            if length >= best_length:
                break
            if float(around.of_points(curve[::8, :2]).min()) < required:
                continue
            if float(around.of_points(curve[:, :2]).min()) >= min(margin, float(free[index])) - 1e-9:
                best, best_length = np.concatenate([line[:index], curve]), length
                break
    return best


def _along_body(gate: Array, enter: Array, body: Array, step: float) -> Array:
    """A smooth path from the gate through the joints of the goal posture to its joint 1."""
    from scipy.interpolate import CubicSpline

    points = [body[0]] if np.linalg.norm(body[0] - gate) < 1e-9 else [gate, body[0]]
    knots = np.concatenate([points, body[1:]])
    if len(knots) < 2:
        return knots
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))])
    ends: Any = ((1, enter), (2, np.zeros(2)))
    spline = CubicSpline(s, knots, bc_type=ends)
    return spline(np.linspace(0.0, s[-1], max(2, int(np.ceil(s[-1] / step)))))[1:]


def _drive(snake: Snake, start: Array, goal: Array, path: Array, speed: float) -> tuple[Array, Array]:
    """Inputs (m, 4) and durations that move joint 1 along the path, the head link ahead of it on the path, the tail relaxing."""
    moves = np.diff(path, axis=0)
    lengths = np.linalg.norm(moves, axis=1)
    durations = lengths / speed
    inputs = np.zeros((len(moves), 4))
    inputs[:, :2] = moves / durations[:, None]
    s = np.concatenate([[0.0], np.cumsum(lengths)])
    l0 = float(snake.lengths[0])
    tip = np.stack([np.interp(s + l0, s, path[:, i]) for i in (0, 1)], axis=1)
    beyond = np.maximum(s + l0 - s[-1], 0.0)
    tip += beyond[:, None] * _direction(path[-1] - path[-2])
    away = path - tip
    wanted = np.unwrap(np.arctan2(away[:, 1], away[:, 0]))
    wanted += start[2] + wrap_angle(wanted[0] - start[2]) - wanted[0]
    # the head swings onto the path within two of its lengths, and onto the goal's head over the last two
    fade = np.exp(-s / l0)
    final = wanted[-1] + wrap_angle(goal[2] - wanted[-1])
    close = np.exp(-(s[-1] - s) / l0)
    angle = wanted + (start[2] - wanted[0]) * fade + (final - wanted[-1]) * close
    angle += (start[2] - angle[0]) * np.clip(1.0 - s / max(s[-1], 1e-9), 0.0, 1.0)
    inputs[:, 2] = np.diff(angle) / durations
    tail = goal[-1] * close + start[-1] * fade
    tail += (start[-1] - tail[0]) * np.clip(1.0 - s / max(s[-1], 1e-9), 0.0, 1.0)
    inputs[:, 3] = np.diff(tail) / durations
    return inputs, durations


def _arrive(
    snake: Snake,
    goal: Array,
    around: Surroundings,
    settings: NavigateOptions,
    path: Array,
    motion: Motion,
    inputs: Array,
    durations: Array,
    start: Array,
) -> Navigation:
    """Exact steering at the end, with the least of a few random motions that keeps clear; then the certificate of the whole."""
    from ._steer import steer

    half = 0.5 * settings.width
    failure, reason = "steering", "steering: "
    for seed in range(settings.seed, settings.seed + 4):
        steering = steer(snake, motion.end, goal, 1e-9, seed=seed, skip=3 * (seed - settings.seed), tries=8)
        if not steering.solved:
            reason = f"steering: {steering.reason}"
            continue
        # a power of two times what steering took: the inputs keep their digits, which the way back amplifies
        time = steering.duration * two_to(max(steering.path_length / settings.speed, 1e-3) / steering.duration)
        last = len(steering.inputs)
        all_inputs = np.concatenate([inputs, steering.inputs * (steering.duration / time)])
        all_durations = np.concatenate([durations, np.full(last, time / last)])
        whole = snake.simulate(start, all_inputs, durations=all_durations, tolerance=1e-9)
        certificate = certify_motion(snake, whole, around, half, settings.clearance)
        if not certificate.certified:
            failure, reason = (
                "arrival",
                f"arrival: steering into the goal comes within {at_least(certificate.clearance, 3)} m",
            )
            continue
        error = whole.end - goal
        error[2:] = wrap_angle(error[2:])
        size = float(np.abs(error).max())
        solved = size < 1e-6
        return Navigation(
            solved,
            "" if solved else "arrival",
            "" if solved else f"arrival: off by {size:.2g}",
            whole,
            path,
            certificate,
            steering,
            size,
            (),
            (),
        )
    return _failed(failure, reason, path, motion)
