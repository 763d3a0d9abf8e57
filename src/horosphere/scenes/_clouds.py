"""Point clouds from files: what was cut off, transposed or named otherwise is refused, what is not used is noted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._whole import ply_header, require_whole
from ..errors import InputError
from ..numeric import is_number
from ._files import suffix_of
from ._pcd import read_pcd

CLOUDS = (".npy", ".npz", ".csv", ".xyz", ".ply", ".pcd")
_XYZ = ("x", "y", "z")
_MOST_COLUMNS = 32
_NO_BREAK = "no line break after the last line: make sure that nothing was cut off"
_DECIMALS = "write decimal points, and commas, semicolons or spaces between the numbers"
_NAME_THEM = "name three of the columns x, y and z, or leave the header out: then the first three count"

Floats = NDArray[np.float64]


def read_cloud(path: Path) -> tuple[Floats, list[str]]:
    """Points (m, 3) of an NPY, NPZ (array `points`, or the only one), CSV/XYZ text, PLY or PCD file, and notes on what is not used.

    Raises InputError if the file is not whole, or it is not plain which numbers are x, y and z.
    """
    suffix = suffix_of(path, CLOUDS, "point cloud")
    notes: list[str] = []
    try:
        read = {".npy": _npy, ".npz": _npz, ".ply": _ply, ".pcd": _pcd}.get(suffix, _text)
        points = read(path, notes)
    except InputError as error:
        raise InputError(f"{path.name!r}: {error.message}", remedy=error.remedy, choices=error.choices) from None
    except Exception as error:
        raise InputError(f"{path.name!r} cannot be read as a point cloud: {error}") from None
    if not len(points):
        raise InputError(f"{path.name!r} holds no points", remedy="leave an empty cloud out")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise InputError(
            f"{path.name!r}: point {bad[0]} is not finite ({len(bad):,} of {len(points):,} are not)",
            remedy="take them out; where a camera saw nothing, nothing is known to be free",
        )
    return points, [f"{path.name}: {note}" for note in notes]


def _npy(path: Path, notes: list[str]) -> Floats:
    return _of_array(np.load(path, allow_pickle=False), notes)


def _npz(path: Path, notes: list[str]) -> Floats:
    with np.load(path, allow_pickle=False) as archive:
        if "points" not in archive.files and len(archive.files) != 1:
            raise InputError(
                f"expected an array 'points', or one only, got {', '.join(archive.files) or 'none'}",
                remedy="numpy.savez(file, points=...) writes it",
            )
        return _of_array(archive["points" if "points" in archive.files else archive.files[0]], notes)


def _of_array(array: Any, notes: list[str]) -> Floats:
    """Points (m, 3) from (m, 3 or a few more), or from an array of records with fields x, y, z."""
    if array.dtype.names is not None:
        if not set(_XYZ) <= set(array.dtype.names):
            raise InputError(f"expected fields x, y, z, got {', '.join(array.dtype.names)}")
        return np.stack([np.asarray(array[name], np.float64).ravel() for name in _XYZ], axis=1)
    if array.dtype.kind not in "fiu":
        raise InputError(f"expected an array of real numbers, got dtype {array.dtype}")
    shape = array.shape
    if array.size == 0:
        return np.zeros((0, 3))
    if array.ndim != 2:
        whole = (array.ndim > 2 and shape[-1] == 3) or (array.ndim == 1 and shape[0] % 3 == 0)
        remedy = "array.reshape(-1, 3), if the three numbers of a point stand side by side" if whole else None
        raise InputError(f"expected points (m, 3), got shape {shape}", remedy=remedy)
    rows, columns = shape
    if columns < 3 or (columns > 3 and rows < columns) or columns > _MOST_COLUMNS:
        turned = rows in (3, 4) and "a row is a point here: transpose it (array.T)"
        remedy = turned or "keep the columns of x, y and z" if columns >= 3 or rows == 3 else "a point has x, y and z"
        raise InputError(f"expected points (m, 3), one in each row, got shape {shape}", remedy=remedy)
    if columns > 3:
        notes.append(_unnamed(columns))
    return np.asarray(array[:, :3], np.float64)


def _unnamed(columns: int) -> str:
    others = "the other is" if columns == 4 else f"the other {columns - 3} are"
    return f"its first three columns are taken as x, y, z; {others} not used"


def _ply(path: Path, notes: list[str]) -> Floats:
    data = path.read_bytes()
    require_whole(data, ".ply")
    form, elements, at = ply_header(data)
    k = next((k for k, element in enumerate(elements) if element.name == "vertex"), None)
    if k is None:
        raise InputError(f"no vertices in it, only {', '.join(e.name for e in elements) or 'nothing'}")
    vertex, before = elements[k], elements[:k]
    if not set(_XYZ) <= set(vertex.names):
        raise InputError(f"expected vertices with x, y, z, got {', '.join(vertex.names)}")
    if any(counter for element in (*before, vertex) for _, _, counter in element.properties):
        raise InputError("lists before the end of its vertices are not read", remedy="write x, y, z alone")
    faces = sum(element.count for element in elements if element.name == "face")
    if faces:
        notes.append(f"only its {vertex.count:,} vertices are taken, not its {faces:,} faces; type: mesh takes both")
    if not vertex.count:
        return np.zeros((0, 3))
    if form == "ascii":
        rows = [line for line in data[at:].splitlines() if line and not line.isspace()]
        rows = rows[sum(e.count for e in before) :][: vertex.count]
        if len(elements) == 1 and not data.endswith((b"\n", b"\r")):
            notes.append(_NO_BREAK)
        return np.loadtxt(rows, np.float64, comments=None, usecols=[vertex.names.index(n) for n in _XYZ], ndmin=2)
    order = "<" if form == "binary_little_endian" else ">"
    at += sum(e.count * e.dtype(order).itemsize for e in before)
    table = np.frombuffer(data, vertex.dtype(order), vertex.count, at)
    return np.stack([table[name].astype(np.float64) for name in _XYZ], axis=1)


def _pcd(path: Path, notes: list[str]) -> Floats:
    return read_pcd(path.read_bytes(), notes)


def _text(path: Path, notes: list[str]) -> Floats:
    """Numbers between commas, semicolons or white space, in lines; a header or the last comment before them may name the columns."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"no text: byte {error.start} is not UTF-8") from None
    lines = text.splitlines()
    data = [k for k, line in enumerate(lines) if line.strip() and not _is_comment(line)]
    if not data:
        return np.zeros((0, 3))
    header, count = None, None
    first = _cells(lines[data[0]])
    if not is_number(first[0]):
        header, data = first, data[1:]
    elif len(first) == 1 and first[0].isdigit():
        count, data = int(first[0]), data[1:]
    if count is not None and count != len(data):
        raise InputError(
            f"its first line says {count:,} points, {len(data):,} follow", remedy="copy or export it again"
        )
    if not data:
        return np.zeros((0, 3))
    if header is None and data[0] > 0 and _is_comment(lines[data[0] - 1]):
        named = _cells(lines[data[0] - 1].strip().lstrip("#/"))
        header = named if set(_XYZ) <= {cell.lower() for cell in named} else None
    table = _table(lines, data)
    if not text.endswith(("\n", "\r")):
        notes.append(_NO_BREAK)
    columns = table.shape[1]
    if columns < 3:
        raise InputError(f"expected x, y and z in each line, got {columns} numbers")
    if header is not None:
        names = [cell.lower() for cell in header]
        if len(names) == columns and set(_XYZ) <= set(names):
            return table[:, [names.index(name) for name in _XYZ]]
        if len(names) != columns or columns > 3:
            raise InputError(f"{columns} columns under the header {', '.join(header)[:80]!r}", remedy=_NAME_THEM)
        notes.append(f"its columns {', '.join(header)} are taken as x, y, z")
    elif columns > 3:
        notes.append(_unnamed(columns))
    return table[:, :3]


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(("#", "//"))


