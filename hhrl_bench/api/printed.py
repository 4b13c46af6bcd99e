"""Tables as text, as a notebook and ``print`` show them."""

import io
import os
import shutil
import sys
from collections.abc import Sequence

from rich.console import Console

from hhrl_bench.tables.markdown import markdown_table
from hhrl_bench.tables.table import Table
from hhrl_bench.tables.terminal import print_table
from hhrl_bench.text import PLAIN_WIDTH


class Printed:
    """What shows its tables when it is printed, in a notebook as Markdown."""

    def tables(self) -> Sequence[Table]:
        """Return the tables."""
        raise NotImplementedError

    def __str__(self) -> str:
        return "\n".join(map(as_text, self.tables()))

    def __repr__(self) -> str:
        return str(self)

    def _repr_markdown_(self) -> str:
        titled = (table._replace(title=table.full_title or table.title) for table in self.tables())
        return "\n\n".join(block for table in titled for block in markdown_table(table, "###"))


class Shown(Printed):
    """One table, which prints as the command line prints it."""

    def __init__(self, table: Table) -> None:
        self.table = table

    def tables(self) -> Sequence[Table]:
        """Return the table."""
        return [self.table]


def as_text(table: Table) -> str:
    """Return a table as the command line prints it: as wide as the terminal, or wide enough for any."""
    known = sys.stdout.isatty() or "COLUMNS" in os.environ
    width = shutil.get_terminal_size().columns if known else PLAIN_WIDTH
    text = io.StringIO()
    print_table(Console(file=text, width=width, markup=False, emoji=False), table)
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())
