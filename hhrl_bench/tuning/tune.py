"""Tune: search for the numbers of a rule, task by task or for all tasks at once, and keep what is found in a file."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from types import MappingProxyType
from typing import Final, Literal, Self

from pydantic import ValidationError, model_validator

from hhrl_agents.atomic_files import require_writable, write_atomically
from hhrl_agents.rules.tuned_rule import ALL_TASKS, HELD_OUT, ROBUST, TUNED
from hhrl_agents.rules.tuning import bounds
from hhrl_bench.errors import TuningError
from hhrl_bench.evaluation.results import Update
from hhrl_bench.schema import Count, Finite, Name, Positive, Rate, Record, Sha256, first_problem
from hhrl_bench.tasks.tasks import TASKS, Task
from hhrl_bench.tuning.search import Found, search
from hhrl_envs import Scenario, get_scenario
from hhrl_envs.scenario.registry import SUPERSEDED

VERSION: Final = 1

Sets = Mapping[str, Sequence[Task]]
"""The tasks of every search, by the name of the set of numbers that it is for."""

Shown = Callable[[str], AbstractContextManager[Update]]
"""Returns, for the name of a search, a context whose value hears how far it is."""


class SetRecord(Record):
    """Numbers that a search has found.

    ``scenarios`` are the hashes of the worlds by their ids, ``score`` is the mean over ``episodes`` of each, which the
    search had not seen before.
    """

    scenarios: dict[Name, Sha256]
    seed: Count
    env_steps: Positive
    candidates: Positive
    episodes: Positive
    score: Rate
    tuning: dict[Name, Finite]

    @model_validator(mode="after")
    def _has_every_number(self) -> Self:
        if self.tuning.keys() != bounds().keys():
            raise ValueError(f"a set has the numbers {', '.join(bounds())}; this one has {', '.join(self.tuning)}")
        return self


class TuningRecord(Record):
    """The sets of numbers of an agent by their names."""

    schema_version: Literal[1]
    agent: Name
    sets: dict[Name, SetRecord]


def tunable_tasks() -> list[Task]:
    """Return the registered tasks that are searched in by default: one for each scenario with scripted traffic.

    Those that are superseded, and those whose drivers nobody is to have met, are not among them.
    """
    left = {*HELD_OUT, *SUPERSEDED}
    return [task for task in TASKS.values() if not (_refusal(task) or task.given_actions or task.scenario in left)]


def tune(
    agent: str,
    tasks: Sequence[Task],
    seed: int,
    env_steps: int | None,
    out: Path | None,
    progress: Shown,
) -> TuningRecord:
    """Return what the searches for an agent find; after each of them write it into the file, if any.

    Sets of the file that are not searched for anew stay in it, and in what is returned. A search has the budget of its
    tasks together, or ``env_steps``; ``progress`` shows how far it is.

    Raises:
        TuningError: for an agent without numbers, a task without a score, a file of something else, or too few steps.
        OutputError: before any search, if the file cannot be written.
    """
    searches = _searches(agent, tasks or tunable_tasks())
    sets = {} if out is None else dict(_read(out, agent).sets)
    record = TuningRecord(schema_version=VERSION, agent=agent, sets=sets)
    for name, record_of_set in _search_all(searches, seed, env_steps, progress):
        record = record.model_copy(update={"sets": {**record.sets, name: record_of_set}})
        if out is not None:
            write_atomically(out, record.model_dump_json(indent=2) + "\n")
    return record


def _search_all(searches: Sets, seed: int, env_steps: int | None, progress: Shown) -> Iterator[tuple[str, SetRecord]]:
    for name, tasks in searches.items():
        budget = env_steps or sum(task.env_steps for task in tasks)
        with progress(name) as update:
            found = search(tasks, budget, seed, update)
        yield name, _record(tasks, seed, found)


def _record(tasks: Sequence[Task], seed: int, found: Found) -> SetRecord:
    hashes = {task.scenario: get_scenario(task.scenario).spec_hash for task in tasks}
    return SetRecord(
        scenarios=hashes,
        seed=seed,
        env_steps=found.env_steps,
        candidates=found.candidates,
        episodes=found.worlds,
        score=found.score,
        tuning=dict(found.tuning),
    )


def _each(tasks: Sequence[Task]) -> Sets:
    return {task.scenario: [task] for task in tasks}


def _together(tasks: Sequence[Task]) -> Sets:
    return {ALL_TASKS: tasks}


TUNABLE: Mapping[str, Callable[[Sequence[Task]], Sets]] = MappingProxyType({TUNED: _each, ROBUST: _together})
"""The agents that have numbers to search for, and which searches that takes."""


def _searches(agent: str, tasks: Sequence[Task]) -> Sets:
    if agent not in TUNABLE:
        raise TuningError(f"{agent!r} has no numbers to search for; write one of: {', '.join(TUNABLE)}")
    refused = next(filter(None, map(_refusal, tasks)), None)
    if refused is not None:
        raise TuningError(refused)
    return TUNABLE[agent](tasks)


def _refusal(task: Task) -> str | None:
    """Return why no search can be in a task; None if one can."""
    scenario: Scenario = get_scenario(task.scenario)
    if not scenario.learned_fronts:
        return None
    return f"{task.id} has learned front vehicles, and so no score to search by; write a task with scripted ones"


def _read(path: Path, agent: str) -> TuningRecord:
    """Return what is in a file that is to be written, or no sets where there is none."""
    require_writable(path)
    if not path.exists():
        return TuningRecord(schema_version=VERSION, agent=agent, sets={})
    try:
        record = TuningRecord.model_validate_json(path.read_bytes())
    except ValidationError as error:
        problem = first_problem(error)
        raise TuningError(f"{path} is no file of tunings: {problem}; write another --out") from error
    if record.agent != agent:
        raise TuningError(f"{path} holds the numbers of {record.agent}; write another --out")
    return record
