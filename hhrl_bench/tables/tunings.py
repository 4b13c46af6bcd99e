"""The table of what a search for the numbers of an agent has found: a row for each number, a column for each set."""

from hhrl_agents.rules.tuning import bounds
from hhrl_bench.tables.table import Cell, Column, Group, Note, Row, Table, TerminalFit
from hhrl_bench.tuning.tune import TuningRecord

_SHARE = "1"


def tunings_table(record: TuningRecord) -> Table:
    """Return the numbers with their units, and how good and how dear they were."""
    sets = list(record.sets.values())
    numbers = Group(
        "",
        tuple(_row(_named(name, one.unit), [f"{s.tuning[name]:.3f}" for s in sets]) for name, one in bounds().items()),
    )
    search = Group(
        "search",
        (
            _row("score", [f"{one.score:.3f}" for one in sets]),
            _row("episodes of each task", [f"{one.episodes:,}" for one in sets]),
            _row("candidates", [f"{one.candidates:,}" for one in sets]),
            _row("environment steps", [f"{one.env_steps:,}" for one in sets]),
        ),
    )
    columns = tuple(Column(name, priority=-place) for place, name in enumerate(record.sets))
    note = Note("The score is the mean over training worlds that the search had not seen before.")
    return Table(record.agent, "", columns, (numbers, search), (note,), fit=TerminalFit(intervals=None))


def _named(name: str, unit: str) -> str:
    return name if unit == _SHARE else f"{name}, {unit}"


def _row(name: str, values: list[str]) -> Row:
    return Row(name, tuple(Cell(value) for value in values))
