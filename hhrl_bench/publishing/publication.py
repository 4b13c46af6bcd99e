"""A folder of published entries: found, verified, indexed, and added to."""

from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

from pydantic import Field, StringConstraints, ValidationError

import hhrl_bench
from hhrl_agents.atomic_files import is_fragment, write_atomically
from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.records import ResultRecord
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.entry import entry_schema, entry_text, named_files, read_entry
from hhrl_bench.leaderboard.entry_files import INDEX, SCHEMA, EntryFileName, entry_paths, find_entries, is_entry_name
from hhrl_bench.leaderboard.findings import Finding, differences
from hhrl_bench.leaderboard.level import Level
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.publishing.copies import Stored, copied
from hhrl_bench.schema import (
    FIRST,
    SCHEMA_VERSION,
    Name,
    Positive,
    Record,
    Sha256,
    Stem,
    first_problem,
    require_plain,
    sha256_of,
)
from hhrl_bench.suites import suites
from hhrl_bench.suites.units import Evaluation, Training
from hhrl_bench.tables.markdown import suite_page
from hhrl_bench.tasks.tasks import registered_task
from hhrl_bench.text import looks_like
from hhrl_bench.verification.identity import named, rounded, shipped
from hhrl_bench.verification.verify import reached
from hhrl_envs.errors import InputError

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
    tasks: Annotated[tuple[Name, ...], FIRST]
    agents: Annotated[tuple[Name, ...], FIRST]
    results: Positive
    verified: VerifiedRecord


class IndexRecord(Record):
    """All entries in a folder, by file name."""

    schema_version: Literal[1]
    entries: Annotated[tuple[EntryRecord, ...], FIRST]


class VerifiedEntry(NamedTuple):
    """An entry as it was read, and how it was verified."""

    board: LeaderboardRecord
    verified: VerifiedRecord


def verified_now(level: Level, asked: Level) -> VerifiedRecord:
    """Return what there is to say of an entry that the command which asks for a level has now verified up to one."""
    day = datetime.now(UTC).date().isoformat()
    return VerifiedRecord(level=level, day=day, package_version=hhrl_bench.__version__, command=build_command(asked))


def write_index(folder: Path, entries: Mapping[str, VerifiedEntry]) -> IndexRecord:
    """Write the index, the schema and the pages of a folder, and return the index.

    ``entries``: those that were read and verified, by the names of their files. What the index said before counts for
    nothing, and nothing is read again.
    """
    rows = [
        _entry(name, entry_text(one.board).encode(), one.board, one.verified) for name, one in sorted(entries.items())
    ]
    index = IndexRecord(schema_version=SCHEMA_VERSION, entries=tuple(rows))
    write_atomically(folder / INDEX, index.model_dump_json(indent=2) + "\n")
    for name, text in _made_of({name: one.board for name, one in entries.items()}).items():
        write_atomically(folder / name, text)
    return index


def build_command(level: Level) -> str:
    """Return the command that verifies a folder up to a level and writes its index."""
    return f"hhrl-bench leaderboard build --level {level}"


def _made_of(boards: Mapping[str, LeaderboardRecord]) -> dict[str, str]:
    """Return the texts that are made of entries, given by file name, by their own: the schema, and a page a suite."""
    by_stem = {Path(name).stem: board for name, board in boards.items()}
    known = dict.fromkeys(board.suite for board in boards.values())
    return {SCHEMA: entry_schema(), **{f"{suite}.md": suite_page(_of_suite(by_stem, suite)) for suite in known}}


def check_index(folder: Path) -> Iterator[Finding]:
    """Yield what of a folder is not as its entries say: the index, schema and pages, and files that no entry names.

    Raises:
        RecordError: if it has no index, or one that is none.
    """
    published = _read_index(folder).entries
    known = {entry.file: entry for entry in published}
    if [entry.file for entry in published] != sorted(known):
        yield Finding(INDEX, "it does not name every file once, in order")
    boards = {path.name: read_entry(path) for path in entry_paths(folder)}
    for file, board in boards.items():
        if (entry := known.pop(file, None)) is None:
            yield Finding(INDEX, f"it lacks {file}; hhrl-bench leaderboard build adds it")
        else:
            found = _entry(file, (folder / file).read_bytes(), board, entry.verified)
            yield from differences(f"{INDEX} {file}", entry.model_dump(), found.model_dump())
            yield from _check_level(f"{INDEX} {file}.verified", entry.verified, board)
    for name in known:
        yield Finding(INDEX, f"it names {name}, which is not there")
    yield from _check_pages(folder, boards)
    store = Store(folder)
    yield from copied({file: Stored(board, store) for file, board in boards.items()})
    named_by = {path for board in boards.values() for path in named_files(board, store)}
    for path in sorted({*folder.glob("evidence/*"), *folder.glob("checkpoints/*")} - named_by):
        if not is_fragment(path):
            yield Finding(str(path.relative_to(folder)), "no entry names this file")


