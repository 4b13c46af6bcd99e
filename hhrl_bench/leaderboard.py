"""Leaderboards: a suite's results, built, written whole, and read back strictly."""

import json
import time
from collections.abc import Iterator
from pathlib import Path

from pydantic import ValidationError
from pydantic.json_schema import GenerateJsonSchema

from hhrl_agents.files import write_atomically
from hhrl_bench.errors import RecordError
from hhrl_bench.loading import load_agents
from hhrl_bench.provenance import provenance
from hhrl_bench.records import SCHEMA_VERSION, LeaderboardRecord, first_problem
from hhrl_bench.results import BOOTSTRAP_SEED, TimedResult, evaluate_agent, task_record, wall_seconds
from hhrl_bench.statistics import CONFIDENCE
from hhrl_bench.suite import Suite, units
from hhrl_bench.tasks import get_task
from hhrl_envs import get_scenario

MAX_BYTES = 16 * 2**20


def run_suite(suite: Suite) -> Iterator[TimedResult]:
    """Return, one after the other, the result of every unit of the suite; an agent that does not load is said first."""
    for unit in units(suite):
        load_agents(unit.agent, get_scenario(unit.task.scenario))
    for unit in units(suite):
        started = time.perf_counter()
        result = evaluate_agent(unit.agent, unit.task, unit.episodes)
        yield TimedResult(result, time.perf_counter() - started)


def build(suite: Suite, results: list[TimedResult], command: str) -> LeaderboardRecord:
    """Return the leaderboard of a suite's finished units, made by ``command``."""
    return LeaderboardRecord(
        schema_version=SCHEMA_VERSION,
        suite=suite.id,
        confidence=CONFIDENCE,
        bootstrap_seed=BOOTSTRAP_SEED,
        tasks=tuple(task_record(get_task(task), suite.episodes) for task in suite.tasks),
        results=tuple(timed.result for timed in results),
        provenance=provenance(command, wall_seconds(results)),
    )


def write(leaderboard: LeaderboardRecord, path: Path) -> bool:
    """Return whether the leaderboard was written as JSON, whole or not at all.

    A file that says the same but for its provenance is left as it is: what ran first stays on record, and repeating a
    published run changes no file.
    """
    if _says(path, leaderboard):
        return False
    write_atomically(path, leaderboard.model_dump_json(indent=2) + "\n")
    return True


def _says(path: Path, leaderboard: LeaderboardRecord) -> bool:
    try:
        return read(path).model_copy(update={"provenance": leaderboard.provenance}) == leaderboard
    except RecordError:
        return False


def schema() -> str:
    """Return the JSON schema of leaderboards (draft 2020-12), as text."""
    told = {"$schema": GenerateJsonSchema.schema_dialect, **LeaderboardRecord.model_json_schema()}
    return json.dumps(told, indent=2) + "\n"


def read(path: Path) -> LeaderboardRecord:
    """Return the leaderboard in a file.

    Raises:
        RecordError: in one line, if there is none, it is larger than 16 MiB, or not a valid record.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise RecordError(f"cannot read {path}: {error.strerror}; hhrl-bench run writes one") from error
    if len(data) > MAX_BYTES:
        raise RecordError(f"{path} is larger than {MAX_BYTES // 2**20} MiB, which no leaderboard is")
    try:
        return LeaderboardRecord.model_validate_json(data)
    except ValidationError as error:
        raise RecordError(f"{path} is no leaderboard: {first_problem(error)}") from error
