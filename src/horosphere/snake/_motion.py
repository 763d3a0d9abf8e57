"""Motion under any input: piecewise constant, a callable, or a spline."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array
from ._extended import extended_angles, two_to

if TYPE_CHECKING:
    from ._snake import Snake

_LONGEST_STEP = 0.5  # of (speed of a joint) x 1/(f length) x time: an eighth-order step then errs by about 1e-6
_DOUBLINGS = 10
_MOST_STEPS = 200_000  # followed in extended precision


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A simulated motion: `time` (k,) seconds, `q` (k, N+3), `inputs` (k, 4) at those times (after a jump).

    `residual`: largest sideways speed of a wheel, m/s, the Pfaff matrix at the computed postures times the computed rates.
    `error`: estimated error of q, from halving the steps; `reason` is "" or says that the tolerance was not met.
    """

    time: NDArray[np.float64]
    q: NDArray[np.float64]
    inputs: NDArray[np.float64]
    residual: float
    error: float
    reason: str

    @property
    def end(self) -> NDArray[np.float64]:
        return self.q[-1]

    @property
    def displacement(self) -> NDArray[np.float64]:
        """q at the end less q at the start (angles not wrapped)."""
        return self.q[-1] - self.q[0]


def simulate(
    snake: Snake, q0: ArrayLike, controls: object, duration: float, durations: ArrayLike | None, tolerance: float
) -> Motion:
    """See Snake.simulate."""
    start = snake.check(q0, single=True)
    duration = float(float_array(duration, "duration", ndim=0))
    if duration <= 0.0:
        raise InputError(f"expected a positive duration, got {duration}", place="duration")
    sampler, edges, spans = _controls(controls, float(duration), durations)
    fastest = float(np.max(snake.wheel_rates, initial=0.0))
    growth = max(1.0, snake.wheel_ratio)
    counts = []
    for a, b in zip(edges[:-1], edges[1:]):
        probe = sampler(np.linspace(a, b, 9))[:, :2]
        speed = float(np.linalg.norm(probe, axis=1).max())
        # powers of two: a part of a span is then exact, and every fineness follows the same inputs to the last digit
        counts.append(int(two_to(max(1.0, (b - a) * speed * fastest * growth / _LONGEST_STEP))))
    for integrate in (_floats, extended_angles):  # the second where rounding, amplified on the way, is what is left
        coarse = _run(snake, start, sampler, edges, spans, counts, integrate)
        error = np.inf
        for _ in range(_DOUBLINGS):
            counts = [2 * n for n in counts]
            fine = _run(snake, start, sampler, edges, spans, counts, integrate)
            before, error = error, float(np.abs(fine[1][-1] - coarse[1][-1]).max())
            coarse = fine
            if error <= tolerance or (error < 1e-6 and error > 0.25 * before):  # finer steps add rounding
                break
        if error <= tolerance or sum(counts) > _MOST_STEPS:
            break
    time, q, inputs, rates = coarse
    reason = "" if error <= tolerance else f"the tolerance {tolerance:g} was not met in {len(time) - 1} steps"
    pfaff = snake.pfaff(q)
    residual = float(np.abs(np.einsum("tij,tj->ti", pfaff, rates)).max(initial=0.0))
    return Motion(time, q, inputs, residual, error, reason)


