"""A way through joint space as a timed motion with its certificate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..certify import certify
from ..scenes import Scene
from ._clearance import arm
from ._plan import Plan, Progress
from ._timing import timed

Floats = NDArray[np.float64]

_ROUGH = 5e-4, 0.05  # play of the clearance (m, share) while a motion is one of several
_REFINEMENTS = 3  # times the waypoints are doubled for the sake of the certificate


def certified(scene: Scene, waypoints: Floats, by: str, progress: Progress, points: Floats | None) -> Plan:
    """Time the motion through `waypoints` and certify it; solved only if the certificate of the timed motion holds.

    The spline through the waypoints leaves their straight connections a little; where that costs the certificate, points
    are put between the waypoints, which draws it closer. Its clearance is found out roughly: `finely`.
    """
    reason, certificate = "", None
    for _ in range(_REFINEMENTS + 1):
        with progress.part("timing"):
            trajectory = timed(arm(scene), waypoints, scene.options)
        with progress.part("certificate"):
            certificate = certify(scene, trajectory, tolerance=_ROUGH[0], relative=_ROUGH[1])
        if certificate.certified:
            return Plan(scene, True, "solved", by, trajectory, certificate, points)
        reason = f"the motion has no certificate: {certificate.first_violation or certificate.unresolved}"
        waypoints = np.insert(waypoints, np.arange(1, len(waypoints)), 0.5 * (waypoints[1:] + waypoints[:-1]), axis=0)
    return Plan(scene, False, reason, by, certificate=certificate, path=points)


def finely(plan: Plan, progress: Progress) -> Plan:
    """The plan with a certificate that finds out the clearance as closely as `certify` by itself does."""
    with progress.part("certificate"):
        return replace(plan, certificate=certify(plan.scene, plan.trajectory))
