"""The strict reading of the 5-DOF arm finds every root phi: plane trigonometry on a grid of 1e-5 rad, near and double roots."""

from functools import partial

import numpy as np
import pytest
from plain_fk import chain_pose, humanoid

from horosphere.kinematics import GripperOnPlane, inverse
from horosphere.robots import humanoid_arm

GEOMETRIES = {
    "offset": (0.2, 0.12, 0.35, 0.30, 0.15),
    "shoulder on the axis": (0.1, 0.1, 0.35, 0.30, 0.15),
    "equal links": (0.1, 0.06, 0.3, 0.3, 0.2),
    "nearly on the axis": (0.1, np.sqrt(0.01 - 1e-12), 0.35, 0.25, 0.1),
}


def hinge(lengths, point, normal, phi):
    """(4, m) forearm . (n x g) of (front, back) x (elbow) by plane trigonometry in the arm plane; NaN out of reach."""
    d0, h, d1, d2, d3 = lengths
    a = np.sqrt(d0 * d0 - h * h)
    n = normal / np.linalg.norm(normal)
    radial = point * [1, 0, 1]
    g0 = radial - (radial @ n) * n
    g0 /= np.linalg.norm(g0)
    g = np.cos(phi)[:, None] * g0 + np.sin(phi)[:, None] * np.cross(n, g0)
    p2, across = point - d3 * g, np.cross(n, g)
    R = np.hypot(p2[:, 0], p2[:, 2])
    u = np.stack([p2[:, 0] / R, 0 * R, p2[:, 2] / R], axis=1)
    found = []
    for side in (1.0, -1.0):
        x, y = R - side * a, p2[:, 1] - h
        D = np.hypot(x, y)
        with np.errstate(invalid="ignore"):
            c = (D * D + d2 * d2 - d1 * d1) / (2.0 * D * d2)
            s = np.sqrt(1.0 - c * c)
        for way in (1.0, -1.0):
            forearm = ((c * x - way * s * y) / D)[:, None] * u
            forearm[:, 1] += (way * s * x + c * y) / D
            found.append((forearm * across).sum(axis=1))
    return np.array(found)


def target(rng, lengths):
    return rng.uniform(-1, 1, 3) * (lengths[2] + lengths[3]), rng.normal(size=3)


def solved(lengths, point, normal):
    return inverse(humanoid_arm(*lengths), GripperOnPlane(point, normal), strict=True)


