"""The command line: exit code 0 done, 1 a check did not hold, 2 bad usage or input, said in one line."""

import sys
from enum import StrEnum
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from hhrl_bench.cli_options import (
    AddressOption,
    AgentArgument,
    AgentsArgument,
    Executor,
    ExecutorOption,
    HeldOption,
    JsonOption,
    OpponentOption,
    TaskOption,
    UnitTimeoutOption,
    WorkersOption,
)
from hhrl_bench.leaderboard_cli import leaderboard_app

INTERRUPTED = 130


class Listed(StrEnum):
    """What ``list`` can be asked for."""

    AGENTS = "agents"
    TASKS = "tasks"
    SUITES = "suites"


class OneLineErrors(TyperGroup):
    """A group of commands whose failures are one line on stderr and exit code 2, without a traceback."""

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Return nothing; run the command line and leave with its exit code."""
        try:
            code = super().main(*args, **{**kwargs, "standalone_mode": False})
        except Exception as error:
            message = _message(error)
            if message is None:
                raise
            typer.echo("hhrl-bench: " + " ".join(message.split()), err=True)
            code = 2
        if code == INTERRUPTED:
            typer.echo("hhrl-bench: interrupted; what was not finished was not written", err=True)
        sys.exit(code if isinstance(code, int) else 0)


def _message(error: Exception) -> str | None:
    """Return what to say of bad usage or input; None for a fault of ours, which keeps its traceback."""
    if hasattr(error, "format_message"):
        return str(error.format_message())
    if isinstance(error, OSError) and error.strerror:
        return f"{error.strerror}: {error.filename}" if error.filename else error.strerror
    if isinstance(error, ValueError):
        from hhrl_envs.errors import InputError  # noqa: PLC0415

        return str(error) if isinstance(error, InputError) else None
    return None


app = typer.Typer(
    cls=OneLineErrors,
    help="Benchmark hierarchical, flat and rule agents on the stop-line tasks.",
    context_settings={"help_option_names": ["-h", "--help"]},
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.add_typer(leaderboard_app, name="leaderboard")


def main() -> None:
    """Return nothing; the entry point of ``hhrl-bench``."""
    app()


def _commands() -> ModuleType:
    """Return the module that does the work: it brings in numba and scipy, which ``--help`` need not wait for."""
    from hhrl_bench import commands  # noqa: PLC0415
    from hhrl_bench.compiling import announce_compiling  # noqa: PLC0415

    announce_compiling()
    return commands


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and leave.")] = False,
) -> None:
    if version:
        from hhrl_bench import __version__  # noqa: PLC0415

        typer.echo(f"hhrl-bench {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


@app.command("list")
def _list(
    what: Annotated[Listed | None, typer.Argument(help="What to list.", show_default="all")] = None,
    json: JsonOption = False,
) -> None:
    """List what is registered: agents with their number of trained seeds, tasks and suites."""
    _commands().list_registered(what, as_json=json)


@app.command("train")
def _train(
    method: Annotated[str, typer.Argument(metavar="METHOD", help="A learned method; see: list agents.")],
    task: TaskOption = "stop-line-v0",
    seeds: Annotated[str, typer.Option(help="Training seeds, trained side by side, such as 0-4,7.")] = "0",
    env_steps: Annotated[
        int | None, typer.Option(min=1, help="Steps for each seed.", show_default="the task's budget")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Run directory.", show_default="runs/METHOD/TASK")] = None,
    device: Annotated[str, typer.Option(help="Where torch computes, cpu or cuda.")] = "cpu",
    resume: Annotated[bool, typer.Option("--resume", help="Go on with a training that was stopped.")] = False,
    tensorboard: Annotated[bool, typer.Option("--tensorboard", help="Write TensorBoard event files too.")] = False,
) -> None:
    """Train a method; keep each seed's best policy on validation episodes, and its last; exit code 1 if one fails."""
    held = _commands().train(method, task, seeds, env_steps, out, device, resume=resume, tensorboard=tensorboard)
    raise typer.Exit(0 if held else 1)


@app.command("evaluate")
def _evaluate(
    agents: AgentsArgument,
    task: TaskOption = "stop-line-v0",
    episodes: Annotated[int, typer.Option(help="How many test episodes.")] = 1000,
    option: HeldOption = None,
    opponent: OpponentOption = None,
    json: JsonOption = False,
) -> None:
    """Score one agent or several on a task's test episodes, the same worlds for every agent."""
    _commands().evaluate(agents, task, episodes, option, opponent, as_json=json)


