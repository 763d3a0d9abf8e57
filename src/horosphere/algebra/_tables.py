"""Tables of G(4,1): blades in grade-lexicographic order over e1..e5 (e5 squares to -1), products, the null basis."""

from __future__ import annotations

from itertools import combinations

import numpy as np

METRIC = (1, 1, 1, 1, -1)
BLADES: tuple[tuple[int, ...], ...] = tuple(b for k in range(6) for b in combinations(range(1, 6), k))
POSITION = {b: i for i, b in enumerate(BLADES)}
GRADE = np.array([len(b) for b in BLADES])
NAMES = ("1",) + tuple("e" + "".join(map(str, b)) for b in BLADES[1:])
REVERSE = np.array([(-1.0) ** (k * (k - 1) // 2) for k in GRADE])
INVOLUTE = np.array([(-1.0) ** k for k in GRADE])


def _blade_product(a: tuple[int, ...], b: tuple[int, ...]) -> tuple[tuple[int, ...], int]:
    """Blade and sign of the product of two basis blades: sort by neighbour swaps, contract equal pairs."""
    factors, sign = list(a + b), 1
    for end in range(len(factors) - 1, 0, -1):
        for i in range(end):
            if factors[i] > factors[i + 1]:
                factors[i], factors[i + 1] = factors[i + 1], factors[i]
                sign = -sign
    kept: list[int] = []
    for f in factors:
        if kept and kept[-1] == f:
            kept.pop()
            sign *= METRIC[f - 1]
        else:
            kept.append(f)
    return tuple(kept), sign


def _geometric() -> tuple[np.ndarray, np.ndarray]:
    """PARTNER[k, i] = j and SIGN[k, i] with e_i e_j = SIGN e_k."""
    partner, sign = np.zeros((32, 32), dtype=np.intp), np.zeros((32, 32))
    for i, a in enumerate(BLADES):
        for j, b in enumerate(BLADES):
            c, s = _blade_product(a, b)
            partner[POSITION[c], i], sign[POSITION[c], i] = j, s
    return partner, sign


PARTNER, GEOMETRIC = _geometric()
_LEFT, _RIGHT, _OUT = GRADE[None, :], GRADE[PARTNER], GRADE[:, None]
OUTER = GEOMETRIC * (_OUT == _LEFT + _RIGHT)
LEFT_CONTRACTION = GEOMETRIC * (_OUT == _RIGHT - _LEFT)
INNER = GEOMETRIC * (np.abs(_LEFT - _RIGHT) == _OUT) * (_LEFT > 0) * (_RIGHT > 0)  # Hestenes: none with scalars


def _null_basis() -> tuple[tuple[str, ...], np.ndarray]:
    """Names of the outer products over (e1, e2, e3, e0, ei) and the 32x32 matrix with their coefficients as columns."""
    vectors = np.zeros((5, 32))
    for k in range(3):
        vectors[k, POSITION[(k + 1,)]] = 1.0
    vectors[3, [POSITION[(4,)], POSITION[(5,)]]] = -0.5, 0.5  # e0 = (e5 - e4)/2
    vectors[4, [POSITION[(4,)], POSITION[(5,)]]] = 1.0, 1.0  # ei = e4 + e5
    names, columns = [], []
    for grade in range(6):
        for factors in combinations(range(5), grade):
            blade = np.zeros(32)
            blade[0] = 1.0
            for f in factors:
                blade = (OUTER * vectors[f][PARTNER]) @ blade
            names.append("".join("1230i"[f] for f in factors))
            columns.append(blade)
    return tuple(names), np.array(columns).T


NULL_NAMES, FROM_NULL = _null_basis()
TO_NULL = np.linalg.inv(FROM_NULL)
TO_NULL = np.where(np.abs(TO_NULL) < 1e-12, 0.0, np.round(TO_NULL, 12))
NULL_POSITION = {name: i for i, name in enumerate(NULL_NAMES)}
