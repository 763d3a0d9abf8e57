"""YAML read into plain values, with the place of every one of them kept."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError

if TYPE_CHECKING:
    import yaml

Loc = tuple[str | int, ...]

# YAML 1.2 reads these; PyYAML's own resolver takes 1e-6 for a text and `no` for False.
_INT = re.compile(r"[-+]?[0-9]+\Z")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?\Z")
_SPECIAL = {
    ".inf": float("inf"),
    "+.inf": float("inf"),
    "-.inf": float("-inf"),
    ".nan": float("nan"),
    "nan": float("nan"),
    "inf": float("inf"),
    "-inf": float("-inf"),
}
_WORDS = {"true": True, "false": False, "null": None, "~": None, "": None}


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong: where (`loc` in the document), what, and possibly the remedy and the valid choices."""

    loc: Loc
    message: str
    remedy: str | None = None
    choices: tuple[str, ...] | None = None
    at_key: bool = False


@dataclass(frozen=True, slots=True)
class Document:
    """A YAML file as plain values (`data`), with the nodes that know their places."""

    path: str
    data: Any
    root: Any
    problems: tuple[Problem, ...]

    def place(self, loc: Loc, at_key: bool = False) -> str:
        """file:line:column of the value at `loc` (or of its key); of its nearest parent that is in the file otherwise."""
        import yaml

        node, mark = self.root, None if self.root is None else self.root.start_mark
        for step in loc:
            if isinstance(node, yaml.MappingNode):
                pair = next((p for p in reversed(node.value) if p[0].value == step), None)
                if pair is None:
                    break
                node, mark = pair[1], (pair[0] if at_key and step == loc[-1] else pair[1]).start_mark
            elif isinstance(node, yaml.SequenceNode) and isinstance(step, int) and step < len(node.value):
                node = node.value[step]
                mark = node.start_mark
            else:
                break
        return self.path if mark is None else f"{self.path}:{mark.line + 1}:{mark.column + 1}"


def read_yaml(path: Path) -> Document:
    """The file as a `Document`; raises InputError if it cannot be read or is no YAML."""
    try:
        text = path.read_text(encoding="utf-8")
    except IsADirectoryError:
        raise InputError("expected a file, got a folder", place=str(path)) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", place=str(path)) from None
    except UnicodeDecodeError as error:
        what = "it is UTF-16" if error.object[:2] in (b"\xff\xfe", b"\xfe\xff") else f"byte {error.start} is not UTF-8"
        remedy = "a scene is a YAML text: save it as UTF-8, or name another file"
        raise InputError(f"cannot be read as text: {what}", place=str(path), remedy=remedy) from None
    return parse_yaml(text, str(path))


def parse_yaml(text: str, path: str) -> Document:
    """`text` as a `Document`; duplicate keys, strange keys and loops are among its problems."""
    import yaml

    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        root = yaml.compose(text, Loader=loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = path if mark is None else f"{path}:{mark.line + 1}:{mark.column + 1}"
        said = ", ".join(s for s in (error.context, error.problem) if s)
        raise InputError(f"not valid YAML: {said}", place=place) from None
    except yaml.YAMLError as error:
        raise InputError(f"not valid YAML: {error}", place=path) from None
    problems: list[Problem] = []
    data = None if root is None else _construct(root, (), problems, {}, set())
    return Document(path, data, root, tuple(problems))


def _construct(node: Any, loc: Loc, problems: list[Problem], done: dict[int, Any], open_: set[int]) -> Any:
    import yaml

    if id(node) in done:  # an alias
        return done[id(node)]
    if isinstance(node, yaml.ScalarNode):
        value = _scalar(node)
    elif id(node) in open_:
        problems.append(Problem(loc, "an alias that contains itself"))
        return None
    elif isinstance(node, yaml.SequenceNode):
        open_.add(id(node))
        value = [_construct(item, (*loc, i), problems, done, open_) for i, item in enumerate(node.value)]
    else:
        open_.add(id(node))
        value = {}
        for key, item in node.value:
            if not isinstance(key, yaml.ScalarNode):
                problems.append(Problem(loc, "expected a word as the key of a field"))
            elif key.value in value:
                problems.append(Problem((*loc, key.value), f"the field {key.value!r} stands here twice", at_key=True))
            else:
                value[key.value] = _construct(item, (*loc, key.value), problems, done, open_)
    open_.discard(id(node))
    done[id(node)] = value
    return value


def _scalar(node: yaml.ScalarNode) -> Any:
    text = node.value
    if node.style in ("'", '"', "|", ">") or (node.tag == "tag:yaml.org,2002:str" and _plain_text(text)):
        return text
    low = text.lower()
    if low in _WORDS:
        return _WORDS[low]
    if low in _SPECIAL:
        return _SPECIAL[low]
    if _INT.match(text):
        return int(text)
    if _FLOAT.match(text):
        return float(text)
    return text


def _plain_text(text: str) -> bool:
    low = text.lower()
    return not (low in _WORDS or low in _SPECIAL or _INT.match(text) or _FLOAT.match(text))
