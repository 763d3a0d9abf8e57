"""From pydantic's findings to sentences with a place: every problem of a file in one error."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, TypeVar

from ..errors import InputError
from ._yaml import Document, Loc, Problem

if TYPE_CHECKING:
    from ._schema import Section

S = TypeVar("S", bound="Section")


class SceneError(InputError):
    """Everything that is wrong with one file; `errors` holds one InputError per problem, in the order of the file."""

    def __init__(self, errors: Iterable[InputError]) -> None:
        self.errors = tuple(errors)
        first = self.errors[0]
        super().__init__(first.message, place=first.place, remedy=first.remedy, choices=first.choices)
        self.args = ("\n".join(str(error) for error in self.errors),)

    def __reduce__(self):
        return SceneError, (self.errors,)


class Reader:
    """Validates the sections of one document and collects what is wrong, and what one should know (`notes`)."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.problems = list(document.problems)
        self.notes: list[str] = []

    def fail(
        self, loc: Loc, message: str, remedy: str | None = None, choices: Iterable[str] | None = None, at_key=False
    ):
        """Notes one problem; returns None, so that a reading function can end with it."""
        self.problems.append(Problem(loc, message, remedy, None if choices is None else tuple(choices), at_key))

    def unknown(self, loc: Loc, kind: str, name: object, choices: Iterable[str], at_key: bool = False) -> None:
        """Notes a name that is not among `choices`."""
        valid = tuple(sorted(choices))
        self.fail(loc, f"unknown {kind} {name!r}", _nearest(str(name), valid), valid, at_key)

    def caught(self, loc: Loc, error: InputError) -> None:
        """Notes an error of a lower layer, with its place put behind the message."""
        for one in getattr(error, "errors", (error,)):
            inside = f"{one.place}: " if one.place and not one.place.startswith(self.document.path) else ""
            self.fail(loc, inside + one.message, one.remedy, one.choices)

    def section(self, model: type[S], data: Any, loc: Loc, also: tuple[str, ...] = ()) -> S | None:
        """`data` as `model`, or None with the problems noted; `also`: names that are fields here too."""
        import pydantic

        if not isinstance(data, dict):
            return self.fail(loc, f"expected fields ({', '.join(model.model_fields)}), got {_shown(data)}")
        before = len(self.problems)
        result = None
        try:
            result = model.model_validate(data)
        except pydantic.ValidationError as error:
            for item in error.errors(include_url=False, include_context=True):
                self._finding(model, loc, item, also)
        for group in (*model.one_of, *model.at_most_one):
            given = [name for name in group if data.get(name) is not None]
            if len(given) > 1:
                self.fail((*loc, given[1]), f"{_and(given)} exclude each other", "keep one of them", at_key=True)
            elif not given and group in model.one_of:
                self.fail(loc, f"missing field {' or '.join(repr(name) for name in group)}")
        return result if len(self.problems) == before else None

    def look(self, model: type[S], data: Any, loc: Loc, also: tuple[str, ...] = ()) -> None:
        """Notes what is wrong with fields of which nothing can be made, but their `type` or `mechanism`, which is noted already."""
        noted = {(*loc, "type"), (*loc, "mechanism")}
        before = len(self.problems)
        self.section(model, data, loc, also)
        self.problems[before:] = [problem for problem in self.problems[before:] if problem.loc not in noted]

    def _finding(self, model: type[S], loc: Loc, item: Mapping[str, Any], also: tuple[str, ...]) -> None:
        inner = tuple(step for step in item["loc"] if not str(step).startswith("<"))  # <...>: a form, see _schema
        kind, value, limits = item["type"], item["input"], item.get("ctx", {})
        at = (*loc, *inner)
        if kind == "missing":
            return self.fail(loc + inner[:-1], f"missing field {inner[-1]!r}")
        if kind == "extra_forbidden":
            return self.unknown(at, "field", inner[-1], (*model.model_fields, *also), at_key=True)
        if kind == "literal_error":
            choices = [text.strip("' ") for text in limits["expected"].replace(" or ", ",").split(",")]
            return self.fail(at, f"unknown value {value!r}", _nearest(str(value), tuple(choices)), choices)
        self.fail(at, f"expected {_expected(kind, limits, item['msg'])}, got {_got(kind, value)}")

    def finish(self) -> None:
        """Raises SceneError if anything was noted."""
        if self.problems:
            found = {}
            for p in self.problems:
                place = self.document.place(p.loc, p.at_key)
                found.setdefault((place, p.message), (p, place))
            errors = [
                InputError(_named(p), place=place, remedy=p.remedy, choices=p.choices) for p, place in found.values()
            ]
            raise SceneError(sorted(errors, key=lambda e: _position(e.place or "")))


def _position(place: str) -> tuple[int, int]:
    parts = place.rsplit(":", 2)
    return (int(parts[1]), int(parts[2])) if len(parts) == 3 and parts[1].isdigit() and parts[2].isdigit() else (0, 0)


def _named(problem: Problem) -> str:
    path = ""
    for step in problem.loc:
        path += f"[{step}]" if isinstance(step, int) else f".{step}" if path else step
    return f"{path}: {problem.message}" if path else problem.message


def _nearest(name: str, choices: tuple[str, ...]) -> str | None:
    near = get_close_matches(name, choices, n=2, cutoff=0.5)
    return f"did you mean {' or '.join(repr(n) for n in near)}?" if near else None


def likely(name: object, choices: Iterable[str]) -> str | None:
    """The choice that a name means if it is misspelt, None if that is in doubt; the name itself if it is one of them."""
    near = get_close_matches(name, tuple(choices), n=1, cutoff=0.7) if isinstance(name, str) else []
    return near[0] if near else None


def _and(names: list[str]) -> str:
    return " and ".join(repr(name) for name in names)


def _expected(kind: str, limits: Mapping[str, Any], message: str) -> str:
    if kind in ("float_type", "float_parsing", "finite_number"):
        return "a finite number" if kind == "finite_number" else "a number"
    if kind in ("int_type", "int_from_float", "int_parsing"):
        return "a whole number"
    for name, sign in (("gt", ">"), ("ge", ">="), ("lt", "<"), ("le", "<=")):
        if name in limits and kind.startswith(("greater", "less")):
            return f"a number {sign} {limits[name]:g}"
    if kind == "too_short":
        return f"at least {limits['min_length']} items"
    if kind == "too_long":
        return f"at most {limits['max_length']} items"
    if kind == "union_tag_invalid":
        forms = (
            limits["expected_tags"].replace("'", "").replace("<", "a ").replace(">", "").replace("a fields", "fields")
        )
        return forms.replace("a list", "a list of numbers").replace(", ", " or ")
    plain = {
        "string_type": "a text",
        "bool_type": "true or false",
        "list_type": "a list of numbers",
        "dict_type": "fields",
    }
    return plain.get(kind, message[0].lower() + message[1:])


def _got(kind: str, value: Any) -> str:
    return f"{len(value)}" if kind in ("too_short", "too_long") else _shown(value)


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return "fields"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if value is None:
        return "nothing"
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