def _check_pages(folder: Path, boards: Mapping[str, LeaderboardRecord]) -> Iterator[Finding]:
    """Return which pages, and the schema, are not what the entries come to, and which suite has a page and no entry."""
    made = _made_of(boards)
    for name, text in made.items():
        if not _holds(folder / name, text):
            yield Finding(name, "it is not what the entries come to; hhrl-bench leaderboard build writes it")
    for path in sorted(folder.glob("*.md")):
        if path.stem in suites.SUITES and path.name not in made:
            yield Finding(path.name, f"no entry is of suite {path.stem}")


def _check_level(place: str, verified: VerifiedRecord, board: LeaderboardRecord) -> Iterator[Finding]:
    """Return whether the command cannot have verified an entry so far."""
    asked = next((level for level in Level if verified.command == build_command(level)), None)
    if asked is None:
        yield Finding(f"{place}.command", f"{verified.command!r} is not how a folder is built")
    elif verified.level != reached(board, asked):
        said = f"{verified.level} is published, {verified.command} comes to {reached(board, asked)}"
        yield Finding(f"{place}.level", said)


def _holds(path: Path, text: str) -> bool:
    try:
        return path.read_bytes() == text.encode()
    except OSError:
        return False


def require_submittable(board: LeaderboardRecord, store: Store, name: str, folder: Path) -> None:
    """Refuse an entry, whose files lie in ``store``, that cannot be submitted to a folder under a name.

    Raises:
        RecordError: if the name is taken, none or like a suite's, the entry is not what a run of its suite makes, or
            its episodes are those of agents in the folder.
    """
    if not is_entry_name(name) or looks_like(name, suites.SUITES):
        raise RecordError(
            f"cannot call an entry {name!r}; write small letters, digits and hyphens, and no suite's name"
        )
    if (folder / f"{name}.json").exists():
        raise RecordError(f"{folder} holds an entry {name} already; write another --name")
    require_of_suite(board)
    for other, known in of_suite(folder, board.suite).items():
        if _evidence(board) <= _evidence(known):
            raise RecordError(f"the same episodes are in {folder}/{other}.json already; submit another agent's")
    if found := next(copied({**_stored(folder), name: Stored(board, store)}, of=name), None):
        raise RecordError(f"{found}; submit another agent's")


def _stored(folder: Path) -> dict[str, Stored]:
    store = Store(folder)
    return {path.name: Stored(read_entry(path), store) for path in find_entries(folder)}


def check_suite(name: str, board: LeaderboardRecord) -> Iterator[Finding]:
    """Return whether the entry of a name in a folder is not what a run of its suite makes."""
    try:
        near = looks_like(name, suites.SUITES)
        if near is not None and near != board.suite:
            raise RecordError(f"an entry of suite {board.suite} is not called {name}, which looks like {near}")
        if near is not None and near != name:
            raise RecordError(f"{name} looks like {near}; call it otherwise")
        require_of_suite(board)
        if name == board.suite:
            _require_whole(board)
    except InputError as error:
        yield Finding("suite", str(error))


def _require_whole(board: LeaderboardRecord) -> None:
    """Refuse an entry under the name of its suite that has other rows or curves than the suite makes."""
    own = suites.get_suite(board.suite)
    rows = {(unit.agent, unit.task.id) for unit in _units(own)}
    _require_equal("rows", {(result.agent, result.task) for result in board.results}, rows, own.id)
    trainings = {(one.agent, one.task.id) for one in own.curves(Path()).trainings}
    _require_equal("curves", {(one.method, one.task) for one in board.trainings}, trainings, own.id)


def _units(suite: suites.Suite) -> list[Evaluation | Training]:
    return [unit for stage in suite.stages(Path()) for unit in stage if isinstance(unit, Evaluation | Training)]


