"""The scenes that come with the package."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from ..errors import unknown_name


def _folder() -> Path:
    return Path(str(resources.files("horosphere.scenes") / "library"))


def names() -> tuple[str, ...]:
    """Names of the built-in scenes, sorted."""
    return tuple(sorted(path.stem for path in _folder().glob("*.yaml")))


def library_path(name: str) -> Path:
    """The file of a built-in scene; an unknown name is an InputError with the nearest ones."""
    if not isinstance(name, str) or name not in names():
        raise unknown_name("scene", name, names())
    return _folder() / f"{name}.yaml"


def locate(path: str | Path) -> Path:
    """The file that is meant by a path, or by the name of a built-in scene; a file of that name comes first."""
    direct = Path(path).expanduser()
    if direct.exists() or direct.suffix or len(direct.parts) > 1:
        return direct
    return library_path(str(path))
