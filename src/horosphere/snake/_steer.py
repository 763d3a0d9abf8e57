"""Steering from posture to posture: the return method.

A path run out and back brings every driftless system to where it was, but the motion linearised along it reaches all
directions that brackets reach. So an out-and-back path is a start from which Newton's method on the end point works,
where zero input (whose linearisation has rank 4) is none. The best such path is the plainest: drive straight ahead, head
leading, for about one and a half lengths of the body, and back. Along it each midpoint-wheeled link is the all-pass filter
(1 - s l/2)/(1 + s l/2), and the body a Laguerre cascade, whose states are as independent as states can be: the smallest
singular value of the linearisation is 30 to 1000 times that of random loops of the same length. Our derivation.

The way back is unstable (angles grow as exp(2 s / l)), so the postures between the segments are unknowns too (multiple
shooting): a step is small when neither inputs nor postures change much, and rounding does not grow along the way.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array, wrap_angle
from ._extended import extended_angles, two_to
from ._returns import out_and_back
from ._singular import fold_joints

if TYPE_CHECKING:
    from ._motion import Motion
    from ._snake import Snake

Array = NDArray[np.float64]

_CLOSE = 1e-11
_FINEST = 4e-3
_LOOK_ON = 3  # starting paths still tried for a less sensitive motion once one is exact to half the tolerance


@dataclass(frozen=True, slots=True)
class SteerOptions:
    """How hard to search. `segments` of constant input in unit time, `tries` out-and-back paths to start from, `shorten`
    steps that reduce the input's energy, `seed` of the paths, `iterations` of Newton's method;
    `skip` leaves out the first paths, for another motion to the same goal; `legs` motions at most, one after another, where a
    single one is too sensitive to end exactly or none is found."""

    segments: int = 24
    tries: int = 16
    shorten: int = 60
    seed: int = 0
    iterations: int = 40
    skip: int = 0
    legs: int = 4


@dataclass(frozen=True, slots=True, eq=False)
class Steering:
    """The outcome of steering.

    `inputs` (m, 4) are constant over equal parts of `duration` seconds (one a leg); `error` is the largest coordinate
    error at the end, by a finer integration than the search used; `path_length`: metres that joint 1 travels; `tries`:
    starting paths used;
    `reason` is "" when `solved`.
    """

    solved: bool
    reason: str
    inputs: Array
    duration: float
    error: float
    path_length: float
    tries: int
    motion: Motion


class _Shooting:
    """The snake cut into m segments of constant input in unit time: postures between them and inputs are the unknowns.

    Unknowns: angles theta_1 .. theta_{m-1} at the cuts (m-1, k) and inputs (m, 2). Equations: each segment ends where
    the next starts, the last at the goal; the inputs bring joint 1 to the goal.
    """

    def __init__(self, snake: Snake, start: Array, goal: Array, segments: int) -> None:
        self.first, self.last, self.shift = start[3:-1], goal[3:-1], goal[:2] - start[:2]
        self.rate, self.ratio = snake.wheel_rates, snake.wheel_ratio
        self.stiffest = float(self.rate.max()) * max(1.0, self.ratio)
        self.count, self.k = segments, len(self.rate)
        self.fineness = 1.0  # of the integration between the cuts

    def flow(self, cuts: Array | None, inputs: Array, fineness: float = 1.0) -> tuple[Array, Array, Array]:
        """Starts, ends (m, k) and tangents (m, k, k+2) of the segments; without cuts each starts where the last ended."""
        from ._kernels import segment_flow

        fastest = float(np.sqrt((inputs * inputs).sum(axis=1).max())) * self.stiffest / self.count
        sub = max(1, int(np.ceil(2.0 * fineness * min(fastest, 50.0))))
        theta, ends = np.empty((2, self.count, self.k))
        theta[0] = self.first
        if cuts is not None:
            theta[1:] = cuts
        tangent = np.empty((self.count, self.k, self.k + 2))
        segment_flow(theta, inputs, 1.0 / self.count, sub, self.rate, self.ratio, cuts is None, ends, tangent)
        return theta, ends, tangent

    def defects(self, cuts: Array, inputs: Array, goal: Array, shift: Array) -> tuple[Array, Array]:
        """What is left of the equations, (m k + 2,), and the tangents."""
        _, ends, tangent = self.flow(cuts, inputs, self.fineness)
        wanted = np.concatenate([cuts, goal[None]])
        return np.concatenate([(wanted - ends).ravel(), shift - inputs.mean(axis=0)]), tangent

    def step(self, tangent: Array, defect: Array, pull: Array, ease: float) -> tuple[Array, Array]:
        """The change of cuts and inputs that meets the linearised equations with least weighted size.

        Minimises |d cuts|^2 + w |d inputs - ease pull|^2, w = (segment's turning per unit of input)^2.
        """
        from ._kernels import arrow_solve

        m, k = self.count, self.k
        loose = (m / self.stiffest) ** 2  # an input changes as easily as the angle it turns a link by in one segment
        a, b = tangent[:, :, :k], tangent[:, :, k:]
        size = m * k + 2
        gram = np.zeros((size, size))
        blocks = loose * (b @ np.swapaxes(b, 1, 2))
        blocks[1:] += a[1:] @ np.swapaxes(a[1:], 1, 2)
        blocks[:-1] += np.eye(k)
        for i in range(m):
            here = slice(i * k, (i + 1) * k)
            gram[here, here] = blocks[i]
            if i:
                before = slice((i - 1) * k, i * k)
                gram[here, before] = -a[i]
                gram[before, here] = -a[i].T
            gram[here, -2:] = loose / m * b[i]
            gram[-2:, here] = loose / m * b[i].T
        gram[-2:, -2:] = np.eye(2) * (loose / m)
        bias = ease * pull
        target = defect.copy()
        target[:-2] -= np.einsum("mij,mj->mi", b, bias).ravel()
        target[-2:] -= bias.mean(axis=0)
        # scaled to unit diagonal: the entries span many decades
        scale = 1.0 / np.sqrt(np.diag(gram))
        scaled = gram * scale * scale[:, None] + 1e-15 * np.eye(size)
        force = scale * target
        arrow_solve(scaled, 2 * k - 1, 2, force)
        force *= scale
        forces = force[:-2].reshape(m, k)
        inputs = bias + loose * (np.einsum("mij,mi->mj", b, forces) + force[-2:] / m)
        cuts = np.einsum("mij,mi->mj", a[1:], forces[1:]) - forces[:-1]
        return cuts, inputs

    def solve(
        self, cuts: Array, inputs: Array, goal: Array, shift: Array, iterations: int
    ) -> tuple[Array, Array, float]:
        """Damped Newton on the equations; the error that is left."""
        defect, tangent = self.defects(cuts, inputs, goal, shift)
        size = float(np.linalg.norm(defect))
        for _ in range(iterations):
            if size < _CLOSE or not np.isfinite(size):
                break
            d_cuts, d_inputs = self.step(tangent, defect, inputs, 0.0)
            step = min(1.0, 1.0 / max(float(np.abs(d_cuts).max()), 1e-12))
            while True:
                trial = cuts + step * d_cuts, inputs + step * d_inputs
                new_defect, new_tangent = self.defects(*trial, goal, shift)
                new_size = float(np.linalg.norm(new_defect))
                if new_size < (1.0 - 0.1 * step) * size:
                    break
                step *= 0.5
                if step < 1e-2:
                    return cuts, inputs, size
            (cuts, inputs), defect, tangent, size = trial, new_defect, new_tangent, new_size
        return cuts, inputs, size

    def attempt(self, inputs: Array, iterations: int) -> tuple[Array, Array, float]:
        """From inputs that lead back to the start to ones that lead to the goal: at once, else by goals in between."""
        theta, ends, _ = self.flow(None, inputs)
        begin, begin_shift = ends[-1], inputs.mean(axis=0)
        cuts, done, part, left = theta[1:], 0.0, 1.0, np.inf
        while done < 1.0:
            part = min(part, 1.0 - done)
            at = done + part
            goal, shift = begin + at * (self.last - begin), begin_shift + at * (self.shift - begin_shift)
            *trial, left = self.solve(cuts, inputs, goal, shift, iterations)
            if left < _CLOSE:
                (cuts, inputs), done, part = trial, at, 2.0 * part
            else:
                part *= 0.4
                if part < _FINEST:
                    return cuts, inputs, left
        return cuts, inputs, left

    def shorten(self, cuts: Array, inputs: Array, steps: int) -> tuple[Array, Array]:
        """Less energy at the same end: steps toward smaller inputs within the equations."""
        ease = 0.3
        for _ in range(steps):
            defect, tangent = self.defects(cuts, inputs, self.last, self.shift)
            energy = float((inputs**2).sum())
            accepted = False
            while ease > 2e-3 and not accepted:
                d_cuts, d_inputs = self.step(tangent, defect, -inputs, ease)
                if float(np.abs(d_cuts).max()) < 1.0:
                    *trial, left = self.solve(cuts + d_cuts, inputs + d_inputs, self.last, self.shift, 4)
                    accepted = left < _CLOSE and float((trial[1] ** 2).sum()) < energy
                if not accepted:
                    ease *= 0.5
            if not accepted or float((trial[1] ** 2).sum()) > (1.0 - 2e-4) * energy:
                break
            cuts, inputs = trial
            ease = min(0.9, 1.5 * ease)
        return cuts, inputs

    def polish(self, inputs: Array) -> tuple[Array, float]:
        """Newton on the end point alone, followed with 32 digits; also the error that twice finer steps find.

        A way back of two body lengths amplifies rounding 1e8 times for N = 7: floats alone cannot tell where it ends.
        """
        fastest = float(np.sqrt((inputs * inputs).sum(axis=1).max())) * self.stiffest / self.count
        sub = int(min(128.0, two_to(max(1.0, 8.0 * fastest))))
        fine = 4 * sub
        for _ in range(16):
            cuts = self._follow(inputs, sub)
            error = np.concatenate([self.last - cuts[-1], self.shift - inputs.mean(axis=0)])
            size = float(np.abs(error).max())
            if not size < 1.0:  # also where it is not a number: the path is too sensitive to follow
                return inputs, np.inf
            if size < 1e-7 and sub < fine:
                sub = fine
                continue
            if size < 1e-12:
                break
            jacobian = self._end_jacobian(self.flow(cuts[:-1], inputs, 2.0)[2])
            inputs = inputs + _weak_change(jacobian, error, size < 1e-4).reshape(-1, 2)
        ends = self._follow(inputs, 2 * sub)[-1]
        left = float(np.abs(ends - self.last).max() + np.abs(self.shift - inputs.mean(axis=0)).max())
        return inputs, left if np.isfinite(left) else np.inf

    def _follow(self, inputs: Array, sub: int) -> Array:
        """Ends (m, k) of the segments, one after another in extended precision; `sub` is a power of two."""
        nodes = np.repeat(np.repeat(inputs, sub, axis=0)[:, None, :], 5, axis=1)
        steps = np.full(len(nodes), 1.0 / self.count / sub)
        return extended_angles(self.first, nodes, steps, self.rate, self.ratio)[sub::sub]

    def _end_jacobian(self, tangent: Array) -> Array:
        m, k = self.count, self.k
        jacobian = np.zeros((k + 2, 2 * m))
        carry = np.eye(k)
        for i in range(m - 1, -1, -1):
            jacobian[:k, 2 * i : 2 * i + 2] = carry @ tangent[i, :, k:]
            carry = carry @ tangent[i, :, :k]
        jacobian[k, 0::2] = jacobian[k + 1, 1::2] = 1.0 / m
        return jacobian


def steer(snake: Snake, q0: ArrayLike, q1: ArrayLike, tolerance: float, **options: object) -> Steering:
    """See Snake.steer."""
    settings = _settings(options)
    start, goal = snake.check(q0, "q0", single=True), snake.check(q1, "q1", single=True)
    tolerance = float(float_array(tolerance, "tolerance", ndim=0))
    if tolerance < 1e-12:
        raise InputError(f"expected a tolerance of at least 1e-12, got {tolerance}", place="tolerance")
    for posture, name in ((start, "q0"), (goal, "q1")):
        folded = snake.folds(posture)
        if folded:
            raise InputError(
                f"the posture lies on the fold of joint {', '.join(map(str, folded))} (Phi = pi)",
                place=name,
                remedy="no motion reaches or leaves such a fold, the wheels of the two links stand on one another; "
                "choose a posture off it",
            )
    rng = np.random.default_rng(settings.seed)
    here, legs, tries, best = start, [], 0, np.inf
    while len(legs) < settings.legs:
        leg = _one_leg(snake, here, goal, settings, tolerance, rng)
        tries += leg.tries
        best = min(best, leg.error)
        if leg.error > tolerance and len(legs) + 1 < settings.legs:
            halfway = here + 0.5 * (_nearest(snake, here, goal) - here)
            if not snake.folds(halfway):
                half = _one_leg(snake, here, halfway, settings, tolerance, rng)
                tries += half.tries
                leg = leg if half.inputs is None else half  # two short motions lose less to rounding than a long one
        if leg.inputs is None:
            break
        legs.append(leg.inputs)
        if leg.motion is not None:
            here = leg.motion.end
        if leg.error <= tolerance and np.abs(here - _nearest(snake, here, goal)).max() <= tolerance:
            break
    inputs = np.concatenate(legs) if legs else np.zeros((settings.segments, 4))
    duration = float(max(1, len(legs)))
    motion = snake.simulate(start, inputs, duration, tolerance=0.1 * tolerance)
    error = float(np.abs(motion.end - _nearest(snake, motion.end, goal)).max())
    solved = error <= tolerance
    reason = (
        ""
        if solved
        else f"no input found from {tries} starting paths; the smallest error left was {min(best, error):.2g}"
    )
    length = float(np.linalg.norm(inputs[:, :2], axis=1).mean()) * duration
    return Steering(solved, reason, inputs, duration, error, length, tries, motion)


def _weak_change(jacobian: Array, error: Array, near: bool) -> Array:
    """The change of inputs that takes the error away: of least size in units of effect, near the end by weak inputs alone.

    An input of effect 1e8 moves the end by 1e-8 when its last digit changes: the last steps must leave it untouched.
    """
    effect = np.sqrt((jacobian**2).sum(axis=0))
    for most in (1e2, 1e4, 1e6) if near else ():
        some = effect < most
        weight = 1.0 / effect[some]
        part = weight * np.linalg.lstsq(jacobian[:, some] * weight, error, rcond=1e-13)[0]
        left = np.linalg.norm(jacobian[:, some] @ part - error)
        if left < 1e-3 * np.linalg.norm(error) and np.abs(part).max(initial=0.0) < 0.1:
            change = np.zeros(len(effect))
            change[some] = part
            return change
    return np.linalg.lstsq(jacobian / effect, error, rcond=1e-13)[0] / effect


@dataclass(frozen=True, slots=True, eq=False)
class _Leg:
    """Inputs of unit time that end within `error` of the goal, or None where nothing came near."""

    inputs: Array | None
    error: float
    tries: int
    motion: Motion | None


def _one_leg(
    snake: Snake, start: Array, goal: Array, settings: SteerOptions, tolerance: float, rng: np.random.Generator
) -> _Leg:
    """The most exact motion from the starting paths; one that only comes near is worth keeping: a shorter one can follow it."""
    z0, z1 = snake.to_angles(start), snake.to_angles(_nearest(snake, start, goal))
    search = _Shooting(snake, z0, z1, settings.segments)
    body = float(snake.lengths[1:-1].sum())
    inputs = np.zeros((settings.segments, 4))
    inputs[:, 2], inputs[:, 3] = z1[2] - z0[2], z1[-1] - z0[-1]
    distance = float(max(np.abs(search.last - search.first).max(), np.abs(search.shift).max()))
    if distance <= 0.01 * tolerance:
        motion = snake.simulate(start, inputs, 1.0)
        return _Leg(inputs, 0.0, 0, motion)
    best = _Leg(None, np.inf, 0, None)
    tries = since = 0
    while best.error > 0.3 * tolerance and tries < settings.tries and since < _LOOK_ON:
        path = out_and_back(search.first, settings.segments, settings.skip + tries, body, rng)
        tries += 1
        since += best.error <= tolerance
        cuts, found, left = search.attempt(path, settings.iterations)
        if left >= _CLOSE:
            continue
        cuts, found = search.shorten(cuts, found, settings.shorten)
        search.fineness = 5.0  # what a coarse segment errs by is amplified from the next cut to the end
        found, left = search.polish(search.solve(cuts, found, search.last, search.shift, 8)[1])
        search.fineness = 1.0
        if not left < min(0.1 * distance, best.error):
            continue
        trial = inputs.copy()
        trial[:, :2] = found
        motion = snake.simulate(start, trial, 1.0, tolerance=0.1 * tolerance)
        error = float(np.abs(motion.end - _nearest(snake, motion.end, goal)).max())
        if error < min(0.1 * distance, best.error):
            best = _Leg(trial, error, tries, motion)
    return _Leg(best.inputs, best.error, tries, best.motion)


def _settings(options: dict[str, object]) -> SteerOptions:
    from ..errors import unknown_name

    for name in options:
        if name not in SteerOptions.__dataclass_fields__:
            raise unknown_name("option", name, SteerOptions.__dataclass_fields__, place="steer")
    settings = SteerOptions(**options)  # type: ignore[arg-type]
    if settings.segments < 8 or settings.segments % 2:
        raise InputError(f"expected an even number of segments, 8 or more, got {settings.segments}", place="segments")
    return settings


def _nearest(snake: Snake, start: Array, goal: Array) -> Array:
    """`goal` with each angle shifted by turns to where it can be reached from `start`: never through a fold."""
    shifted = goal.copy()
    shifted[2:] = start[2:] + wrap_angle(goal[2:] - start[2:])
    for j in 2 + fold_joints(snake.lengths, snake.wheel_fraction):
        shifted[j] = goal[j] + (start[j] - wrap_angle(start[j])) - (goal[j] - wrap_angle(goal[j]))
    return shifted