def require_of_suite(board: LeaderboardRecord) -> None:
    """Refuse an entry that is not what a run of its suite makes, with its own agents or with others.

    Raises:
        InputError: if there is no such suite, or the entry has other tasks, episodes, opponents, agents or seeds.
    """
    if board.suite not in suites.SUITES:
        raise RecordError(
            f"{board.suite!r} is no registered suite, and only entries of those are published; "
            "score your agent in one: hhrl-bench run --suite quick --agent AGENT"
        )
    own = suites.get_suite(board.suite)
    _require_equal("tasks", [task.id for task in board.tasks], list(own.tasks), own.id)
    _require_equal("episodes", {task.episodes for task in board.tasks}, {own.episodes}, own.id)
    opponents = [task.opponent and task.opponent.agent for task in board.tasks]
    _require_equal("opponents", opponents, [registered_task(task).opponent for task in own.tasks], own.id)
    transfers = {one.target.id: one for one in own.curves(Path()).transfers}
    if board.transfer and not transfers:
        raise RecordError(f"it has a transfer, and suite {own.id} has none; publish the checkpoints")
    units = _units(own)
    sources = {unit.agent: unit.task for unit in units if isinstance(unit, Training) and unit.transfer is None}
    rows = {(result.agent, result.task) for result in board.results}
    for arm in board.transfer.rows if board.transfer else ():
        wanted = transfers[arm.target].env_steps if arm.target in transfers else 0
        what = f"{arm.method} {arm.arm} on {arm.target}"
        _require_equal(f"env steps of {what}", arm.budget, rounded(wanted, arm.method), own.id)
        source = sources.get(arm.method)
        _require_equal(f"sources of {what}", arm.source, source and source.scenario, own.id)
        if source and (arm.method, source.id) not in rows:
            raise RecordError(f"the entry lacks {arm.method} on {source.id}, the source of its {arm.arm}")
    own_tasks: dict[str, set[str]] = {}
    for unit in units:
        own_tasks.setdefault(unit.agent, set()).add(unit.task.id)
    for agent in dict.fromkeys(result.agent for result in board.results):
        scored = {result.task for result in board.results if result.agent == agent}
        if missing := [task for task in own.tasks if task not in scored and scored != own_tasks.get(agent)]:
            said = "every agent of an entry is scored on all tasks of its suite"
            raise RecordError(f"the entry lacks {agent} on {missing[0]}; {said}")
    seeds = {(unit.agent, unit.task.id): unit.seeds for unit in units if isinstance(unit, Training)}
    with_curves = {(one.agent, one.task.id) for one in own.curves(Path()).trainings}
    curves = {(one.method, one.task) for one in board.trainings}
    for result in board.results:
        row = result.agent, result.task
        trained = seeds.get(row) if row in curves or row not in with_curves else None
        _require_known(result, trained, own.id, shipped_too=board.transfer is None)


def _require_known(result: ResultRecord, seeds: tuple[int, ...] | None, suite: str, *, shipped_too: bool) -> None:
    """Refuse a row of a registered method that is neither trained in its suite nor the one of the package.

    Of a learned agent of a user's own its seeds are 0 to n - 1, so that none was left out because of its result.

    seeds: those that the suite trains there, if the entry has what else such a training leaves; None: it trains none.
    shipped_too: whether the entry shows what the one of the package decides, with its checkpoints.
    """
    says = named(result.agent, result.kind)
    every = sorted((*result.seeds, *result.failed_seeds))
    if says.method is None and every != list(range(len(every))):
        given = ", ".join(map(str, every))
        raise RecordError(f"the seeds of {result.agent} are {given}; publish 0 to n - 1, with those that failed")
    there = all(run.training is not None and run.training.task == result.task for run in result.runs)
    if says.method is None or (there and tuple(every) == seeds):
        return
    whole = [run.checkpoint_sha256 for run in result.runs] == shipped(says.method) and not result.failed_seeds
    if says.arm is not None or not whole or not shipped_too:
        raise RecordError(
            f"{result.agent} on {result.task} is neither what comes with the package nor trained by suite {suite}; "
            "publish it under another name"
        )


def _evidence(board: LeaderboardRecord) -> set[str | None]:
    return {run.evidence_sha256 for result in board.results for run in result.runs}


def _require_equal(what: str, given: object, wanted: object, suite: str) -> None:
    if given != wanted:
        raise RecordError(f"the entry has other {what} than suite {suite}; hhrl-bench run --suite {suite} makes one")


def _read_index(folder: Path) -> IndexRecord:
    path = folder / INDEX
    try:
        data = path.read_bytes()
        require_plain(data)
        return IndexRecord.model_validate_json(data)
    except OSError as error:
        raise RecordError(f"cannot read {path}: {error.strerror}; hhrl-bench leaderboard build writes it") from error
    except ValidationError as error:
        raise RecordError(f"{path} is no index: {first_problem(error)}") from error
    except ValueError as error:
        raise RecordError(f"{path} is no index: {error}") from error


def _entry(file: str, content: bytes, board: LeaderboardRecord, verified: VerifiedRecord) -> EntryRecord:
    return EntryRecord(
        file=file,
        sha256=sha256_of(content),
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
    return _of_suite({path.stem: read_entry(path) for path in find_entries(folder)}, suite)


def _of_suite(boards: Mapping[str, LeaderboardRecord], suite: str) -> dict[str, LeaderboardRecord]:
    own = {name: board for name, board in boards.items() if board.suite == suite}
    return dict(sorted(own.items(), key=lambda item: item[0] != suite))
