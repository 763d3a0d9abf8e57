"""What is to be solved: one problem a scene and seed, named, and known by its content."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..scenes._library import locate

SCENE_ENDINGS = (".yaml", ".yml")


@dataclass(frozen=True, slots=True)
class Problem:
    """`name` is unique in its sweep; `key` is a hash of the scene's text and the options, so that a changed scene is solved anew.

    `scene`: an absolute path; `options`: as `planning.plan` takes them; `save`: where its trajectory goes, or None.
    """

    key: str
    name: str
    scene: str
    seed: int | None
    options: Mapping[str, Any]
    save: str | None = None

    def as_task(self) -> dict[str, Any]:
        """What a worker is told, as plain data."""
        return asdict(self)


def expand(
    scenes: Iterable[str | Path], seeds: int | None = None, options: Mapping[str, Any] | None = None
) -> tuple[Problem, ...]:
    """The problems of scene files, built-in scenes and folders (all .yaml files in them, sorted), each once per seed.

    `seeds`: 0 .. seeds-1; None leaves the scene's own. Raises InputError for what is not there and for an empty folder: a
    scene that cannot be read is found out when it is its turn, and named then.
    """
    from .. import __version__

    found: dict[str, Path] = {}
    for given in scenes:
        path = locate(given)
        if path.is_dir():
            inside = sorted(p for p in path.rglob("*") if p.suffix.lower() in SCENE_ENDINGS and p.is_file())
            if not inside:
                raise InputError("no scene file (.yaml) in this folder", place=str(path))
            found |= {str(p): p for p in inside}
        elif not path.is_file():
            raise InputError("no such file", place=str(path), remedy="`horosphere scenes` lists the built-in ones")
        else:
            found[str(given)] = path
    if not found:
        raise InputError("expected at least one scene", place="SCENES", remedy="a file, a folder or a built-in name")
    problems = []
    for name, path in found.items():
        try:
            content = path.read_bytes()
        except OSError as error:
            raise InputError(f"cannot be read: {error.strerror}", place=str(path)) from None
        for seed in [None] if seeds is None else range(seeds):
            chosen = dict(options or {}) | ({} if seed is None else {"seed": seed})
            text = json.dumps([__version__, str(path.resolve()), chosen], sort_keys=True)
            key = hashlib.sha256(content + text.encode()).hexdigest()[:16]
            problems.append(
                Problem(key, name if seed is None else f"{name} seed {seed}", str(path.resolve()), seed, chosen)
            )
    return tuple(problems)
