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
    solids, poses = item.items("primitives"), item.items("primitive_poses")
    if len(solids) != len(poses) and not (item.get("pose") is not None and not poses):
        raise item.error(f"{len(solids)} primitives but {len(poses)} primitive_poses")
    for k, solid in enumerate(solids):
        own = name if len(solids) == 1 else f"{name}/{k}"
        shapes.append(_primitive(solid, place @ (pose_of(poses[k]) if poses else np.eye(4)), own, notes))
    meshes, mesh_poses = item.items("meshes"), item.items("mesh_poses")
    for k, mesh in enumerate(meshes):
        from ..shapes import Mesh

        pose = place @ (pose_of(mesh_poses[k]) if mesh_poses else np.eye(4))
        vertices = np.array([v.numbers(3, ("x", "y", "z")) for v in mesh.items("vertices")]).reshape(-1, 3)
        faces = [t.need("vertex_indices") if isinstance(t.value, dict) else t for t in mesh.items("triangles")]
        indices = np.array([t.numbers(3) for t in faces], np.int64).reshape(-1, 3)
        shapes.append(Mesh(vertices @ pose[:3, :3].T + pose[:3, 3], indices, name=name))
    for k, plane in enumerate(item.items("planes")):
        from ..shapes import HalfSpace

        # shape_msgs/Plane: a x + b y + c z + d = 0; the solid lies where that is not positive
        plane_poses = item.items("plane_poses")
        pose = place @ (pose_of(plane_poses[k]) if plane_poses else np.eye(4))
        coefficients = plane.need("coef").numbers(4)
        normal = pose[:3, :3] @ coefficients[:3]
        shapes.append(HalfSpace(normal, float(normal @ pose[:3, 3] - coefficients[3]), name=name))
    return shapes


def _primitive(solid: Node, pose: Floats, name: str, notes: list[str]) -> Any:
    from ..shapes import Ball, Box, Cylinder

    kind = solid.need("type").value
    kind = _TYPES.get(kind, kind)
    if kind not in PRIMITIVES:
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
