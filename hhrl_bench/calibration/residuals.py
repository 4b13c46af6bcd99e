"""Residuals: how far Rules 1 to 4 are from Table I in a world, cell by cell, as a record and as a table to read."""

import math
from typing import Annotated, Literal

from pydantic import Field

from hhrl_bench.calibration import target
from hhrl_bench.calibration.fit import score
from hhrl_bench.provenance import ProvenanceRecord, provenance
from hhrl_bench.schema import SCHEMA_VERSION, Count, Finite, Name, Positive, Record, Sha256
from hhrl_bench.tables.sheet import COLUMNS, Column
from hhrl_bench.tasks.tasks import TEST
from hhrl_bench.text import NONE
from hhrl_envs import Scenario


class CellRecord(Record):
    """One cell of Table I: the paper's, ours, and the bounds of its bar; null: the cell has none. Rates are shares."""

    agent: Name
    column: Name
    paper: Finite
    ours: Finite
    difference: Finite
    low: Finite | None
    high: Finite | None
    inside: bool | None


class ResidualsRecord(Record):
    """The 36 cells of Rules 1 to 4 over the first ``episodes`` test episodes of a world."""

    schema_version: Literal[1]
    scenario: Name
    spec_hash: Sha256
    test_start: Count
    episodes: Positive
    objective: Finite
    cells: Annotated[tuple[CellRecord, ...], Field(min_length=36, max_length=36)]
    provenance: ProvenanceRecord

    @property
    def holds(self) -> bool:
        """Whether every cell that carries a bar lies inside it."""
        return all(cell.inside is not False for cell in self.cells)


def measure(scenario: Scenario, episodes: int, command: str) -> ResidualsRecord:
    """Return the residuals of a world over its first ``episodes`` test episodes, measured by ``command``.

    Raises:
        SeedError: for a number of episodes that the test seeds cannot serve.
    """
    seeds = TEST.take(episodes)
    ours, paper, (low, high) = score(scenario, seeds), target.paper(), target.bars()
    cells = [
        _cell(row.counterpart, column, paper[i, j].item(), ours[i, j].item(), low[i, j].item(), high[i, j].item())
        for i, row in enumerate(target.ROWS)
        for j, column in enumerate(target.COLUMNS)
    ]
    return ResidualsRecord(
        schema_version=SCHEMA_VERSION,
        scenario=scenario.id,
        spec_hash=scenario.spec_hash,
        test_start=int(seeds[0]),
        episodes=episodes,
        objective=target.objective(ours),
        cells=tuple(cells),
        provenance=provenance(command, {}),
    )


def markdown(record: ResidualsRecord) -> str:
    """Return the residuals as a Markdown page: one line a cell."""
    held = [cell.inside for cell in record.cells if cell.inside is not None]
    lines = [
        f"# Residuals of {record.scenario}",
        "",
        f"Table I's Rules 1 to 4 against ours over {record.episodes:,} test episodes, written by",
        f"`{record.provenance.command}`. {sum(held)} of {len(held)} bars hold: rates within the 95% Wilson interval of",
        "the paper's 100 cases, steps within 20%. The other cells carry no bar.",
        "",
        "| agent | column | paper | ours | difference | bar | inside |",
        "|---|---|---:|---:|---:|---:|---|",
    ]
    return "\n".join([*lines, *map(_line, record.cells)]) + "\n"


def _cell(agent: str, column: str, paper: float, ours: float, low: float, high: float) -> CellRecord:
    barred = not math.isnan(low)
    return CellRecord(
        agent=agent,
        column=column,
        paper=paper,
        ours=ours,
        difference=ours - paper,
        low=low if barred else None,
        high=high if barred else None,
        inside=low <= ours <= high if barred else None,
    )


def _line(cell: CellRecord) -> str:
    column = next(column for column in COLUMNS if column.key == cell.column)
    bar, inside = NONE, NONE
    if cell.low is not None and cell.high is not None:
        bar = f"{_said(column, cell.low)} to {_said(column, cell.high)}"
        inside = "yes" if cell.inside else "no"
    numbers = (_said(column, cell.paper), _said(column, cell.ours), _said(column, cell.difference, "+"))
    return f"| {cell.agent} | {column.heading} | {' | '.join(numbers)} | {bar} | {inside} |"


def _said(column: Column, value: float, sign: str = "") -> str:
    return f"{value * (100.0 if column.percent else 1.0):{sign}.{column.digits}f}" + ("%" if column.percent else "")


class ParametersRecord(Record):
    """The best of ``worlds`` worlds that the search tried, by name, each on ``episodes`` validation episodes."""

    schema_version: Literal[1]
    scenario: Name
    spec_hash: Sha256
    seed: Count
    generations: Positive
    episodes: Positive
    worlds: Positive
    objective: Finite
    parameters: dict[str, Finite]
    provenance: ProvenanceRecord
