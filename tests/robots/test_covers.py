"""Covers of meshes: everything inside, nothing further out than stated; files in four formats; what is missing is said."""

import re

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from horosphere import robots
from horosphere.errors import InputError
from horosphere.robots import _bodies, _cover
from horosphere.robots._cover import CoverOptions, box_triangles, cover_triangles, cylinder_triangles
from horosphere.robots._kept import digest, kept
from horosphere.robots._solid import make_solid, split

from .mesh_arm import FORMATS, LENGTHS, link_mesh, rough, write_arm


def depth_inside(points, bodies):
    """How deep each point lies inside the union of the capsules (negative: outside)."""
    return np.max([body.radius - _bodies.distance_to_axis(points, body) for body in bodies], axis=0)


def meshes(seed):
    """Convex or not, closed or open, fat or thin, coarse or fine."""
    rng = np.random.default_rng(seed)
    if seed == 0:
        return link_mesh(1, 0.33, 3000, seed)
    if seed == 1:
        return trimesh.creation.torus(0.3, 0.05)
    if seed == 2:
        return trimesh.convex.convex_hull(rng.normal(size=(40, 3)) * rng.uniform(0.05, 0.5, 3))
    if seed == 3:  # a plate with no room for a cell inside
        return trimesh.creation.box((0.3, 0.2, 0.001))
    if seed == 4:
        return trimesh.creation.annulus(0.04, 0.05, 0.3)
    if seed == 5:  # a bowl: open, no inside
        ball = rough(trimesh.creation.icosphere(3, 0.1), 1, seed)
        return trimesh.Trimesh(ball.vertices, ball.faces[ball.triangles_center[:, 2] < 0.02], process=False)
    mesh = trimesh.convex.convex_hull(rng.normal(size=(30, 3)))
    mesh.apply_scale(rng.uniform(0.02, 0.2))
    mesh.apply_translation(rng.uniform(-0.3, 0.3, 3))
    return mesh


