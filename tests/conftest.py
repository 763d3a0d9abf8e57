"""Shared fixtures."""

import contextlib
import io
import os
import signal
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).resolve().parent.parent

if (
    signal.getsignal(signal.SIGINT) is signal.SIG_IGN
):  # as in a shell's background; the tests of Ctrl-C need it, in children too
    signal.signal(signal.SIGINT, signal.default_int_handler)


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