def _separator(line: str) -> str | None:
    return ";" if ";" in line else "," if "," in line else None


def _cells(line: str) -> list[str]:
    separator = _separator(line)
    line = line.strip().removesuffix(separator) if separator else line
    return [cell.strip().strip("\"'") for cell in line.split(separator)] or [""]


def _table(lines: list[str], data: list[int]) -> Floats:
    """The numbers (m, columns) of the lines `data`, all separated as in the first."""
    rows = [lines[k].strip() for k in data]
    separator = _separator(rows[0])
    if separator and rows[0].endswith(separator):
        rows = [row.removesuffix(separator) for row in rows]
    try:
        return np.loadtxt(rows, np.float64, comments=None, delimiter=separator, ndmin=2)
    except ValueError as error:
        columns = len(rows[0].split(separator))
        for k, row in zip(data, rows):
            cells = [cell.strip() for cell in row.split(separator)]
            bad = next((cell for cell in cells if not is_number(cell)), None)
            if bad is not None:
                remedy = _DECIMALS if "," in bad or " " in bad else None
                raise InputError(f"line {k + 1}: expected a number, got {bad!r}", remedy=remedy) from None
            if len(cells) != columns:
                raise InputError(
                    f"line {k + 1}: {len(cells)} numbers, {columns} in the lines before", remedy="was it cut off?"
                ) from None
        raise InputError(str(error)) from None
