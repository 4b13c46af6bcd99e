"""The commands that do a study: units shown while they run, then a leaderboard, printed and written."""

import os
import shlex
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, cast

import typer

from hhrl_bench.cli.console import announce_compiling, console
from hhrl_bench.cli.options import AgentsArgument, JsonOption, TrustOption

if TYPE_CHECKING:
    from hhrl_bench.execution.progress_folder import ProgressFolder
    from hhrl_bench.execution.run import Execution
    from hhrl_bench.execution.unit import Done
    from hhrl_bench.leaderboard.record import LeaderboardRecord
    from hhrl_bench.suites.study import Study

SHOWN_DIFFERENCES = 10
"""How many differences from a published leaderboard are shown."""

suites_app = typer.Typer()


class Executor(StrEnum):
    """Who can do the units of a suite."""

    LOCAL = "local"
    RAY = "ray"


ExecutorOption = Annotated[
    Executor, typer.Option(help="Who does the units: processes of this machine, or a Ray cluster (the ray extra).")
]
WorkersOption = Annotated[
    int | None, typer.Option(min=1, help="Processes of this machine, side by side.", show_default="the number of cores")
]
AddressOption = Annotated[
    str | None, typer.Option(metavar="HOST:PORT", help="The Ray cluster's.", show_default="this machine's cluster")
]
UnitTimeoutOption = Annotated[
    float | None,
    typer.Option(
        min=0.01, metavar="MINUTES", help="End a worker that reports nothing for so long.", show_default="never"
    ),
]


@suites_app.command()
def run(
    suite: Annotated[str, typer.Option(metavar="SUITE", help="The suite's id, or a suite file.")] = "quick",
    agent: Annotated[
        list[str] | None,
        typer.Option(
            "--agent",
            metavar="AGENT",
            help="Score this agent on the suite's tasks in place of the suite's own; may be repeated.",
            show_default="the suite's",
        ),
    ] = None,
    status: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Run nothing: say how far the suite with this --work folder is.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Leaderboard file.", show_default="entry.json in --work")] = None,
    work: Annotated[
        Path | None,
        typer.Option(help="Folder of its trainings.", show_default="runs/SUITE; with --agent runs/SUITE-agents"),
    ] = None,
    executor: ExecutorOption = Executor.LOCAL,
    workers: WorkersOption = None,
    address: AddressOption = None,
    unit_timeout: UnitTimeoutOption = None,
    _trust: TrustOption = False,
) -> None:
    """Run a suite, print and write its leaderboard, and compare it with the published one; exit code 1 if a unit fails.

    A run that was stopped goes on if the command is repeated.
    """
    from hhrl_bench.cli.live_view import print_status
    from hhrl_bench.evaluation.loading import require_playable
    from hhrl_bench.execution.progress_folder import ProgressFolder
    from hhrl_bench.suites.files import find_suite
    from hhrl_bench.suites.study import suite_study
    from hhrl_bench.suites.suites import ScoreSuite
    from hhrl_bench.tasks.tasks import get_task

    if status is not None:
        print_status(console(), ProgressFolder.within(status))
        return
    announce_compiling()
    execution = _execution(executor, workers, address, unit_timeout)
    chosen = find_suite(suite)
    folder = work or Path("runs") / (f"{chosen.id}-agents" if agent else chosen.id)
    if agent:
        require_playable(agent, get_task(chosen.tasks[0]))
        study = suite_study(ScoreSuite(chosen.id, tuple(agent), chosen.tasks, chosen.episodes), folder)
    else:
        study = suite_study(chosen, folder)
    words = ["hhrl-bench", "run", "--suite", suite, *(word for one in agent or () for word in ("--agent", one))]
    study = replace(study, command=shlex.join(words))
    path, published = out or folder / "entry.json", Path("leaderboards") / f"{chosen.id}.json"
    board = _publish(study, path, folder, execution)
    if not agent and path.resolve() != published.resolve():
        _compare(board, published)


@suites_app.command()
def transfer(
    source: Annotated[
        str, typer.Option(help="A run directory, a checkpoint, or a method with shipped seeds.", show_default=False)
    ],
    target: Annotated[list[str], typer.Option(metavar="TASK", help="A target task; may be repeated.")],
    seeds: Annotated[
        str | None, typer.Option(help="Training seeds, such as 0-4,7.", show_default="all of the source")
    ] = None,
    env_steps: Annotated[int, typer.Option(min=1, help="Steps for each seed in each arm.")] = 50_000,
    episodes: Annotated[int, typer.Option(help="How many test episodes.")] = 1000,
    out: Annotated[Path, typer.Option(help="Folder of the trainings; its transfer.json is the last command's.")] = Path(
        "runs/transfer"
    ),
    executor: ExecutorOption = Executor.LOCAL,
    workers: WorkersOption = None,
    address: AddressOption = None,
    unit_timeout: UnitTimeoutOption = None,
) -> None:
    """Reuse a trained run in other tasks, arm by arm, beside training from scratch; what was stopped goes on."""
    from hhrl_bench.suites.study import transfer_study
    from hhrl_bench.tasks.seeds import parse_seeds

    announce_compiling()
    execution = _execution(executor, workers, address, unit_timeout)
    study = transfer_study(source, target, () if seeds is None else parse_seeds(seeds), env_steps, episodes, out)
    _publish(study, out / "transfer.json", out, execution)


