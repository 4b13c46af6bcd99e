"""Residuals: how far Rules 1 to 4 are from Table I in a world, cell by cell, as a record and as a table to read."""

import math

from hhrl_bench import calibration_target as target
from hhrl_bench.calibration import score
from hhrl_bench.calibration_records import CellRecord, ResidualsRecord
from hhrl_bench.cells import COLUMNS, NONE, Column
from hhrl_bench.provenance import provenance
from hhrl_bench.records import SCHEMA_VERSION
from hhrl_bench.tasks import TEST
from hhrl_envs import Scenario


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