@app.command("robustness")
def _robustness(
    agents: AgentsArgument,
    episodes: Annotated[int, typer.Option(help="How many test episodes of each task.")] = 1000,
    json: JsonOption = False,
) -> None:
    """Score agents in ordinary traffic, among held-out drivers, and behind a trained adversary."""
    raise typer.Exit(0 if _commands().robustness(agents, episodes, as_json=json) else 1)


@app.command("analyse")
def _analyse(
    agent: AgentArgument,
    task: TaskOption = "stop-line-v0",
    episodes: Annotated[int, typer.Option(help="How many test episodes to count options and rewards over.")] = 500,
    episode: Annotated[int, typer.Option(min=0, help="The test episode to show step by step.")] = 0,
    out: Annotated[Path | None, typer.Option(help="Folder to write analysis.json and the figures into.")] = None,
    json: JsonOption = False,
) -> None:
    """Show an agent's option usage, per-level rewards and attention; of several training seeds, the lowest one's."""
    _commands().analyse(agent, task, episodes, episode, out, as_json=json)


@app.command("run")
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
            help="Leaderboard file.", show_default="leaderboards/SUITE.json, or with --agent runs/SUITE/entry.json"
        ),
    ] = None,
    work: Annotated[Path | None, typer.Option(help="Folder of its trainings.", show_default="runs/SUITE")] = None,
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


@app.command("transfer")
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


@app.command("calibrate")
def _calibrate(
    seed: Annotated[int, typer.Option(min=0, help="Seed of the search.")] = 0,
    generations: Annotated[int, typer.Option(min=1, help="Generations of the search.")] = 70,
    episodes: Annotated[int, typer.Option(help="How many test episodes to score the outcome on.")] = 10_000,
    out: Annotated[Path | None, typer.Option(help="Folder to write the parameters and residuals into.")] = None,
    check: Annotated[bool, typer.Option("--check", help="Do not search: score the registered scenario.")] = False,
) -> None:
    """Fit a world to the paper's Table I and print what is left; exit code 1 if an outcome leaves its interval."""
    held = _commands().calibrate(seed, generations, episodes, out, check=check)
    raise typer.Exit(0 if held else 1)


@app.command("sigma")
def _sigma(json: JsonOption = False) -> None:
    """Recover the constants of the paper's reward from its Table I, and show what guesses would leave."""
    _commands().sigma(as_json=json)


@app.command("figures")
def _figures(
    file: Annotated[Path, typer.Argument(help="Leaderboard file.")] = Path("leaderboards/transfer.json"),
    out: Annotated[Path | None, typer.Option(help="Folder.", show_default="FILE without .json")] = None,
) -> None:
    """Draw the figures of a leaderboard file, as SVG and PNG."""
    _commands().figures(file, out)


@app.command("report")
def _report(
    file: Annotated[Path, typer.Argument(help="Leaderboard file.")] = Path("leaderboards/quick.json"),
    out: Annotated[Path | None, typer.Option(help="The page to write.", show_default="FILE.html")] = None,
) -> None:
    """Write a leaderboard file as one HTML page: tables, figures, settings and provenance."""
    _commands().report(file, out)


@app.command("watch")
def _watch(
    agent: AgentArgument,
    out: Annotated[Path, typer.Option(help="The picture to write: a .gif in real time, or a .png strip.")],
    task: TaskOption = "stop-line-v0",
    episode: Annotated[int | None, typer.Option(min=0, help="Which test episode.", show_default="0")] = None,
    option: HeldOption = None,
    opponent: OpponentOption = None,
    failed: Annotated[
        int | None,
        typer.Option(
            min=1,
            metavar="N",
            help="Draw the first N failures that --entry has of the agent instead, each beside OUT.",
            show_default="none",
        ),
    ] = None,
    entry: Annotated[Path, typer.Option(help="A published leaderboard, for --failed.")] = Path(
        "leaderboards/quick.json"
    ),
) -> None:
    """Draw an agent's test episode: every step as a .gif, or key frames and charts as a .png."""
    if failed is None:
        _commands().watch(agent, task, out, episode or 0, option, opponent)
        return
    for name, given in {"--episode": episode, "--option": option, "--opponent": opponent}.items():
        if given is not None:
            raise typer.BadParameter(
                "it says nothing to --failed, whose episodes are the entry's; leave one out", param_hint=name
            )
    _commands().watch_failures(agent, task, out, failed, entry)
