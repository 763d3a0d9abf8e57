from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError, unknown_name
from ..numeric import float_array

CHARGE_RULES = ("safe", "equilibrium", "monotone", "planar-log", "printed")


def safe_charge(
    radius: ArrayLike,
    distance: ArrayLike,
    dimension: ArrayLike = 3,
    *,
    rule: str = "safe",
    exponent: ArrayLike | None = None,
) -> NDArray[np.float64]:
    """The charge q of an obstacle ball that faces a goal of charge -1; all arguments broadcast.

    `radius` R and `distance` D from the ball's centre to the goal in metres, D > R; `dimension` n of the space. The field of a
    charge is r^(1-p) with p = `exponent`, by default p = n, the true harmonic field. With rho = D/R:

    - "safe": the least q whose gradient lines never enter the ball,
      (1 + rho)^(1-p) for p <= 2 or rho >= p - 1, else ((p-2)/p)^(p/2) / ((p-2) (rho^2 - 1)^((p-2)/2)).
    - "equilibrium": the unstable point lies on the ball, opposite the goal: (1 + rho)^(1-p).
    - "monotone": the largest q with which the distance to the goal never grows; the same number as "equilibrium".
    - "planar-log": R / (R + D), the equilibrium charge of the planar (p = 2) field used in any dimension.
    - "printed": R / (R + D) whatever p is, as the papers print it; unsafe in 3-D for D < 14/13 R.

    A "safe" value above 1 means that no field with these exponents is both safe and attracted to the goal from everywhere.
    Raises InputError for R <= 0, D <= R, n < 2, p <= 1, an unknown rule.
    Source: [Rn] (3), [Humanoid] (23); "safe" and "monotone" are our derivation (docs/fields.md); see docs/errata.md.
    """
    rule = "planar-log" if rule == "planar" else rule
    if rule not in CHARGE_RULES:
        raise unknown_name("charge rule", str(rule), CHARGE_RULES, place="rule")
    R = float_array(radius, "radius")
    D = float_array(distance, "distance")
    n = float_array(dimension, "dimension")
    if (R <= 0).any():
        raise InputError(f"expected radii above 0, got {float(R.min()):g}", place="radius")
    if (n < 2).any():
        raise InputError(f"expected a dimension of at least 2, got {float(n.min()):g}", place="dimension")
    R, D, n = np.broadcast_arrays(R, D, n)
    if (D <= R).any():
        k = int(np.argmax(R - D))
        raise InputError(
            f"the goal lies in the ball: distance {D.flat[k]:g} is not above radius {R.flat[k]:g}",
            place="distance",
            remedy="move the goal out or shrink the security radius",
        )
    if rule in ("planar-log", "printed"):
        return R / (R + D)
    p = n if exponent is None else float_array(exponent, "exponent")
    if (p <= 1).any():
        raise InputError(f"expected exponents above 1, got {float(np.min(p)):g}", place="exponent")
    rho, p = np.broadcast_arrays(D / R, p)
    q = (1.0 + rho) ** (1.0 - p)
    if rule == "safe":
        near = (p > 2.0) & (rho < p - 1.0)
        # the guarded values keep the unused branch finite
        pn, rn = np.where(near, p, 3.0), np.where(near, rho, 1.5)
        worst = (1.0 - 2.0 / pn) ** (0.5 * pn) / (pn - 2.0) * ((rn - 1.0) * (rn + 1.0)) ** (1.0 - 0.5 * pn)
        q = np.where(near, worst, q)
    return np.asarray(q, dtype=np.float64)


def superposition_charges(
    centers: NDArray[np.float64], radii: NDArray[np.float64], far: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The least charges (m,) with which the sum of all planar fields is safe: (I - M) q = R / (R + D).

    M_ij = R_i / (|S_i - S_j| - R_i) bounds the inward push of charge j on ball i. Where no such charges exist (spectral radius of M
    not below 1) the equilibrium charges are returned; `certificate()` refuses both that and a sum of charges of 1 or more.
    Our derivation (docs/fields.md).
    """
    single = radii / (radii + far)
    M = interaction(centers, radii)
    if len(radii) and np.abs(np.linalg.eigvals(M)).max() >= 1.0:
        return single
    return np.asarray(np.linalg.solve(np.eye(len(radii)) - M, single), dtype=np.float64)


def interaction(centers: NDArray[np.float64], radii: NDArray[np.float64]) -> NDArray[np.float64]:
    """M (m, m) of `superposition_charges`."""
    apart = np.linalg.norm(centers[:, None] - centers, axis=-1)
    np.fill_diagonal(apart, np.inf)
    return radii[:, None] / (apart - radii[:, None])
