"""Scenarios of users' own: read from a file, or taken from a module, and registered for this process."""

from collections.abc import Collection
from pathlib import Path

from hhrl_bench.errors import TaskError
from hhrl_bench.extensions import import_here
from hhrl_bench.text import look
from hhrl_envs import SCENARIOS, Scenario, read_scenario
from hhrl_envs.errors import InputError
from hhrl_envs.scenario.registry import add_scenario


def find_own(source: str) -> Scenario | None:
    """Return the scenario in the file, or of the ``module:scenario``, that is named; None if it names neither.

    The module is looked for in the current folder too. What it names is a scenario, or makes one without arguments.

    Raises:
        InputError: in one line, if there is no such file or module, or no valid scenario in it.
    """
    path = Path(source)
    if path.suffix == ".py":
        raise TaskError(f"{source!r} is a file of Python; write module:scenario, such as {path.stem}:SCENARIO")
    if path.suffix == ".json" or _is_file(path):
        return read_scenario(path)
    return _of_module(source) if ":" in source else None


def add_own(scenario: Scenario, taken: Collection[str]) -> None:
    """Register a scenario; ``taken`` are ids of tasks that are more than their scenario.

    Raises:
        TaskError: if its id is that of another one, or looks like one.
    """
    for known in (*SCENARIOS, *taken):
        if look(known) == look(scenario.id) and (known != scenario.id or known in taken):
            raise TaskError(
                f"the id {scenario.id!r} is or looks like that of the task {known}; write another id, "
                "such as 'my-road-v0'"
            )
    if scenario.id in SCENARIOS and SCENARIOS[scenario.id] != scenario:
        raise TaskError(
            f"the id {scenario.id!r} is that of a registered scenario with other numbers; write another id, "
            "such as 'my-road-v0'"
        )
    add_scenario(scenario)


def _of_module(source: str) -> Scenario:
    module, _, name = source.partition(":")
    try:
        found = getattr(import_here(module), name, None)
        scenario = found() if callable(found) else found
    except InputError as error:
        raise TaskError(f"{source}: {error}") from error
    except (Exception, SystemExit) as error:
        raise TaskError(
            f"cannot take the scenario {source}: {type(error).__name__}: {error}; write module:scenario, the module as "
            "in an import statement; it is looked for in the current folder"
        ) from error
    if not isinstance(scenario, Scenario):
        held = "there is no such name" if found is None else f"it is {type(scenario).__name__}"
        raise TaskError(f"{source} is no scenario: {held}; name a Scenario, or a function that makes one of nothing")
    return scenario


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name that is too long for a file
        return False
