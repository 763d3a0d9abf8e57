"""The three-joint arm of [Rn], section 4: obstacles of configuration space from the geometry, one ellipsoid around each.

    python derivations/fields_revolute_arm.py             prints the obstacles as they stand in the scene rn-fig6-revolute-arm
    python derivations/fields_revolute_arm.py picture DIR the motion in configuration space and nine snapshots of the arm

The paper gives the start, the goal and the joints (base, upper arm, lower arm; all zero: straight up) but no lengths. Ours:
shoulder 0.6 m above the floor, upper and lower arm 0.5 m, links of radius 0.05 m, two upright cylinders.
"""

from __future__ import annotations

import sys

import numpy as np

SHOULDER, UPPER, LOWER, THICK = 0.6, 0.5, 0.5, 0.05
BLOCKS = ((0.48, -0.7, 0.08, 0.24), (0.48, 0.75, 0.08, 0.26))  # distance and bearing from the base, radius, height
LIMITS = np.array([[-2.8, 2.0], [-2.1, 2.1], [-2.8, 2.8]])
START, GOAL = np.array([-np.pi / 2, np.pi / 2, np.pi / 2]), np.array([np.pi / 2, np.pi / 2, np.pi / 2])


def joints(q):
    """Shoulder, elbow, tip (..., 3, 3) for angles q (..., 3): bearing, tilt of the upper arm, bend of the elbow."""
    q = np.asarray(q, float)
    out = np.stack([np.cos(q[..., 0]), np.sin(q[..., 0])], axis=-1)
    shoulder = np.broadcast_to([0.0, 0.0, SHOULDER], (*q.shape[:-1], 3))

    def along(tilt):
        return np.concatenate([np.sin(tilt)[..., None] * out, np.cos(tilt)[..., None]], axis=-1)

    elbow = shoulder + UPPER * along(q[..., 1])
    return np.stack([shoulder, elbow, elbow + LOWER * along(q[..., 1] + q[..., 2])], axis=-2)


def clearance(q, samples=41):
    """Distance (...) between the arm and the blocks, metres, by samples on the links (at most 7 mm off)."""
    p = joints(q)
    t = np.linspace(0.0, 1.0, samples)[:, None]
    least = np.full(p.shape[:-2], np.inf)
    for a, b in ((0, 1), (1, 2)):
        x = p[..., None, a, :] + t * (p[..., None, b, :] - p[..., None, a, :])
        for away, bearing, radius, height in BLOCKS:
            side = np.hypot(x[..., 0] - away * np.cos(bearing), x[..., 1] - away * np.sin(bearing)) - radius
            above = x[..., 2] - height
            d = np.where((side > 0) & (above > 0), np.hypot(side, above), np.maximum(side, above))
            least = np.minimum(least, d.min(axis=-1) - THICK)
    return least


def obstacles(spacing=0.06):
    """The connected parts of the blocked configurations on a grid: a list of points (m, 3)."""
    from scipy.ndimage import label

    axes = [np.arange(low, high + spacing, spacing) for low, high in LIMITS]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    blocked = np.concatenate([clearance(part) < 0.012 for part in np.array_split(grid, 12)])
    parts, count = label(blocked)
    return [grid[parts == k + 1] for k in range(count)], spacing


def ellipsoid(points, tolerance=1e-3):
    """Centre, semi-axes and axes (columns) of the least-volume ellipsoid around the points, by Khachiyan's algorithm."""
    n = points.shape[1]
    lifted = np.vstack([points.T, np.ones(len(points))])
    weight = np.full(len(points), 1.0 / len(points))
    while True:
        X = lifted * weight @ lifted.T
        M = np.einsum("ij,ij->j", lifted, np.linalg.solve(X, lifted))
        k = int(np.argmax(M))
        step = (M[k] - n - 1.0) / ((n + 1.0) * (M[k] - 1.0))
        if M[k] - n - 1.0 < tolerance * n:
            break
        weight *= 1.0 - step
        weight[k] += step
    center = points.T @ weight
    scatter = (points.T * weight) @ points - np.outer(center, center)
    values, axes = np.linalg.eigh(scatter * n)
    y = (points - center) @ axes / np.sqrt(values)
    return center, np.sqrt(values) * np.sqrt((y**2).sum(1).max()), axes * np.sign(np.linalg.det(axes))


