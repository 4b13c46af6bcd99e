"""Tables in a terminal: as wide as it has room for."""

from collections.abc import Sequence

from rich import box
from rich.console import Console, Group
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.tables.sheet import Cell
from hhrl_bench.tables.success import contestants, notes, success_cell
from hhrl_bench.text import NONE, WIDTH, folded


def print_overview(console: Console, board: LeaderboardRecord) -> None:
    """Return nothing; print the success on every task, or on the first ones that the console has room for."""
    tables = [_table(board, len(board.tasks), intervals=True)]
    tables += [_table(board, count, intervals=False) for count in range(len(board.tasks), 0, -1)]
    print_widest(console, tables)


def _table(board: LeaderboardRecord, count: int, *, intervals: bool) -> Table:
    tasks, width = board.tasks[:count], WIDTH if intervals else 12
    episodes = " or ".join(dict.fromkeys(f"{task.episodes:,}" for task in tasks))
    table = ruled_table(f"Success, {episodes} test episodes a task", intervals=intervals)
    more = "95% intervals" if count == len(board.tasks) else "95% intervals and more tasks"
    of_intervals, *others = notes(tasks, [board])
    said = [of_intervals, *others] if intervals else [*others, f"A wider terminal shows {more}."]
    table.caption, table.caption_justify = "\n".join(said), "left"
    table.add_column("agent", overflow="fold", max_width=width, vertical="top")
    for task in tasks:
        table.add_column(folded(task.id, 12 if intervals else 9), justify="right", no_wrap=True)
    for name, own in contestants(board).items():
        cells = (success_cell(own.get(task.id)) for task in tasks)
        table.add_row(Text(folded(name, width)), *(cell_text(cell, intervals=intervals) for cell in cells))
    return table


BOUNDLESS = 1000


def print_widest(console: Console, tables: Sequence[Table | Group], *, wrapped: bool = False) -> int:
    """Return the place of the table printed: the first that the console has room for; if none, the last.

    With ``wrapped`` there is room for one whose cells are wrapped between words.
    """
    boundless = console.options.update(max_width=BOUNDLESS)
    sizes = (Measurement.get(console, boundless, table) for table in tables)
    widths = (size.minimum if wrapped else size.maximum for size in sizes)
    place = next((place for place, width in enumerate(widths) if width <= console.width), len(tables) - 1)
    console.print(tables[place])
    return place


def ruled_table(title: str, *, intervals: bool) -> Table:
    """Return an empty table with rules between its parts alone; with ``intervals`` its columns stand further apart."""
    return Table(
        title=title,
        box=box.HORIZONTALS,
        show_edge=False,
        padding=(0, 1 if intervals else 0),
        collapse_padding=True,
        pad_edge=False,
        title_justify="left",
    )


def cell_text(cell: Cell, *, intervals: bool) -> Text:
    """Return a cell as text, its bounds on a line below where ``intervals`` are shown."""
    text = Text(cell.value or NONE)
    return text.append(f"\n{cell.bounds}", style="dim") if intervals and cell.bounds else text
