"""The terminal that the command line prints on."""

import os

from rich.console import Console

PLAIN_WIDTH = 160


def console() -> Console:
    """Return the console of stdout; wide enough for any table where that is no terminal and COLUMNS is not set."""
    console = Console(markup=False, emoji=False)  # names are text, whatever brackets and colons they hold
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = PLAIN_WIDTH
    return console