@suites_app.command()
def robustness(
    agents: AgentsArgument,
    episodes: Annotated[int, typer.Option(help="How many test episodes of each task.")] = 1000,
    as_json: JsonOption = False,
    _trust: TrustOption = False,
) -> None:
    """Score agents in ordinary traffic, among held-out drivers, and behind a trained adversary."""
    from hhrl_bench.evaluation.loading import require_playable
    from hhrl_bench.execution.run import IN_THIS_PROCESS
    from hhrl_bench.suites.study import suite_study
    from hhrl_bench.suites.suites import ScoreSuite, get_suite
    from hhrl_bench.tables.success import success_table
    from hhrl_bench.tables.terminal import print_table
    from hhrl_bench.tasks.tasks import get_task

    announce_compiling()
    suite = replace(cast(ScoreSuite, get_suite("robustness")), agents=tuple(agents), episodes=episodes)
    require_playable(agents, get_task(suite.tasks[0]))
    command = shlex.join(["hhrl-bench", "robustness", *agents, "--episodes", str(episodes)])
    with TemporaryDirectory() as folder:
        board = _do(replace(suite_study(suite, Path(folder)), command=command), IN_THIS_PROCESS)
    if board is None:
        raise typer.Exit(1)
    if as_json:
        typer.echo(board.model_dump_json(indent=2))
    else:
        print_table(console(), success_table(board.tasks, [board]))


def _execution(executor: Executor, workers: int | None, address: str | None, unit_timeout: float | None) -> "Execution":
    """Return who does the units, from options that must not contradict each other."""
    from hhrl_bench.errors import ClusterError
    from hhrl_bench.execution.run import Execution

    if executor is Executor.LOCAL and address is not None:
        raise ClusterError("an --address is that of a Ray cluster; add --executor ray")
    if executor is Executor.RAY and workers is not None:
        raise ClusterError("a Ray cluster has the workers that its nodes have cores; leave --workers out")
    patience = None if unit_timeout is None else 60.0 * unit_timeout
    return Execution("ray" if executor is Executor.RAY else "local", workers or os.cpu_count() or 1, address, patience)


def _publish(study: "Study", path: Path, folder: Path, execution: "Execution") -> "LeaderboardRecord":
    """Do a study, write, print and return its leaderboard; leave with exit code 1 if a unit has failed."""
    from hhrl_agents.atomic_files import require_writable
    from hhrl_bench.execution.progress_folder import ProgressFolder
    from hhrl_bench.leaderboard.entry import publish_entry
    from hhrl_bench.tables.terminal import print_leaderboard

    require_writable(path)
    progress = ProgressFolder.within(folder)
    with progress.opened(study.status(execution)):
        board = _do(study, execution, progress)
    if board is None:
        typer.echo("hhrl-bench: no leaderboard was written; the same command goes on with what is left", err=True)
        raise typer.Exit(1)
    written = publish_entry(board, path, study.store)
    print_leaderboard(console(), board)
    typer.echo(f"wrote {path}" if written else f"{path} holds the same results already", err=True)
    return board


def _compare(board: "LeaderboardRecord", published: Path) -> None:
    """Say whether a leaderboard equals the published one but for its provenance, else where they differ."""
    from hhrl_bench.leaderboard.entry import compare_entries, read_entry

    if not published.exists():
        return
    found = list(compare_entries(read_entry(published), board))
    if not found:
        typer.echo(f"equal to the published {published}, digit for digit")
        return
    typer.echo(f"differs from the published {published} in {len(found)} place{'s'[: len(found) - 1]}:")
    for finding in found[:SHOWN_DIFFERENCES]:
        typer.echo(f"  {finding}")
    if len(found) > SHOWN_DIFFERENCES:
        typer.echo(f"  and {len(found) - SHOWN_DIFFERENCES} more")


def _do(study: "Study", execution: "Execution", progress: "ProgressFolder | None" = None) -> "LeaderboardRecord | None":
    """Do the units of a study and say which have failed; return its leaderboard, or None if one has."""
    from hhrl_bench.cli.live_view import study_view

    done: list[Done] = []
    with study_view(study.name, len(study.units)) as view:
        for one in study.run(execution, progress, view.show):
            done.append(one)
            view.ended(one)
    failed = [one for one in done if one.outcome is None]
    for one in failed:
        typer.echo(f"hhrl-bench: {one.unit.name} failed: {one.failure}", err=True)
    return None if failed else study.leaderboard(done, execution.executor)
