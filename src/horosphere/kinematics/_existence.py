"""Where on the circle of its redundancy a branch begins and ends to exist: roots of trigonometric polynomials."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..numeric import wrap_angle

Floats = NDArray[np.float64]


class Trig:
    """A real trigonometric polynomial: the coefficients c[-d..d] of exp(i k t), as a plain array of length 2 d + 1."""

    def __init__(self, c: Any) -> None:
        self.c = np.asarray(c, dtype=np.complex128)

    @staticmethod
    def first(constant: float, cosine: float, sine: float) -> Trig:
        """constant + cosine cos t + sine sin t."""
        return Trig([0.5 * (cosine + 1j * sine), constant, 0.5 * (cosine - 1j * sine)])

    @staticmethod
    def sampled(values: Floats) -> Trig:
        """Of first degree, from its values at 0, pi/2 and pi."""
        middle = 0.5 * (values[0] + values[2])
        return Trig.first(middle, 0.5 * (values[0] - values[2]), values[1] - middle)

    def __add__(self, other: Trig | float) -> Trig:
        a, b = self.c, other.c if isinstance(other, Trig) else np.array([other], complex)
        size = max(len(a), len(b))
        widen = lambda x: np.pad(x, (size - len(x)) // 2)
        return Trig(widen(a) + widen(b))

    def __mul__(self, other: Trig | float) -> Trig:
        return Trig(np.convolve(self.c, other.c) if isinstance(other, Trig) else self.c * other)

    __rmul__ = __mul__

    def __sub__(self, other: Trig | float) -> Trig:
        return self + -1.0 * other

    def roots(self) -> Floats:
        """Angles in (-pi, pi] where it is zero, and those of roots nearly on the circle (a double root splits off it)."""
        c = self.c[::-1]
        size = np.abs(c).max(initial=0.0)
        if size == 0.0:
            return np.zeros(0)
        z = np.roots(np.where(np.abs(c) < 1e-15 * size, 0.0, c))
        return np.asarray(np.angle(z[np.abs(np.abs(z) - 1.0) < 1e-3]), dtype=np.float64)


def q7_candidates(made: Any, motor: Floats) -> Floats:
    """Angles of the last joint at which a sew7 branch can begin or end to exist, sorted, with -pi and pi. Our derivation.

    With w the wrist and u = S - w, both u.u and u.n6 are of first degree in t = q7, and from u.u = A + B cos q4 + C sin q4 the
    component of u along axis 5 is z = a(t) +- b w(t), w^2 = B^2 + C^2 - (u.u - A)^2. A wrist exists while
    (1 - c^2)(u.u - z^2) >= (u.n6 - c z)^2, c = n5.n6: its ends are zeros of P +- Q w, hence of P^2 - Q^2 w^2, of degree four.
    """
    chain = made.structure.screws
    n, p, (S, W) = chain.axes, chain.points, made.structure.special
    T = _chain_pose(made, motor)
    R, t = T[:3, :3], T[:3, 3]
    length2, along6 = np.zeros(3), np.zeros(3)
    for k, q7 in enumerate((0.0, 0.5 * np.pi, np.pi)):
        back = _turn(n[6], -q7)
        u = S - (R @ (back @ (W - p[6]) + p[6]) + t)
        length2[k], along6[k] = u @ u, u @ (R @ back @ n[5])
    elbow2, along5 = np.zeros(3), np.zeros(3)
    for k, q4 in enumerate((0.0, 0.5 * np.pi, np.pi)):
        R4 = _turn(n[3], q4)
        u = S - (R4 @ (W - p[3]) + p[3])
        elbow2[k], along5[k] = u @ u, u @ (R4 @ n[4])
    A, z0 = 0.5 * (elbow2[0] + elbow2[2]), 0.5 * (along5[0] + along5[2])
    B, C = 0.5 * (elbow2[0] - elbow2[2]), elbow2[1] - A
    z1, z2 = 0.5 * (along5[0] - along5[2]), along5[1] - z0
    h2, c = B * B + C * C, float(n[4] @ n[5])
    L2, u6 = Trig.sampled(length2), Trig.sampled(along6)
    g = L2 - A
    w2 = Trig([h2]) - g * g
    a, b = z0 + 0.0, (z2 * B - z1 * C) / h2
    z = g * ((z1 * B + z2 * C) / h2) + a
    rest = u6 - c * z
    P = (1.0 - c * c) * (L2 - z * z - (b * b) * w2) - rest * rest - (c * c * b * b) * w2
    Q = (2.0 * b) * (c * rest - (1.0 - c * c) * z)
    found = [P * P - Q * Q * w2, w2]
    j = 0 if made.structure.is_reversed else 6
    q4 = 3
    for m in made.limits[:, q4]:
        if np.isfinite(m):
            m4 = -m if made.structure.is_reversed else m
            found.append(g - (B * np.cos(m4) + C * np.sin(m4)))
    angles = np.concatenate([f.roots() for f in found])
    angles = -angles if made.structure.is_reversed else angles
    ends = made.limits[:, j]
    return sorted_ends(np.concatenate([angles, ends[np.isfinite(ends)]]))


def phi_candidates(arm: Floats, circle: Floats) -> Floats:
    """Angles phi at which the elbow of the 5-DOF arm begins or ends to exist: the wrist's circle meets a torus.

    arm: a, h, d1, d2, d3. circle (3, 3): the wrist at phi = 0, pi/2 and pi. The wrist at distance D
    from the shoulder's circle (radius a at height h): (s + a^2 - D^2)^2 = 4 a^2 (x^2 + z^2), s = |p2 - (0, h, 0)|^2.
    """
    a, h, d1, d2, _ = arm
    x, y, z = (Trig.sampled(circle[:, k]) for k in range(3))
    level = y - h
    s, flat = x * x + level * level + z * z, x * x + z * z
    found = []
    for D in (d1 + d2, abs(d1 - d2)):
        side = s + (a * a - D * D)
        found.append((side * side - (4.0 * a * a) * flat).roots())
    return sorted_ends(np.concatenate(found))


def strict_candidates(arm: Floats, circle: Floats, across: Floats) -> Floats | None:
    """Angles phi at which the whole gripper of the 5-DOF arm can be parallel to its plane, and the ends of its reach; None: all.

    arm: a, h, d1, d2, d3. circle, across (3, 3): the wrist p and m = n x g at phi = 0, pi/2 and pi. Asked is forearm . m = 0. In the
    arm plane let R = sqrt(T) be the wrist's distance from the torso axis, k its height over the shoulder, (X / R, Y) the components
    of m, and n0 + n1 R = |wrist - shoulder|^2 + d2^2 - d1^2. The triangle of the links gives, for both elbows,
    (n0 + n1 R)^2 (X^2 + Y^2 T) = 4 d2^2 (Y T - k X +- a Y R)^2, which is P +- Q R = 0 for shoulders in front and behind: P^2 - Q^2 T
    is of degree 12 and holds the roots of all four. Our derivation.
    """
    size = arm[2] + arm[3] + arm[4]
    a, h, d1, d2, _ = arm / size
    p = circle / size
    x, z, k = Trig.sampled(p[:, 0]), Trig.sampled(p[:, 2]), Trig.sampled(p[:, 1] - h)
    m = [Trig.sampled(across[:, j]) for j in range(3)]
    T, X, Y = x * x + z * z, m[0] * x + m[2] * z, m[1]
    flat = p - [0.0, h, 0.0]
    n0 = Trig.sampled((flat * flat).sum(axis=-1) + a * a + d2 * d2 - d1 * d1)  # |p|^2 is of first degree on the circle
    n1, b0, b1 = -2.0 * a, Y * T - k * X, -a * Y
    G = X * X + Y * Y * T
    P = (n0 * n0 + n1 * n1 * T) * G - (4.0 * d2 * d2) * (b0 * b0 + b1 * b1 * T)
    Q = (2.0 * n1) * n0 * G - (8.0 * d2 * d2) * (b0 * b1)
    if max(np.abs(P.c).max(), np.abs(Q.c).max()) < 1e-14:
        return None
    one = P if np.abs(Q.c).max() < 1e-12 * np.abs(P.c).max() else P * P - Q * Q * T
    reach = phi_candidates(arm, circle)
    return sorted_ends(np.concatenate([one.roots(), T.roots(), reach[1:-1]]))


def sorted_ends(angles: Floats) -> Floats:
    """Sorted in [-pi, pi], both ends included, repeated ones once."""
    x = wrap_angle(angles)
    x = np.sort(np.concatenate([[-np.pi], x, [np.pi]]))
    return x[np.concatenate([[True], np.diff(x) > 1e-13])]


def _chain_pose(made: Any, motor: Floats) -> Floats:
    """(4, 4) of exp(S1 q1) ... exp(Sn qn) of the chain as it is solved."""
    from ._screw_kernels import load_pose

    R, t = load_pose(motor[None].copy(), 0, made.arm, made.joints)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.array(R).reshape(3, 3), t
    return T


def _turn(axis: Floats, angle: float) -> Floats:
    from ._screws import axis_rotation

    return axis_rotation(axis, angle)
