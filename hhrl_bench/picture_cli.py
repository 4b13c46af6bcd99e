"""The commands that draw: an episode, an analysis, the figures and the page of a leaderboard."""

from pathlib import Path
from types import ModuleType
from typing import Annotated

import typer

from hhrl_bench.cli_options import AgentArgument, HeldOption, JsonOption, OpponentOption, TaskOption
from hhrl_bench.command_module import command_module

picture_app = typer.Typer()


def _commands() -> ModuleType:
    return command_module("picture_commands")


@picture_app.command("watch")
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


@picture_app.command("analyse")
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


@picture_app.command("figures")
def _figures(
    file: Annotated[Path, typer.Argument(help="Leaderboard file.")] = Path("leaderboards/transfer.json"),
    out: Annotated[Path | None, typer.Option(help="Folder.", show_default="FILE without .json")] = None,
) -> None:
    """Draw the figures of a leaderboard file, as SVG and PNG."""
    _commands().figures(file, out)


@picture_app.command("report")
def _report(
    file: Annotated[Path, typer.Argument(help="Leaderboard file.")] = Path("leaderboards/quick.json"),
    out: Annotated[Path | None, typer.Option(help="The page to write.", show_default="FILE.html")] = None,
) -> None:
    """Write a leaderboard file as one HTML page: tables, figures, settings and provenance."""
    _commands().report(file, out)
