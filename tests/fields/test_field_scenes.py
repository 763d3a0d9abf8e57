"""Fields through scenes: meshes from files as stars, names of rules, the tracking of `control:`."""

from typing import get_args

import numpy as np
import pytest

from horosphere.control import SlidingMode
from horosphere.control._sliding import LAWS
from horosphere.errors import InputError
from horosphere.fields import HarmonicField
from horosphere.planning import plan
from horosphere.scenes import Scene, _options, _schema

SCENE = """
horosphere/scene: 1
robot: {{type: point, dimension: {n}, radius: 0.1}}
start: {{position: {start}}}
goal: {{position: {goal}}}
obstacles:
{obstacles}
{more}
"""


def scene(tmp_path, obstacles, more="", start="[3, 0.2, 0.1]", goal="[-3, 0, 0]"):
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE.format(obstacles=obstacles, more=more, start=start, goal=goal, n=start.count(",") + 1))
    return Scene.load(file)


@pytest.mark.parametrize("ending", ["stl", "obj", "ply"])
def test_a_mesh_file_is_a_star_with_its_slack_stated(tmp_path, ending):
    import trimesh

    solid = trimesh.creation.icosphere(2, 0.8).slice_plane([0, 0, -0.2], [0, 0, 1], cap=True)
    solid.export(tmp_path / f"rock.{ending}")
    problem = scene(tmp_path, f"  - {{type: mesh, file: rock.{ending}, name: rock, position: [0.2, 0, 0], scale: 1.5}}")
    field = HarmonicField(problem.goal.position, problem.obstacles, margin=0.11)
    (star,) = field.stars
    assert any(note.startswith("rock: enclosed with at most") for note in field.notes)
    corners = 1.5 * np.asarray(solid.vertices) + [0.2, 0, 0]
    assert star.level(corners).max() < 0.0  # all of it inside, with the margin
    # nowhere further out than the stated slack and the margin, witness: the hull's own support
    w = np.random.default_rng(0).standard_normal((500, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    reach = star.support(w) + w @ star.center
    assert (reach - (w @ corners.T).max(axis=1)).max() <= star.slack + 0.11 * 1.5
    result = plan(problem)
    assert result.solved and any("rock" in note for note in result.notes)
    outside = trimesh.Trimesh(corners, solid.faces)
    gap = -trimesh.proximity.signed_distance(outside, result.path)
    assert gap.min() > 0.1


def test_meshes_that_cannot_be_used_are_named(tmp_path):
    import trimesh

    solid = trimesh.creation.box((1, 1, 1))
    solid.update_faces(np.arange(11))
    solid.export(tmp_path / "open.stl")
    with pytest.raises(InputError, match="not watertight: 3 of its edges"):
        scene(tmp_path, "  - {type: mesh, file: open.stl, name: shell}")
    result = plan(scene(tmp_path, "  - {type: mesh, file: open.stl, name: shell, fill: surface}"))
    assert not result.solved and "shell" in result.reason and "watertight" in result.reason
    (tmp_path / "empty.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    with pytest.raises(InputError, match=r"empty\.obj"):
        scene(tmp_path, "  - {type: mesh, file: empty.obj}")


def test_a_hollow_mesh_says_that_its_hull_is_used(tmp_path):
    import trimesh

    ring = trimesh.creation.torus(0.6, 0.2, major_sections=16, minor_sections=8)
    ring.export(tmp_path / "ring.ply")
    problem = scene(tmp_path, "  - {type: mesh, file: ring.ply, name: ring}")
    assert any("not convex" in note for note in HarmonicField(problem.goal.position, problem.obstacles).notes)


def test_scenes_know_the_names_of_the_layers_above():
    kinds = {
        name: get_args(get_args(_schema.FieldFields.model_fields[name].annotation)[0]) for name in ("rule", "blending")
    }
    assert kinds == {"rule": _options.RULES, "blending": _options.BLENDINGS}
    for rule in _options.RULES:
        HarmonicField([0.0, 0.0], ([[4.0, 0.0]], [1.0]), rule=rule)
    for blend in _options.BLENDINGS:
        HarmonicField([0.0, 0.0], ([[4.0, 0.0]], [1.0]), blend=blend)
    from horosphere.fields import _field, _world

    assert set(_options.RULES) == {*_field.RULES, *(k for k in _field._ALIASES if k[0] != "W")}
    assert set(_options.BLENDINGS) == {*_world.BLENDS, "W1", "W2"}
    laws = get_args(get_args(_schema.ControlFields.model_fields["law"].annotation)[0])
    assert laws == _options.LAWS == LAWS
    assert all(SlidingMode(1.0, law) for law in laws)


def test_an_unknown_rule_is_found_when_the_scene_is_read(tmp_path):
    with pytest.raises(InputError, match="planar-log") as caught:
        scene(tmp_path, "  - {type: sphere, center: [0, 0, 0], radius: 0.5}", "field: {rule: planar-lag}")
    assert "scene.yaml:8" in str(caught.value)


@pytest.mark.parametrize("heuristic", ["", ", slow_down: true", ", grow_radius: true"])
def test_control_of_a_scene_is_simulated_and_reported(tmp_path, heuristic):
    ball = "  - {type: sphere, center: [0, 0.1], radius: 0.5}"
    ends = {"start": "[3, 0.2]", "goal": "[-3, 0]"}
    quiet = plan(scene(tmp_path, ball, **ends))
    assert quiet.solved and not any("tracking" in note for note in quiet.notes)
    found = []
    for disturbance in (0.0, 2.0):
        more = f"control: {{period: 0.05, law: explicit, disturbance: {disturbance}{heuristic}}}"
        result = plan(scene(tmp_path, ball, more, **ends))
        assert result.solved
        (note,) = (note for note in result.notes if "tracking simulated" in note)
        assert "explicit at 50 ms" in note and "reached in" in note
        found.append(float(note.partition("velocity error ")[2].split()[0]))
    assert found[1] > found[0]
