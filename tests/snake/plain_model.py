"""The snake by plain trigonometry: a witness that shares no code with the package."""

import numpy as np


def angles(q):
    return np.cumsum(np.asarray(q, float)[2:])


def joints(q, lengths):
    th = angles(q)
    steps = lengths[:, None] * np.stack([np.cos(th), np.sin(th)], 1)
    return np.vstack([q[:2], q[:2] + np.cumsum(steps, 0)])


def wheels(q, lengths, fraction):
    points = joints(q, lengths)
    return points[:-1] + fraction * np.diff(points, axis=0)


def wheel_jacobian(q, lengths, fraction):
    points, centres = joints(q, lengths), wheels(q, lengths, fraction)
    links = len(lengths)
    result = np.zeros((links, 2, links + 2))
    for i in range(links):
        result[i, 0, 0] = result[i, 1, 1] = 1.0
        for k in range(i + 1):
            arm = centres[i] - points[k]
            result[i, :, 2 + k] = -arm[1], arm[0]
    return result


def pfaff(q, lengths, fraction):
    th, jacobian = angles(q), wheel_jacobian(q, lengths, fraction)
    return np.array(
        [-np.sin(th[i]) * jacobian[i, 0] + np.cos(th[i]) * jacobian[i, 1] for i in range(1, len(lengths) - 1)]
    )


def basis(q, lengths, fraction):
    """g1 .. g4 solved from the Pfaff rows one by one, without the reflection law."""
    n, links = len(q), len(lengths)
    rows = pfaff(q, lengths, fraction)
    th0 = q[2]
    columns = []
    for start in (
        {0: 1.0},
        {1: 1.0},
        {0: lengths[0] * np.sin(th0), 1: -lengths[0] * np.cos(th0), 2: 1.0},
        {n - 1: 1.0},
    ):
        v = np.zeros(n)
        for index, value in start.items():
            v[index] = value
        for i in range(1, links - 1):  # row i fixes the rate of Phi_i
            v[2 + i] = -(rows[i - 1] @ v - rows[i - 1, 2 + i] * v[2 + i]) / rows[i - 1, 2 + i]
        columns.append(v)
    return np.stack(columns, 1)


def drive(q, lengths, fraction, segments, duration):
    """End of piecewise constant inputs by DOP853 on the witness's own basis."""
    from scipy.integrate import solve_ivp

    for u in segments:
        run = solve_ivp(
            lambda t, y, u=u: basis(y, lengths, fraction) @ u,
            (0.0, duration / len(segments)),
            q,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
        )
        q = run.y[:, -1]
    return q
