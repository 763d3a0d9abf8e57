"""Obstacles from whatever the caller has."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import InputError
from ..numeric import float_array
from ._base import Shape
from ._flat import HalfSpace
from ._round import Ball

KINDS = ("Ball", "Capsule", "Cylinder", "Box", "HalfSpace", "Ellipsoid", "Mesh", "PointCloud", "Sphere", "Plane")


def as_shapes(obstacles: Any) -> tuple[Shape, ...]:
    """Obstacles as a tuple of shapes.

    Takes a shape, an entity `Sphere` (batched: one ball each) or `Plane` (solid where n.x <= d), a pair (centers (m, n),
    radii (m,)), or a list of shapes and entities. Raises InputError.
    """
    if obstacles is None:
        return ()
    if type(obstacles) is tuple and all([issubclass(kind, Shape) for kind in set(map(type, obstacles))]):
        return obstacles
    if isinstance(obstacles, Shape):
        return (obstacles,)
    if _is_entity(obstacles):
        return _from_entity(obstacles)
    if isinstance(obstacles, (list, tuple)):
        if len(obstacles) == 2 and not any(isinstance(x, Shape) or _is_entity(x) for x in obstacles):
            return _from_arrays(*obstacles)
        return tuple(shape for item in obstacles for shape in _one(item))
    raise _wrong(obstacles)


def _one(item: Any) -> tuple[Shape, ...]:
    if isinstance(item, Shape):
        return (item,)
    if _is_entity(item):
        return _from_entity(item)
    raise _wrong(item)


def _wrong(item: Any) -> InputError:
    return InputError(
        f"cannot read an obstacle from {type(item).__name__}",
        place="obstacles",
        choices=KINDS,
        remedy="or a pair (centers (m, n), radii (m,))",
    )


def _is_entity(item: Any) -> bool:
    # by name: the entities bring the kernel compiler along, which plain shapes do without
    return type(item).__module__.startswith("horosphere.entities")


def _from_entity(item: Any) -> tuple[Shape, ...]:
    kind = type(item).__name__
    if kind == "Sphere":
        if not np.all(item.is_real):
            raise InputError("an imaginary sphere (radius squared < 0) is no solid", place="obstacles")
        return _from_arrays(np.reshape(item.center, (-1, 3)), np.reshape(item.radius, -1))
    if kind == "Plane":
        normals, distances = np.reshape(item.normal, (-1, 3)), np.reshape(item.distance, -1)
        return tuple(HalfSpace(n, float(d)) for n, d in zip(normals, distances))
    raise _wrong(item)


def _from_arrays(centers: Any, radii: Any) -> tuple[Shape, ...]:
    points = float_array(centers, "centers", ndim=2)
    sizes = float_array(radii, "radii")
    if sizes.ndim > 1 or (sizes.ndim == 1 and len(sizes) != len(points)):
        raise InputError(f"{len(points)} centers but radii of shape {sizes.shape}", place="radii")
    return tuple(Ball(c, float(r)) for c, r in zip(points, np.broadcast_to(sizes, len(points))))
