"""The command line."""


def main() -> None:
    """Entry point of `horosphere`."""
    import os
    import sys
    from contextlib import suppress

    from ._app import main as run

    code = run()
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:  # the reader went away; what is left goes nowhere, and that is no failure
            with suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    sys.exit(code)
