"""Shared fixtures."""

import contextlib
import io
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of public robots and problem sets; tests that need it are skipped where it is not present."""
    folder = Path(os.environ.get("HOROSPHERE_DATA") or ROOT.parent / "shared" / "data")
    if not folder.is_dir():
        pytest.skip(f"no data folder at {folder} (set HOROSPHERE_DATA)")
    return folder


def call(*words):
    """Runs `horosphere WORDS` in this process: code, standard output, standard error."""
    from horosphere.cli._app import main

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(word) for word in words])
    return SimpleNamespace(code=code, out=out.getvalue(), err=err.getvalue())


@pytest.fixture(scope="session")
def run():
    return call
