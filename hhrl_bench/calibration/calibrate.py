"""Calibrate: search for the paper's world or take the registered one, score it, and write how far it is from Table I.

Residuals are the differences of Rules 1 to 4 from Table I, cell by cell, as a record and as a page to read.
"""

import math
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from hhrl_agents.atomic_files import require_writable, write_atomically
from hhrl_bench.calibration import space, target
from hhrl_bench.calibration.fit import fit, score
from hhrl_bench.evaluation.metrics import METRICS, Metric
from hhrl_bench.evaluation.results import Update
from hhrl_bench.provenance import ProvenanceRecord, provenance
from hhrl_bench.schema import SCHEMA_VERSION, Count, Finite, Name, Positive, Record, Sha256
from hhrl_bench.tasks.tasks import TEST
from hhrl_bench.text import NONE
from hhrl_envs import Scenario, get_scenario

FIT_EPISODES = 1_200
PARAMETERS, RESIDUALS, PAGE = "parameters.json", "residuals.json", "residuals.md"


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


def search(seed: int, generations: int, episodes: int, folder: Path | None, update: Update) -> ResidualsRecord:
    """Return the residuals of the best world found; write its parameters and its residuals into the folder, if any.

    Raises:
        SeedError, OutputError: before the search, if its outcome could not be scored or written.
    """
    TEST.take(episodes)
    if folder is not None:
        require_writable(folder / PARAMETERS)
    command = f"hhrl-bench calibrate --seed {seed} --generations {generations}"
    found = fit(seed, generations, FIT_EPISODES, update)
    scenario = space.build(found.parameters)
    record = ParametersRecord(
        schema_version=SCHEMA_VERSION,
        scenario=scenario.id,
        spec_hash=scenario.spec_hash,
        seed=seed,
        generations=generations,
        episodes=FIT_EPISODES,
        worlds=found.worlds,
        objective=found.objective,
        parameters=found.parameters,
        provenance=provenance(command, {}),
    )
    if folder is not None:
        _write(record, folder / PARAMETERS)
    return _publish(scenario, episodes, folder, f"{command} --episodes {episodes}")


def check(episodes: int, folder: Path | None) -> ResidualsRecord:
    """Return the residuals of the registered world; write them into the folder, if any."""
    return _publish(
        get_scenario(space.SCENARIO_ID), episodes, folder, f"hhrl-bench calibrate --check --episodes {episodes}"
    )


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


def _publish(scenario: Scenario, episodes: int, folder: Path | None, command: str) -> ResidualsRecord:
    if folder is not None:
        require_writable(folder / RESIDUALS)
    record = measure(scenario, episodes, command)
    if folder is not None:
        _write(record, folder / RESIDUALS)
        write_atomically(folder / PAGE, markdown(record))
    return record


def _write(record: Record, path: Path) -> None:
    write_atomically(path, record.model_dump_json(indent=2) + "\n")


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
    metric, bar, inside = METRICS[cell.column], NONE, NONE
    if cell.low is not None and cell.high is not None:
        bar = f"{_said(metric, cell.low)} to {_said(metric, cell.high)}"
        inside = "yes" if cell.inside else "no"
    numbers = (_said(metric, cell.paper), _said(metric, cell.ours), _said(metric, cell.difference, "+"))
    return f"| {cell.agent} | {metric.heading} | {' | '.join(numbers)} | {bar} | {inside} |"


def _said(metric: Metric, value: float, sign: str = "") -> str:
    scale, unit = (100.0, "%") if metric.is_rate else (1.0, "")
    return f"{value * scale:{sign}.{metric.digits}f}{unit}"
