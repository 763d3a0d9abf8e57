"""MoveIt problems in files: a scene with its request, folders and archives of them, and how one of them is named."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..numeric import file_path
from ._moveit import MoveItProblem, problem_of
from ._yaml import Document, parse_yaml, read_yaml

ARCHIVES = (".tar", ".tar.gz", ".tar.bz2", ".tar.xz")
SCENE_FIELDS = (
    "world",
    "robot_state",
    "robot_model_name",
    "allowed_collision_matrix",
    "fixed_frame_transforms",
    "is_diff",
)
REQUEST_FIELDS = (
    "goal_constraints",
    "start_state",
    "workspace_parameters",
    "planner_id",
    "group_name",
    "path_constraints",
)
_FILE = re.compile(r"scene(.*)\.ya?ml\Z")


def is_moveit(data: Any) -> bool:
    """Whether the content of a YAML file is that of a MoveIt planning scene or request."""
    ours = isinstance(data, dict) and any(str(key).startswith("horosphere/") for key in data)
    return isinstance(data, dict) and not ours and any(key in data for key in (*SCENE_FIELDS, *REQUEST_FIELDS))


def names_moveit(text: str | Path) -> bool:
    """Whether this is the path of a MoveIt file, or a problem in an archive."""
    path, name = split(text)
    return bool(name) or is_archive(path) or (path.is_file() and is_moveit(read_yaml(path).data))


def read_moveit(scene: str | Path, request: str | Path | None = None) -> MoveItProblem:
    """One problem from a planning-scene file and its request file (default: `request*` beside `scene*`, if it is there)."""
    path = file_path(scene, "scene")
    return from_document(path, read_yaml(path), request)


def from_document(path: Path, document: Document, request: str | Path | None = None) -> MoveItProblem:
    """`read_moveit` for a scene that was read already."""
    data = document.data
    if isinstance(data, dict) and not any(key in data for key in SCENE_FIELDS) and is_moveit(data):
        raise InputError(
            "this is a motion-plan request, expected its planning scene",
            place=str(path),
            remedy="name the scene's file; this one is its `request`",
        )
    if request is None and _FILE.match(path.name):
        beside = path.with_name(path.name.replace("scene", "request", 1))
        request = beside if beside.is_file() else None
    return problem_of(path.stem, document, None if request is None else read_yaml(Path(request)))


def read_moveit_set(path: str | Path) -> Iterator[tuple[str, MoveItProblem]]:
    """(set, problem) for all `scene*.yaml` with their `request*.yaml` under a folder or in a .tar(.gz, .bz2, .xz), in order.

    The set is the name of the folder that holds the files. Raises InputError (file:line:column) at the first bad one.
    """
    place = Path(path)
    if place.is_file() and place.suffix in (".yaml", ".yml"):
        yield place.parent.name, read_moveit(place)
        return
    found = ProblemSet.read(place)
    for file in found.scenes.values():
        yield file.rpartition("/")[0].rpartition("/")[2], found.problem(file)


def split(text: str | Path) -> tuple[Path, str]:
    """The path and the problem's name of PATH:SET/NUMBER; a path without a name gives ""."""
    whole = file_path(text, "path").expanduser()
    head, colon, name = str(text).rpartition(":")
    if colon and name and not whole.exists():
        path = Path(head).expanduser()
        if path.exists() or is_archive(path):
            return path, name
    return whole, ""


def is_archive(path: Path) -> bool:
    """By its name, or else by what is in it."""
    name = path.name.lower()
    if any(name.endswith((ending, ending.replace("tar.", "t"))) for ending in ARCHIVES):
        return True
    import tarfile

    return path.is_file() and path.suffix.lower() not in (".yaml", ".yml") and tarfile.is_tarfile(path)


