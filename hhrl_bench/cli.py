"""The command line: exit code 0 done, 1 a check did not hold, 2 bad usage or input, said in one line."""

import os
import sys
from enum import StrEnum
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from hhrl_bench.cli_options import AgentsArgument, HeldOption, JsonOption, OpponentOption, TaskOption
from hhrl_bench.command_module import command_module
from hhrl_bench.leaderboard_cli import leaderboard_app
from hhrl_bench.picture_cli import picture_app
from hhrl_bench.study_cli import study_app

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
            sys.stdout.flush()  # here, where a full disk or a reader that has left can still be answered
        except Exception as error:
            message = _message(error)
            if message is None:
                raise
            if isinstance(error, OSError):
                _close_stdout()
            typer.echo("hhrl-bench: " + " ".join(message.split()), err=True)
            code = 2
        if code == INTERRUPTED:
            typer.echo("hhrl-bench: interrupted; what was not finished was not written", err=True)
        sys.exit(code if isinstance(code, int) else 0)


def _close_stdout() -> None:
    """Return nothing; what stdout still holds and nobody takes is dropped, not tried again when Python ends."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _message(error: Exception) -> str | None:
    """Return what to say of bad usage or input; None for a fault of ours, which keeps its traceback."""
    if hasattr(error, "format_message"):
        return str(error.format_message()).replace("Value error, ", "")
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
app.add_typer(study_app)
app.add_typer(picture_app)
app.add_typer(leaderboard_app, name="leaderboard")


def main() -> None:
    """Return nothing; the entry point of ``hhrl-bench``."""
    app()


def _commands() -> ModuleType:
    return command_module("commands")


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
