"""One real plan for all tests of the command line."""

import contextlib
import io
import json
from types import SimpleNamespace

import pytest

from horosphere.cli._app import main


def call(*words):
    """Runs `horosphere WORDS` in this process: code, standard output, standard error."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(word) for word in words])
    return SimpleNamespace(code=code, out=out.getvalue(), err=err.getvalue())


@pytest.fixture(scope="session")
def run():
    return call


@pytest.fixture(scope="session")
def reach(tmp_path_factory):
    """`horosphere plan humanoid-reach --json`: the folder and what was printed."""
    folder = tmp_path_factory.mktemp("reach")
    result = call("plan", "humanoid-reach", "--out", folder, "--save", folder / "more" / "motion.mcap", "--json")
    assert result.code == 0, result.err
    return SimpleNamespace(folder=folder, data=json.loads(result.out))
