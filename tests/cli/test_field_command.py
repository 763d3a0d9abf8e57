"""`horosphere field` draws a field of the plane or of space."""

import json

import numpy as np
import pytest


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_picture(run, tmp_path, ending):
    file = tmp_path / "deep" / f"field.{ending}"
    result = run("field", "rn-fig1-basic", "--out", file, "--json")
    assert result.code == 0, result.err
    assert json.loads(result.out)["reached"] is True
    assert [p.name for p in file.parent.iterdir()] == [file.name]
    if ending == "png":
        from PIL import Image

        pixels = np.asarray(Image.open(file).convert("RGB")).reshape(-1, 3)
        assert len(np.unique(pixels, axis=0)) > 50  # not blank


@pytest.mark.parametrize("name", ["rn-fig4-three-obstacles", "rn-fig6-revolute-arm", "field-humanoid-fig6b"])
def test_other_scenes_of_the_papers(run, tmp_path, name):
    result = run("field", name, "--out", tmp_path / "field.png", "--json")
    assert result.code == 0, result.err
    assert json.loads(result.out)["reached"] is True and (tmp_path / "field.png").stat().st_size > 20_000


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("humanoid-reach",), "a point or a unicycle in the plane"),
        (("rn-fig1-basic", "--out", "x.gif"), "valid: .png, .svg, .pdf"),
        (("rn-fig1-basic", "--out", "/dev/null/x.png"), "is a file, not a folder"),
    ],
)
def test_refused(run, words, message):
    result = run("field", *words)
    assert result.code == 2 and message in result.err
