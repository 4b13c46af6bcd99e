"""What a calibration publishes: the parameters that it found, and the residuals of a world from Table I."""

from typing import Annotated, Literal

from pydantic import Field

from hhrl_bench.records import Count, Finite, Name, Positive, ProvenanceRecord, Record, Sha256


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
