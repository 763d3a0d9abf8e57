"""Shared fixtures."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of public robots and problem sets; tests that need it are skipped where it is not present."""
    folder = Path(os.environ.get("HOROSPHERE_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no data folder at {folder} (set HOROSPHERE_DATA)")
    return folder
