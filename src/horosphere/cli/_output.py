"""How commands speak: results on standard output, progress and errors on standard error, JSON where it is asked for."""

from __future__ import annotations

import json
import re
import sys
import threading
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from typing import Any

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
PATIENCE = 1.0
"""Seconds after which a command says what it is doing."""


def shown_default(value: Any) -> str | None:
    """A default as --help shows it: numbers, words and paths; switches and empty lists speak for themselves."""
    return None if value is None or isinstance(value, bool | tuple | list) else str(value)


def console(stderr: bool = False) -> Any:
    """A rich console; plain text where the output is no terminal."""
    from rich.console import Console

    class Plain(Console):
        def on_broken_pipe(self) -> None:  # rich would end the program here, with exit code 1
            raise BrokenPipeError

    stream = sys.stderr if stderr else sys.stdout
    width = None if stream.isatty() else 110
    return Plain(stderr=stderr, highlight=False, soft_wrap=not stream.isatty(), width=width)


def print_json(value: Any) -> None:
    """One JSON document on standard output."""
    from ..io import to_json

    sys.stdout.write(to_json(value) + "\n")


def print_rows(rows: Any, title: str | None = None) -> None:
    """Two columns: label and value."""
    from rich.table import Table

    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0), title=title, title_justify="left")
    table.add_column(style="dim", no_wrap=True)
    table.add_column(overflow="fold")
    for label, value in rows:
        table.add_row(str(label), plain_text(value))
    print_table(table)


def print_table(table: Any, wide: bool = False) -> None:
    """A table without the blanks that rich fills its lines with; `wide`: in a file or a pipe its lines may be long."""
    screen = console()
    if wide and not screen.is_terminal:
        screen.width = 200
    if screen.is_terminal:
        screen.print(table)
        return
    with screen.capture() as captured:
        screen.print(table)
    sys.stdout.write("".join(line.rstrip() + "\n" for line in captured.get().splitlines()))


def plain_text(value: Any) -> Any:
    """Text that rich prints as it is, brackets included."""
    from rich.text import Text

    return Text(str(value))


def print_verdict(text: str, good: bool) -> None:
    """The first line of a result."""
    from rich.text import Text

    console().print(Text(text, style="bold green" if good else "bold red"))


def print_notes(notes: Any, stderr: bool = False) -> None:
    """Remarks, one a line."""
    for note in notes:
        console(stderr).print(plain_text(f"note: {note}"))


def print_error(error: BaseException, as_json: bool, options: Collection[str] = ()) -> None:
    """One message per problem on standard error; as JSON on standard output where that was asked for.

    `options`: names of the command's options, as Python writes them; where a message names one, it is said as on a command line.
    """
    errors = [_spoken(e, options) for e in getattr(error, "errors", None) or (error,)]
    if as_json:
        items = [
            {
                "message": getattr(e, "message", str(e)),
                "place": getattr(e, "place", None),
                "remedy": getattr(e, "remedy", None),
                "choices": getattr(e, "choices", None),
            }
            for e in errors
        ]
        sys.stdout.write(json.dumps({"error": "\n".join(map(str, errors)), "errors": items}, indent=2) + "\n")
    out = console(stderr=True)
    for e in errors:
        out.print("[bold red]error:[/] ", plain_text(e), sep="")


def _spoken(error: BaseException, options: Collection[str]) -> BaseException:
    """The error with `link_radius` and link_radius=... written as --link-radius."""
    from ..errors import InputError

    def said(text: str | None) -> str | None:
        if text is None:
            return None
        known = "|".join(map(re.escape, options))
        return (
            re.sub(rf"`({known})`|\b({known})=(?=[\s,;)]|$)", lambda m: option(m[1] or m[2]), text) if known else text
        )

    if not isinstance(error, InputError):
        return error
    place = error.place
    if place is not None and place in options:
        place = option(place)
    return InputError(said(error.message) or "", place=place, remedy=said(error.remedy), choices=error.choices)


def option(name: str) -> str:
    """A keyword as it is written on a command line."""
    return "--" + name.replace("_", "-")


class Working:
    """Says on standard error what a command is doing, once it takes longer than a second."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._lock = threading.Lock()
        self._started = time.monotonic()
        self._status: Any = None
        self._said = ""
        self._done = False
        self._timer: threading.Timer | None = None
        self._console = console(stderr=True)

    @property
    def is_terminal(self) -> bool:
        """Is there somebody who sees a line change?"""
        return bool(self._console.is_terminal)

    def start(self) -> None:
        self._timer = threading.Timer(PATIENCE, self._show)
        self._timer.daemon = True
        self._timer.start()

    def update(self, what: str) -> None:
        """From now on something else is being done."""
        with self._lock:
            self._what = what
        if time.monotonic() - self._started > PATIENCE:
            self._show()

    def note(self, what: str) -> None:
        """A line that stays."""
        with self._lock, suppress(OSError):
            self._console.print(plain_text(f"note: {what}"))

    def stop(self) -> None:
        with self._lock:
            self._done = True
            if self._timer is not None:
                self._timer.cancel()
            if self._status is not None:
                self._status.stop()

    def _show(self) -> None:
        with self._lock:
            if self._done or self._said == self._what:
                return
            self._said = self._what
            with suppress(OSError):  # nobody may be listening: that is no reason to stop
                self._say()

    def _say(self) -> None:
        if not self._console.is_terminal:
            self._console.print(plain_text(f"{self._what} ..."))
        elif self._status is None:
            self._status = self._console.status(plain_text(self._what))
            self._status.start()
        else:
            self._status.update(plain_text(self._what))


@contextmanager
def working(what: str) -> Iterator[Working]:
    """Progress for anything that may take over a second; machine code that is compiled on the way is announced too."""
    progress = Working(what)
    progress.start()
    try:
        yield progress
    finally:
        progress.stop()


_compiling: list[Working] = []
_heard: list[str] = []
_lost: list[str] = []


def announce_compiling(progress: Working) -> None:
    """Tells when kernels are being compiled, which happens once a machine and takes a few seconds."""
    from ..kernels import on_compile

    if not _compiling:
        on_compile(_compiled)
    _compiling[:] = [progress]


def _compiled(name: str) -> None:
    from ..kernels import cache_folder, is_cache_writable

    if not _heard and not is_cache_writable():
        _lost.append(name)
        place = cache_folder()
        _compiling[0].note(
            f"{place} cannot be written: kernels are compiled anew each time (HOROSPHERE_CACHE names the folder)"
        )
    _heard.append(name)
    if len(_heard) > 1 and not _compiling[0].is_terminal:
        return  # where lines stay, once is enough
    what = "compiling kernels"
    what += "" if _lost else " (once on this machine, then they come from the disk)"
    if _compiling[0].is_terminal:
        what += f": {len(_heard)}, {name.strip('_').replace('_', ' ')}"
    _compiling[0].update(what)


def compiled_names() -> tuple[str, ...]:
    """What was compiled since the program started."""
    return tuple(_heard)


def flush() -> None:
    """Lets a reader at the other end of a pipe see what was printed so far."""
    sys.stdout.flush()
