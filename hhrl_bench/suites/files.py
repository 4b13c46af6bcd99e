"""Suites of users' own as JSON files: an id, tasks, agents, and how many test episodes each agent plays."""

from typing import Annotated

from pydantic import Field, ValidationError

from hhrl_bench.errors import SuiteError
from hhrl_bench.schema import MAX_RESULTS, Name, Positive, Record, Stem, first_problem
from hhrl_bench.suites.suites import SUITES, ScoreSuite, Suite, get_suite
from hhrl_bench.tasks.tasks import Task, get_task, registered_task
from hhrl_bench.text import looks_like
from hhrl_envs.scenario.files import read_file, read_json

_WHAT = 'a suite file, such as {"id": "my-suite", "tasks": ["stop-line-v0"], "agents": ["rule-4"], "episodes": 100}'
_Names = Annotated[tuple[Name, ...], Field(min_length=1, max_length=MAX_RESULTS)]


class SuiteFile(Record):
    """What a suite file holds; tasks are ids and scenario files, and paths are relative to the current folder."""

    id: Stem
    tasks: _Names
    agents: _Names
    episodes: Positive


def find_suite(source: str) -> Suite:
    """Return the suite of a registered id, or the one in a file.

    Raises:
        InputError: in one line, if there is none, a task of it is none, or it would pass for a registered one.
    """
    if source in SUITES or not source.endswith(".json"):
        return get_suite(source)
    file = read_file(source, _read, _WHAT)
    if known := looks_like(file.id, SUITES):
        raise SuiteError(f"{source}: the id {file.id!r} is or looks like that of the suite {known}; write another id")
    tasks = tuple(_task(source, task).id for task in file.tasks)
    for what, names in (("task", tasks), ("agent", file.agents)):
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise SuiteError(f"{source}: the {what} {twice!r} is named twice; name each once")
    return ScoreSuite(file.id, file.agents, tasks, file.episodes)


def _task(source: str, name: str) -> Task:
    if ":" in name and not name.endswith(".json"):
        raise SuiteError(f"{source}: {name!r} may be code, which a suite file cannot run; name ids and scenario files")
    return get_task(name) if name.endswith(".json") else registered_task(name)


def _read(text: str) -> SuiteFile:
    read_json(text)
    try:
        return SuiteFile.model_validate_json(text)
    except ValidationError as error:
        raise SuiteError(first_problem(error)) from error
