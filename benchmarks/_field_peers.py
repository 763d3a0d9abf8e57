"""Peers of the harmonic field in plain numpy, written from their papers' formulas: each is f(x) -> velocity among stars.

- navigation: Rimon and Koditschek's function for balls, the direction of -grad: -k grad ln |x - g|^2 + sum grad ln beta_i;
- modulation: Huber, Billard and Slotine's dynamics modulation, eigenvalues 1 -/+ 1/Gamma about the star's centre, directions
  averaged with weights 1 / (Gamma_i - 1);
- cbfpy: the package of that name, if installed (`pip install cbfpy`): its CBF-QP for x' = u, with the same barriers as `cbf`;
- cbf: the quadratic programme min |u - u0|^2 with grad b_i . u >= -alpha b_i, b_i = |y| / r_i - 1, by Hildreth's dual ascent.
"""

from __future__ import annotations

import os
from functools import cache
from time import perf_counter

import numpy as np

from horosphere.maps import RoundHull, Star


def outline(stars: list[Star], x):
    """u, |y|, r_i and the gradient of |y| / r_i(u) for every star, stacked."""
    y = x - np.array([star.center for star in stars])
    r = np.linalg.norm(y, axis=1)
    u = y / r[:, None]
    if all(isinstance(star, RoundHull) for star in stars):  # balls, at numpy's speed
        edge = np.array([star.far for star in stars])
        return u, r, edge, u / edge[:, None]
    pairs = [star.radial(way[None]) for star, way in zip(stars, u)]
    edge = np.array([pair[0][0] for pair in pairs])
    slope = np.array([pair[1][0] for pair in pairs])
    return u, r, edge, u / edge[:, None] - slope / edge[:, None] ** 2


def navigation(goal, stars, k=30.0):
    centers, radii = np.array([s.center for s in stars]), np.array([s.outer for s in stars])

    def velocity(x):
        y = x - centers
        beta = (y**2).sum(1) - radii**2
        return -2.0 * k * (x - goal) / ((x - goal) ** 2).sum() + (2.0 * y / beta[:, None]).sum(0)

    return velocity


def modulation(goal, stars):
    def velocity(x):
        f = goal - x
        size = np.linalg.norm(f)
        f0 = f / max(size, 1e-12)
        u, r, edge, normal = outline(stars, x)
        gamma = np.maximum(r / edge, 1.0 + 1e-9)
        weight = 1.0 / (gamma - 1.0)
        weight /= weight.sum()
        turn, speed = np.zeros_like(x), 0.0
        for i in range(len(stars)):
            along = (f @ normal[i]) / (u[i] @ normal[i])
            across = f - along * u[i]
            radial = 1.0 - 1.0 / gamma[i] if along < 0.0 else 1.0
            v = radial * along * u[i] + (1.0 + 1.0 / gamma[i]) * across
            length = np.linalg.norm(v)
            speed += weight[i] * length
            c = np.clip(v @ f0 / max(length, 1e-300), -1.0, 1.0)
            side = v / max(length, 1e-300) - c * f0
            norm = np.linalg.norm(side)
            if norm > 1e-12:
                turn += weight[i] * np.arccos(c) * side / norm
        angle = np.linalg.norm(turn)
        return speed * (f0 if angle < 1e-14 else np.cos(angle) * f0 + np.sin(angle) * turn / angle)

    return velocity


def cbf(goal, stars, alpha=1.0):
    def velocity(x):
        f = goal - x
        u = f / max(np.linalg.norm(f), 1e-12)
        _, r, edge, normal = outline(stars, x)
        size = np.linalg.norm(normal, axis=1)
        n, bound = normal / size[:, None], -alpha * (r / edge - 1.0) / size
        dual = np.zeros(len(stars))
        for _ in range(500):
            change = 0.0
            for i in range(len(stars)):
                step = max(-dual[i], bound[i] - u @ n[i])
                dual[i] += step
                u = u + step * n[i]
                change = max(change, abs(step))
            if change < 1e-9:
                break
        return u

    return velocity


def cbfpy(goal, stars, alpha=1.0):
    """The safety filter of cbfpy around the unit velocity to the goal, barriers |x - c_i| / r_i(u) - 1 linearised at x by us.

    Star radii are numpy functions, so the linear part is passed in: h(z) = h_i + slope_i . (z - x). Compiled once a number of
    obstacles and dimension; None if the package is not there.
    """
    filtered = _cbfpy_filter(len(goal), len(stars), alpha)

    def velocity(x):
        f = goal - x
        u = f / max(np.linalg.norm(f), 1e-12)
        _, r, edge, normal = outline(stars, x)
        return np.asarray(
            filtered(x, u, np.concatenate([normal, (r / edge - 1.0)[:, None], np.tile(x, (len(r), 1))], axis=1))
        )

    return velocity


@cache
def _cbfpy_filter(n, count, alpha):
    os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")  # as its manual recommends
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    import jax

    jax.config.update("jax_enable_x64", True)
    import jax.numpy as jnp
    from cbfpy import CBF, CBFConfig

    class Stars(CBFConfig):
        def __init__(self):
            super().__init__(n=n, m=n, init_args=(np.ones((count, 2 * n + 1)),), relax_qp=False)

        def f(self, z, rows):
            return jnp.zeros(n)

        def g(self, z, rows):
            return jnp.eye(n)

        def h_1(self, z, rows):
            return rows[:, n] + jnp.sum(rows[:, :n] * (z - rows[:, n + 1 :]), axis=1)

        def alpha(self, h, rows):
            return alpha * h

    return jax.jit(CBF.from_config(Stars()).safety_filter)


def simulate(velocity, start, goal, stars, step=0.01, most=6000, unit=True):
    """Explicit steps of the normalised velocity; (reached, touched, length, clearance, seconds an evaluation).

    Given up when the distance to the goal was not lowered for 1,500 steps.
    """
    x, points, best, since, spent = start.copy(), [start.copy()], np.inf, 0, 0.0
    reached = False
    for _ in range(most):
        away = np.linalg.norm(x - goal)
        best, since = (away, 0) if away < best - 1e-6 else (best, since + 1)
        reached = bool(away <= step)
        if reached or since > 1500:
            break
        begin = perf_counter()
        v = velocity(x)
        spent += perf_counter() - begin
        size = np.linalg.norm(v)
        if not size >= 1e-9:
            break
        x = x + min(step, away) * (1.0 if unit else min(size, 1.0)) * v / size
        points.append(x)
    track = np.array(points)
    length = float(np.linalg.norm(np.diff(track, axis=0), axis=1).sum()) + float(np.linalg.norm(x - goal)) * reached
    least = min(float(star.level(track).min()) for star in stars)
    if least > 0.0:
        least = min(float(star.distance(track).min()) for star in stars)
    return reached, least < 0.0, length, least, spent / max(len(points) - 1, 1)
