"""What the commands that do a study do: units shown while they run, then a leaderboard, printed and written."""

import os
import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal, cast

import typer

from hhrl_agents.files import require_writable
from hhrl_bench import leaderboard
from hhrl_bench.attempts import Done
from hhrl_bench.board import Board
from hhrl_bench.errors import ClusterError
from hhrl_bench.executors import HERE, Execution
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.leaderboard_table import print_leaderboard
from hhrl_bench.loading import require_playable
from hhrl_bench.overview_table import print_overview
from hhrl_bench.seeds import parse_seeds
from hhrl_bench.status import print_status, study_board, study_status
from hhrl_bench.study import Study, suite_study, transfer_study
from hhrl_bench.study_view import study_view
from hhrl_bench.suite import ScoreSuite, get_suite
from hhrl_bench.tasks import get_task
from hhrl_bench.terminal import console
from hhrl_envs.extras import require


def run(suite_id: str, agents: Sequence[str], out: Path | None, work: Path | None, execution: Execution) -> bool:
    """Return whether every unit of the suite was done; write and print its leaderboard, or that of other agents."""
    suite = get_suite(suite_id)
    folder = work or Path("runs") / (f"{suite_id}-agents" if agents else suite_id)
    if not agents:
        return _publish(suite_study(suite, folder), out or Path("leaderboards") / f"{suite_id}.json", folder, execution)
    study = suite_study(ScoreSuite(suite.id, tuple(agents), suite.tasks, suite.episodes), folder)
    require_playable(agents, get_task(suite.tasks[0]))
    words = ["hhrl-bench", "run", "--suite", suite_id, *(word for agent in agents for word in ("--agent", agent))]
    return _publish(replace(study, command=shlex.join(words)), out or folder / "entry.json", folder, execution)


def status(folder: Path) -> None:
    """Return nothing; print how far the suite is whose trainings lie in ``folder``."""
    print_status(console(), study_board(folder))


def transfer(
    source: str,
    targets: Sequence[str],
    seeds: str | None,
    env_steps: int,
    episodes: int,
    out: Path,
    execution: Execution,
) -> bool:
    """Return whether every arm was done; reuse a source in the targets, write and print what it is worth there."""
    require("torch", "torch")
    study = transfer_study(source, targets, () if seeds is None else parse_seeds(seeds), env_steps, episodes, out)
    return _publish(study, out / "transfer.json", out, execution)


def robustness(agents: Sequence[str], episodes: int, *, as_json: bool) -> bool:
    """Return whether every agent was scored on the robustness suite's tasks; print a leaderboard, or a row an agent."""
    suite = replace(cast(ScoreSuite, get_suite("robustness")), agents=tuple(agents), episodes=episodes)
    require_playable(agents, get_task(suite.tasks[0]))
    command = shlex.join(["hhrl-bench", "robustness", *agents, "--episodes", str(episodes)])
    with TemporaryDirectory() as folder:
        board = _do(replace(suite_study(suite, Path(folder)), command=command), HERE)
    if board and as_json:
        typer.echo(board.model_dump_json(indent=2))
    elif board:
        print_overview(console(), board)
    return board is not None


def execution(
    executor: Literal["local", "ray"], workers: int | None, address: str | None, unit_timeout: float | None
) -> Execution:
    """Return who does the units; ``unit_timeout`` in minutes."""
    if executor != "ray" and address is not None:
        raise ClusterError("an --address is that of a Ray cluster; add --executor ray")
    if executor == "ray" and workers is not None:
        raise ClusterError("a Ray cluster has the workers that its nodes have cores; leave --workers out")
    patience = None if unit_timeout is None else 60.0 * unit_timeout
    return Execution(executor, workers or os.cpu_count() or 1, address, patience)


def _publish(study: Study, path: Path, folder: Path, execution: Execution) -> bool:
    """Return whether every unit of the study was done; write and print its leaderboard if so."""
    require_writable(path)
    progress_board = study_board(folder)
    with progress_board.opened(study_status(study, execution)):
        board = _do(study, execution, progress_board)
    if board is None:
        typer.echo("hhrl-bench: no leaderboard was written; the same command goes on with what is left", err=True)
        return False
    written = leaderboard.publish(board, path, study.store)
    print_leaderboard(console(), board)
    typer.echo(f"wrote {path}" if written else f"{path} holds the same results already", err=True)
    return True


def _do(study: Study, execution: Execution, board: Board | None = None) -> LeaderboardRecord | None:
    """Return the leaderboard of a study; None if a unit has failed, which is said."""
    done: list[Done] = []
    with study_view(study.name, study.units) as view:
        for one in study.run(execution, board, view.show):
            done.append(one)
            view.ended(one)
    failed = [one for one in done if one.outcome is None]
    for one in failed:
        typer.echo(f"hhrl-bench: {one.unit.name} failed: {one.failure}", err=True)
    return None if failed else study.leaderboard(done, execution.executor)
