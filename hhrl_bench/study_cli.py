"""The commands that do a study: a suite, a transfer, the robustness of an agent."""

from pathlib import Path
from types import ModuleType
from typing import Annotated

import typer

from hhrl_bench.cli_options import (
    AddressOption,
    AgentsArgument,
    Executor,
    ExecutorOption,
    JsonOption,
    UnitTimeoutOption,
    WorkersOption,
)
from hhrl_bench.command_module import command_module

study_app = typer.Typer()


def _commands() -> ModuleType:
    return command_module("study_commands")


@study_app.command("run")
def _run(
    suite: Annotated[str, typer.Option(help="The suite's id.")] = "quick",
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
    out: Annotated[
        Path | None,
        typer.Option(
            help="Leaderboard file.", show_default="leaderboards/SUITE.json; with --agent entry.json in --work"
        ),
    ] = None,
    work: Annotated[
        Path | None,
        typer.Option(help="Folder of its trainings.", show_default="runs/SUITE; with --agent runs/SUITE-agents"),
    ] = None,
    executor: ExecutorOption = Executor.LOCAL,
    workers: WorkersOption = None,
    address: AddressOption = None,
    unit_timeout: UnitTimeoutOption = None,
) -> None:
    """Run a suite, print its table and write its leaderboard; what was stopped goes on; exit code 1 if a unit fails."""
    commands = _commands()
    if status is not None:
        commands.status(status)
        return
    execution = commands.execution(executor.value, workers, address, unit_timeout)
    raise typer.Exit(0 if commands.run(suite, agent or (), out, work, execution) else 1)


@study_app.command("transfer")
def _transfer(
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
    commands = _commands()
    execution = commands.execution(executor.value, workers, address, unit_timeout)
    raise typer.Exit(0 if commands.transfer(source, target, seeds, env_steps, episodes, out, execution) else 1)


@study_app.command("robustness")
def _robustness(
    agents: AgentsArgument,
    episodes: Annotated[int, typer.Option(help="How many test episodes of each task.")] = 1000,
    json: JsonOption = False,
) -> None:
    """Score agents in ordinary traffic, among held-out drivers, and behind a trained adversary."""
    raise typer.Exit(0 if _commands().robustness(agents, episodes, as_json=json) else 1)
