"""The collision model of a link from the geometry that a URDF gives it: capsules or balls, conservative, slack stated."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from ..errors import InputError
from . import _bodies, _placement
from ._bodies import Body, Floats
from ._kept import kept
from ._meshes import read_triangles
from ._urdf import Shape, Urdf

Kind = Literal["capsules", "spheres"]
Source = Literal["auto", "collision", "visual"]
BUDGETS = {"capsules": 16, "spheres": 32}
TOLERANCE = 0.02
"""Metres; the default for geometry of five times that size and more, a fifth of the size for smaller one."""
SIDES = 32


@dataclass(frozen=True, slots=True)
class CoverOptions:
    """How geometry is covered: by what, at most how many bodies a link (for its meshes), until what slack (m)."""

    kind: Kind = "capsules"
    budget: int | None = None
    tolerance: float | None = None
    geometry: Source = "auto"
    seed: int = 0

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
        return min(TOLERANCE, 0.2 * size) if self.tolerance is None else float(self.tolerance)


@dataclass(slots=True)
class LinkCover:
    """Bodies of a link in its frame; `slack` (m) of those round meshes (None if there are none), from how many `triangles`;
    `visual`: visual geometry was used; `problems`: what could not be read; `surface` (t, 3, 3): all of its geometry as triangles,
    None if some of it has none."""

    bodies: list[Body] = field(default_factory=list)
    slack: float | None = None
    triangles: int = 0
    visual: bool = False
    problems: list[str] = field(default_factory=list)
    surface: Floats | None = None


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
    soup: list[Floats] = []
    surface: list[Floats] = []
    meshes, flat = 0, True
    for shape in join_capsules(shapes):
        rotation, translation = _placement.rotation_translation(shape.origin)
        if shape.kind == "mesh":
            found = _read(path, shape, files)
            if isinstance(found, str):
                result.problems.append(found)
                flat = False
                continue
            meshes += 1
        elif shape.kind in ("box", "cylinder"):
            found = box_triangles(np.array(shape.sizes)) if shape.kind == "box" else cylinder_triangles(*shape.sizes)
        else:
            found, flat = np.zeros((0, 3, 3)), False
        surface.append(found @ rotation.T + translation)
        if shape.kind == "mesh" or (options.kind == "spheres" and shape.kind in ("box", "cylinder")):
            soup.append(surface[-1])
        else:
            result.bodies += [body.moved(rotation, translation) for body in _primitive(shape, options)]
    result.surface = np.concatenate(surface) if surface and flat else None
    if soup:
        triangles = np.concatenate(soup)
        what = f"mesh of {len(triangles)} triangles" if meshes else "primitives"
        covered, result.slack = kept(triangles, repr(options), lambda: cover_triangles(triangles, options))
        result.triangles = len(triangles)
        for body in covered:
            note = f"{'visual ' if visual else ''}{what}, slack at most {result.slack:.4f} m"
            result.bodies.append(Body(body.a, body.b, body.radius, note))
    return result


def cover_triangles(triangles: Floats, options: CoverOptions) -> tuple[list[Body], float]:
    """Bodies that hold triangles (t, 3, 3) and what they enclose, and how far they stand out at most (m)."""
    from ._fit import cover_solid
    from ._solid import make_solid

    tolerance = max(options.tolerance_for(float(np.ptp(triangles.reshape(-1, 3), axis=0).max())), 1e-6)
    solid = make_solid(triangles, tolerance)
    return cover_solid(solid, options.most, tolerance, capsules=options.kind == "capsules", seed=options.seed)


def _read(path: Path, shape: Shape, files: dict[str, Floats | str]) -> Floats | str:
    key = f"{shape.filename} {shape.sizes}"
    if key not in files:
        try:
            files[key] = read_triangles(shape.filename, shape.sizes, path)
        except InputError as error:
            files[key] = error.message
    return files[key]


def _primitive(shape: Shape, options: CoverOptions) -> list[Body]:
    if shape.kind == "sphere":
        return _bodies.from_sphere(*shape.sizes)
    if shape.kind == "capsule":
        radius, length = shape.sizes
        end = np.array([0.0, 0.0, 0.5 * length])
        body = Body(-end, end, radius, "capsule, exact")
        return (
            [body]
            if options.kind == "capsules"
            else _bodies.as_balls(body, options.most, options.tolerance_for(2.0 * radius))
        )
    if shape.kind == "cylinder":
        return _bodies.from_cylinder(*shape.sizes)
    return _bodies.from_box(np.array(shape.sizes))


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
    rim = radius / np.cos(np.pi / SIDES) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    low, high = (np.insert(rim, 2, z, axis=1) for z in (-0.5 * length, 0.5 * length))
    middle = [np.broadcast_to([0.0, 0.0, z], low[1:].shape) for z in (-0.5 * length, 0.5 * length)]
    parts = [
        (low[:-1], low[1:], high[1:]),
        (low[:-1], high[1:], high[:-1]),
        (low[:-1], low[1:], middle[0]),
        (high[:-1], high[1:], middle[1]),
    ]
    return np.concatenate([np.stack(part, axis=1) for part in parts])
