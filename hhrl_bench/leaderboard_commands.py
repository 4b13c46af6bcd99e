"""What the commands under ``hhrl-bench leaderboard`` do: findings on stdout, progress on stderr."""

import json
import secrets
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import typer

from hhrl_agents.files import write_atomically
from hhrl_bench import leaderboard
from hhrl_bench.differences import Finding
from hhrl_bench.errors import RecordError
from hhrl_bench.fresh import check_fresh
from hhrl_bench.leaderboard_table import print_leaderboard
from hhrl_bench.level import Level
from hhrl_bench.markdown_tables import markdown
from hhrl_bench.progress import progress
from hhrl_bench.publication import INDEX, check_index, entry_paths, of_suite, require_submittable, write_index
from hhrl_bench.store import Store
from hhrl_bench.terminal import console
from hhrl_bench.verification import checked_results, verify


class Verified(NamedTuple):
    """What was found in a file of published entries, and how far it is verified; None where it is not, or no entry."""

    path: Path
    findings: list[Finding]
    level: Level | None


def verify_entries(
    paths: Sequence[Path], level: Level, sample: int | None, fresh: int | None, seed: int | None, *, as_json: bool
) -> bool:
    """Return whether all holds; verify entries, or those of folders and their index; print what does not hold."""
    seed = secrets.randbelow(10**9) if seed is None else seed
    found: list[Verified] = []
    for path in paths:
        if path.is_dir():
            found.append(Verified(path / INDEX, list(check_index(path)), None))
        files = entry_paths(path) if path.is_dir() else [path]
        found += [_verify(file, level, sample, fresh, seed) for file in files]
    if as_json:
        rows = [{"entry": str(one.path), **finding._asdict()} for one in found for finding in one.findings]
        verified = {str(one.path): one.level for one in found if one.level}
        typer.echo(json.dumps({"level": level, "verified": verified, "findings": rows}, indent=2))
    else:
        _print(found)
        if sample or fresh:
            typer.echo(f"drawn by --seed {seed}", err=True)
    return not any(one.findings for one in found)


def build(folder: Path, level: Level) -> bool:
    """Return whether every entry in a folder is verified up to ``level``; if so write its index, schema and tables."""
    found = [_verify(path, level) for path in entry_paths(folder)]
    _print(found)
    if any(one.findings for one in found):
        return False
    index = write_index(folder, {one.path.name: one.level for one in found if one.level})
    for suite in dict.fromkeys(entry.suite for entry in index.entries):
        write_atomically(folder / f"{suite}.md", markdown(of_suite(folder, suite)))
    typer.echo(f"wrote {folder / INDEX}, {len(index.entries)} entries, and a page of tables a suite", err=True)
    return True


def submit(path: Path, name: str, folder: Path) -> bool:
    """Return whether an entry was verified, agents run again where they can be, and put into a folder under a name."""
    board = leaderboard.read(path)
    require_submittable(board, name, folder)
    found = _verify(path, Level.RERUN)
    _print([found])
    if found.findings:
        typer.echo("hhrl-bench: nothing was submitted", err=True)
        return False
    target = folder / f"{name}.json"
    leaderboard.publish(board, target, Store(path.parent))
    typer.echo(f"wrote {target}; hhrl-bench leaderboard build --folder {folder} adds it to the index", err=True)
    return True


def show_leaderboard(path: Path, *, details: bool, as_json: bool) -> None:
    """Return nothing; print a leaderboard file as tables, in ``details`` or not, or as the JSON it is."""
    board = leaderboard.read(path)
    if as_json:
        typer.echo(board.model_dump_json(indent=2))
    else:
        print_leaderboard(console(), board, details=details)


def show_schema() -> None:
    """Return nothing; print the JSON schema of leaderboards."""
    typer.echo(leaderboard.schema(), nl=False)


def _verify(path: Path, level: Level, sample: int | None = None, fresh: int | None = None, seed: int = 0) -> Verified:
    if path.name == INDEX:
        raise RecordError(f"{path} is the index of a folder of entries; verify the folder: {path.parent}")
    board, store = leaderboard.read(path), Store(path.parent)
    with progress(f"verify {path.name}") as update:
        found = list(verify(board, store, level, update, sample, seed))
        if fresh is not None and not found:
            found += check_fresh(board, store, fresh, seed, update)
    found += leaderboard.respelt(path, board)
    if found:
        return Verified(path, list(dict.fromkeys(found)), None)
    own = [one for one in checked_results(board, store) if not one.playable]
    if own and (level == Level.RERUN or fresh is not None):
        why = "they are a user's own code" if board.checkpoints_published else "their checkpoints are not published"
        typer.echo(f"hhrl-bench: {path}: {len(own)} of {len(board.results)} results were not run: {why}", err=True)
    return Verified(path, [], level.at_most(Level.REPLAYED) if own else level)


def _print(found: Sequence[Verified]) -> None:
    for one in found:
        for finding in one.findings:
            typer.echo(f"{one.path}: {finding}")
        if not one.findings:
            typer.echo(f"{one.path}: {one.level or 'names every entry and file'}")
