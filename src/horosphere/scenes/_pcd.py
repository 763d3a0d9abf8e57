"""PCD files, as the Point Cloud Library and ROS write them: text, binary, and binary compressed with LZF."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

Floats = NDArray[np.float64]

_REMEDY = "the file was cut off or is damaged: copy or export it again"
_FORMS = ("ascii", "binary", "binary_compressed")
_KINDS = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}
_UNMOVED = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)  # a place, a quaternion w, x, y, z


@dataclass(frozen=True, slots=True)
class _Header:
    """`fields`: name, numpy's code, how many numbers a point; `body`: where the points begin."""

    fields: tuple[tuple[str, str, int], ...]
    count: int
    form: str
    viewpoint: tuple[float, ...]
    body: int

    @property
    def columns(self) -> list[int]:
        """The fields x, y, z."""
        names = [name for name, _, _ in self.fields]
        if not {"x", "y", "z"} <= set(names) or any(self.fields[names.index(name)][2] != 1 for name in "xyz"):
            raise InputError(f"expected fields x, y, z of one number each, got {', '.join(names)}")
        return [names.index(name) for name in "xyz"]

    @property
    def sizes(self) -> list[int]:
        """Bytes of a point, by field."""
        return [int(code[1:]) * count for _, code, count in self.fields]


def read_pcd(data: bytes, notes: list[str]) -> Floats:
    """Points (m, 3) of a PCD file, in its own frame. Raises InputError if it is not whole."""
    header = _header(data)
    columns = header.columns
    if header.viewpoint != _UNMOVED:
        where = " ".join(f"{value:g}" for value in header.viewpoint)
        notes.append(f"its VIEWPOINT {where} is not used: position and quaternion_wxyz of the obstacle place it")
    if header.form == "ascii":
        return _text(data[header.body :], header, columns)
    size = sum(header.sizes)
    if header.form == "binary":
        body = data[header.body :]
        _require(len(body) // max(size, 1), header)
        table = np.frombuffer(body, _rows(header), header.count)
        return np.stack([table[f"f{k}"].astype(np.float64) for k in columns], axis=1)
    if len(data) < header.body + 8:
        raise InputError("no sizes after its header", remedy=_REMEDY)
    packed, plain = struct.unpack_from("<II", data, header.body)
    body = data[header.body + 8 : header.body + 8 + packed]
    if len(body) < packed or plain != size * header.count:
        raise InputError(f"{len(body):,} bytes of {packed:,} for {header.count:,} points", remedy=_REMEDY)
    unpacked = unpack_lzf(body, plain)
    starts = np.cumsum([0, *header.sizes]) * header.count  # field by field
    return np.stack(
        [
            np.frombuffer(unpacked, "<" + header.fields[k][1], header.count, int(starts[k])).astype(np.float64)
            for k in columns
        ],
        axis=1,
    )


def unpack_lzf(data: bytes, size: int) -> bytes:
    """What LZF packed, `size` bytes: runs of literals, and copies of what came before. Raises InputError if it does not fit."""
    out, at, end = bytearray(), 0, len(data)
    try:
        while at < end:
            control = data[at]
            at += 1
            if control < 32:
                out += data[at : at + control + 1]
                at += control + 1
                continue
            length = (control >> 5) + 2
            if length == 9:
                length += data[at]
                at += 1
            start = len(out) - ((control & 31) << 8) - data[at] - 1
            at += 1
            if start < 0:
                raise IndexError
            copy = out[start : start + length]
            if len(copy) < length:  # it reads what it writes: a pattern that repeats
                copy = (copy * (length // len(copy) + 1))[:length]
            out += copy
    except IndexError:
        raise InputError("its compressed points cannot be unpacked", remedy=_REMEDY) from None
    if len(out) != size:
        raise InputError(f"its points unpack to {len(out):,} bytes, not {size:,}", remedy=_REMEDY)
    return bytes(out)


def _header(data: bytes) -> _Header:
    entries, at = {}, 0
    while "DATA" not in entries:
        end = data.find(b"\n", at)
        if end < 0 or end - at > 10_000:
            raise InputError("no PCD file: no line DATA that ends its header")
        words = data[at:end].decode("latin-1").split()
        at = end + 1
        if words and not words[0].startswith("#"):
            entries[words[0].upper()] = words[1:]
    try:
        names, sizes, kinds = entries["FIELDS"], [int(x) for x in entries["SIZE"]], entries["TYPE"]
        counts = [int(x) for x in entries.get("COUNT", ["1"] * len(names))]
        points = int(entries["POINTS"][0]) if "POINTS" in entries else _product(entries)
        viewpoint = tuple(float(x) for x in entries.get("VIEWPOINT", _UNMOVED))
        form = entries["DATA"][0].lower()
    except (KeyError, IndexError, ValueError) as error:
        raise InputError(f"its PCD header is not complete: {error}", remedy=_REMEDY) from None
    if not len(names) == len(sizes) == len(kinds) == len(counts) or points < 0 or min(counts, default=0) < 1:
        raise InputError("FIELDS, SIZE, TYPE and COUNT of its PCD header do not fit together", remedy=_REMEDY)
    for name, size, kind in zip(names, sizes, kinds):
        if size not in _KINDS.get(kind, ()):
            raise InputError(f"field {name!r} of type {kind!r} with {size} bytes", choices=tuple(_KINDS))
    if "WIDTH" in entries and "HEIGHT" in entries and _product(entries) != points:
        raise InputError(f"WIDTH times HEIGHT are {_product(entries):,}, POINTS {points:,}", remedy=_REMEDY)
    if form not in _FORMS:
        raise InputError(f"PCD data {form!r}", choices=_FORMS)
    fields = tuple((n, f"{kind.lower()}{size}", count) for n, size, kind, count in zip(names, sizes, kinds, counts))
    return _Header(fields, points, form, viewpoint, at)


def _product(entries: dict[str, list[str]]) -> int:
    return int(entries["WIDTH"][0]) * int(entries["HEIGHT"][0])


def _require(found: int, header: _Header) -> None:
    if found < header.count:
        raise InputError(f"its header says {header.count:,} points, it holds {found:,}", remedy=_REMEDY)


def _rows(header: _Header) -> np.dtype:
    shapes = [(count,) if count > 1 else () for _, _, count in header.fields]
    return np.dtype(
        [(f"f{k}", "<" + code, shape) for k, ((_, code, _), shape) in enumerate(zip(header.fields, shapes))]
    )


def _text(body: bytes, header: _Header, columns: list[int]) -> Floats:
    lines = [line for line in body.splitlines() if line and not line.isspace()]
    _require(len(lines), header)
    if len(lines) > header.count:
        raise InputError(f"its header says {header.count:,} points, {len(lines):,} follow", remedy=_REMEDY)
    counts = [count for _, _, count in header.fields]
    places = [sum(counts[:k]) for k in columns]
    for k, line in enumerate(lines):
        found = len(line.split())
        if found != sum(counts):
            raise InputError(f"point {k} of {header.count:,} has {found} of {sum(counts)} numbers", remedy=_REMEDY)
    if not lines:
        return np.zeros((0, 3))
    return np.loadtxt(lines, np.float64, comments=None, usecols=places, ndmin=2)
