"""The commands under ``hhrl-bench leaderboard``: findings on stdout, progress on stderr."""

import json
import secrets
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from hhrl_bench.cli.console import announce_compiling, console, progress
from hhrl_bench.cli.options import JsonOption
from hhrl_bench.leaderboard.level import Level

if TYPE_CHECKING:
    from hhrl_bench.execution.pools import Each
    from hhrl_bench.leaderboard.findings import Finding
    from hhrl_bench.leaderboard.record import LeaderboardRecord
    from hhrl_bench.publishing.publication import VerifiedEntry

leaderboard_app = typer.Typer(help="Read, verify and publish leaderboards.")

FolderOption = Annotated[Path, typer.Option("--folder", help="The folder of published entries.")]
LevelOption = Annotated[Level, typer.Option("--level", help="How far: each level includes those before it.")]
JobsOption = Annotated[int, typer.Option("--jobs", min=1, help="Results checked side by side, in processes.")]
FOLDER = Path("leaderboards")


@leaderboard_app.command()
def show(
    file: Annotated[Path, typer.Argument(help="Leaderboard file.")] = FOLDER / "quick.json",
    details: Annotated[
        bool, typer.Option("--details", help="Print worst cases, comparisons with the best agent and efficiency too.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Print a leaderboard as tables."""
    from hhrl_bench.leaderboard.entry import read_entry
    from hhrl_bench.tables.terminal import print_leaderboard

    board = read_entry(file)
    if as_json:
        typer.echo(board.model_dump_json(indent=2))
    else:
        print_leaderboard(console(), board, details=details)


@leaderboard_app.command()
def verify(
    paths: Annotated[
        list[Path] | None, typer.Argument(help="Entries, or folders of them.", show_default="leaderboards")
    ] = None,
    level: LevelOption = Level.REPLAYED,
    sample: Annotated[
        int | None,
        typer.Option(min=1, help="Run so many results again; at retrained, train so many seeds.", show_default="all"),
    ] = None,
    fresh: Annotated[
        int | None, typer.Option(min=1, help="Also score every run in so many worlds drawn anew.", show_default="none")
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, help="Draws the sample and the worlds.", show_default="a new one")
    ] = None,
    jobs: JobsOption = 1,
    as_json: JsonOption = False,
) -> None:
    """Verify entries, offline: their files, numbers and agents; exit code 1 where something does not hold."""
    if sample is not None and not level.includes(Level.RERUN):
        raise typer.BadParameter(
            f"--level {level} runs no agent again; write --level rerun or --level retrained", param_hint="--sample"
        )
    from hhrl_bench.execution.pools import mapping
    from hhrl_bench.leaderboard.entry import read_entry
    from hhrl_bench.leaderboard.entry_files import INDEX, entry_paths
    from hhrl_bench.publishing.publication import check_index

    announce_compiling()
    drawn = secrets.randbelow(10**9) if seed is None else seed
    found: list[_Verified] = []
    with mapping(jobs) as each:
        for path in paths or [FOLDER]:
            if path.is_dir():
                found.append(_Verified(path / INDEX, list(check_index(path)), None))
            for file in entry_paths(path) if path.is_dir() else [path]:
                board, published = read_entry(file), path.is_dir()
                found.append(_verify_entry(file, board, level, each, sample, fresh, drawn, published=published))
    if as_json:
        rows = [{"entry": str(one.path), **finding._asdict()} for one in found for finding in one.findings]
        verified = {str(one.path): one.level for one in found if one.level}
        typer.echo(json.dumps({"level": level, "verified": verified, "findings": rows}, indent=2))
    else:
        _print_verified(found)
        if sample or fresh:
            typer.echo(f"drawn by --seed {drawn}", err=True)
    if any(one.findings for one in found):
        raise typer.Exit(1)


@leaderboard_app.command()
def build(
    folder: FolderOption = FOLDER,
    level: LevelOption = Level.REPLAYED,
    again: Annotated[
        bool, typer.Option("--again", help="Verify also what has not changed since this machine has verified it.")
    ] = False,
    jobs: JobsOption = 1,
) -> None:
    """Verify every entry in a folder, then write its INDEX.json, its schema.json and a page of tables a suite.

    What this machine has verified is not verified again as long as the entry, its files and this package are the same.
    """
    from hhrl_bench.leaderboard.entry_files import INDEX
    from hhrl_bench.publishing.publication import write_index

    announce_compiling()
    index = write_index(folder, _verify_changed(folder, level, jobs, again=again))
    typer.echo(f"wrote {folder / INDEX}, {len(index.entries)} entries, and a page of tables a suite", err=True)


@leaderboard_app.command()
def submit(
    file: Annotated[Path, typer.Argument(help="A leaderboard that hhrl-bench run has written.", show_default=False)],
    name: Annotated[str, typer.Option(help="What to call the entry.", show_default=False)],
    folder: FolderOption = FOLDER,
) -> None:
    """Verify a run's leaderboard up to running its agents again, and put it among the published entries."""
    from hhrl_bench.evaluation.store import Store
    from hhrl_bench.leaderboard.entry import publish_entry, read_entry
    from hhrl_bench.publishing.publication import require_submittable

    announce_compiling()
    board = read_entry(file)  # once: what is verified is what is published, whatever becomes of the file
    require_submittable(board, Store(file.parent), name, folder)
    found = _verify_entry(file, board, Level.RERUN, map)
    _print_verified([found])
    if found.findings:
        typer.echo("hhrl-bench: nothing was submitted", err=True)
        raise typer.Exit(1)
    target = folder / f"{name}.json"
    publish_entry(board, target, Store(file.parent))
    typer.echo(f"wrote {target}; hhrl-bench leaderboard build --folder {folder} adds it to the index", err=True)


@leaderboard_app.command()
def schema() -> None:
    """Print the JSON schema of leaderboard files."""
    from hhrl_bench.leaderboard.entry import entry_schema

    typer.echo(entry_schema(), nl=False)


class _Verified(NamedTuple):
    """What was found in a file of published entries, and how far it is verified; None where it is not, or no entry."""

    path: Path
    findings: "list[Finding]"
    level: Level | None


def _verify_entry(
    path: Path,
    board: "LeaderboardRecord",
    level: Level,
    each: "Each",
    sample: int | None = None,
    fresh: int | None = None,
    seed: int = 0,
    *,
    published: bool = False,
) -> _Verified:
    """Verify what was read from a path; of one in a folder of ``published`` entries also that its suite makes it."""
    from hhrl_bench.evaluation.store import Store
    from hhrl_bench.leaderboard.entry import check_spelling
    from hhrl_bench.publishing.publication import check_suite
    from hhrl_bench.verification import verify as verification
    from hhrl_bench.verification.rerun import check_fresh

    store = Store(path.parent)
    with progress(f"verify {path.name}") as update:
        found = list(verification.verify(board, store, level, update, sample, seed, each))
        if fresh is not None and not found:
            found += check_fresh(board, store, fresh, seed, update, each)
    found += check_spelling(path, board)
    found += check_suite(path.stem, board) if published else ()
    if found:
        return _Verified(path, list(dict.fromkeys(found)), None)
    _say_left_out(path, board, level, scored=fresh is not None)
    return _Verified(path, [], verification.reached(board, level))


def _verify_changed(folder: Path, level: Level, jobs: int, *, again: bool) -> "dict[str, VerifiedEntry]":
    """Return how the entries of a folder were verified, by file name; leave with exit code 1 where one does not hold.

    Unless ``again``, those are passed over that this machine has verified before and that have not changed since.
    """
    from hhrl_bench.evaluation.store import Store
    from hhrl_bench.execution.pools import mapping
    from hhrl_bench.leaderboard.entry import read_entry
    from hhrl_bench.leaderboard.entry_files import entry_paths
    from hhrl_bench.publishing.copies import Stored, copied
    from hhrl_bench.publishing.memory import hash_of_all, recall, remember
    from hhrl_bench.publishing.publication import VerifiedEntry, verified_now

    boards = {path: read_entry(path) for path in entry_paths(folder)}
    hashes = {path: hash_of_all(path, board, level) for path, board in boards.items()}
    records = {path: record for path in boards if not again and (record := recall(hashes[path]))}
    for path, record in records.items():
        typer.echo(f"{path}: {record.level}, verified here on {record.day}, nothing has changed since", err=True)
    with mapping(jobs) as each:
        found = [
            _Verified(path, [], records[path].level)
            if path in records
            else _verify_entry(path, board, level, each, published=True)
            for path, board in boards.items()
        ]
    if copies := list(copied({path.name: Stored(board, Store(folder)) for path, board in boards.items()})):
        found.append(_Verified(folder, copies, None))
    _print_verified(found)
    for one in found:
        if one.level and one.path not in records:
            records[one.path] = verified_now(one.level, level)
            remember(hashes[one.path], one.path, boards[one.path], level, records[one.path])
    if any(one.findings for one in found):
        raise typer.Exit(1)
    return {path.name: VerifiedEntry(boards[path], record) for path, record in records.items()}


def _say_left_out(path: Path, board: "LeaderboardRecord", level: Level, *, scored: bool) -> None:
    """Say what of an entry could not be run or trained again."""
    from hhrl_bench.verification.identity import playable, repeatable

    own = [result for result in board.results if not playable(result, checkpoints=board.checkpoints_published)]
    if own and (level.includes(Level.RERUN) or scored):
        why = "they are a user's own code" if board.checkpoints_published else "their checkpoints are not published"
        typer.echo(f"hhrl-bench: {path}: {len(own)} of {len(board.results)} results were not run: {why}", err=True)
    trainings = [run.training for result in board.results for run in result.runs if run.training]
    left_out = sum(not repeatable(training) for training in trainings)
    if left_out and level.includes(Level.RETRAINED):
        why = "they round differently on other machines, or say no budget"
        typer.echo(f"hhrl-bench: {path}: {left_out} of {len(trainings)} seeds were not trained: {why}", err=True)


def _print_verified(found: Sequence[_Verified]) -> None:
    for one in found:
        for finding in one.findings:
            typer.echo(f"{one.path}: {finding}")
        if not one.findings:
            typer.echo(f"{one.path}: {one.level or 'names every entry and file'}")
