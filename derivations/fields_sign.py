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
