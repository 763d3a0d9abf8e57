# ruff: noqa: E501
"""[Humanoid] (33), (34): the principal root maps half of the outside of an ellipse into the circle; adding a margin to both semi-axes
does not keep it; the right root by the larger distance from the circle's centre."""

import numpy as np

if __name__ == "__main__":
    rng = np.random.default_rng(4)
    for a, b in ((2.0, 1.0), (2.0, 0.5), (1.2, 1.0)):
        q = (rng.uniform(-4, 4, (200_000, 2)) @ [1, 1j]).astype(complex)
        q = q[(q.real / a) ** 2 + (q.imag / b) ** 2 > 1.0]
        c2, R = a * a - b * b, 0.5 * (a + b)
        printed = 0.5 * (q + np.sqrt(q * q - c2))
        other = 0.25 * c2 / printed
        ours = np.where(np.abs(printed) >= np.abs(other), printed, other)
        share = (np.abs(printed) < R).mean()
        print(
            f"semi-axes {a}, {b}: {share:.1%} of the outside lands in the circle with the printed root, {(np.abs(ours) < R).mean():.0%} with ours"
        )
        assert 0.4 < share < 0.6 and (np.abs(ours) > R).all()
        assert np.abs(ours + 0.25 * c2 / ours - q).max() < 1e-12
    t = np.linspace(0, 2 * np.pi, 200_001)
    support = lambda a, b: np.hypot(a * np.cos(t), b * np.sin(t))
    short = 0.3 - (support(2.3, 0.8) - support(2.0, 0.5)).min()
    print(f"ellipse 2 x 0.5 with 0.3 added to both semi-axes: {short:.3f} m of the margin are missing")
    assert abs(short - 0.047) < 1e-3
    # VII (c), the aerofoil: the circle about mu through the trailing edge P = k; which of the two P of a point is the outer one?
    k, mu = 1.0, -0.12 + 0.12j
    radius = abs(k - mu)
    P = mu + radius * (1.0 + rng.exponential(0.3, 200_000)) * np.exp(2j * np.pi * rng.uniform(size=200_000))
    q = P + k * k / P
    root = np.sqrt(0.25 * q * q - k * k)
    both = np.stack([0.5 * q + root, 0.5 * q - root])
    by_size = np.take_along_axis(both, np.abs(both).argmax(0)[None], 0)[0]
    by_distance = np.take_along_axis(both, np.abs(both - mu).argmax(0)[None], 0)[0]
    wrong = (np.abs(by_size - P) > 1e-6).mean()
    print(f"aerofoil: the larger |P| is the wrong root for {wrong:.2%} of points outside, the larger |P - mu| for none")
    assert wrong > 0.001 and np.abs(by_distance - P).max() < 1e-6
    slopes = [abs(1.0 - (k / (mu + m * (k - mu))) ** 2) for m in (1.0, 1.01, 1.05)]
    print(
        f"at the trailing edge |dq/dP| = {slopes[0]:.0e}; on circles 1 % and 5 % larger {slopes[1]:.3f} and {slopes[2]:.3f}"
    )
    assert slopes[0] < 1e-12 and slopes[2] > 0.05
