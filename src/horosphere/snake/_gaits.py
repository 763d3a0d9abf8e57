"""Gaits: periodic inputs, and how far a period moves the snake."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ._motion import Motion

if TYPE_CHECKING:
    from ._snake import Snake

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Gait:
    """A gait carried out: `motion`, seconds of one `period`, `displacement` (periods, 3) of the head (x, y, theta) in each.

    `condition`: largest condition number met where joint rates were turned into inputs (1 where none were);
    `reason` is "" or says why the gait ended early.
    """

    motion: Motion
    period: float
    displacement: Array
    condition: float
    reason: str


def _posture(snake: Snake, q0: ArrayLike) -> NDArray[np.float64]:
    if not hasattr(snake, "check"):
        raise InputError(f"expected a Snake, got {type(snake).__name__}", place="snake")
    return snake.check(q0, "q0", single=True)


def serpenoid(
    snake: Snake,
    q0: ArrayLike,
    *,
    amplitude: float = 0.4,
    wavelength: float | None = None,
    speed: float = 1.0,
    turn: float = 0.0,
    periods: int = 3,
) -> Gait:
    """Joint 1 runs along a serpenoid: heading = start + amplitude sin(2 pi s / wavelength) + turn s; the head link keeps ahead.

    amplitude: radians; wavelength: metres, 6 link lengths by default; turn: 1/m; speed: m/s. The body follows link by link and is
    singular nowhere for long. Our derivation.
    """
    q = _posture(snake, q0)
    length = 6.0 * float(snake.lengths.mean()) if wavelength is None else float(wavelength)
    if not (length > 0 and speed > 0 and periods >= 1):
        raise InputError("expected positive wavelength and speed, and at least one period", place="serpenoid")
    ahead = snake.joints(q)[0] - snake.joints(q)[1]
    base = float(np.arctan2(ahead[1], ahead[0]))
    wave = 2.0 * np.pi / length

    def inputs(t: float) -> Array:
        s = speed * t
        heading = base + amplitude * np.sin(wave * s) + turn * s
        rate = speed * (amplitude * wave * np.cos(wave * s) + turn)
        return np.array([speed * np.cos(heading), speed * np.sin(heading), rate, 0.0])

    period = length / speed
    inputs.x = period * np.arange(periods + 1)  # knots: a step ends where a period does
    motion = snake.simulate(q, inputs, periods * period, tolerance=1e-9)
    return Gait(motion, period, _per_period(motion, period, periods), 1.0, motion.reason)


def shape_gait(
    snake: Snake,
    q0: ArrayLike,
    *,
    joints: tuple[int, int] = (2, 3),
    amplitude: float = 0.3,
    phase: float = np.pi / 2,
    period: float = 2.0,
    periods: int = 3,
) -> Gait:
    """Two joints are driven, Phi_j = start + amplitude (sin(w t + shift) - sin(shift)); the wheels turn that into motion.

    The second joint's shift is `phase` radians. Ends early, saying so, where the two joints lock: there the wheel axes meet.
    """
    q = _posture(snake, q0)
    if len(set(joints)) != 2 or not all(2 <= j <= snake.links - 2 for j in joints):
        raise InputError(
            f"expected two different joints in 2 .. {snake.links - 2}, got {joints}",
            place="joints",
            remedy="joint 1 turns the head and the last joint the tail, which the wheels do not see",
        )
    from scipy.integrate import solve_ivp

    rows = [2 + j for j in joints]
    shifts = np.array([0.0, phase])
    wave = 2.0 * np.pi / period
    worst = 1.0

    def inputs(t: float, state: Array) -> Array:
        nonlocal worst
        basis = snake.control_basis(state)[rows][:, :2]
        worst = max(worst, float(np.linalg.cond(basis)))
        wanted = amplitude * wave * np.cos(wave * t + shifts)
        return np.append(np.linalg.solve(basis, wanted), [0.0, 0.0])

    def locked(t: float, state: Array) -> float:
        return float(np.linalg.det(snake.control_basis(state)[rows][:, :2])) ** 2 - 1e-6

    locked.terminal = True
    if locked(0.0, q) <= 0:
        raise InputError("the two joints are locked at the start: the wheel axes meet in one point", place="q0")
    end = periods * period
    run = solve_ivp(
        lambda t, y: snake.control_basis(y) @ inputs(t, y),
        (0.0, end),
        q,
        method="DOP853",
        rtol=1e-10,
        atol=1e-12,
        events=locked,
        t_eval=np.linspace(0.0, end, 60 * periods + 1),
    )
    used = np.array([inputs(t, y) for t, y in zip(run.t, run.y.T)])
    rates = np.einsum("kij,kj->ki", snake.control_basis(run.y.T), used)
    residual = float(np.abs(np.einsum("kij,kj->ki", snake.pfaff(run.y.T), rates)).max())
    reason = "" if run.status == 0 else f"the driven joints locked at t = {float(run.t_events[0][0]):.3g} s"
    motion = Motion(run.t, run.y.T.copy(), used, residual, 1e-9, reason)
    return Gait(motion, period, _per_period(motion, period, int(run.t[-1] / period + 1e-9)), worst, reason)


def _per_period(motion: Motion, period: float, periods: int) -> Array:
    at = period * np.arange(periods + 1)
    poses = np.stack([np.interp(at, motion.time, motion.q[:, i]) for i in range(3)], axis=1)
    return np.diff(poses, axis=0)
