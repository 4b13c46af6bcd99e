"""The commands under ``hhrl-bench leaderboard``."""

from pathlib import Path
from types import ModuleType
from typing import Annotated

import typer

from hhrl_bench.cli_options import JsonOption
from hhrl_bench.command_module import command_module
from hhrl_bench.level import Level

leaderboard_app = typer.Typer(help="Read, verify and publish leaderboards.")

FolderOption = Annotated[Path, typer.Option("--folder", help="The folder of published entries.")]
LevelOption = Annotated[Level, typer.Option("--level", help="How far: each level includes those before it.")]
FOLDER = Path("leaderboards")


def _commands() -> ModuleType:
    return command_module("leaderboard_commands")


@leaderboard_app.command("show")
def _show(
    file: Annotated[Path, typer.Argument(help="Leaderboard file.")] = FOLDER / "quick.json",
    details: Annotated[
        bool, typer.Option("--details", help="Print worst cases, comparisons with the best agent and efficiency too.")
    ] = False,
    json: JsonOption = False,
) -> None:
    """Print a leaderboard as tables."""
    _commands().show_leaderboard(file, details=details, as_json=json)


@leaderboard_app.command("verify")
def _verify(
    paths: Annotated[
        list[Path] | None, typer.Argument(help="Entries, or folders of them.", show_default="leaderboards")
    ] = None,
    level: LevelOption = Level.REPLAYED,
    sample: Annotated[
        int | None, typer.Option(min=1, help="Run the agents of so many results again.", show_default="all")
    ] = None,
    fresh: Annotated[
        int | None, typer.Option(min=1, help="Also score every run in so many worlds drawn anew.", show_default="none")
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, help="Draws the sample and the worlds.", show_default="a new one")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Verify entries, offline: their files, numbers and agents; exit code 1 where something does not hold."""
    if sample is not None and level != Level.RERUN:
        raise typer.BadParameter(f"--level {level} runs no agent again; write --level rerun", param_hint="--sample")
    held = _commands().verify_entries(paths or [FOLDER], level, sample, fresh, seed, as_json=json)
    raise typer.Exit(0 if held else 1)


@leaderboard_app.command("build")
def _build(folder: FolderOption = FOLDER, level: LevelOption = Level.REPLAYED) -> None:
    """Verify every entry in a folder, then write its INDEX.json, its schema.json and a page of tables a suite."""
    raise typer.Exit(0 if _commands().build(folder, level) else 1)


@leaderboard_app.command("submit")
def _submit(
    file: Annotated[Path, typer.Argument(help="A leaderboard that hhrl-bench run has written.", show_default=False)],
    name: Annotated[str, typer.Option(help="What to call the entry.", show_default=False)],
    folder: FolderOption = FOLDER,
) -> None:
    """Verify a run's leaderboard up to running its agents again, and put it among the published entries."""
    raise typer.Exit(0 if _commands().submit(file, name, folder) else 1)


@leaderboard_app.command("schema")
def _schema() -> None:
    """Print the JSON schema of leaderboard files."""
    _commands().show_schema()
