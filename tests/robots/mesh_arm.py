"""A 7-joint arm as its maker would ship it: a package folder, package:// paths, STL, OBJ, PLY and DAE meshes with dents."""

import numpy as np
import trimesh

AXES = ["0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1"]
LENGTHS = [0.33, 0.16, 0.16, 0.2, 0.18, 0.1, 0.11]
FORMATS = ["stl", "obj", "ply", "dae", "stl", "obj", "stl", "ply"]


def rough(mesh, triangles, seed, dents=5e-4):
    """At least so many triangles, with dents of some tenths of a millimetre."""
    while len(mesh.faces) < triangles:
        mesh = mesh.subdivide()
    mesh.merge_vertices()
    noise = np.random.default_rng(seed).normal(size=mesh.vertices.shape)
    return trimesh.Trimesh(mesh.vertices + dents * noise, mesh.faces, process=False)


def link_mesh(k, length, triangles, seed):
    """A housing, a sleeve across it and a flange: one shell that is far from convex."""
    radius = 0.065 - 0.004 * k
    parts = [trimesh.creation.cylinder(radius, length, sections=48)]
    parts[0].apply_translation([0, 0, length / 2])
    sleeve = trimesh.creation.cylinder(0.9 * radius, 2.6 * radius, sections=48)
    sleeve.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    sleeve.apply_translation([0, 0.4 * radius, 0])
    box = trimesh.creation.box((1.2 * radius, 1.2 * radius, 0.4 * length))
    box.apply_translation([radius, 0, 0.6 * length])
    parts += [sleeve, box]
    return rough(trimesh.util.concatenate(parts), triangles, seed)


def write_arm(folder, triangles=2_000, seed=0, collision=True, skip=(), joints=7, primitives=False):
    """Writes `acme_description/` into `folder`; the path of its URDF, and the meshes by link."""
    package = folder / "acme_description"
    (package / "meshes").mkdir(parents=True)
    (package / "urdf").mkdir()
    (package / "package.xml").write_text("<package><name>acme_description</name></package>")
    meshes, text = {}, ['<robot name="acme">']
    for k, (length, ending) in enumerate(zip([0.3, *LENGTHS][: joints + 1], FORMATS)):
        geometry = f'<geometry><mesh filename="package://acme_description/meshes/link{k}.{ending}"/></geometry>'
        if primitives:
            geometry = (
                f'<origin xyz="0 0 {length / 2}"/><geometry><cylinder radius="0.08" length="{length}"/></geometry>'
            )
        else:
            mesh = meshes[f"link{k}"] = link_mesh(k, length, triangles, seed + k)
            if k not in skip:
                mesh.export(package / "meshes" / f"link{k}.{ending}")
        tags = ("collision", "visual") if collision else ("visual",)
        text.append(f'<link name="link{k}">{"".join(f"<{t}>{geometry}</{t}>" for t in tags)}</link>')
    for k in range(joints):
        above = [0.3, *LENGTHS][k]
        text.append(
            f'<joint name="joint{k + 1}" type="revolute"><parent link="link{k}"/><child link="link{k + 1}"/>'
            f'<origin xyz="0 0 {above}"/><axis xyz="{AXES[k]}"/><limit lower="-2.8" upper="2.8" velocity="2" effort="50"/></joint>'
        )
    path = package / "urdf" / "acme.urdf"
    path.write_text("\n".join([*text, "</robot>"]))
    return path, meshes
