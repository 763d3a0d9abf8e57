"""The command `horosphere` and its exit codes."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError, Parameter, UnknownCommandError, UnusedCliTokensError

from . import _output as out
from ._bench import app as bench
from ._check import check
from ._field import field
from ._plan import plan
from ._robot import robot
from ._scenes import scenes
from ._show import show
from ._snake import app as snake
from ._sweep import sweep
from ._warmup import warmup


def _version() -> str:
    from importlib.metadata import version

    return version("horosphere")


def build() -> App:
    """The application with all its commands."""
    app = App(
        name="horosphere",
        help="Robot motion in conformal geometric algebra: from a scene to a certified motion.\n\n"
        "Example: `horosphere plan humanoid-reach`",
        version=_version,
        help_format="markdown",
        result_action="return_value",
        suppress_keyboard_interrupt=False,
        default_parameter=Parameter(negative=(), show_default=out.shown_default),
    )
    for command in (plan, check, field, robot):
        app.command(command)
    app.command(show, usage="Usage: horosphere show [OPTIONS] SCENE [TRAJECTORY]")
    app.command(sweep, usage="Usage: horosphere sweep [OPTIONS] SCENES...")
    app.command(scenes, usage="Usage: horosphere scenes [OPTIONS] [NAME]")
    app.command(warmup)
    app.command(snake)
    app.command(bench)
    return app


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command; returns its exit code: 0 done, 1 not solved or not certified, 2 bad input, 130 interrupted."""
    from ..errors import HorosphereError

    words = list(sys.argv[1:] if arguments is None else arguments)
    as_json = "--json" in words
    try:
        result = build()(words, exit_on_error=False, print_error=False)
        sys.stdout.flush()
    except CycloptsError as error:
        out.print_error(_Usage(_said(error)), as_json)
        return out.BAD_INPUT
    except HorosphereError as error:
        out.print_error(error, as_json, _options(words))
        return out.BAD_INPUT
    except KeyboardInterrupt:
        out.console(stderr=True).print("interrupted; no file was left half written")
        return out.INTERRUPTED
    except BrokenPipeError:  # the reader went away: horosphere scenes | head -1
        return out.DONE
    return result if isinstance(result, int) else out.DONE


def _said(error: CycloptsError) -> str:
    """What is wrong with the words, and what would be right."""
    text = str(error).strip()
    command = " ".join(("horosphere", *(error.command_chain or ())))
    if isinstance(error, UnusedCliTokensError):
        words = ", ".join(map(repr, error.unused_tokens or ()))
        return f"not understood: {words} (`{command} --help` says what the command takes)"
    if isinstance(error, UnknownCommandError) and error.app is not None:
        names = ", ".join(name for name in error.app if not name.startswith("-"))
        word = (error.unused_tokens or [""])[0]
        hint = f" A scene is planned with `horosphere plan {word}`." if word.endswith((".yaml", ".yml")) else ""
        return f"{text.partition(' Available commands')[0]}{hint} Available commands: {names}."
    return text


def _options(words: Sequence[str]) -> list[str]:
    """Names of the options of the command that these words call, as Python writes them."""
    _, apps, _ = build().parse_commands(list(words))
    if apps[-1].default_command is None:
        return []
    arguments = apps[-1].assemble_argument_collection()
    return [name[2:].replace("-", "_") for argument in arguments for name in argument.names if name.startswith("--")]


class _Usage(Exception):
    """A word on the command line that is not understood."""
