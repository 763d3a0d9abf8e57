"""The motion as a viser recording: one page that plays from disk."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..scenes import Scene, Trajectory
from ._parts import extent_of, parts, stride, tool_points
from ._sight import blocks, look
from ._solids import ball, solid_of

Floats = NDArray[np.float64]

OBSTACLE = (214, 110, 70)
GROUND = (205, 205, 200)
PATH = (30, 30, 30)
GLASS = 0.3
"""Opacity of what would hide the robot."""
START, GOAL = (120, 120, 120), (46, 160, 67)
FRAMES_PER_SECOND, MOST_FRAMES = 25.0, 300
REST = 0.8
"""Seconds for which the end is seen before the player starts again."""
AMBIENT = 1.5
FIELD_OF_VIEW, ASPECT, FILLED = 0.7, 1.25, 0.9
"""Of the camera, vertical, rad; the narrowest picture it fits; how much of that the scene may fill."""


def has_viser() -> bool:
    """Is the extra `view` installed?"""
    from importlib.util import find_spec

    return find_spec("viser") is not None


def new_server(port: int | None = None) -> Any:
    """A viser server on this machine's own address (viser's default is every address); a free port unless one is given."""
    if not has_viser():
        raise InputError("drawing needs the extra `view`", remedy="pip install 'horosphere[view]'")
    import viser

    logging.getLogger("websockets").setLevel(logging.ERROR)
    with silent():
        return viser.ViserServer(host="127.0.0.1", port=8080 if port is None else port, verbose=False)


@contextmanager
def silent() -> Iterator[None]:
    """Keeps viser from printing its banner onto standard output, where results go."""
    import rich

    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before


def moments(trajectory: Trajectory) -> tuple[Floats, Floats]:
    """Times from the first waypoint, and configurations, of the frames to draw: at most 25 a second and 300 in all."""
    count = int(np.clip(np.ceil(trajectory.duration * FRAMES_PER_SECOND), 1, MOST_FRAMES)) + 1
    time = np.linspace(trajectory.time[0], trajectory.time[-1], count)
    return time - time[0], trajectory.at(time)


def record(scene: Scene, trajectory: Trajectory | None, path: Floats | None = None) -> str:
    """The scene and its motion as one HTML document, 3D with a time slider; nothing is loaded from a network.

    `path` (k, 3): the points that the tool should follow, drawn besides those it does follow.
    """
    server = new_server()
    try:
        time, q = moments(trajectory) if trajectory is not None else (np.zeros(1), rest(scene))
        moving = draw(server, scene, q, path)
        serializer = server.get_scene_serializer()
        for k in range(len(time)):
            if k:
                serializer.insert_sleep(float(time[k] - time[k - 1]))
            pose(server, moving, k)
        if len(time) > 1:
            serializer.insert_sleep(REST)
        return serializer.as_html()
    finally:
        with silent():
            server.stop()


def rest(scene: Scene) -> Floats:
    """One configuration to draw where there is no motion: the start if it is one, the middle of the limits otherwise."""
    q = getattr(scene.start, "q", None)
    if q is None:
        q = getattr(scene.start, "position", None)
    robot: Any = scene.robot
    if hasattr(robot, "limits"):
        if hasattr(scene.start, "q"):
            return scene.start.q[None]  # type: ignore[union-attr]
        return robot.limits.middle[None]
    if hasattr(scene.start, "heading"):
        return np.array([[*scene.start.position, scene.start.heading or 0.0]])  # type: ignore[union-attr]
    return np.asarray(q)[None]


def up_direction(scene: Scene) -> Floats:
    """y for the humanoid arm, whose torso axis it is; z for everything else."""
    form = getattr(scene.robot, "closed_form", None)
    return np.array([0.0, 1.0, 0.0]) if form and form[0] == "humanoid_arm" else np.array([0.0, 0.0, 1.0])


def draw(server: Any, scene: Scene, q: Floats, path: Floats | None) -> list[tuple[Any, Floats]]:
    """Puts the whole scene on a server; returns the handles of the moving parts with their poses (k, 4, 4)."""
    api = server.scene
    tool = tool_points(scene, q)
    body = parts(scene, q)
    reach = np.concatenate([corners for part in body for corners in _corners(part)])
    center, extent = extent_of(scene, tool, reach)
    up = up_direction(scene)
    solids = {
        k: solid_of(o, center, 1.6 * extent) for k, o in enumerate(scene.obstacles) if type(o).__name__ != "PointCloud"
    }
    lowest = min(
        [float((points @ up).min()) for points in (tool, reach, *(v for v, _ in solids.values()))], default=0.0
    )
    api.set_up_direction(tuple(up))
    api.configure_environment_map(hdri=None, background=False)
    flat = scene.dimension == 2  # figures a few millimetres thick would shade themselves
    api.configure_default_lights(enabled=True, cast_shadow=not flat)
    # what faces away from the lamps, or lies in its own shadow under software rendering, keeps its colour
    api.add_light_hemisphere("/sky", sky_color=(255, 255, 255), ground_color=(190, 190, 190), intensity=AMBIENT)
    goal = getattr(scene.goal, "position", None)
    end = tool[-1] if goal is None else np.concatenate([goal[:3], np.zeros(max(0, 3 - len(goal)))])
    view, glassy = direction(scene, up), frozenset()
    if not flat:
        clouds = {k: blocks(o.points[:: stride(o)]) for k, o in enumerate(scene.obstacles) if k not in solids}
        view, glassy = look(view, up, np.concatenate([*map(_middles, body), end[None]]), {**solids, **clouds})
    for k, obstacle in enumerate(scene.obstacles):
        name = f"/obstacles/{obstacle.name or k + 1}"
        _obstacle(api, name, obstacle, solids.get(k), extent, shadow=not flat, opacity=GLASS if k in glassy else None)
    _ground(api, scene, up, center, extent, lowest)
    if len(tool) > 1:
        _polyline(api, "/tool path", tool, PATH, 2.5)
    if path is not None and len(path) > 1:
        planned = np.column_stack([path[:, :3], np.zeros((len(path), max(0, 3 - path.shape[1])))])
        _polyline(api, "/planned path", planned, (150, 150, 150), 1.0)
    mark = 0.016 * extent
    begin = (
        getattr(scene.start, "position", None) if len(tool) == 1 else None
    )  # then the posture shown need not be there
    begin = tool[0] if begin is None else np.concatenate([begin[:3], np.zeros(max(0, 3 - len(begin)))])
    _mesh(api, "/start", ball(begin, mark), START)
    _mesh(api, "/goal", ball(end, 1.2 * mark), GOAL)
    moving = []
    for part in body:
        handle = api.add_frame(f"/robot/{part.name}", show_axes=False)
        for m, solid in enumerate(part.solids):
            _mesh(api, f"/robot/{part.name}/{m + 1}", solid, part.color)
        moving.append((handle, part.poses))
        if len(q) > 1:
            ghost = api.add_frame(f"/start posture/{part.name}", show_axes=False)
            for m, solid in enumerate(part.solids):
                _mesh(api, f"/start posture/{part.name}/{m + 1}", solid, (150, 150, 150), opacity=0.15)
            _set(ghost, part.poses[0])
    bounded = [solid[0] for k, solid in solids.items() if type(scene.obstacles[k]).__name__ != "HalfSpace"]
    bounded += [o.points[:: stride(o)] for k, o in enumerate(scene.obstacles) if k not in solids]
    _camera(server, scene, up, view, np.concatenate([reach, tool, end[None], *bounded]))
    pose(server, moving, 0)
    return moving


def _corners(part: Any) -> Iterator[Floats]:
    """Points of a moving part at its first, middle and last moment."""
    for k in {0, len(part.poses) // 2, len(part.poses) - 1}:
        for vertices, _ in part.solids:
            yield vertices @ part.poses[k, :3, :3].T + part.poses[k, :3, 3]


def _middles(part: Any) -> Floats:
    """Where the middle of a moving part is at some moments (k, 3)."""
    middle = np.concatenate([vertices for vertices, _ in part.solids]).mean(axis=0)
    some = part.poses[:: max(1, len(part.poses) // 8)]
    return some[:, :3, :3] @ middle + some[:, :3, 3]


def pose(server: Any, moving: list[tuple[Any, Floats]], k: int) -> None:
    """Moves the parts to the k-th moment."""
    with server.atomic():
        for handle, poses in moving:
            _set(handle, poses[k])


def _set(handle: Any, matrix: Floats) -> None:
    from ..scenes import matrix_quaternion

    handle.wxyz = tuple(matrix_quaternion(matrix[:3, :3]))
    handle.position = tuple(matrix[:3, 3])


def _mesh(api: Any, name: str, solid: Any, color: tuple[int, int, int], opacity: float | None = None) -> None:
    vertices, faces = solid
    api.add_mesh_simple(
        name,
        vertices.astype(np.float32),
        faces.astype(np.uint32),
        color=color,
        opacity=opacity,
        side="double" if opacity else "front",
        cast_shadow=opacity is None,
    )


def _obstacle(
    api: Any, name: str, obstacle: Any, solid: Any, extent: float, shadow: bool, opacity: float | None
) -> None:
    if solid is None:
        points = np.asarray(obstacle.points)[:: stride(obstacle)]
        radius = float(np.median(obstacle.radius))
        api.add_point_cloud(name, points.astype(np.float32), OBSTACLE, point_size=radius, point_shape="circle")
        return
    kind = type(obstacle).__name__
    vertices, faces = solid
    api.add_mesh_simple(
        name,
        vertices.astype(np.float32),
        faces.astype(np.uint32),
        color=GROUND if kind == "HalfSpace" else OBSTACLE,
        flat_shading=not shadow or kind in ("HalfSpace", "Box"),
        # the front alone: a solid drawn from both sides lies in its own shadow
        side="double" if kind in ("Mesh", "HalfSpace") or not shadow or opacity else "front",
        opacity=opacity,
        cast_shadow=shadow and kind != "HalfSpace" and not opacity,
        receive_shadow=shadow and not opacity,
    )


def _polyline(api: Any, name: str, points: Floats, color: tuple[int, int, int], width: float) -> None:
    segments = np.stack([points[:-1], points[1:]], axis=1).astype(np.float32)
    api.add_line_segments(name, segments, colors=color, thickness=width, thickness_units="screen")


def _ground(api: Any, scene: Scene, up: Floats, center: Floats, extent: float, lowest: float) -> None:
    if any(type(o).__name__ == "HalfSpace" for o in scene.obstacles):
        return
    foot = center - up * (up @ center)
    low = 0.0 if scene.dimension == 2 else min(0.0, lowest)
    cell = 10.0 ** np.floor(np.log10(extent))
    plane = "xz" if up[1] else "xy"
    size = 4.0 * float(np.ceil(extent / cell)) * cell
    api.add_grid(
        "/ground",
        width=size,
        height=size,
        plane=plane,
        cell_size=0.5 * cell,
        section_size=cell * 2.0,
        position=tuple(foot + low * up),
    )


def direction(scene: Scene, up: Floats) -> Floats:
    """Towards the eye (3,), where nothing stands in the way."""
    view = [0.0, -0.35, 1.0] if scene.dimension == 2 else [1.0, 0.45, 0.7] if up[1] else [1.0, -0.8, 0.6]
    return np.array(view) / np.linalg.norm(view)


def _camera(server: Any, scene: Scene, up: Floats, view: Floats, points: Floats) -> None:
    """Looks from `view`, as near as all `points` (k, 3) stay in the picture, and so that they are in its middle."""
    across = np.cross(up if scene.dimension == 3 else [0.0, 1.0, 0.0], view)
    across /= np.linalg.norm(across)
    frame = np.stack([across, np.cross(view, across), view])  # right, up, towards the eye
    x = points @ frame.T
    half = FILLED * np.tan(0.5 * FIELD_OF_VIEW) * np.array([ASPECT, 1.0])
    look_at, distance = 0.5 * (x.min(axis=0) + x.max(axis=0)), 0.0
    for _ in range(20):  # what is nearer looks larger, so the middle depends on the distance
        y = x - look_at
        distance = max(float((np.abs(y[:, :2]) / half + y[:, 2:]).max()), 1e-3)
        seen = y[:, :2] / (distance - y[:, 2:])
        look_at[:2] += 0.5 * (seen.min(axis=0) + seen.max(axis=0)) * distance
    camera = server.initial_camera
    camera.up, camera.fov = tuple(up), FIELD_OF_VIEW
    camera.look_at = tuple(look_at @ frame)
    camera.position = tuple((look_at + [0.0, 0.0, distance]) @ frame)
