"""Outcome files: what a finished unit came to, so that it is not done again while nothing about it has changed."""

from collections.abc import Callable
from pathlib import Path

from pydantic import ValidationError

from hhrl_agents.atomic_files import write_atomically
from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.loading import load_agents
from hhrl_bench.evaluation.records import ResultRecord, RunRecord, TimedResult
from hhrl_bench.evaluation.store import Store, read
from hhrl_bench.provenance import code_sha256
from hhrl_bench.schema import Record, Sha256
from hhrl_bench.tasks.tasks import Task
from hhrl_envs import get_scenario


class OutcomeRecord(Record):
    """An outcome, and the hash of the code that made it."""

    code_sha256: Sha256
    outcome: TimedResult


def keep_outcome(path: Path, make: Callable[[], TimedResult], agent: str, task: Task, store: Store) -> TimedResult:
    """Return the outcome in a file, or the one that ``make`` makes anew, which is then written there.

    It is made anew where there is none, where it was made by other code, where ``agent`` has other checkpoints now, and
    where the store lacks some of its files or holds damaged ones. An agent that is the user's own code is always scored
    anew.
    """
    known = _read(path)
    if known and known.code_sha256 == code_sha256() and _still_holds(known.outcome.result, agent, task, store):
        return known.outcome
    outcome = make()
    path.parent.mkdir(parents=True, exist_ok=True)
    record = OutcomeRecord(code_sha256=code_sha256(), outcome=outcome)
    write_atomically(path, record.model_dump_json(indent=2) + "\n")
    return outcome


def _read(path: Path) -> OutcomeRecord | None:
    try:
        return OutcomeRecord.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None


def _still_holds(result: ResultRecord, agent: str, task: Task, store: Store) -> bool:
    loaded = load_agents(agent, get_scenario(task.scenario))
    return (
        result.task == task.id
        and all(one.kind != "factory" for one in loaded)
        and [one.sha256 for one in loaded] == [run.checkpoint_sha256 for run in result.runs]
        and all(_are_whole(run, store) for run in result.runs)
    )


def _are_whole(run: RunRecord, store: Store) -> bool:
    """Return whether the evidence and the checkpoint of a run, if it has one, lie in the store, and are not damaged."""
    try:
        read(store.evidence(str(run.evidence_sha256)))
        if run.checkpoint_sha256:
            read(store.checkpoint(run.checkpoint_sha256))
    except RecordError:
        return False
    return True
