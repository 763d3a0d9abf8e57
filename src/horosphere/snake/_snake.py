"""The snake robot: its data, and every question one can ask it."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..kernels import Kernel
from ..numeric import float_array
from . import _singular
from ._growth import Growth, growth
from ._inverse import ClosedChains, closed_chain, from_joints
from ._model import snake_kernel
from ._word import read_word

if TYPE_CHECKING:
    from ._brackets import BracketMotion
    from ._motion import Motion
    from ._navigate import Navigation
    from ._steer import Steering

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False, init=False, repr=False)
class Snake:
    """A snake robot in the plane: links 0 .. N, passive wheels on links 1 .. N-1, joints Q_0 (head) .. Q_{N+1}.

    A posture is q = (x, y, theta, Phi_1 .. Phi_N), N = links - 1: position of Q_0 (m), angle of link 0, relative angles of
    the next links (rad). Inputs: velocity of Q_1 along e1 and e2 with a steady head (m/s), rate of the head link about Q_1,
    rate of the last joint (rad/s). `wheel_fraction` f puts the wheels at f times the length behind the front joint of their
    link. Leading axes are batch. [Snake] sec. 4, corrected: docs/errata.md.
    """

    lengths: Array
    wheel_fraction: float
    _data: Array = field(repr=False)
    _model: Kernel = field(repr=False)

    def __init__(
        self,
        links: int | None = None,
        length: float = 2.0,
        *,
        lengths: ArrayLike | None = None,
        wheel_fraction: float = 0.5,
    ) -> None:
        """`links` of equal `length` (metres; 6 of 2 m by default), or one number each in `lengths`. Raises InputError."""
        if lengths is None:
            count = 6 if links is None else _whole_number(links)
            values = np.full(max(count, 0), _number(length, "length"))
        else:
            values = float_array(lengths, "lengths", ndim=1).copy()
            count = len(values)
            if links is not None and _whole_number(links) != count:
                raise InputError(f"expected {links} lengths, one a link, got {count}", place="lengths")
        if count < 3:
            raise InputError(
                f"a snake needs at least 3 links (one wheeled link between head and tail), got {count}",
                place="links" if lengths is None else "lengths",
            )
        if not (np.isfinite(values).all() and values.min() > 0):
            raise InputError(f"expected positive link lengths in metres, got {values.tolist()}", place="lengths")
        fraction = _number(wheel_fraction, "wheel_fraction")
        if not 0.0 < fraction <= 1.0:
            raise InputError(
                f"expected the place of the wheels along the link, above 0 and up to 1, got {fraction}",
                place="wheel_fraction",
                remedy="0.5 is the midpoint; at 0 the wheels stand on the joint and cannot steer the link",
            )
        data = np.append(values, fraction)
        values = data[:-1]
        data.flags.writeable = False
        object.__setattr__(self, "lengths", values)
        object.__setattr__(self, "wheel_fraction", fraction)
        object.__setattr__(self, "_data", data)
        object.__setattr__(self, "_model", snake_kernel("model", count))

    def __repr__(self) -> str:
        equal = np.ptp(self.lengths) == 0.0
        size = f"length={self.lengths[0]:g}" if equal else f"lengths={self.lengths.tolist()}"
        return f"Snake(links={self.links}, {size}, wheel_fraction={self.wheel_fraction:g})"

    @property
    def links(self) -> int:
        return len(self.lengths)

    @property
    def n(self) -> int:
        """Number of coordinates, N + 3."""
        return len(self.lengths) + 2

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return ("x", "y", "theta", *(f"Phi_{i}" for i in range(1, self.links)))

    @property
    def wheel_rates(self) -> Array:
        """1 / (f length) of the wheeled links: turning rate per sideways speed of the front joint, 1/m."""
        return 1.0 / (self.wheel_fraction * self.lengths[1:-1])

    @property
    def wheel_ratio(self) -> float:
        """(1 - f) / f: what a link makes of the sideways speed of its front joint; 1 at the midpoint."""
        return (1.0 - self.wheel_fraction) / self.wheel_fraction

    def check(self, q: ArrayLike, name: str = "q", single: bool = False) -> Array:
        """q as a float64 array (..., N+3) of finite numbers; `single` refuses batches. Raises InputError."""
        array = float_array(q, name, ndim=1 if single else None)
        if array.ndim == 0 or array.shape[-1] != self.n:
            raise InputError(
                f"expected a posture of {self.n} numbers (x, y, theta, Phi_1 .. Phi_{self.links - 1}), got shape {array.shape}",
                place=name,
            )
        return array

    # -- kinematics -----------------------------------------------------------------------------------------------------

    def _evaluate(self, what: str, q: ArrayLike, shape: tuple[int, ...], out: Array | None = None) -> Array:
        array = self.check(q)
        flat = None if out is None else out.reshape(*array.shape[:-1], -1)
        result = snake_kernel(what, self.links)(array, self._data, out=flat)
        return out if out is not None else result.reshape(*array.shape[:-1], *shape)

    def joints(self, q: ArrayLike, out: Array | None = None) -> Array:
        """Joints with head and tail point Q_0 .. Q_{N+1}, metres, (..., N+2, 2): Q_i = M_i e0 ~M_i. [Snake] sec. 4."""
        return self._evaluate("joints", q, (self.links + 1, 2), out)

    def centres(self, q: ArrayLike, out: Array | None = None) -> Array:
        """Wheel points p_i of all links, metres, (..., N+1, 2): link centres for wheels at the midpoint. [Snake] sec. 4."""
        return self._evaluate("centres", q, (self.links, 2), out)

    def frames(self, q: ArrayLike) -> Array:
        """Motors of the link frames (..., N+1, 4), coefficients of 1, e12, e1 einf, e2 einf; origin Q_i, e1 along the link."""
        return self._evaluate("frames", q, (self.links, 4))

    def axes(self, q: ArrayLike) -> Array:
        """Rotation axes L_i = M_i e12 ~M_i of the links (..., N+1, 3): coefficients of e12, e1 einf, e2 einf."""
        return self._evaluate("axes", q, (self.links, 3))

    def point_pairs(self, q: ArrayLike) -> Array:
        """Point pairs P_i = Q_i ^ Q_{i+1} (OPNS), (..., N+1, 6): coefficients of e12, e10, e1 einf, e20, e2 einf, e0^einf."""
        a, b = (x for x in _consecutive(self.joints(q)))
        square_a, square_b = 0.5 * (a * a).sum(-1), 0.5 * (b * b).sum(-1)
        (ax, ay), (bx, by) = (np.moveaxis(x, -1, 0) for x in (a, b))
        parts = (
            ax * by - ay * bx,
            ax - bx,
            ax * square_b - bx * square_a,
            ay - by,
            ay * square_b - by * square_a,
            square_b - square_a,
        )
        return np.stack(parts, axis=-1)

    def jacobian(self, q: ArrayLike, out: Array | None = None) -> Array:
        """Velocities of the wheel points per unit rate, (..., N+1, 2, N+3): column k is p_i . L_k. [Snake] (3), Theorem."""
        return self._evaluate("jacobian", q, (self.links, 2, self.n), out)

    def pfaff(self, q: ArrayLike, out: Array | None = None) -> Array:
        """Pfaff matrix A (..., N-1, N+3), metres: sideways velocity of the wheels of links 1 .. N-1. [Snake] (4)-(6)."""
        return self._evaluate("pfaff", q, (self.links - 2, self.n), out)

    def control_basis(self, q: ArrayLike, out: Array | None = None) -> Array:
        """Control fields g1 .. g4 as columns (..., N+3, 4), without denominators, A G = 0 everywhere. Our derivation.

        g1, g2: joint 1 moves along e1, e2 and each link passes the velocity on by u -> d (d.u) - (1-f)/f n (n.u), the
        reflection d u d for midpoint wheels; g3: the head link turns about joint 1; g4: the last joint.
        """
        return self._evaluate("control_basis", q, (self.n, 4), out)

    def model(self, q: ArrayLike, out: Array | None = None) -> Array:
        """Joints, Pfaff matrix and control basis by one kernel, flat (..., K); `split_model` gives the three parts."""
        if (
            type(q) is np.ndarray and q.ndim == 1 and q.dtype == np.float64
        ):  # the single call: no copies, one finiteness check
            if not isfinite(q.dot(q)):
                self.check(q)
            return self._model(q, self._data, out=out)
        return self._model(self.check(q), self._data, out=out)

    def split_model(self, flat: Array) -> tuple[Array, Array, Array]:
        """Views (..., N+2, 2), (..., N-1, N+3), (..., N+3, 4) of what `model` returned."""
        cuts = [2 * (self.links + 1), 2 * (self.links + 1) + (self.links - 2) * self.n]
        shapes = ((self.links + 1, 2), (self.links - 2, self.n), (self.n, 4))
        parts = np.split(flat, cuts, axis=-1)
        return tuple(p.reshape(*flat.shape[:-1], *s) for p, s in zip(parts, shapes))  # type: ignore[return-value]

    # -- postures -------------------------------------------------------------------------------------------------------

    def singularity(self, q: ArrayLike) -> Array:
        """How far the wheel axes are from meeting in one point or being parallel, (...,), 0 to 1; 0 is singular.

        The wedge test on the IPNS wheel axes, as a smallest singular value. Fewer than three wheeled links are always
        singular in this sense. [Snake] (7), corrected: docs/errata.md.
        """
        return _singular.singularity(self.joints(q), self.lengths, self.wheel_fraction)

    def is_singular(self, q: ArrayLike, tolerance: float = 1e-9) -> NDArray[np.bool_]:
        """Whether all wheel axes meet in one point or are parallel, so that the body can turn with its joints locked."""
        return np.asarray(self.singularity(q) <= tolerance)

    def folds(self, q: ArrayLike, tolerance: float = 1e-9) -> tuple[int, ...]:
        """Joints of one posture that lie on a fold (Phi_j = pi) which no motion reaches or leaves. Our derivation."""
        posture = self.check(q, single=True)
        joints = _singular.fold_joints(self.lengths, self.wheel_fraction)
        bent = np.pi - np.abs(np.remainder(posture[2 + joints] + np.pi, 2 * np.pi) - np.pi)
        return tuple(int(j) for j in joints[bent <= tolerance])

    def regularity(self, q: ArrayLike) -> Array:
        """The determinant that vanishes exactly at non-generic postures, (...,): N = 4, 5, equal lengths, midpoint wheels."""
        if self.links not in (5, 6) or np.ptp(self.lengths) > 0 or self.wheel_fraction != 0.5:
            raise InputError(
                f"the closed form is known for 5 or 6 equal links with midpoint wheels, this is {self!r}",
                remedy="use growth_vector, which is exact for every snake",
            )
        return _singular.regularity(self.check(q), self.lengths)

    def growth(self, q: ArrayLike, method: str = "auto", fields: int = 2) -> Growth:
        """Growth vector at one posture with its certificate, weights, factor and degree. Our derivation: docs/snake.md.

        `method`: "auto", "spectral" (exact rational arithmetic, midpoint wheels), "words" (exact modulo primes, any wheels;
        `fields=4` brackets all of g1 .. g4), "float". Angles are read as exact: equal ones equal, opposite ones opposite,
        0 zero, pi and pi/2 themselves. Raises InputError.
        """
        return growth(self.check(q, single=True), self.lengths, self.wheel_fraction, method, fields)

    def growth_vector(self, q: ArrayLike, exact: bool = True) -> tuple[int, ...]:
        """Growth vector (n_1, .., n_r) at one posture; `exact=False` ranks floats and warns where they decide nothing.

        [Snake] sec. 3, corrected: docs/errata.md.
        """
        found = self.growth(q, "auto" if exact else "float")
        if not found.is_decided:
            import warnings

            warnings.warn(found.reason, stacklevel=2)
        return found.vector

    def from_joints(self, points: ArrayLike, tolerance: float = 1e-6) -> Array:
        """The posture (..., N+3) with the given joints (..., N+2, 2), angles in (-pi, pi]. [Snake] sec. 6, corrected.

        Raises InputError where neighbours are not one link apart within `tolerance`, metres.
        """
        return from_joints(points, self.lengths, tolerance)

    def closed_chain(self, head: ArrayLike, tail: ArrayLike, free: ArrayLike) -> ClosedChains:
        """All postures whose first and last link are given. Our derivation, from [Snake] sec. 6.

        `head` (2, 2): Q_0, Q_1; `tail` (2, 2): Q_N, Q_{N+1}, metres; `free` (..., N-3): the absolute angles of links
        1 .. N-3 (rad), which parametrise the solutions; the last two links are the meet of two circles, two ways.
        """
        return closed_chain(head, tail, free, self.lengths)

    # -- motion ---------------------------------------------------------------------------------------------------------

    def simulate(
        self,
        q0: ArrayLike,
        controls: Any,
        duration: float = 1.0,
        *,
        durations: ArrayLike | None = None,
        tolerance: float = 1e-10,
    ) -> Motion:
        """The motion from q0 (N+3,) under any input.

        `controls`: (m, 4) or (m, 2) piecewise constant inputs, over equal parts of `duration` seconds or over `durations`
        (m,); or a callable of time (splines too) giving 4 or 2 inputs. Order-8 Runge-Kutta, halved until `tolerance`.
        """
        from ._motion import simulate

        return simulate(self, q0, controls, duration, durations, tolerance)

    def bracket(self, q: ArrayLike, word: Any) -> Array:
        """Value of a Lie bracket of g1 .. g4 at q, (..., N+3), with [X, Y] = DY X - DX Y.

        `word`: nested pairs (1, (2, (1, 2))), the text "[1,[2,[1,2]]]", or "1212" for the right-normed bracket. Exact formulas in
        floats, no differences. Raises InputError for unknown letters.
        """
        from ._brackets import bracket_vector

        return bracket_vector(self, self.check(q), read_word(word))

    def bracket_motion(self, q0: ArrayLike, word: Any, t: float = 0.1) -> BracketMotion:
        """A bracket carried out as an input word with legs of t seconds: predicted and measured displacement, and order."""
        from ._brackets import bracket_motion

        return bracket_motion(self, q0, read_word(word), t)

    def steer(self, q0: ArrayLike, q1: ArrayLike, tolerance: float = 1e-9, **options: Any) -> Steering:
        """Inputs that move the snake from q0 exactly to q1; see `Steering` and docs/snake.md. Options: `SteerOptions`."""
        from ._steer import steer

        return steer(self, q0, q1, tolerance, **options)

    def navigate(self, q0: ArrayLike, q1: ArrayLike, obstacles: Any, **options: Any) -> Navigation:
        """A certified motion from q0 to q1 among obstacles in the plane; see `Navigation`. Options: `NavigateOptions`."""
        from ._navigate import navigate

        return navigate(self, q0, q1, obstacles, **options)

    # -- coordinates of the integrators ---------------------------------------------------------------------------------

    def to_angles(self, q: Array) -> Array:
        """(x, y of joint 1, absolute angles of links 0 .. N-1, Phi_N): coordinates in which the inputs act simply."""
        angles = np.cumsum(q[..., 2:-1], axis=-1)
        z = np.concatenate([q[..., :2], angles, q[..., -1:]], axis=-1)
        z[..., 0] += self.lengths[0] * np.cos(angles[..., 0])
        z[..., 1] += self.lengths[0] * np.sin(angles[..., 0])
        return z

    def from_angles(self, z: Array) -> Array:
        """The inverse of `to_angles`."""
        q = z.copy()
        q[..., 0] -= self.lengths[0] * np.cos(z[..., 2])
        q[..., 1] -= self.lengths[0] * np.sin(z[..., 2])
        q[..., 3:-1] = np.diff(z[..., 2:-1], axis=-1)
        return q

    def angle_rates(self, z: Array, inputs: Array) -> Array:
        """Rates of q, (..., N+3), from the angle coordinates and the four inputs (..., 4)."""
        rates = np.zeros_like(z)
        c, s = np.cos(z[..., 2:-1]), np.sin(z[..., 2:-1])
        ux, uy = inputs[..., 0], inputs[..., 1]
        rates[..., 0] = ux + self.lengths[0] * s[..., 0] * inputs[..., 2]
        rates[..., 1] = uy - self.lengths[0] * c[..., 0] * inputs[..., 2]
        rates[..., 2] = before = inputs[..., 2]
        for j, rate in enumerate(self.wheel_rates, start=1):
            across, along = c[..., j] * uy - s[..., j] * ux, c[..., j] * ux + s[..., j] * uy
            rates[..., 2 + j], before = -rate * across - before, -rate * across
            ux = c[..., j] * along + self.wheel_ratio * s[..., j] * across
            uy = s[..., j] * along - self.wheel_ratio * c[..., j] * across
        rates[..., -1] = inputs[..., 3]
        return rates


def _consecutive(points: Array) -> tuple[Array, Array]:
    return points[..., :-1, :], points[..., 1:, :]


def _whole_number(links: Any) -> int:
    if isinstance(links, bool) or not isinstance(links, (int, np.integer)):
        raise InputError(f"expected a whole number of links, got {links!r}", place="links")
    return int(links)


def _number(value: Any, name: str) -> float:
    array = float_array(value, name)
    if array.ndim:
        raise InputError(f"expected one number, got shape {array.shape}", place=name, remedy="use lengths=[...]")
    return float(array)