@pytest.mark.parametrize("kind", ["capsules", "spheres"])
@pytest.mark.parametrize("seed", range(7))
def test_covers_hold_the_mesh_within_their_slack(kind, seed):
    mesh = meshes(seed)
    options = CoverOptions(kind, 16, 0.002)
    bodies, slack = cover_triangles(np.asarray(mesh.triangles), options)
    assert 1 <= len(bodies) <= options.most
    assert all(np.array_equal(b.a, b.b) for b in bodies) or kind == "capsules"
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet(np.ones(3), size=(len(mesh.faces), 60_000 // len(mesh.faces) + 1))
    points = np.einsum("fwc,fcx->fwx", weights, mesh.triangles).reshape(-1, 3)
    assert depth_inside(np.concatenate([points, mesh.vertices[np.unique(mesh.faces)]]), bodies).min() >= -1e-12
    # what stands out: the skin of each body against dense points of the surface, inside counts as nothing
    tree = cKDTree(trimesh.sample.sample_surface(mesh, 60_000, seed=seed)[0])
    directions = rng.normal(size=(1500, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    skins = [b.a + t * (b.b - b.a) + b.radius * directions for b in bodies for t in np.linspace(0.0, 1.0, 7)]
    skin = np.concatenate(skins)
    skin = skin[depth_inside(skin, bodies) < 1e-9]
    grain = 3.0 * np.sqrt(mesh.area / 60_000)  # the samples do not lie everywhere
    assert tree.query(skin)[0].max() <= slack + grain
    # and the bound is worth something: not more than twice what was seen
    assert slack <= 2.0 * tree.query(skin)[0].max() + 0.01


@pytest.mark.parametrize("kind", ["capsules", "spheres"])
def test_what_a_mesh_encloses_is_held_too(kind):
    mesh = link_mesh(2, 0.3, 2000, 5)
    bodies, _ = cover_triangles(np.asarray(mesh.triangles), CoverOptions(kind))
    points = np.random.default_rng(0).uniform(*mesh.bounds, (20_000, 3))
    points = points[mesh.contains(points)]
    assert len(points) > 3000 and depth_inside(points, bodies).min() >= 0.0


@pytest.mark.parametrize("seed", range(3))
def test_depth_is_a_lower_bound(seed):
    mesh = meshes((1, 2, 6)[seed])
    solid = make_solid(np.asarray(mesh.triangles))
    points = np.random.default_rng(seed).uniform(*mesh.bounds, (400, 3))
    true = trimesh.proximity.signed_distance(mesh, points)
    depth = solid.depth(points)
    assert (depth <= true + 1e-9).all()
    deep = true > 2.5 * solid.cell
    assert deep.any() and (depth[deep] >= true[deep] - solid.cell).all()


def test_more_bodies_stand_out_less_and_a_loose_tolerance_needs_few():
    mesh = np.asarray(link_mesh(1, 0.3, 1000, 0).triangles)
    slacks = [cover_triangles(mesh, CoverOptions("spheres", n))[1] for n in (1, 6, 24)]
    assert slacks[0] > 1.2 * slacks[1] > 1.2 * 1.2 * slacks[2]
    slacks = [cover_triangles(mesh, CoverOptions("capsules", n, 0.01))[1] for n in (1, 6, 24)]
    assert slacks[0] > 1.2 * slacks[1] > 1.2 * 1.2 * slacks[2]
    few, slack = cover_triangles(mesh, CoverOptions("spheres", 40, tolerance=0.08))
    assert len(few) < 12 and slack <= 0.08


def test_kept_covers_are_the_same_and_broken_files_are_made_again(tmp_path, monkeypatch):
    monkeypatch.setenv("HOROSPHERE_CACHE", str(tmp_path))
    mesh = np.asarray(trimesh.creation.icosphere(1, 0.1).triangles)
    made = []

    def make():
        made.append(1)
        bodies, slack = cover_triangles(mesh, CoverOptions(budget=2))
        return np.array([[slack] * 7, *([*b.a, *b.b, b.radius] for b in bodies)])

    first, second = kept("covers", "a", make), kept("covers", "a", make)
    assert len(made) == 1 and first.tobytes() == second.tobytes()
    kept("covers", "b", make)
    kept("covers", digest(mesh), make)
    kept("covers", digest(1.5 * mesh), make)
    assert len(made) == 4
    for path in (tmp_path / "covers").iterdir():
        path.write_bytes(path.read_bytes()[:90])
    assert kept("covers", "a", make).tobytes() == first.tobytes() and len(made) == 5


def test_the_second_load_reads_no_mesh(tmp_path, monkeypatch):
    monkeypatch.setenv("HOROSPHERE_CACHE", str(tmp_path / "cache"))
    path, _ = write_arm(tmp_path, 300, joints=2)
    first, read = robots.load(path, budget=4), []
    monkeypatch.setattr(_cover, "read_triangles", lambda *given: read.append(given))
    second = robots.load(path, budget=4)
    assert not read and second.notes == first.notes and second.pair_table == first.pair_table
    assert second.capsules.a.tobytes() == first.capsules.a.tobytes()
    # another byte in a mesh, another cover
    monkeypatch.undo()
    monkeypatch.setenv("HOROSPHERE_CACHE", str(tmp_path / "cache"))
    mesh = link_mesh(1, 0.4, 300, 9)
    mesh.export(path.parent.parent / "meshes" / "link1.obj")
    assert robots.load(path, budget=4).capsules.a.tobytes() != first.capsules.a.tobytes()


def test_covers_repeat_to_the_bit():
    mesh = np.asarray(link_mesh(1, 0.3, 1000, 0).triangles)
    for kind in ("capsules", "spheres"):
        first, second = (cover_triangles(mesh, CoverOptions(kind, 8))[0] for _ in range(2))
        for a, b in zip(first, second, strict=True):
            assert a.a.tobytes() == b.a.tobytes() and a.radius == b.radius


@pytest.mark.parametrize("seed", range(3))
def test_cut_triangles_are_the_same_surface(seed):
    rng = np.random.default_rng(seed)
    triangles = rng.normal(size=(30, 3, 3)) * [1.0, 0.1, 0.01]
    parts, number = split(triangles, 0.2)
    edges = np.linalg.norm(parts - np.roll(parts, 1, axis=1), axis=2)

    def area(t):
        return np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1).sum() / 2

    assert edges.max() <= 0.2 and area(parts) == pytest.approx(area(triangles), rel=1e-12)
    sums = np.bincount(number, [area(part[None]) for part in parts])
    assert sums == pytest.approx([area(triangle[None]) for triangle in triangles], rel=1e-9)


def test_primitives_as_triangles():
    size = np.array([0.1, 0.2, 0.3])
    box = trimesh.Trimesh(*trimesh.triangles.to_kwargs(box_triangles(size)).values())
    assert box.extents == pytest.approx(size) and box.area == pytest.approx(2 * (0.02 + 0.03 + 0.06))
    pipe = cylinder_triangles(0.1, 0.4)
    across = np.linalg.norm(pipe.mean(axis=1)[:64, :2], axis=1)
    assert np.abs(pipe[..., 2]).max() == pytest.approx(0.2) and across.min() > 0.095
    middles = 0.5 * (pipe[:32, 0] + pipe[:32, 1])
    assert np.linalg.norm(middles[:, :2], axis=1) == pytest.approx(np.full(32, 0.1))
    # none of the cylinder lies outside of it
    rng = np.random.default_rng(0)
    angle = rng.uniform(-np.pi, np.pi, 2000)
    rim = np.stack([0.1 * np.cos(angle), 0.1 * np.sin(angle), rng.choice([-0.2, 0.2], 2000)], axis=1)
    normal = np.cross(pipe[:, 1] - pipe[:, 0], pipe[:, 2] - pipe[:, 0])
    normal *= np.sign((normal * pipe[:, 0]).sum(axis=1))[:, None] / np.linalg.norm(normal, axis=1)[:, None]
    assert (rim @ normal.T - (normal * pipe[:, 0]).sum(axis=1)).max() < 1e-12


def cylinder_arm(folder, sizes):
    """A URDF of cylinders at random places in their links, and where: rotation and translation."""
    text, places, rng = ['<robot name="r">'], [], np.random.default_rng(7)
    for k, (radius, length) in enumerate(sizes):
        xyz, rpy = rng.uniform(-0.3, 0.3, 3), rng.uniform(-3.0, 3.0, 3)
        places.append((Rotation.from_euler("xyz", rpy).as_matrix(), xyz))
        origin = f'<origin xyz="{" ".join(map(str, xyz))}" rpy="{" ".join(map(str, rpy))}"/>'
        shape = f'<geometry><cylinder radius="{radius}" length="{length}"/></geometry>'
        text.append(f'<link name="l{k}"><collision>{origin}{shape}</collision></link>')
        if k:
            ends = f'<parent link="l{k - 1}"/><child link="l{k}"/>'
            text.append(f'<joint name="j{k}" type="continuous"><origin xyz="0 0 1"/>{ends}</joint>')
    path = folder / "r.urdf"
    path.write_text("".join([*text, "</robot>"]))
    return path, places


@pytest.mark.parametrize("kind", ["capsules", "spheres"])
def test_cylinders_are_covered_as_closely_as_meshes(tmp_path, kind):
    # wheel, mount, knob, column, hub; and one whose capsule does
    sizes = [(0.0985, 0.04), (0.025, 0.01), (0.005, 0.005), (0.06, 0.272), (0.0326, 0.051), (0.03, 0.4)]
    path, places = cylinder_arm(tmp_path, sizes)
    robot = robots.load(path, collision=kind)
    caps, rng, worst = robot.capsules, np.random.default_rng(1), 0.0
    for k, ((radius, length), (rotation, middle)) in enumerate(zip(sizes, places)):
        own = np.flatnonzero(caps.link == k)
        bodies = [_bodies.Body(caps.a[i], caps.b[i], caps.radius[i]) for i in own]
        angle, across = rng.uniform(-np.pi, np.pi, 6000), radius * np.sqrt(rng.uniform(size=6000))
        across[:3000] = radius
        z = length * rng.uniform(-0.5, 0.5, 6000)
        z[1500:4500] = 0.5 * length * np.sign(z[1500:4500])
        points = np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)
        assert depth_inside(points @ rotation.T + middle, bodies).min() >= -1e-12
        # the skin against the true cylinder
        directions = rng.normal(size=(1000, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        skins = [b.a + t * (b.b - b.a) + b.radius * directions for b in bodies for t in np.linspace(0.0, 1.0, 7)]
        local = (np.concatenate(skins) - middle) @ rotation
        sides = np.maximum(np.hypot(local[:, 0], local[:, 1]) - radius, 0.0)
        out = np.hypot(sides, np.maximum(np.abs(local[:, 2]) - 0.5 * length, 0.0)).max()
        (said,) = {float(re.search(r"slack at most ([0-9.]+) m", caps.note[i]).group(1)) for i in own}
        # a tenth more: it is the size of the turned cylinder that counts
        assert 0.5 * said < out <= said <= 1.1 * CoverOptions().tolerance_for(max(2.0 * radius, length)), (k, out, said)
        assert len(own) <= CoverOptions(kind).most and (len(own) == 1) == (k == 5 and kind == "capsules")
        worst = max(worst, said)
    note = next(note for note in robot.notes if "stand out of it" in note)
    assert f"at most {worst:.4f} m" in note


@pytest.mark.parametrize("seed", range(20))
def test_one_capsule_round_a_cylinder_is_as_large_as_it_may_be(seed):
    rng = np.random.default_rng(seed)
    radius, length = rng.uniform(0.002, 0.2, 2)
    least = min(  # by trial, with the axis on that of the cylinder
        max(r - radius, max(0.5 * length - np.sqrt(r * r - radius**2), 0.0) + r - 0.5 * length)
        for r in radius * np.linspace(1.0, 3.0, 4001)
    )
    one = _bodies.from_cylinder(radius, length, 0.0)[0]
    assert one.slack == pytest.approx(least, rel=2e-3, abs=1e-8)
    free, tolerance = _bodies.from_cylinder(radius, length)[0], least + rng.uniform() * radius
    bounded = _bodies.from_cylinder(radius, length, tolerance)[0]

    def volume(body):
        return body.radius**2 * (np.linalg.norm(body.b - body.a) + 4.0 / 3.0 * body.radius)

    # volumes come from a scan of radii
    assert bounded.slack <= tolerance and volume(free) <= 1.02 * volume(bounded) <= 1.04 * volume(one)
    rim = [[radius, 0.0, 0.5 * length], [0.0, radius, -0.5 * length]]
    for body in (one, free, bounded):
        assert depth_inside(np.array(rim), [body]).min() >= 0.0


def test_a_budget_of_one_is_one_capsule_a_cylinder(tmp_path):
    path, _ = cylinder_arm(tmp_path, [(0.1, 0.02), (0.05, 0.3)])
    assert len(robots.load(path, budget=1).capsules) == 2


def test_an_arm_with_mesh_files(tmp_path):
    path, shells = write_arm(tmp_path, 300, joints=3)
    for kind in ("capsules", "spheres"):
        robot = robots.load(path, collision=kind, budget=12)
        assert robot.n_joints == 3 and not any("could not" in note for note in robot.notes)
        said = next(note for note in robot.notes if "stand out of it by at most" in note)
        worst = float(re.search(r"at most ([0-9.]+) m", said).group(1))
        for k, name in enumerate(robot.link_names):
            own = np.flatnonzero(robot.capsules.link == k)
            caps = robot.capsules
            bodies = [_bodies.Body(caps.a[i], caps.b[i], caps.radius[i]) for i in own]
            # written in single precision by some formats
            assert depth_inside(shells[name].vertices, bodies).min() >= -1e-6, (name, FORMATS[k])
            assert 0 < len(own) <= 12
            assert all(float(re.search(r"at most ([0-9.]+) m", caps.note[i]).group(1)) <= worst for i in own)
    assert len(robots.load(path, budget=1).capsules) == 4


def test_visual_meshes_stand_in(tmp_path):
    path, shells = write_arm(tmp_path, 300, collision=False, joints=1)
    robot = robots.load(path)
    assert any("visual one is covered: link0" in note for note in robot.notes)
    assert set(robot.capsules.link.tolist()) == {0, 1}
    bare = robots.load(path, geometry="collision")
    assert len(bare.capsules) == 0 and any("NO collision body" in note for note in bare.notes)
    # a collision mesh that is missing is replaced by the visual one, and the robot says so
    path.write_text(
        path.read_text().replace(
            '<link name="link1">',
            '<link name="link1"><collision><geometry><mesh filename="gone.stl"/></geometry></collision>',
        )
    )
    robot = robots.load(path)
    assert any("visual" in note and "link1" in note for note in robot.notes)
    bodies = [
        _bodies.Body(robot.capsules.a[i], robot.capsules.b[i], robot.capsules.radius[i])
        for i in np.flatnonzero(robot.capsules.link == 1)
    ]
    assert depth_inside(shells["link1"].vertices, bodies).min() >= -1e-6


def test_missing_and_broken_meshes_are_named(tmp_path):
    path, _ = write_arm(tmp_path, 300, skip=(3, 4), joints=5)
    meshes = path.parent.parent / "meshes"
    (meshes / "link3.dae").write_text("<COLLADA>this is not")
    (meshes / "link5.obj").write_text("# nothing in here\n")
    robot = robots.load(path)
    notes = " ".join(robot.notes)
    assert "3 mesh(es) of 3 link(s) could not be used" in notes and "link3.dae cannot be read" in notes
    assert "WITHOUT collision body: link3, link4, link5" in notes
    helped = robots.load(
        path, capsules={"link0": 0.1, "link1": 0.1, "link2": 0.1, "link3": 0.07, "link5": []}, link_radius=0.06
    )
    assert "WITHOUT" not in " ".join(helped.notes) and 4 in helped.capsules.link


def test_collada_units_and_scales(tmp_path):
    box = trimesh.creation.box((100.0, 40.0, 40.0))
    box.export(tmp_path / "box.dae")
    text = (tmp_path / "box.dae").read_text()
    text = text.replace("</asset>", '<unit name="millimeter" meter="0.001"/></asset>')
    assert 'meter="0.001"' in text
    (tmp_path / "box.dae").write_text(text)
    shape = '<collision><geometry><mesh filename="box.dae" scale="1 1 -2"/></geometry></collision>'
    (tmp_path / "r.urdf").write_text(
        f'<robot name="r"><link name="a">{shape}</link><link name="b"/><joint name="j" type="continuous">'
        '<parent link="a"/><child link="b"/></joint></robot>'
    )
    robot = robots.load(tmp_path / "r.urdf", budget=1, tip="b")
    low = (np.minimum(robot.capsules.a, robot.capsules.b) - robot.capsules.radius[:, None]).min(axis=0)
    assert (low > -0.12).all() and (low <= [-0.05, -0.02, -0.04]).all()


@pytest.mark.parametrize("collision", ["capsules", "spheres"])
def test_primitives_are_covered(tmp_path, collision):
    shapes = {
        "sphere": '<sphere radius="0.1"/>',
        "cylinder": '<cylinder radius="0.05" length="0.3"/>',
        "box": '<box size="0.3 0.1 0.05"/>',
        "capsule": '<capsule radius="0.05" length="0.2"/>',
    }
    points = {
        "sphere": [[0.1, 0, 0], [0, 0, -0.1]],
        "cylinder": [[0.05, 0, 0.15], [0, -0.05, -0.15]],
        "box": [[0.15, 0.05, 0.025], [-0.15, 0.05, -0.025]],
        "capsule": [[0, 0, 0.15], [0.05, 0, 0.1], [0, 0.05, 0]],
    }
    text = ['<robot name="r">']
    for name, shape in shapes.items():
        origin = '<origin xyz="0.1 0.2 0.3" rpy="0.4 -0.5 0.6"/>'
        text.append(f'<link name="{name}"><collision>{origin}<geometry>{shape}</geometry></collision></link>')
    for one, two in zip(list(shapes), list(shapes)[1:]):
        text.append(f'<joint name="{two}" type="continuous"><parent link="{one}"/><child link="{two}"/></joint>')
    (tmp_path / "r.urdf").write_text("".join([*text, "</robot>"]))
    robot = robots.load(tmp_path / "r.urdf", collision=collision)
    turn = Rotation.from_euler("xyz", [0.4, -0.5, 0.6]).as_matrix()
    caps = robot.capsules
    for k, name in enumerate(robot.link_names):
        own = [_bodies.Body(caps.a[i], caps.b[i], caps.radius[i]) for i in np.flatnonzero(caps.link == k)]
        assert depth_inside(np.array(points[name]) @ turn.T + [0.1, 0.2, 0.3], own).min() >= -1e-12
    if collision == "spheres":
        assert (caps.a == caps.b).all()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"collision": "cubes"}, "cubes.*capsules, spheres"),
        ({"budget": 0}, "bodies >= 1"),
        ({"budget": 2.5}, "bodies >= 1"),
        ({"tolerance": 0.0}, "length > 0"),
        ({"tolerance": np.nan}, "length > 0"),
        ({"geometry": "both"}, "both.*auto, collision, visual"),
        ({"group": "arm"}, "SRDF"),
    ],
)
def test_bad_options(tmp_path, options, words):
    path, _ = write_arm(tmp_path, 1, joints=1)
    with pytest.raises(InputError, match=words):
        robots.load(path, **options)


