"""A ball in R^n: it follows the harmonic field, at a speed and acceleration that its limits allow."""

from __future__ import annotations

import numpy as np

from ..certify import certify
from ..control import PointMass, SlidingMode, SpeedProfile, Track, track, tracking_inflation
from ..errors import InputError
from ..fields import HarmonicField, Path
from ..fields._chart import Identity
from ..robots import Limits
from ..scenes import ControlOptions, HeadingTarget, PointRobot, PositionTarget, Scene
from ._plan import Plan, Progress
from ._timing import timed_path
from ._tool_path import evenly

_REFINEMENTS = 4
_GROW = 0.5  # seconds of approach by which zones are grown, [Rn]'s second heuristic


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
    if robot.unit == "rad":
        progress.notes.append(
            "a configuration space: where a note or a reason says m or mm, read radians or thousandths of them"
        )
    progress.notes.extend((*field.notes, *path.notes))
    if not path.reached:
        return Plan(scene, False, path.reason, path=path.points)
    if scene.control != ControlOptions():
        with progress.part("tracking"):
            progress.notes.extend(tracking_notes(scene, robot, field, path))
    n = robot.dimension
    limits = Limits(
        np.full(n, -np.inf), np.full(n, np.inf), np.full(n, robot.max_speed / np.sqrt(n)),
        np.full(n, robot.max_acceleration / np.sqrt(n)), np.full(n, np.inf),
    )  # fmt: skip
    names = tuple("xyz"[:n]) if n <= 3 else tuple(f"x{k + 1}" for k in range(n))
    waypoints, reason = evenly(path.points, options.path_step), ""
    for _ in range(_REFINEMENTS):
        with progress.part("timing"):
            trajectory = timed_path(
                waypoints, limits.velocity, limits.acceleration, options.time_step, names,
                options.timing, None if options.jerk is None else np.full(n, options.jerk / np.sqrt(n)),
            )  # fmt: skip
        with progress.part("certificate"):
            certificate = certify(scene, trajectory)
        if certificate.certified:
            return Plan(scene, True, "solved", "harmonic field", trajectory, certificate, path.points)
        reason = f"the motion has no certificate: {certificate.first_violation or certificate.unresolved}"
        waypoints = evenly(path.points, np.linalg.norm(np.diff(waypoints, axis=0), axis=1).max() / 2.0)
    return Plan(scene, False, reason, "harmonic field", path=path.points)


def tracking_notes(scene: Scene, robot: PointRobot, field: HarmonicField, path: Path) -> list[str]:
    """What a simulated run with the scene's control law, period and disturbance does; the motion of the plan is another, timed one."""
    control, notes = scene.control, []
    gain = robot.max_acceleration if control.gain is None else control.gain
    grow = control.grow_radius
    if grow and field.stars:
        grow = False
        notes.append("tracking: grow_radius is for balls only and was left out")
    speed = SpeedProfile(
        robot.max_speed,
        0.4 * robot.max_acceleration,
        0.4 * robot.max_acceleration,
        slow_down=1.0 if control.slow_down else 0.0,
    )
    run = track(
        (lambda x, extra: field.grown(extra)(x)) if grow else field,
        path.points[0],
        field.goal,
        period=control.period,
        law=SlidingMode(gain, control.law),
        speed=speed,
        robot=PointMass(robot.radius, robot.max_acceleration),
        disturbance=control.disturbance,
        # the field's zones are grown by the robot's radius and the scene's clearance
        clearance=lambda x: field.clearance(x) + field.margin,
        grow_radius=_GROW if grow else 0.0,
        duration=20.0 + 4.0 * path.length / robot.max_speed,
    )
    words = f"{run.reason} in {run.time[-1]:.2f} s" if run.reached else run.reason
    notes.append(
        f"tracking simulated with {control.law} at {1e3 * control.period:g} ms, disturbance {control.disturbance:g} m/s^2: {words}; "
        f"velocity error {run.rms_error():.3g} m/s rms, least clearance {1e3 * run.clearance:.3g} mm"
    )
    if len(field.world.radii) and isinstance(field.chart, Identity):
        notes.append(_inflation_note(scene, field, run, speed))
    short = scene.options.clearance - run.clearance
    if short > 0.0:
        notes.append(
            f"tracking: to keep the clearance of {1e3 * scene.options.clearance:g} mm, ask for {1e3 * short:.2g} mm more"
        )
    return notes


def _inflation_note(scene: Scene, field: HarmonicField, run: Track, speed: SpeedProfile) -> str:
    """By how much the nearest zone must be grown for the velocity errors that were met within the clearance asked for."""
    world, error = field.world, run.worst_error(nearer=scene.options.clearance)
    if error == 0.0:
        return "tracking: the run kept the clearance asked for; no growth of the zones is needed"
    near = np.linalg.norm(run.positions[:, None] - world.centers, axis=2) - world.radii
    k = int(np.unravel_index(near.argmin(), near.shape)[1])
    radius = world.radii[k] - scene.options.clearance
    growth = float(tracking_inflation(radius, np.linalg.norm(world.centers[k] - field.goal), speed, error))
    covers = "no growth short of the goal covers" if np.isinf(growth) else f"a growth by {1e3 * growth:.2g} mm covers"
    return f"tracking: {covers} a velocity error of {error:.2g} m/s beside {field.names[k]}"


def harmonic_field(scene: Scene, margin: float) -> HarmonicField:
    """The field of a scene for a point that keeps `margin` metres from every obstacle."""
    goal, options = scene.goal, scene.field
    assert isinstance(goal, (PositionTarget, HeadingTarget))
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
