"""`python -m horosphere`."""

from .cli import main

main()
