"""Results as JSON: numbers that JSON has no word for become null."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from .._atomic import writing
from ..numeric import file_path


def plain(value: Any) -> Any:
    """Dataclasses, arrays, tuples and paths as what JSON knows; NaN and infinity as None."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value) if f.repr}
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(item) for item in value]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else None
    return value if value is None or isinstance(value, str) else str(value)


def to_json(value: Any, indent: int | None = 2) -> str:
    """`value` as JSON text."""
    return json.dumps(plain(value), indent=indent, allow_nan=False, ensure_ascii=False)


def save_json(value: Any, path: str | Path) -> Path:
    """Writes `value` as JSON; complete or not there."""
    path = file_path(path, "path")
    with writing(path) as file:
        file.write(to_json(value) + "\n")
    return path
