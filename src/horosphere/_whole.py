"""Is a mesh or a cloud file as long as its own header says? Libraries read what is there of a file that was cut off."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass

import numpy as np

from .errors import InputError

_REMEDY = "the file was cut off or is damaged: copy or export it again"
_KINDS = ("char", "uchar", "short", "ushort", "int", "uint", "float", "double")
_BITS = ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64")
_CODES: dict[str, str] = dict(zip((*_KINDS, *_BITS), 2 * ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")))
_SIZES = {name: int(code[1]) for name, code in _CODES.items()}
_PLURALS = {"vertex": "vertices", "face": "faces"}


def require_whole(data: bytes, ending: str) -> None:
    """Raises InputError if a PLY, STL, OFF or OBJ file (`ending` with its dot) holds fewer or more than it says, or ends in the middle
    of something. Files of other formats pass: their readers do not survive a cut."""
    check = {".ply": _ply, ".stl": _stl, ".off": _off, ".obj": _obj}.get(ending.lower())
    if check is not None:
        check(data)


@dataclass(frozen=True, slots=True)
class PlyElement:
    """An element of a PLY header: `properties` are (name, type, type of the count or "" where it is no list)."""

    name: str
    count: int
    properties: tuple[tuple[str, str, str], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Of its properties."""
        return tuple(name for name, _, _ in self.properties)

    def dtype(self, order: str) -> np.dtype:
        """Of a row in a binary file; `order` "<" or ">"; without lists."""
        return np.dtype([(name, order + _CODES[kind]) for name, kind, _ in self.properties])


def ply_header(data: bytes) -> tuple[str, tuple[PlyElement, ...], int]:
    """Format, elements, and where the body begins. Raises InputError if it is no PLY header."""
    if not data.startswith(b"ply"):
        raise InputError("no PLY file: it does not begin with 'ply'")
    end = re.search(rb"^end_header[ \t]*(\r\n|\n|\r)?", data, re.MULTILINE)
    if end is None:
        raise InputError("the PLY header has no end_header", remedy=_REMEDY)
    form, elements = "", []
    for line in re.split(r"\r\n|\n|\r", data[: end.start()].decode("latin-1"))[1:]:
        words = line.split()
        try:
            if words[:1] == ["format"]:
                form = words[1]
            elif words[:1] == ["element"]:
                elements.append((words[1], int(words[2]), []))
            elif words[:2] == ["property", "list"]:
                elements[-1][2].append((words[4], words[3], words[2]))
            elif words[:1] == ["property"]:
                elements[-1][2].append((words[2], words[1], ""))
        except (IndexError, ValueError):
            raise InputError(f"the PLY header has the line {line!r}", remedy=_REMEDY) from None
    for name, _, properties in elements:
        for _, kind, counter in properties:
            if kind not in _CODES or _CODES.get(counter, "u")[0] == "f" or (counter and counter not in _CODES):
                raise InputError(f"the PLY header has a property of {name} of unknown type {kind!r} {counter}".rstrip())
    return form, tuple(PlyElement(name, count, tuple(rest)) for name, count, rest in elements), end.end()


def _ply(data: bytes) -> None:
    form, elements, start = ply_header(data)
    if form == "ascii":
        _ply_lines(data[start:], elements)
    elif form in ("binary_little_endian", "binary_big_endian"):
        _ply_bytes(data, elements, start, "<" if form == "binary_little_endian" else ">")
    else:
        raise InputError(f"PLY format {form!r}", choices=("ascii", "binary_little_endian", "binary_big_endian"))


def _short(element: PlyElement, found: int) -> InputError:
    what = _PLURALS.get(element.name, f"rows of {element.name}")
    return InputError(f"its header says {element.count:,} {what}, it holds {found:,}", remedy=_REMEDY)


def _ply_lines(body: bytes, elements: tuple[PlyElement, ...]) -> None:
    lines = [line for line in body.splitlines() if line and not line.isspace()]
    at = 0
    for element in elements:
        rows = lines[at : at + element.count]
        if len(rows) < element.count:
            raise _short(element, len(rows))
        lists = any(counter for _, _, counter in element.properties)
        for k, row in enumerate(rows):
            words = row.split()
            expected = _list_words(words, element) if lists else len(element.properties)
            if len(words) != expected:
                raise InputError(
                    f"{element.name} {k} of {element.count:,} has {len(words)} of {expected} numbers", remedy=_REMEDY
                )
        at += element.count
    if at < len(lines):
        raise _longer(f"{len(lines) - at:,} lines more than its header says")


def _longer(how: str) -> InputError:
    return InputError(f"it holds {how}", remedy="the header is wrong, or the file was written over a longer one")


def _list_words(words: list[bytes], element: PlyElement) -> int:
    """How many words a row with lists has by its own counts."""
    at = 0
    for _, _, counter in element.properties:
        if counter and at < len(words):
            try:
                at += int(words[at])
            except ValueError:
                return -1
        at += 1
    return at


