"""A ball in R^n: it follows the harmonic field, at a speed and acceleration that its limits allow."""

from __future__ import annotations

import numpy as np

from ..certify import certify
from ..errors import InputError
from ..fields import HarmonicField
from ..robots import Limits
from ..scenes import PointRobot, PositionTarget, Scene
from ._plan import Plan, Progress
from ._timing import timed_path
from ._tool_path import evenly

_REFINEMENTS = 4


def plan_point(scene: Scene, progress: Progress) -> Plan:
    """See `plan`; for a `PointRobot`."""
    robot, options = scene.robot, scene.options
    assert isinstance(robot, PointRobot)
    assert isinstance(scene.start, PositionTarget) and isinstance(scene.goal, PositionTarget)
    with progress.part("field path"):
        try:
            field = harmonic_field(scene, robot.radius + options.clearance)
        except InputError as error:
            return Plan(scene, False, str(error))
        path = field.trace(scene.start.position, step=options.path_step)
    progress.notes.extend((*field.notes, *path.notes))
    if not path.reached:
        return Plan(scene, False, path.reason, path=path.points)
    n = robot.dimension
    limits = Limits(
        np.full(n, -np.inf), np.full(n, np.inf), np.full(n, robot.max_speed / np.sqrt(n)),
        np.full(n, robot.max_acceleration / np.sqrt(n)), np.full(n, np.inf),
    )  # fmt: skip
    names = tuple("xyz"[:n]) if n <= 3 else tuple(f"x{k + 1}" for k in range(n))
    waypoints, reason = evenly(path.points, options.path_step), ""
    for _ in range(_REFINEMENTS):
        with progress.part("timing"):
            trajectory = timed_path(waypoints, limits.velocity, limits.acceleration, options.time_step, names)
        with progress.part("certificate"):
            certificate = certify(scene, trajectory)
        if certificate.certified:
            return Plan(scene, True, "solved", "harmonic field", trajectory, certificate, path.points)
        reason = f"the motion has no certificate: {certificate.first_violation or certificate.unresolved}"
        waypoints = evenly(path.points, np.linalg.norm(np.diff(waypoints, axis=0), axis=1).max() / 2.0)
    return Plan(scene, False, reason, "harmonic field", path=path.points)


def harmonic_field(scene: Scene, margin: float) -> HarmonicField:
    """The field of a scene for a point that keeps `margin` metres from every obstacle."""
    goal, options = scene.goal, scene.field
    return HarmonicField(
        goal.position,
        scene.obstacles,
        boundary=options.boundary,
        rule=options.rule,
        blend=options.blending,
        exponent=options.exponents,
        workspace=scene.workspace,
        sensor_range=options.sensor_range,
        margin=margin,
    )
