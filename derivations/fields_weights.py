"""The weights [Rn] (9): negative and discontinuous for k >= 3, and four balls among which they never let the robot through.

Also [Rn] (8): the gradient of a blended potential is not the blend of the gradients, and depends on the unit of length.
"""

import numpy as np

BOUNDARY = 0.1


def printed(d, delta=BOUNDARY):
    near = d <= d.min() + delta
    k = near.sum()
    return np.where(near, 1.0 / k + (d[near].mean() - d) / delta, 0.0)


def simplex(d, delta=BOUNDARY):
    z = np.sort(d) / delta
    tau = [(1.0 + z[: k + 1].sum()) / (k + 1) for k in range(len(z))]
    k = max(k for k in range(len(z)) if z[k] < tau[k])
    return np.maximum(tau[k] - d / delta, 0.0)


def four_balls():
    a, half = np.deg2rad([0, 120, 240]), np.sqrt(0.5)
    small = 1.715 * np.stack([np.full(3, -half), half * np.cos(a), half * np.sin(a)], axis=-1)
    return np.vstack([small, [50.8149, 0, 0]]), np.array([1.0, 1, 1, 50]), np.array([-1000.0, 0, 0])


def field(x, centers, radii, goal, weights):
    y, away = x - centers, x - goal
    r = np.linalg.norm(y, axis=1)
    q = radii / (radii + np.linalg.norm(centers - goal, axis=1))
    mu = weights(r - radii)
    return mu, -mu.sum() * away / (away @ away) + (mu * q / r**2) @ y


if __name__ == "__main__":
    for k in (3, 4):
        d = np.r_[np.zeros(k - 1), BOUNDARY]
        inside, outside = printed(d), printed(d + np.r_[np.zeros(k - 1), 1e-12])
        jump = abs(inside[0] - outside[0])
        print(
            f"k = {k}, one zone on the border of the layer: weights {inside.round(4)}, just outside {outside.round(4)}"
        )
        assert np.isclose(inside[-1], 2 / k - 1) and np.isclose(jump, (k - 2) / (k * (k - 1)))

    centers, radii, goal = four_balls()
    gaps = np.linalg.norm(centers[:, None] - centers, axis=-1) - radii[:, None] - radii + 1e9 * np.eye(4)
    print(
        f"four balls: least gap {gaps.min():.4f} > boundary {BOUNDARY}, goal outside all: every assumption of [Rn] 3.2 holds"
    )
    assert gaps.min() > BOUNDARY
    for name, weights in (("printed", printed), ("simplex", simplex)):
        mu, E = field(np.zeros(3), centers, radii, goal, weights)
        print(f"  {name}: weights {mu.round(5)}, (x - g) . E = {(0 - goal) @ E:+.4f}")
        assert ((0 - goal) @ E > 0) == (name == "printed")
        x, step = np.array([0.3, 1e-3, 5e-4]), 2e-3
        for _ in range(5000):
            e = field(x, centers, radii, goal, weights)[1]
            x = x + step * e / np.linalg.norm(e)
        print(f"  {name}: after 10 m of steps from (0.3, 0, 0) the robot is at {x.round(2)}")
        assert (x[0] > -0.5) == (name == "printed")

    # (8): weights of two zones, potentials in metres and in centimetres
    centers, radii, x = np.array([[2.0, 0.9], [2.2, -1.0]]), np.array([0.5, 0.6]), np.array([2.1, -0.04])
    turned = []
    for unit in (1.0, 100.0):
        c, R, z, delta, h = unit * centers, unit * radii, unit * x, 0.3 * unit, 1e-5 * unit
        q = R / (R + np.linalg.norm(c, axis=1))

        def potential(p, c=c, R=R, q=q, delta=delta):
            r = np.linalg.norm(p - c, axis=1)
            return np.log(np.linalg.norm(p)) - (printed(r - R, delta) * q) @ np.log(r)

        g = np.array([potential(z + h * e) - potential(z - h * e) for e in np.eye(2)])
        turned.append(-g / np.linalg.norm(g))
    print(
        f"gradient of the blended potential: direction {turned[0].round(3)} in metres, {turned[1].round(3)} in centimetres"
    )
    assert np.linalg.norm(turned[0] - turned[1]) > 0.05