def quaternion(R):
    """wxyz of a rotation matrix, by the eigenvector of the largest eigenvalue."""
    K = np.array(
        [
            [R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0],
            [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
            [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], 0],
            [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)],
        ]
    )
    q = np.linalg.eigh(K / 3.0)[1][:, -1]
    return q[[3, 0, 1, 2]] * np.sign(q[3])


def zones():
    """One ellipsoid (centre, semi-axes, rotation) around every part; half a cell is added for what lies between grid points."""
    parts, spacing = obstacles()
    half = 0.5 * spacing * np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    out = []
    for part in parts:
        hull = (part[:, None] + half).reshape(-1, 3)
        out.append(ellipsoid(np.unique(np.round(hull, 6), axis=0)))
    return out


def picture(folder):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from horosphere.fields import HarmonicField
    from horosphere.maps import ellipsoid as star

    bodies = [star(c, a, R) for c, a, R in zones()]
    path = HarmonicField(GOAL, bodies).trace(START, step=0.02)
    print(path, "least clearance of the arm", clearance(path.points).min())
    figure = plt.figure(figsize=(10, 5.4), layout="constrained")
    space, arm = figure.add_subplot(1, 2, 1, projection="3d"), figure.add_subplot(1, 2, 2, projection="3d")
    u, v = np.mgrid[0 : 2 * np.pi : 40j, 0 : np.pi : 20j]
    ball = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    for c, a, R in zones():
        x = c + (ball * a) @ R.T
        space.plot_surface(*np.moveaxis(x, -1, 0), color="#8aa0b8", alpha=0.35, linewidth=0)
    space.plot(*path.points.T, color="#d1495b", linewidth=2)
    space.plot(*path.points[0][:, None], "s", color="#d1495b", markersize=6)
    space.plot(*path.points[-1][:, None], "*", color="#0b6e4f", markersize=13)
    space.set_box_aspect(
        [np.ptp(limits) for limits in (space.get_xlim(), space.get_ylim(), space.get_zlim())], zoom=0.85
    )
    space.set(
        xlabel=r"$\theta_1$ [rad]", ylabel=r"$\theta_2$ [rad]", zlabel=r"$\theta_3$ [rad]", title="configuration space"
    )
    for away, bearing, radius, height in BLOCKS:
        angle, z = np.meshgrid(np.linspace(0, 2 * np.pi, 30), [0.0, height])
        x, y = away * np.cos(bearing), away * np.sin(bearing)
        arm.plot_surface(x + radius * np.cos(angle), y + radius * np.sin(angle), z, color="#8aa0b8", alpha=0.6)
    at = np.linspace(0, len(path.points) - 1, 9).astype(int)
    for k, p in enumerate(joints(path.points[at])):
        p = np.vstack([[0, 0, 0], p])
        arm.plot(*p.T, "-o", color=plt.cm.viridis(k / 8), linewidth=2.5, markersize=3)
    arm.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]", title="nine snapshots, from dark to light")
    arm.set_box_aspect([np.ptp(limits) for limits in (arm.get_xlim(), arm.get_ylim(), arm.get_zlim())], zoom=0.85)
    figure.savefig(f"{folder}/field-rn-fig6-7.png", dpi=85)


if __name__ == "__main__":
    if sys.argv[1:2] == ["picture"]:
        picture(sys.argv[2])
    else:
        for center, axes, R in zones():
            numbers = [np.round(v, 5).tolist() for v in (center, np.ceil(axes * 1e4) / 1e4, quaternion(R))]
            print("  - {{type: ellipsoid, center: {}, semi_axes: {}, quaternion_wxyz: {}}}".format(*numbers))