@pytest.mark.parametrize("count", [2, pytest.param(60, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", GEOMETRIES)
def test_no_root_of_a_dense_scan_is_missed(name, count):
    lengths, rng = GEOMETRIES[name], np.random.default_rng(len(name))
    step = 1e-5
    phi = np.arange(-np.pi - step, np.pi, step)
    for _ in range(count):
        point, normal = target(rng, lengths)
        s = solved(lengths, point, normal)
        f = hinge(lengths, point, normal, phi)
        with np.errstate(invalid="ignore"):
            cells = np.argwhere((f[:, 1:] * f[:, :-1] <= 0.0) & (np.abs(f[:, 1:] - f[:, :-1]) < 0.1))
        free = s.free[s.valid][::2]  # flips share their root
        assert len(free) == len(cells)
        middle = phi[cells[:, 1]] + 0.5 * step
        off = np.abs(np.angle(np.exp(1j * (np.sort(middle) - np.sort(free)))))
        assert off.max(initial=0.0) < step
        assert s.residual[s.valid].max(initial=0.0) < 1e-9


def extremum(f, at):
    """(place, value, curvature) of the extremum of f nearest to `at`, by Newton steps on differences."""
    d = 1e-4
    for _ in range(40):
        low, here, high = f(np.array([at - d, at, at + d]))
        bend = (low - 2.0 * here + high) / d**2
        move = np.clip(-(high - low) / (2.0 * d) / bend, -0.02, 0.02)
        at += move
        if abs(move) < 1e-9:
            break
    return at, float(f(np.array([at]))[0]), bend


def along(lengths, point, way, normal, kind):
    """f of one branch as a function of phi, as a function of x: of the target point + x way."""
    return lambda x: lambda at: hinge(lengths, point + x * way, normal, at)[kind]


def family(rng, lengths):
    """A line of targets, a branch and a place at which the target 0 has an extremum of f near zero; f as a function of the target."""
    phi = np.linspace(-np.pi, np.pi, 4001)
    while True:
        point, normal = target(rng, lengths)
        way = rng.normal(size=3)
        f = hinge(lengths, point, normal, phi)
        with np.errstate(invalid="ignore"):
            turns = np.argwhere(
                ((f[:, 1:-1] - f[:, :-2]) * (f[:, 2:] - f[:, 1:-1]) < 0.0) & (np.abs(f[:, 1:-1]) < 0.03)
            )
        for kind, k in turns:
            of = along(lengths, point, way, normal, kind)
            if np.isfinite(f[kind, max(k - 300, 0) : k + 300]).all():
                return point, normal, way, of, phi[k + 1]


@pytest.mark.parametrize("seed", range(6))
def test_near_roots_are_told_apart_and_double_roots_are_found(seed):
    lengths, rng = list(GEOMETRIES.values())[seed % 3], np.random.default_rng(seed)
    done = 0
    for _ in range(60):
        point, normal, way, of, start = family(rng, lengths)

        def where_value_is(goal, of=of, start=start):
            """The target x at which the extremum has this value: secant steps."""
            (x0, x1), at = (0.0, 1e-4), start
            _, v0, bend = extremum(of(x0), at)
            for _ in range(30):
                at, v1, bend = extremum(of(x1), at)
                if v1 == v0 or not np.isfinite(v1) or abs(x1) > 0.2:
                    return None
                x0, v0, x1 = x1, v1, x1 - (v1 - goal) * (x1 - x0) / (v1 - v0)
                if abs(v0 - goal) < 1e-15:
                    return x0, at, bend
            return (x0, at, bend) if abs(v0 - goal) < 1e-13 else None

        flat = where_value_is(0.0)
        if (
            flat is None
            or abs(flat[2]) < 0.05
            or not np.isfinite(of(flat[0])(flat[1] + np.linspace(-0.1, 0.1, 50))).all()
        ):
            continue
        near = partial(roots_near, lengths, point, way, normal)
        assert len(near(*flat[:2])) in (1, 2), "a double root is lost"
        for apart in (3e-3, 1e-4, 3e-6):
            found = where_value_is(-flat[2] * apart**2 / 8.0)
            if found is None:
                continue
            pair = near(*found[:2])
            assert len(pair) == 2 and abs(pair[1] - pair[0] - apart) < 0.1 * apart + 1e-7, (apart, pair)
            done += 1
        none = where_value_is(flat[2] * 1e-6)
        assert none is None or len(near(*none[:2])) == 0
        if done >= 6:
            break
    assert done >= 3


def roots_near(lengths, point, way, normal, x, at):
    """Roots of the target point + x way within 5e-3 of `at`, of the branch that has most of them."""
    s = solved(lengths, point + x * way, normal)
    blocks, free = s.valid.reshape(-1, 8)[:, ::2], s.free.reshape(-1, 8)[:, ::2]
    off = np.angle(np.exp(1j * (free - at)))
    return max((np.sort(off[:, k][blocks[:, k] & (np.abs(off[:, k]) < 5e-3)]) for k in range(4)), key=len)


def test_every_phi_where_the_wrist_circles_the_torso_axis():
    lengths = GEOMETRIES["offset"]
    s = solved(lengths, [0.0, 0.5, 0.0], [0, 1, 0])
    assert s.flags["phi_free"] and s.valid.all() and s.residual.max() < 1e-12
    M = chain_pose(*humanoid(*lengths), s.q)
    assert np.abs(M[:, :3, 3] - [0.0, 0.5, 0.0]).max() < 1e-12 and np.abs(M[:, 1, 1:3]).max() < 1e-12
    batch = inverse(humanoid_arm(*lengths), GripperOnPlane([[0, 0.5, 0], [0.4, 0.2, 0.1]], [0, 1, 0]), strict=True)
    assert batch.flags["phi_free"].tolist() == [True, False] and batch.solved.all()


def test_a_batch_of_none():
    s = inverse(humanoid_arm(), GripperOnPlane(np.zeros((0, 3)), [0, 0, 1]), strict=True)
    assert s.q.shape == (0, 8, 5) and s.valid.shape == s.residual.shape == (0, 8) and s.flags["phi_free"].shape == (0,)
