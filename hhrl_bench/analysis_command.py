"""The command ``analyse``: an agent's analysis as tables or JSON on stdout, and as JSON and figures in a folder."""

from pathlib import Path

import typer
from rich.console import Console

from hhrl_bench.analysis import analyse, require_folder, write
from hhrl_bench.analysis_tables import print_analysis


def run(
    console: Console, agent: str, task: str, episodes: int, episode: int, out: Path | None, *, as_json: bool
) -> None:
    """Return nothing; analyse an agent, print the outcome, and write it into the folder ``out``, if any."""
    if out is not None:
        require_folder(out)
    record = analyse(agent, task, episodes, episode)
    if out is not None:
        for path in write(record, out):
            typer.echo(f"wrote {path}", err=True)
    if as_json:
        typer.echo(record.model_dump_json())
    else:
        print_analysis(console, record)
