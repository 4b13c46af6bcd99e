"""Tables in a terminal, as wide as it has room for, and a leaderboard as such tables."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

from rich import box
from rich.console import Console
from rich.console import Group as Stack
from rich.measure import Measurement
from rich.table import Table as Grid
from rich.text import Text

from hhrl_bench.leaderboard.record import LeaderboardRecord, compared_to_best
from hhrl_bench.tables.comparisons import comparison_tables
from hhrl_bench.tables.learning import efficiency_table, outcome_tables
from hhrl_bench.tables.results import further_tables, results_table, sensitivity_tables
from hhrl_bench.tables.success import spans_tasks, success_table
from hhrl_bench.tables.table import Cell, Note, Row, Table
from hhrl_bench.tables.transfers import transfer_tables
from hhrl_bench.text import NAME_WIDTH, NONE, folded, indented

BOUNDLESS = 1000


def print_leaderboard(console: Console, board: LeaderboardRecord, *, details: bool = False) -> None:
    """Print the results of every task, what agents do across tasks, transfers and trainings.

    With ``details`` also what scores are made of, the worst cases, how far every agent is from the best, and how soon
    methods succeed.
    """
    for task in board.tasks:
        print_table(console, results_table(task, board.on(task)))
    if spans_tasks(board):
        console.print()
        print_table(console, success_table(board.tasks, [board]))
    if details:
        tables = [
            table
            for task in board.tasks
            for table in (*further_tables(task, board.on(task)), *sensitivity_tables(board.sensitivity, task))
        ]
        for title in dict.fromkeys(table.title for table in tables):
            console.print()
            print_tables(console, [table for table in tables if table.title == title])
    if details and (compared := [one for task in board.tasks for one in compared_to_best(board, task)]):
        console.print()
        print_tables(console, comparison_tables(compared))
    if board.transfer:
        print_tables(console, transfer_tables(board.transfer.rows, known=True))
    if board.trainings:
        print_tables(console, outcome_tables(board.trainings))
    if details and board.efficiency:
        console.print()
        print_table(console, efficiency_table(board.efficiency), notes="below")


def print_table(console: Console, table: Table, *, notes: Literal["caption", "below"] = "caption") -> None:
    """Print a table in the widest layout that the console has room for, its notes as wide as the table or below it."""
    shown = layouts(table)
    grids = [grid(table, layout) for layout in shown]
    if notes == "caption":
        for place, one in enumerate(grids):
            one.caption, one.caption_justify = "\n".join(_said([table], shown, place)), "left"
    place = print_widest(console, grids)
    if notes == "below":
        _print_notes(console, _said([table], shown, place))


def print_tables(console: Console, tables: Sequence[Table]) -> None:
    """Print tables of equal columns in the widest layout that the console has room for, the notes of all below them."""
    shown = layouts(tables[0])
    stacks = [Stack(*(part for table in tables for part in (grid(table, layout), ""))) for layout in shown]
    place = print_widest(console, stacks)
    _print_notes(console, _said(tables, shown, place))


def print_widest(console: Console, tables: Sequence[Grid | Stack], *, wrapped: bool = False) -> int:
    """Print the first table that the console has room for, if none the last, and return its place.

    With ``wrapped`` there is room for one whose cells are wrapped between words.
    """
    boundless = console.options.update(max_width=BOUNDLESS)
    sizes = (Measurement.get(console, boundless, table) for table in tables)
    widths = (size.minimum if wrapped else size.maximum for size in sizes)
    place = next((place for place, width in enumerate(widths) if width <= console.width), len(tables) - 1)
    console.print(tables[place])
    return place


class Layout(NamedTuple):
    """What a terminal shows of a table: the columns at these places, with intervals or without, names so wide."""

    columns: tuple[int, ...]
    intervals: bool
    name_width: int


def layouts(table: Table) -> list[Layout]:
    """Return the layouts of a table, from the widest to the narrowest."""
    fit, columns = table.fit, table.columns
    kept = [
        tuple(place for place, column in enumerate(columns) if column.priority >= least)
        for least in sorted({column.priority for column in columns})
    ]
    with_intervals = {"first": kept[:1], "last": kept, None: []}[fit.intervals]
    widest = [Layout(kept[0], intervals=False, name_width=width) for width in fit.name_widths]
    narrower = [Layout(places, intervals=False, name_width=fit.name_widths[-1]) for places in kept[1:]]
    return [*(Layout(places, intervals=True, name_width=NAME_WIDTH) for places in with_intervals), *widest, *narrower]


def grid(table: Table, layout: Layout) -> Grid:
    """Return what a layout shows of a table, with rules between its parts alone."""
    lines = Grid(
        title=table.full_title or table.title,
        box=box.HORIZONTALS,
        show_edge=False,
        padding=(0, 1 if layout.intervals else 0),
        collapse_padding=True,
        pad_edge=False,
        title_justify="left",
    )
    indent = any(group.name and not group.quoted for group in table.groups)
    names = table.names if table.terminal_names is None else table.terminal_names
    lines.add_column(names, overflow="fold", max_width=layout.name_width + 2 * indent, vertical="top")
    for column in (table.columns[place] for place in layout.columns):
        broken = column.wide if layout.intervals else column.narrow
        lines.add_column(column.heading if broken is None else broken, justify="right", no_wrap=True)
    for group in table.groups:
        lines.add_section()
        if group.name:
            lines.add_row(Text(folded(group.name, layout.name_width), style="italic" if group.quoted else "bold"))
        for row in group.rows:
            name = _name(row, layout.name_width, indent=bool(group.name) and not group.quoted)
            cells = (_cell(row.cells[place], intervals=layout.intervals) for place in layout.columns)
            lines.add_row(name, *cells, style="dim" if group.quoted else None)
    return lines


def _name(row: Row, width: int, *, indent: bool) -> Text:
    name = Text(indented(row.name, width) if indent else folded(row.name, width))
    return name.append(f"\n{row.note}", style="dim") if row.note else name


def _cell(cell: Cell, *, intervals: bool) -> Text:
    """Return a cell as text, its bounds on a line below where ``intervals`` are shown."""
    text = Text(NONE if cell.value is None else cell.value)
    return text.append(f"\n{cell.bounds}", style="dim") if intervals and cell.bounds else text


def _said(tables: Sequence[Table], shown: Sequence[Layout], place: int) -> list[str]:
    """Return what is said of tables in the layout at a place: the notes of all, each once, and what is left out."""
    layout, widest = shown[place], shown[0]
    notes = (_note(note, layout) for table in tables for note in table.all_notes)
    lines = [note for note in dict.fromkeys(notes) if note]
    if place > 0:
        lines.append(f"A wider terminal shows {tables[0].fit.wider[layout.columns != widest.columns]}.")
    return lines


def _note(note: Note, layout: Layout) -> str:
    """Return what a note says in a layout, which may be nothing."""
    if note.column is not None and note.column not in layout.columns:
        return ""
    return note.text if layout.intervals or note.without_intervals is None else note.without_intervals


def _print_notes(console: Console, notes: Sequence[str]) -> None:
    console.print("\n".join(notes), style="dim", highlight=False)
