"""Entries: a leaderboard built from results, written whole to its file, and read back strictly."""

import json
import re
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from pathlib import Path

from pydantic import ValidationError
from pydantic.json_schema import GenerateJsonSchema

from hhrl_agents.atomic_files import write_atomically
from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.records import TaskRecord, TimedResult
from hhrl_bench.evaluation.results import wall_seconds
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.entry_files import NO_ENTRIES
from hhrl_bench.leaderboard.findings import Finding, differences
from hhrl_bench.leaderboard.record import LeaderboardRecord, derived_fields
from hhrl_bench.provenance import provenance
from hhrl_bench.schema import SCHEMA_VERSION, first_problem, require_plain
from hhrl_bench.statistics.intervals import BOOTSTRAP_SEED, CONFIDENCE
from hhrl_bench.training.learning_curves import TrainingOutcomesRecord
from hhrl_bench.transfer.records import TransferSetRecord

MAX_ENTRY_BYTES = 16 * 2**20
PLACES = "hhrl-bench run writes one, and published ones lie in the repository's folder leaderboards"
_NUMBERS = re.compile(r'\[\n[^][{}"]*\]')  # a list of them over several lines; no text holds a line end


def build_entry(
    suite: str,
    tasks: Sequence[TaskRecord],
    results: Sequence[TimedResult],
    command: str,
    store: Store,
    transfer: TransferSetRecord | None = None,
    trainings: Sequence[TrainingOutcomesRecord] = (),
    executor: str = "local",
) -> LeaderboardRecord:
    """Return the leaderboard of finished units, made by ``command``, whose evidence and checkpoints lie in a store.

    The checkpoints of transfers, which are many, are not to be published.
    """
    runs = [timed.result for timed in results]
    return LeaderboardRecord(
        schema_version=SCHEMA_VERSION,
        suite=suite,
        confidence=CONFIDENCE,
        bootstrap_seed=BOOTSTRAP_SEED,
        tasks=tuple(tasks),
        results=tuple(runs),
        checkpoints_published=transfer is None,
        **derived_fields(runs, trainings, store, checkpoints=transfer is None),
        transfer=transfer,
        trainings=tuple(trainings),
        provenance=provenance(command, wall_seconds(results), executor),
    )


def write_entry(board: LeaderboardRecord, path: Path) -> bool:
    """Write a leaderboard as JSON, whole or not at all, and return whether that changed its file.

    A file that says the same but for its provenance is left as it is: what ran first stays on record, and repeating a
    published run changes no file.
    """
    if _says(path, board):
        return False
    write_atomically(path, entry_text(board))
    return True


def publish_entry(board: LeaderboardRecord, path: Path, source: Store) -> bool:
    """Copy the files that a leaderboard names to the store beside it, then do what ``write_entry`` does.

    Raises:
        RecordError: if one of them is missing or has been changed.
    """
    target = Store(path.parent)
    for file in named_files(board, source):
        target.copy(file)
    return write_entry(board, path)


def named_files(board: LeaderboardRecord, store: Store) -> Iterator[Path]:
    """Yield the files of a store that a leaderboard names."""
    for result in board.results:
        for run in result.runs:
            if run.evidence_sha256:
                yield store.evidence(run.evidence_sha256)
            if run.checkpoint_sha256 and board.checkpoints_published:
                yield store.checkpoint(run.checkpoint_sha256)


def check_spelling(path: Path, board: LeaderboardRecord) -> Iterator[Finding]:
    """Yield the first line of a file that is not as ``write_entry`` spells the leaderboard that was read from it.

    It may hold digits beyond what a number can have, or a name twice, of which only the last counts.
    """
    lines = zip_longest(path.read_text(encoding="utf-8").split("\n"), entry_text(board).split("\n"), fillvalue="")
    for number, (line, ours) in enumerate(lines, start=1):
        if line != ours:
            said = f"{line.strip()[:60]!r} is not how hhrl-bench run spells it, which is {ours.strip()[:60]!r}"
            yield Finding(f"line {number}", said)
            return


def entry_text(board: LeaderboardRecord) -> str:
    """Return the content of a file, a list of numbers on a line: half of the bytes of one number on each."""
    spread = board.model_dump_json(indent=2)
    return _NUMBERS.sub(lambda numbers: "".join(numbers[0].split()).replace(",", ", "), spread) + "\n"


def _says(path: Path, board: LeaderboardRecord) -> bool:
    try:
        return not any(compare_entries(read_entry(path), board))
    except RecordError:
        return False


def compare_entries(published: LeaderboardRecord, found: LeaderboardRecord) -> Iterator[Finding]:
    """Yield every number or word in which a leaderboard differs from a published one, but for their provenance."""
    texts = (board.model_dump_json(exclude={"provenance"}) for board in (published, found))
    yield from differences("", *map(json.loads, texts))


def entry_schema() -> str:
    """Return the JSON schema of leaderboards (draft 2020-12), as text."""
    schema = {"$schema": GenerateJsonSchema.schema_dialect, **LeaderboardRecord.model_json_schema()}
    return json.dumps(schema, indent=2) + "\n"


def read_entry(path: Path) -> LeaderboardRecord:
    """Return the leaderboard in a file.

    Raises:
        RecordError: in one line, if there is none, it is larger than 16 MiB, or not a valid record.
    """
    if path.name in NO_ENTRIES:
        raise RecordError(f"{path} is {NO_ENTRIES[path.name]} of a folder of entries; name an entry")
    try:
        with path.open("rb") as file:
            data = file.read(MAX_ENTRY_BYTES + 1)
    except OSError as error:
        raise RecordError(f"cannot read {path}: {error.strerror}; {PLACES}") from error
    if len(data) > MAX_ENTRY_BYTES:
        raise RecordError(f"{path} is larger than {MAX_ENTRY_BYTES // 2**20} MiB, which no leaderboard is")
    try:
        require_plain(data)
        return LeaderboardRecord.model_validate_json(data)
    except ValidationError as error:
        raise RecordError(f"{path} is no leaderboard: {first_problem(error)}") from error
    except ValueError as error:
        raise RecordError(f"{path} is no leaderboard: {error}") from error
