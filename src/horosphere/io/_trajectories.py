"""Trajectories in files: NPZ, CSV, MCAP by the ending of the name."""

from __future__ import annotations

import csv
import zipfile
from pathlib import Path

import numpy as np

from .._atomic import writing
from ..errors import InputError
from ..numeric import file_path, is_number
from ..scenes import Trajectory

_CUT_OFF = "was it cut off? copy or write it again"
TRAJECTORY_ENDINGS = (".npz", ".csv", ".mcap")
_RATES = ("velocities", "accelerations")
_KEYS = {"time": "time", "positions": "q", "velocities": "dq", "accelerations": "ddq"}


def save_trajectory(trajectory: Trajectory, path: str | Path) -> Path:
    """Writes `trajectory`; NPZ holds time, q, dq, ddq, names, CSV one column each, MCAP one ROS 2 JointTrajectory message.

    The file is complete or not there. Raises InputError on another ending, or if it cannot be written.
    """
    path = file_path(path, "path")
    if not hasattr(trajectory, "positions"):
        raise InputError(f"expected a Trajectory, got {type(trajectory).__name__}", place="trajectory")
    writer = {".npz": _save_npz, ".csv": _save_csv, ".mcap": _save_mcap}[_ending(path)]
    writer(trajectory, path)
    return path


def load_trajectory(path: str | Path) -> Trajectory:
    """The trajectory in a file, also one from another planner: NPZ with `q` (and `time`), CSV with a header, MCAP.

    A CSV column is `time`, NAME, NAME.velocity or NAME.acceleration; semicolons or tabs may separate them. Without time
    the waypoints count as one second apart, and `is_timed` is False: then velocities are not checked.
    Raises InputError naming the file, and the line where there is one.
    """
    path = file_path(path, "path")
    reader = {".npz": _load_npz, ".csv": _load_csv, ".mcap": _load_mcap}[_ending(path)]
    if not path.is_file():
        raise InputError("is a folder" if path.is_dir() else "no such file", place=str(path))
    try:
        return reader(path)
    except InputError as error:
        if error.place is not None and error.place.startswith(str(path)):
            raise
        place = f"{path}: {error.place}" if error.place else str(path)
        raise InputError(error.message, place=place, remedy=error.remedy, choices=error.choices) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", place=str(path)) from None


def _ending(path: Path) -> str:
    if path.suffix.lower() not in TRAJECTORY_ENDINGS:
        raise InputError(
            f"no trajectory format has the ending {path.suffix!r}", place=str(path), choices=TRAJECTORY_ENDINGS
        )
    return path.suffix.lower()


def _save_npz(trajectory: Trajectory, path: Path) -> None:
    arrays = {key: getattr(trajectory, name) for name, key in _KEYS.items() if getattr(trajectory, name) is not None}
    with writing(path, "wb") as file:
        np.savez(file, **arrays, names=np.array(trajectory.names, dtype=np.str_))


def _load_npz(path: Path) -> Trajectory:
    with open(path, "rb") as file:
        if file.read(2) != b"PK":
            raise InputError("not an NPZ file: no archive", remedy="numpy.savez writes one")
    try:
        with np.load(path, allow_pickle=False) as archive:
            data = {key: archive[key] for key in archive.files}
    except (ValueError, zipfile.BadZipFile, EOFError, KeyError) as error:
        raise InputError(
            f"not a readable NPZ file ({error})",
            remedy=_CUT_OFF if isinstance(error, zipfile.BadZipFile | EOFError) else None,
        ) from None
    if "q" not in data:
        raise InputError(f"no array 'q' in it, only {', '.join(data) or 'nothing'}", choices=(*_KEYS.values(), "names"))
    count = len(np.atleast_1d(data["q"]))
    names = tuple(str(name) for name in np.atleast_1d(data.get("names", np.zeros(0, np.str_))))
    time = data.get("time", np.arange(float(count)))
    return Trajectory(time, data["q"], data.get("dq"), data.get("ddq"), names, "time" in data)


