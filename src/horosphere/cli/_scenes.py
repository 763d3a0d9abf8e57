"""`horosphere scenes`: the built-in scenes, and what MoveIt files and archives hold."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from . import _output as out
from ._source import NOTHING, MoveIt


def scenes(
    name: str | None = None,
    /,
    *,
    moveit: MoveIt = NOTHING,
    out_file: Annotated[Path | None, Parameter(name="--out")] = None,
    force: bool = False,
    json: bool = False,
) -> int:
    """Lists the built-in scenes, or prints or copies out one of them; lists MoveIt archives, and turns their scenes into ours.

    Example: `horosphere scenes humanoid-reach --out my-scene.yaml`

    A MoveIt scene needs a robot: `horosphere scenes scene0001.yaml --robot panda.urdf --out mine.yaml` writes mine.yaml and
    mine.robot.yaml.

    Parameters
    ----------
    name
        A built-in scene, a scene file, ARCHIVE:SET/NUMBER; an archive or folder of MoveIt scenes is listed. Without it all
        built-in scenes are.
    out_file
        The file to write that one scene to; printed without.
    force
        Write over files that exist.
    json
        Print as JSON.
    """
    from ..errors import InputError
    from ..scenes import library_path, names
    from ..scenes._moveit_files import ProblemSet, is_archive, split

    if name is None:
        if out_file is not None:
            raise InputError("which scene? --out writes one", place="--out", choices=names())
        return _list_built_in(json)
    place, problem = split(name)
    if not problem and (is_archive(place) or place.is_dir()):
        found = ProblemSet.read(place)
        if out_file is not None:
            first = f"{name}:{next(iter(found.scenes))}"
            raise InputError(
                f"{name} holds {len(found.scenes)} scenes, and --out writes one",
                place="--out",
                remedy=f"name it: `horosphere scenes {first} --robot URDF --out {out_file}`; without --out they are listed",
            )
        return _list_problems(name, found, json)
    if name in names() or not (problem or place.exists()):
        if moveit.given:
            moveit.load(name)  # raises: a scene of ours says all itself
        texts = {"": library_path(name).read_text(encoding="utf-8")}
    else:
        from ..scenes._save import texts_of

        with out.working("reading the scene"):
            loaded = moveit.load(name)
            texts = texts_of(loaded, Path(f"{loaded.name}.yaml") if out_file is None else out_file)
    written = [] if out_file is None else _write(out_file, texts, force)
    if json:
        out.print_json({"name": name, "text": next(iter(texts.values())), "written": out_file})
    elif written:
        out.print_rows([("Written", ", ".join(map(str, written)))])
    else:
        out.console().print(out.plain_text(next(iter(texts.values())).rstrip()))
        out.print_notes([f"{file} is written with --out" for file in list(texts)[1:]], stderr=True)
    return out.DONE


def _write(file: Path, texts: dict[str, str], force: bool) -> list[Path]:
    """The first text, the scene, as `file`, and what belongs to it under its own name in the same folder; all or none."""
    from ..errors import InputError
    from ..io import output_folder, writing, writing_set

    paths = [file, *(file.with_name(name) for name in list(texts)[1:])]
    for path in paths:
        if path.exists() and not force:
            raise InputError("the file exists already", place=str(path), remedy="another name, or --force")
    output_folder(file.parent)
    with writing_set(file.parent, [path.name for path in paths]) as stage:
        for path, text in zip(paths, texts.values()):
            with writing(stage / path.name) as stream:
                stream.write(text)
    return paths


def _list_built_in(json: bool) -> int:
    from ..scenes import library_path, names
    from ..scenes._yaml import read_yaml

    found = {}
    for each in names():
        data = read_yaml(library_path(each)).data
        found[each] = " ".join(str(data.get("description") or "").split())
    if json:
        out.print_json(found)
    else:
        out.print_rows(found.items())
    return out.DONE


def _list_problems(path: str, found: Any, json: bool) -> int:
    if json:
        out.print_json({"place": found.place, "problems": list(found.scenes)})
        return out.DONE
    rows = []
    for name, numbers in found.sets.items():
        some = numbers if len(numbers) < 9 else [f"{numbers[0]} to {numbers[-1]} ({len(numbers)} problems)"]
        rows.append((name or ".", ", ".join(some)))
    out.print_rows(rows)
    out.print_notes([f"`horosphere plan {path}:{next(iter(found.scenes))} --robot URDF` plans the first"])
    return out.DONE
