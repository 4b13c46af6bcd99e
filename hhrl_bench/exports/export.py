"""Exports: runs, fresh or of a published entry, written in a format."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from hhrl_agents.atomic_files import OutputError, require_writable, write_atomically
from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.decisions import episodes_of
from hhrl_bench.evaluation.evidence import read_evidence
from hhrl_bench.evaluation.store import Store
from hhrl_bench.exports.episodes import Run, episode_columns
from hhrl_bench.exports.files import to_csv, to_parquet
from hhrl_bench.exports.minari_dataset import require_minari, write_dataset
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.verification.checked_result import played_task
from hhrl_envs.errors import require, require_value

FORMATS = ("csv", "parquet", "minari")


def format_of(to: Path, given: str | None = None) -> str:
    """Return the format to write in: what is given, else what the suffix of ``to`` says, none being Minari's folder.

    Raises:
        InputError: in one line, for another one, or if an extra is missing.
    """
    kind = given or to.suffix.removeprefix(".").lower() or "minari"
    wanted = "csv, parquet or minari" if given else "a name that ends in .csv or .parquet, or a folder for Minari"
    require_value(kind in FORMATS, "the format" if given else "the file to export to", repr(given or to.name), wanted)
    if kind == "parquet":
        require("pyarrow", "data")
    if kind == "minari":
        require_minari()
    return kind


def export_runs(runs: Sequence[Run], to: Path, kind: str) -> list[str]:
    """Write the episodes of runs into a file, or into a folder of Minari datasets; return what was written.

    Returns:
        The file's path, or the id of the dataset of each agent.

    Raises:
        InputError: in one line, if that cannot be written, or decisions do not come to the episodes.
    """
    if kind == "minari":
        by_agent = groupby(runs, key=lambda run: run.agent)
        return [write_dataset(list(own), to) for _, own in by_agent]
    require_writable(to)
    columns = episode_columns(runs)
    write_atomically(to, to_csv(columns) if kind == "csv" else to_parquet(columns))
    return [str(to)]


def entry_runs(board: LeaderboardRecord, store: Store, agent: str, task: str, episodes: int | None = None) -> list[Run]:
    """Return the first episodes, by default all, of every training seed of an agent on a task of a published entry.

    Raises:
        RecordError: if the entry has no such result, or fewer episodes, or its evidence is missing or damaged.
    """
    result, record = board.find(agent, task), next(one for one in board.tasks if one.id == task)
    if episodes is not None and not 1 <= episodes <= record.episodes:
        raise RecordError(f"the entry has {record.episodes} episodes of {task}, not {episodes}; ask for fewer")
    played, runs = played_task(record), []
    for run in result.runs:
        evidence = read_evidence(run, store)
        part = slice(0, episodes or record.episodes)
        seed = run.training.seed if run.training else None
        runs.append(Run(agent, seed, played, episodes_of(evidence.trace, part), evidence.outcome[part]))
    return runs


def require_free(to: Path, kind: str) -> None:
    """Raise an ``OutputError`` before anything is played if the place cannot be written."""
    if kind != "minari":
        require_writable(to)
    elif to.exists() and not to.is_dir():
        raise OutputError(f"cannot write {to}: it is not a folder; name a folder for Minari's datasets")
