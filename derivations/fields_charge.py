"""Charges of an obstacle ball in the harmonic field of R^n: the printed R / (R + D) against the least safe one.

[Rn] (3), [Humanoid] (23). Closed forms against brute force over the sphere, and how deep the printed charge lets a robot in.
"""

import numpy as np


def worst_pull(rho, p, count=100_001):
    """max over the unit sphere of the goal's inward pull, goal at distance rho from the centre."""
    c = np.cos(np.linspace(0.0, np.pi, count))
    return float(((1.0 - rho * c) / (1.0 + rho**2 - 2.0 * rho * c) ** (p / 2.0)).max())


def closed_form(rho, p):
    if p <= 2.0 or rho >= p - 1.0:
        return (1.0 + rho) ** (1.0 - p)
    return ((p - 2.0) / p) ** (p / 2.0) / ((p - 2.0) * (rho**2 - 1.0) ** ((p - 2.0) / 2.0))


def deepest(distance, charge, p, step=1e-3):
    """Least distance to the unit ball over gradient lines that start 0.002 off its surface, by fourth-order steps."""
    angle = np.linspace(0.01, 3.13, 60)
    x = np.stack([distance + 1.002 * np.cos(angle), 1.002 * np.sin(angle)], axis=-1)
    center, least = np.array([distance, 0.0]), np.full(len(x), np.inf)

    def direction(z):
        y, r = z - center, np.linalg.norm(z, axis=1, keepdims=True)
        e = -z / r**p + charge * y / np.linalg.norm(y, axis=1, keepdims=True) ** p
        return np.where(r > 2 * step, e / np.maximum(np.linalg.norm(e, axis=1, keepdims=True), 1e-300), 0.0)

    for _ in range(3000):
        a = direction(x)
        b = direction(x + 0.5 * step * a)
        c = direction(x + 0.5 * step * b)
        x = x + step / 6.0 * (a + 2 * b + 2 * c + direction(x + step * c))
        least = np.minimum(least, np.linalg.norm(x - center, axis=1) - 1.0)
    return float(least.min())


if __name__ == "__main__":
    worst = max(
        abs(closed_form(rho, p) / worst_pull(rho, p) - 1.0)
        for p in (1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
        for rho in np.concatenate([[1.01, 1.05, 1.2], np.linspace(1.5, 12.0, 15)])
    )
    print(f"least safe charge: closed form against brute force, largest relative difference {worst:.1e}")
    assert worst < 1e-7
    for n in (3, 4, 5, 6):
        rho = np.linspace(1.0005, 1.5, 20_000)
        unsafe = [r for r in rho if 1.0 / (1.0 + r) < closed_form(r, n)]
        print(
            f"R^{n}: R / (R + D) is unsafe for D < {max(unsafe):.4f} R"
            + (f"  (14/13 = {14 / 13:.4f})" if n == 3 else "")
        )
    assert abs(closed_form(14 / 13, 3) - 1 / (1 + 14 / 13)) < 1e-12
    for D in (1.01, 1.03, 1.06, 1.1, 1.5):
        row = [deepest(D, 1 / (1 + D), 3), deepest(D, 1 / (1 + D), 2)]
        print(
            f"R^3, D = {D}: least distance with the printed charge {row[0]:+.4f}, with the planar field {row[1]:+.4f}"
        )
        assert row[1] > -1e-6 and (row[0] < -1e-3) == (D < 1.07)
    # the goal inside the ball (D < R): the antipode is no longer the worst place, the planar charge R / (R + D) is not safe
    pull = worst_pull(0.5, 2.0)
    print(f"goal inside (D = R / 2): the pull is up to {pull:.3f}, the charge {1 / 1.5:.3f}")
    assert pull > 1.9
    # safety and progress together: the least safe charge may not exceed the largest one with progress, (1 + rho)^(1 - n)
    for n in (3, 4, 5, 6):
        rho = np.linspace(1.0005, 2.0, 5_000)
        both = (
            [r for r in np.linspace(1.5, 3.0, 301) if worst_pull(r, n, 2001) <= (1.0 + r) ** (1 - n) * (1.0 + 1e-6)]
            if n == 3
            else None
        )
        none = [r for r in rho if closed_form(r, n) >= 1.0]
        limit = np.sqrt(1.0 + (n - 2) * n ** (-n / (n - 2)))
        print(f"R^{n}: no charge below 1 is safe for D < {max(none):.4f} R ({limit:.4f})")
        assert abs(max(none) - limit) < 1e-3 and (both is None or abs(min(both) - 2.0) < 0.02)
