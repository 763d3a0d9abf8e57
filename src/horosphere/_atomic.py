"""Files that are either complete or not there."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from .errors import InputError


@contextmanager
def writing(path: str | Path, mode: str = "w") -> Iterator[IO[Any]]:
    """A file handle on a temporary name beside `path`, renamed to it when the block ends well and removed otherwise.

    An interruption leaves the file that was there before, or none. Raises InputError if the folder cannot be written.
    """
    path = Path(path)
    temporary = path.with_name(_hidden(path.name))
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


@contextmanager
def writing_set(folder: str | Path, names: Sequence[str]) -> Iterator[Path]:
    """A hidden folder inside `folder`: what the block writes there takes the place of all files `names` when it ends well.

    Those of an earlier set that were not written anew are removed, so that results of two runs never stand side by side.
    An interruption or a full disk leaves the earlier set as it was. Raises InputError if the folder cannot be written.
    """
    folder = Path(folder)
    stage = folder / _hidden("horosphere")
    earlier = stage / "earlier"
    try:
        stage.mkdir()
        try:
            yield stage
        except InputError as error:  # the user knows nothing of the hidden folder
            if error.place is None or stage.name not in error.place:
                raise
            place = str(folder / Path(error.place).name)
            raise InputError(error.message, place=place, remedy=error.remedy, choices=error.choices) from None
        earlier.mkdir()
        new = [name for name in names if (stage / name).exists()]
        try:
            for name in names:
                if (folder / name).is_file():
                    os.replace(folder / name, earlier / name)
                if (stage / name).exists():
                    os.replace(stage / name, folder / name)
        except BaseException:
            for name in names:
                if (earlier / name).exists():
                    os.replace(earlier / name, folder / name)
                elif name in new and not (stage / name).exists():
                    (folder / name).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", place=str(folder)) from None
    finally:
        shutil.rmtree(stage, ignore_errors=True)


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
    probe = folder / _hidden("horosphere")
    try:
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", place=str(folder), remedy=remedy) from None
    return folder


def _hidden(name: str) -> str:
    """A name beside `name` that no other thread or process takes, nor one that was killed left behind."""
    return f".{name}.{os.urandom(4).hex()}.tmp"
