"""`horosphere scenes`: the built-in scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from . import _output as out


def scenes(
    name: str | None = None,
    /,
    *,
    out_file: Annotated[Path | None, Parameter(name="--out")] = None,
    force: bool = False,
    json: bool = False,
) -> int:
    """Lists the built-in scenes, or prints or copies out one of them.

    Example: `horosphere scenes humanoid-reach --out my-scene.yaml`

    Parameters
    ----------
    name
        A built-in scene; without it all of them are listed.
    out_file
        Where to copy it; printed without.
    force
        Write over a file that exists.
    json
        Print as JSON.
    """
    from ..errors import InputError
    from ..scenes import library_path, names
    from ..scenes._yaml import read_yaml

    if name is None:
        found = {}
        for each in names():
            data = read_yaml(library_path(each)).data
            found[each] = " ".join(str(data.get("description") or "").split())
        if json:
            out.print_json(found)
        else:
            out.print_rows(found.items())
        return out.DONE
    text = library_path(name).read_text(encoding="utf-8")
    if out_file is not None:
        if out_file.exists() and not force:
            raise InputError("the file exists already", place=str(out_file), remedy="another name, or --force")
        from ..io import output_folder, writing

        output_folder(out_file.parent)
        with writing(out_file) as file:
            file.write(text)
    if json:
        out.print_json({"name": name, "text": text, "written": out_file})
    elif out_file is not None:
        out.print_rows([("Written", out_file)])
    else:
        out.console().print(out.plain_text(text.rstrip()))
    return out.DONE