def test_built_in_robots_as_balls():
    arm, balls = robots.load("panda"), robots.load("panda", collision="spheres")
    caps = balls.capsules
    assert (caps.a == caps.b).all() and len(caps) > len(arm.capsules)
    rng = np.random.default_rng(0)
    for k in range(len(arm.capsules)):
        a, b, r = arm.capsules.a[k], arm.capsules.b[k], arm.capsules.radius[k]
        own = [
            _bodies.Body(caps.a[i], caps.b[i], caps.radius[i])
            for i in np.flatnonzero(caps.link == arm.capsules.link[k])
        ]
        directions = rng.normal(size=(500, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        skin = a + rng.uniform(0, 1, (500, 1)) * (b - a) + r * directions
        assert depth_inside(skin, own).min() >= -1e-12


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["capsules", "spheres"])
def test_covers_of_large_meshes_that_fold_over_themselves(tmp_path, kind):
    """Dents of half a millimetre, triangles narrower than that."""
    path, shells = write_arm(tmp_path, 20_000)
    assert all(len(shell.faces) > 20_000 for shell in shells.values()) and len(LENGTHS) == 7
    arm = robots.load(path, collision=kind)
    for name, shell in shells.items():
        own = np.flatnonzero(arm.capsules.link == arm.link_names.index(name))
        bodies = [_bodies.Body(arm.capsules.a[i], arm.capsules.b[i], arm.capsules.radius[i]) for i in own]
        points = np.concatenate([shell.vertices, trimesh.sample.sample_surface(shell, 20_000, seed=1)[0]])
        assert depth_inside(points, bodies).min() >= -1e-7  # files hold seven digits
        directions = np.random.default_rng(0).normal(size=(1_000, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        skin = np.concatenate([b.a + t * (b.b - b.a) + b.radius * directions for b in bodies for t in (0.0, 0.5, 1.0)])
        assert cKDTree(points).query(skin[depth_inside(skin, bodies) < 1e-9])[0].max() <= 0.02