def _columns(trajectory: Trajectory) -> tuple[list[str], np.ndarray]:
    n = trajectory.positions.shape[1]
    names = trajectory.names or tuple(f"q{j + 1}" for j in range(n))
    header, blocks = ["time", *names], [trajectory.time[:, None], trajectory.positions]
    for rate, ending in zip(_RATES, (".velocity", ".acceleration")):
        if getattr(trajectory, rate) is not None:
            header += [name + ending for name in names]
            blocks.append(getattr(trajectory, rate))
    return header, np.concatenate(blocks, axis=1)


def _save_csv(trajectory: Trajectory, path: Path) -> None:
    header, table = _columns(trajectory)
    with writing(path) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([repr(float(x)) for x in row] for row in table)


def _load_csv(path: Path) -> Trajectory:
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            first = file.readline()
            separator = ";" if ";" in first else "\t" if "\t" in first and "," not in first else ","
            file.seek(0)
            lines = csv.reader(file, delimiter=separator)
            rows = [(k, row) for k, row in enumerate(lines, 1) if any(cell.strip() for cell in row)]
    except UnicodeDecodeError as error:
        raise InputError(f"not a CSV file: byte {error.start} is not UTF-8", remedy="save it as UTF-8") from None
    except csv.Error as error:
        raise InputError(f"not a CSV file ({error})") from None
    if not rows:
        raise InputError("the file is empty")
    header = [cell.strip() for cell in rows[0][1]]
    if all(is_number(cell.replace(",", ".")) for cell in header):
        raise InputError(
            "no header", place=f"{path}:1", remedy="the first line names the columns: time, then one name per joint"
        )
    if len(header) == 1 and " " in header[0]:
        remedy = "separate the columns by commas, semicolons or tabs"
        raise InputError(f"one column, named {_short(header[0])}", place=f"{path}:1", remedy=remedy)
    if len(set(header)) != len(header):
        twice = next(name for name in header if header.count(name) > 1)
        raise InputError(f"two columns are named {twice!r}", place=f"{path}:1")
    if len(rows) == 1:
        raise InputError("a header but no waypoints", place=f"{path}:1")
    table = np.empty((len(rows) - 1, len(header)))
    for i, (line, row) in enumerate(rows[1:]):
        if len(row) != len(header):
            raise InputError(f"expected {len(header)} values as in the header, got {len(row)}", place=f"{path}:{line}")
        for j, cell in enumerate(row):
            if not is_number(cell) or not np.isfinite(float(cell)):
                raise InputError(
                    f"{header[j]}: expected a finite number, got {_short(cell)}",
                    place=f"{path}:{line}:{j + 1}",
                    remedy="write decimal points" if is_number(cell.replace(",", ".", 1)) and "," in cell else None,
                )
            table[i, j] = float(cell)
    names = [name for name in header if name != "time" and not name.endswith((".velocity", ".acceleration"))]
    columns = {name: table[:, k] for k, name in enumerate(header)}
    values = [np.stack([columns[name] for name in names], axis=1)] if names else []
    if not names:
        raise InputError("no joint columns", place=f"{path}:1")
    for ending in (".velocity", ".acceleration"):
        given = [name for name in names if name + ending in columns]
        if given and len(given) != len(names):
            missing = next(name for name in names if name not in given)
            raise InputError(f"{missing + ending!r} is missing, {given[0] + ending!r} is there", place=f"{path}:1")
        values.append(np.stack([columns[name + ending] for name in names], axis=1) if given else None)  # type: ignore[arg-type]
    time = columns.get("time", np.arange(float(len(table))))
    return Trajectory(time, values[0], values[1], values[2], tuple(names), "time" in columns)


def _short(text: str) -> str:
    return repr(text if len(text) <= 60 else f"{text[:57]}...")


def _save_mcap(trajectory: Trajectory, path: Path) -> None:
    from ._mcap import write_mcap

    write_mcap(trajectory, path)


def _load_mcap(path: Path) -> Trajectory:
    from ._mcap import read_mcap

    return read_mcap(path)