@dataclass(frozen=True, slots=True)
class ProblemSet:
    """The YAML files of a folder or an archive, not parsed; `scenes`: of each problem by its name SET/NUMBER, in order."""

    place: str
    files: dict[str, Path | bytes]
    scenes: dict[str, str]

    @staticmethod
    def read(path: Path) -> ProblemSet:
        """Raises InputError for what is not there, no archive, or without scenes."""
        files: dict[str, Path | bytes]
        if path.is_dir():
            files = {p.relative_to(path).as_posix(): p for p in path.rglob("*") if p.suffix in (".yaml", ".yml")}
        elif path.is_file():
            files = dict(_unpacked(path))
        else:
            raise InputError("no such file or folder", place=str(path))
        scenes = sorted(name for name in files if _FILE.match(name.rpartition("/")[2]))
        if not scenes:
            raise InputError(
                "no scene*.yaml in it",
                place=str(path),
                remedy="expected MoveIt planning scenes, as in MotionBenchMaker",
            )
        short = [_name(file) for file in scenes]
        names = short if len(set(short)) == len(short) else [file.rpartition(".")[0] for file in scenes]
        return ProblemSet(str(path), files, dict(zip(names, scenes)))

    @property
    def sets(self) -> dict[str, list[str]]:
        """The numbers of the problems in each set."""
        found: dict[str, list[str]] = {}
        for name in self.scenes:
            folder, _, number = name.rpartition("/")
            found.setdefault(folder, []).append(number)
        return found

    def problem(self, file: str, request: str | Path | None = None) -> MoveItProblem:
        """That of a scene file, with another request file than the one beside it if one is given."""
        folder, slash, name = file.rpartition("/")
        beside = folder + slash + name.replace("scene", "request", 1)
        wanted = self._document(beside) if request is None and beside in self.files else None
        wanted = wanted if request is None else read_yaml(Path(request))
        return problem_of(name.rpartition(".")[0], self._document(file), wanted)

    def find(self, name: str) -> str:
        """The full name of a problem: SET/NUMBER as listed, where an unmistakable beginning of SET will do; or its file's name.

        Raises InputError with what there is, and what is like it.
        """
        for full, file in self.scenes.items():
            if name in (full, file) or (not name and len(self.scenes) == 1):
                return full
        sets, how = self.sets, "name one as PATH:SET/NUMBER; `horosphere scenes PATH` lists them"
        folder, _, number = name.rstrip("/").rpartition("/")
        if not folder and any(each.startswith(number) for each in sets):
            folder, number = number, ""
        folder = folder.rpartition("/")[2]
        if not folder and folder not in sets:
            what = f"{name!r} names no set" if name else f"there are {len(self.scenes)} problems"
            raise InputError(what, place=self.place, choices=sets, remedy=how)
        like = [folder] if folder in sets else [each for each in sets if each.startswith(folder)]
        if not like:
            near = get_close_matches(folder, sets, n=3, cutoff=0.4)
            remedy = f"did you mean {' or '.join(map(repr, near))}?" if near else how
            raise InputError(f"unknown set {folder!r}", place=self.place, choices=sets, remedy=remedy)
        if len(like) > 1:
            raise InputError(f"{folder!r} may be several sets", place=self.place, choices=like, remedy=how)
        return "/".join(filter(None, (like[0], self._number(like[0], number, how))))

    def _number(self, folder: str, given: str, how: str) -> str:
        """The one of a set that is meant: 1 and scene0001.yaml are 0001."""
        numbers = self.sets[folder]
        plain = re.sub(r"\A(?:scene|request)|\.ya?ml\Z", "", given)
        same = [
            each
            for each in numbers
            if each == plain or (plain.isdigit() and each.isdigit() and int(each) == int(plain))
        ]
        if len(same) == 1:
            return same[0]
        near = [] if plain.isdigit() else get_close_matches(plain, numbers, n=3, cutoff=0.5)  # numbers are not misspelt
        raise InputError(
            f"no problem {given!r} in {folder!r}" if given else f"{folder!r} is a set of {len(numbers)} problems",
            place=self.place,
            choices=numbers if len(numbers) < 9 else (f"{numbers[0]} to {numbers[-1]}",),
            remedy=f"did you mean {' or '.join(map(repr, near))}?" if near else how,
        )

    def _document(self, file: str) -> Document:
        content = self.files[file]
        if isinstance(content, Path):
            return read_yaml(content)
        place = f"{self.place}/{file}"
        try:
            return parse_yaml(content.decode("utf-8"), place)
        except UnicodeDecodeError as error:
            raise InputError(f"cannot be read: {error}", place=place) from None


def _name(file: str) -> str:
    """SET/NUMBER of a scene file in the folder SET."""
    folder, _, name = file.rpartition("/")
    match = _FILE.match(name)
    assert match is not None
    return f"{folder.rpartition('/')[2]}/{match[1] or 'scene'}".lstrip("/")


def _unpacked(path: Path) -> Iterator[tuple[str, bytes]]:
    import tarfile

    try:
        # read in the order of the archive: seeking back in a compressed one would unpack it again each time
        with tarfile.open(path) as archive:
            for member in archive:
                if member.isfile() and member.name.endswith((".yaml", ".yml")):
                    yield member.name, archive.extractfile(member).read()  # type: ignore[union-attr]
    except (tarfile.TarError, EOFError, OSError) as error:
        raise InputError(
            f"not a readable archive: {str(error).splitlines()[0]}", place=str(path), choices=ARCHIVES
        ) from None
