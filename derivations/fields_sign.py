"""[Rn] (6): with e1, e2 of (5), E = -grad(U_G + U_S) is -e1 / |x - g| + q e2 / |x - S|; both signs are printed the other way."""

import numpy as np

if __name__ == "__main__":
    rng = np.random.default_rng(0)
    for n in (2, 3, 5):
        x, g, S, q, h = *rng.normal(0, 2, (3, n)), 0.3, 1e-6

        def potential(z, g=g, S=S, q=q):
            return np.log(np.linalg.norm(z - g)) + q * np.log(1.0 / np.linalg.norm(z - S))

        descent = -np.array([potential(x + h * e) - potential(x - h * e) for e in np.eye(n)]) / (2 * h)
        e1, e2 = (x - g) / np.linalg.norm(x - g), (x - S) / np.linalg.norm(x - S)
        printed = e1 / np.linalg.norm(x - g) - q * e2 / np.linalg.norm(x - S)
        print(
            f"R^{n}: |(6) - E| = {np.linalg.norm(printed - descent):.3f}, |(6) + E| = {np.linalg.norm(printed + descent):.1e}"
        )
        assert np.linalg.norm(printed + descent) < 1e-8
    # [Humanoid] (21) for n = 2 prints q ln(q / r): for the goal, q = -1, the logarithm of a negative number
    with np.errstate(invalid="ignore"):
        printed = -1.0 * np.log(-1.0 / 2.0)
    print(f"[Humanoid] (21), q = -1, r = 2: printed {printed}, q ln(1 / r) = {-np.log(0.5):.3f}")
    assert np.isnan(printed)
    # no operation plane: S, x and g on one line, and a motion in R^5 that stays in the plane of its three points
    g, S, x = np.zeros(5), 2.0 * np.eye(5)[0], 5.0 * np.eye(5)[0] + 0.3 * np.eye(5)[3]
    for _ in range(2000):
        y = x - S
        e = -(x - g) / (x @ x) + (y / (y @ y)) / 3.0
        x = x + 0.002 * e / np.linalg.norm(e)
    print(f"R^5: after 4 m off the plane of x, S, g by {np.abs(x[[1, 2, 4]]).max():.1e} m, no plane constructed")
    assert np.abs(x[[1, 2, 4]]).max() < 1e-12
