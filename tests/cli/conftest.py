"""One real plan for all tests of the command line."""

import json
from types import SimpleNamespace

import pytest


@pytest.fixture(scope="session")
def reach(run, tmp_path_factory):
    """`horosphere plan humanoid-reach --json`: the folder and what was printed."""
    folder = tmp_path_factory.mktemp("reach")
    result = run("plan", "humanoid-reach", "--out", folder, "--save", folder / "more" / "motion.mcap", "--json")
    assert result.code == 0, result.err
    return SimpleNamespace(folder=folder, data=json.loads(result.out))
