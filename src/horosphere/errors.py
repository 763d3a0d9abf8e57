"""Errors that name the place, what was expected, and the remedy."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class HorosphereError(Exception):
    """Base of every error that horosphere raises on purpose."""


class InputError(HorosphereError, ValueError):
    """What the caller gave cannot be used; the message says where, why and what to do.

    Attributes, each possibly None: `place` (file:line:column, argument or field), `remedy`, `choices` (the valid ones).
    """

    def __init__(
        self,
        message: str,
        *,
        place: str | None = None,
        remedy: str | None = None,
        choices: Iterable[str] | None = None,
    ) -> None:
        self.message, self.place, self.remedy = message, place, remedy
        self.choices = None if choices is None else tuple(choices)
        text = message if place is None else f"{place}: {message}"
        if self.choices is not None:
            text += f"; valid: {', '.join(self.choices) or 'none'}"
        if remedy is not None:
            text += f" ({remedy})"
        super().__init__(text)

    def __reduce__(self):
        return _rebuild, (type(self), self.message, self.place, self.remedy, self.choices)


def _rebuild(cls, message, place, remedy, choices):
    return cls(message, place=place, remedy=remedy, choices=choices)


def unknown_name(kind: str, name: object, choices: Iterable[str], place: str | None = None) -> InputError:
    """The error for a name that is not among `choices`, with the nearest ones suggested."""
    valid = sorted(choices)
    near = get_close_matches(name, valid, n=3, cutoff=0.5) if isinstance(name, str) else []
    remedy = f"did you mean {' or '.join(repr(n) for n in near)}?" if near else None
    return InputError(f"unknown {kind} {name!r}", place=place, remedy=remedy, choices=valid)
