"""The command line."""


def main() -> None:
    """Entry point of `horosphere`."""
    import sys

    from ._app import main as run

    sys.exit(run())
