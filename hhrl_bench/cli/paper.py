"""The commands about the paper: a world fitted to its Table I, and the constants of its reward."""

from pathlib import Path
from typing import Annotated

import typer

from hhrl_bench.cli.console import announce_compiling, console, progress
from hhrl_bench.cli.options import JsonOption

paper_app = typer.Typer()


@paper_app.command()
def calibrate(
    seed: Annotated[int, typer.Option(min=0, help="Seed of the search.")] = 0,
    generations: Annotated[int, typer.Option(min=1, help="Generations of the search.")] = 70,
    episodes: Annotated[int, typer.Option(help="How many test episodes to score the outcome on.")] = 10_000,
    out: Annotated[Path | None, typer.Option(help="Folder to write the parameters and residuals into.")] = None,
    check_only: Annotated[bool, typer.Option("--check", help="Do not search: score the registered scenario.")] = False,
) -> None:
    """Fit a world to the paper's Table I and print what is left; exit code 1 if an outcome leaves its interval."""
    from hhrl_bench.calibration.calibrate import check, markdown, search

    announce_compiling()
    with progress("calibration" if check_only else f"calibration, seed {seed}") as update:
        record = check(episodes, out) if check_only else search(seed, generations, episodes, out, update)
    typer.echo(markdown(record))
    if out is not None:
        typer.echo(f"wrote {out}", err=True)
    if not record.holds:
        raise typer.Exit(1)


@paper_app.command()
def sigma(as_json: JsonOption = False) -> None:
    """Recover the constants of the paper's reward from its Table I, and show what guesses would leave."""
    from hhrl_bench.calibration.reward_constants import measure, print_sigma

    record = measure()
    if as_json:
        typer.echo(record.model_dump_json(indent=2))
    else:
        print_sigma(console(), record)
