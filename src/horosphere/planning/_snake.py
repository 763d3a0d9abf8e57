"""A snake robot: navigation from posture to posture, which brings its own certificate of the whole body."""

from __future__ import annotations

from ..errors import InputError
from ..scenes import Scene
from ..snake import certificate_of, navigate_scene, snake_of, trajectory_of
from ._plan import Plan, Progress


def plan_snake(scene: Scene, progress: Progress) -> Plan:
    """See `plan`; for a `SnakeRobot`."""
    with progress.part("navigation"):
        try:
            result = navigate_scene(scene)
        except InputError as error:  # a start or goal that no motion can leave or reach
            return Plan(scene, False, str(error))
    progress.notes.extend(result.notes)
    if len(result.attempts) > 1:
        progress.note(f"{len(result.attempts)} plans tried, with other turning radii and margins")
    trajectory = trajectory_of(snake_of(scene), result)
    certificate = certificate_of(scene, result)
    reason = "solved" if result.solved else result.reason
    by = "harmonic field, head leading, exact steering at the end"
    return Plan(scene, result.solved, reason, by, trajectory, certificate, result.path)
