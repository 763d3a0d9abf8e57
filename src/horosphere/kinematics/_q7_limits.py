"""Where a joint of a sew7 arm stands at a limit, as a function of the last angle t = q7: roots of polynomials. Our derivation.

With u the vector from the wrist W to the shoulder S, |u|^2 and u . n6 are of first degree in t, and in q4; A + B cos q4 + C sin q4 =
|u|^2 ties the two. "Degree" is that of a trigonometric polynomial; it has twice as many roots.

- q4 = m is of degree 1 in t.
- q5 = m: n6 . turn(n5, -m) u is of degree 1 in q4 and equals u . n6; q6 = m: n5 . u is of degree 1 in q4 and equals
  n5 . turn(n6, m) u, of degree 1 in t. Each time two linear equations in cos q4, sin q4, so cos^2 + sin^2 = 1 is of degree 2 in t.
- q1, q2, q3 = m are a . R3 b = k with R3 the rotation of link 3. Two elbows and two wrists give four values, with nested square
  roots of polynomials. With s the distance of S to axis 5 (s' of the other elbow) and v = n6 x u, their product times s^4 s'^4 |v|^8
  is a polynomial, of degree 16; it has the factor s^2 s'^2 |v|^4, and what is left is of degree 8. This degree was not proved but
  counted, by the Fourier series of the product for random arms and poses (`tests/kinematics/test_q7_limits.py`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._existence import Trig, _chain_pose, _turn, q7_candidates, sorted_ends
from ._structured import _turns

Floats = NDArray[np.float64]
DEGREE = 8  # of the equation of q1, q2, q3 at a limit
_SAMPLES = 32  # of t for its coefficients: more than twice the degree
_SHIFTS = 5  # sets of them to choose from, to stay away from zeros of the factor


def q7_limit_candidates(made: Any, motor: Floats) -> Floats:
    """Sorted values of the last angle in [-pi, pi], ends included, between which no branch begins or ends to exist and no joint
    of it crosses a limit."""
    chain = made.structure.screws
    limits = -made.limits[::-1, ::-1] if made.structure.is_reversed else made.limits
    one = _Arm(chain.axes, chain.points, made.structure.special, _chain_pose(made, motor))
    found = [f.roots() for j in (4, 5) for m in limits[:, j] if np.isfinite(m) for f in one.wrist(j, float(m))]
    found += [f.roots() for f in one.shoulder(shoulder_equations(chain.axes, limits))]
    angles = np.concatenate([np.zeros(0), *found])
    return sorted_ends(np.concatenate([q7_candidates(made, motor), -angles if made.structure.is_reversed else angles]))


def shoulder_equations(n: Floats, limits: Floats) -> list[tuple[Floats, Floats, float]]:
    """a, b, k with a . R3 b = k where joint 1, 2 or 3 stands at a limit, or axes that are not at right angles end a branch."""
    from ._redundancy import _limit_equation

    found = [
        _limit_equation(n, np.eye(3), np.eye(3), j, float(m)) for j in range(3) for m in limits[:, j] if np.isfinite(m)
    ]
    alpha, gamma = float(n[0] @ n[1]), float(n[1] @ n[2])
    if max(abs(alpha), abs(gamma)) > 1e-9:
        size = float(np.sqrt((1.0 - alpha**2) * (1.0 - gamma**2)))
        found += [(n[0], n[2], alpha * gamma + size), (n[0], n[2], alpha * gamma - size)]
    return found


class _Arm:
    """One pose of one chain: what the equations are made of."""

    def __init__(self, axes: Floats, points: Floats, special: Floats, pose: Floats) -> None:
        self.n, self.p, (self.S, self.W) = axes, points, special
        self.R, self.t = pose[:3, :3], pose[:3, 3]
        three = np.array([0.0, 0.5 * np.pi, np.pi])
        u, m6, u6 = self.at(three)
        self.length2, self.along6 = Trig.sampled((u * u).sum(axis=-1)), Trig.sampled((u * m6).sum(axis=-1))
        self.seen6 = u6
        # S from W in the frame of link 3, at q4 = 0, pi/2, pi: constant, cosine and sine part; axis 5 likewise.
        self.turns4 = _turns(axes[3], three)
        self.u0 = _parts(self.S - (self.turns4 @ (self.W - points[3]) + points[3]))
        self.m5 = _parts(self.turns4 @ axes[4])
        self.A, self.B, self.C = _parts((_whole(self.u0, *_CORNERS) ** 2).sum(axis=-1))

    def at(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """u and n6 in the base (m, 3), and u in link 6 (m, 3), at angles t (m,)."""
        R6 = self.R @ _turns(self.n[6], -t)
        u = self.S - (R6 @ (self.W - self.p[6]) + self.R @ self.p[6] + self.t)
        return u, R6 @ self.n[5], np.einsum("mji,mj->mi", R6, u)

    def wrist(self, j: int, m: float) -> list[Trig]:
        """Of second degree in t: zero where joint 5 (j = 4) or 6 (j = 5) stands at m."""
        if j == 4:
            seen4 = np.einsum("mji,mj->mi", self.turns4, _whole(self.u0, *_CORNERS))
            x0, x1, x2 = _parts(seen4 @ (_turn(self.n[4], m) @ self.n[5]))
            right = self.along6
        else:
            x0, x1, x2 = _parts((_whole(self.u0, *_CORNERS) * _whole(self.m5, *_CORNERS)).sum(axis=-1))
            right = Trig.sampled(self.seen6 @ (_turn(self.n[5], -m) @ self.n[4]))
        g, k = self.length2 - self.A, right - x0
        down, across = g * x2 - k * self.C, k * self.B - g * x1
        det = self.B * x2 - self.C * x1
        if abs(det) < 1e-9 * np.hypot(self.B, self.C) * max(np.hypot(x1, x2), 1e-300):
            return [down, across]  # the two equations say the same of q4: what is left is of first degree in t
        return [down * down + across * across - det * det]

    def shoulder(self, equations: list[tuple[Floats, Floats, float]]) -> list[Trig]:
        """Of degree 8 in t: zero where a . R3 b = k on some branch."""
        t, values = self.products(equations)
        turns = np.exp(-1j * np.outer(np.arange(-DEGREE, DEGREE + 1), t)) / len(t)
        return [Trig(turns @ value) for value in values]

    def products(self, equations: list[tuple[Floats, Floats, float]]) -> tuple[Floats, list[Floats]]:
        """Even t (m,), and at them for each equation the product over the branches without its factor."""
        shift = np.arange(_SHIFTS)[:, None] / _SHIFTS
        t = (2.0 * np.pi / _SAMPLES) * (np.arange(_SAMPLES) + shift).reshape(-1)
        u, m6, _ = self.at(t)
        c = float(self.n[4] @ self.n[5])
        L2, u6, v = (u * u).sum(axis=-1), (u * m6).sum(axis=-1), np.cross(m6, u)
        across, g, h2 = (v * v).sum(axis=-1), L2 - self.A, self.B**2 + self.C**2
        w = np.sqrt((h2 - g * g).astype(complex))
        sheets, factor = [], across * across
        for sign in (1.0, -1.0):
            cosine, sine = (g * self.B - sign * w * self.C) / h2, (g * self.C + sign * w * self.B) / h2
            u0, m5 = _whole(self.u0, cosine, sine), _whole(self.m5, cosine, sine)
            z = (u0 * m5).sum(axis=-1)
            away = L2 - z * z
            rho = np.sqrt((1.0 - c * c) * away - (u6 - c * z) ** 2)
            flat = (z - c * u6)[:, None] * u + (c * L2 - z * u6)[:, None] * m6
            for side in (rho, -rho):
                sheets.append((u0, m5, z, away, flat + side[:, None] * v))
            factor = factor * away
        factor = factor.real
        row = int(np.argmax(np.abs(factor).reshape(_SHIFTS, -1).min(axis=1)))
        pick = slice(row * _SAMPLES, (row + 1) * _SAMPLES)
        u, L2, across = u[pick], L2[pick], across[pick]
        sheets = [[x[pick] for x in sheet] for sheet in sheets]
        found = []
        for a, b, k in equations:
            value = 1.0 / factor[pick]
            for u0, m5, z, away, axis5 in sheets:
                # R3 b by its parts along u, axis 5 and their cross product, times (S to axis 5)^2, and |n6 x u|^2 for axis 5
                first, second, third = u0 @ b, m5 @ b, np.cross(m5, u0) @ b
                f = (first - z * second) * (u @ a) * across + (L2 * second - z * first) * (axis5 @ a)
                value = value * (f + third * (np.cross(axis5, u) @ a) - k * away * across)
            found.append(value.real)
        return t[pick], found


_CORNERS = np.array([1.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])  # cosine and sine at 0, pi/2, pi


def _parts(values: Floats) -> tuple[Any, Any, Any]:
    """Constant, cosine and sine part of what is of first degree, from its values (3, ...) at 0, pi/2, pi."""
    middle = 0.5 * (values[0] + values[2])
    return middle, 0.5 * (values[0] - values[2]), values[1] - middle


def _whole(parts: tuple[Any, Any, Any], cosine: Any, sine: Any) -> Any:
    """Its values (m, 3) at cosines and sines (m,), complex ones too."""
    return parts[0] + np.multiply.outer(cosine, parts[1]) + np.multiply.outer(sine, parts[2])
