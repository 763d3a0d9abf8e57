"""Matrix exponential of screws in extended precision (80-bit): the witness for the motors."""

import numpy as np

LONG = np.longdouble


def screw_matrix(screw):
    """[[ [w]x, v ], [0, 0]] of one screw, in extended precision."""
    w, v = np.asarray(screw, LONG)[:3], np.asarray(screw, LONG)[3:]
    a = np.zeros((4, 4), LONG)
    a[0, 1], a[0, 2], a[1, 0], a[1, 2], a[2, 0], a[2, 1] = -w[2], w[1], w[2], -w[0], -w[1], w[0]
    a[:3, 3] = v
    return a


def expm(screw):
    """exp of `screw_matrix` by scaling, 30 Taylor terms and squaring."""
    a = screw_matrix(screw)
    halvings = max(0, int(np.ceil(np.log2(float(np.abs(a[:3, :3]).max()) + 1e-30))) + 2)
    a = a / LONG(2) ** halvings
    total = term = np.eye(4, dtype=LONG)
    for k in range(1, 31):
        term = term @ a / LONG(k)
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total


def relative_error(matrix, screw):
    """Errors of the rotation (absolute) and of the translation (relative to the larger of 1 and |v|)."""
    exact = expm(screw)
    size = max(1.0, float(np.abs(np.asarray(screw)[3:]).max()))
    off = np.abs(np.asarray(matrix, LONG) - exact)
    return float(off[:3, :3].max()), float(off[:3, 3].max()) / size
