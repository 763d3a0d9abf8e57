"""Commands beside plan and check, and what all of them have in common."""

import json
import re
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from horosphere import kinematics, robots
from horosphere.cli import _output
from horosphere.cli._app import build

COMMANDS = sorted(name for name in build() if not name.startswith("-") and name not in ("snake", "bench"))
SNAKE = sorted(name for name in build()["snake"] if not name.startswith("-"))
HEAVY = ("scipy", "numba", "viser", "matplotlib", "trimesh", "pydantic", "yourdfpy")


@pytest.mark.parametrize(
    ("file", "options"),
    [
        ("panda_spheres.urdf", ["--tip", "panda_grasptarget", "--tolerance", "0.005"]),
        ("nao.urdf", ["--base", "torso", "--tip", "l_gripper", "--link-radius", "0.03"]),
    ],
)
def test_a_first_scene_plans_as_it_stands(run, shared_data, tmp_path, file, options):
    path = tmp_path / "new" / "desk.yaml"
    made = run("robot", shared_data / file, *options, "--scene", path)
    assert made.code == 0 and "desk.yaml" in made.out
    planned = run("plan", path, "--out", tmp_path / "out", "--no-report", "--time", "0")
    assert planned.code == 0 and "Solved and certified" in planned.out
    written = path.read_text()
    assert (
        "table" in written and "name: desk" in written and ("tolerance: 0.005" in written) == ("--tolerance" in options)
    )


def test_a_robot_says_where_its_tool_is(run):
    said, data = run("robot", "panda"), json.loads(run("robot", "panda", "--json").out)
    panda = robots.load("panda")
    place = data["tool_pose"]
    assert np.allclose(place["q"], 0.5 * (panda.limits.lower + panda.limits.upper))
    at = kinematics.forward(panda, np.array(place["q"]))
    assert np.allclose(at.translation, place["position"]) and "Tool " in said.out
    turn = Rotation.from_quat(place["quaternion_wxyz"], scalar_first=True).as_matrix()
    assert np.allclose(turn, at.as_matrix()[:3, :3])
    seen = kinematics.forward(panda, np.random.default_rng(0).uniform(panda.limits.lower, panda.limits.upper, (500, 7)))
    assert np.linalg.norm(seen.translation - [0, 0, 0.333], axis=1).max() < data["reach"] < 2.0


@pytest.mark.parametrize("writable", [True, False])
def test_a_cache_folder_that_cannot_be_written_is_said_once(monkeypatch, capsys, tmp_path, writable):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("HOROSPHERE_CACHE", str(tmp_path / ("new" if writable else "file")))
    progress = _output.Working("planning")
    progress._started -= 10.0
    for name, value in (("_heard", []), ("_lost", []), ("_compiling", [progress])):
        monkeypatch.setattr(_output, name, value)
    _output._compiled("first")
    _output._compiled("second")
    said = " ".join(capsys.readouterr().err.split())
    assert said.count("compiled anew each time") == (0 if writable else 1)
    assert ("then they come from the disk" in said) == writable


def test_the_promised_commands_are_there():
    assert {"plan", "check", "show", "field", "robot", "snake", "sweep", "scenes", "warmup"} <= {*COMMANDS, "snake"}
    assert set(SNAKE) == {"growth", "simulate", "steer", "navigate"}


def test_options_are_named_as_they_are_typed(run, shared_data):
    """Not as the Python function that is called behind them writes them."""
    for words, option in (
        (("humanoid-arm", "--link-radius", "nan"), "--link-radius: "),
        ((shared_data / "panda_spheres.urdf",), "(--tip)"),
        ((shared_data / "panda_spheres.urdf", "--tip", "panda_hand", "--group", "x"), "(--srdf)"),
    ):
        result = run("robot", *words)
        assert result.code == 2 and option in result.err and "=" not in result.err and "name_or_path" not in result.err
    result = run("robot", "pnada")
    assert result.err.startswith("error: unknown robot 'pnada'; valid: ")


@pytest.mark.parametrize("words", [("--word", "12"), ("--gait", "serpenoid")])
def test_a_simulated_snake_is_a_table_with_units(run, words):
    result = run("snake", "simulate", "--links", "5", *words)
    lines = [line.split() for line in result.out.splitlines()]
    assert (
        result.code == 0
        and ["x", "m"] in [line[:2] for line in lines]
        and ["theta", "rad"] in [line[:2] for line in lines]
    )
    for line in lines:
        if line[0] in ("x", "y", "theta") or line[0].startswith("Phi_"):
            assert abs(float(line[3]) - float(line[2]) - float(line[4])) < 2e-5


