"""What the README and the pages of docs/ say, runs. (The examples of docs/algebra.md: tests/versors/test_docs.py.)"""

import re
from pathlib import Path

import pytest

import horosphere as hs

ROOT = Path(__file__).resolve().parent.parent
PAGES = ("README.md", *sorted(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md")))


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", (ROOT / page).read_text(), flags=re.MULTILINE | re.DOTALL)


CODE = {page: blocks(page, "python") for page in PAGES if page != "docs/algebra.md"}


@pytest.mark.parametrize("page", [page for page, found in CODE.items() if found])
def test_python(page, tmp_path, monkeypatch, capsys):
    """A page from top to bottom, as a reader would try it; what needs files of the reader's own is marked `py`."""
    monkeypatch.chdir(tmp_path)
    names = {"__name__": page}
    for block in CODE[page]:
        exec(compile(block, page, "exec"), names)


def test_readme_python_tells_the_truth(capsys):
    names = {}
    exec(compile(blocks("README.md", "python")[0], "README.md", "exec"), names)
    said, seen = (float(line.split()[-1]) for line in capsys.readouterr().out.splitlines())
    assert names["plan"].solved and 0.014 <= said <= seen
    assert names["tool"].as_euclidean().shape == (len(names["q"]), 3)


def test_a_robot_file_of_the_page(tmp_path):
    from horosphere.robots import load

    (file,) = [block for block in blocks("docs/robots.md", "yaml") if "horosphere/robot: 1" in block]
    (tmp_path / "two-link.yaml").write_text(file)
    assert load(tmp_path / "two-link.yaml").joint_names == ("shoulder", "elbow")


@pytest.mark.parametrize("k", range(len(blocks("docs/scenes.md", "yaml"))))
def test_yaml(k, tmp_path):
    from horosphere.scenes import Scene

    (tmp_path / "scene.yaml").write_text(blocks("docs/scenes.md", "yaml")[k])
    Scene.load(tmp_path / "scene.yaml")


def test_every_command_that_is_named_is_understood():
    from horosphere.cli._app import build

    app = build()
    text = "".join((ROOT / page).read_text() for page in PAGES)
    lines = set(
        re.findall(
            r"(?:^|`)(?:\./run )?horosphere ((?:plan|check|show|robot|scenes|warmup|field|snake|sweep|bench)\b[^`#\n]*)",
            text,
            re.MULTILINE,
        )
    )
    assert len(lines) > 6
    for line in (line for line in lines if " " in line.strip()):  # others are only mentioned
        words = [word for word in line.split() if word != "..."]
        app.parse_args(words, exit_on_error=False, print_error=False)  # raises on what it does not know


def test_the_table_of_scene_fields_is_complete():
    from horosphere.scenes import _schema

    text = (ROOT / "docs" / "scenes.md").read_text()
    models = [
        *_schema.OBSTACLES.values(),
        *_schema.MECHANISMS.values(),
        *_schema.BODIES.values(),
        _schema.UrdfRobot,
        _schema.OptionFields,
    ]
    models += [_schema.FieldFields, _schema.ControlFields, _schema.PoseFields, _schema.PostureFields]
    words = set(re.findall(r"\w+", text))
    for model in models:
        for field in model.model_fields:
            assert field in words or f"{field.removesuffix('_deg')}" in words, f"{model.__name__}.{field}"
    for kind in _schema.OBSTACLES:
        assert f"`{kind}`" in text


def test_links_lead_somewhere():
    for page in ("README.md", *(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md"))):
        for target in re.findall(r"\]\((?!http)([^)#]+)", (ROOT / page).read_text()):
            assert ((ROOT / page).parent / target).exists(), f"{page}: {target}"


@pytest.mark.parametrize("page", PAGES)
def test_what_a_page_names_is_there(page):
    """Files, tests, options of the command line, and names of the public modules."""
    text = (ROOT / page).read_text()
    for path in re.findall(r"(?:tests|benchmarks|derivations|examples|src)/[\w/.-]*\w", text):
        assert (ROOT / path).exists(), path
    tests = {name for file in ROOT.glob("tests/**/*.py") for name in re.findall(r"def (test_\w+)", file.read_text())}
    for name in re.findall(r"(?<![\w/])(test_\w+)(?![\w.])`", text):
        assert name in tests, name
    options = {word for file in ROOT.glob("src/horosphere/**/*.py") for word in re.findall(r"\w+", file.read_text())}
    for option in re.findall(r"--([a-z][a-z-]+)", text):
        assert option.replace("-", "_") in options or option.removeprefix("no-") in options, option
    for module, name in re.findall(r"`(?:hs\.|horosphere\.)?([a-z]+)\.([A-Za-z_]+)", text):
        if module in dir(hs):
            assert hasattr(getattr(hs, module), name), f"{module}.{name}"
