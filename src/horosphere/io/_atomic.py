"""Files that are either complete or not there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from ..errors import InputError


@contextmanager
def writing(path: str | Path, mode: str = "w") -> Iterator[IO[Any]]:
    """A file handle on a temporary name beside `path`, renamed to it when the block ends well and removed otherwise.

    An interruption leaves the file that was there before, or none. Raises InputError if the folder cannot be written.
    """
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with open(
            temporary, mode, encoding=None if "b" in mode else "utf-8", newline=None if "b" in mode else ""
        ) as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", place=str(path)) from None
    finally:
        temporary.unlink(missing_ok=True)


def output_folder(path: str | Path) -> Path:
    """The folder, made if it is not there and proved writable; InputError otherwise. Call it before the work starts."""
    folder = Path(path).expanduser()
    remedy = "choose another folder with --out"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise InputError("is a file, not a folder", place=str(folder), remedy=remedy) from None
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror}", place=str(folder), remedy=remedy) from None
    probe = folder / f".horosphere.{os.getpid()}.tmp"
    try:
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", place=str(folder), remedy=remedy) from None
    return folder