def test_help_is_light():
    program = (
        "import sys; from horosphere.cli._app import main; main(['--help']); main(['plan', '--help']); "
        f"print([m for m in {HEAVY!r} if m in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"
    assert "plan" in done.stdout


@pytest.mark.parametrize("command", [*COMMANDS, *(f"snake {name}" for name in SNAKE)])
def test_every_command_has_help_with_an_example_and_json(run, command):
    text = run(*command.split(), "--help").out
    (example,) = re.findall(r"Example: (horosphere .+?)\s*\n", text)
    assert example.startswith(f"horosphere {command}")
    assert "--json" in text and "--no-json" not in text


def test_the_examples_are_words_the_program_knows():
    app = build()
    for command in COMMANDS:
        text = app[command].help
        words = re.search(r"Example: `horosphere (.+?)`", text)[1].split()
        app.parse_args(
            words, exit_on_error=False, print_error=False
        )  # raises on an unknown option or a missing argument


def test_unknown_words(run):
    result = run("paln", "x")
    assert result.code == 2 and 'Did you mean "plan"?' in result.err
    assert run("--version").out.strip()


def test_robot(run, tmp_path):
    data = json.loads(run("robot", "humanoid-arm", "--json").out)
    assert data["closed_form"]["name"] == "humanoid_arm" and len(data["joints"]) == 5
    result = run("robot", "humanoid-arm", "--out", tmp_path / "arm.yaml")
    assert result.code == 0 and "closed form, humanoid_arm" in result.out
    assert json.loads(run("robot", tmp_path / "arm.yaml", "--json").out)["joints"] == data["joints"]
    scene = "horosphere/scene: 1\nrobot: arm.yaml\nstart: {joints: [0, 0, 0, 0, 0]}\ngoal: {position: [0.3, 0, 0.3]}\n"
    (tmp_path / "scene.yaml").write_text(scene)
    from horosphere.scenes import Scene

    assert Scene.load(tmp_path / "scene.yaml").robot.n_joints == 5


def test_every_figure_of_a_robot_has_its_unit(run):
    rows = [line.split() for line in run("robot", "panda").out.splitlines() if line.startswith("panda_joint")]
    assert len(rows) == 7 and all(row[-2:] == ["N", "m"] and float(row[-3]) > 0 for row in rows)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("pnada",), "unknown robot 'pnada'"),
        (("none.urdf",), "none.urdf: no such file"),
        (("humanoid-arm", "--link-radius", "-1"), "expected a positive radius"),
        (("humanoid-arm", "--out", "/proc/none/x.yaml"), "cannot be made"),
    ],
)
def test_bad_robots(run, words, message):
    result = run("robot", *words)
    assert result.code == 2 and message in result.err


def test_urdf_with_two_tips(run, shared_data):
    result = run("robot", shared_data / "panda_spheres.urdf")
    assert result.code == 2 and "panda_grasptarget" in result.err and "tip" in result.err


def test_nao_without_its_meshes(run, shared_data):
    result = run("robot", shared_data / "nao.urdf", "--base", "torso", "--tip", "l_gripper")
    assert result.code == 0 and re.search(r"mesh.*could not be used", result.out)
    assert "WITHOUT collision body" in result.out
    said = " ".join(result.out.split())
    assert "a position alone: closed form, us5: 4 branches (shoulder, wrist), free psi and q5" in said
    assert "LHand only turns about the tool point" in said


def test_scenes(run, tmp_path):
    listed = json.loads(run("scenes", "--json").out)
    assert {"humanoid-reach", "panda-table", "nao-reach"} <= set(listed) and all(listed.values())
    copy = tmp_path / "copy.yaml"
    assert run("scenes", "humanoid-reach", "--out", copy).code == 0
    assert copy.read_text() == run("scenes", "humanoid-reach").out
    result = run("scenes", "humanoid")
    assert result.code == 2 and "unknown scene 'humanoid'" in result.err


def test_progress_is_told_after_a_while(monkeypatch, capsys):
    import time

    from horosphere.cli import _output

    monkeypatch.setattr(_output, "PATIENCE", 0.05)
    with _output.working("counting") as progress:
        time.sleep(0.2)
        progress.update("counting on")
    with _output.working("a moment"):
        pass
    time.sleep(0.2)
    captured = capsys.readouterr()
    assert captured.err.splitlines() == ["counting ...", "counting on ..."] and captured.out == ""


def test_all_errors_of_a_scene_are_told(run, tmp_path):
    file = tmp_path / "bad.yaml"
    file.write_text(
        "horosphere/scene: 1\nrobot: {type: point, radius: -1}\nstart: {position: [0, 0, .nan]}\ngoal: {position: [1, 1, 1]}\n"
    )
    result = run("plan", file)
    assert result.code == 2
    assert [line.split(":")[2] for line in result.err.splitlines()] == ["2", "3"]


def test_nobody_needs_to_listen_to_progress(monkeypatch):
    import time

    from horosphere.cli import _output

    class Deaf:
        encoding = "utf-8"

        def isatty(self):
            return False

        def write(self, text):
            raise BrokenPipeError

        def flush(self):
            raise BrokenPipeError

    monkeypatch.setattr(sys, "stderr", Deaf())
    monkeypatch.setattr(_output, "PATIENCE", 0.01)
    with _output.working("counting") as progress:
        time.sleep(0.05)
        progress.update("counting on")


def test_a_reader_that_goes_away_is_no_failure(tmp_path):
    words = [sys.executable, "-m", "horosphere", "plan", "rn-fig1-basic", "--no-report", "--out", str(tmp_path)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.stdout.close()
    process.stderr.close()
    assert process.wait(120) == 0
    assert {p.name for p in tmp_path.iterdir()} == {"trajectory.npz", "trajectory.csv", "certificate.json"}


def test_compiling_is_announced_once(monkeypatch):
    said = []
    monkeypatch.setattr(_output, "_heard", [])
    monkeypatch.setattr(_output, "_compiling", [SimpleNamespace(is_terminal=False, update=said.append)])
    for name in ("first", "second", "third"):
        _output._compiled(name)
    assert len(said) == 1 and said[0].startswith("compiling kernels (once on this machine")
    assert _output.compiled_names() == ("first", "second", "third")
