"""Shapes of MoveIt collision objects (moveit_msgs/CollisionObject)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._moveit_node import Floats, Node, pose_of

PRIMITIVES = {"box": 3, "sphere": 1, "cylinder": 2, "cone": 2}
_TYPES = {1: "box", 2: "sphere", 3: "cylinder", 4: "cone"}  # shape_msgs/SolidPrimitive


def objects_of(item: Node, to_base: Floats, notes: list[str]) -> list[Any]:
    if item.plain("operation") in (1, "REMOVE"):
        return []
    name = str(item.plain("id") or "")
    place = to_base @ pose_of(item.get("pose"))
    shapes: list[Any] = []
    solids = _posed(item, "primitives", "primitive_poses", place)
    for k, (solid, pose) in enumerate(solids):
        shapes.append(_primitive(solid, pose, name if len(solids) == 1 else f"{name}/{k}", notes))
    for mesh, pose in _posed(item, "meshes", "mesh_poses", place):
        from ..shapes import Mesh

        vertices = np.array([v.numbers(3, ("x", "y", "z")) for v in mesh.items("vertices")]).reshape(-1, 3)
        faces = [_indices(triangle) for triangle in mesh.items("triangles")]
        shapes.append(mesh.make(Mesh, vertices @ pose[:3, :3].T + pose[:3, 3], faces, name=name))
    for plane, pose in _posed(item, "planes", "plane_poses", place):
        from ..shapes import HalfSpace

        # shape_msgs/Plane: a x + b y + c z + d = 0; the solid lies where that is not positive
        coefficients = plane.need("coef").numbers(4)
        normal = pose[:3, :3] @ coefficients[:3]
        shapes.append(plane.make(HalfSpace, normal, float(normal @ pose[:3, 3] - coefficients[3]), name=name))
    return shapes


def _posed(item: Node, parts: str, poses: str, place: Floats) -> list[tuple[Node, Floats]]:
    """The parts of an object, each with its pose; without poses all are where the object is, which has to be said of primitives:
    meshes and planes hold places themselves."""
    solids, stated = item.items(parts), item.items(poses)
    if len(solids) != len(stated) and (stated or (parts == "primitives" and item.get("pose") is None)):
        raise item.error(f"{len(solids)} {parts} but {len(stated)} {poses}")
    return [(solid, place @ pose_of(stated[k]) if stated else place) for k, solid in enumerate(solids)]


def _indices(triangle: Node) -> list[int]:
    """The three vertices of a triangle, by number."""
    node = triangle.need("vertex_indices") if isinstance(triangle.value, dict) else triangle
    numbers = node.numbers(3)
    if (numbers != np.floor(numbers)).any() or np.abs(numbers).max() > 2**31:
        raise node.error(f"expected three vertex numbers, got {node.value!r}")
    return numbers.astype(np.int64).tolist()


def _primitive(solid: Node, pose: Floats, name: str, notes: list[str]) -> Any:
    from ..shapes import Ball, Box, Cylinder

    kind = solid.need("type").value
    kind = _TYPES.get(kind, kind) if type(kind) is int else kind
    if not isinstance(kind, str) or kind not in PRIMITIVES:
        raise solid.need("type").error(f"unknown primitive {kind!r}", choices=sorted(PRIMITIVES))
    sizes = solid.need("dimensions").numbers(PRIMITIVES[kind])
    if (sizes <= 0).any():
        raise solid.need("dimensions").error(f"expected sizes > 0, got {sizes.tolist()}")
    centre = pose[:3, 3]
    if kind == "box":
        return Box(centre, 0.5 * sizes, pose[:3, :3], name=name)
    if kind == "sphere":
        return Ball(centre, float(sizes[0]), name=name)
    if kind == "cone":
        notes.append(f"{name}: the cone is enclosed in its cylinder")
    half = 0.5 * sizes[0] * pose[:3, 2]
    return Cylinder(centre - half, centre + half, float(sizes[1]), name=name)
