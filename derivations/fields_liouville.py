# ruff: noqa: E501
"""[Humanoid] VIII: the conformal mappings generalise to higher dimensions. Liouville: from n = 3 on all are Moebius maps.

Infinitesimally: polynomial vector fields v of degree <= d with dv + dv^T = (2/n) div v I. In the plane their number grows
with d without end (the holomorphic functions); from n = 3 on it stays (n+1)(n+2)/2, the dimension of the Moebius group.
These maps carry balls to balls: no ellipsoid's outside becomes a ball's outside.
"""

from itertools import product

import numpy as np


def conformal_fields(n, degree):
    """Dimension of the solution space, by the rank of the equations on the coefficients (small integers)."""
    powers = [p for p in product(range(degree + 1), repeat=n) if sum(p) <= degree]
    place = {p: k for k, p in enumerate(powers)}
    rows = []

    def derivative(p, j):
        return (p[j], (*p[:j], p[j] - 1, *p[j + 1 :])) if p[j] else None

    for i in range(n):
        for j in range(i, n):
            for target in powers:
                row = np.zeros((n, len(powers)))
                for p in powers:
                    for a, b in ((i, j), (j, i)):
                        d = derivative(p, b)
                        if d and d[1] == target:
                            row[a, place[p]] += d[0]
                    if i == j:
                        for k in range(n):
                            d = derivative(p, k)
                            if d and d[1] == target:
                                row[k, place[p]] -= 2.0 / n * d[0]
                if row.any():
                    rows.append(row.ravel())
    return n * len(powers) - np.linalg.matrix_rank(np.array(rows))


if __name__ == "__main__":
    for n, degrees in ((2, (1, 2, 3, 4, 5)), (3, (1, 2, 3, 4)), (4, (1, 2, 3))):
        found = [int(conformal_fields(n, d)) for d in degrees]
        print(f"R^{n}: conformal fields of degree at most {degrees}: {found}")
        expected = (
            [2 * (d + 1) for d in degrees]
            if n == 2
            else [1 + n + n * (n - 1) // 2] + [(n + 1) * (n + 2) // 2] * (len(degrees) - 1)
        )
        assert found == expected
    rng = np.random.default_rng(0)
    u = rng.standard_normal((200, 3))
    x = rng.normal(0, 1, 3) + 0.7 * u / np.linalg.norm(u, axis=1, keepdims=True)
    y = x / (x**2).sum(1, keepdims=True)  # inversion, of which with similarities all Moebius maps are made
    fit = np.linalg.lstsq(np.c_[2 * y, np.ones(len(y))], (y**2).sum(1), rcond=None)
    print(
        f"the image of a sphere under inversion is a sphere to {np.abs(np.c_[2 * y, np.ones(len(y))] @ fit[0] - (y**2).sum(1)).max():.1e}"
    )