def _ply_bytes(data: bytes, elements: tuple[PlyElement, ...], at: int, order: str) -> None:
    for element in elements:
        if not any(counter for _, _, counter in element.properties):
            size = element.dtype(order).itemsize
            if at + size * element.count > len(data):
                raise _short(element, (len(data) - at) // max(size, 1))
            at += size * element.count
        elif element.count:
            at = _past_lists(data, element, at, order)
    if data[at:].strip(b"\0 \t\r\n"):
        raise _longer(f"{len(data) - at:,} bytes more than its header says")


def _past_lists(data: bytes, element: PlyElement, at: int, order: str) -> int:
    """Where the rows of an element with lists end: at once where all have the length of the first, else row by row."""
    size, counters = _row(data, element, at, order)
    if size is not None and at + size * element.count <= len(data):
        rows = np.frombuffer(data, np.uint8, size * element.count, at).reshape(element.count, size)
        if all((rows[:, k : k + n] == rows[0, k : k + n]).all() for k, n in counters):
            return at + size * element.count
    for k in range(element.count):
        size, _ = _row(data, element, at, order)
        if size is None:
            raise _short(element, k)
        at += size
    return at


def _row(data: bytes, element: PlyElement, at: int, order: str) -> tuple[int | None, list[tuple[int, int]]]:
    """Bytes of the row at `at`, None if the file ends in it; where in it the counts of its lists stand, and how long they are."""
    place, counters = at, []
    for _, kind, counter in element.properties:
        if not counter:
            place += _SIZES[kind]
            continue
        n = _SIZES[counter]
        if place + n > len(data):
            return None, []
        counters.append((place - at, n))
        place += n + max(int(np.frombuffer(data, order + _CODES[counter], 1, place)[0]), 0) * _SIZES[kind]
    return (place - at if place <= len(data) else None), counters


def _stl(data: bytes) -> None:
    promised = struct.unpack_from("<I", data, 80)[0] if len(data) >= 84 else None
    if promised is not None and len(data) == 84 + 50 * promised:
        return
    if data.lstrip()[:5].lower() == b"solid" and (b"facet" in data[:2000].lower() or len(data) < 84):
        return _stl_text(data.lower())
    if promised is None:
        return  # no header at all: no triangles are found in it
    found = (len(data) - 84) / 50
    held = f"{int(found):,}" if found == int(found) else f"{int(found):,} and a part"
    raise InputError(f"its header says {promised:,} triangles, it holds {held}", remedy=_REMEDY)


def _stl_text(text: bytes) -> None:
    begun, ended = len(re.findall(rb"\bfacet\s+normal\b", text)), len(re.findall(rb"\bendfacet\b", text))
    corners = len(re.findall(rb"\bvertex(?:\s+[-+.\deinaf]+){3}(?=\s)", text))
    if begun != ended or corners != 3 * ended:
        raise InputError(f"{begun:,} facets begin, {ended:,} end, with {corners:,} corners", remedy=_REMEDY)
    if not re.search(rb"\bendsolid\b", text):
        raise InputError(f"no endsolid after {ended:,} facets", remedy=_REMEDY)


def _off(data: bytes) -> None:
    text = re.sub(r"#.*", "", data.decode("latin-1"))
    found = re.match(r"\s*\w*OFF\b", text)
    lines = [line.split() for line in text[found.end() if found else 0 :].splitlines() if line.strip()]
    try:
        vertices, faces = int(lines[0][0]), int(lines[0][1])
    except (IndexError, ValueError):
        raise InputError("no OFF file: no line with the numbers of vertices and faces") from None
    rows = lines[1:]
    for name, count, held in (("vertices", vertices, len(rows)), ("faces", faces, len(rows) - vertices)):
        if held < count:
            raise InputError(f"its header says {count:,} {name}, it holds {max(held, 0):,}", remedy=_REMEDY)
    if len(rows) > vertices + faces:
        raise _longer(f"{len(rows) - vertices - faces:,} lines more than its header says")
    for k, row in enumerate(rows):
        if len(row) < 3 if k < vertices else not row[0].isdigit() or len(row) < 1 + int(row[0]):
            what = f"vertex {k}" if k < vertices else f"face {k - vertices}"
            raise InputError(f"{what} has too few numbers", remedy=_REMEDY)


def _obj(data: bytes) -> None:
    """OBJ files have no counts: what can be told is a line cut short and a face on a vertex that is not there."""
    vertices = len(re.findall(rb"^[ \t]*v[ \t]", data, re.MULTILINE))
    for number, line in enumerate(data.splitlines(), 1):
        words = line.partition(b"#")[0].split()
        if words[:1] == [b"v"] and len(words) < 4:
            raise InputError(f"line {number}: a vertex of {len(words) - 1} numbers", remedy=_REMEDY)
        if words[:1] != [b"f"] or words[-1] == b"\\":
            continue
        if len(words) < 4:
            raise InputError(f"line {number}: a face of {len(words) - 1} vertices", remedy=_REMEDY)
        for word in words[1:]:
            if not _names_one_of(vertices, word.partition(b"/")[0]):
                what = word.decode("latin-1")
                raise InputError(f"line {number}: a face on vertex {what!r} of {vertices:,}", remedy=_REMEDY)


def _names_one_of(vertices: int, index: bytes) -> bool:
    """From 1 on, or from the last one back: -1."""
    try:
        return 0 < abs(int(index)) <= vertices
    except ValueError:
        return False