Sampler = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def _controls(
    controls: object, duration: float, durations: ArrayLike | None
) -> tuple[Sampler, NDArray[np.float64], NDArray[np.float64]]:
    """The input as a function of many times, the times between which it is smooth, and the spans between them."""
    if callable(controls):
        function = controls

        def sample(times: NDArray[np.float64]) -> NDArray[np.float64]:
            values = np.array([np.asarray(function(float(t)), dtype=np.float64) for t in times])
            return _four_inputs(values, "controls")

        knots = getattr(controls, "x", getattr(controls, "t", None))  # splines jump in some derivative at their knots
        inner = [] if knots is None else [float(t) for t in np.unique(np.asarray(knots)) if 0.0 < t < duration]
        knotted = np.array([0.0, *inner, duration])
        return sample, knotted, np.diff(knotted)
    values = _four_inputs(float_array(controls, "controls", ndim=2), "controls")  # type: ignore[arg-type]
    if durations is None:
        lengths = np.full(len(values), duration / len(values))
    else:
        lengths = float_array(durations, "durations", last=len(values), ndim=1)
        if lengths.min(initial=1.0) <= 0:
            raise InputError("expected positive durations", place="durations")
    edges = np.concatenate([[0.0], np.cumsum(lengths)])

    def steady(times: NDArray[np.float64]) -> NDArray[np.float64]:
        middle = 0.5 * (times[0] + times[-1])  # asked for within one segment at a time
        index = min(int(np.searchsorted(edges, middle, side="right")) - 1, len(values) - 1)
        return np.repeat(values[index : index + 1], len(times), axis=0)

    return steady, edges, np.array(lengths)


def _four_inputs(values: NDArray[np.float64], name: str) -> NDArray[np.float64]:
    if values.ndim != 2 or values.shape[1] not in (2, 4) or len(values) == 0:
        raise InputError(
            f"expected inputs of shape (m, 4), or (m, 2) for g1 and g2 alone, got {values.shape}",
            place=name,
            remedy="the four inputs are: velocity of joint 1 along e1 and e2 (m/s), head link rate, tail joint rate (rad/s)",
        )
    if not np.isfinite(values).all():
        raise InputError("expected finite inputs", place=name)
    return values if values.shape[1] == 4 else np.concatenate([values, np.zeros_like(values)], axis=1)


def _floats(theta: NDArray, inputs: NDArray, steps: NDArray, rate: NDArray, ratio: float) -> NDArray:
    from ._kernels import flow

    out = np.empty((len(steps) + 1, len(theta)))
    flow(theta, inputs, steps, rate, ratio, out)
    return out


def _run(
    snake: Snake,
    start: NDArray,
    sampler: Sampler,
    edges: NDArray,
    spans: NDArray,
    counts: list[int],
    integrate: Callable[..., NDArray],
) -> tuple[NDArray, ...]:
    from ._kernels import NODE_WEIGHTS, NODES

    steps = np.concatenate([np.full(n, span / n) for span, n in zip(spans, counts)])
    blocks, ends = [], []
    for a, b, n in zip(edges[:-1], edges[1:], counts):
        h = (b - a) / n
        times = (a + h * (np.arange(n)[:, None] + NODES)).ravel()
        # a value taken at a knot must be the one inside: shrink the outermost times by rounding
        times = np.clip(times, a + 1e-13 * (b - a), b - 1e-13 * (b - a))
        blocks.append(sampler(times).reshape(n, 5, 4))
        ends.append(blocks[-1][:, 0])
    inputs = np.concatenate(blocks)
    z0 = snake.to_angles(start)
    wheeled = len(snake.lengths) - 2
    plane = np.ascontiguousarray(inputs[:, :, :2])
    theta = integrate(z0[3 : 3 + wheeled].copy(), plane, steps, snake.wheel_rates, snake.wheel_ratio)
    moved = np.cumsum(np.einsum("snk,n,s->sk", inputs, NODE_WEIGHTS, steps), axis=0)
    moved = np.concatenate([np.zeros((1, 4)), moved])
    z = np.empty((len(steps) + 1, len(z0)))
    z[:, :3], z[:, -1] = z0[:3] + moved[:, :3], z0[-1] + moved[:, 3]
    z[:, 3 : 3 + wheeled] = theta
    time = np.concatenate([[0.0], np.cumsum(steps)])
    used = np.concatenate([np.concatenate(ends), inputs[-1:, -1]])
    return time, snake.from_angles(z), used, snake.angle_rates(z, used)
