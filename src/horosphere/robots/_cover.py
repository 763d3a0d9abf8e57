"""The collision model of a link from the geometry that a URDF gives it: capsules or balls, conservative, slack stated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from ..errors import InputError
from ..numeric import at_most
from . import _bodies, _placement
from ._bodies import Body, Floats
from ._kept import digest, find, kept
from ._meshes import content_of, read_triangles
from ._urdf import Shape, Urdf

Kind = Literal["capsules", "spheres"]
Source = Literal["auto", "collision", "visual"]
BUDGETS = {"capsules": 40, "spheres": 48}
TOLERANCE = 0.015
"""Metres; the default for geometry of five times that size and more, a fifth of the size for smaller one."""
SIDES = 32
ROUNDING = 1.0 / np.cos(np.pi / SIDES) - 1.0
"""A prism of so many sides round a cylinder stands out of it by this share of its radius."""


@dataclass(frozen=True, slots=True)
class CoverOptions:
    """How geometry is covered: by what, at most how many bodies a link (for its meshes), until what slack (m).

    `share`: of the slack that is the default for the size of the geometry.
    """

    kind: Kind = "capsules"
    budget: int | None = None
    tolerance: float | None = None
    geometry: Source = "auto"
    seed: int = 0
    share: float = 1.0

    def __post_init__(self) -> None:
        if self.kind not in BUDGETS:
            raise InputError(f"cannot cover by {self.kind!r}", place="collision", choices=tuple(BUDGETS))
        if self.geometry not in ("auto", "collision", "visual"):
            raise InputError(
                f"unknown geometry {self.geometry!r}", place="geometry", choices=("auto", "collision", "visual")
            )
        if self.budget is not None and (
            isinstance(self.budget, bool) or int(self.budget) != self.budget or self.budget < 1
        ):
            raise InputError(f"expected a number of bodies >= 1, got {self.budget!r}", place="budget")
        if self.tolerance is not None and not (np.isfinite(self.tolerance) and self.tolerance > 0.0):
            raise InputError(f"expected a length > 0 in metres, got {self.tolerance!r}", place="tolerance")

    @property
    def most(self) -> int:
        """Bodies a link, at most."""
        return BUDGETS[self.kind] if self.budget is None else int(self.budget)

    def tolerance_for(self, size: float) -> float:
        """Slack (m) at which geometry of this size (m, its longest side) is covered well enough."""
        return self.share * min(TOLERANCE, 0.2 * size) if self.tolerance is None else float(self.tolerance)


@dataclass(frozen=True, slots=True)
class Surface:
    """All geometry of a link as triangles (t, 3, 3), made when asked for, and a key of what they are made from."""

    key: str
    triangles: Callable[[], Floats]


@dataclass(slots=True)
class LinkCover:
    """Bodies of a link in its frame, from how many `triangles`;
    `visual`: visual geometry was used; `problems`: what could not be read; `surface`: None if some of it has no triangles."""

    bodies: list[Body] = field(default_factory=list)
    triangles: int = 0
    visual: bool = False
    problems: list[str] = field(default_factory=list)
    surface: Surface | None = None

    @property
    def slack(self) -> float:
        """How far the bodies stand out of the geometry at most (m)."""
        return max((body.slack for body in self.bodies), default=0.0)


def cover_link(urdf: Urdf, link: str, options: CoverOptions, files: dict[str, Floats | str] | None = None) -> LinkCover:
    """Cover a link: its collision geometry; with "auto" its visual geometry if it has none or a mesh of it cannot be read."""
    files = {} if files is None else files
    first, second = urdf.collisions[link], urdf.visuals[link]
    if options.geometry == "visual":
        return _cover(urdf.path, second, options, files, visual=True)
    found = _cover(urdf.path, first, options, files)
    if options.geometry == "auto" and second and (found.problems or not first):
        other = _cover(urdf.path, second, options, files, visual=True)
        if not other.problems:
            return other
    return found


def _cover(
    path: Path, shapes: list[Shape], options: CoverOptions, files: dict[str, Floats | str], visual: bool = False
) -> LinkCover:
    result = LinkCover(visual=visual and bool(shapes))
    whole = join_capsules(shapes)
    parts = [shape for shape in whole if shape.kind in ("mesh", "box", "cylinder")]
    soup: list[Shape] = []
    for shape in whole:
        found = _closed_form(shape, options)
        if found is None:
            soup.append(shape)
        else:
            rotation, translation = _placement.rotation_translation(shape.origin)
            result.bodies += [body.moved(rotation, translation) for body in found]
    keys = [_key(path, shape) for shape in soup]
    key = None if None in keys else digest(options, keys)
    rows = None if key is None or not soup else find("covers", key)
    straight = bool(soup) and all(shape.kind != "mesh" for shape in soup)
    turn = _placement.rotation_translation(soup[0].origin)[0] if straight else np.eye(3)
    if rows is None:
        sound = [
            (shape, key) for shape, key in zip(soup, keys, strict=True) if not _problem(path, shape, files, result)
        ]
        if sound:
            triangles = np.concatenate([_triangles(path, shape, files) for shape, _ in sound])
            known = [digest(triangles) if key is None else key for _, key in sound]
            rows = kept("covers", digest(options, known), lambda: _rows(triangles, options, turn))
    if parts and not result.problems and len(parts) == len(whole):
        result.surface = Surface(
            digest([_key(path, shape) or _triangles(path, shape, files) for shape in parts]),
            lambda: np.concatenate([_triangles(path, shape, files) for shape in parts]),
        )
    if rows is not None:
        round_ = max((ROUNDING * shape.sizes[0] for shape in soup if shape.kind == "cylinder"), default=0.0)
        slack, result.triangles = float(rows[0, 0]) + round_, int(rows[0, 1])
        meshes = any(shape.kind == "mesh" for shape in soup)
        what = f"mesh of {result.triangles} triangles" if meshes else "primitives"
        note = f"{'visual ' if visual else ''}{what}, slack at most {at_most(slack, decimals=4)} m"
        result.bodies += [Body(row[:3], row[3:6], float(row[6]), note, slack) for row in rows[1:]]
    return result


def cover_box(size: Floats, options: CoverOptions) -> list[Body] | None:
    """Parallel capsules in a box about the origin, None if they stand out of it too far: it is covered like a mesh then."""
    return _near(_bodies.from_box(size, min(8, options.most)), options, float(max(size)))


def cover_cylinder(radius: float, length: float, options: CoverOptions) -> list[Body] | None:
    """A capsule round a cylinder along z, None if it stands out of it too far: it is covered like a mesh then."""
    size = max(2.0 * radius, length)
    return _near(_bodies.from_cylinder(radius, length, options.tolerance_for(size)), options, size)


def _near(bodies: list[Body], options: CoverOptions, size: float) -> list[Body] | None:
    """The bodies, if they stand out no further than geometry of this size (m) may, or the budget leaves no choice."""
    return bodies if options.most == 1 or bodies[0].slack <= options.tolerance_for(size) else None


def _key(path: Path, shape: Shape) -> str | None:
    """Of what the triangles of a shape depend on, None if it cannot be told without reading them."""
    content = content_of(shape.filename, shape.sizes, path) if shape.kind == "mesh" else shape.kind
    return None if content is None else digest(content, shape.sizes, np.asarray(shape.origin))


def _problem(path: Path, shape: Shape, files: dict[str, Floats | str], result: LinkCover) -> bool:
    """Whether a mesh cannot be read, and why."""
    found = _read(path, shape, files) if shape.kind == "mesh" else None
    if isinstance(found, str):
        result.problems.append(found)
    return isinstance(found, str)


def _triangles(path: Path, shape: Shape, files: dict[str, Floats | str]) -> Floats:
    """Triangles (t, 3, 3) of a shape in the frame of its link."""
    if shape.kind == "mesh":
        found = np.asarray(_read(path, shape, files))
    else:
        found = box_triangles(np.array(shape.sizes)) if shape.kind == "box" else cylinder_triangles(*shape.sizes)
    rotation, translation = _placement.rotation_translation(shape.origin)
    return found @ rotation.T + translation


def _rows(triangles: Floats, options: CoverOptions, turn: Floats) -> Floats:
    """A cover as an array: slack and number of triangles, then a row for each body."""
    bodies, slack = cover_triangles(triangles, options, turn)
    return np.array([[slack, len(triangles), *np.zeros(5)], *([*body.a, *body.b, body.radius] for body in bodies)])


def cover_triangles(triangles: Floats, options: CoverOptions, turn: Floats | None = None) -> tuple[list[Body], float]:
    """Bodies that hold triangles (t, 3, 3) and what they enclose, and how far they stand out at most (m).

    turn: the axes (3, 3), as columns, of a frame along which flat faces lie: the grid and the boxes of the search fit those best.
    """
    from ._fit import cover_solid
    from ._solid import make_solid

    turn = np.eye(3) if turn is None else turn
    triangles = triangles @ turn
    tolerance = max(options.tolerance_for(float(np.ptp(triangles.reshape(-1, 3), axis=0).max())), 1e-6)
    solid = make_solid(triangles, tolerance)
    bodies, slack = cover_solid(solid, options.most, tolerance, capsules=options.kind == "capsules", seed=options.seed)
    return [body.moved(turn, np.zeros(3)) for body in bodies], slack


def _read(path: Path, shape: Shape, files: dict[str, Floats | str]) -> Floats | str:
    key = f"{shape.filename} {shape.sizes}"
    if key not in files:
        try:
            files[key] = read_triangles(shape.filename, shape.sizes, path)
        except InputError as error:
            files[key] = error.message
    return files[key]


def _closed_form(shape: Shape, options: CoverOptions) -> list[Body] | None:
    """Bodies of a shape in its own frame, None if bodies have to be fitted to its triangles."""
    if shape.kind == "sphere":
        return _bodies.from_sphere(shape.sizes[0])
    if shape.kind == "capsule":
        radius, length = shape.sizes
        end = np.array([0.0, 0.0, 0.5 * length])
        body = Body(-end, end, radius, "capsule, exact")
        return (
            [body]
            if options.kind == "capsules"
            else _bodies.as_balls(body, options.most, options.tolerance_for(2.0 * radius))
        )
    if shape.kind == "mesh" or options.kind == "spheres":
        return None
    if shape.kind == "cylinder":
        radius, length = shape.sizes
        return cover_cylinder(radius, length, options)
    return cover_box(np.array(shape.sizes), options)


def join_capsules(shapes: list[Shape]) -> list[Shape]:
    """The same shapes, but a cylinder with a sphere of its radius at either end is one capsule, as it is often written."""
    result, used = list(shapes), set()
    places = {k: _placement.rotation_translation(s.origin)[1] for k, s in enumerate(shapes) if s.kind == "sphere"}
    for k, shape in enumerate(shapes):
        if shape.kind != "cylinder":
            continue
        rotation, middle = _placement.rotation_translation(shape.origin)
        radius, length = shape.sizes
        ends: list[int] = []
        for end in (middle - 0.5 * length * rotation[:, 2], middle + 0.5 * length * rotation[:, 2]):
            near = (i for i, p in places.items() if np.linalg.norm(p - end) < 1e-9 and i not in ends)
            # capsules that meet share a sphere, or each has its own
            ends += sorted((i for i in near if abs(shapes[i].sizes[0] - radius) < 1e-9), key=lambda i: i in used)[:1]
        if len(ends) == 2:
            result[k] = Shape("capsule", shape.sizes, shape.origin)
            used.update(ends)
    return [shape for k, shape in enumerate(result) if k not in used]


def box_triangles(size: Floats) -> Floats:
    """Twelve triangles (12, 3, 3) of a box about the origin."""
    faces = []
    for k in range(3):
        for side in (-0.5, 0.5):
            square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
            corners = np.insert(square, k, side, axis=1) * size
            faces += [corners[[0, 1, 2]], corners[[0, 2, 3]]]
    return np.array(faces)


def cylinder_triangles(radius: float, length: float) -> Floats:
    """A prism about the cylinder along z: its faces touch the cylinder from outside."""
    angle = np.arange(SIDES + 1) * (2.0 * np.pi / SIDES)
    rim = (1.0 + ROUNDING) * radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    low, high = (np.insert(rim, 2, z, axis=1) for z in (-0.5 * length, 0.5 * length))
    middle = [np.broadcast_to([0.0, 0.0, z], low[1:].shape) for z in (-0.5 * length, 0.5 * length)]
    parts = [
        (low[:-1], low[1:], high[1:]),
        (low[:-1], high[1:], high[:-1]),
        (low[:-1], low[1:], middle[0]),
        (high[:-1], high[1:], middle[1]),
    ]
    return np.concatenate([np.stack(part, axis=1) for part in parts])
