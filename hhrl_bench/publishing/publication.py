"""A folder of published entries: found, verified, indexed, and added to."""

from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StringConstraints, ValidationError

import hhrl_bench
from hhrl_agents.atomic_files import is_fragment, write_atomically
from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.entry import entry_schema, named_files, read_entry
from hhrl_bench.leaderboard.entry_files import INDEX, SCHEMA, EntryFileName, entry_paths, find_entries, is_entry_name
from hhrl_bench.leaderboard.findings import Finding, differences
from hhrl_bench.leaderboard.level import Level
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.schema import (
    SCHEMA_VERSION,
    Name,
    Positive,
    Record,
    Sha256,
    Stem,
    first_problem,
    sha256_of,
)
from hhrl_bench.suites import suites
from hhrl_bench.tasks.tasks import registered_task

Day = Annotated[str, StringConstraints(pattern=r"^[0-9]{4}-[0-9]{2}-[0-9]{2}$")]


class VerifiedRecord(Record):
    """How far an entry was verified, when, by which version of this package, and by which command."""

    level: Level = Field(strict=False)
    day: Day
    package_version: Name
    command: Name


class EntryRecord(Record):
    """An entry: its file, what is in it, and how far it was verified. It is a submission if not named by its suite."""

    file: EntryFileName
    sha256: Sha256
    suite: Stem
    tasks: tuple[Name, ...]
    agents: tuple[Name, ...]
    results: Positive
    verified: VerifiedRecord


class IndexRecord(Record):
    """All entries in a folder, by file name."""

    schema_version: Literal[1]
    entries: tuple[EntryRecord, ...]


def write_index(folder: Path, levels: Mapping[str, Level], command: str) -> IndexRecord:
    """Write the index and the schema of a folder whose entries were just verified, and return the index.

    ``levels``: how far, by file name; ``command``: that verified them. What the index said before counts for nothing.
    """
    day = datetime.now(UTC).date().isoformat()
    entries = [
        _entry(
            path,
            VerifiedRecord(level=levels[path.name], day=day, package_version=hhrl_bench.__version__, command=command),
        )
        for path in entry_paths(folder)
    ]
    index = IndexRecord(schema_version=SCHEMA_VERSION, entries=tuple(entries))
    write_atomically(folder / INDEX, index.model_dump_json(indent=2) + "\n")
    write_atomically(folder / SCHEMA, entry_schema())
    return index


def check_index(folder: Path) -> Iterator[Finding]:
    """Yield what of a folder is not as its index says, and the files of its store that no entry names.

    Raises:
        RecordError: if it has no index, or one that is none.
    """
    known = {entry.file: entry for entry in _read_index(folder).entries}
    for path in entry_paths(folder):
        if (entry := known.pop(path.name, None)) is None:
            yield Finding(INDEX, f"it lacks {path.name}; hhrl-bench leaderboard build adds it")
        else:
            found = _entry(path, entry.verified)
            yield from differences(f"{INDEX} {path.name}", entry.model_dump(), found.model_dump())
    for name in known:
        yield Finding(INDEX, f"it names {name}, which is not there")
    store, boards = Store(folder), map(read_entry, entry_paths(folder))
    named = {path for board in boards for path in named_files(board, store)}
    for path in sorted({*folder.glob("evidence/*"), *folder.glob("checkpoints/*")} - named):
        if not is_fragment(path):
            yield Finding(str(path.relative_to(folder)), "no entry names this file")


def require_submittable(board: LeaderboardRecord, name: str, folder: Path) -> None:
    """Refuse an entry that cannot be submitted to a folder under a name.

    Raises:
        RecordError: if the name is taken or none, or the entry is not what a run of its suite makes.
    """
    if not is_entry_name(name) or name in suites.SUITES:
        raise RecordError(
            f"cannot call an entry {name!r}; write small letters, digits and hyphens, and no suite's name"
        )
    if (folder / f"{name}.json").exists():
        raise RecordError(f"{folder} holds an entry {name} already; write another --name")
    own = suites.get_suite(board.suite)
    _require_equal("tasks", [task.id for task in board.tasks], list(own.tasks), own.id)
    _require_equal("episodes", {task.episodes for task in board.tasks}, {own.episodes}, own.id)
    opponents = [task.opponent and task.opponent.agent for task in board.tasks]
    _require_equal("opponents", opponents, [registered_task(task).opponent for task in own.tasks], own.id)
    scored = {(result.agent, result.task) for result in board.results}
    agents = dict.fromkeys(result.agent for result in board.results)
    missing = [f"{agent} on {task}" for agent in agents for task in own.tasks if (agent, task) not in scored]
    if missing:
        raise RecordError(f"the entry lacks {missing[0]}; every agent of an entry is scored on all tasks of its suite")
    for other, known in of_suite(folder, board.suite).items():
        if _evidence(board) <= _evidence(known):
            raise RecordError(f"the same episodes are in {folder}/{other}.json already; submit another agent's")


def _evidence(board: LeaderboardRecord) -> set[str | None]:
    return {run.evidence_sha256 for result in board.results for run in result.runs}


def _require_equal(what: str, given: object, wanted: object, suite: str) -> None:
    if given != wanted:
        raise RecordError(f"the entry has other {what} than suite {suite}; hhrl-bench run --suite {suite} makes one")


def _read_index(folder: Path) -> IndexRecord:
    path = folder / INDEX
    try:
        return IndexRecord.model_validate_json(path.read_bytes())
    except OSError as error:
        raise RecordError(f"cannot read {path}: {error.strerror}; hhrl-bench leaderboard build writes it") from error
    except ValidationError as error:
        raise RecordError(f"{path} is no index: {first_problem(error)}") from error


def _entry(path: Path, verified: VerifiedRecord) -> EntryRecord:
    board = read_entry(path)
    return EntryRecord(
        file=path.name,
        sha256=sha256_of(path.read_bytes()),
        suite=board.suite,
        tasks=tuple(task.id for task in board.tasks),
        agents=_agents(board),
        results=len(board.results),
        verified=verified,
    )


def _agents(board: LeaderboardRecord) -> tuple[str, ...]:
    return tuple(dict.fromkeys(result.agent for result in board.results))


def of_suite(folder: Path, suite: str) -> dict[str, LeaderboardRecord]:
    """Return the entries of a suite in a folder by name, the published one first."""
    boards = {path.stem: read_entry(path) for path in find_entries(folder)}
    own = {name: board for name, board in boards.items() if board.suite == suite}
    return dict(sorted(own.items(), key=lambda item: item[0] != suite))
